// test: unoptimised test asan
#define NDEBUG // as in a release build: contracts are reported in every build
#include "everywhere.hpp"
#include "programs.hpp"

using namespace engine_test;

namespace {

struct Small : Buffer<std::uint32_t, 2> {};
struct Demand {
    std::uint32_t items;
};
struct Nothing {
    void operator()() const noexcept {}
};
struct Overfill {
    void operator()(Demand const& demand, Small& small) const noexcept
    {
        for (std::uint32_t i = 0; i < demand.items; ++i) small.push(i);
    }
};
using Filling = Sequence<Superstep<Nothing>, Superstep<Nothing>, Superstep<Nothing>, Superstep<Overfill>, Superstep<Nothing>>;

struct Wire : Channel<std::uint32_t, 2> {};
struct Chatter {
    Vote operator()(Demand& demand, In<Wire>, Out<Wire> out) const noexcept
    {
        // Each run sends one more message: the third message is one too many.
        for (std::uint32_t i = 0; i < demand.items; ++i) out[Direction::east].push(i);
        if (demand.items != 0) ++demand.items;
        return demand.items != 0 ? Vote::busy : Vote::quiet;
    }
};

struct WhatNext {
    void operator()(Visits& visits) const noexcept { ++visits.count; }
};

/// The Error of run(), on each engine and number of threads. The mesh must then refuse to run again. All Meshes give the same text.
/// CheckedMesh stops on the first tile, so its text lacks the number of broken contracts and is otherwise equal.
template <class Program, class Machine = Mk2, class Load>
std::string error_everywhere(Grid grid, Load const& load, Program program = {})
{
    std::string text, of_checked;
    on_each<Program, Machine>(
        grid,
        [&](auto& mesh) {
            load(mesh);
            constexpr bool checked = std::is_same_v<std::decay_t<decltype(mesh)>, CheckedMesh<Program, Machine>>;
            auto const now = error_of([&] { mesh.run(); });
            CHECK_FALSE(now.empty());
            auto& same = checked ? of_checked : text;
            if (same.empty()) same = now;
            CHECK(now == same);
            CHECK(has(error_of([&] { mesh.run(); }), "a mesh that stopped on an error cannot run again"));
        },
        program);
    auto const count = text.find(", the first of ");
    CHECK(of_checked == (count == text.npos ? text : text.substr(0, count) + "]"));
    return text;
}

} // namespace

TEST_CASE("a contract broken in a kernel comes out of run() with tile, superstep and kernel")
{
    auto const text = error_everywhere<Filling>({6, 4}, [](auto& mesh) { mesh.template state<Demand>(TileId::at(3, 2)).items = 3; });
    CHECK(has(text, "push into a full buffer"));
    CHECK(has(text, "; use try_push"));
    CHECK(has(text, "[tile (3, 2), superstep 3 (Overfill)]"));
}

TEST_CASE("of several tiles that break a contract, the lowest is named, and Mesh counts what all of them broke")
{
    auto const text = error_everywhere<Filling>({40, 36}, [](auto& mesh) {
        for (std::uint32_t i = 203; i < 1440; i += 7) mesh.template state<Demand>(mesh.grid().tile(i)).items = 9;
    });
    CHECK(has(text, "[tile (3, 5), superstep 3 (Overfill), the first of 1239 broken contracts]"));
    auto const all = error_everywhere<Filling>({40, 36}, [](auto& mesh) {
        for (std::uint32_t i = 0; i < 1440; ++i) mesh.template state<Demand>(mesh.grid().tile(i)).items = 9;
    });
    CHECK(has(all, "[tile (0, 0), superstep 3 (Overfill), the first of 10080 broken contracts]"));
}

TEST_CASE("exactly full breaks nothing")
{
    auto const p = everywhere<Filling>({6, 4}, [](auto& mesh) { mesh.template state<Demand>(TileId::at(3, 2)).items = 2; });
    CHECK(p.mesh->state<Small>(TileId::at(3, 2)).size() == 2);
}

TEST_CASE("a contract broken in UntilQuiet names the pass in which it broke")
{
    using Program = Sequence<Superstep<Chatter>, UntilQuiet<Chatter>>;
    auto const text = error_everywhere<Program>({6, 4}, [](auto& mesh) { mesh.template state<Demand>(TileId::at(5, 3)).items = 1; });
    CHECK(has(text, "push into a full channel"));
    CHECK(has(text, "[tile (5, 3), superstep 2 (Chatter)]"));
}

TEST_CASE("a run that stopped ran no further: later steps saw nothing")
{
    using Program = Sequence<Superstep<Overfill>, Superstep<WhatNext>>;
    on_each<Program>({6, 4}, [](auto& mesh) {
        mesh.template state<Demand>(TileId::at(0, 0)).items = 3;
        CHECK_FALSE(error_of([&] { mesh.run(); }).empty());
        for (std::uint32_t i = 0; i < 24; ++i) CHECK(mesh.template state<Visits>(mesh.grid().tile(i)).count == 0);
        auto const small = mesh.template state<Small>(TileId::at(0, 0)); // the full list keeps its items
        REQUIRE(small.size() == 2);
        CHECK(small[0] == 0);
        CHECK(small[1] == 1);
    });
}

TEST_CASE("sending over unread mail, after a bound cut the step that reads it, is an error")
{
    using Program = Sequence<UntilQuiet<Catch>, Superstep<Throw>>;
    Program program;
    std::get<0>(program.steps).at_most = 3;
    std::string text;
    on_each<Program>(
        {5, 1},
        [&](auto& mesh) {
            mesh.template state<Ball>(TileId::at(1, 0)).throws = 9;
            mesh.run(); // ends with a ball that no tile has caught yet
            auto const now = error_of([&] { mesh.run(); });
            if (text.empty()) text = now;
            CHECK(now == text);
            CHECK(has(now, "a kernel sends on a channel with unread mail"));
            CHECK(has(now, "; raise the bound"));
            CHECK(has(now, "superstep 3 (Throw)]"));
            CHECK(has(error_of([&] { mesh.run(); }), "cannot run again"));
        },
        program);
}

TEST_CASE("the same program with a bound that suffices runs on and on")
{
    using Program = Sequence<UntilQuiet<Catch>, Superstep<Throw>>;
    Program program;
    std::get<0>(program.steps).at_most = 9;
    auto const p = everywhere<Program>(
        {5, 1}, [](auto& mesh) { mesh.template state<Ball>(TileId::at(1, 0)).throws = 9; }, 3, program);
    CHECK(p.runs[1].steps[0].passes == 9);
    CHECK(p.runs[2].steps[0].passes == 0);
}

namespace {

struct Loud { // sends over unread mail, and breaks another contract on the lowest tile
    void operator()(Small& small, Ball& ball, Out<Lane> out) const noexcept
    {
        for (std::uint32_t i = 0; i < 3; ++i) small.push(i);
        Throw{}(ball, out);
    }
};
struct Sometimes {
    void operator()(Small& small, Visits& visits, In<Lane> in, Out<Lane> out) const noexcept
    {
        small.truncate(0);
        Catch{}(visits, in, out);
    }
};

} // namespace

TEST_CASE("unread mail is reported before what the sending kernel then breaks, on every engine")
{
    using Program = Sequence<UntilQuiet<Catch>, Superstep<Throw>, UntilQuiet<Sometimes>, Superstep<Loud>>;
    Program program;
    std::get<2>(program.steps).at_most = 1;
    auto const text = error_everywhere<Program>(
        {40, 10}, [](auto& mesh) { mesh.template state<Ball>(TileId::at(1, 0)).throws = 9; }, program);
    CHECK(has(text, "a kernel sends on a channel with unread mail"));
    CHECK(has(text, "[tile (0, 0), superstep 2 (Loud)]"));
}

TEST_CASE("errors of several runs do not mix: a fresh mesh after a broken one is whole")
{
    CHECK_FALSE(error_everywhere<Filling>({6, 4}, [](auto& mesh) { mesh.template state<Demand>(TileId::at(3, 2)).items = 3; }).empty());
    everywhere<Filling>({6, 4}, [](auto& mesh) { mesh.template state<Demand>(TileId::at(3, 2)).items = 1; });
}
