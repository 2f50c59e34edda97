#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <tilemesh/engine/mesh_core.hpp>
#include <tilemesh/engine/mesh_options.hpp>
#include <tilemesh/engine/port.hpp>
#include <tilemesh/engine/run.hpp>
#include <tilemesh/engine/store.hpp>
#include <tilemesh/engine/team.hpp>
#include <type_traits>
#include <utility>

namespace tilemesh { inline namespace v0_2 {

/// Runs a program on host threads. The thread that calls run() walks the program. In each superstep the other threads take their shares of
/// the tiles that must run; if only a few tiles must run, the calling thread runs them alone. Pictures, counters and digests do not depend
/// on the number of threads, and equal those of CheckedMesh.
///
/// If a multi-worker kernel has a nested `AllWorkers`, the mesh runs that (see Worker).
///
/// Cost: idle tiles and empty channels cost nothing in a superstep, except one word for each 4,096 tiles. Memory follows live items.
/// Between runs a mesh keeps its states, and the mail that a bound (`at_most`) left under way.
///
/// Errors: the constructor and `limit` throw Error for a machine that is too small, and the constructor for a program with the counts of
/// another grid (`SequenceOn`). `run` throws Error for broken contracts (TILEMESH_EXPECT) and for a step that exceeds `most_passes`. An
/// observer's exception passes through. Out of memory, it throws std::bad_alloc. After an exception the mesh refuses to run again.
///
/// Broken contracts end the run after their superstep, in every build, because a program that waits for an item that a full list refused
/// would never end. The Error has the text of the first broken contract of the lowest tile, the tile, the superstep, and the number of
/// broken contracts on all tiles.
template <class Program, class Machine = Mk2>
class Mesh : public engine::TileStore<Program, false>, protected engine::MeshCore {
    static_assert(is_machine<Machine>, "no machine (it has the members name, tiles, sram_bytes, code_bytes, workers and clock_khz, as "
                                       "Mk2 has); look for a misspelt one; a setup is not one: give its Machine");
    using Base = engine::TileStore<Program, false>;
    using Core = engine::MeshCore;

public:
    using typename Base::Links;
    using typename Base::States;
    using typename Base::Sizes;
    using Options = MeshOptions;

    /// A mesh of `Machine`, for a program whose lists all have the capacity that their types name.
    Mesh(Program program, Grid grid, Options options = {})
        : Mesh(program, grid, mesh_sizes<Program, Machine>(), options)
    {
    }
    /// The constructor above, with a value of type `Machine`, so that the compiler deduces it:
    /// `Mesh mesh{program, Grid{8, 8}, Traced<Mk2>{}}`.
    template <std::same_as<Machine> M>
    Mesh(Program program, Grid grid, M, Options options = {}) : Mesh(program, grid, options)
    {
    }
    /// A mesh with the machine and the slots of `sizes`.
    template <std::same_as<Sizes> S>
    Mesh(Program program, Grid grid, S const& sizes, Options options = {})
        : Base(program, grid, sizes), Core(this->view(), options.threads), options_(options)
    {
        if constexpr (traced)
            if (options.trace) run_.keep_trace();
    }
    Mesh(Mesh const&) = delete;
    Mesh& operator=(Mesh const&) = delete;

    /// Limits this buffer to `items` items, or this channel to `items` slots, on every tile. The limit may be at most the slots with which
    /// the mesh was built. For a channel that gets its slots only by `limit`, it may be at most the slots that fit the SRAM.
    template <class X>
    void limit(std::uint32_t items)
    {
        if constexpr (is_channel<X>)
            limit_link(Base::template index_of_link<X>, items);
        else
            this->view().limit_state(Base::template index_of_state<X>, items);
    }

    /// The messages that tile t will read on channel C from side d when a kernel next takes In<C>. Call it only between runs, or from an
    /// observer.
    template <class C>
    typename C::Receiver incoming(TileId t, Direction d) noexcept
    {
        return typename C::Receiver{incoming_place(Base::template index_of_link<C>, this->grid_.index_of(t), d)};
    }

    /// As `incoming` and `limit`, with the number of a channel and of a tile (engine/port.hpp).
    machine::Place incoming_place(std::uint32_t link, std::uint32_t tile, Direction d) noexcept { return Core::ends(link).in(4 * tile + index(d)); }
    void limit_link(std::uint32_t link, std::uint32_t items) { Core::limit_link(this->view(), link, items); }

    /// From now on Superstep and Repeat run only the tiles of columns x0 to x1 - 1 and rows y0 to y1 - 1, and those other tiles that voted
    /// busy or have mail for the kernel. Idle tiles outside cost nothing. The caller promises that on the other tiles the kernels would
    /// change no word, send nothing and vote quiet; CheckedMesh checks this. At first the rectangle is the whole grid. Throws Error for a
    /// rectangle that is not in the grid.
    void run_within(std::uint32_t x0, std::uint32_t y0, std::uint32_t x1, std::uint32_t y1)
    {
        this->rectangle_ = engine::checked_rectangle(this->grid_, {x0, y0, x1, y1});
    }

    /// Sets a function that the thread that called run() calls after every superstep.
    void observe(Observer observer) { run_.observer = std::move(observer); }

    /// Runs f(thread, threads) once on each of the mesh's threads, for host work between runs; the caller's thread is thread 0. Returns
    /// when all calls have returned. If calls throw, it throws the exception of the lowest such thread. f must not call the mesh's run() or
    /// on_threads().
    template <class F>
    void on_threads(F const& f)
    {
        team_.each([&](std::uint32_t w) noexcept {
            try {
                f(w, team_.size());
            } catch (...) {
                workers_[w].thrown = std::current_exception();
            }
        });
        rethrow();
    }

    /// The trace of the last run, superstep by superstep; only on a Traced machine. Throws Error if the options say that the mesh keeps none.
    Trace const& trace() const
    {
        static_assert(traced, "a mesh without a trace (its machine is not Traced); build it for Traced<Machine>");
        return run_.kept_trace();
    }

    /// Runs the whole program once.
    RunCounters run()
    {
        this->view().require_capacities();
        this->begin_run();
        run_.begin<traced>(this->program_, this->shareds());
        return Core::run(this->view(), run_, steps(), limits());
    }

protected: // for an engine that runs a part of the grid's rows
    static constexpr bool traced = is_traced<Machine>;
    static constexpr std::uint32_t links = Links::count + 1;
    static_assert(distance_of(Links{}) != 0, "channels that skip tiles by two distances in one program (a mesh has one table of their "
                                             "readers); give them one distance");
    using typename Core::Ends, typename Core::WorkerState;

    /// The source that this interpreter gives to run_kernel.
    struct Source {
        Mesh& mesh;
        WorkerState& me;
        engine::detail::TileSet* mail;                      ///< those of `me`
        std::uint32_t *state_peak, *link_peak;
        std::array<Ends, links> links_now;
        std::uint32_t const* slots;                         ///< places at which neighbours read this tile's four outgoing ends
        std::uint32_t tile;
        Worker share;
        bool const keeps_samples; ///< does the run keep a trace?
        std::array<std::array<std::uint32_t*, 4>, links> next{}; ///< where the messages of this tile go, by channel and side
        /// The place at which the messages that this tile sends towards d are read.
        template <class C>
        TILEMESH_KERNEL std::uint32_t slot(Direction d) const noexcept
        {
            if constexpr (C::edge == Edge::reflect) // which has the distance 1
                return slots[index(d)];
            else
                return mesh.template slot<C>(tile, d);
        }
        template <class X>
        TILEMESH_KERNEL machine::Place state() noexcept
        {
            return mesh.template state_place<X>(tile);
        }
        template <class C>
        TILEMESH_KERNEL machine::Place in(Direction d) noexcept
        {
            return links_now[Base::template index_of_link<C>].in(4 * tile + index(d));
        }
        template <class C>
        TILEMESH_KERNEL machine::Place out(Direction d) noexcept
        {
            constexpr auto l = Base::template index_of_link<C>;
            return {links_now[l].out_head(slot<C>(d)), next[l][index(d)], links_now[l].capacity};
        }
        template <class P>
        TILEMESH_KERNEL P const* shared() noexcept
        {
            return mesh.Base::template shared<P>();
        }
        /// The bytes that an end of C with n messages takes on the machine.
        template <class C>
        std::uint32_t end_bytes(std::uint32_t n) const noexcept
        {
            return mesh.template end_bytes<C>(n);
        }
        TILEMESH_KERNEL Here here() noexcept { return {mesh.grid_.tile(tile), mesh.grid_}; }
        TILEMESH_KERNEL Worker worker() noexcept { return share; }
    };

    template <class C>
    TILEMESH_KERNEL std::uint32_t slot(std::uint32_t tile, Direction d) const noexcept
    {
        return Core::slot(C::edge, C::distance, tile, d);
    }

    // --- one tile -------------------------------------------------------------------------------------------------------
    template <class Kernel>
    TILEMESH_KERNEL void run_tile(Source& source, std::uint32_t tile) noexcept
    {
        source.tile = tile;
        source.slots = this->slots_.data() + 4 * std::size_t{tile};
        using AllWorkers = AllWorkersOf<Kernel>;
        if constexpr (AllWorkers::exists) {
            source.share = {0, this->sizes_.machine.workers};
            (void)run_kernel<typename AllWorkers::type>(source);
        } else if constexpr (KernelTraits<Kernel>::multi_worker) { // one host thread does the shares of all of the tile's workers
            for (std::uint32_t w = 0; w < this->sizes_.machine.workers; ++w) {
                source.share = {w, this->sizes_.machine.workers};
                (void)run_kernel<Kernel>(source);
            }
        } else if (run_kernel<Kernel>(source) == Vote::busy) {
            source.me.busy.insert(tile);
        }
        if constexpr (traced)
            if (source.keeps_samples) [[unlikely]] keep_sample<Kernel>(source);
        after_kernel(source, typename KernelTraits<Kernel>::Arguments{});
    }
    template <class Kernel>
    [[gnu::noinline, gnu::cold]] static void keep_sample(Source& source) noexcept
    {
        try {
            source.me.samples.push_back(engine::sample<Kernel>(source, source.tile));
            engine::sample_far<Kernel>(source, source.tile, source.me.far);
        } catch (...) { // out of memory, perhaps on a helper thread: the superstep rethrows it
            source.me.thrown = std::current_exception();
        }
    }
    template <class... A>
    TILEMESH_KERNEL void after_kernel(Source& source, machine::Types<A...>) noexcept
    {
        (after(source, static_cast<std::remove_reference_t<A>*>(nullptr)), ...);
    }
    template <class X>
    TILEMESH_KERNEL void after([[maybe_unused]] Source& source, X*) noexcept
    {
        if constexpr (is_list<X> && !std::is_const_v<X>) {
            auto& peak = source.state_peak[Base::template index_of_state<X>];
            peak = std::max(peak, source.template state<X>().head[0]);
        }
    }
    template <class C>
    TILEMESH_KERNEL void after(Source& source, In<C>*) noexcept // mail is read once
    {
        auto* const heads = source.template in<C>(news[0]).head; // the heads of the four sides are contiguous
        std::uint32_t any = 0;
        for (std::uint32_t i = 0; i < 4; ++i) any |= heads[Ends::head_words * i] | heads[Ends::head_words * i + 1];
        if (any == 0) return;
        for (std::uint32_t i = 0; i < 4; ++i) heads[Ends::head_words * i] = heads[Ends::head_words * i + 1] = 0;
    }
    template <class C>
    TILEMESH_KERNEL void after(Source& source, Out<C>*) noexcept
    {
        constexpr auto l = Base::template index_of_link<C>;
        auto& me = source.me;
        for (Direction d : news) {
            if constexpr (C::sends_to != Sides::all)
                if (!contains(C::sends_to, d)) continue;
            auto const [head, items, capacity] = source.template out<C>(d);
            auto const n = head[0];
            if ((n | head[1]) == 0) continue;
            std::memcpy(head + 2, &items, sizeof items);
            if constexpr (C::edge == Edge::drop)
                if (source.template slot<C>(d) >= 4 * this->grid_.size()) {
                    source.link_peak[l] = std::max(source.link_peak[l], n);
                    head[0] = head[1] = 0;
                    continue;
                }
            source.next[l][index(d)] += std::size_t{n} * C::Sender::item_words;
            source.mail[l].insert(source.template slot<C>(d) / 4);
            me.messages += n;
            me.live_bytes += std::uint64_t{n} * this->template message_bytes<C>();
            source.link_peak[l] = std::max(source.link_peak[l], n);
        }
    }
    /// Prefetches the words that say where a tile's words are. On a grid larger than the caches they come from memory.
    template <class... A>
    TILEMESH_KERNEL void prefetch_heads([[maybe_unused]] Source const& source, [[maybe_unused]] std::uint32_t tile,
                                        machine::Types<A...>) const noexcept
    {
        (prefetch_head(source, tile, static_cast<std::remove_reference_t<A>*>(nullptr)), ...);
    }
    template <class X>
    TILEMESH_KERNEL void prefetch_head(Source const&, std::uint32_t, X*) const noexcept
    {
    }
    template <class C>
    TILEMESH_KERNEL void prefetch_head(Source const& source, std::uint32_t tile, In<C>*) const noexcept
    {
        __builtin_prefetch(source.links_now[Base::template index_of_link<C>].in(4 * tile).head, 1);
        __builtin_prefetch(this->hot(tile), 1);
    }
    template <class C>
    TILEMESH_KERNEL void prefetch_head(Source const&, [[maybe_unused]] std::uint32_t tile, Out<C>*) const noexcept
    {
        if constexpr (C::edge == Edge::reflect) __builtin_prefetch(slots_.data() + 4 * std::size_t{tile});
    }
    /// Prefetches the words of a tile that will run soon. If it has mail, its channel ends are far apart in memory.
    template <class... A>
    TILEMESH_KERNEL void prefetch([[maybe_unused]] Source const& source, [[maybe_unused]] std::uint32_t tile,
                                  machine::Types<A...>) const noexcept
    {
        [[maybe_unused]] bool mail = false;
        (prefetch_argument(source, tile, mail, static_cast<std::remove_reference_t<A>*>(nullptr)), ...);
    }
    template <class X>
    TILEMESH_KERNEL void prefetch_argument(Source const&, std::uint32_t, bool&, X*) const noexcept
    {
    }
    /// Prefetches the beginnings of a tile's lists, for a kernel that works only on lists. The processor continues from there.
    template <class... A>
    TILEMESH_KERNEL void prefetch_lists([[maybe_unused]] std::uint32_t tile, machine::Types<A...>) noexcept
    {
        (prefetch_list(tile, static_cast<std::remove_cv_t<std::remove_reference_t<A>>*>(nullptr)), ...);
    }
    template <class X>
    TILEMESH_KERNEL void prefetch_list([[maybe_unused]] std::uint32_t tile, X*) noexcept
    {
        if constexpr (is_list<X>) {
            auto const* const items = this->template state_place<X>(tile).items;
            for (std::uint32_t line = 0; line < 4; ++line) __builtin_prefetch(items + 16 * line);
        }
    }
    template <class C>
    TILEMESH_KERNEL void prefetch_argument(Source const& source, std::uint32_t tile, bool& mail, In<C>*) const noexcept
    {
        auto const& ends = source.links_now[Base::template index_of_link<C>];
        for (Direction d : news) {
            auto const p = ends.in(4 * tile + index(d));
            if (p.head[0] == 0) continue;
            mail = true;
            __builtin_prefetch(p.items);
            __builtin_prefetch(p.items + 16);
        }
    }
    template <class C>
    TILEMESH_KERNEL void prefetch_argument(Source const& source, std::uint32_t tile, bool& mail, Out<C>*) const noexcept
    {
        if (!mail) return;
        auto const& ends = source.links_now[Base::template index_of_link<C>];
        for (Direction d : news) __builtin_prefetch(ends.out_head(slot<C>(tile, d)), 1);
    }

    /// Sets where the messages of a piece of the tiles go.
    template <class... A>
    TILEMESH_KERNEL void begin_piece([[maybe_unused]] Source& source, [[maybe_unused]] std::uint32_t first_tile,
                                     machine::Types<A...>) const noexcept
    {
        (begin_stream(source, first_tile, static_cast<std::remove_reference_t<A>*>(nullptr)), ...);
    }
    template <class X>
    TILEMESH_KERNEL void begin_stream(Source&, std::uint32_t, X*) const noexcept
    {
    }
    template <class C>
    TILEMESH_KERNEL void begin_stream(Source& source, std::uint32_t first_tile, Out<C>*) const noexcept
    {
        constexpr auto l = Base::template index_of_link<C>;
        auto const& ends = source.links_now[l];
        for (Direction d : news)
            source.next[l][index(d)] = ends.out_items + (std::size_t{index(d)} * this->grid_.size() + first_tile) * ends.stride;
    }

    // --- one superstep --------------------------------------------------------------------------------------------------
    /// Runs worker w's part of the n tiles: the listed tiles, or all tiles without a list.
    template <class Kernel>
    static void run_tiles(void* mesh, std::uint32_t w, std::uint32_t const* tiles, std::uint32_t n, bool together) noexcept
    {
        using Arguments = typename KernelTraits<Kernel>::Arguments;
        auto& self = *static_cast<Mesh*>(mesh);
        auto& me = self.workers_[w];
        engine::detail::BrokenContracts broken;
        engine::detail::tilemesh_broken_contracts = &broken;
        auto* const peaks = me.state_peaks();
        Source source{self, me, me.mail.data(), peaks, peaks + States::count, {}, nullptr, 0, {0, 1}, self.keeps_trace(), {}};
        for (std::uint32_t l = 0; l < links - 1; ++l) source.links_now[l] = self.ends(l);
        std::uint32_t first = 0, last = n;
        for (bool more = together ? self.shares_.take(w, first, last) : n != 0; more; more = together && self.shares_.take(w, first, last)) {
            self.begin_piece(source, tiles == nullptr ? first : tiles[first], Arguments{});
            for (auto i = first; i < last; ++i) {
                if (i + 4 < last) self.prefetch_heads(source, tiles == nullptr ? i + 4 : tiles[i + 4], Arguments{});
                if (i + 2 < last) self.prefetch(source, tiles == nullptr ? i + 2 : tiles[i + 2], Arguments{});
                if constexpr (KernelTraits<Kernel>::Links::count == 0)
                    if (i + 1 < last) self.prefetch_lists(tiles == nullptr ? i + 1 : tiles[i + 1], Arguments{});
                auto const tile = tiles == nullptr ? i : tiles[i];
                self.template run_tile<Kernel>(source, tile);
                if (broken.count != 0) [[unlikely]] {
                    me.failure.add({tile, broken.first, broken.count});
                    broken = {};
                }
            }
            me.runs += last - first;
        }
        engine::detail::tilemesh_broken_contracts = nullptr; // the next function on this thread may not be a kernel
    }

    template <class... Step>
    static typename Core::RunTiles const* runs_of(machine::Types<Step...>) noexcept
    {
        static constexpr typename Core::RunTiles all[] = {run_tiles<KernelOf<Step>>..., nullptr};
        return all;
    }
    typename Core::Steps steps() noexcept { return {&engine::program_facts<Program>, runs_of(StepsOf<Program>{}), this}; }
    engine::RunState::Limits limits() const noexcept { return {options_.most_passes, options_.digest, options_.explain}; }
    bool keeps_trace() const noexcept
    {
        if constexpr (traced)
            return run_.trace != nullptr;
        else
            return false;
    }
    Options options_;
    engine::RunState run_;
};

template <class Program, class Machine>
    requires(!std::same_as<Machine, MeshOptions>)
Mesh(Program, Grid, Machine, MeshOptions = {}) -> Mesh<Program, Machine>;
template <class Program>
Mesh(Program, Grid, MeshSizes<Program>, MeshOptions = {}) -> Mesh<Program, AnyMachine>;

template <class Program>
std::unique_ptr<engine::Port<Program>> make_threads_port(Program const& program, Grid grid, MeshSizes<Program> const& sizes,
                                                         MeshOptions const& options)
{
    return std::make_unique<engine::PortOver<Mesh<Program, Traced<AnyMachine>>>>(program, grid, sizes, options);
}

}} // namespace tilemesh
