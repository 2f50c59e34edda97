#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/engine/stopwatch.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/render/accounting.hpp>
#include <tilemesh/render/core.hpp>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/render/host.hpp>
#include <tilemesh/render/kept_pixels.hpp>
#include <tilemesh/render/losses.hpp>
#include <tilemesh/render/picture.hpp>
#include <tilemesh/render/record_keeper.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/screen_cache.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/render/setup_on_mesh.hpp>
#include <type_traits>
#include <utility>

namespace tilemesh { inline namespace v0_2 {

namespace render {

/// The anchored program with policies P, on an engine. It takes the setup as a value (Setup). `Machine` is AnyMachine or
/// Traced<AnyMachine>. A Renderer runs `HostRenderer` (basic_renderer.hpp), which serves all setups by reference.
///
/// The way of a Gaussian: `RecordTable` (the map) - `RecordKeeper` (onto tiles) - `ScreenCache` (projected, by reference) - the program
/// splat::Frame on the mesh, whose kernels read it through `splat::Access` (by reference: splat/references.hpp) - `Host::picture`.
/// render/ranks/host.hpp says what differs on an engine over several processes.
template <class P, template <class, class> class Engine, class Machine>
class FrameRenderer : public Core {
public:
    using Policies = P;
    using Program = splat::Frame<P>;
    using Steps = splat::FrameSteps<P>;
    using Parameters = typename P::Parameters;
    using MeshType = Engine<Program, Machine>;
    using EngineOptions = typename MeshType::Options;
    using HostType = Host<MeshType, Machine>;
    static constexpr bool by_reference = std::is_same_v<typename P::Record, splat::Reference>;

    static_assert(HostType::has_one_memory || !splat::stores_own_form<P>,
                  "records of an own form on an engine over several processes (they send each other the map's records); choose an engine "
                  "of one process");
    static_assert(HostType::has_one_memory || !by_reference, "references to a table of the host on an engine over several processes (a tile "
                                                             "of another process cannot read that table); choose a setup by value");

    FrameRenderer(scene::Map map, Setup setup, RendererOptions const& options, EngineOptions engine);
    ~FrameRenderer() override;

    /// The rules of the picture. Change them between frames.
    splat::Rules& rules() noexcept override { return rules_; }
    splat::Rules const& rules() const noexcept { return rules_; }

    /// What it renders with.
    Setup const& setup() const noexcept override { return setup_; }

    /// The parameters with which a mesh is built, if tiles store a form of their own of the records: what these share must be known before
    /// the first record is loaded. The next mesh has them. The map must have the records that this form stands for, because the host
    /// projects the map's.
    template <class Q = P> // a template, as `gather_trace`
    void begin_with(typename Q::Parameters const& parameters)
        requires(splat::stores_own_form<Q>)
    {
        own_ = parameters;
    }

    /// The mesh. It exists after the first `render` or `prepare`. Tiles that keep their pixels rely on two rules for its user: add 1 to
    /// `splat::Counts::changes` of a tile whose words you change, and do not run the mesh with parameters of your own.
    MeshType& mesh() noexcept { return host_.mesh(); }
    splat::Tiling const& tiling() const noexcept { return tiling_; }

    /// The tiles of the picture that composited in the last frame; the others kept their pixels (render/kept_pixels.hpp). A tile counts twice
    /// if it composited in both runs of a frame that ran twice. It is a fact about the host, so it is not in the report.
    std::uint32_t composited_tiles() const noexcept override { return composited_; }

    /// The trace of the last frame, superstep by superstep; only on a Traced machine, and an Error if the engine's options say that the mesh
    /// keeps none. If the host recalled copies, the program ran twice, and the trace holds both runs in order. The mesh's own trace holds the
    /// second run only. Neither trace contains the host's work. On several processes, it is the trace of this process's tiles.
    Trace const& trace() const override
    {
        if constexpr (is_traced<Machine>)
            return host_.trace();
        else
            return Core::trace();
    }
    /// The trace of all tiles, in the first of several processes; an empty one in the others. Every process calls it.
    template <class M = Machine> // a template, because Clang 14 instantiates members of an `extern template` whatever they require
    Trace gather_trace()
        requires(is_traced<M>)
    {
        return host_.gather_trace();
    }

    /// The records that the renderer has, as a map.
    scene::Map const& map() const noexcept override { return records_.map(); }
    Extent2 grid() override
    {
        auto const grid = host_.mesh().grid();
        return {grid.width, grid.height};
    }
    Extent2 tile() override { return {tiling_.tile_width, tiling_.tile_height}; }

    /// Builds the mesh for frames of this size and loads the map. Does nothing if this mesh exists already. On several processes, this mesh has
    /// bands of equal height; the mesh that `render` builds has bands of equal work in its view.
    void prepare(std::uint32_t width, std::uint32_t height) override;

    /// Sets the function that the mesh calls after every superstep; see SuperstepEvent.
    void observe(Observer observer) override;
    void require_idle() const override { host_.require_idle(); }

    /// Renders one frame. The records start on the tiles where the last frame left them. After an exception (out of memory, an observer
    /// that threw, an error of the mesh), the next frame starts like the first one: it builds a new mesh and loads the map.
    void render_into(splat::Camera const& camera, RenderedFrame& result) override;

    /// Moves records and copies to the tiles that will want them in the view of `camera`, without a picture: the steps project, route and
    /// bloom. Call it between two frames with the camera that you expect, as `track::predicted` finds it from the last two poses. The next
    /// frame may have any camera. If that frame lacks no record, its picture has the same bits as without this call. What moved wrongly
    /// moves back in that frame. It may also come before the first frame.
    ///
    /// It is a run of its own: an observer sees its supersteps, and `trace` has them until the next frame. It throws Error for a setup that
    /// drops records or does not route, for policies without words for a frame's parts, for a bound on hops, and for a camera that no frame can
    /// have. Then no record moved.
    Prefetched prefetch(splat::Camera const& camera) override;

private:
    void prepare_for(std::uint32_t width, std::uint32_t height, splat::View const* view);
    /// `view`: that of the first frame, if it is known.
    void build(Grid grid, splat::View const* view)
    {
        host_.build(options_, records_, [&] {
            return MeshPlan<Program>{splat::frame_program<P>(options_.hops), grid, mesh_sizes_of<P>(setup_)};
        }, view, tiling_);
        limit_lists<P>(host_.mesh(), setup_, options_);
        blacken();
        if constexpr (splat::stores_own_form<P>) frame() = own_;
        last_.reset();
        prefetched_ = false;
        left_ = {};
        keeper_.begin(host_, tiling_, storage_slots(), setup_.routes);
    }
    void blacken()
    {
        size_framebuffers<P>(host_, tiling_, size_, setup_.has_planes());
        kept_.forget();
    }
    std::uint32_t storage_slots() const noexcept { return options_.storage_slots != 0 ? options_.storage_slots : setup_.sizes.storage; }
    Parameters& frame() noexcept { return host_.mesh().template broadcast<Parameters>(); }

    /// In a new view, projects the host's table and puts the missing records onto the mesh. Returns whether there is anything new to show.
    bool put_records(splat::View const& view)
    {
        bool const changed = prefetched_ || !last_ || __builtin_memcmp(&*last_, &view, sizeof view) != 0 ||
                             __builtin_memcmp(&frame().tiling, &tiling_, sizeof tiling_) != 0;
        if (!changed) return false;
        if constexpr (by_reference)
            host_.on_threads(records_.rows(), [&](std::uint32_t first, std::uint32_t last) {
                cache_.project(records_, first, last, view, tiling_, !last_, frame());
            });
        if constexpr (!P::routes || splat::has_parts_words<Parameters>)
            if (!setup_.routes) keeper_.place(host_, view, tiling_);
        if constexpr (P::routes)
            if (setup_.routes && setup_.holds && !keeper_.missing().empty())
                keeper_.load(host_, tiling_, last_.has_value());
        return true;
    }
    void tell(splat::View const& view, bool changed)
    {
        auto const flag = [](bool set) { return static_cast<std::uint8_t>(set ? 1 : 0); };
        static_cast<splat::FrameParameters&>(frame()) = {view, tiling_, flag(changed), flag(changed && left_.copies_lost), flag(left_.cut)};
        write_words(setup_, frame());
        // With a bound on hops, after a loss, or where a record with a full channel ahead becomes one of the tile's own (`Drop`), a tile may
        // have a record or a copy that did not touch it in the view before.
        bool const regular =
            !left_.cut && options_.hops == 0 && !left_.copies_lost && setup_.routes && setup_.blooms && setup_.holds;
        if constexpr (by_reference) cache_.point(frame(), changed && regular);
    }

    /// Does the host keep the missing records? If not, they are lost for good.
    bool host_keeps() const noexcept { return !setup_.routes || setup_.holds; }
    report::FrameReport run()
    {
        if constexpr (may_keep_pixels<P>) kept_.begin_run(frame(), host_.mesh().grid());
        auto const counters = host_.run();
        composited_ += kept_.composited(tiling_, host_.mesh().grid());
        return finish(counters);
    }
    /// Runs the frame again. No record moves, and tiles whose copies were recalled sort and composite again.
    void run_again(report::FrameReport& report)
    {
        frame().view_changed = frame().resend_copies = 0;
        if constexpr (by_reference) cache_.point(frame(), false);
        auto const second = run();
        host_.step([&] { add_second_run(report, second); });
    }

    report::FrameReport finish(RunCounters const& counters)
    {
        auto const& now = frame();
        auto const sums = keeper_.sums(host_, now.view, tiling_, host_keeps());
        report::FrameReport r;
        host_.step([&] { r = account<P>(counters, sums, setup_.holds); });
        left_.count(r, now.resend_copies != 0, now.view_changed != 0);
        bool const spans = !setup_.blooms && keeper_.any_spans(host_, tiling_);
        if (r.refused.storage_full != 0 || !keeper_.missing().empty() || left_.lacks_copies() || options_.hops != 0 || spans) {
            LossQuestion const question{host_.mesh().grid(), now.view, now.tiling, setup_.routes, setup_.blooms, setup_.holds,
                                        options_.hops != 0, storage_slots()};
            auto off = host_.template losses<P>(question, records_, r);
            keeper_.set_missing(std::move(off.missing), std::move(off.missing_ids));
            keeper_.set_under_way(std::move(off.under_way));
        }
        return r;
    }

    struct NoWords {};
    RendererOptions options_;
    Setup setup_;
    [[no_unique_address]] std::conditional_t<splat::stores_own_form<P>, Parameters, NoWords> own_{};
    HostType host_;
    typename HostType::Records records_;
    ScreenCache cache_;                              ///< the table that the tiles' references point to
    RecordKeeper<P, typename HostType::Records> keeper_;
    KeptPixels kept_;
    splat::Rules rules_;
    Extent2 size_{};                                 ///< of the frame, pixels
    splat::Tiling tiling_{};
    std::optional<splat::View> last_;
    std::uint32_t composited_ = 0;                   ///< tiles, in the last frame
    LeftBehind left_;
    bool prefetched_ = false;                        ///< since the last picture; so no tile has sorted for the last view
};

// The members that users call are defined outside the class. So with `extern template` users need not compile them or what they call.

template <class P, template <class, class> class Engine, class Machine>
FrameRenderer<P, Engine, Machine>::FrameRenderer(scene::Map map, Setup setup, RendererOptions const& options, EngineOptions engine)
    : options_(options), setup_(checked(std::move(setup))), host_(std::move(engine)), records_(std::move(map), setup_.sh_degree),
      cache_(by_reference ? records_.rows() : 0), keeper_(records_, &cache_), kept_(may_keep_pixels<P> && options.keep_pixels),
      rules_(with_options(setup_.rules, options))
{
    check_policies<P>(setup_);
    check_hops(setup_, options.hops);
    auto const words = splat::policy_words(setup_);
    host_.identify(records_, options_, {options_.rows_of_all_parts, options_.channel_slots, options_.waiting_slots, words.holds,
                                        words.carried, words.reusable, words.road_bytes, words.beam_bytes,
                                        static_cast<std::uint32_t>(setup_.colour), options_.hops, options_.storage_slots, words.ranks});
}
template <class P, template <class, class> class Engine, class Machine>
FrameRenderer<P, Engine, Machine>::~FrameRenderer() = default;

template <class P, template <class, class> class Engine, class Machine>
void FrameRenderer<P, Engine, Machine>::prepare(std::uint32_t width, std::uint32_t height)
{ prepare_for(width, height, nullptr); }
template <class P, template <class, class> class Engine, class Machine>
void FrameRenderer<P, Engine, Machine>::prepare_for(std::uint32_t width, std::uint32_t height, splat::View const* view)
{
    host_.drop_halfway();
    if (host_.has_mesh() && width == size_.width && height == size_.height) return;
    auto const layout = layout_frame({options_.grid, options_.tile}, width, height, setup_.machine, setup_.sizes.tile_pixels, setup_.name);
    size_ = {width, height};
    tiling_ = layout.tiling;
    if (host_.has_mesh() && layout.grid.width == host_.mesh().grid().width && layout.grid.height == host_.mesh().grid().height) {
        blacken();
        keeper_.occupy(host_, tiling_.columns, tiling_.rows);
        return;
    }
    try {
        build(layout.grid, view);
    } catch (...) {
        host_.drop_mesh();
        throw;
    }
}

template <class P, template <class, class> class Engine, class Machine>
void FrameRenderer<P, Engine, Machine>::observe(Observer observer)
{
    host_.observe(std::move(observer));
}

template <class P, template <class, class> class Engine, class Machine>
void FrameRenderer<P, Engine, Machine>::render_into(splat::Camera const& camera, RenderedFrame& result)
{
    engine::Stopwatch const all;
    auto const view = host_.view_of(camera, rules_, [&](splat::View const& v) {
        check_lens(v.camera, Parameters::bends, Parameters::exact_rays);
        views_.require(v);
    });
    prepare_for(camera.width, camera.height, &view);
    engine::Stopwatch const preparing;
    host_.begin_frame();
    bool const changed = put_records(view);
    tell(view, changed);
    std::size_t const gone = host_keeps() ? 0 : keeper_.missing().size();
    composited_ = 0;
    auto const prepared_ms = preparing.milliseconds();

    auto report = run();
    report.host_ms.project += prepared_ms;
    // If records found no room, the frame runs again without their copies, so that the picture shows a record whole or not at all.
    bool const may_recall = setup_.holds && options_.hops == 0;
    if (may_recall && keeper_.recall_copies(host_)) run_again(report);
    check_sums(report, records_.all_rows(), gone);

    engine::Stopwatch const collecting;
    host_.template picture<P>(setup_, tiling_, camera, result);
    result.report = std::move(report);
    result.report.width = camera.width;
    result.report.height = camera.height;
    result.report.gaussians.parked += views_.culled();
    last_ = view;
    left_.cut = options_.hops != 0;
    prefetched_ = false;
    host_.end_frame();
    result.report.host_ms.picture = collecting.milliseconds();
    result.report.host_ms.total = all.milliseconds();
}

template <class P, template <class, class> class Engine, class Machine>
Prefetched FrameRenderer<P, Engine, Machine>::prefetch(splat::Camera const& camera)
{
    Prefetched result;
    if constexpr (splat::has_parts_words<Parameters>) {
        engine::Stopwatch const all;
        check_prefetch(setup_, options_.hops);
        auto const view = host_.view_of(camera, rules_, [](splat::View const&) {});
        prepare_for(camera.width, camera.height, &view);
        host_.begin_frame();
        if (put_records(view)) {
            tell(view, true);
            frame().draws = 0;
            auto const report = finish(host_.run());
            // The next frame is a new view, so it need not run again for the copies that the host recalls here.
            (void)keeper_.recall_copies(host_);
            check_sums(report, records_.all_rows(), 0);
            last_ = view;
            prefetched_ = true;
            result = {report.exchanges.total(), report.messages, report.exchanged_live_bytes, report.gaussians.moved, 0};
        }
        host_.end_frame();
        result.host_ms = all.milliseconds();
    } else {
        throw Error("a prefetch with policies as types (they have no words that leave out a picture); use a Renderer, with headers alone and "
                    "<tilemesh/all_programs.hpp>");
    }
    return result;
}

} // namespace render
}} // namespace tilemesh
