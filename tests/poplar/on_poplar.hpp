#pragma once
#include "../engine/everywhere.hpp"
#include "standin/standin.hpp"
#include <deque>
#include <poplar/DeviceManager.hpp>
#include <string>
#include <tilemesh/poplar/codelet.hpp>
#include <tilemesh/poplar/ledger.hpp>
#include <tilemesh/poplar/poplar_mesh.hpp>
#include <vector>

/// A line of a codelet file, and its vertex made known to the stand-in.
#define VERTEX(Name, ...)                                                                                                      \
    TILEMESH_VERTEX(Name, __VA_ARGS__)                                                                                         \
    static standin::Vertices<Name> const enter_##Name;
#define MULTI_VERTEX(Name, ...)                                                                                                \
    TILEMESH_MULTI_VERTEX(Name, __VA_ARGS__)                                                                                   \
    static standin::Vertices<Name> const enter_##Name;

/// Runs one program on a Mesh, and on a PoplarMesh with the stand-in for Poplar (never an IPU). All live words and counters must agree.
namespace poplar_test {
using namespace tilemesh;

/// An attached device with the stand-in's current settings. It lives as long as the program.
inline poplar::Device const& device()
{
    static std::deque<poplar::Device> all;
    auto devices = poplar::DeviceManager::createDeviceManager().getDevices(poplar::TargetType::IPU, 1);
    REQUIRE(devices[0].attach());
    all.push_back(std::move(devices[0]));
    return all.back();
}
inline PoplarOptions options(std::string prefix)
{
    PoplarOptions o;
    o.device = &device();
    o.codelets = "linked into this program";
    o.prefix = std::move(prefix);
    return o;
}

/// The ways in which the stand-in may execute: every order of workers and vertices, and workers on threads.
struct Execution {
    char const* name;
    standin::Order order;
    bool threads;
};
inline constexpr Execution executions[] = {
    {"in order", standin::Order::ascending, false},
    {"last first", standin::Order::descending, false},
    {"permuted", standin::Order::permuted, false},
    {"on threads", standin::Order::ascending, true},
};
inline void use(Execution const& e)
{
    auto& s = standin::settings();
    s.workers = s.vertices = e.order;
    s.threads = e.threads;
    s.check_inputs = true;
}

template <class M, class M2>
void check_same_words(M& a, M2& b)
{
    CHECK(engine_test::words_of(a) == engine_test::words_of(b));
}

/// Loads and runs a program on both, `runs` times, in every way in which the stand-in executes. Returns the runs' counters of the Mesh.
template <class Program, class Machine = Mk2, class Load>
std::vector<RunCounters> on_both(std::string const& prefix, Grid grid, Load const& load, int runs, Program program,
                                 MeshSizes<Program> const& sizes)
{
    standin::Restore const restore;
    std::vector<RunCounters> counted;
    for (auto const& e : executions) {
        CAPTURE(e.name);
        use(e);
        Mesh<Program, Machine> mesh{program, grid, sizes};
        PoplarMesh<Program, Machine> graph{program, grid, sizes, options(prefix)};
        load(mesh);
        load(graph);
        counted.clear();
        for (int r = 0; r < runs; ++r) {
            CAPTURE(r);
            counted.push_back(mesh.run());
            engine_test::check_same(counted.back(), graph.run());
            check_same_words(mesh, graph);
            if constexpr (is_traced<Machine>) CHECK(mesh.trace() == graph.trace());
        }
    }
    return counted;
}
/// on_both() with the slots that the program's types name.
template <class Program, class Machine = Mk2, class Load>
std::vector<RunCounters> on_both(std::string const& prefix, Grid grid, Load const& load, int runs = 1, Program program = {})
{
    return on_both<Program, Machine>(prefix, grid, load, runs, program, mesh_sizes<Program, Machine>());
}

/// Takes the variables of a line of a tile's ledger out of `variables`. Returns their bytes.
inline std::size_t take(std::map<std::string, std::size_t>& variables, machine::Region const& line)
{
    std::size_t bytes = 0;
    auto const one = [&](std::string const& name) {
        bytes += variables[name];
        variables.erase(name);
    };
    std::string const name(line.name.text, line.name.size);
    if (std::string(line.what) == "channel, 8 ends")
        for (char const* side : {" north", " east", " west", " south"}) one(name + " from" + side), one(name + " to" + side);
    else if (name == "logs and votes")
        for (char const* log : {"log", "run log", "bounds of loops", "said", "rows said", "again", "who runs"}) one(log);
    else
        one(name);
    return bytes;
}

/// The lines of the ledger are all that tile 0 holds, byte for byte, and no tile holds more.
template <class Program, class Machine = Mk2, class Setup = NoSetup>
void check_ledger(std::string const& prefix, Grid grid)
{
    PoplarMesh<Program, Machine> mesh{{}, grid, mesh_sizes<Program, Machine, Setup>(), options(prefix)};
    mesh.prepare();
    auto const found = standin::tile_bytes(mesh.engine(), 0);
    auto variables = found.variables;
    std::size_t sum = 0, expected = 0;
    for (auto const& line : on_poplar::ledger<Machine, Program, Setup>(grid)) {
        std::string const name(line.name.text, line.name.size);
        CAPTURE(name);
        sum += line.bytes;
        if (name == "code and stacks")
            CHECK(line.bytes > 100 * 1024); // about 30 KiB of code, six stacks of 8 KiB, exchange code
        else
            CHECK(line.bytes == (name == "votes arriving" ? found.temporaries : name == "vertices" ? found.vertex_state : take(variables, line)));
    }
    CHECK(variables.empty());
    for (auto const& line : Tile<Machine, Program, Setup>::ledger()) expected += line.bytes;
    CHECK(sum == expected);
    for (std::uint32_t t = 1; t < grid.size(); ++t) CHECK(standin::tile_bytes(mesh.engine(), t).total() <= found.total());
}

} // namespace poplar_test
