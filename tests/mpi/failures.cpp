#include "../engine/programs.hpp"
#include "on_ranks.hpp"
#include "short_of_memory.hpp"
#include "../standard.hpp"
#include <sys/resource.h>
#include <tilemesh/machine/reduce.hpp>

using namespace mpi_test;

namespace {

struct Small : Buffer<std::uint32_t, 2> {};
struct Demand {
    std::uint32_t items, after; ///< pushes this many items when `after` supersteps have passed
};
struct Fill {
    void operator()(Demand& demand, Small& small, In<Wall> in, Out<Wall> out) const noexcept
    {
        (void)in;
        out.to_all(1);
        if (demand.after-- != 0) return;
        for (std::uint32_t i = 0; i < demand.items; ++i) small.push(i);
    }
};
using Filling = Repeat<Fill>;
constexpr Grid grid{5, 8};

template <class M>
void load(M& mesh, std::vector<TileId> const& breaking)
{
    for (auto [tile, demand] : mesh.template states<Demand>())
        demand = {std::find(breaking.begin(), breaking.end(), tile) != breaking.end() ? 4u : 2u, 3};
}

/// The rank that has a row of the grid.
std::uint32_t owner(std::uint32_t row)
{
    return mpi::Bands{grid.height, ranks()}.rank_of(row);
}

template <class Program, class... Arguments>
std::string error_of_building(Program program, Grid g, Arguments const&... arguments)
{
    return error_of([&] { MpiMesh<Program, Roomy> mesh{MPI_COMM_WORLD, program, g, arguments...}; });
}

} // namespace

TEST_CASE("a broken contract is the same Error on all ranks: that of Mesh, and the rank of the lowest tile")
{
    for (auto const& breaking : {std::vector{TileId::at(2, 7)}, std::vector{TileId::at(4, 6), TileId::at(1, 3), TileId::at(0, 7)},
                                 std::vector{TileId::at(0, 0)}}) {
        auto lowest = breaking.front();
        for (auto t : breaking)
            if (grid.index_of(t) < grid.index_of(lowest)) lowest = t;
        CAPTURE(lowest.y());
        Mesh<Filling, Roomy> reference{Filling{9}, grid};
        load(reference, breaking);
        auto const want = error_of([&] { reference.run(); });
        CHECK(has(want, "superstep 3 (Fill), the first of " + std::to_string(2 * breaking.size()) + " broken contracts]"));
        for (std::uint32_t threads : {1u, 2u}) {
            MpiMesh<Filling, Roomy> mesh{MPI_COMM_WORLD, Filling{9}, grid, {.threads = threads}};
            load(mesh, breaking);
            CHECK(error_of([&] { mesh.run(); }) == want + of_rank(owner(lowest.y())));
            CHECK(has(error_of([&] { mesh.run(); }), "a mesh that stopped on an error cannot run again"));
        }
    }
}

TEST_CASE("exactly full breaks nothing")
{
    on_ranks<Filling>(grid, [](auto& mesh) { load(mesh, {}); }, 1, Filling{9});
}

TEST_CASE("the exception of an observer on one rank is the same Error on all ranks")
{
    auto const last = ranks() - 1;
    auto const error_with = [&](auto const& f) {
        MpiMesh<Filling, Roomy> mesh{MPI_COMM_WORLD, Filling{9}, grid};
        std::uint32_t calls = 0;
        mesh.observe([&](SuperstepEvent const& e) {
            CHECK(e.pass == calls++);
            CHECK(e.tile_runs == grid.size());
            CHECK(e.messages == 4 * grid.size());
            if (e.pass == 4 && rank() == last) f();
        });
        if (rank() == 0 && last != 0) mesh.observe(nullptr); // a rank may have none
        auto const text = error_of([&] { mesh.run(); });
        CHECK(calls == (rank() == 0 && last != 0 ? 0 : text.empty() ? 9 : 5));
        return text;
    };
    auto const where = " [superstep 4 (Fill)]" + (ranks() == 1 ? "" : of_rank(last)); // if all ranks throw, the Error names none
    CHECK(error_with([] { throw std::runtime_error("disk full"); }) == "disk full" + where);
    CHECK(error_with([] { throw 7; }) == "an exception that is no std::exception" + where);
    CHECK(has(error_with([] { throw std::bad_alloc{}; }), "out of memory ("));
    CHECK(error_with([] {}).empty());
}

TEST_CASE("a program that is not quiet, and one that sends over unread mail, are the errors of Mesh")
{
    auto const compare = [](auto program, std::uint32_t most_passes, auto const& fill, int runs) {
        using Program = decltype(program);
        Mesh<Program, Roomy> reference{program, grid, {.most_passes = most_passes}};
        MpiMesh<Program, Roomy> mesh{MPI_COMM_WORLD, program, grid, {.most_passes = most_passes}};
        fill(reference);
        fill(mesh);
        for (int r = 1; r < runs; ++r) {
            reference.run();
            mesh.run();
        }
        auto const want = error_of([&] { reference.run(); });
        CHECK_FALSE(want.empty());
        CHECK(error_of([&] { mesh.run(); }) == want);
    };
    auto const throws = [](auto& mesh) {
        for (auto [tile, ball] : mesh.template states<Ball>()) ball.throws = tile.y() == 6 ? 50 : 0;
    };
    compare(Bounce{}, 10, throws, 1);
    using Cut = Sequence<UntilQuiet<Catch>, Superstep<Throw>>;
    Cut cut;
    get_step<Catch>(cut).at_most = 3;
    compare(cut, 0, throws, 2);
}

TEST_CASE("a trace that stays on its ranks explains nothing, and says where to look")
{
    MpiMesh<Bounce, Traced<Roomy>> mesh{MPI_COMM_WORLD, Bounce{}, grid, {.most_passes = 5}};
    for (auto [tile, ball] : mesh.states<Ball>()) ball.throws = 50;
    CHECK(has(error_of([&] { mesh.run(); }), "run the program on a Mesh"));
}

TEST_CASE("ranks that differ are refused on every rank, when the mesh is built or when it runs")
{
    if (ranks() == 1) return;
    bool const other = rank() == ranks() - 1;
    auto const differs = "ranks with different meshes (";
    CHECK(has(other ? error_of_building(Heat{}, grid) : error_of_building(Bounce{}, grid), differs));
    CHECK(has(error_of_building(Heat{}, other ? Grid{5, 8} : Grid{8, 5}), differs));
    CHECK(has(error_of_building(Heat{}, grid, MpiMeshOptions{.digest = other}), differs));
    CHECK(has(error_of_building(Heat{}, grid, MpiMeshOptions{.row_weights = std::vector<std::uint32_t>(8, other ? 1 : 2)}), differs));
    auto sizes = mesh_sizes<Filling, Roomy>();
    sizes.slots_of<Small>() = other ? 1 : 2;
    CHECK(has(error_of_building(Filling{}, grid, sizes), differs));
    CHECK(error_of_building(Heat{}, grid, MpiMeshOptions{.threads = other ? 2u : 1u}).empty());

    auto const runs_differ = "ranks with different runs (";
    MpiMesh<Heat, Roomy> mesh{MPI_COMM_WORLD, Heat{{other ? 3u : 2u}}, grid};
    CHECK(has(error_of([&] { mesh.run(); }), runs_differ));
    get_step<Diffuse>(mesh.program()).times = 2;
    mesh.run_within(0, 0, other ? 1 : 2, 8);
    CHECK(has(error_of([&] { mesh.run(); }), runs_differ));
    mesh.run_within(0, 0, 5, 8);
    CHECK(error_of([&] { mesh.run(); }).empty());
    MpiMesh<Filling, Roomy> limited{MPI_COMM_WORLD, Filling{1}, grid};
    limited.limit<Small>(other ? 1 : 2);
    CHECK(has(error_of([&] { limited.run(); }), runs_differ));
}

TEST_CASE("what all ranks do wrong is the error of Mesh, without a rank")
{
    using Tiny = TestMachine<64u << 20, 12>;
    auto const want = error_of([] { Mesh<Heat, Tiny> mesh{Heat{}, grid}; });
    CHECK(has(want, "a grid of 5 x 8 = 40 tiles (test has 12)"));
    CHECK(error_of([] { MpiMesh<Heat, Tiny> mesh{MPI_COMM_WORLD, Heat{}, grid}; }) == want);
    CHECK(has(error_of_building(Heat{}, grid, MpiMeshOptions{.row_weights = {1, 2}}), "2 row weights (the grid has 8 rows); "));
    CHECK(has(error_of_building(Heat{}, grid, MpiMeshOptions{.threads = 1025}), "1025 threads (a mesh runs on at most 1,024)"));
    CHECK(has(error_of_building(reduce_on<Member<&Demand::items>, Sum>({5, 7}), grid), "for a grid of 5 x 7 tiles (the mesh has 5 x 8)"));
    MpiMesh<Filling, Roomy> mesh{MPI_COMM_WORLD, Filling{1}, grid};
    CHECK(has(error_of([&] { mesh.limit<Small>(3); }), "a limit of 3 items for Small (the program's layout has 2)"));
    CHECK(has(error_of([&] { mesh.run_within(0, 0, 6, 8); }), "choose a rectangle inside it"));
    mesh.limit<Wall>(0);
    CHECK(has(error_of([&] { mesh.run(); }), "channel Wall has no slots"));
}

TEST_CASE("an error that only one rank can see, because only its tiles hold items, comes out of all")
{
    MpiMesh<Filling, Roomy> mesh{MPI_COMM_WORLD, Filling{1}, grid};
    for (auto [tile, small] : mesh.states<Small>())
        if (tile == TileId::at(2, 7)) small.push(1), small.push(2);
    auto const error = error_of([&] { mesh.limit<Small>(1); });
    CHECK(has(error, "(tile (2, 7) holds 2); set limits before the mesh is loaded"));
    CHECK(has(error, of_rank(owner(7))) == (ranks() > 1));
}

TEST_CASE("one rank out of memory, at each allocation in turn: every rank gets an Error")
{
    struct Made {
        std::optional<MpiMesh<Post, Traced<Roomy>>> mesh; // no memory for the mesh itself: that would be the program's own error
        std::uint64_t hops = 0;
    };
    auto const run = [](Made& made) {
        made.mesh.emplace(MPI_COMM_WORLD, Post{}, grid, MpiMeshOptions{.digest = true});
        for (auto [tile, outbox] : made.mesh->states<Outbox>()) outbox.push({tile.packed, made.mesh->grid().tile(39 - grid.index_of(tile)), {}});
        made.mesh->observe([](SuperstepEvent const&) {});
        made.hops = made.mesh->run().messages();
        made.mesh->gather<Inbox>();
        (void)made.mesh->gather_trace();
    };
    Made right;
    run(right);
    CHECK(right.hops > 0);
    each_allocation_fails([] { return std::make_unique<Made>(); }, run, [&](Made& made, bool) {
        run(made);
        CHECK(made.hops == right.hops);
    });
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) // they need the address space
#    if !defined(__has_feature)
#        define __has_feature(x) 0
#    endif
#    if !__has_feature(address_sanitizer) && !__has_feature(thread_sanitizer)
TEST_CASE("one rank without memory for its mesh: every rank gets the Error, and a smaller mesh can be built")
{
    struct Large : Buffer<std::uint32_t, 4'000'000> {};
    struct Keep {
        void operator()(Large&) const noexcept {}
    };
    using Program = Superstep<Keep>;
    Grid const wide{100, 100}; // 160 GB of address space
    rlimit before{};
    ::getrlimit(RLIMIT_AS, &before);
    bool const mine = rank() == ranks() - 1;
    if (mine) {
        rlimit const low{std::min<rlim_t>(before.rlim_max, rlim_t{64} << 30), before.rlim_max};
        ::setrlimit(RLIMIT_AS, &low);
    }
    auto const error = error_of([&] { MpiMesh<Program, Roomy> mesh{MPI_COMM_WORLD, Program{}, wide}; });
    if (mine) ::setrlimit(RLIMIT_AS, &before);
    CHECK(error == "out of memory (a rank has not enough for its tiles); use more ranks, or smaller lists and channels" +
                       (ranks() == 1 ? "" : of_rank(ranks() - 1)));
    CHECK(error_of_building(Program{}, grid).empty());
}
#    endif
#endif
