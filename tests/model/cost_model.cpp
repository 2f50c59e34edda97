// test: unoptimised test asan tsan
#include "../engine/everywhere.hpp"
#include "../splat/support.hpp"
#include "model_by_hand.hpp"
#include <tilemesh/model/any_to_any.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/orbit.hpp>

// Modelled cycles: an example computed by hand. A trace is the same on every engine and with any number of threads. Frames report where
// their messages end.
using namespace engine_test;

namespace {
struct Load {
    std::uint32_t messages;
};
struct Wire : Channel<std::uint32_t, 4> {};
using splat::Operation; // any set of operations would do
using splat::Operations;
struct Send {
    void operator()(Load const& load, Out<Wire> out) const noexcept
    {
        for (std::uint32_t i = 0; i < load.messages; ++i) out[Direction::east].push(i);
    }
    static Operations operations(Load const& load, Out<Wire> out) noexcept
    {
        Operations o;
        o[Operation::slot] = 2 * load.messages;
        o[Operation::routed] = out[Direction::east].size();
        return o;
    }
};
struct Take {
    void operator()(Load& load, In<Wire> in) const noexcept { load.messages += in[Direction::west].size(); }
    static Operations operations(In<Wire> in) noexcept
    {
        Operations o;
        o[Operation::slot] = in[Direction::west].size();
        return o;
    }
};
struct Silent { // reports no operations
    void operator()(Load&) const noexcept {}
};
using Program = Sequence<Superstep<Send>, Superstep<Take>>;

void load(auto& mesh)
{
    std::uint32_t const messages[3] = {1, 3, 0};
    for (std::uint32_t i = 0; i < 3; ++i) mesh.template state<Load>(mesh.grid().tile(i)).messages = messages[i];
}
} // namespace

TEST_CASE("cost model: three tiles, two supersteps, by hand")
{
    Grid const grid{3, 1};
    Mesh<Program, Traced<Mk2>> mesh{{}, grid};
    load(mesh);
    mesh.run();
    auto const& trace = mesh.trace();
    REQUIRE(trace.supersteps.size() == 2);
    CHECK(trace.kernels == std::vector<std::string>{"Send", "Take"});
    CHECK(trace.supersteps[0].tiles[1].sent_bytes[index(Direction::east)] == 8 + 3 * 4);
    CHECK(trace.supersteps[0].tiles[2].sent_bytes[index(Direction::east)] == 0);

    // Superstep 0. Tile 0: 2 slots, 1 routed: 1 + 6 = 7, and 10 to run. Tile 1: 6 slots, 3 routed: 3 + 18 = 21, and 10. Tile 2: 10.
    // Each tile moves 24 bytes to each side, 96 in all, at a quarter of a cycle: 24, and 100. Sync 7.
    // Superstep 1. Tile 1: 1 slot, half a cycle, counts as 1; tile 2: 3 slots, 2 cycles. Nothing is sent.
    auto m = model();
    auto cost = model_cost(m, trace, grid);
    REQUIRE(cost.supersteps.size() == 2);
    CHECK(cost.supersteps[0].compute == 31);
    CHECK(cost.supersteps[0].slowest == 1);
    CHECK(cost.supersteps[0].exchange == 124);
    CHECK(cost.supersteps[0].sync == 7);
    CHECK(cost.supersteps[0].vote == 0);
    CHECK(cost.supersteps[1].compute == 12);
    CHECK(cost.supersteps[1].slowest == 2);
    CHECK(cost.supersteps[1].exchange == 0);
    CHECK(cost.cycles == 31 + 124 + 7 + 12 + 7);
    CHECK(cost.busy[0] == std::vector<std::uint64_t>{17, 31, 10});
    CHECK(cost.busy[1] == std::vector<std::uint64_t>{10, 11, 12});
    CHECK(milliseconds(m, cost.cycles) == 0.181);

    // Only what was sent: tile 2 receives most, 20 bytes.
    m.exchange_cost = ExchangeCost::live;
    cost = model_cost(m, trace, grid);
    CHECK(cost.supersteps[0].exchange == 105);
    CHECK(cost.cycles == 162);
    // The same trace again with another machine.
    m.prices = {{"slot", 500}, {"routed", 0}};
    CHECK(model_cost(m, trace, grid).supersteps[0].compute == 13);
}

TEST_CASE("cost model: the busiest tile receives what goes around the grid's edge")
{
    Trace trace;
    trace.kernels = {"Send"};
    trace.operations = {{}};
    trace.supersteps = {{0, false, 40, true, {{1, {}, {0, 0, 16, 0}}, {2, {}, {0, 24, 0, 0}}}}}; // tiles 1 to the west and 2 to the east
    auto const exchange = [&](Edge edge) {
        trace.supersteps[0].edge = edge;
        auto m = model();
        m.exchange_cost = ExchangeCost::live;
        return model_cost(m, trace, Grid{3, 1}).supersteps[0].exchange;
    };
    CHECK(exchange(Edge::reflect) == 106); // 24 bytes back to tile 2
    CHECK(exchange(Edge::wrap) == 110);    // 16 and 24 bytes to tile 0
}

TEST_CASE("cost model: votes are paid for by supersteps of UntilQuiet, and nothing by one that does not run")
{
    using Looping = Sequence<Superstep<Send>, UntilQuiet<Take>, UntilQuiet<Take>, Superstep<Silent>>;
    Mesh<Looping, Traced<Mk2>> mesh{{}, Grid{3, 1}};
    load(mesh);
    mesh.run();
    auto const& trace = mesh.trace();
    REQUIRE(trace.supersteps.size() == 3);
    CHECK(trace.supersteps[1].votes);
    CHECK(trace.supersteps[1].tiles.size() == 2); // tiles with mail; the last tile's message comes back to it from the east and is not for it
    CHECK(trace.supersteps[2].step == 3);
    auto const cost = model_cost(model(), trace, Grid{3, 1});
    CHECK(cost.supersteps[0].vote == 0);
    CHECK(cost.supersteps[1].vote == 3);
    CHECK(cost.supersteps[2].compute == 10); // a kernel that reports no operations costs its run
}

namespace {
struct Small : support::Small<9, 3000> {
    using Machine = Traced<TestMachine<64u << 20>>;
};
struct SmallDrop : support::Small<5, 120, splat::Paper> {
    using Machine = Traced<TestMachine<64u << 20>>;
};

/// The anchor tile of each record.
template <class S, class M>
std::map<splat::GaussianId, std::uint32_t> anchors(M& mesh)
{
    std::map<splat::GaussianId, std::uint32_t> at;
    for (std::uint32_t i = 0; i < mesh.grid().size(); ++i)
        for (auto const& mark : mesh.template state<splat::Marks<S>>(mesh.grid().tile(i)))
            if (!mark.is(splat::Mark::copy)) at[mark.id] = i;
    return at;
}

/// The settled bytes of each step.
std::vector<std::uint64_t> settled(Trace const& trace)
{
    std::vector<std::uint64_t> bytes(trace.kernels.size());
    for (auto const& s : trace.supersteps)
        for (auto const& t : s.tiles) bytes[s.step] += t.operations.settled_bytes;
    return bytes;
}
constexpr std::size_t route_step = 1, bloom_step = 2; // bloom's first superstep is one step, the others are another

/// Renders three views. In Route the records whose anchor moved settle, in Bloom the copies that it sent.
template <class S, class Camera>
void bytes_are_conserved(scene::Map const& map, RendererOptions const& options, Camera const& camera)
{
    BasicRenderer<S> renderer{map, options};
    renderer.prepare(camera(0.0f).width, camera(0.0f).height);
    std::uint64_t copies = 0, most_copies = 0, most_moved = 0;
    renderer.observe([&](SuperstepEvent const& e) { copies += e.kernel == "bloom" ? e.messages : 0; });
    for (float turn : {0.0f, 0.05f, 0.05f}) {
        CAPTURE(turn);
        auto const before = anchors<S>(renderer.mesh());
        copies = 0;
        renderer.render(camera(turn));
        auto const after = anchors<S>(renderer.mesh());
        std::uint64_t moved = 0;
        for (auto const& [id, tile] : after) moved += before.at(id) != tile ? 1 : 0;
        auto const& trace = renderer.mesh().trace();
        REQUIRE(trace.kernels.at(route_step) == "route");
        REQUIRE(trace.kernels.at(bloom_step) == "bloom");
        auto const bytes = settled(trace);
        CHECK(bytes[route_step] == moved * wire_bytes<splat::RoadMessage<S>>);
        CHECK(bytes[bloom_step] == 0);
        CHECK(bytes[bloom_step + 1] == copies * wire_bytes<splat::BeamMessage<S>>);
        most_moved = std::max(most_moved, moved);
        most_copies = std::max(most_copies, copies);

        for (auto exchange : {ExchangeCost::live, ExchangeCost::capacity}) {
            auto m = model();
            m.exchange_cost = exchange;
            auto const cost = model_cost(m, trace, renderer.mesh().grid());
            auto const ideal = any_to_any(m, trace, renderer.mesh().grid());
            std::uint64_t compute = 0;
            for (auto const& c : cost.supersteps) compute += c.compute;
            CHECK(ideal.news_cycles == cost.cycles - compute);
            for (auto const& s : ideal.steps) CHECK(s.bound_cycles <= s.news_cycles);
            CHECK((copies == 0 || ideal.bound_cycles < ideal.news_cycles));
            CHECK(ideal.exchanges <= 2);
            CHECK(ideal.steps[route_step].settled_bytes == bytes[route_step]);
            CHECK(ideal.steps[bloom_step].settled_bytes == bytes[bloom_step + 1]);
        }
    }
    CHECK(most_moved > 0);
    CHECK(most_copies > 0);
}

template <class S>
void same_everywhere()
{
    auto const map = support::map_of(support::cloud(fast() ? 80 : 250, 21));
    RendererOptions options;
    options.tile = {20, 16};
    BasicRenderer<S, CheckedMesh> checked{map, options};
    std::vector<Trace> traces;
    for (float turn : {0.0f, 0.05f, 0.05f}) {
        checked.render(support::lens(150, 70, turn));
        traces.push_back(checked.mesh().trace());
    }
    CHECK(model_cost(model(), traces[0], checked.mesh().grid()).cycles > model_cost(model(), traces[2], checked.mesh().grid()).cycles);
    CHECK(traces[0].supersteps.size() > traces[2].supersteps.size());
    constexpr std::size_t kinds = std::size(Operation::names);
    std::uint64_t operations[kinds] = {};
    for (auto const& s : traces[0].supersteps)
        for (auto const& t : s.tiles)
            for (std::uint32_t i = 0; i < kinds; ++i) operations[i] += t.operations.count[i];
    for (auto n : operations) CHECK(n > 0);
    for (auto threads : thread_counts) {
        CAPTURE(threads);
        options.threads = threads;
        BasicRenderer<S> mesh{map, options};
        std::size_t i = 0;
        for (float turn : {0.0f, 0.05f, 0.05f}) {
            mesh.render(support::lens(150, 70, turn));
            CHECK(mesh.mesh().trace() == traces[i++]);
        }
    }
}
} // namespace

TEST_CASE("cost model: a frame's trace is the same on both engines and any number of threads")
{
    same_everywhere<Small>();
    same_everywhere<SmallDrop>();
}

TEST_CASE("any to any: a frame's messages end where its records are anchored and its copies are, and a bound is below what it cost")
{
    RendererOptions options;
    options.tile = {20, 16};
    auto const cloud = support::map_of(support::cloud(fast() ? 80 : 250, 21));
    auto const lens = [](float turn) { return support::lens(150, 70, turn); };
    bytes_are_conserved<Small>(cloud, options, lens);
    bytes_are_conserved<SmallDrop>(cloud, options, lens);
    if (fast()) return;
    auto const map = scene::built_in_map();
    auto const cameras = scene::orbit(scene::built_in_camera({320, 180}), scene::robust_centre(map), 0.5, 2);
    bytes_are_conserved<Small>(map, options, [&](float turn) { return turn == 0.0f ? cameras[0] : cameras[1]; });
}

TEST_CASE("cost model: without a trace, not a byte of a tile")
{
    static_assert(std::is_empty_v<Send> && Tile<Traced<Mk2>, Program>::bytes == Tile<Mk2, Program>::bytes);
}
