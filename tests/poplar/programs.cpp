// test: unoptimised test asan, without tsan
#include "../engine/programs.hpp"
#include "on_poplar.hpp"
#include <standin_vertex.hpp>
#include <tilemesh/poplar/codelet.hpp>

// Programs of the engine's tests as codelets, and programs for rules that only a graph has.
using namespace engine_test;

// --- mail across runs: a bound ends the step that reads --------------------------------------------------------------------------
using Bounded = Sequence<Superstep<Throw>, UntilQuiet<Catch>>;

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

// --- two channels in one memory, and a list with a limit ---------------------------------------------------------------------------
struct Pile : Buffer<std::uint32_t, 9> {};
struct Wide : Channel<std::uint32_t, 5> {};
struct Narrow : Channel<std::uint32_t, 2> {
    using memory_of = Wide;
};
struct SendWide {
    void operator()(Pile& pile, Out<Wide> out) const noexcept
    {
        std::uint32_t n = 0;
        while (!pile.empty() && n < 5 && out[Direction::south].try_push(pile[pile.size() - 1])) {
            pile.truncate(pile.size() - 1);
            ++n;
        }
    }
};
struct TakeWide {
    void operator()(Pile& pile, In<Wide> in) const noexcept
    {
        for (auto d : news)
            for (auto word : in[d])
                if (!pile.try_push(word)) return;
    }
};
struct SendNarrow {
    void operator()(Pile const& pile, Out<Narrow> out) const noexcept
    {
        for (std::uint32_t i = 0; i < pile.size(); ++i)
            if (!out[Direction::west].try_push(pile[i] + 1)) return;
    }
};
struct TakeNarrow {
    void operator()(Pile& pile, In<Narrow> in) const noexcept
    {
        for (auto d : news)
            for (auto word : in[d]) (void)pile.try_push(word);
    }
};
using Shared = Sequence<Superstep<SendWide>, Superstep<TakeWide>, Superstep<SendNarrow>, Superstep<TakeNarrow>>;

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

// --- a sender over unread mail ----------------------------------------------------------------------------------------------------------
struct Stamp {
    std::uint32_t word;
};
struct SendStamp {
    void operator()(Stamp const& stamp, Out<Lane> out) const noexcept { out[Direction::east].push(stamp.word); }
};
struct ReadStamp {
    void operator()(Stamp& stamp, In<Lane> in) const noexcept
    {
        for (auto d : news)
            for (auto word : in[d]) stamp.word += word;
    }
};
using Cut = Sequence<Superstep<SendStamp>, UntilQuiet<ReadStamp>>;

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

// --- three channels in one memory -----------------------------------------------------------------------------------------------------
struct Low : Channel<std::uint32_t, 2> {};
struct Middle : Channel<std::uint32_t, 3> {
    using memory_of = Low;
};
struct High : Channel<std::uint32_t, 6> {
    using memory_of = Low;
};
template <class C>
struct Pass {
    static constexpr char const* name = std::is_same_v<C, Low> ? "pass low" : std::is_same_v<C, Middle> ? "pass middle" : "pass high";
    void operator()(Countdown& c, Out<C> out) const noexcept
    {
        while (out[Direction::east].try_push(++c.left)) {}
    }
};
template <class C>
struct Receive {
    static constexpr char const* name = std::is_same_v<C, Low> ? "take low" : std::is_same_v<C, Middle> ? "take middle" : "take high";
    void operator()(Countdown& c, In<C> in) const noexcept
    {
        for (auto d : news)
            for (auto word : in[d]) c.ran = 31 * c.ran + word;
    }
};
using ThreeInOne = Sequence<Superstep<Pass<Low>>, Superstep<Receive<Low>>, Superstep<Pass<Middle>>, Superstep<Receive<Middle>>,
                            Superstep<Pass<High>>, Superstep<Receive<High>>>;

TILEMESH_VERTEX(test_Weigh, Mk2, Weighing, Weigh)
TILEMESH_VERTEX(test_Stock, Mk2, StockingOnce, Stock)
TILEMESH_VERTEX(test_pass_low, Mk2, ThreeInOne, Pass<Low>)
TILEMESH_VERTEX(test_take_low, Mk2, ThreeInOne, Receive<Low>)
TILEMESH_VERTEX(test_pass_middle, Mk2, ThreeInOne, Pass<Middle>)
TILEMESH_VERTEX(test_take_middle, Mk2, ThreeInOne, Receive<Middle>)
TILEMESH_VERTEX(test_pass_high, Mk2, ThreeInOne, Pass<High>)
TILEMESH_VERTEX(test_take_high, Mk2, ThreeInOne, Receive<High>)
TILEMESH_VERTEX(test_Diffuse, Mk2, Heat, Diffuse)
TILEMESH_VERTEX(test_TellSideways, Mk2, Generation, TellSideways)
TILEMESH_VERTEX(test_TellUpAndDown, Mk2, Generation, TellUpAndDown)
TILEMESH_VERTEX(test_Live, Mk2, Generation, Live)
TILEMESH_VERTEX(test_Throw, Mk2, Bounce, Throw)
TILEMESH_VERTEX(test_Catch, Mk2, Bounce, Catch)
TILEMESH_VERTEX(test_Depart, Bench, Post, Depart)
TILEMESH_VERTEX(test_Deliver, Bench, Post, Deliver)
TILEMESH_VERTEX(test_Trade, Mk2, SortRows, Trade)
TILEMESH_VERTEX(test_Settle, Mk2, SortRows, Settle)
TILEMESH_VERTEX(test_Tell, Mk2, Listening, Tell)
TILEMESH_MULTI_VERTEX(test_Listen, Mk2, Listening, Listen)
TILEMESH_VERTEX(test_SendCart, Mk2, Sized, SendCart)
TILEMESH_VERTEX(test_TakeCart, Mk2, Sized, TakeCart)
TILEMESH_VERTEX(test_SendTray, Mk2, Sized, SendTray)
TILEMESH_VERTEX(test_TakeTray, Mk2, Sized, TakeTray)
TILEMESH_VERTEX(test_SendWide, Mk2, Shared, SendWide)
TILEMESH_VERTEX(test_TakeWide, Mk2, Shared, TakeWide)
TILEMESH_VERTEX(test_SendNarrow, Mk2, Shared, SendNarrow)
TILEMESH_VERTEX(test_TakeNarrow, Mk2, Shared, TakeNarrow)
TILEMESH_VERTEX(test_Tick, Mk2, Ticking, Tick)
TILEMESH_VERTEX(test_Fill, Mk2, Filling, Fill)
TILEMESH_VERTEX(test_SendStamp, Mk2, Cut, SendStamp)
TILEMESH_VERTEX(test_ReadStamp, Mk2, Cut, ReadStamp)

#define ENTER(Name) POPLAR_STANDIN_VERTEX(Name, reads, keeps, sends, x, y, width, height, step, log_at, task, program)
ENTER(test_Weigh);
ENTER(test_Stock);
ENTER(test_pass_low);
ENTER(test_take_low);
ENTER(test_pass_middle);
ENTER(test_take_middle);
ENTER(test_pass_high);
ENTER(test_take_high);
ENTER(test_Diffuse);
ENTER(test_TellSideways);
ENTER(test_TellUpAndDown);
ENTER(test_Live);
ENTER(test_Throw);
ENTER(test_Catch);
ENTER(test_Depart);
ENTER(test_Deliver);
ENTER(test_Trade);
ENTER(test_Settle);
ENTER(test_Tell);
ENTER(test_Listen);
ENTER(test_SendCart);
ENTER(test_TakeCart);
ENTER(test_SendTray);
ENTER(test_TakeTray);
ENTER(test_SendWide);
ENTER(test_TakeWide);
ENTER(test_SendNarrow);
ENTER(test_TakeNarrow);
ENTER(test_Tick);
ENTER(test_Fill);
ENTER(test_SendStamp);
ENTER(test_ReadStamp);

namespace {
using poplar_test::on_both;

TEST_CASE("poplar: heat, life, sorting, bouncing and post are the engine's, word for word")
{
    on_both<Heat>("test", Grid{7, 5}, [](auto& mesh) {
        mesh.template broadcast<Conductivity>().per_step = 0.2f;
        mesh.template state<Cell>(TileId::at(3, 2)).kelvin = 1000;
    }, 2, Heat{{20}});
    on_both<Generation>("test", Grid{4, 3}, [](auto& mesh) {
        std::uint32_t const glider[3] = {2, 4, 7};
        for (std::uint32_t i = 0; i < 3; ++i) mesh.template state<Patch>(TileId::at(1, 1)).row[i + 5] = glider[i] << 5;
    }, 12);
    auto const sorted = on_both<SortRows>("test", Grid{12, 2}, [](auto& mesh) {
        for (std::uint32_t i = 0; i < 24; ++i) mesh.template state<Key>(mesh.grid().tile(i)).value = (i * 7 + 3) % 24;
    }, 1, SortRows{{12}, {}});
    CHECK(sorted[0].steps[0].exchanges == 12);
    auto const bounced = on_both<Bounce>("test", Grid{5, 2}, [](auto& mesh) {
        mesh.template state<Ball>(TileId::at(1, 0)).throws = 13;
        mesh.template state<Ball>(TileId::at(4, 1)).throws = 1;
    });
    CHECK(bounced[0].steps[1].passes == 13);
    CHECK(bounced[0].steps[1].exchanges == 12); // the last pass only reads mail
    standin::With const restore(standin::settings());
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

TEST_CASE("poplar: one tile, one row, one column: every message comes back where it should")
{
    for (Grid grid : {Grid{1, 1}, Grid{6, 1}, Grid{1, 6}}) {
        CAPTURE(grid.width);
        on_both<Heat>("test", grid, [](auto& mesh) {
            mesh.template broadcast<Conductivity>().per_step = 0.1f;
            mesh.template state<Cell>(TileId::at(0, 0)).kelvin = 500;
        }, 1, Heat{{20}});
        on_both<Bounce>("test", grid, [](auto& mesh) { mesh.template state<Ball>(TileId::at(0, 0)).throws = 9; });
    }
}

TEST_CASE("poplar: what a bound leaves under way goes on in the next run")
{
    Bounded program;
    std::get<1>(program.steps).at_most = 2;
    auto const runs = on_both<Bounded>("test", Grid{4, 1}, [](auto& mesh) { mesh.template state<Ball>(TileId::at(0, 0)).throws = 0; }, 1, program);
    CHECK(runs[0].steps[1].passes == 0);
    for (std::uint32_t bound : {0u, 1u, 5u, 6u}) { // the ball needs 6 passes: the bounds 5 and 6 are the boundary
        CAPTURE(bound);
        std::get<1>(program.steps).at_most = bound;
        standin::With const restore(standin::settings());
        Mesh<Bounded> mesh{program, Grid{4, 1}};
        PoplarMesh<Bounded> graph{program, Grid{4, 1}, poplar_test::options("test")};
        mesh.state<Ball>(TileId::at(0, 0)).throws = 6;
        graph.state<Ball>(TileId::at(0, 0)).throws = 6;
        check_same(mesh.run(), graph.run());
        poplar_test::check_same_words(mesh, graph);
        if (bound < 6) { // Throw only sends, so the next run finds unread mail on its channel
            CHECK(has(error_of([&] { graph.run(); }), "unread mail"));
            CHECK(has(error_of([&] { mesh.run(); }), "unread mail"));
            CHECK(has(error_of([&] { graph.run(); }), "cannot run again"));
        } else {
            check_same(mesh.run(), graph.run());
        }
    }
    Cut cut;
    std::get<1>(cut.steps).at_most = 0;
    PoplarMesh<Cut> graph{cut, Grid{3, 2}, poplar_test::options("test")};
    graph.run();
    CHECK(has(error_of([&] { graph.run(); }), "SendStamp"));
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

TEST_CASE("poplar: two channels in one memory; lists and channels shorter than their layout")
{
    auto const load = [](auto& mesh) {
        mesh.template limit<Pile>(7);
        mesh.template limit<Wide>(3);
        for (std::uint32_t i = 0; i < 12; ++i)
            for (std::uint32_t n = 0; n < i % 8; ++n) mesh.template state<Pile>(mesh.grid().tile(i)).push(10 * i + n);
    };
    auto const runs = on_both<Shared>("test", Grid{4, 3}, load, 4);
    CHECK(runs[0].peaks[0].capacity == 7);
    CHECK(runs[0].steps[0].capacity_bytes == 12u * 4 * (8 + 3 * 4));
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

TEST_CASE("poplar: states of one name; three channels in one memory")
{
    on_both<Weighing>("test", Grid{2, 2}, [](auto& mesh) { mesh.template state<right::Pan>(TileId::at(1, 1)).grams = 5; }, 2);
    on_both<ThreeInOne>("test", Grid{3, 2}, [](auto&) {}, 2);
    PoplarMesh<ThreeInOne> graph{{}, Grid{3, 2}, poplar_test::options("test")};
    graph.run();
    // The ledger counts the largest channel, once.
    std::size_t bytes = 0;
    for (auto const& line : Tile<Mk2, ThreeInOne>::ledger())
        if (std::string(line.what) == "channel, 8 ends") bytes += line.bytes;
    CHECK(bytes == 8u * (8 + 6 * 4));
    std::size_t stored = 0;
    for (auto const& [name, n] : standin::tile_bytes(graph.engine(), 1).variables)
        if (name.find("Low") == 0) stored += n;
    CHECK(stored == bytes);
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
    standin::With const restore(standin::settings());
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
    standin::With const restore(standin::settings());
    standin::settings().tiles = 3;
    auto manager = poplar::DeviceManager::createDeviceManager();
    auto devices = manager.getDevices(poplar::TargetType::IPU, 1);
    auto small = options("test");
    small.device = &devices[0];
    CHECK(has(error_of([&] { PoplarMesh<Ticking>{{}, Grid{2, 2}, small}; }), "3 tiles"));
}
} // namespace
