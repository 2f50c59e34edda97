#pragma once
#include "../engine/everywhere.hpp"
#include <deque>
#include <poplar/DeviceManager.hpp>
#include <standin.hpp>
#include <string>
#include <tilemesh/poplar/poplar_mesh.hpp>
#include <vector>

/// Runs one program on a Mesh, and on a PoplarMesh with the stand-in for Poplar (never an IPU). All live words and counters must agree.
namespace poplar_test {
using namespace tilemesh;

/// An attached device with the stand-in's current settings. It lives as long as the program.
inline poplar::Device const& device()
{
    static std::deque<poplar::Device> all;
    auto manager = poplar::DeviceManager::createDeviceManager();
    auto devices = manager.getDevices(poplar::TargetType::IPU, 1);
    REQUIRE(!devices.empty());
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
    standin::Order workers, vertices;
    bool threads;
};
inline constexpr Execution executions[] = {
    {"in order", standin::Order::ascending, standin::Order::ascending, false},
    {"last first", standin::Order::descending, standin::Order::descending, false},
    {"permuted", standin::Order::permuted, standin::Order::permuted, false},
    {"on threads", standin::Order::ascending, standin::Order::ascending, true},
};
inline void use(Execution const& e)
{
    auto& s = standin::settings();
    s.workers = e.workers;
    s.vertices = e.vertices;
    s.threads = e.threads;
    s.check_inputs = true;
}

template <class M, class M2>
void check_same_words(M& a, M2& b)
{
    auto const x = engine_test::words_of(a), y = engine_test::words_of(b);
    REQUIRE(x.size() == y.size());
    CHECK(x == y);
}

/// Loads and runs a program on both, `runs` times, in every way in which the stand-in executes. Returns the runs' counters of the Mesh.
template <class Program, class Machine = Mk2, class Load>
std::vector<RunCounters> on_both(std::string const& prefix, Grid grid, Load const& load, int runs, Program program,
                                 MeshSizes<Program> const& sizes)
{
    standin::With const restore(standin::settings());
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

} // namespace poplar_test
