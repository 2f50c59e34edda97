#pragma once
#include <cstdint>
#include <memory>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/render/picture.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 {
struct RendererOptions;
}}

namespace bench {

/// A mesh that renders frame after frame on the host by reference, as `tilemesh::Renderer` does. One renderer is compiled for all setups.
class Machine {
public:
    virtual ~Machine() = default;
    /// Wakes the mesh's threads, as in a sequence of frames.
    virtual void wake(tilemesh::splat::Camera const&) = 0;
    virtual void render(tilemesh::splat::Camera const&) = 0;
    /// The picture and the report of the last frame.
    virtual tilemesh::report::Image const& image() const = 0;
    virtual tilemesh::report::FrameReport const& report() const = 0;
};
/// Throws Error if the setup does not fit into its machine, or if the options do not fit the setup.
std::unique_ptr<Machine> make_machine(tilemesh::scene::Map const&, tilemesh::render::Setup const&,
                                      tilemesh::RendererOptions const&);

/// A record on a tile.
struct Stored {
    tilemesh::splat::GaussianId id;
    std::uint32_t tile; ///< index
    bool home;          ///< the record itself, on its anchor tile; false: a copy, or a record that must leave
};

/// A mesh that keeps a trace. Its limits may change between frames.
class TracedMachine : public Machine {
public:
    /// Limits the slots of every channel end and (if the setup holds) of each FIFO, from the next frame on; 0: the setup's slots. Not
    /// allowed while records are under way.
    virtual void limit_channels(std::uint32_t slots) = 0;
    /// Sets another bound on the hops per frame, after the first frame; 0: until quiet. Only for machines that were made with a bound.
    virtual void limit_hops(std::uint32_t hops) = 0;
    /// Moves records and copies to where this camera will want them. `trace` is that of this run until the next frame.
    virtual tilemesh::render::Prefetched prefetch(tilemesh::splat::Camera const&) = 0;
    virtual std::vector<Stored> stored() = 0;
    virtual tilemesh::splat::Rules const& rules() const = 0;
    /// The trace of the last frame.
    virtual tilemesh::Trace const& trace() const = 0;
    virtual tilemesh::Grid grid() = 0;
};
std::unique_ptr<TracedMachine> make_traced_machine(tilemesh::scene::Map const&, tilemesh::render::Setup const&,
                                                   tilemesh::RendererOptions const&);

} // namespace bench
