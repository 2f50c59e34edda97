#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <tilemesh/engine/mesh_options.hpp>
#include <tilemesh/engine/port.hpp>
#include <tilemesh/engine/run.hpp>
#include <tilemesh/engine/store.hpp>
#include <tilemesh/engine/team.hpp>
#include <tilemesh/engine/tile_set.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

namespace engine::detail {

/// The broken contracts that run() reports: the first one of the lowest tile, and their number on all tiles.
struct Failure {
    std::uint32_t tile = 0xffffffffu;
    char const* text = nullptr;
    std::uint64_t count = 0;

    void add(Failure const& other) noexcept
    {
        auto const all = count + other.count;
        if (other.tile < tile) *this = other;
        count = all;
    }
};

/// Both banks of a channel on the host. The exchange swaps them. A sender writes the head of its neighbour's end: size, note, and the
/// address of the messages.
///
/// The messages that tiles send to one side follow one another in memory, in the order in which a thread runs the tiles. So a superstep
/// reads four streams and writes four, whose length is that of the live messages, for any capacity. A thread begins a stream for each of
/// its pieces of the tiles, at the place of the piece's first tile if every tile had room for its capacity.
struct Bank {
    static constexpr std::uint32_t head_words = 4;
    Arena heads[2];
    Arena items[2];
    std::size_t stride = 0;      ///< words for the capacity of one end
    std::uint32_t capacity = 0;
};

} // namespace engine::detail

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
class Mesh : public engine::TileStore<Program, false> {
    static_assert(is_machine<Machine>, "no machine (it has the members name, tiles, sram_bytes, code_bytes, workers and clock_khz, as "
                                       "Mk2 has); look for a misspelt one; a setup is not one: give its Machine");
    using Base = engine::TileStore<Program, false>;
    using Bank = engine::detail::Bank;
    using TileSet = engine::detail::TileSet;
    using Run = engine::Run<Program, is_traced<Machine>>;
    using KernelFacts = engine::KernelFacts;
    friend Run;

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
        : Base(program, grid, sizes), options_(options), rectangle_{0, 0, grid.width, grid.height},
          active_(grid.size()), shares_(checked_threads(options)),
          workers_(checked_threads(options)), team_(checked_threads(options))
    {
        if constexpr (traced)
            if (options.trace) run_.keep_trace();
        slots_.resize(std::size_t{grid.size()} * 4);
        for (std::uint32_t i = 0; i < grid.size(); ++i)
            for (Direction d : news) {
                auto const t = grid.tile(i);
                slots_[4 * std::size_t{i} + index(d)] =
                    4 * grid.index_of(grid.neighbour(t, d)) + index(grid.arrival(t, d));
            }
        make_slots();
        tiles_.resize(grid.size());
        for (std::uint32_t l = 0; l < Links::count; ++l) make_bank(l);
        for (auto& w : workers_) {
            w.busy = TileSet(grid.size());
            w.mail.fill(TileSet(grid.size()));
        }
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
        return typename C::Receiver{ends<C>().in(4 * this->grid_.index_of(t) + index(d))};
    }

    /// As `incoming`, by the tile's index and as a place (engine/port.hpp).
    template <class C>
    machine::Place incoming_place(std::uint32_t tile, Direction d) noexcept
    {
        return ends<C>().in(4 * tile + index(d));
    }

    /// From now on Superstep and Repeat run only the tiles of columns x0 to x1 - 1 and rows y0 to y1 - 1, and those other tiles that voted
    /// busy or have mail for the kernel. Idle tiles outside cost nothing. The caller promises that on the other tiles the kernels would
    /// change no word, send nothing and vote quiet; CheckedMesh checks this. At first the rectangle is the whole grid. Throws Error for a
    /// rectangle that is not in the grid.
    void run_within(std::uint32_t x0, std::uint32_t y0, std::uint32_t x1, std::uint32_t y1)
    {
        rectangle_ = engine::checked_rectangle(this->grid_, {x0, y0, x1, y1});
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
        for (auto& w : workers_) w.begin();
        return run_.all(*this, this->program_, this->grid_, {options_.most_passes, options_.digest, options_.explain}, [this] {
            return peaks();
        });
    }

protected: // for an engine that runs a part of the grid's rows
    static constexpr bool traced = is_traced<Machine>;
    using Failure = engine::detail::Failure;

    std::vector<engine::Peak> peaks() const
    {
        std::array<std::uint32_t, States::count + 1> state_peak{};
        std::array<std::uint32_t, links> link_peak{};
        for (auto const& w : workers_) {
            for (std::uint32_t s = 0; s < States::count; ++s) state_peak[s] = std::max(state_peak[s], w.state_peak[s]);
            for (std::uint32_t l = 0; l < Links::count; ++l) link_peak[l] = std::max(link_peak[l], w.link_peak[l]);
        }
        return engine::list_peaks(this->view(), state_peak.data(), link_peak.data());
    }

    /// Up to this many tiles, the thread that walks the program runs alone. To run a tile takes 20 ns to 1 us, and to involve another
    /// thread takes 0.2 us. The words of the tiles may also have to come from the first thread's cache.
    static constexpr std::uint32_t most_tiles_of_one_thread = 8;

    static std::uint32_t checked_threads(Options const& options)
    {
        if (options.threads > 1024)
            throw Error(std::to_string(options.threads) + " threads (a mesh runs on at most 1,024); ask for fewer");
        return std::max(options.threads, 1u);
    }

    static constexpr std::uint32_t links = Links::count + 1;
    static constexpr bool skips = distance_of(Links{}) != 1; ///< has the program a channel that skips tiles?
    static_assert(distance_of(Links{}) != 0, "channels that skip tiles by two distances in one program (a mesh has one table of their "
                                             "readers); give them one distance");
    /// One thread's part of a superstep.
    struct alignas(64) WorkerState {
        std::uint64_t messages = 0, live_bytes = 0, runs = 0, digest = 0;
        [[no_unique_address]] std::conditional_t<traced, std::vector<TileSample>, engine::NoTrace> samples;
        [[no_unique_address]] std::conditional_t<traced && skips, std::vector<FarSample>, engine::NothingFar> far;
        engine::detail::Failure failure;
        TileSet busy;                                       ///< tiles that voted busy
        std::array<TileSet, links> mail;                    ///< tiles that got a message on a channel
        std::array<std::uint32_t, States::count + 1> state_peak{};
        std::array<std::uint32_t, links> link_peak{};
        std::exception_ptr thrown;                          ///< exception of a function of on_threads; on a Traced machine, of a sample

        void begin() noexcept
        {
            busy.clear();
            state_peak.fill(0);
            link_peak.fill(0);
        }
    };

    /// Both ends of a channel on all tiles, in one superstep. The exchange swaps them.
    struct Ends {
        std::uint32_t *in_heads, *out_heads, *out_items;
        std::size_t stride;
        std::uint32_t capacity;
        TILEMESH_KERNEL machine::Place in(std::uint32_t slot) const noexcept
        {
            auto* const head = in_heads + Bank::head_words * std::size_t{slot};
            std::uint32_t* items;
            std::memcpy(&items, head + 2, sizeof items);
            return {head, items, capacity};
        }
        TILEMESH_KERNEL std::uint32_t* out_head(std::uint32_t slot) const noexcept
        {
            return out_heads + Bank::head_words * std::size_t{slot};
        }
    };
    static_assert(sizeof(std::uint32_t*) <= 8, "an address fits into two words of a head");
    Ends ends(std::uint32_t link) const noexcept
    {
        auto const& b = banks_[link];
        auto const out = bank_[link], in = out ^ 1u;
        return {b.heads[in].data(), b.heads[out].data(), b.items[out].data(), b.stride, b.capacity};
    }
    template <class C>
    Ends ends() const noexcept
    {
        return ends(Base::template index_of_link<C>);
    }
    std::array<Ends, links> all_ends() const noexcept
    {
        std::array<Ends, links> all{};
        for (std::uint32_t l = 0; l < Links::count; ++l) all[l] = ends(l);
        return all;
    }

    /// The source that this interpreter gives to run_kernel.
    struct Source {
        Mesh& mesh;
        WorkerState& me;
        std::array<Ends, links> const links_now;
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
        auto const at = 4 * std::size_t{tile} + index(d);
        if constexpr (C::distance != 1) return far_[at];
        return C::edge == Edge::reflect ? slots_[at] : C::edge == Edge::wrap ? wrapping_[at] : dropping_[at];
    }
    /// The place at which what a tile sends on a channel is read.
    std::uint32_t slot_of(std::uint32_t link, std::uint32_t tile, Direction d) const noexcept
    {
        auto const& c = engine::link_table<Program>.at[link];
        auto const at = 4 * std::size_t{tile} + index(d);
        if constexpr (skips)
            if (c.distance != 1) return far_[at];
        return c.edge == Edge::reflect ? slots_[at] : c.edge == Edge::wrap ? wrapping_[at] : dropping_[at];
    }
    /// Fills the tables of places for channels whose edges do not reflect. Messages that an edge drops go to a place after those of all
    /// tiles. Each such side has its own place, and nobody reads it.
    void make_slots()
    {
        auto const grid = this->grid_;
        auto const make = [&](std::vector<std::uint32_t>& slots, Edge edge) {
            auto bin = 4 * grid.size();
            for (TileId const t : grid.tiles())
                for (Direction d : news)
                    slots.push_back(grid.delivers(t, d, edge) ? 4 * grid.index_of(grid.neighbour(t, d, edge)) + index(grid.arrival(t, d, edge))
                                                              : bin++);
        };
        if constexpr (skips) {
            auto bin = 4 * grid.size();
            for (TileId const t : grid.tiles())
                for (Direction d : news)
                    far_.push_back(grid.reaches(t, d, distance_of(Links{}))
                                       ? 4 * grid.index_of(grid.tile_at(t, d, distance_of(Links{}))) + index(opposite(d))
                                       : bin++);
        }
        bool drops = false, wraps = false;
        for (std::uint32_t l = 0; l < Links::count; ++l) {
            auto const edge = engine::link_table<Program>.at[l].edge;
            drops = drops || edge == Edge::drop;
            wraps = wraps || edge == Edge::wrap;
        }
        if (drops) make(dropping_, Edge::drop);
        if (wraps) make(wrapping_, Edge::wrap);
    }

    void make_bank(std::uint32_t l)
    {
        auto& b = banks_[l];
        auto const& c = engine::link_table<Program>.at[l];
        auto const bins = c.edge == Edge::drop ? 2 * (std::size_t{this->grid_.width} + this->grid_.height) * c.distance : 0;
        auto const n = std::size_t{this->grid_.size()} * 4;
        auto const capacity = this->link_capacity_[l];
        auto const most = this->view().gets_slots_by_limit(l) ? capacity : this->sizes_.links[l].slots;
        auto const stride = ((std::size_t{most} * c.item_words + 15u) & ~std::size_t{15}) | 16u;
        for (auto& heads : b.heads)
            if (heads.data() == nullptr) heads = engine::Arena((n + bins) * Bank::head_words);
        if (stride != b.stride) {
            engine::Arena items[2] = {engine::Arena(std::uint64_t{n} * stride), engine::Arena(std::uint64_t{n} * stride)};
            for (int i : {0, 1}) b.items[i] = std::move(items[i]);
        }
        b.capacity = capacity;
        b.stride = stride;
    }
    void limit_link(std::uint32_t l, std::uint32_t items)
    {
        auto const before = this->link_capacity_[l];
        this->view().limit_link(l, items, has_mail(l));
        try {
            make_bank(l);
        } catch (...) { // out of memory: the channel keeps its old capacity
            this->link_capacity_[l] = before;
            throw;
        }
    }

    // --- one tile -------------------------------------------------------------------------------------------------------
    template <class Kernel>
    TILEMESH_KERNEL void run_tile(Source& source, std::uint32_t tile) noexcept
    {
        source.tile = tile;
        source.slots = slots_.data() + 4 * std::size_t{tile};
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
    /// Throws the exception of the lowest thread of the team that has one.
    void rethrow()
    {
        std::exception_ptr first;
        for (auto& w : workers_) {
            if (!first) first = w.thrown;
            w.thrown = nullptr;
        }
        if (first) std::rethrow_exception(first);
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
            auto& peak = source.me.state_peak[Base::template index_of_state<X>];
            peak = std::max(peak, source.template state<X>().head[0]);
        }
    }
    template <class C>
    TILEMESH_KERNEL void after(Source& source, In<C>*) noexcept // mail is read once
    {
        auto* const heads = source.template in<C>(news[0]).head; // the heads of the four sides are contiguous
        std::uint32_t any = 0;
        for (std::uint32_t i = 0; i < 4; ++i) any |= heads[Bank::head_words * i] | heads[Bank::head_words * i + 1];
        if (any == 0) return;
        for (std::uint32_t i = 0; i < 4; ++i) heads[Bank::head_words * i] = heads[Bank::head_words * i + 1] = 0;
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
                    me.link_peak[l] = std::max(me.link_peak[l], n);
                    head[0] = head[1] = 0;
                    continue;
                }
            source.next[l][index(d)] += std::size_t{n} * C::Sender::item_words;
            me.mail[l].insert(source.template slot<C>(d) / 4);
            me.messages += n;
            me.live_bytes += std::uint64_t{n} * this->template message_bytes<C>();
            me.link_peak[l] = std::max(me.link_peak[l], n);
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

    // --- a part of the grid's rows --------------------------------------------------------------------------------------
    /// What a tile sent towards d in a superstep whose exchange has not flipped the banks yet.
    machine::Place sent(std::uint32_t link, std::uint32_t tile, Direction d) const noexcept
    {
        auto const now = ends(link);
        auto* const head = now.out_head(slot_of(link, tile, d));
        std::uint32_t* items;
        std::memcpy(&items, head + 2, sizeof items);
        return {head, items, now.capacity};
    }
    /// Puts what a tile that runs elsewhere sent towards d where it is read, before the exchange flips the banks. `head`: size and note. No
    /// stream of this mesh reaches the messages' place, because it is that of the other tile.
    void deliver(std::uint32_t link, std::uint32_t from, Direction d, std::uint32_t const* head, std::uint32_t const* items) noexcept
    {
        auto const now = ends(link);
        auto* const place = now.out_items + (std::size_t{index(d)} * this->grid_.size() + from) * now.stride;
        auto* const to = now.out_head(slot_of(link, from, d));
        std::memcpy(place, items, std::size_t{head[0]} * engine::link_table<Program>.at[link].item_words * 4);
        std::memcpy(to + 2, &place, sizeof place);
        to[0] = head[0];
        to[1] = head[1];
        workers_[0].mail[link].insert(slot_of(link, from, d) / 4);
    }

    // --- one superstep --------------------------------------------------------------------------------------------------
    bool has_mail(std::uint32_t link) const noexcept
    {
        for (auto const& w : workers_)
            if (!w.mail[link].empty()) return true;
        return false;
    }
    bool mail_to_read(KernelFacts const& kernel) const noexcept
    {
        for (auto const& use : links_of(kernel))
            if (use.reads && has_mail(use.link)) return true;
        return false;
    }
    static constexpr char const* over_unread = "a kernel sends on a channel with unread mail (a bound cut the step that reads it); raise "
                                               "the bound, or let the sending kernel read the channel";
    bool sends_over_unread(KernelFacts const& kernel) const noexcept
    {
        for (auto const& use : links_of(kernel))
            if (use.writes && !use.reads && has_mail(use.link)) return true;
        return false;
    }
    bool sent_anything(KernelFacts const& kernel) const noexcept
    {
        for (auto const& use : links_of(kernel))
            if (use.writes && has_mail(use.link)) return true;
        return false;
    }
    /// Calls `f` with each set of tiles that a kernel wakes: those that voted busy, and those with mail for it.
    template <class F>
    void for_each_waking_set(KernelFacts const& kernel, F const& f) noexcept
    {
        for (auto& w : workers_) {
            f(w.busy);
            for (auto const& use : links_of(kernel))
                if (use.reads) f(w.mail[use.link]);
        }
    }
    void flip(KernelFacts const& kernel) noexcept
    {
        for (auto const& use : links_of(kernel)) bank_[use.link] ^= 1u;
    }

    /// Runs worker w's part of the n tiles with one kernel: `run_tiles<Kernel>`.
    using RunTiles = void (*)(Mesh& mesh, std::uint32_t w, std::uint32_t const* tiles, std::uint32_t n, bool together) noexcept;
    template <class Kernel>
    static void run_tiles_of(Mesh& mesh, std::uint32_t w, std::uint32_t const* tiles, std::uint32_t n, bool together) noexcept
    {
        mesh.template run_tiles<Kernel>(w, tiles, n, together);
    }
    /// Runs worker w's part of the n tiles: the listed tiles, or all tiles without a list.
    template <class Kernel>
    void run_tiles(std::uint32_t w, std::uint32_t const* tiles, std::uint32_t n, bool together) noexcept
    {
        using Arguments = typename KernelTraits<Kernel>::Arguments;
        auto& me = workers_[w];
        engine::detail::BrokenContracts broken;
        engine::detail::tilemesh_broken_contracts = &broken;
        Source source{*this, me, all_ends(), nullptr, 0, {0, 1}, keeps_trace(), {}};
        std::uint32_t first = 0, last = n;
        for (bool more = together ? shares_.take(w, first, last) : n != 0; more; more = together && shares_.take(w, first, last)) {
            begin_piece(source, tiles == nullptr ? first : tiles[first], Arguments{});
            for (auto i = first; i < last; ++i) {
                if (i + 4 < last) prefetch_heads(source, tiles == nullptr ? i + 4 : tiles[i + 4], Arguments{});
                if (i + 2 < last) prefetch(source, tiles == nullptr ? i + 2 : tiles[i + 2], Arguments{});
                if constexpr (KernelTraits<Kernel>::Links::count == 0)
                    if (i + 1 < last) prefetch_lists(tiles == nullptr ? i + 1 : tiles[i + 1], Arguments{});
                auto const tile = tiles == nullptr ? i : tiles[i];
                run_tile<Kernel>(source, tile);
                if (broken.count != 0) [[unlikely]] {
                    me.failure.add({tile, broken.first, broken.count});
                    broken = {};
                }
            }
            me.runs += last - first;
        }
        engine::detail::tilemesh_broken_contracts = nullptr; // the next function on this thread may not be a kernel
    }

    /// Runs n tiles: the calling thread alone if they are at most `most_alone`, otherwise the team.
    void run_on_team(RunTiles run_part, std::uint32_t const* tiles, std::uint32_t n, std::uint32_t most_alone) noexcept
    {
        if (team_.size() > 1 && n > most_alone) {
            shares_.set(n);
            team_.share([&](std::uint32_t w) noexcept { run_part(*this, w, tiles, n, true); });
        } else {
            run_part(*this, 0, tiles, n, false);
        }
    }
    /// Adds up what the threads counted in a superstep, and appends to the trace. Returns the broken contracts. Throws the exception of a
    /// sample, and std::bad_alloc.
    Failure collect(KernelFacts const& kernel, engine::Passed& passed)
    {
        Failure failure;
        for (auto& w : workers_) {
            passed.messages += std::exchange(w.messages, 0);
            passed.tile_runs += std::exchange(w.runs, 0);
            passed.live_bytes += std::exchange(w.live_bytes, 0);
            failure.add(w.failure);
        }
        if constexpr (traced)
            if (keeps_trace()) [[unlikely]]
                append_sample({run_.step(), engine::program_facts<Program>.step[run_.step()].votes, this->view().capacity_a_side(kernel),
                               passed.sent, {}, kernel.edge, this->view().absent_a_side(kernel), kernel.distance, {}});
        return failure;
    }
    bool keeps_trace() const noexcept
    {
        if constexpr (traced)
            return run_.trace != nullptr;
        else
            return false;
    }
    /// Appends a superstep with the samples of all threads to the trace. Throws the exception of a sample, and std::bad_alloc.
    [[gnu::noinline, gnu::cold]] void append_sample(SuperstepSample s)
    {
        rethrow();
        if constexpr (traced) {
            for (auto& w : workers_) {
                s.tiles.insert(s.tiles.end(), w.samples.begin(), w.samples.end());
                w.samples.clear();
                if constexpr (skips) {
                    s.far.insert(s.far.end(), w.far.begin(), w.far.end());
                    w.far.clear();
                }
            }
            if constexpr (skips) std::sort(s.far.begin(), s.far.end(), [](auto const& a, auto const& b) { return a.tile < b.tile; });
            std::sort(s.tiles.begin(), s.tiles.end(), [](auto const& a, auto const& b) { return a.tile < b.tile; });
            run_.trace->supersteps.push_back(std::move(s));
        }
    }

    bool any_busy() const noexcept
    {
        return std::any_of(workers_.begin(), workers_.end(), [](auto const& w) { return !w.busy.empty(); });
    }
    /// One superstep on all tiles, or on the tiles that must run. Does nothing if no tile must run.
    template <class Kernel, bool All>
    engine::Passed superstep()
    {
        return superstep(engine::kernel_facts<Program, Kernel>, All, run_tiles_of<Kernel>);
    }
    engine::Passed superstep(KernelFacts const& kernel, bool everywhere, RunTiles run_part)
    {
        auto n = this->grid_.size();
        bool const all = everywhere && rectangle_.covers(this->grid_);
        if (all) {
            for_each_waking_set(kernel, [](TileSet& set) { set.clear(); });
        } else {
            if (!everywhere && !any_busy() && !mail_to_read(kernel)) return {};
            for_each_waking_set(kernel, [&](TileSet& set) { active_.take(set); });
            if (everywhere)
                for (auto y = rectangle_.y0; y < rectangle_.y1; ++y)
                    active_.insert(y * this->grid_.width + rectangle_.x0, y * this->grid_.width + rectangle_.x1);
            n = active_.list(tiles_.data());
        }
        auto const* const tiles = all ? nullptr : tiles_.data();
        if (sends_over_unread(kernel)) throw run_.failed(this->grid_, 0, over_unread);
        run_on_team(run_part, tiles, n, everywhere ? 1 : most_tiles_of_one_thread);

        engine::Passed passed;
        passed.ran = true;
        passed.sent = sent_anything(kernel);
        flip(kernel);
        auto const failure = collect(kernel, passed);
        if (failure.count != 0) throw run_.failed(this->grid_, failure.tile, failure.text, failure.count);
        return passed;
    }

    std::uint64_t digest_now() noexcept { return digest_of(0, this->grid_.size()); }
    /// The sum of the digests of tiles begin..end-1.
    std::uint64_t digest_of(std::uint32_t begin, std::uint32_t end) noexcept
    {
        auto const all = all_ends();
        auto const store = this->view();
        shares_.set(end - begin);
        team_.share([&](std::uint32_t w) noexcept {
            for (std::uint32_t first = 0, last = 0; shares_.take(w, first, last);)
                for (auto t = begin + first; t < begin + last; ++t)
                    workers_[w].digest += engine::mix(digest_mail(store, all, t), store.digest_states(t));
        });
        std::uint64_t digest = 0;
        for (auto& w : workers_) digest += std::exchange(w.digest, 0);
        return digest;
    }
    static std::uint64_t digest_mail(engine::StoreView const& store, std::array<Ends, links> const& all, std::uint32_t tile) noexcept
    {
        std::uint64_t h = 0;
        for (std::uint32_t l = 0; l < Links::count; ++l)
            if (!store.undigested_links[l])
                for (Direction d : news) h = store.mix_mail(h, l, all[l].in(4 * tile + index(d)));
        return h;
    }

    Options options_;
    std::vector<std::uint32_t> slots_;                  ///< places at which each tile's four outgoing ends are read
    std::vector<std::uint32_t> wrapping_, dropping_;    ///< these places for channels with these edges; empty without such a channel
    [[no_unique_address]] std::conditional_t<skips, std::vector<std::uint32_t>, engine::NothingFar> far_; ///< for channels that skip tiles
    std::array<Bank, links> banks_;
    std::array<std::uint32_t, links> bank_{};           ///< the bank that senders write now
    engine::Rectangle rectangle_;                  ///< Superstep and Repeat run all of its tiles
    TileSet active_;
    std::vector<std::uint32_t> tiles_;                  ///< the tiles that run in this superstep, if not all do
    engine::detail::Shares shares_;
    std::vector<WorkerState> workers_;
    Run run_;
    engine::detail::Team team_;                         ///< last: its threads end before the objects that they use
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
