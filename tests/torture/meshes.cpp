// Meshes that run out of memory.
#include "failing.hpp"
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
/// Adds the arrived messages, and sends as many ones as the channel takes.
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
using Watched = Mesh<Program, Traced<Mk2>>;
constexpr Grid grid{3, 2};

/// The words on the tiles and the mesh's counters; for a mesh with a trace, also the number of samples.
template <class M>
std::string text_of(M& mesh, RunCounters const& counters)
{
    std::string text;
    for (std::uint32_t t = 0; t < grid.size(); ++t) text += std::to_string(mesh.template state<Sum>(grid.tile(t)).value) + " ";
    for (auto const& step : counters.steps) text += std::to_string(step.capacity_bytes) + " " + std::to_string(step.messages) + " ";
    for (auto const& peak : counters.peaks) text += std::to_string(peak.items) + " of " + std::to_string(peak.capacity) + " ";
    if constexpr (std::is_same_v<M, Watched>)
        for (auto const& superstep : mesh.trace().supersteps) text += std::to_string(superstep.tiles.size()) + " ";
    return text;
}

/// A mesh runs for the first time. If that fails, it either runs exactly once afterwards, or refuses.
template <class M>
class Run : public Act {
public:
    Run() : mesh_(Program{{2}}, grid) { mesh_.template limit<Line>(3); }
    void act() override { counters_ = mesh_.run(); }
    std::string result() override { return text_of(mesh_, counters_); }

private:
    M mesh_;
    RunCounters counters_;
};

/// A channel gets more slots. If that fails, it keeps the slots that it had.
template <class M>
class Limit : public Act {
public:
    Limit() : mesh_(Program{{2}}, grid) { mesh_.template limit<Line>(3); }
    void act() override { mesh_.template limit<Line>(3000); }
    std::string result() override
    {
        auto const counters = mesh_.run();
        return text_of(mesh_, counters);
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

TEST_CASE_TEMPLATE("a mesh without memory runs once or not at all", M, Mesh<Program>, CheckedMesh<Program>, Watched)
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
        void act() override { Mesh<Program> const mesh({}, grid, {.threads = 4}); }
        std::string result() override { return "made"; }
    };
    torture::torture({{"4 threads", [] { return std::make_unique<Start>(); }}});
    if (torture::has_threads_that_fail()) torture::torture({{"4 threads, and no thread", [] { return std::make_unique<Start>(); }, torture::What::thread}});
}
