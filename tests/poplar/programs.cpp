// test: unoptimised test asan, without tsan
#include "../engine/programs.hpp"
#include "on_poplar.hpp"

// Programs of the engine's tests as codelets, and programs for rules that only a graph has.
using namespace engine_test;

// --- a kernel on all workers that reads a channel: no worker alone may empty the channel --------------------------------------------
struct Sum {
    std::uint32_t of_worker[6];
};
struct Note : Channel<std::uint32_t, 6> {};
struct Tell {
    void operator()(Here here, Out<Note> out) const noexcept
    {
        for (std::uint32_t i = 0; i < 6; ++i) out[Direction::east].push(i + here.tile.x());
        out[Direction::north].set_note(7);
    }
};
struct Listen {
    void operator()(Sum& sum, In<Note> in, Worker worker) const noexcept
    {
        std::uint32_t all = 0;
        for (std::uint32_t i = worker.index; i < in[Direction::west].size(); i += worker.count) all += in[Direction::west][i];
        sum.of_worker[worker.index] += all + (in[Direction::south].note() == 7 ? 1000u : 0u);
    }
};
using Listening = Sequence<Superstep<Tell>, Superstep<Listen>, Superstep<Listen>>;

// --- slots that are values: one codelet for graphs of any sizes ---------------------------------------------------------------------
struct Slots {
    std::uint32_t crate = 0, cart = 0, tray = 0;
    bool shared = false;
};
struct Crate : Buffer<std::uint32_t> {
    static constexpr auto slots = &Slots::crate;
};
struct Cart : Channel<std::uint32_t> {
    static constexpr auto slots = &Slots::cart;
};
struct Tray : Channel<std::uint32_t> {
    using memory_of = Cart;
    static constexpr auto slots = &Slots::tray;
    static constexpr auto memory_shared = &Slots::shared;
};
struct SendCart {
    void operator()(Crate& crate, Here here, Out<Cart> out) const noexcept
    {
        std::uint32_t n = here.tile.x();
        while (crate.try_push(n)) ++n;
        for (auto word : crate)
            if (!out[Direction::east].try_push(word)) break;
    }
};
struct TakeCart {
    void operator()(Crate& crate, In<Cart> in) const noexcept
    {
        crate.truncate(0);
        for (auto word : in[Direction::west]) (void)crate.try_push(word);
    }
};
struct SendTray {
    void operator()(Crate const& crate, Out<Tray> out) const noexcept
    {
        for (auto word : crate)
            if (!out[Direction::north].try_push(word + 1)) break;
    }
};
struct TakeTray {
    void operator()(Crate& crate, In<Tray> in) const noexcept
    {
        for (auto word : in[Direction::south]) (void)crate.try_push(word);
    }
};
using Sized = Sequence<Superstep<SendCart>, Superstep<TakeCart>, Superstep<SendTray>, Superstep<TakeTray>>;

// --- votes without a channel ------------------------------------------------------------------------------------------------------------
struct Countdown {
    std::uint32_t left, ran;
};
struct Tick {
    Vote operator()(Countdown& c) const noexcept
    {
        ++c.ran;
        if (c.left != 0) --c.left;
        return c.left != 0 ? Vote::busy : Vote::quiet;
    }
};
using Ticking = Sequence<Superstep<Tick>, UntilQuiet<Tick>>;

// --- a dynamic channel -------------------------------------------------------------------------------------------------------------
struct Any : Channel<std::uint32_t> {};
struct Fill {
    void operator()(Countdown& c, In<Any> in, Out<Any> out) const noexcept
    {
        for (auto d : news) c.ran += in[d].size();
        while (out[Direction::north].try_push(c.ran)) {}
    }
};
using Filling = Sequence<Repeat<Fill>>;

// --- a machine that a program fits exactly, and a machine that lacks one word ------------------------------------------------------
struct Hoard : Buffer<std::uint32_t, 100> {};
struct Grow {
    void operator()(Hoard& hoard) const noexcept { (void)hoard.try_push(1); }
};
using Growing = Sequence<Superstep<Grow>>;

// --- two states of one name, and a program that gets the codelets of another program --------------------------------------------------
namespace left {
struct Pan {
    std::uint32_t grams;
};
} // namespace left
namespace right {
struct Pan {
    std::uint32_t grams;
};
} // namespace right
struct Weigh {
    void operator()(left::Pan& a, right::Pan& b) const noexcept
    {
        a.grams += 1;
        b.grams += 10;
    }
};
using Weighing = Sequence<Superstep<Weigh>>;
struct Shelf : Buffer<std::uint32_t, 5> {};
struct Stock {
    void operator()(Shelf& shelf, Countdown& c) const noexcept
    {
        (void)shelf.try_push(c.left);
        ++c.ran;
    }
};
using Stocking = Sequence<Superstep<Stock>, Superstep<Tick>>;
using StockingOnce = Sequence<Superstep<Stock>>; // the program of the codelet

VERTEX(test_Weigh, Mk2, Weighing, Weigh)
VERTEX(test_Stock, Mk2, StockingOnce, Stock)
VERTEX(test_Grow, TestMachine<1024>, Growing, Grow)
VERTEX(test_TellSideways, Mk2, Generation, TellSideways)
VERTEX(test_TellUpAndDown, Mk2, Generation, TellUpAndDown)
VERTEX(test_Live, Mk2, Generation, Live)
VERTEX(test_Throw, Mk2, Bounce, Throw)
VERTEX(test_Catch, Mk2, Bounce, Catch)
VERTEX(test_Depart, Bench, Post, Depart)
VERTEX(test_Deliver, Bench, Post, Deliver)
VERTEX(test_Trade, Mk2, SortRows, Trade)
VERTEX(test_Settle, Mk2, SortRows, Settle)
VERTEX(test_Tell, Mk2, Listening, Tell)
MULTI_VERTEX(test_Listen, Mk2, Listening, Listen)
VERTEX(test_SendCart, Mk2, Sized, SendCart)
VERTEX(test_TakeCart, Mk2, Sized, TakeCart)
VERTEX(test_SendTray, Mk2, Sized, SendTray)
VERTEX(test_TakeTray, Mk2, Sized, TakeTray)
VERTEX(test_Tick, Mk2, Ticking, Tick)
VERTEX(test_Fill, Mk2, Filling, Fill)

namespace {
using poplar_test::on_both;

TEST_CASE("poplar: life, sorting, bouncing and post are the engine's, word for word")
{
    on_both<Generation>("test", Grid{4, 3}, [](auto& mesh) {
        std::uint32_t const glider[3] = {2, 4, 7};
        for (std::uint32_t i = 0; i < 3; ++i) mesh.template state<Patch>(TileId::at(1, 1)).row[i + 5] = glider[i] << 5;
    }, 12);
    auto const sorted = on_both<SortRows>("test", Grid{12, 2}, [](auto& mesh) {
        for (std::uint32_t i = 0; i < 24; ++i) mesh.template state<Key>(mesh.grid().tile(i)).value = (i * 7 + 3) % 24;
    }, 1, SortRows{{12}, {}});
    CHECK(sorted[0].steps[0].exchanges == 12);
    for (Grid grid : {Grid{1, 1}, Grid{6, 1}, Grid{1, 6}})
        on_both<Bounce>("test", grid, [](auto& mesh) { mesh.template state<Ball>(TileId::at(0, 0)).throws = 9; });
    auto const bounced = on_both<Bounce>("test", Grid{5, 2}, [](auto& mesh) {
        mesh.template state<Ball>(TileId::at(1, 0)).throws = 13;
        mesh.template state<Ball>(TileId::at(4, 1)).throws = 1;
    });
    CHECK(bounced[0].steps[1].passes == 13);
    CHECK(bounced[0].steps[1].exchanges == 12); // the last pass only reads mail
    standin::Restore const restore;
    standin::settings().tile_bytes = Bench::sram_bytes;
    on_both<Post, Bench>("test", Grid{9, 8}, [](auto& mesh) {
        Random random(5);
        for (std::uint32_t i = 0; i < 72; ++i)
            for (std::uint32_t n = random.below(20), id = 0; id < n; ++id) {
                auto const to = random.below(72);
                mesh.template state<Outbox>(mesh.grid().tile(i)).push({100 * i + id, mesh.grid().tile(to), {0, 1}});
            }
    });
}

TEST_CASE("poplar: what a bound leaves under way goes on in the next run")
{
    Bounce program;
    std::get<1>(program.steps).at_most = 2;
    auto const runs = on_both<Bounce>("test", Grid{4, 1}, [](auto& mesh) { mesh.template state<Ball>(TileId::at(0, 0)).throws = 0; }, 1, program);
    CHECK(runs[0].steps[1].passes == 0);
    for (std::uint32_t bound : {0u, 1u, 5u, 6u}) { // the ball needs 6 passes: the bounds 5 and 6 are the boundary
        CAPTURE(bound);
        std::get<1>(program.steps).at_most = bound;
        standin::Restore const restore;
        Mesh<Bounce> mesh{program, Grid{4, 1}};
        PoplarMesh<Bounce> graph{program, Grid{4, 1}, poplar_test::options("test")};
        mesh.state<Ball>(TileId::at(0, 0)).throws = 6;
        graph.state<Ball>(TileId::at(0, 0)).throws = 6;
        check_same(mesh.run(), graph.run());
        poplar_test::check_same_words(mesh, graph);
        if (bound < 6) { // Throw only sends, so the next run finds unread mail on its channel
            auto const refusal = error_of([&] { graph.run(); });
            CHECK(has(refusal, "unread mail"));
            CHECK(has(refusal, "Throw]"));
            CHECK(has(error_of([&] { mesh.run(); }), "unread mail"));
            CHECK(has(error_of([&] { graph.run(); }), "cannot run again"));
        } else {
            check_same(mesh.run(), graph.run());
        }
    }
}

TEST_CASE("poplar: all workers read a channel, and its mail is read once")
{
    auto const runs = on_both<Listening>("test", Grid{3, 3}, [](auto&) {}, 3);
    CHECK(runs[0].steps[0].messages == 9 * 6);
    PoplarMesh<Listening> graph{{}, Grid{3, 3}, poplar_test::options("test")};
    graph.run();
    // Worker w of the middle tile reads w + 0 from the west, and the note from the south, each once.
    auto const& sum = graph.state<Sum>(TileId::at(1, 1));
    for (std::uint32_t w = 0; w < 6; ++w) CHECK(sum.of_worker[w] == w + 1000);
}

TEST_CASE("poplar: one codelet serves any slots, and channels in one memory or in two, as the sizes of the graph say")
{
    for (Slots const slots : {Slots{6, 4, 3, false}, Slots{6, 4, 3, true}, Slots{1, 2, 5, true}, Slots{17, 1, 9, false}, Slots{0, 1, 1, true}}) {
        CAPTURE(slots.crate);
        CAPTURE(slots.shared);
        auto const sizes = mesh_sizes<Sized>(size_of_machine<Mk2>(), slots);
        auto const runs = on_both<Sized>("test", Grid{4, 3}, [](auto&) {}, 2, {}, sizes);
        CHECK(runs[0].steps[0].messages == 12u * std::min(slots.crate, slots.cart));
        CHECK(runs[0].peaks[0].capacity == slots.crate);
        CHECK(runs[0].peaks[0].items == slots.crate);
        // The graph stores the bytes of the ledger.
        PoplarMesh<Sized> graph{{}, Grid{4, 3}, sizes, poplar_test::options("test")};
        graph.run();
        std::size_t channels = 0, stored = 0;
        for (auto const& line : SramLedger<Sized>::lines(sizes.machine, slots))
            if (std::string(line.what) == "channel, 8 ends") channels += line.bytes;
        for (auto const& [name, n] : standin::tile_bytes(graph.engine(), 1).variables)
            if (name.find("Cart") == 0 || name.find("Tray") == 0) stored += n;
        CHECK(stored == channels);
    }
    // Lists and channels shorter than their layout.
    auto const sizes = mesh_sizes<Sized>(size_of_machine<Mk2>(), Slots{6, 4, 3, true});
    auto const runs = on_both<Sized>("test", Grid{4, 3}, [](auto& mesh) {
        mesh.template limit<Crate>(5);
        mesh.template limit<Cart>(3);
    }, 2, {}, sizes);
    CHECK(runs[0].peaks[0].capacity == 5);
    CHECK(runs[0].steps[0].capacity_bytes == 12u * 4 * (8 + 3 * 4));
}

TEST_CASE("poplar: votes without channels; who runs is counted, also outside a rectangle")
{
    auto const load = [](auto& mesh) {
        mesh.run_within(1, 0, 3, 2);
        for (std::uint32_t i = 0; i < 12; ++i) {
            auto const t = mesh.grid().tile(i);
            if (t.x() >= 1 && t.x() < 3 && t.y() < 2) mesh.template state<Countdown>(t).left = i;
        }
    };
    auto const runs = on_both<Ticking>("test", Grid{4, 3}, load, 2);
    CHECK(runs[0].steps[0].tile_runs == 4);
    CHECK(runs[0].steps[1].passes == 5); // the largest `left` is 6, and the first superstep takes 1
}

TEST_CASE("poplar: a dynamic channel of 0, 1 and 5 slots")
{
    CHECK(has(error_of([] { PoplarMesh<Filling>{{}, Grid{2, 2}, poplar_test::options("test")}.run(); }), "has no slots"));
    for (std::uint32_t slots : {1u, 5u})
        on_both<Filling>("test", Grid{2, 2}, [&](auto& mesh) { mesh.template limit<Any>(slots); }, 2, Filling{{3}});
}

TEST_CASE("poplar: states of one name")
{
    on_both<Weighing>("test", Grid{2, 2}, [](auto& mesh) { mesh.template state<right::Pan>(TileId::at(1, 1)).grams = 5; }, 2);
}

TEST_CASE("poplar: a tile that is full, and one word over")
{
    standin::Restore const restore;
    Grid const grid{3, 2};
    auto const ready = [&] {
        auto mesh = std::make_unique<PoplarMesh<Growing, TestMachine<1024>>>(Growing{}, grid, poplar_test::options("test"));
        mesh->prepare();
        return mesh;
    };
    auto const needs = standin::tile_bytes(ready()->engine(), 0).total();
    CHECK(needs == 408 + on_poplar::log_bytes<Growing>() + on_poplar::arriving_bytes<Growing>(grid) + on_poplar::vertex_bytes<Growing>());
    standin::settings().tile_bytes = 1024;
    standin::settings().code_bytes = 1024 - needs;
    auto const full = ready();
    full->run();
    CHECK(full->state<Hoard>(TileId::at(2, 1)).size() == 1);
    standin::settings().code_bytes += 4;
    CHECK(has(error_of([&] { ready(); }), "4 more than its 1024"));
}

TEST_CASE("poplar: codelets of another program are refused, and touch nothing")
{
    PoplarMesh<Stocking> graph{{}, Grid{2, 2}, poplar_test::options("test")};
    CHECK(has(error_of([&] { graph.run(); }), "codelets of another program"));
    CHECK(graph.state<Shelf>(TileId::at(0, 0)).size() == 0);
    CHECK(has(error_of([&] { graph.run(); }), "cannot run again"));
    CHECK(on_poplar::program_mark<Mk2, Stocking> != on_poplar::program_mark<Mk2, StockingOnce>);
    CHECK(on_poplar::program_mark<Mk2, Stocking> != on_poplar::program_mark<Traced<Mk2>, Stocking>); // a traced codelet has one more edge

    // A graph that keeps a trace, with codelets that have no trace.
    PoplarMesh<Ticking, Traced<Mk2>> watched{{}, Grid{2, 2}, poplar_test::options("test")};
    CHECK(has(error_of([&] { watched.run(); }), "codelets of another program"));
}

TEST_CASE("poplar: a run that Poplar stops leaves a mesh that refuses")
{
    standin::Restore const restore;
    standin::settings().while_limit = 3;
    PoplarMesh<Ticking> graph{{}, Grid{2, 2}, poplar_test::options("test")};
    graph.state<Countdown>(TileId::at(0, 0)).left = 50;
    CHECK(has(error_of([&] { graph.run(); }), "a run that Poplar stopped"));
    CHECK(graph.state<Countdown>(TileId::at(0, 0)).ran > 0); // the state at the stop
    CHECK(has(error_of([&] { graph.run(); }), "cannot run again"));
}

TEST_CASE("poplar: mail looked at before a limit, and after runs")
{
    PoplarMesh<Filling> graph{Filling{{3}}, Grid{2, 3}, poplar_test::options("test")};
    CHECK(graph.incoming<Any>(TileId::at(1, 1), Direction::south).empty());
    graph.limit<Any>(500);
    CHECK(graph.incoming<Any>(TileId::at(1, 1), Direction::south).empty());
    for (int r = 0; r < 2; ++r) {
        graph.run();
        CHECK(graph.incoming<Any>(TileId::at(1, 1), Direction::south).size() == 500);
        CHECK(graph.incoming<Any>(TileId::at(1, 1), Direction::west).empty());
    }
}

TEST_CASE("poplar: what a PoplarMesh refuses, in one line")
{
    using poplar_test::options;
    CHECK(has(error_of([] { PoplarMesh<Ticking>{{}, Grid{2, 2}}; }), "without a device"));
    CHECK(has(error_of([] { PoplarMesh<Ticking>{{}, Grid{2, 2}, options("other")}.run(); }), "other_Tick"));
    auto digest = options("test");
    digest.digest = true;
    CHECK(has(error_of([&] { PoplarMesh<Ticking>{{}, Grid{2, 2}, digest}; }), "digests"));
    PoplarMesh<Ticking> mesh{{}, Grid{2, 2}, options("test")};
    CHECK(has(error_of([&] { mesh.observe([](SuperstepEvent const&) {}); }), "observer"));
    mesh.observe({});
    CHECK(has(error_of([&] { mesh.run_within(0, 0, 3, 2); }), "rectangle inside"));
    mesh.run();
    PoplarMesh<Filling> full{{}, Grid{1, 1}, options("test")};
    CHECK(has(error_of([&] { full.limit<Any>(1u << 20); }), "over a tile's SRAM"));
    full.limit<Any>(2);
    full.run();
    CHECK(has(error_of([&] { full.limit<Any>(3); }), "before the first run"));
    // The device has too few tiles.
    standin::Restore const restore;
    standin::settings().tiles = 3;
    auto manager = poplar::DeviceManager::createDeviceManager();
    auto devices = manager.getDevices(poplar::TargetType::IPU, 1);
    auto small = options("test");
    small.device = &devices[0];
    CHECK(has(error_of([&] { PoplarMesh<Ticking>{{}, Grid{2, 2}, small}; }), "3 tiles"));
}
} // namespace
