#pragma once
#include <cstdint>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/render/picture.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/rules.hpp>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// One program on one engine with a map, as a Renderer runs it: FrameRenderer is that of anchored tiles, HomesRenderer that of homes. This
/// header contains no kernel, so code that only uses a renderer compiles quickly.
class Core {
public:
    virtual ~Core() = default;
    Core(Core const&) = delete;
    Core& operator=(Core const&) = delete;

    /// Renders into an existing frame and reuses its memory. After an exception the frame holds no picture, and the next frame begins anew.
    virtual void render_into(splat::Camera const& camera, RenderedFrame& frame) = 0;
    RenderedFrame render(splat::Camera const& camera)
    {
        RenderedFrame frame;
        render_into(camera, frame);
        return frame;
    }
    /// Builds the mesh for frames of this size and loads the map, which the first frame does otherwise. Homes wait for that frame.
    virtual void prepare(std::uint32_t, std::uint32_t) {}
    /// FrameRenderer::prefetch. Homes throw Error, because their records never move.
    virtual Prefetched prefetch(splat::Camera const&)
    {
        throw Error("a prefetch with the program of homes (its records never move); render without it, or choose Program::anchored");
    }
    /// Sets the function that the mesh calls after every superstep; see SuperstepEvent.
    virtual void observe(Observer observer) = 0;
    /// Throws Error if its own observer calls it, because its frame is not over. `render_into`, `prepare`, `prefetch` and `observe` throw this
    /// Error too.
    virtual void require_idle() const {}
    /// The trace of the last frame, superstep by superstep. Throws Error if the engine keeps none.
    virtual Trace const& trace() const
    {
        throw Error("the trace of a renderer that keeps none (RendererOptions::trace is off); set it when you make the renderer");
    }
    virtual splat::Rules& rules() = 0;        ///< of the picture; change them between frames
    virtual scene::Map const& map() const = 0; ///< the records that the renderer has; perhaps in another order
    virtual Extent2 grid() = 0;               ///< tiles of the last frame; call `render` first
    virtual Extent2 tile() = 0;               ///< pixels of a tile in the last frame; call `render` first
    virtual Setup const& setup() const = 0;   ///< with the sizes of the last frame
    /// The tiles of the picture that composited in the last frame; the others kept their pixels. 0 for homes.
    virtual std::uint32_t composited_tiles() const noexcept { return 0; }

    /// Names the demand to which the map was reduced. From now on `render` throws Error for a view that the demand does not cover, and it
    /// counts the records that were not loaded as parked.
    void hold_to(scene::Demand const& demand) { views_ = scene::LoadedViews(demand); }

protected:
    Core() = default;

    scene::LoadedViews views_;
};

}}} // namespace tilemesh::render
