#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tilemesh/engine/digest.hpp>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/engine/stopwatch.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/either.hpp>
#include <tilemesh/render/accounting.hpp>
#include <tilemesh/render/engine_options.hpp>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/render/kept_pixels.hpp>
#include <tilemesh/render/losses.hpp>
#include <tilemesh/render/over_ranks.hpp>
#include <tilemesh/render/picture.hpp>
#include <tilemesh/render/record_keeper.hpp>
#include <tilemesh/render/record_table.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/row_shares.hpp>
#include <tilemesh/render/row_weights.hpp>
#include <tilemesh/render/screen_cache.hpp>
#include <tilemesh/render/setup_choice.hpp>
#include <tilemesh/render/setup_facts.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

namespace render {

/// The facts of a setup. If the options name sizes, the facts have these sizes.
template <class S>
SetupFacts facts_of(RendererOptions const& options)
{
    return options.sizes ? facts_of<S>(*options.sizes) : facts_of<S>();
}
/// Throws Error if a renderer of policies P cannot serve a setup: its pixels lack a plane, it has other steps, or (by value) its records or
/// rules differ.
template <class P>
void check_facts(SetupFacts const& facts)
{
    bool serves = (P::Pixel::has_depth || !facts.has_depth) && (P::Pixel::has_alpha || !facts.has_alpha);
    if constexpr (!splat::has_parts_words<typename P::Parameters>) serves = serves && facts.routes == P::routes && facts.blooms == P::blooms;
    if constexpr (splat::has_policies<typename P::Parameters>) {
        if constexpr (!std::is_same_v<typename P::Record, splat::Reference>) serves = serves && facts.sh_degree <= P::Record::sh_degree;
    } else {
        serves = serves && facts.sh_degree == P::Record::sh_degree && (facts.policies.holds != 0) == P::Saturation::holds &&
                 (facts.policies.carried != 0) == P::Addressing::carried && (facts.policies.reusable != 0) == P::Copies::reusable;
    }
    if (!serves)
        throw Error(std::string("setup ") + facts.name + " on a renderer of other policies (its pixels lack a plane, its steps differ, or by value its records " +
                    "or rules do); choose the renderer with the setup's policies");
}

/// A renderer of policies P: BasicRenderer without the setup, which it takes as a value (SetupFacts). `Machine` is AnyMachine or
/// Traced<AnyMachine>. `HostRenderer` (renderer.hpp) is the one that the compiled library has.
///
/// If the engine runs on several processes (MpiMesh), every process has such a renderer of the same map, setup and options, and calls the
/// same functions with the same cameras and models. Records start on the tiles of every process and route themselves. Every process returns
/// the same report; `host_ms` is its own. The first process returns the picture, the others an empty one. What fails in one process is an
/// Error in all of them. A process keeps its share of the map (RendererOptions::rows_of_all_parts), and a record that starts on a tile of another
/// process is sent to it. Cost: a frame gathers the picture, and adds up 12 words; a frame that lists losses collects a splat of each record
/// in the first process.
template <class P, template <class, class> class Engine, class Machine>
class FrameRenderer {
public:
    using Policies = P;
    using Program = splat::Frame<P>;
    using Steps = splat::FrameSteps<P>;
    using Parameters = typename P::Parameters;
    using MeshType = Engine<Program, Machine>;
    using EngineOptions = typename MeshType::Options;
    static constexpr bool by_reference = std::is_same_v<typename P::Record, splat::Reference>;
    /// May tiles keep their pixels? With parameters of the user's own, the host cannot know what compositing reads.
    static constexpr bool may_keep_pixels =
        std::is_same_v<Parameters, splat::TableParameters> || std::is_same_v<Parameters, splat::HostParameters>;

    static_assert(!over_ranks<MeshType> || !by_reference, "references to a table of the host on an engine over several processes (a tile "
                                                          "of another process cannot read that table); choose a setup by value");

    FrameRenderer(scene::Map const& map, SetupFacts facts, RendererOptions const& options, EngineOptions engine);
    ~FrameRenderer();
    FrameRenderer(FrameRenderer const&) = delete;
    FrameRenderer& operator=(FrameRenderer const&) = delete;

    /// The rules of the picture. Change them between frames.
    splat::Rules& rules() noexcept { return rules_; }
    splat::Rules const& rules() const noexcept { return rules_; }

    /// The machine, the sizes and the ledger of the setup.
    SetupFacts const& facts() const noexcept { return facts_; }

    /// The mesh. It exists after the first `render` or `prepare`. Tiles that keep their pixels rely on two rules for its user: add 1 to
    /// `splat::Counts::changes` of a tile whose words you change, and do not run the mesh with parameters of your own.
    MeshType& mesh() noexcept { return *mesh_; }
    splat::Tiling const& tiling() const noexcept { return tiling_; }

    /// The tiles of the picture that composited in the last frame; the others kept their pixels (render/kept_pixels.hpp). A tile counts twice
    /// if it composited in both runs of a frame that ran twice. It is a fact about the host, so it is not in the report.
    std::uint32_t composited_tiles() const noexcept { return composited_; }

    /// The trace of the last frame, superstep by superstep; only on a Traced machine, and an Error if the engine's options say that the mesh
    /// keeps none. If the host recalled copies, the program ran twice, and the trace holds both runs in order. The mesh's own trace holds the second run only. Neither trace contains the host's work. On
    /// several processes, it is the trace of this process's tiles.
    template <class M = Machine> // a template, because Clang 14 instantiates members of an `extern template` whatever they require
    Trace const& trace() const
        requires(is_traced<M>)
    {
        return ran_twice_ && keeps_trace() ? trace_ : mesh_->trace();
    }

    /// The trace of all tiles, in the first of several processes; an empty one in the others. Every process calls it.
    template <class M = Machine>
    Trace gather_trace()
        requires(is_traced<M>)
    {
        return render::gather_trace(*mesh_, trace());
    }

    /// Builds the mesh for frames of this size and loads the map. Does nothing if this mesh exists already. On several processes, this mesh has
    /// bands of equal height; the mesh that `render` builds has bands of equal work in its view.
    void prepare(std::uint32_t width, std::uint32_t height);

    /// Sets the function that the mesh calls after every superstep; see SuperstepEvent.
    void observe(Observer observer);

    /// Renders one frame. The records start on the tiles where the last frame left them. After an exception (out of memory, an observer
    /// that threw, an error of the mesh), the next frame starts like the first one: it builds a new mesh and loads the map.
    RenderedFrame render(splat::Camera const& camera);

    /// Renders into an existing frame and reuses its memory, for many frames of one size. After an exception the frame holds no picture.
    void render_into(splat::Camera const& camera, RenderedFrame& result);

private:
    static constexpr bool traced = is_traced<Machine>;

    bool keeps_trace() const noexcept
    {
        if constexpr (requires { engine_.trace; })
            return traced && engine_.trace;
        else
            return traced;
    }
    void prepare_for(std::uint32_t width, std::uint32_t height, splat::View const* view);
    /// `view`: that of the first frame, if it is known.
    void build(Grid grid, splat::View const* view)
    {
        auto const make = [&](EngineOptions const& engine) {
            mesh_.emplace(splat::frame_program<P>(options_.hops), grid, mesh_sizes_of<P>(facts_), engine);
        };
        if constexpr (over_ranks<MeshType>) {
            GroupOf<MeshType> group(engine_);
            require_same_frames(group, renderer_digest_);
            EngineOptions engine;
            together(group, [&] {
                set_engine_options<traced>(options_, engine_);
                engine = engine_;
            });
            if (view != nullptr && engine.row_weights.empty()) engine.row_weights = weights_of_rows(group, grid.height, *view);
            make(engine);
        } else {
            set_engine_options<traced>(options_, engine_);
            make(engine_);
        }
        if (options_.channel_slots != 0) {
            if constexpr (P::routes)
                if (facts_.routes) mesh_->template limit<splat::Road<P>>(options_.channel_slots);
            if constexpr (P::blooms)
                if (facts_.blooms) mesh_->template limit<splat::Beam<P>>(options_.channel_slots);
        }
        if constexpr (P::routes && P::Saturation::may_hold)
            if (options_.waiting_slots != 0 && facts_.policies.holds != 0 && facts_.routes) {
                mesh_->template limit<splat::Waiting<P, 0>>(options_.waiting_slots);
                mesh_->template limit<splat::Waiting<P, 1>>(options_.waiting_slots);
            }
        if (options_.storage_slots != 0) mesh_->template limit<splat::Storage<P>>(options_.storage_slots);
        together(*mesh_, [&] {
            if (observer_) mesh_->observe(observer_);
        });
        if (over_ranks<MeshType> && !shared_) {
            records_.share(*mesh_, options_.rows_of_all_parts);
            shared_ = true;
        }
        blacken();
        last_.reset();
        copies_lost_ = copies_refused_ = cut_ = ran_twice_ = false;
        keeper_.begin(*mesh_, tiling_, storage_slots(), facts_.routes);
    }
    /// The work of each row of tiles in a view. Each process projects its share of the map.
    template <class Group>
    std::vector<std::uint32_t> weights_of_rows(Group& group, std::uint32_t height, splat::View const& view) const
    {
        std::optional<RowWeights> rows;
        together(group, [&] {
            rows.emplace(tiling_, height);
            if (is_first(group)) rows->add_tiles();
            RowShares mine(records_.rows());
            if (!shared_ && options_.rows_of_all_parts == 0) mine = RowShares(records_.rows(), processes(group), this_process(group)); // of the whole map
            constexpr std::uint32_t at_once = 256;
            splat::Splat splats[at_once];
            auto const last = static_cast<std::uint32_t>(mine.last());
            for (auto row = mine.first(); row < last; row += at_once) {
                auto const some = std::min(at_once, last - row);
                records_.project(row, some, view, tiling_, splats);
                for (std::uint32_t i = 0; i < some; ++i) rows->add(splats[i]);
            }
        });
        sum(group, rows->work().data(), rows->work().size());
        std::vector<std::uint32_t> weights;
        together(group, [&] { weights = rows->weights(); });
        return weights;
    }
    void blacken()
    {
        size_framebuffers<P>(*mesh_, tiling_, size_, facts_.has_planes());
        kept_.forget();
    }
    std::uint32_t storage_slots() const noexcept { return options_.storage_slots != 0 ? options_.storage_slots : facts_.sizes.storage; }

    /// In a new view, projects the host's table and puts the missing records onto the mesh. Returns whether the view is new.
    bool put_records(splat::View const& view)
    {
        auto const& frame = mesh_->template broadcast<Parameters>();
        bool const changed = !last_ || __builtin_memcmp(&*last_, &view, sizeof view) != 0 ||
                             __builtin_memcmp(&frame.tiling, &tiling_, sizeof tiling_) != 0;
        if (!changed) return false;
        if constexpr (by_reference) project_all(view);
        if constexpr (!P::routes || splat::has_parts_words<Parameters>)
            if (!facts_.routes) keeper_.place(*mesh_, view, tiling_);
        if constexpr (P::routes)
            if (facts_.routes && facts_.policies.holds != 0 && !keeper_.missing().empty())
                keeper_.load(*mesh_, tiling_, last_.has_value());
        return true;
    }
    /// Projects all records into the table, on all threads.
    void project_all(splat::View const& view)
    {
        mesh_->on_threads([&](std::uint32_t thread, std::uint32_t threads) {
            std::uint64_t const n = records_.rows();
            cache_.project(records_, static_cast<std::uint32_t>(n * thread / threads),
                           static_cast<std::uint32_t>(n * (thread + 1) / threads), view, tiling_, !last_,
                           mesh_->template broadcast<Parameters>());
        });
    }
    void tell(splat::View const& view, bool changed)
    {
        auto& frame = mesh_->template broadcast<Parameters>();
        auto const flag = [](bool set) { return static_cast<std::uint8_t>(set ? 1 : 0); };
        static_cast<splat::FrameParameters&>(frame) = {view, tiling_, flag(changed), flag(changed && copies_lost_), flag(cut_)};
        if constexpr (splat::has_policies<Parameters>) frame.policies = facts_.policies;
        if constexpr (machine::has_form_word<Parameters>) frame.wide = facts_.has_planes() ? 1 : 0;
        if constexpr (splat::has_parts_words<Parameters>) {
            frame.routes = facts_.routes ? 1 : 0;
            frame.blooms = facts_.blooms ? 1 : 0;
        }
        if constexpr (by_reference) cache_.point(frame);
    }

    /// Does the host keep the missing records? If not, they are lost for good.
    bool host_keeps() const noexcept { return !facts_.routes || facts_.policies.holds != 0; }
    report::FrameReport run()
    {
        if constexpr (may_keep_pixels) kept_.begin_run(mesh_->template broadcast<Parameters>(), mesh_->grid());
        auto const counters = mesh_->run();
        composited_ += kept_.composited(tiling_, mesh_->grid());
        return finish(counters);
    }
    /// Runs the frame again. No record moves, and tiles whose copies were recalled sort and composite again.
    void run_again(report::FrameReport& report)
    {
        if constexpr (traced)
            if (keeps_trace()) together(*mesh_, [&] { trace_ = mesh_->trace(); });
        auto& frame = mesh_->template broadcast<Parameters>();
        frame.view_changed = frame.resend_copies = 0;
        auto const second = run();
        together(*mesh_, [&] {
            add_second_run(report, second);
            if constexpr (traced)
                if (keeps_trace()) {
                    auto const& second_run = mesh_->trace().supersteps;
                    trace_.supersteps.insert(trace_.supersteps.end(), second_run.begin(), second_run.end());
                }
        });
    }

    report::FrameReport finish(RunCounters const& counters)
    {
        TileSums sums;
        report::FrameReport r;
        keeper_.for_each_tile(*mesh_, [&](TileId tile) {
            auto const& mesh = std::as_const(*mesh_);
            sums.add(mesh.template state<splat::Counts>(tile), mesh.template state<splat::Work>(tile));
        });
        auto const& frame = mesh_->template broadcast<Parameters>();
        auto const off = keeper_.off_tiles(frame.view, tiling_, host_keeps());
        sums.visible += off.visible;
        sums.parked += off.parked;
        if constexpr (over_ranks<MeshType>) {
            std::uint64_t words[TileSums::words];
            __builtin_memcpy(words, &sums, sizeof words);
            sum(*mesh_, words, TileSums::words);
            __builtin_memcpy(&sums, words, sizeof words);
        }
        together(*mesh_, [&] { r = account<P>(counters, sums, facts_.policies.holds != 0); });

        // A loss lasts until the records are sent again: a frame that refused no record may still lack records that an earlier frame lost.
        copies_lost_ = r.refused.copies_full != 0 || (copies_lost_ && frame.resend_copies == 0);
        copies_refused_ = r.refused.copies_refused != 0 || (copies_refused_ && frame.view_changed == 0);
        bool spans = false;
        if constexpr (!P::blooms || splat::has_parts_words<Parameters>)
            if (!facts_.blooms) spans = any_spans();
        if (r.refused.storage_full != 0 || !keeper_.missing().empty() || copies_lost_ || copies_refused_ || options_.hops != 0 || spans)
            list_losses(r);
        return r;
    }
    void list_losses(report::FrameReport& r)
    {
        auto const& frame = mesh_->template broadcast<Parameters>();
        auto const facts = facts_on<P>(*mesh_);
        LossQuestion const question{mesh_->grid(), frame.view,  frame.tiling, facts_.routes, facts_.blooms, facts_.policies.holds != 0,
                                    options_.hops != 0, storage_slots()};
        ScreenRows const rows(*mesh_, question, records_);
        NotOnTiles off;
        together(*mesh_, [&] {
            if (is_first(*mesh_)) off = render::list_losses(question, rows, facts, r);
        });
        share_losses(*mesh_, r, off);
        if constexpr (!over_ranks<MeshType>) off.missing_ids.clear();
        keeper_.set_missing(std::move(off.missing), std::move(off.missing_ids));
        keeper_.set_under_way(std::move(off.under_way));
    }
    /// Only without bloom: does any footprint leave its anchor tile?
    bool any_spans()
    {
        auto const& frame = mesh_->template broadcast<Parameters>();
        bool any = false;
        keeper_.for_each_tile(*mesh_, [&](TileId tile) {
            for (auto const& entry : std::as_const(*mesh_).template state<splat::Splats<P>>(tile)) {
                auto const& s = splat::AccessOf<P>::splat_of(frame, entry);
                any = any || (s.visible() && splat::tiles_of(s, tiling_).count() > 1);
            }
        });
        return in_any(*mesh_, any);
    }
    /// The view of a camera, which this function checks. On several processes, throws Error in all of them if one refuses its camera or
    /// model, or if they render different frames.
    splat::View agreed_view(splat::Camera const& camera)
    {
        splat::View view{};
        auto const agree = [&]([[maybe_unused]] auto& all) {
            together(all, [&] {
                check_camera(camera);
                check_rules(rules_);
                view = splat::make_view(camera, rules_);
            });
            if constexpr (over_ranks<MeshType>) require_same_frames(all, digest_of_view(renderer_digest_, view));
        };
        if (mesh_ && !halfway_) {
            agree(*mesh_);
        } else {
            GroupOf<MeshType> group(engine_);
            agree(group);
        }
        return view;
    }

    /// A digest of what must be the same on all ranks in all frames: map, rules, and those options that are not in the mesh.
    std::uint64_t digest_of_renderer() const noexcept
    {
        auto digest = over_ranks<MeshType> && options_.rows_of_all_parts == 0 ? records_.digest() : 0;
        for (auto const word : {options_.rows_of_all_parts, options_.channel_slots, options_.waiting_slots, facts_.policies.holds, facts_.policies.carried, facts_.policies.reusable, facts_.policies.road_bytes,
                                facts_.policies.beam_bytes, static_cast<std::uint32_t>(facts_.colour), options_.hops, options_.storage_slots})
            digest = engine::mix(digest, word);
        return digest;
    }

    RendererOptions options_;
    EngineOptions engine_;
    SetupFacts facts_;
    RecordTable records_;
    std::uint64_t renderer_digest_;
    ScreenCache cache_;                              ///< the table that the tiles' references point to
    RecordKeeper<P> keeper_;
    KeptPixels kept_;
    splat::Rules rules_;
    Extent2 size_{};                                 ///< of the frame, pixels
    splat::Tiling tiling_{};
    std::optional<MeshType> mesh_; ///< no memory of its own, which one of several processes may lack
    Observer observer_;
    std::optional<splat::View> last_;
    std::uint32_t composited_ = 0;                   ///< tiles, in the last frame
    bool copies_lost_ = false;                       ///< copies found no storage; tiles do not send these again by themselves
    bool copies_refused_ = false;                    ///< copies met a full channel; tiles owe them again in a new view
    bool cut_ = false;                               ///< a bound may have left records under way
    bool ran_twice_ = false;                         ///< the host recalled copies in the last frame
    bool shared_ = false;                            ///< over several processes: this one has its share of the records
    bool halfway_ = false;                           ///< a frame started and did not end, so the host and the tiles may have different views
    [[no_unique_address]] std::conditional_t<traced, Trace, engine::NoTrace> trace_; ///< of both runs, if it ran twice
};

// The members that users call are defined outside the class. So with `extern template` users need not compile them or what they call.

template <class P, template <class, class> class Engine, class Machine>
FrameRenderer<P, Engine, Machine>::FrameRenderer(scene::Map const& map, SetupFacts facts, RendererOptions const& options,
                                                 EngineOptions engine)
    : options_(options), engine_(std::move(engine)), facts_(std::move(facts)), records_(map, facts_.sh_degree),
      renderer_digest_(digest_of_renderer()), cache_(by_reference ? records_.rows() : 0), keeper_(records_, &cache_),
      kept_(may_keep_pixels && options.keep_pixels), rules_(with_options(facts_.rules, options))
{
    check_facts<P>(facts_);
    if (options.rows_of_all_parts != 0 && !over_ranks<MeshType>) refuse_part();
    if (facts_.sizes.one_channel_memory && options.hops != 0)
        throw Error(std::string("setup ") + facts_.name + " with bounded hops (its routing and bloom take turns in one set of " +
                    "channels, which a bound would leave full); choose a setup with channels of their own");
}
template <class P, template <class, class> class Engine, class Machine>
FrameRenderer<P, Engine, Machine>::~FrameRenderer() = default;

template <class P, template <class, class> class Engine, class Machine>
void FrameRenderer<P, Engine, Machine>::prepare(std::uint32_t width, std::uint32_t height)
{
    prepare_for(width, height, nullptr);
}
template <class P, template <class, class> class Engine, class Machine>
void FrameRenderer<P, Engine, Machine>::prepare_for(std::uint32_t width, std::uint32_t height, splat::View const* view)
{
    if (halfway_) mesh_.reset();
    halfway_ = false;
    if (mesh_ && width == size_.width && height == size_.height) return;
    auto const layout =
        layout_frame({options_.grid, options_.tile}, width, height, facts_.machine, facts_.sizes.tile_pixels, facts_.name);
    size_ = {width, height};
    tiling_ = layout.tiling;
    if (mesh_ && layout.grid.width == mesh_->grid().width && layout.grid.height == mesh_->grid().height) {
        blacken();
        keeper_.occupy(*mesh_, tiling_.columns, tiling_.rows);
        return;
    }
    try {
        build(layout.grid, view);
    } catch (...) {
        mesh_.reset();
        throw;
    }
}

template <class P, template <class, class> class Engine, class Machine>
void FrameRenderer<P, Engine, Machine>::observe(Observer observer)
{
    observer_ = std::move(observer);
    if (mesh_) mesh_->observe(observer_);
}

template <class P, template <class, class> class Engine, class Machine>
RenderedFrame FrameRenderer<P, Engine, Machine>::render(splat::Camera const& camera)
{
    RenderedFrame result;
    render_into(camera, result);
    return result;
}

template <class P, template <class, class> class Engine, class Machine>
void FrameRenderer<P, Engine, Machine>::render_into(splat::Camera const& camera, RenderedFrame& result)
{
    engine::Stopwatch const all;
    auto const view = agreed_view(camera);
    prepare_for(camera.width, camera.height, &view);
    engine::Stopwatch const preparing;
    halfway_ = true;
    bool const changed = put_records(view);
    tell(view, changed);
    std::size_t const gone = host_keeps() ? 0 : keeper_.missing().size();
    composited_ = 0;
    auto const prepared_ms = preparing.milliseconds();

    auto report = run();
    report.host_ms.project += prepared_ms;
    // If records found no room, the frame runs again without their copies, so that the picture shows a record whole or not at all.
    bool const may_recall = facts_.policies.holds != 0 && options_.hops == 0;
    ran_twice_ = may_recall && keeper_.recall_copies(*mesh_);
    if (ran_twice_) run_again(report);
    check_sums(report, records_.all_rows(), gone);

    engine::Stopwatch const collecting;
    collect_picture<P>(*mesh_, facts_, tiling_, camera, result);
    result.report = std::move(report);
    result.report.width = camera.width;
    result.report.height = camera.height;
    last_ = view;
    cut_ = options_.hops != 0;
    halfway_ = false;
    result.report.host_ms.picture = collecting.milliseconds();
    result.report.host_ms.total = all.milliseconds();
}

} // namespace render
}} // namespace tilemesh
