#pragma once
#include <concepts>
#include <cstdint>
#include <memory>
#include <tilemesh/engine/checker.hpp>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/engine/port.hpp>
#include <tilemesh/engine/run.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 {

/// Options of a CheckedMesh.
struct CheckedMeshOptions {
    std::uint32_t threads = 1; ///< not used: this engine has one thread. So the options of a Mesh are also options of a CheckedMesh
    bool digest = false;
    /// Also runs the tiles that need not run, and checks that this changes no word and sends nothing. `Vote` promises this. Without the
    /// promise, a machine that runs every tile (the IPU) would give other results. If no tile must run an UntilQuiet's kernel, and its
    /// own votes said so, all tiles run once more for this check. A run in which no tile runs, because it begins with UntilQuiet and nobody
    /// has voted, is an error if a pass would have changed a word. Counters, traces and words are those of a run without the check.
    bool check_quiet_tiles = true;
    std::uint32_t most_passes = 0; ///< see MeshOptions
    ExplainNotQuiet explain = nullptr; ///< see MeshOptions
    bool trace = true; ///< see MeshOptions
};

/// The sequential engine, which checks every rule. It runs the tiles one by one in order. Incoming and outgoing ends of channels have
/// separate memory, and the exchange copies them. Guard words surround every region and channel end. Dead words are filled with a poison
/// that is a NaN as a float: items beyond a list's size, mail that was read, and (in regions of up to 64 MiB) slots that were never
/// written.
///
/// It has the members, counters, digests and pictures of Mesh. A multi-worker kernel is called once for each worker, the last worker first;
/// its `AllWorkers` is never called. In addition to Mesh's errors it reports: a write outside a region or channel, a size above its
/// capacity, a quiet tile that is not quiet, two channels that share memory and both carry mail, and a kernel of all workers that changes
/// the size of a list. Cost: about the live words of every tile, in each superstep.
template <class Program, class Machine = Mk2>
class CheckedMesh : public engine::TileStore<Program, true> {
    static_assert(is_machine<Machine>, "no machine (it has the members name, tiles, sram_bytes, code_bytes, workers and clock_khz, as "
                                       "Mk2 has); look for a misspelt one; a setup is not one: give its Machine");
    using Base = engine::TileStore<Program, true>;

public:
    using typename Base::Links;
    using typename Base::States;
    using typename Base::Sizes;
    using Options = CheckedMeshOptions;

    /// A mesh of `Machine`, for a program whose lists all have the capacity that their types name.
    CheckedMesh(Program program, Grid grid, Options options = {})
        : CheckedMesh(program, grid, mesh_sizes<Program, Machine>(), options)
    {
    }
    /// The constructor above, with a value of type `Machine`, so that the compiler deduces it:
    /// `CheckedMesh mesh{program, Grid{8, 8}, Traced<Mk2>{}}`.
    template <std::same_as<Machine> M>
    CheckedMesh(Program program, Grid grid, M, Options options = {}) : CheckedMesh(program, grid, options)
    {
    }
    /// A mesh with the machine and the slots of `sizes`.
    template <std::same_as<Sizes> S>
    CheckedMesh(Program program, Grid grid, S const& sizes, Options options = {})
        : Base(program, grid, sizes), options_(options), rectangle_{0, 0, grid.width, grid.height}, checker_(this->view())
    {
        if constexpr (traced)
            if (options.trace) run_.keep_trace();
    }

    template <class X>
    void limit(std::uint32_t items)
    {
        if constexpr (is_channel<X>)
            limit_link(Base::template index_of_link<X>, items);
        else
            this->view().limit_state(Base::template index_of_state<X>, items);
    }
    template <class C>
    typename C::Receiver incoming(TileId t, Direction d) noexcept
    {
        return typename C::Receiver{incoming_place(Base::template index_of_link<C>, this->grid_.index_of(t), d)};
    }
    /// See Mesh.
    machine::Place incoming_place(std::uint32_t link, std::uint32_t tile, Direction d) noexcept { return checker_.in[link].at(4 * tile + index(d)); }
    void limit_link(std::uint32_t link, std::uint32_t items) { checker_.limit_link(this->view(), link, items); }
    /// From now on Superstep and Repeat run only the tiles of columns x0 to x1 - 1 and rows y0 to y1 - 1, and those other tiles that voted
    /// busy or have mail for the kernel. Idle tiles outside cost nothing. The caller promises that on the other tiles the kernels would
    /// change no word, send nothing and vote quiet; CheckedMesh checks this. At first the rectangle is the whole grid. Throws Error for a
    /// rectangle that is not in the grid.
    void run_within(std::uint32_t x0, std::uint32_t y0, std::uint32_t x1, std::uint32_t y1)
    {
        rectangle_ = engine::checked_rectangle(this->grid_, {x0, y0, x1, y1});
    }

    void observe(Observer observer) { run_.observe(std::move(observer)); }

    /// Calls f(0, 1): this engine has one thread.
    template <class F>
    void on_threads(F const& f)
    {
        f(0u, 1u);
    }

    /// See Mesh.
    Trace const& trace() const
    {
        static_assert(traced, "a mesh without a trace (its machine is not Traced); build it for Traced<Machine>");
        return run_.kept_trace();
    }

    RunCounters run()
    {
        this->view().require_capacities();
        run_.begin<traced>(this->program_, this->shareds());
        return checker_.run(this->view(), run_, steps(StepsOf<Program>{}), {options_.most_passes, options_.digest, options_.explain});
    }

private:
    static constexpr bool traced = is_traced<Machine>;

    struct Source {
        CheckedMesh& mesh;
        std::uint32_t tile;
        Worker share;
        template <class X>
        machine::Place state() noexcept
        {
            return mesh.template state_place<X>(tile);
        }
        template <class C>
        machine::Place in(Direction d) noexcept
        {
            return mesh.checker_.in[Base::template index_of_link<C>].at(4 * tile + index(d));
        }
        template <class C>
        machine::Place out(Direction d) noexcept
        {
            return mesh.checker_.out[Base::template index_of_link<C>].at(4 * tile + index(d));
        }
        template <class P>
        P const* shared() noexcept
        {
            return mesh.Base::template shared<P>();
        }
        /// The bytes that an end of C with n messages takes on the machine.
        template <class C>
        std::uint32_t end_bytes(std::uint32_t n) const noexcept
        {
            return mesh.template end_bytes<C>(n);
        }
        Here here() noexcept { return {mesh.grid_.tile(tile), mesh.grid_}; }
        Worker worker() noexcept { return share; }
    };

    template <class Kernel>
    static Vote run_tile(void* mesh, std::uint32_t tile, Worker share)
    {
        Source source{*static_cast<CheckedMesh*>(mesh), tile, share};
        return run_kernel<Kernel>(source);
    }
    template <class Kernel>
    static void sample_tile(void* mesh, std::uint32_t tile, SuperstepSample& to)
    {
        auto& self = *static_cast<CheckedMesh*>(mesh);
        Source source{self, tile, {0, self.sizes_.machine.workers}};
        to.tiles.push_back(engine::sample<Kernel>(source, tile));
    }
    template <class... Step>
    engine::Checker::Steps steps(machine::Types<Step...>)
    {
        static constexpr Vote (*runs[])(void*, std::uint32_t, Worker) = {run_tile<KernelOf<Step>>..., nullptr};
        engine::Checker::Steps all{&engine::program_facts<Program>, runs, nullptr, this, options_.check_quiet_tiles, &rectangle_};
        if constexpr (traced) {
            static constexpr void (*samples[])(void*, std::uint32_t, SuperstepSample&) = {sample_tile<KernelOf<Step>>..., nullptr};
            all.sample = samples;
        }
        return all;
    }

    Options options_;
    engine::Rectangle rectangle_; ///< Superstep and Repeat run all of its tiles
    engine::Checker checker_;
    engine::RunState run_;
};

template <class Program, class Machine>
    requires(!std::same_as<Machine, CheckedMeshOptions>)
CheckedMesh(Program, Grid, Machine, CheckedMeshOptions = {}) -> CheckedMesh<Program, Machine>;
template <class Program>
CheckedMesh(Program, Grid, MeshSizes<Program>, CheckedMeshOptions = {}) -> CheckedMesh<Program, AnyMachine>;

template <class Program>
std::unique_ptr<engine::Port<Program>> make_checked_port(Program const& program, Grid grid, MeshSizes<Program> const& sizes,
                                                         MeshOptions const& options)
{
    CheckedMeshOptions checked;
    checked.digest = options.digest;
    checked.most_passes = options.most_passes;
    checked.explain = options.explain;
    checked.trace = options.trace;
    return std::make_unique<engine::PortOver<CheckedMesh<Program, Traced<AnyMachine>>>>(program, grid, sizes, checked);
}

}} // namespace tilemesh
