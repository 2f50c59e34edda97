// test: unoptimised test asan, without tsan
#include "../../examples/heat/heat.hpp"
#include "../engine/control.hpp"
#include "on_poplar.hpp"
#include <algorithm>
#include <cstdio>
#include <map>
#include <set>
#include <standin_vertex.hpp>
#include <tilemesh/poplar/ledger.hpp>
#include <tilemesh/splat/frame_program.hpp>

// The bytes that the graph stores and moves, as the stand-in for Poplar adds them up, against the ledger and the rule of NEWS neighbours.
using namespace tilemesh;

// --- a machine that a program fits exactly, and a machine that lacks one word ------------------------------------------------------
struct Hoard : Buffer<std::uint32_t, 100> {};
struct Grow {
    void operator()(Hoard& hoard) const noexcept { (void)hoard.try_push(1); }
};
using Growing = Sequence<Superstep<Grow>>;
TILEMESH_VERTEX(ledger_Grow, TestMachine<1024>, Growing, Grow)
POPLAR_STANDIN_VERTEX(ledger_Grow, reads, keeps, sends, x, y, width, height, step, log_at, task, program);

namespace {
using splat::Lossless;
using splat::Paper;

std::string text(machine::Name name)
{
    return std::string(name.text, name.size);
}

/// The paper's grid. Sanitizers use a smaller grid, whose tile 0 holds the same data except for the votes that arrive.
Grid grid_of_tests()
{
    return engine_test::fast() ? Grid{6, 5} : Grid{40, 36};
}

/// The lines of the ledger are the variables of tile 0, byte for byte, and tile 0 has no other variables.
template <class Machine, class Program, class Setup = NoSetup>
void check_ledger(std::string const& prefix, Grid grid)
{
    PoplarMesh<Program, Machine> mesh{{}, grid, mesh_sizes<Program, Machine, Setup>(), poplar_test::options(prefix)};
    mesh.prepare();
    auto const found = standin::tile_bytes(mesh.engine(), 0);
    auto const lines = on_poplar::ledger<Machine, Program, Setup>(grid);
    auto variables = found.variables;
    std::size_t sum = 0, expected = 0;
    auto const take = [&](std::string const& name) {
        auto const bytes = variables[name];
        variables.erase(name);
        return bytes;
    };
    for (auto const& line : lines) {
        auto const name = text(line.name);
        CAPTURE(name);
        sum += line.bytes;
        if (std::string(line.what) == "channel, 8 ends") {
            std::size_t bytes = 0;
            for (char const* side : {" north", " east", " west", " south"}) bytes += take(name + " from" + side) + take(name + " to" + side);
            CHECK(bytes == line.bytes);
        } else if (name == "logs and votes") {
            CHECK(take("log") + take("run log") + take("bounds of loops") + take("said") + take("rows said") + take("again") + take("who runs") == line.bytes);
        } else if (name == "votes arriving") {
            CHECK(found.temporaries == line.bytes);
        } else if (name == "vertices") {
            CHECK(found.vertex_state == line.bytes);
        } else if (name == "code and stacks") {
            CHECK(line.bytes > 100 * 1024); // about 30 KiB of code, six stacks of 8 KiB, exchange code
        } else {
            CHECK(take(name) == line.bytes);
        }
    }
    CHECK(variables.empty());
    using Layout = Tile<Machine, Program, Setup>;
    for (auto const& line : Layout::ledger()) expected += line.bytes;
    CHECK(sum == expected);
    if (prefix != "paper") CHECK(sum == Layout::bytes); // lists are outside the paper's budget
    // No tile has more than tile 0.
    for (std::uint32_t t = 1; t < grid.size(); ++t) CHECK(standin::tile_bytes(mesh.engine(), t).total() <= found.total());
}

/// The bytes that the engine's Copies move from tile to tile.
template <class Program, class Machine>
std::vector<standin::Exchange> copies_of(PoplarMesh<Program, Machine>& mesh)
{
    mesh.prepare();
    std::vector<standin::Exchange> out;
    for (auto const& e : standin::exchanges(mesh.engine()))
        if (e.kind == standin::Exchange::Kind::copy) out.push_back(e);
    return out;
}
} // namespace

TEST_CASE("poplar: the graph's variables are the tile's ledger, byte for byte")
{
    SUBCASE("lossless") { check_ledger<Mk2, splat::Frame<Lossless>, Lossless>("lossless", grid_of_tests()); }
    SUBCASE("heat") { check_ledger<Mk2, Repeat<Diffuse>>("heat", grid_of_tests()); }
    SUBCASE("heat on one row") { check_ledger<Mk2, Repeat<Diffuse>>("heat", Grid{7, 1}); }
    SUBCASE("a loop with a condition and a reduction") { check_ledger<Mk2, engine_test::Warming>("warm", Grid{6, 5}); }
    SUBCASE("a loop in a loop") { check_ledger<Mk2, engine_test::NestedDraining>("nested", Grid{6, 5}); }
}

TEST_CASE("poplar: the paper's budget holds on the machine, but its lists do not fit beside it")
{
    // The paper's data have 520,020 bytes, and our lists 243,224 bytes more. Poplar would refuse this, as the ledger says.
    standin::With const restore(standin::settings());
    standin::settings().code_bytes = Mk2::code_bytes;
    PoplarMesh<splat::Frame<Paper>> mesh{{}, grid_of_tests(), mesh_sizes<splat::Frame<Paper>, Mk2, Paper>(), poplar_test::options("paper")};
    CHECK(engine_test::has(engine_test::error_of([&] { mesh.prepare(); }), "more than its 638976"));
    standin::settings().tile_bytes = 1u << 20;
    check_ledger<Mk2, splat::Frame<Paper>, Paper>("paper", grid_of_tests());
}

TEST_CASE("poplar: a tile that is full, and one word over")
{
    standin::With const restore(standin::settings());
    Grid const grid{3, 2};
    auto const needs = [&] {
        PoplarMesh<Growing, TestMachine<1024>> mesh{{}, grid, poplar_test::options("ledger")};
        mesh.prepare();
        return standin::tile_bytes(mesh.engine(), 0).total();
    }();
    CHECK(needs == 408 + on_poplar::log_bytes<Growing>() + on_poplar::arriving_bytes<Growing>(grid) + on_poplar::vertex_bytes<Growing>());
    standin::settings().tile_bytes = 1024;
    standin::settings().code_bytes = 1024 - needs;
    PoplarMesh<Growing, TestMachine<1024>> full{{}, grid, poplar_test::options("ledger")};
    full.run();
    CHECK(full.state<Hoard>(TileId::at(2, 1)).size() == 1);
    standin::settings().code_bytes += 4;
    PoplarMesh<Growing, TestMachine<1024>> over{{}, grid, poplar_test::options("ledger")};
    CHECK(engine_test::has(engine_test::error_of([&] { over.prepare(); }), "4 more than its 1024"));
}

TEST_CASE("poplar: the exchange moves whole ends to the four neighbours, and nothing else")
{
    Grid const grid{5, 4};
    PoplarMesh<splat::Frame<Lossless>> mesh{{}, grid, mesh_sizes<splat::Frame<Lossless>, Mk2, Lossless>(), poplar_test::options("lossless")};
    std::size_t whole = 0, broadcasts = 0;
    for (auto const& copy : copies_of(mesh)) {
        auto const& moves = copy.moves;
        CAPTURE(copy.name);
        if (moves.size() == grid.size() - 1) { // a broadcast from tile 0 to all other tiles
            ++broadcasts;
            for (auto const& m : moves) CHECK(m.from == 0);
            continue;
        }
        // Every tile sends one end on each side. At an edge of the grid the end comes back.
        ++whole;
        std::map<std::pair<unsigned, unsigned>, std::size_t> found;
        for (auto const& m : moves) found[{m.from, m.to}] += m.words;
        std::map<std::pair<unsigned, unsigned>, std::size_t> expected;
        bool const road = copy.name.find("road") != std::string::npos;
        auto const words = road ? splat::Road<Lossless>::Receiver::words(200) : splat::Beam<Lossless>::Receiver::words(200);
        for (std::uint32_t i = 0; i < grid.size(); ++i)
            for (Direction d : news) expected[{i, grid.index_of(grid.neighbour(grid.tile(i), d))}] += words;
        CHECK(found == expected);
    }
    CHECK(broadcasts == 2);
    CHECK(whole == 3); // routing, the bloom's first superstep, the bloom
    // Before and after compute sets only votes move: one word per tile, and one word per row.
    for (auto const& e : standin::exchanges(mesh.engine()))
        if (e.kind != standin::Exchange::Kind::copy) {
            CAPTURE(e.name);
            CHECK(e.kind == standin::Exchange::Kind::gather);
            CHECK(e.name.find("votes") == 0);
            for (auto const& m : e.moves) CHECK(m.words == 1);
        }
}
