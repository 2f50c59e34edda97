#pragma once
#include <concepts>
#include <cstdint>
#include <exception>
#include <memory>
#include <tilemesh/engine/mesh_options.hpp>
#include <tilemesh/engine/mesh_tiles.hpp>
#include <tilemesh/engine/port.hpp>
#include <tilemesh/engine/rectangle.hpp>
#include <tilemesh/engine/run.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 {

/// Runs a program on host threads. The thread that calls run() goes through the program. In each superstep the other threads take their shares of
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
class Mesh : public engine::MeshTiles<Program, is_traced<Machine>> {
    static_assert(is_machine<Machine>, "no machine (it has the members name, tiles, sram_bytes, code_bytes, workers and clock_khz, as "
                                       "Mk2 has); look for a misspelt one; a setup is not one: give its Machine");
    using Base = engine::MeshTiles<Program, is_traced<Machine>>;
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
        : Base(program, grid, sizes, options.threads), options_(options)
    {
        if constexpr (traced)
            if (options.trace) this->run_.keep_trace();
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

    /// Sets a function that the thread that called run() calls after every superstep. Throws Error if the present one calls it.
    void observe(Observer observer) { this->run_.observe(std::move(observer)); }

    /// Runs f(thread, threads) once on each of the mesh's threads, for host work between runs; the caller's thread is thread 0. Returns
    /// when all calls have returned. If calls throw, it throws the exception of the lowest such thread. f must not call the mesh's run() or
    /// on_threads().
    template <class F>
    void on_threads(F const& f)
    {
        this->team_.each([&](std::uint32_t w) noexcept {
            try {
                f(w, this->team_.size());
            } catch (...) {
                this->workers_[w].thrown = std::current_exception();
            }
        });
        this->rethrow();
    }

    /// The trace of the last run, superstep by superstep; only on a Traced machine. Throws Error if the options say that the mesh keeps none.
    Trace const& trace() const
    {
        static_assert(traced, "a mesh without a trace (its machine is not Traced); build it for Traced<Machine>");
        return this->run_.kept_trace();
    }

    /// Runs the whole program once.
    RunCounters run()
    {
        this->view().require_capacities();
        this->run_.template begin<traced>(this->program_, this->shareds());
        this->begin_run();
        auto const store = this->view();
        auto const steps = this->steps();
        typename Core::Running running{*this, store, this->run_, steps};
        return this->run_.go_on(Core::calls(running), store, limits());
    }

protected: // for an engine that runs a part of the grid's rows
    static constexpr bool traced = is_traced<Machine>;
    engine::RunState::Limits limits() const noexcept { return {options_.most_passes, options_.digest, options_.explain}; }

    Options options_;
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
