#pragma once
#include "../engine/everywhere.hpp"
#include <tilemesh/mpi/mpi_mesh.hpp>

/// Runs one program on all ranks, and checks that every rank has the results of a Mesh. The watch between the engine and MPI (watch.cpp)
/// counts messages, and holds them back at random.
namespace mpi_test {
using namespace engine_test;
using Roomy = TestMachine<64u << 20>;

/// Setup S on a machine that keeps a trace.
template <class S>
struct WithTrace : S {
    using Machine = Traced<typename S::Machine>;
};

/// From now on each message, receipt and agreement of this rank begins up to this time late, and its end is seen up to this time late. The
/// times are random, so the order changes, too. 0: never. Not while requests are open.
void delay(std::uint32_t most_us);
/// The messages and their words that this rank has sent since the last call, and the agreements of all ranks that it took part in.
struct Traffic {
    std::uint64_t messages = 0, words = 0, agreements = 0;
};
Traffic traffic();
/// The requests that this rank has begun and not ended.
int requests_left();

inline std::uint32_t rank()
{
    int r = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &r);
    return static_cast<std::uint32_t>(r);
}
inline std::uint32_t ranks()
{
    int n = 0;
    MPI_Comm_size(MPI_COMM_WORLD, &n);
    return static_cast<std::uint32_t>(n);
}
/// The end of the error of a rank.
inline std::string of_rank(std::uint32_t r)
{
    return " [rank " + std::to_string(r) + "]";
}

template <class M, class... X, class... C>
WordList words_of_rows(M& mesh, std::uint32_t first, std::uint32_t last, machine::Types<X...>, machine::Types<C...>)
{
    WordList words;
    for (std::uint32_t i = first * mesh.grid().width; i < last * mesh.grid().width; ++i) {
        (add_state(mesh, mesh.grid().tile(i), words, static_cast<X*>(nullptr)), ...);
        (add_mail(mesh, mesh.grid().tile(i), words, static_cast<C*>(nullptr)), ...);
    }
    return words;
}
template <class M, class... X>
WordList states_of_all(M& mesh, machine::Types<X...>)
{
    WordList words;
    for (TileId const t : mesh.grid().tiles()) (add_state(mesh, t, words, static_cast<X*>(nullptr)), ...);
    return words;
}
template <class M, class... X>
void gather_all(M& mesh, machine::Types<X...>)
{
    (mesh.template gather<X>(), ...);
}

/// One way to build an MpiMesh of a program. The results are the same for all.
struct Form {
    char const* name;
    std::uint32_t threads;
    bool digest;
    std::uint32_t most_delay_us;
    std::vector<std::uint32_t> weights;
};
inline std::vector<Form> forms_of(Grid grid)
{
    std::vector<std::uint32_t> uneven(grid.height, 1);
    uneven.front() = grid.height; // the first rank has one row, the last may have none
    return {{"one thread", 1, true, 0, {}}, {"two threads, no digest", 2, false, 0, {}}, {"uneven, delayed", 2, true, 30, uneven}};
}

/// Loads and runs a program on a Mesh and on MpiMeshes of several forms. After every run each rank's live words are those of the Mesh,
/// and so are counters, digests, and the states that rank 0 gathers. Returns the counters of the last run.
template <class Program, class Machine = Roomy, class Load>
RunCounters on_ranks(Grid grid, Load const& load, int runs, Program program, MeshSizes<Program> const& sizes)
{
    using Reference = Mesh<Program, Machine>;
    auto const states = typename Reference::States{};
    auto const links = typename Reference::Links{};
    std::vector<RunCounters> counters;
    std::vector<std::vector<WordList>> words; // by run and row
    Reference reference{program, grid, sizes, {.digest = true}};
    load(reference);
    for (int r = 0; r < runs; ++r) {
        counters.push_back(reference.run());
        words.emplace_back();
        for (std::uint32_t y = 0; y < grid.height; ++y) words.back().push_back(words_of_rows(reference, y, y + 1, states, links));
    }
    for (auto const& form : forms_of(grid)) {
        CAPTURE(form.name);
        delay(form.most_delay_us);
        MpiMesh<Program, Machine> mesh{
            MPI_COMM_WORLD, program, grid, sizes, {.threads = form.threads, .digest = form.digest, .row_weights = form.weights}};
        load(mesh);
        for (std::size_t r = 0; r < counters.size(); ++r) {
            CAPTURE(r);
            auto mine = mesh.run();
            CHECK(mine.digests.empty() != form.digest);
            if (!form.digest) mine.digests = counters[r].digests;
            check_same(counters[r], mine);
            for (auto y = mesh.bands().first(rank()); y < mesh.bands().last(rank()); ++y) {
                CAPTURE(y);
                CHECK(words[r][y] == words_of_rows(mesh, y, y + 1, states, links));
            }
        }
        gather_all(mesh, states);
        if (rank() == 0) CHECK(states_of_all(mesh, states) == states_of_all(reference, states));
        delay(0);
    }
    return counters.back();
}
template <class Program, class Machine = Roomy, class Load>
RunCounters on_ranks(Grid grid, Load const& load, int runs = 1, Program program = {})
{
    return on_ranks<Program, Machine>(grid, load, runs, program, mesh_sizes<Program, Machine>());
}

/// Rank 0 gathers the trace of a Mesh. A rank's own trace has only its tiles.
template <class Program, class Load>
void check_trace(Program const& program, Grid grid, Load const& load)
{
    Mesh<Program, Traced<Roomy>> reference{program, grid};
    load(reference);
    reference.run();
    for (auto const& form : forms_of(grid)) {
        CAPTURE(form.name);
        MpiMesh<Program, Traced<Roomy>> mesh{MPI_COMM_WORLD, program, grid, {.threads = form.threads, .row_weights = form.weights}};
        load(mesh);
        mesh.run();
        CHECK((mesh.gather_trace() == (rank() == 0 ? reference.trace() : Trace{})));
        CHECK(mesh.trace().supersteps.size() == reference.trace().supersteps.size());
        for (auto const& s : mesh.trace().supersteps)
            for (auto const& t : s.tiles) CHECK(mesh.owns(grid.tile(t.tile)));
    }
}

} // namespace mpi_test
