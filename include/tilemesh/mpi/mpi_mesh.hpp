#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mpi.h>
#include <string>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/mpi/bands.hpp>
#include <tilemesh/mpi/detail/band_mesh.hpp>
#include <tilemesh/mpi/detail/ranks.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// Options of an MpiMesh. All but `threads` are the same on every rank.
struct MpiMeshOptions {
    std::uint32_t threads = 1; ///< of this rank; see MeshOptions
    bool digest = false;       ///< see MeshOptions; costs one more agreement in each superstep
    std::uint32_t most_passes = 0; ///< see MeshOptions
    /// The work of each row of the grid, in any unit. Ranks then have bands of equal work; without weights, bands of equal height. A renderer
    /// gives a mesh the weights of its first view (render/ranks/row_weights.hpp), unless there are weights here.
    std::vector<std::uint32_t> row_weights = {};
    /// The ranks of a mesh whose constructor gets no communicator, as that of a renderer.
    MPI_Comm comm = MPI_COMM_WORLD;
};

/// Runs a program on the ranks of an MPI communicator. Each rank has a band of the grid's rows, and its threads share the band's tiles as in
/// Mesh. States, counters, digests and traces are those of Mesh, for every number of ranks and threads.
///
/// Every rank builds the mesh with the same program, grid and sizes. The constructor, `limit`, `run`, `gather` and `gather_trace` are
/// collective: every rank calls them in the same order. The mesh makes its own copy of the communicator, collectively. MPI must be
/// initialised, with at least MPI_THREAD_FUNNELED if a rank has several threads; then MPI's main thread owns the mesh. Destroy the mesh
/// before MPI_Finalize, because the destructor frees the copy.
///
/// Cost of a superstep: one message to each of at most two neighbours if the kernel sends, and one agreement (MPI_Iallreduce of 7 words and
/// one for each channel). A message holds the live items of the row at the edge of the band, and 3 words for each channel end that is not
/// empty. It travels while the rank runs its other rows. A step that no tile needs costs nothing. Memory of a rank follows the live words
/// of its rows, plus 20 to 52 bytes for each tile of the grid; address space is that of the whole grid.
///
/// Errors: what Mesh throws on one rank, this mesh throws on every rank, in the same superstep: the text of Mesh, and the rank. So do
/// std::bad_alloc and the exception of an observer, as Error. Ranks whose programs, sizes or limits differ are refused. An error of MPI
/// itself ends the job (MPI_ERRORS_ARE_FATAL). After an exception the mesh refuses to run again.
template <class Program, class Machine = Mk2>
class MpiMesh : mpi::detail::Ranks {
    using Ranks = mpi::detail::Ranks;
    using Band = mpi::detail::BandMesh<Program, Machine>;

public:
    using States = typename Band::States;
    using Links = typename Band::Links;
    using Sizes = typename Band::Sizes;
    using Options = MpiMeshOptions;

    /// The ranks of `options.comm`, for host work before there is a mesh. It makes its own copy of the communicator; every rank makes it, and
    /// calls its members in the same order. The members are those of the mesh.
    class Group : Ranks {
    public:
        explicit Group(Options const& options) : Ranks(options.comm) {}
        using Ranks::rank, Ranks::together, Ranks::same, Ranks::sum;
        std::uint32_t ranks() const noexcept { return this->size(); }
    };

    /// A mesh of `Machine`, for a program whose lists all have the capacity that their types name.
    MpiMesh(MPI_Comm comm, Program program, Grid grid, Options const& options = {})
        : MpiMesh(comm, program, grid, mesh_sizes<Program, Machine>(), options)
    {}
    /// The constructor above, with a value of type `Machine`, so that the compiler deduces it.
    template <std::same_as<Machine> M>
    MpiMesh(MPI_Comm comm, Program program, Grid grid, M, Options const& options = {}) : MpiMesh(comm, program, grid, options)
    {}
    /// A mesh with the machine and the slots of `sizes`.
    template <std::same_as<Sizes> S>
    MpiMesh(MPI_Comm comm, Program program, Grid grid, S const& sizes, Options const& options = {}) : Ranks(comm)
    {
        MeshOptions const own{options.threads, options.digest, options.most_passes, nullptr};
        auto digest = Band::digest_of_program(grid, sizes, own);
        for (auto w : options.row_weights) digest = engine::mix(digest, w);
        if (!same(digest))
            throw Error("ranks with different meshes (the program's type, the grid, the sizes or the options of a rank differ from those of "
                        "another); build the same mesh on every rank");
        together([&] {
            int level = MPI_THREAD_SINGLE;
            MPI_Query_thread(&level);
            if (options.threads > 1 && level < MPI_THREAD_FUNNELED)
                throw Error(std::to_string(options.threads) + " threads on a rank (MPI was initialised for one); call MPI_Init_thread with "
                                                              "MPI_THREAD_FUNNELED");
            Ranks const& all = *this;
            band_ = std::make_unique<Band>(all, mpi::Bands{grid.height, ranks(), options.row_weights}, program, grid, sizes, own);
        });
    }
    /// The constructor above, on the ranks of `options.comm`. Renderers build their meshes with it.
    template <std::same_as<Sizes> S>
    MpiMesh(Program program, Grid grid, S const& sizes, Options const& options) : MpiMesh(options.comm, program, grid, sizes, options)
    {}
    MpiMesh(MpiMesh const&) = delete;
    MpiMesh& operator=(MpiMesh const&) = delete;

    using Ranks::rank; ///< the number of this rank, from 0
    std::uint32_t ranks() const noexcept { return this->size(); }
    /// The rows of each rank.
    mpi::Bands const& bands() const noexcept { return band_->bands(); }
    /// Is tile t one of this rank?
    bool owns(TileId t) const noexcept { return t.y() >= bands().first(rank()) && t.y() < bands().last(rank()); }

    MachineSize const& machine() const noexcept { return band_->machine(); }
    Grid grid() const noexcept { return band_->grid(); }
    Program& program() noexcept { return band_->program(); }
    std::uint64_t sram_bytes() const noexcept { return band_->sram_bytes(); }

    /// The state X of a tile of this rank; see Mesh. On rank 0, after `gather<X>()`, also a copy of the state of any other tile.
    template <class X>
    decltype(auto) state(TileId t) noexcept
    {
        return band_->template state<X>(t);
    }
    template <class X>
    decltype(auto) state(TileId t) const noexcept
    {
        return std::as_const(*band_).template state<X>(t);
    }
    /// The states X of the tiles of this rank, row by row; see Mesh.
    template <class X>
    auto states() noexcept
    {
        return engine::StateRange<engine::TileStore<Program, false>, X>{*band_, band_->first_tile(), band_->last_tile()};
    }
    /// The broadcast P. A run takes that of rank 0, and gives it to all ranks.
    template <class P>
    P& broadcast() noexcept
    {
        return band_->template broadcast<P>();
    }
    /// The messages that a tile of this rank will read on channel C from side d; see Mesh.
    template <class C>
    typename C::Receiver incoming(TileId t, Direction d) noexcept
    {
        return band_->template incoming<C>(t, d);
    }

    /// Limits a list or a channel on every tile; see Mesh. Collective.
    template <class X>
    void limit(std::uint32_t items)
    {
        together([&] { band_->template limit<X>(items); });
    }
    /// See Mesh. Every rank gives the same rectangle.
    void run_within(std::uint32_t x0, std::uint32_t y0, std::uint32_t x1, std::uint32_t y1) { band_->run_within(x0, y0, x1, y1); }
    /// Sets a function that this rank's thread calls after every superstep, with the counts of all ranks. Ranks may have different
    /// observers, or none. With an observer on any rank, a superstep has one more agreement, because its exception is an Error on all ranks.
    void observe(Observer observer)
    {
        band_->require_idle();
        observer_ = std::move(observer);
    }
    /// Runs f(thread, threads) on each thread of this rank; see Mesh.
    template <class F>
    void on_threads(F const& f)
    {
        band_->on_threads(f);
    }

    /// Runs the whole program once. Every rank returns the same counters; only `milliseconds` is the rank's own. Collective.
    RunCounters run()
    {
        band_->require_idle();
        auto const digest = band_->digest_of_run();
        std::uint64_t words[] = {digest, ~digest, observer_ ? 0u : 1u};
        least(words, 3);
        if (words[0] != ~words[1])
            throw Error("ranks with different runs (the numbers in the program, a limit or the rectangle of a rank differ from those of "
                        "another); set the same on every rank");
        together([&] { band_->prepare(); });
        if (words[2] == 0) band_->observe_together(&observer_);
        else band_->observe_nothing();
        band_->share_broadcasts();
        return band_->run_program();
    }

    /// Copies the states X of all tiles to rank 0, where `state<X>` then reads them. A run does not change these copies. Collective.
    template <class X>
    void gather()
    {
        band_->template gather<X>();
    }
    /// The trace of the last run, of this rank's tiles. Only on a Traced machine.
    Trace const& trace() const { return band_->trace(); }
    /// The trace of the last run, of all tiles, on rank 0; an empty one on the other ranks. Collective. Only on a Traced machine.
    Trace gather_trace() { return band_->gather_trace(trace()); }
    /// The same for a trace of this rank's tiles that the caller has made, as of several runs. Every rank gives the same supersteps.
    Trace gather_trace(Trace const& mine) { return band_->gather_trace(mine); }

    // Host work between runs. All functions are collective.
    /// Runs f, which does not communicate. If it throws on some ranks, every rank throws the Error of the lowest of them, with its rank.
    using Ranks::together;
    /// Do all ranks give the same word?
    using Ranks::same;
    /// Replaces n words by their sums over all ranks, which wrap around. `least`, `most`: words below 2^63 by their minima or maxima.
    using Ranks::sum, Ranks::least, Ranks::most;
    /// Every rank, from the lowest to the highest, calls word = f(word), with the result of the rank before. All ranks return the last
    /// result. If f throws on some ranks, the others have run, too, and every rank throws as `together`. Cost: one broadcast for each rank.
    using Ranks::in_turn;
    /// Rank 0 gets the items of all ranks, in their order; the other ranks then have none. T is trivially copyable. The same for a number of
    /// items that every rank can tell, `join(items, n)` with n(r) of rank r: on rank 0, room for the items of the others follows its own.
    using Ranks::join;
    /// Sends `counts[r]` items to rank r, one rank after another. Returns the items that this rank gets, in the order of the ranks that sent
    /// them; `counts[r]` is then the number of those from rank r. T is trivially copyable. Memory: both lists at once.
    using Ranks::deal;
    /// Every rank gets the items of rank 0. T is trivially copyable.
    using Ranks::share;

private:
    std::unique_ptr<Band> band_;
    Observer observer_;
};

template <class Program, class Machine>
    requires(!std::same_as<Machine, MpiMeshOptions>)
MpiMesh(MPI_Comm, Program, Grid, Machine, MpiMeshOptions = {}) -> MpiMesh<Program, Machine>;
template <class Program>
MpiMesh(MPI_Comm, Program, Grid, MeshSizes<Program>, MpiMeshOptions = {}) -> MpiMesh<Program, AnyMachine>;

}} // namespace tilemesh
