// Meshes without memory.
#include "failing.hpp"
#include <doctest/doctest.h>
#include <string>
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/machine/superstep.hpp>

namespace {

using namespace tilemesh;
using torture::Act;

struct Sum {
    std::uint32_t value;
};
struct Line : Channel<std::uint32_t, dynamic_capacity> {};
/// Adds what arrived, and sends as many ones as the channel takes.
struct Add {
    Vote operator()(Sum& sum, In<Line> in, Out<Line> out) const noexcept
    {
        for (auto d : news)
            for (auto one : in[d]) sum.value += one;
        for (auto d : news)
            while (out[d].try_push(1)) {}
        return Vote::quiet;
    }
};
using Program = Sequence<Repeat<Add>>;
constexpr Grid grid{3, 2};

template <class M>
std::string sums(M& mesh)
{
    std::string text;
    for (std::uint32_t t = 0; t < grid.size(); ++t) text += std::to_string(mesh.template state<Sum>(grid.tile(t)).value) + " ";
    return text;
}

/// A mesh runs for the first time. If that fails it runs once in all, or refuses.
template <class M>
class Run : public Act {
public:
    Run() : mesh_(grid, {}, Program{{{2}}}) { mesh_.template limit<Line>(3); }
    void act() override { (void)mesh_.run(); }
    std::string result() override { return sums(mesh_); }

private:
    M mesh_;
};

/// A channel gets more slots. If that fails it has those that it had.
template <class M>
class Limit : public Act {
public:
    Limit() : mesh_(grid, {}, Program{{{2}}}) { mesh_.template limit<Line>(3); }
    void act() override { mesh_.template limit<Line>(3000); }
    std::string result() override
    {
        (void)mesh_.run();
        return sums(mesh_);
    }
    std::string after_failure(std::string const&) override
    {
        Run<M> expected;
        expected.act();
        return result() == expected.result() ? "" : "the limit that failed has changed the channel";
    }

private:
    M mesh_;
};

} // namespace

TEST_SUITE_BEGIN("torture");

TEST_CASE_TEMPLATE("a mesh without memory runs once or not at all", M, Mesh<Program>, CheckedMesh<Program>, Mesh<Program, Traced<Mk2>>)
{
    torture::torture({{"a run", [] { return std::make_unique<Run<M>>(); }}});
}

TEST_CASE_TEMPLATE("a limit without memory leaves the channel as it was", M, Mesh<Program>, CheckedMesh<Program>)
{
    torture::torture({{"a limit", [] { return std::make_unique<Limit<M>>(); }}});
}

TEST_CASE("a mesh of several threads without memory ends those that it started")
{
    struct Start : Act {
        void act() override { Mesh<Program> const mesh(grid, {.threads = 4}); }
        std::string result() override { return "made"; }
    };
    torture::torture({{"4 threads", [] { return std::make_unique<Start>(); }}});
    if (torture::has_threads_that_fail()) torture::torture({{"4 threads, and no thread", [] { return std::make_unique<Start>(); }, torture::What::thread}});
}
