#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/arena.hpp>
#include <tilemesh/engine/rectangle.hpp>
#include <tilemesh/engine/run.hpp>
#include <tilemesh/engine/store_view.hpp>
#include <tilemesh/engine/team.hpp>
#include <tilemesh/engine/tile_set.hpp>
#include <tilemesh/engine/trace.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace engine {

/// A Mesh without the types of its program: channels, threads and supersteps. A function runs a kernel on tiles.
class MeshCore {
public:
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

    /// Both ends of a channel on all tiles, in one superstep. The exchange swaps them.
    struct Ends {
        static constexpr std::uint32_t head_words = 4;
        std::uint32_t *in_heads, *out_heads, *out_items;
        std::size_t stride;
        std::uint32_t capacity;
        TILEMESH_KERNEL machine::Place in(std::uint32_t slot) const noexcept
        {
            auto* const head = in_heads + head_words * std::size_t{slot};
            std::uint32_t* items;
            std::memcpy(&items, head + 2, sizeof items);
            return {head, items, capacity};
        }
        TILEMESH_KERNEL std::uint32_t* out_head(std::uint32_t slot) const noexcept { return out_heads + head_words * std::size_t{slot}; }
    };
    static_assert(sizeof(std::uint32_t*) <= 8, "an address fits into two words of a head");

protected:
    /// Both banks of a channel on the host. The exchange swaps them. A sender writes the head of its neighbour's end: size, note, and the
    /// address of the messages.
    ///
    /// The messages that tiles send to one side follow one another in memory, in the order in which a thread runs the tiles. So a superstep
    /// reads and writes four streams, which are as long as the live messages, for any capacity. A thread takes the tiles in pieces. Their
    /// streams follow one another in a stretch of the thread's own (`stretch`): it begins at the same words in every superstep, so few
    /// pages are ever touched. If the stretch might not have room for a piece whose channels are all full, the piece's stream starts where its
    /// first tile would store its messages if every tile had memory for the full capacity (`stride` words). A bank has both: the memory of
    /// all tiles, then the stretches.
    struct Bank {
        Arena heads[2];
        Arena items[2];
        std::size_t stride = 0;      ///< words for the capacity of one end
        std::size_t stretch_words = 0;
        std::size_t of_tiles = 0;    ///< words before the stretches
        /// Where thread w's messages to side d begin in every superstep; there are `stretch_words` for them.
        std::uint32_t* stretch(std::uint32_t w, Direction d) const noexcept
        {
            return items[now].data() + of_tiles + (4 * std::size_t{w} + index(d)) * stretch_words;
        }
        std::uint32_t capacity = 0;
        std::uint32_t now = 0;       ///< the bank that senders write
    };
    /// One thread's part of a superstep.
    struct alignas(64) WorkerState {
        WorkerState(std::uint32_t tiles, std::uint32_t states, std::uint32_t links);
        std::uint64_t messages = 0, live_bytes = 0, runs = 0, digest = 0;
        std::uint64_t exchange = 0;              ///< the exchange for which `streams` holds
        std::vector<std::uint32_t*> streams;     ///< by channels and sides: where the thread's stretch is free
        Failure failure;
        detail::TileSet busy;              ///< tiles that voted busy
        std::vector<detail::TileSet> mail; ///< by channels: tiles that got a message
        std::vector<std::uint32_t> peaks;  ///< most items by states, then by channels; a cache line before and after them is empty
        std::vector<TileSample> samples;   ///< on a Traced machine
        std::exception_ptr thrown;         ///< exception of a function of on_threads; on a Traced machine, of a sample

        static constexpr std::uint32_t line = 16; ///< words of a cache line
        std::uint32_t* state_peaks() noexcept { return peaks.data() + line; }
        void begin() noexcept;
    };
    /// A piece of the tiles that a thread has taken. n = 0: none, at the end of its run.
    struct Piece {
        std::uint32_t worker, first_tile, n;
        bool begins; ///< the first one of the thread since the exchange
    };
    /// Where the messages of a piece go, for the four sides: `last` says where those of the piece before ended.
    std::array<std::uint32_t*, 4> begin_stream(std::uint32_t link, Piece const& piece, std::uint32_t tiles,
                                               std::array<std::uint32_t*, 4> last) noexcept;
    /// Runs a kernel on n tiles: the tiles listed in `tiles`, or tiles 0..n-1 if `tiles` is null. `together`: thread w runs only its share;
    /// otherwise thread w runs all n tiles.
    using RunTiles = void (*)(void* mesh, std::uint32_t w, std::uint32_t const* tiles, std::uint32_t n, bool together) noexcept;
    /// The steps of a mesh of known type.
    struct Steps {
        ProgramFacts const* program;
        RunTiles const* run; ///< by steps
        void* mesh;
    };

    MeshCore(StoreView const& store, std::uint32_t threads);
    ~MeshCore();
    MeshCore(MeshCore const&) = delete;
    MeshCore& operator=(MeshCore const&) = delete;

    /// In an UntilQuiet step, the thread that called run() runs up to this many tiles alone. Running a tile takes 20 ns to 1 us. Involving
    /// another thread takes 0.2 us, and that thread may have to fetch the tiles' words from the first thread's cache.
    static constexpr std::uint32_t most_tiles_of_one_thread = 8;

    void begin_run() noexcept
    {
        for (auto& w : workers_) w.begin();
    }
    /// What a run needs of a mesh; it lives as long as the run. `calls` are the functions for it.
    struct Running {
        MeshCore& core;
        StoreView const& store;
        RunState& run;
        Steps const& steps;
    };
    static RunCalls calls(Running& running) noexcept;
    std::vector<Peak> peaks(StoreView const& store) const;
    void limit_link(StoreView const& store, std::uint32_t link, std::uint32_t items);
    /// Throws the exception of the lowest thread of the team that has one.
    void rethrow();

    Ends ends(std::uint32_t link) const noexcept
    {
        auto const& b = banks_[link];
        return {b.heads[b.now ^ 1u].data(), b.heads[b.now].data(), b.items[b.now].data(), b.stride, b.capacity};
    }
    /// The number of the incoming end at which the messages that `tile` sends towards d are read. Numbers from 4 x tiles on belong to messages
    /// that nobody reads.
    TILEMESH_KERNEL std::uint32_t slot(Edge edge, std::uint32_t tile, Direction d) const noexcept
    {
        auto const at = 4 * std::size_t{tile} + index(d);
        return edge == Edge::reflect ? slots_[at] : edge == Edge::wrap ? wrapping_[at] : dropping_[at];
    }

    // --- a part of the grid's rows ---
    /// What a tile sent towards d in a superstep whose exchange has not flipped the banks yet.
    machine::Place sent(StoreView const& store, std::uint32_t link, std::uint32_t tile, Direction d) const noexcept;
    /// Delivers the messages that tile `from`, which another process runs, sent towards d. Call it before the exchange flips the banks.
    /// `head`: size and note. The messages are copied into the memory of tile `from`. No stream of this mesh writes there, because this mesh
    /// does not run that tile.
    void deliver(StoreView const& store, std::uint32_t link, std::uint32_t from, Direction d, std::uint32_t const* head,
                 std::uint32_t const* items) noexcept;

    // --- one superstep ---
    bool has_mail(std::uint32_t link) const noexcept;
    bool any_busy() const noexcept;
    /// Forgets which tiles a kernel wakes: those that voted busy, and those with mail for it. `list_waking` adds them to `active_`.
    void forget_waking(KernelFacts const& kernel) noexcept;
    void list_waking(KernelFacts const& kernel) noexcept;
    void flip(KernelFacts const& kernel) noexcept
    {
        for (auto const& use : kernel.links) banks_[use.link].now ^= 1u;
        ++exchange_;
    }
    /// Runs n tiles: the calling thread alone if they are at most `most_alone`, otherwise the team.
    void run_on_team(Steps const& steps, std::uint32_t step, std::uint32_t const* tiles, std::uint32_t n, std::uint32_t most_alone) noexcept;
    /// Adds up what the threads counted in a superstep, and appends to the trace, if there is one. Returns the broken contracts. Throws the
    /// exception of a sample, and std::bad_alloc.
    Failure collect(StoreView const& store, RunState& run, StepFacts const& step, Passed& passed);
    /// One superstep of the run's step on all tiles, or on the tiles that must run. Does nothing if no tile must run.
    Passed superstep(StoreView const& store, RunState& run, Steps const& steps);
    /// The sum of the digests of tiles begin..end-1.
    std::uint64_t digest_of(StoreView const& store, std::uint32_t begin, std::uint32_t end) noexcept;

    std::vector<std::uint32_t> slots_;               ///< places at which each tile's four outgoing ends are read
    std::vector<std::uint32_t> wrapping_, dropping_; ///< these places for channels with these edges; empty without such a channel
    std::vector<Bank> banks_;                        ///< by channels
    std::uint64_t exchange_ = 1;                     ///< exchanges so far, and 1: in each, all streams begin anew
    Rectangle rectangle_;                            ///< Superstep and Repeat run all of its tiles
    detail::TileSet active_;
    std::vector<std::uint32_t> tiles_;               ///< the tiles that run in this superstep, if not all do
    detail::Shares shares_;
    std::vector<WorkerState> workers_;
    detail::Team team_;                              ///< last: its threads end before the objects that they use

private:
    void make_slots(StoreView const& store);
    void make_bank(StoreView const& store, std::uint32_t link);
    void append_sample(RunState& run, SuperstepSample&& s);
};

}}} // namespace tilemesh::engine

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/engine/detail/mesh_core_code.hpp>
#endif
