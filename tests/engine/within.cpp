// test: unoptimised test asan
// Superstep and Repeat on a part of the grid. The rest of the grid is idle.
#include "everywhere.hpp"
#include "programs.hpp"

using namespace engine_test;

namespace {

/// A tile that is alive counts its runs. Every tile passes the ball on.
struct Marked {
    std::uint32_t alive, runs;
};
struct Count {
    Vote operator()(Marked& marked, In<Lane> in, Out<Lane> out) const noexcept
    {
        bool mail = false;
        for (Direction from : along_row)
            for (auto throws : in[from]) {
                mail = true;
                if (throws != 0) out[opposite(from)].push(throws - 1);
            }
        if (marked.alive == 0 && !mail) return Vote::quiet;
        ++marked.runs;
        if (marked.alive == 2) out[Direction::east].push(5u);
        if (marked.alive == 2) marked.alive = 1;
        return Vote::quiet;
    }
};
struct Hand { // only passes the ball on
    void operator()(Marked& marked, In<Lane> in, Out<Lane> out) const noexcept
    {
        for (Direction from : along_row)
            for (auto throws : in[from]) {
                ++marked.runs;
                if (throws != 0) out[opposite(from)].push(throws - 1);
            }
    }
};
using Counting = Sequence<Repeat<Count>, UntilQuiet<Hand>>;
Counting const four{{4}, {}};

} // namespace

TEST_CASE("a program on a corner of a large grid does what it does on a small one, and the rest is not run")
{
    Grid const large{30, 20};
    auto const load = [&](auto& mesh) {
        mesh.run_within(3, 2, 9, 7);
        for (std::uint32_t y = 2; y < 7; ++y)
            for (std::uint32_t x = 3; x < 9; ++x) mesh.template state<Marked>(TileId::at(x, y)).alive = 1;
        mesh.template state<Marked>(TileId::at(7, 4)).alive = 2;
    };
    auto const p = everywhere<Counting, Bench>(large, load, 2, four);
    // Column 7 throws the ball in pass 0; it is in column 12 after 5 more passes. Outside the rectangle it wakes each tile that gets it.
    CHECK(p.runs[0].steps[0].tile_runs == 4 * 30 + 2);
    CHECK(p.runs[0].steps[1].tile_runs == 3);
    CHECK(p.runs[1].steps[0].tile_runs == 4 * 30);
    CHECK(p.mesh->state<Marked>(TileId::at(8, 4)).runs == 4 + 4);
    CHECK(p.mesh->state<Marked>(TileId::at(9, 4)).runs == 1);
    CHECK(p.mesh->state<Marked>(TileId::at(13, 4)).runs == 1);
    CHECK(p.mesh->state<Marked>(TileId::at(14, 4)).runs == 0);
    CHECK(p.mesh->state<Marked>(TileId::at(0, 0)).runs == 0);
}

TEST_CASE("a tile outside that is not idle is caught by the checked engine")
{
    CheckedMesh<Counting, Bench> mesh{four, {30, 20}};
    mesh.run_within(3, 2, 9, 7);
    mesh.state<Marked>(TileId::at(9, 6)).alive = 1;
    auto const text = error_of([&] { mesh.run(); });
    CHECK(has(text, "on a tile outside the rectangle"));
    CHECK(has(text, "; run within a larger one"));
    CHECK(has(text, "[tile (9, 6), superstep 0 (Count)]"));
}

TEST_CASE("an observer may set the rectangle anew: it holds from the next superstep on, on every engine")
{
    on_each<Counting, Bench>({6, 5}, [](auto& mesh) {
        mesh.observe([&](SuperstepEvent const& event) {
            if (event.pass == 1) mesh.run_within(0, 0, 6, 1);
        });
        CHECK(mesh.run().tile_runs() == 2 * 30 + 2 * 6);
        mesh.observe(nullptr);
    }, four);
}

TEST_CASE("the rectangle may be the whole grid, empty, and set anew; not beyond the grid")
{
    on_each<Counting, Bench>({6, 5}, [](auto& mesh) {
        mesh.run_within(0, 0, 6, 5);
        CHECK(mesh.run().tile_runs() == 4 * 30);
        mesh.run_within(2, 2, 2, 2);
        auto const none = mesh.run();
        CHECK(none.tile_runs() == 0);
        CHECK(none.steps[0].passes == 4);
        mesh.run_within(0, 0, 6, 1);
        CHECK(mesh.run().tile_runs() == 4 * 6);
        for (auto const& bad : {error_of([&] { mesh.run_within(0, 0, 7, 5); }), error_of([&] { mesh.run_within(0, 0, 6, 6); }),
                                error_of([&] { mesh.run_within(3, 0, 2, 5); }), error_of([&] { mesh.run_within(0, 4, 6, 3); })})
            CHECK(has(bad, "(the grid has 6 x 5 tiles); choose a rectangle inside it"));
        CHECK(mesh.run().tile_runs() == 4 * 6);
    }, four);
}
