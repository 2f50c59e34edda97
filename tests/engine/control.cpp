// test: unoptimised test asan tsan
#include "control.hpp"
#include "everywhere.hpp"
#include <tilemesh/model/no_progress.hpp>

using namespace engine_test;

namespace {
std::vector<Tank> tanks_of(Grid grid, std::uint32_t seed)
{
    Random random{seed};
    std::vector<Tank> tanks(grid.size());
    for (auto& t : tanks) t = {random.below(4), random.below(3), 0, 0};
    return tanks;
}
template <class M, class X>
void load_all(M& mesh, std::vector<X> const& all)
{
    for (std::uint32_t i = 0; i < mesh.grid().size(); ++i) mesh.template state<X>(mesh.grid().tile(i)) = all[i];
}
template <class P>
auto loop_bound(P& program) -> std::uint32_t&
{
    return std::get<1>(program.steps).at_most;
}
constexpr Grid grids[] = {{1, 1}, {6, 1}, {1, 5}, {4, 3}};
} // namespace

TEST_CASE("Loop: rounds while a tile votes busy, an UntilQuiet inside, and its bound")
{
    for (Grid const grid : grids)
        for (std::uint32_t const at_most : {0u, 1u, 2u, 0xffffffffu}) {
            CAPTURE(grid.width);
            CAPTURE(grid.height);
            CAPTURE(at_most);
            auto const tanks = tanks_of(grid, 7 + grid.width);
            Draining program;
            loop_bound(program) = at_most;
            auto const p = everywhere<Draining>(grid, [&](auto& mesh) { load_all(mesh, tanks); }, 1, program);
            auto const want = drain_all(tanks, at_most);
            REQUIRE(p.last().loops.size() == 1);
            CHECK(p.last().loops[0] == LoopCounters{1, 2, want.rounds});
            CHECK(p.step(1).passes == want.passes);
            CHECK(p.step(2).passes == want.rounds);
            CHECK(p.step(2).tile_runs == want.rounds * grid.size());
            for (std::uint32_t i = 0; i < grid.size(); ++i) {
                auto const& t = p.mesh->state<Tank>(grid.tile(i));
                CHECK(t.drained == want.tanks[i].drained);
                CHECK(t.rounds == want.tanks[i].rounds);
            }
        }
}

TEST_CASE("Loop: no round where nobody voted busy before it, and each run begins quiet")
{
    auto const p = everywhere<Draining>({4, 3}, [](auto&) {}, 2); // all tanks are empty, so no tile votes busy
    CHECK(p.last().loops[0].rounds == 0);
    CHECK(p.step(1).passes == 0);
    CHECK(p.step(2).passes == 0);
    using Bare = Loop<Superstep<OpenTap>>; // the votes of the previous run do not count
    auto const bare = everywhere<Bare>({4, 3}, [](auto& mesh) { mesh.template state<Tank>(TileId::at(1, 1)).level = 1; }, 2);
    CHECK(bare.last().loops[0] == LoopCounters{0, 0, 0});
}

TEST_CASE("Loop: loops in loops count all their rounds")
{
    using Program = NestedDraining;
    Grid const grid{3, 2};
    auto const load = [](auto& mesh) { mesh.template state<Tank>(TileId::at(2, 1)) = {3, 2, 0, 0}; };
    auto const p = everywhere<Program>(grid, load);
    // The level is 3, then 2, then 1. After that the last Refill votes quiet.
    CHECK(p.last().loops == std::vector<LoopCounters>{{1, 2, 3}, {1, 1, 3 + 2 + 1}});
    CHECK(p.step(1).passes == 6);
    CHECK(p.mesh->state<Tank>(TileId::at(2, 1)).drained == 6);
    Program bounded;
    get_loop<Drain>(bounded).at_most = 2;
    auto const b = everywhere<Program>(grid, load, 1, bounded);
    CHECK(b.last().loops == std::vector<LoopCounters>{{1, 2, 3}, {1, 1, 2 + 2 + 2}});
}

TEST_CASE("Loop and Reduce: heat until it stands still is the plain loop, bit for bit")
{
    for (Grid const grid : grids)
        for (std::uint32_t const cooled : {0u, 1u})
            for (std::uint32_t const at_most : {3u, 1000u}) {
                CAPTURE(grid.width);
                CAPTURE(cooled);
                Settling const k{0.2f, 0.01f, cooled};
                std::vector<Plate> plates(grid.size());
                for (std::uint32_t i = 0; i < grid.size(); ++i) plates[i].kelvin = static_cast<float>((i * 7 + 3) % 11);
                Warming program;
                loop_bound(program) = at_most;
                auto const p = everywhere<Warming>(
                    grid,
                    [&](auto& mesh) {
                        load_all(mesh, plates);
                        mesh.template broadcast<Settling>() = k;
                    },
                    1, program);
                auto const want = settle(plates, grid, k, at_most);
                CHECK(p.last().loops[0].rounds == want.rounds);
                CHECK(p.step(step_of<Warming, Cool>()).passes == (cooled != 0 ? want.rounds : 0));
                for (std::uint32_t i = 0; i < grid.size(); ++i)
                    CHECK(p.mesh->state<Plate>(grid.tile(i)).kelvin == want.plates[i].kelvin);
                // Each round has W - 1 + H - 1 passes to tile (0, 0), and as many back.
                CHECK(p.step(4).passes == 2 * want.rounds * (grid.width - 1 + grid.height - 1));
            }
}

TEST_CASE("If: what a flag leaves out does not run; flags nest, may guard nothing, and are read in each run")
{
    for (std::uint32_t const first : {0u, 1u})
        for (std::uint32_t const second : {0u, 5u}) {
            auto const p = everywhere<Choosing>({3, 2}, [&](auto& mesh) { mesh.template broadcast<Wanted>() = {0, first, second}; }, 2);
            CHECK(p.step(0).passes == first);
            CHECK(p.step(1).passes == (first != 0 && second != 0 ? 1 : 0));
            CHECK(p.step(2).passes == 1);
            CHECK(p.mesh->state<Tally>(TileId::at(2, 1)).sum == 2 * (first + (first != 0 && second != 0 ? 10 : 0) + 100));
        }
    on_each<Choosing>({2, 2}, [](auto& mesh) {
        mesh.run();
        mesh.template broadcast<Wanted>().first = 1;
        CHECK(mesh.run().steps[0].passes == 1);
        CHECK(mesh.template state<Tally>(TileId::at(0, 0)).sum == 201);
    });
}

TEST_CASE("If keeps votes and mail for what comes after it")
{
    using Program = Sequence<Superstep<OpenTap>, If<&Wanted::first, Superstep<Add<1>>>, UntilQuiet<Drain>>;
    for (std::uint32_t const first : {0u, 1u}) {
        auto const p = everywhere<Program>({3, 2}, [&](auto& mesh) {
            mesh.template broadcast<Wanted>().first = first;
            mesh.template state<Tank>(TileId::at(1, 1)).level = 4;
        });
        CHECK(p.step(2).passes == (first != 0 ? 0 : 4)); // Add does not vote: all tiles are quiet after it
    }
}

TEST_CASE("what a policy leaves out is nowhere: no state, no channel, no step")
{
    using With = Tile<Mk2, Working<true>>;
    using Without = Tile<Mk2, Working<false>>;
    CHECK(With::ledger().size() == 4); // lines for Rim, Tally, Log and code
    CHECK(Without::ledger().size() == 2);
    CHECK(With::bytes == Without::bytes + 4 + 8 * (8 + 4));
    CHECK(step_of<Working<true>, Ring>() == 0);
    CHECK(step_of<Working<false>, Ring>() == no_step);
    CHECK(step_of<Working<false>, Work<false>>() == 0);
    auto const with = everywhere<Working<true>>({3, 2}, [](auto&) {});
    CHECK(with.mesh->state<Log>(TileId::at(2, 1)).runs == 2);
    CHECK(with.mesh->state<Tally>(TileId::at(2, 1)).sum == 2);
    auto const without = everywhere<Working<false>>({3, 2}, [](auto&) {});
    CHECK(without.last().steps.size() == 2);
    CHECK(without.mesh->state<Tally>(TileId::at(2, 1)).sum == 102);
}

namespace {
/// The trace of one run. Every engine and every number of threads must give the same trace.
template <class Program, class Load>
Trace trace_everywhere(Grid grid, Load const& load)
{
    CheckedMesh<Program, Traced<Mk2>> checked{{}, grid};
    load(checked);
    auto const run = checked.run();
    for (auto threads : thread_counts) {
        Mesh<Program, Traced<Mk2>> mesh{{}, grid, {.threads = threads}};
        load(mesh);
        check_same(run, mesh.run());
        CHECK(checked.trace() == mesh.trace());
    }
    CHECK(checked.trace().loops == run.loops);
    return checked.trace();
}
} // namespace

TEST_CASE("a trace has the rounds of loops, and who votes on another")
{
    auto const trace = trace_everywhere<Draining>({2, 2}, [](auto& mesh) { mesh.template state<Tank>(TileId::at(0, 1)) = {2, 1, 0, 0}; });
    std::vector<std::uint32_t> steps;
    std::vector<bool> votes;
    for (auto const& s : trace.supersteps) {
        steps.push_back(s.step);
        votes.push_back(s.votes);
    }
    CHECK(steps == std::vector<std::uint32_t>{0, 1, 1, 2, 1, 2});
    CHECK(votes == std::vector<bool>{false, true, true, true, true, true});
    CHECK(trace.loops == std::vector<LoopCounters>{{1, 2, 2}});
}

namespace {
struct Stay {
    void operator()(Tally& tally) const noexcept { tally.sum ^= 1; }
};
struct Insist {
    Vote operator()(Tally&) const noexcept { return Vote::busy; }
};
using Forever = Sequence<Superstep<Insist>, Loop<Superstep<Stay>, Superstep<Insist>>>;
} // namespace

TEST_CASE("a Loop that is never done: most_passes rounds, and the report of what repeats")
{
    Grid const grid{3, 1};
    std::string const said = "the loop of steps 1 to 2 is not done after 20 rounds (tiles vote busy, and most_passes allows no more); allow more, or "
                             "see what repeats";
    Mesh<Forever> mesh{{}, grid, {.threads = 2, .most_passes = 20}};
    CHECK(error_of([&] { mesh.run(); }) == said + " on a Traced machine [superstep 40 (Insist)]");
    CheckedMesh<Forever> checked{{}, grid, {.most_passes = 20}};
    CHECK(error_of([&] { checked.run(); }) == said + " on a Traced machine [superstep 40 (Insist)]");
    CHECK(has(error_of([&] { checked.run(); }), "cannot run again"));
    Mesh<Forever, Traced<Mk2>> traced{{}, grid, {.most_passes = 20, .explain = explain_no_progress}};
    auto const report = error_of([&] { traced.run(); });
    CHECK(has(report, said + " [superstep 40 (Insist)]"));
    CHECK(has(report, "the loop of steps 1 to 2 does the same every 2 supersteps from superstep 1 of the run on"));
    auto const found = no_progress(traced.trace(), grid);
    CHECK(found.period == 2);
    REQUIRE(found.loop.has_value());
    CHECK(*found.loop == LoopCounters{1, 2, 20});
    CHECK(found.supersteps == 40);
    // most_passes bounds the rounds of a Loop, and the passes of an inner UntilQuiet in each round. Exactly most_passes is no error.
    Grid const one{1, 1};
    auto const load = [](auto& m) { m.template state<Tank>(TileId::at(0, 0)) = {3, 2, 0, 0}; };
    Mesh<Draining> enough{{}, one, {.most_passes = 3}}, short_of{{}, one, {.most_passes = 2}};
    load(enough);
    load(short_of);
    CHECK(enough.run().loops[0].rounds == 3);
    CHECK(has(error_of([&] { short_of.run(); }), "step 1 is not quiet after 2 passes"));
}
