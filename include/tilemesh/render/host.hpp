#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/engine/mesh_options.hpp>
#include <tilemesh/engine/mesh_sizes.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/model/no_progress.hpp>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/render/losses.hpp>
#include <tilemesh/render/picture.hpp>
#include <tilemesh/render/record_table.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/splat/view.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// Sets what the renderer's options say of an engine. A traced engine explains a program that does not become quiet, unless it has an
/// explanation of its own.
template <bool Traced, class EngineOptions>
void set_engine_options(RendererOptions const& options, EngineOptions& engine)
{
    engine.digest = options.digest;
    if constexpr (requires { engine.threads; }) engine.threads = options.threads;
    if constexpr (requires { engine.most_passes; })
        if (options.most_passes != 0) engine.most_passes = options.most_passes;
    if constexpr (Traced && requires { engine.explain; })
        if (engine.explain == nullptr) engine.explain = explain_no_progress;
}

/// What a mesh is built of.
template <class Program>
struct MeshPlan {
    Program program;
    Grid grid;
    MeshSizes<Program> sizes;
};

/// Does the engine run on several processes, each with a part of the mesh's tiles?
template <class MeshType>
inline constexpr bool over_ranks = requires(MeshType const& mesh) { mesh.ranks(); };

/// What hosts have in common, in one process and in several: the mesh, its observer, the trace, and whether a frame is halfway.
template <class MeshType, class Machine>
class HostOfMesh {
public:
    using EngineOptions = typename MeshType::Options;
    static constexpr bool traced = is_traced<Machine>;

    explicit HostOfMesh(EngineOptions engine) : engine_(std::move(engine)) {}

    bool has_mesh() const noexcept { return mesh_.has_value(); }
    MeshType& mesh() noexcept { return *mesh_; }
    MeshType const& mesh() const noexcept { return *mesh_; }
    void drop_mesh() noexcept
    {
        mesh_.reset();
        ran_ = false;
    }
    /// Throws Error if the observer of this host calls it.
    void require_idle() const
    {
        if (running_) throw Error("a renderer that its own observer calls (the frame that it observes is not over); call it after the frame");
    }
    /// Drops the mesh of a frame that did not end.
    void drop_halfway()
    {
        require_idle();
        if (std::exchange(halfway_, false)) drop_mesh();
    }
    void observe(Observer observer)
    {
        require_idle();
        observer_ = std::move(observer);
        if (mesh_) mesh_->observe(observer_);
    }
    /// Shares 0..n-1 out among the mesh's threads: f(first, last) on each.
    template <class F>
    void on_threads(std::uint64_t n, F const& f)
    {
        mesh_->on_threads([&](std::uint32_t thread, std::uint32_t threads) {
            f(static_cast<std::uint32_t>(n * thread / threads), static_cast<std::uint32_t>(n * (thread + 1) / threads));
        });
    }
    void end_frame() noexcept { halfway_ = false; }

    bool keeps_trace() const noexcept
    {
        if constexpr (requires { engine_.trace; })
            return traced && engine_.trace;
        else
            return traced;
    }
    /// The trace of the last frame. Throws Error if the engine's options say that the mesh keeps none.
    Trace const& trace() const
        requires(traced)
    {
        return keeps_trace() ? trace_.of(mesh_->trace()) : mesh_->trace();
    }

protected:
    template <class... Arguments>
    void make_mesh(Arguments const&... arguments)
    {
        mesh_.emplace(arguments...);
        ran_ = false;
    }
    /// `step(f)` runs f, which may run out of memory.
    template <class Step>
    void begin_frame_in([[maybe_unused]] Step const& step)
    {
        halfway_ = true;
        if constexpr (traced) {
            if (!keeps_trace()) return;
            if (ran_)
                step([&] { trace_.begin(&mesh_->trace()); });
            else
                trace_.begin(nullptr);
        }
    }
    template <class Step>
    RunCounters run_in([[maybe_unused]] Step const& step)
    {
        if constexpr (traced)
            if (keeps_trace() && ran_) step([&] { trace_.before(mesh_->trace()); });
        engine::Raised const running(running_);
        auto counters = mesh_->run();
        ran_ = true;
        if constexpr (traced)
            if (keeps_trace()) step([&] { trace_.after(mesh_->trace()); });
        return counters;
    }

    EngineOptions engine_;
    std::optional<MeshType> mesh_; ///< no memory of its own, which one of several processes may lack
    Observer observer_;
    bool ordered_ = false; ///< the records have the order that the renderer asked for

private:
    bool halfway_ = false, ran_ = false; ///< a frame began and did not end; this mesh ran
    bool running_ = false;               ///< the program, so that observers may call
    [[no_unique_address]] std::conditional_t<traced, engine::JoinedTrace, engine::NoTrace> trace_;
};

/// The host of a mesh does what every renderer does between two runs, whatever its program. It checks views, builds the mesh, shares work
/// among threads, adds up what tiles counted, lists what they lack, and copies pictures.
///
/// All tiles are in this process. A mesh over several processes has a Host of its own with the same members (render/ranks/host.hpp). There,
/// "all tiles" are those of all processes, and in `step` they agree that none has failed.
///
/// A frame is `view_of`, `build` if there is no mesh that fits, `begin_frame`, the renderer's own work, `run`, `picture`, and `end_frame`. If an
/// exception comes between, the next frame begins without a mesh, because the host and the tiles may have different views.
template <class MeshType, class Machine>
class Host : public HostOfMesh<MeshType, Machine> {
    using Base = HostOfMesh<MeshType, Machine>;
    using Base::engine_, Base::mesh_, Base::observer_, Base::ordered_;
    static_assert(!over_ranks<MeshType>, "a renderer on an engine over several processes, without its host; include "
                                         "<tilemesh/render/ranks/host.hpp>");

public:
    using Records = RecordTable;
    static constexpr bool has_one_memory = true; ///< a tile may point to a table of the host

    using Base::Base, Base::traced;

    /// Names the renderer: the words that its pictures and reports depend on, with those of `records`.
    void identify(Records const&, RendererOptions const& options, std::initializer_list<std::uint32_t>)
    {
        if (options.rows_of_all_parts != 0)
            throw Error("a part of a map on an engine of one process (the other parts would be missing); load the whole map");
    }
    /// The view of a camera. Throws Error for a camera or rules that no frame can be rendered with. `check(view)` may refuse more.
    template <class Check>
    splat::View view_of(splat::Camera const& camera, splat::Rules const& rules, Check const& check)
    {
        this->drop_halfway();
        check_camera(camera);
        check_rules(rules);
        auto const view = splat::make_view(camera, rules);
        check(view);
        return view;
    }

    /// Builds the mesh that `plan()` describes. `first`: the view for which it is built, if that is known.
    template <class Plan>
    void build(RendererOptions const& options, Records&, Plan const& plan, splat::View const* /*first*/ = nullptr, splat::Tiling const& = {})
    {
        auto const p = plan();
        set_engine_options<traced>(options, engine_);
        this->make_mesh(p.program, p.grid, p.sizes, engine_);
        if (observer_) mesh_->observe(observer_);
    }
    /// Puts the records into another order, once: row r becomes row place_of(r). `Record`: a record that has room for a row.
    template <class Record, class PlaceOf>
    void reorder(Records& records, PlaceOf const& place_of)
    {
        if (!std::exchange(ordered_, true)) records.reorder(place_of);
    }

    /// A step of the host's work, which may run out of memory.
    template <class F>
    void step(F const& f)
    {
        f();
    }
    /// Is tile t in this process?
    bool has(TileId) const noexcept { return true; }
    /// Calls f(tile) for each tile.
    template <class F>
    void each_tile(F const& f)
    {
        for (TileId const tile : mesh_->grid().tiles()) f(tile);
    }
    /// Gives things to tiles, one after another: next = f(next), where f goes over the tiles.
    template <class F>
    std::uint64_t in_turn(std::uint64_t next, F const& f)
    {
        return f(next);
    }
    /// The sums over all tiles: `add(sums)` adds up what they counted. `Sums` consists of words of 64 bits.
    template <class Sums, class F>
    Sums total(F const& add)
    {
        Sums sums{};
        add(sums);
        return sums;
    }
    /// The largest of these words over all tiles; `here` are those of the tiles of this process.
    template <std::size_t N>
    void most(std::uint64_t (&)[N])
    {
    }
    /// Is it so on some tile?
    bool any(bool here) { return here; }
    /// What `add(items)` lists, in the order of tiles.
    template <class T, class F>
    std::vector<T> list(F const& add)
    {
        std::vector<T> items;
        add(items);
        return items;
    }

    /// Records on their way to tiles. `record(make, id)`: what a tile stores at first for the record with this id, which `make()` makes.
    /// `took`: a tile took a slot for a row. `finish` calls put(tile, slot, record) for the records that came later.
    template <class Record>
    struct Loading {
        template <class Make>
        Record record(Make const& make, splat::GaussianId) const
        {
            return make();
        }
        void took(std::uint32_t, TileId, std::uint32_t) const noexcept {}
    };
    template <class Record, class Put>
    void finish(Loading<Record>&, Records const&, Put const&)
    {
    }
    /// Sends items to tiles. `send_all(send)` calls send(tile, item) for items in the order of rows; `put(tile, item)` is called where the
    /// tile is, in the same order.
    template <class Item, class SendAll, class Put>
    void to_tiles(SendAll const& send_all, Put const& put)
    {
        send_all(put);
    }
    /// Every process has the items that each of them found for its tiles, in this order.
    template <class T, class Before>
    void everywhere(std::vector<T>&, Before const&)
    {
    }
    /// Deals n items of this process to the tiles in even shares: `first_of(all, tile)` is the first of a tile's share, `item(i)` makes the
    /// i-th one, and `fill(tile, all, next)` takes them.
    template <class Item, class FirstOf, class Make, class Fill>
    void deal(std::uint64_t n, FirstOf const&, Make const& item, Fill const& fill)
    {
        std::uint32_t at = 0;
        for (TileId const tile : mesh_->grid().tiles()) fill(tile, n, [&] { return item(at++); });
    }
    /// The keys number `done` and `done + n` in ascending order, or `no_key`. Call it with ascending ranges, because it sorts as it goes.
    struct KeyRange {
        std::uint64_t from, to;
    };
    static constexpr std::uint64_t no_key = ~std::uint64_t{0}; ///< behind all keys
    KeyRange range_of(std::vector<std::uint64_t>& keys, std::uint64_t done, std::uint64_t n)
    {
        auto const first = keys.begin() + static_cast<std::ptrdiff_t>(done), last = first + static_cast<std::ptrdiff_t>(n);
        if (last != keys.end()) std::nth_element(first, last, keys.end());
        return {n == 0 ? 0 : *std::min_element(first, last), last != keys.end() ? *last : no_key};
    }

    /// What the picture lacks: fills the report's list of losses. Returns the rows that no tile owns.
    template <class P>
    NotOnTiles losses(LossQuestion const& question, Records const& records, report::FrameReport& report)
    {
        auto off = list_losses(question, ScreenRows(records), MeshFacts(fact_lists<P>(*this)), report);
        off.missing_ids.clear(); // the table has them
        return off;
    }
    /// Copies the tiles' framebuffers into one picture, with the planes that the setup has, on all threads.
    template <class P>
    void picture(Setup const& setup, splat::Tiling const& tiling, splat::Camera const& camera, RenderedFrame& to)
    {
        size_planes(camera, setup.depth, setup.alpha, to);
        copy_picture<P>(*mesh_, setup, tiling, camera, 0, tiling.rows, to);
    }
    /// Lets `copy()` make a picture of the states X of all tiles.
    template <class X, class F>
    void picture_of(RenderedFrame&, F const& copy)
    {
        copy();
    }

    /// Begins a frame, and runs the program. A frame may run it more than once.
    void begin_frame()
    {
        this->begin_frame_in([&](auto const& f) { step(f); });
    }
    RunCounters run()
    {
        return this->run_in([&](auto const& f) { step(f); });
    }
    /// The trace of all tiles.
    Trace gather_trace()
        requires(traced)
    {
        return this->trace();
    }
};

}}} // namespace tilemesh::render
