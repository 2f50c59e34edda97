#pragma once
#include <concepts>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/render/core.hpp>
#include <tilemesh/render/picture.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/rules.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 {

namespace render {

/// May anchored tiles render a frame? No if the records are more than the tiles have slots, or if the tiles have no room for the pixels.
struct MayFitAnchored {
    bool records;
    Cut cut;
    MachineSize machine;
    std::uint32_t tile_pixels;

    bool frame(Extent2 size) const noexcept { return fits(cut, size.width, size.height, machine, tile_pixels); }
};
inline MayFitAnchored may_fit_anchored(std::uint64_t records, Setup const& setup, RendererOptions const& options) noexcept
{
    std::uint64_t const tiles = options.grid.width != 0 ? std::uint64_t{options.grid.width} * options.grid.height : setup.machine.tiles;
    std::uint64_t const slots = options.storage_slots != 0 ? options.storage_slots : setup.sizes.storage;
    return {records <= tiles * slots, {options.grid, options.tile}, setup.machine, setup.sizes.tile_pixels};
}

/// The program of a setup on an engine of this process, by reference: that of anchored tiles, or of homes if `setup.program` says so. The
/// options name the engine and say whether it keeps a trace. Throws Error as the constructors of Renderer do.
TILEMESH_HOST std::unique_ptr<Core> make_core(scene::Map map, Setup const& setup, RendererOptions const& options);

/// Makes what is not the anchored program on plain threads. It is apart, so that a program without it need not compile or link it. With
/// headers alone, <tilemesh/all_programs.hpp> sets it.
#if defined(TILEMESH_COMPILED)
std::unique_ptr<Core> make_other_core(scene::Map map, Setup const& setup, RendererOptions const& options);
#else
inline constinit decltype(&make_core) make_other_core = nullptr;
#endif

} // namespace render

/// Renders a map on a mesh of tiles, frame after frame. It loads the map's records onto the tiles once, then runs the frame program for
/// each camera. Records and copies stay on their tiles between frames. So a small step of the camera moves few records, and a static view
/// moves none.
///
/// It is the same type in every build. What it runs is a value: the setup (splat/setup.hpp) has machine, sizes and policies, and the options
/// name the program and the engine of this process, and ask for a trace. A host keeps each record once, moves references, and
/// projects each record once per view; pictures and reports are those of a machine that moves values (render/host_form.hpp). With headers alone,
/// this header has the anchored program on host threads; other programs and engines, and traces, are in <tilemesh/all_programs.hpp>.
/// tilemesh::compiled has all.
///
/// **Programs.** `anchored`: records move to anchor tiles. `homes`: a map of any density, in rounds. `automatic`: anchored as long as nothing
/// is missing; a frame that would lack records or copies, or has more pixels than anchored tiles have room for, is rendered by homes instead,
/// and so are all later frames. The frame at the change runs both; its report is that of homes, with the host time of both. If
/// homes have no room for the map either, the anchored program goes on, and its reports list what is missing. `automatic` stays anchored where
/// homes lack something: a setup that drops, ranks or copies splats, bounded hops, a tile's size, sizes in the options.
///
/// Policies of your own, and engines of another machine, are types: `BasicRenderer` (basic_renderer.hpp) renders with one setup type
/// on one engine, and a Renderer takes it as its core.
///
/// Errors: it throws Error if the frame, the grid or the map does not fit the machine, if the map has a higher degree of harmonics than the
/// setup's records (scene::at_degree drops the rest), if two records have one id, or if a limit is out of range. A record that finds
/// no room while a frame runs is not an error: the frame's report lists it by id and cause. A setup that holds gives a record whose anchor tile
/// is full back to the host, which puts it onto the mesh again for the next view. One that drops loses the record, as on the paper's machine.
/// If an unplaced record left copies on other tiles, the host recalls them and the frame is composited again, so that the picture shows a
/// record whole or not at all. After an exception (also std::bad_alloc), the next frame builds a new mesh and loads the map.
class Renderer {
public:
    /// Makes the core of homes from the records of the anchored one, when it is needed. It may throw Error.
    using MakeHomes = std::function<std::unique_ptr<render::Core>(scene::Map const&)>;

    /// `lossless` on Mk2, with records of the map's degree.
    explicit Renderer(scene::Map map, RendererOptions const& options = {});
    /// A setup of your own. `homes`: what the program of homes has, if that is not `splat::as_homes(setup)`.
    template <std::same_as<render::Setup> S> // so that {.threads = 2} can only be options
    Renderer(scene::Map map, S const& setup, RendererOptions const& options = {}, std::optional<render::Setup> const& homes = {})
    {
        make(std::move(map), setup, options, homes);
    }
    /// A core of your own.
    explicit Renderer(std::unique_ptr<render::Core> core) : core_(std::move(core)) { (void)this->core(); }
    /// The program `automatic` with cores of your own. A frame that may not fit is of homes at once.
    Renderer(std::unique_ptr<render::Core> anchored, MakeHomes make_homes, render::MayFitAnchored const& may_fit)
        : core_(std::move(anchored)), make_homes_(std::move(make_homes)), may_fit_(may_fit)
    {
        (void)core();
    }

    RenderedFrame render(splat::Camera const& camera)
    {
        RenderedFrame frame;
        render_into(camera, frame);
        return frame;
    }
    /// Renders into an existing frame and reuses its memory, for many frames of one size. After an exception the frame holds no picture.
    void render_into(splat::Camera const& camera, RenderedFrame& frame);
    /// Builds the mesh for frames of this size and loads the map, which the first frame does otherwise.
    void prepare(std::uint32_t width, std::uint32_t height) { core().prepare(width, height); }
    /// Moves records to the tiles that will want them in the view of `camera`, without a picture (render::FrameRenderer::prefetch).
    render::Prefetched prefetch(splat::Camera const& camera) { return core().prefetch(camera); }

    /// The rules of the picture. Change them between frames.
    splat::Rules& rules() { return core().rules(); }
    /// Names the demand to which the map was reduced. From now on `render` throws Error for a view that the demand does not cover, and it
    /// counts the records that were not loaded as parked.
    void hold_to(scene::Demand const& demand);
    /// Sets the function that the mesh calls after every superstep; see SuperstepEvent. It follows a change of the program. What it throws
    /// comes out of `render`. It may read everything; if it renders, prepares, prefetches or observes with this renderer, it gets an Error.
    void observe(Observer observer);
    /// The trace of the last frame, superstep by superstep. Throws Error without `RendererOptions::trace`.
    Trace const& trace() const { return std::as_const(core()).trace(); }

    scene::Map const& map() const { return core().map(); } ///< the records that the renderer has; perhaps in another order
    Extent2 grid() const { return core().grid(); }         ///< tiles of the last frame; call `render` first
    Extent2 tile() const { return core().tile(); }         ///< pixels of a tile in the last frame; call `render` first
    render::Setup const& setup() const { return core().setup(); } ///< with the sizes of the last frame
    /// The slots of one bloom channel. Without bloom: of one routing channel. Without both: 0.
    std::uint32_t channel_slots() const
    {
        auto const& s = setup();
        return s.program == splat::Program::homes ? s.sizes.road : s.blooms ? s.sizes.beam : s.routes ? s.sizes.road : 0;
    }
    /// The tiles of the picture that composited in the last frame; the others kept their pixels. It is a fact about the host.
    std::uint32_t composited_tiles() const { return core().composited_tiles(); }

    /// The program of the last frame, and of the next one unless that would lack something. Its mesh has the states of the tiles
    /// (`dynamic_cast<render::HostRenderer&>`). Throws Error, as every member function, if this object was moved from.
    render::Core& core() const
    {
        if (!core_) throw Error("a Renderer without a core (it was moved from, or made of none); use the one to which it was moved");
        return *core_;
    }
    /// Why `automatic` changed to homes, in words: "1200 records and 3 copies would be missing". Empty as long as it did not change.
    std::string const& change() const noexcept { return change_; }
    /// Why it could not change to homes: the text of the Error. Empty if it could, or need not.
    std::string const& change_refused() const noexcept { return change_refused_; }

private:
    void make(scene::Map map, render::Setup const& setup, RendererOptions const& options, std::optional<render::Setup> const& homes);

    std::unique_ptr<render::Core> core_;
    MakeHomes make_homes_; ///< empty after the change, and for one program
    render::MayFitAnchored may_fit_{};
    std::optional<scene::Demand> demand_; ///< only the facts about views
    Observer observer_;
    std::string change_, change_refused_;
};

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/detail/renderer_code.hpp>
#endif
