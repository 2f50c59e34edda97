// test: unoptimised test asan tsan
#include "everywhere.hpp"
#include "programs.hpp"

using namespace engine_test;

namespace {

struct Seen : Buffer<std::uint32_t, 32> {};
struct Seed {
    std::uint32_t value;
};
struct Red : Channel<std::uint32_t, 4> {};
struct Blue : Channel<std::uint32_t, 4> {};

template <class Ends>
std::uint32_t mail_in(Ends const& in)
{
    std::uint32_t n = 0;
    for (Direction d : news) n += in[d].size();
    return n;
}

struct Nothing {
    void operator()() const noexcept {}
};
/// Sends on all sides if the tile's seed is set.
template <class C>
struct Send {
    void operator()(Seed const& seed, Out<C> out) const noexcept
    {
        if (seed.value == 0) return;
        for (Direction d : news) out[d].push(seed.value);
    }
};
template <class C>
struct Read {
    void operator()(Seen& seen, In<C> in) const noexcept { seen.push(mail_in(in)); }
};
/// Read that does nothing on a tile without mail, so it need not vote.
template <class C>
struct ReadMail {
    void operator()(Seen& seen, In<C> in) const noexcept
    {
        if (mail_in(in) != 0) seen.push(mail_in(in));
    }
};
template <class C>
struct SendThenLook {
    void operator()(Seen& seen, In<C> in, Out<C> out) const noexcept
    {
        for (Direction d : news) out[d].push(7);
        seen.push(mail_in(in));
    }
};

template <class M>
WordList seen(M& mesh, TileId t)
{
    auto const list = mesh.template state<Seen>(t);
    return {list.begin(), list.end()};
}
auto const seed_all = [](auto& mesh) {
    for (std::uint32_t i = 0; i < mesh.grid().size(); ++i) mesh.template state<Seed>(mesh.grid().tile(i)).value = i + 1;
};
auto const seed_none = [](auto&) {};

} // namespace

TEST_CASE("a write is invisible before the exchange, to the neighbours and to the tile itself")
{
    using Program = Repeat<SendThenLook<Red>>;
    for (Grid const grid : {Grid{1, 1}, Grid{3, 3}}) {
        auto const p = everywhere<Program>(grid, seed_none, 1, Program{3});
        for (std::uint32_t i = 0; i < grid.size(); ++i) CHECK(seen(*p.mesh, grid.tile(i)) == WordList{0, 4, 4});
    }
}

TEST_CASE("mail is read once")
{
    using Program = Sequence<Superstep<Send<Red>>, Superstep<Read<Red>>, Superstep<Read<Red>>>;
    auto const p = everywhere<Program>({4, 2}, seed_all, 2);
    for (std::uint32_t i = 0; i < 8; ++i) CHECK(seen(*p.mesh, p.mesh->grid().tile(i)) == WordList{4, 0, 4, 0});
    for (std::uint32_t i = 0; i < 8; ++i)
        for (Direction d : news) CHECK(p.mesh->incoming<Red>(p.mesh->grid().tile(i), d).empty());
}

TEST_CASE("mail outlives steps that do not read it, and steps on other channels")
{
    using Program = Sequence<Superstep<Send<Red>>, Superstep<Nothing>, Superstep<Send<Blue>>, Superstep<Read<Blue>>,
                             Repeat<Nothing>, Superstep<Read<Red>>>;
    Program program;
    get_step<Nothing, 1>(program).times = 3;
    auto const p = everywhere<Program>({4, 2}, seed_all, 2, program);
    CHECK(p.step(4).passes == 3);
    for (std::uint32_t i = 0; i < 8; ++i) CHECK(seen(*p.mesh, p.mesh->grid().tile(i)) == WordList{4, 4, 4, 4});
    CHECK(p.step(0).exchanges == 1);
    CHECK(p.step(1).exchanges == 0);
    CHECK(p.last().exchanges() == 2);
}

TEST_CASE("mail outlives a run")
{
    using Program = Sequence<Superstep<Read<Red>>, Superstep<Send<Red>>>;
    auto const p = everywhere<Program>({3, 1}, seed_all, 3);
    for (std::uint32_t i = 0; i < 3; ++i) CHECK(seen(*p.mesh, TileId::at(i, 0)) == WordList{0, 4, 4});
    for (Direction d : news) CHECK(p.mesh->incoming<Red>(TileId::at(1, 0), d).size() == 1); // the mail is still there
}

TEST_CASE("messages come from the side they were sent on; edges return a tile's own on the same side")
{
    for (Grid const grid : {Grid{1, 1}, Grid{2, 1}, Grid{1, 3}, Grid{4, 3}}) {
        CAPTURE(grid.width);
        CAPTURE(grid.height);
        using Program = Sequence<Superstep<Read<Red>>, Superstep<Send<Red>>>;
        auto const p = everywhere<Program>(grid, seed_all);
        for (std::uint32_t i = 0; i < grid.size(); ++i)
            for (Direction d : news) {
                auto const t = grid.tile(i);
                auto const end = p.mesh->incoming<Red>(t, d);
                REQUIRE(end.size() == 1);
                CHECK(end[0] == grid.index_of(grid.neighbour(t, d)) + 1);
            }
    }
}

namespace {

struct Spring {
    std::uint32_t left;
};
struct Wind {
    Vote operator()(Spring const& spring) const noexcept { return spring.left != 0 ? Vote::busy : Vote::quiet; }
};
struct Unwind {
    Vote operator()(Spring& spring) const noexcept
    {
        if (spring.left != 0) --spring.left;
        return spring.left != 0 ? Vote::busy : Vote::quiet;
    }
};
auto const wind = [](auto& mesh) {
    mesh.template state<Spring>(TileId::at(0, 0)).left = 1;
    mesh.template state<Spring>(TileId::at(4, 1)).left = 5;
    mesh.template state<Spring>(TileId::at(2, 3)).left = 3;
};

} // namespace

TEST_CASE("UntilQuiet tests before its first pass: nothing to do costs nothing")
{
    auto const p = everywhere<Sequence<UntilQuiet<Unwind>, Superstep<Wind>>>({5, 4}, wind); // alone it would be a run of nothing: per_pass.cpp
    CHECK(p.step(0).passes == 0);
    CHECK(p.step(0).tile_runs == 0);
    CHECK(p.last().digests.size() == 1);
    CHECK(p.mesh->state<Spring>(TileId::at(4, 1)).left == 5);
}

TEST_CASE("the votes of the superstep before, another kernel's, start UntilQuiet; its own carry it on")
{
    auto const p = everywhere<Sequence<Superstep<Wind>, UntilQuiet<Unwind>>>({5, 4}, wind);
    CHECK(p.step(0).tile_runs == 20);
    CHECK(p.step(1).passes == 5);
    CHECK(p.step(1).tile_runs == 1 + 5 + 3);
    CHECK(p.last().exchanges() == 0); // no tile sends
    for (std::uint32_t i = 0; i < 20; ++i) CHECK(p.mesh->state<Spring>(p.mesh->grid().tile(i)).left == 0);
}

TEST_CASE("votes hold for the next superstep alone, whatever steps make no pass in between")
{
    SUBCASE("a step of no passes keeps them")
    {
        using Program = Sequence<Superstep<Wind>, Repeat<Nothing>, UntilQuiet<Unwind>, UntilQuiet<Unwind>>;
        Program program;
        get_step<Nothing>(program).times = 0;
        std::get<2>(program.steps).at_most = 0;
        auto const p = everywhere<Program>({5, 4}, wind, 1, program);
        CHECK(p.step(1).passes == 0);
        CHECK(p.step(2).passes == 0);
        CHECK(p.step(3).passes == 5);
    }
    SUBCASE("a superstep whose kernel does not vote is quiet")
    {
        auto const p = everywhere<Sequence<Superstep<Wind>, Superstep<Nothing>, UntilQuiet<Unwind>>>({5, 4}, wind);
        CHECK(p.step(2).passes == 0);
    }
    SUBCASE("they do not outlive a run")
    {
        auto const odd = everywhere<Sequence<UntilQuiet<Unwind>, Superstep<Wind>>>({5, 4}, wind, 3);
        CHECK(odd.step(0).passes == 0);
        auto const even = everywhere<Sequence<UntilQuiet<Unwind>, Superstep<Nothing>, Superstep<Wind>>>({5, 4}, wind, 3);
        CHECK(even.step(0).passes == 0);
    }
    SUBCASE("a cut UntilQuiet hands them on")
    {
        using Program = Sequence<Superstep<Wind>, UntilQuiet<Unwind>, UntilQuiet<Unwind>>;
        Program program;
        std::get<1>(program.steps).at_most = 2;
        auto const p = everywhere<Program>({5, 4}, wind, 1, program);
        CHECK(p.step(1).passes == 2);
        CHECK(p.step(1).tile_runs == 3 + 2);
        CHECK(p.step(2).passes == 3);
        CHECK(p.step(2).tile_runs == 2 + 1 + 1);
    }
}

TEST_CASE("Repeat and Superstep run every tile, quiet or not; no times none, by default once")
{
    using Program = Sequence<Repeat<Unwind>, Repeat<Unwind>, Superstep<Unwind>, Repeat<Unwind>>;
    auto const p = everywhere<Program>({5, 4}, wind, 1, Program{{4}, {0}, {}, {}});
    CHECK(p.step(0).passes == 4);
    CHECK(p.step(0).tile_runs == 80);
    CHECK(p.step(1).passes == 0);
    CHECK(p.step(1).tile_runs == 0);
    CHECK(p.step(2).tile_runs == 20);
    CHECK(p.step(3).passes == 1);
    CHECK(p.last().tile_runs() == 120);
}

namespace {

/// Throws the ball, and catches the ball that is still under way from the previous run.
struct Toss {
    void operator()(Ball& ball, Visits& visits, In<Lane> in, Out<Lane> out) const noexcept
    {
        Catch{}(visits, in, out);
        if (ball.throws != 0) out[Direction::east].push(ball.throws - 1);
        ball.throws = 0;
    }
};

} // namespace

TEST_CASE("at_most cuts, at 0, 1, n - 1, n and n + 1, and the next run goes on where it stopped")
{
    using Program = Sequence<Superstep<Toss>, UntilQuiet<Catch>>;
    constexpr std::uint32_t throws = 10;
    for (std::uint32_t at_most : {0u, 1u, 3u, 9u, 10u, 11u, 0xffffffffu}) {
        CAPTURE(at_most);
        Program program;
        std::get<1>(program.steps).at_most = at_most;
        auto const p = everywhere<Program>(
            {4, 1}, [](auto& mesh) { mesh.template state<Ball>(TileId::at(1, 0)).throws = throws; }, 12, program);
        std::uint32_t left = throws; // catches that are still to come
        for (std::size_t r = 0; r < p.runs.size(); ++r) {
            CAPTURE(r);
            if (r > 0 && left > 0) --left; // Toss catches one
            auto const now = std::min(left, at_most);
            CHECK(p.runs[r].steps[1].passes == now);
            CHECK(p.runs[r].steps[1].tile_runs == now);
            left -= now;
        }
        CHECK(left == 0);
        std::uint32_t caught = 0;
        for (std::uint32_t x = 0; x < 4; ++x) caught += p.mesh->state<Visits>(TileId::at(x, 0)).count;
        CHECK(caught == throws);
    }
}

TEST_CASE("a program is a value: its bound can change between runs")
{
    using Program = Sequence<Superstep<Toss>, UntilQuiet<Catch>>;
    on_each<Program>({4, 1}, [](auto& mesh) {
        mesh.template state<Ball>(TileId::at(1, 0)).throws = 10;
        std::get<1>(mesh.program().steps).at_most = 2;
        CHECK(mesh.run().steps[1].passes == 2);
        std::get<1>(mesh.program().steps).at_most = 3;
        CHECK(mesh.run().steps[1].passes == 3);
        std::get<1>(mesh.program().steps).at_most = 0xffffffffu;
        CHECK(mesh.run().steps[1].passes == 10 - 2 - 1 - 3 - 1);
        CHECK(mesh.run().steps[1].passes == 0);
    });
}

namespace {

template <std::uint32_t Word>
struct Notify { // one tile sends a note without messages eastwards
    void operator()(Here here, Out<Red> out) const noexcept
    {
        if (here.tile == TileId::at(1, 1)) out[Direction::east].set_note(Word);
    }
};
struct ReadNote {
    void operator()(Seen& seen, In<Red> in) const noexcept
    {
        for (Direction d : news)
            if (in[d].note() != 0) seen.push(in[d].note() + index(d));
    }
};

} // namespace

TEST_CASE("a note alone is mail: it wakes its receiver, is read once, and makes an exchange")
{
    auto const p =
        everywhere<Sequence<Superstep<Notify<100>>, UntilQuiet<ReadNote>, Superstep<ReadNote>>>({4, 3}, seed_none);
    CHECK(p.step(0).exchanges == 1);
    CHECK(p.step(0).messages == 0);
    CHECK(p.step(0).live_bytes == 0);
    CHECK(p.step(0).capacity_bytes == 16 * 12 * (2 + 4));
    CHECK(p.step(1).passes == 1);
    CHECK(p.step(1).tile_runs == 1);
    CHECK(p.last().peaks.back().items == 0);
    for (std::uint32_t i = 0; i < 12; ++i) {
        auto const t = p.mesh->grid().tile(i);
        CHECK(seen(*p.mesh, t) == (t == TileId::at(2, 1) ? WordList{100 + index(Direction::west)} : WordList{}));
    }
}

TEST_CASE("a note of 0 is no mail")
{
    auto const p = everywhere<Sequence<Superstep<Notify<0>>, UntilQuiet<ReadNote>>>({4, 3}, seed_none);
    CHECK(p.last().exchanges() == 0);
    CHECK(p.step(0).capacity_bytes == 0);
    CHECK(p.step(1).passes == 0);
}

TEST_CASE("mail on a channel that a kernel does not read does not wake it")
{
    using Program = Sequence<Superstep<Send<Red>>, UntilQuiet<ReadMail<Blue>>, UntilQuiet<ReadMail<Red>>>;
    auto const p = everywhere<Program>({3, 3}, [](auto& mesh) { mesh.template state<Seed>(TileId::at(1, 1)).value = 5; });
    CHECK(p.step(1).passes == 0);
    CHECK(p.step(2).passes == 1);
    CHECK(p.step(2).tile_runs == 4); // the four neighbours
}

namespace {

struct Look {
    std::uint32_t tile, width, height, word;
};
struct Parameters {
    std::uint32_t word;
};
struct WhereAmI {
    void operator()(Look& look, Here here, Broadcast<Parameters> p) const noexcept
    {
        look = {here.tile.packed, here.grid.width, here.grid.height, p->word};
    }
};

} // namespace

TEST_CASE("every tile knows where it is, and holds the broadcast of this run")
{
    on_each<Superstep<WhereAmI>>({7, 5}, [](auto& mesh) {
        for (std::uint32_t word : {11u, 12u}) {
            mesh.template broadcast<Parameters>().word = word;
            mesh.run();
            for (std::uint32_t y = 0; y < 5; ++y)
                for (std::uint32_t x = 0; x < 7; ++x) {
                    auto const& look = mesh.template state<Look>(TileId::at(x, y));
                    CHECK(look.tile == TileId::at(x, y).packed);
                    CHECK(look.width == 7);
                    CHECK(look.height == 5);
                    CHECK(look.word == word);
                }
        }
    });
}

namespace {

struct Cells : Buffer<std::uint32_t, 20> {};
struct Size {
    void operator()(Cells& cells) const noexcept
    {
        cells.resize(20);
        for (auto& cell : cells) cell = 0;
    }
};
struct Fill {
    void operator()(Cells& cells, Worker worker, Here here) const noexcept
    {
        for (std::uint32_t i = worker.index; i < cells.size(); i += worker.count)
            cells[i] = here.tile.packed * 10000 + worker.count * 1000 + worker.index * 100 + i;
    }
};
struct TwoWorkers : Mk2 {
    static constexpr std::uint32_t workers = 2;
};
template <class Machine>
void check_workers()
{
    auto const p = everywhere<Sequence<Superstep<Size>, Superstep<Fill>>, Machine>({3, 2}, seed_none);
    for (std::uint32_t t = 0; t < 6; ++t) {
        auto const tile = p.mesh->grid().tile(t);
        auto const cells = p.mesh->template state<Cells>(tile);
        REQUIRE(cells.size() == 20);
        for (std::uint32_t i = 0; i < 20; ++i)
            CHECK(cells[i] == tile.packed * 10000 + Machine::workers * 1000 + i % Machine::workers * 100 + i);
    }
    CHECK(p.step(1).tile_runs == 6); // one tile run per tile, for any number of workers
}

// The guide's example: each worker writes a word of its own, and a kernel without Worker adds them up.
struct Stock : Buffer<std::uint32_t, 1000> {};
struct Sums { std::uint32_t of[6]; }; // of[worker]: at least as many as the machine has workers
struct AddUp {
    void operator()(Worker worker, Stock const& stock, Sums& sums) const noexcept
    {
        sums.of[worker.index] = 0;
        for (auto i = worker.index; i < stock.size(); i += worker.count) sums.of[worker.index] += stock[i];
    }
};
struct Sum {
    std::uint32_t value;
};
struct Stocked {
    void operator()(Stock& stock, Here here) const noexcept
    {
        for (std::uint32_t i = 0; i < 100 + here.tile.x(); ++i) stock.push(i);
    }
};
struct AddSums {
    void operator()(Sums const& sums, Sum& sum) const noexcept
    {
        for (std::uint32_t const one : sums.of) sum.value += one;
    }
};
template <class Machine>
void check_sums()
{
    auto const p = everywhere<Sequence<Superstep<Stocked>, Superstep<AddUp>, Superstep<AddSums>>, Machine>({3, 2}, seed_none);
    for (std::uint32_t t = 0; t < 6; ++t) {
        auto const tile = p.mesh->grid().tile(t);
        std::uint32_t const n = 100 + tile.x();
        CHECK(p.mesh->template state<Sum>(tile).value == n * (n - 1) / 2);
    }
}

} // namespace

TEST_CASE("all workers of a tile add up a list: a word a worker, and a kernel that adds the words")
{
    check_sums<Mk2>();
    check_sums<TwoWorkers>();
}

TEST_CASE("a kernel that takes Worker runs all shares of the machine's workers")
{
    check_workers<Mk2>();
    check_workers<TwoWorkers>();
}

namespace {

struct TwoChannels {
    void operator()(Seen& seen, In<Red> red_in, In<Blue> blue_in, Out<Blue> blue_out, Out<Red> red_out) const noexcept
    {
        red_out[Direction::east].push(1);
        blue_out[Direction::north].push(2);
        blue_out[Direction::north].push(3);
        seen.push(mail_in(red_in) * 10 + mail_in(blue_in));
    }
};

} // namespace

TEST_CASE("counters add up over the channels of a kernel; each exchange moves both at full capacity")
{
    auto const p = everywhere<Repeat<TwoChannels>>({4, 3}, seed_none, 1, {3});
    CHECK(p.step(0).messages == 3 * 12 * 3);
    CHECK(p.step(0).live_bytes == 4 * 3 * 12 * 3);
    CHECK(p.step(0).exchanges == 3);
    CHECK(p.step(0).capacity_bytes == 3 * 2 * 16 * 12 * (2 + 4));
    REQUIRE(p.last().peaks.size() == 3);
    CHECK(p.last().peaks[0].region == "Seen");
    CHECK(p.last().peaks[0].items == 3);
    CHECK(p.last().peaks[1].region == "Red");
    CHECK(p.last().peaks[1].items == 1);
    CHECK(p.last().peaks[2].region == "Blue");
    CHECK(p.last().peaks[2].items == 2);
    CHECK(p.last().peaks[2].capacity == 4);
}

TEST_CASE("counters and peaks begin anew in each run")
{
    using Program = Sequence<Superstep<Send<Red>>, Superstep<Read<Red>>>;
    on_each<Program>({3, 3}, [](auto& mesh) {
        seed_all(mesh);
        auto const first = mesh.run();
        CHECK(first.messages() == 36);
        CHECK(first.peaks.back().items == 1);
        for (std::uint32_t i = 0; i < 9; ++i) mesh.template state<Seed>(mesh.grid().tile(i)).value = 0;
        auto const second = mesh.run();
        CHECK(second.messages() == 0);
        CHECK(second.exchanges() == 0);
        CHECK(second.peaks.back().items == 0);
        CHECK(second.steps[0].passes == 1);
    });
}

TEST_CASE("an empty program, and one of kernels that take nothing, run")
{
    auto const none = everywhere<Sequence<>>({3, 3}, seed_none);
    CHECK(none.last().steps.empty());
    CHECK(none.last().peaks.empty());
    auto const idle = everywhere<Superstep<Nothing>>({3, 3}, seed_none);
    CHECK(idle.step(0).tile_runs == 9);
}

TEST_CASE("nested sequences are their steps in order")
{
    using Flat = Sequence<Superstep<Send<Red>>, Superstep<Read<Red>>, Repeat<SendThenLook<Blue>>, Superstep<Read<Blue>>>;
    using Nested = Sequence<Sequence<Superstep<Send<Red>>>,
                            Sequence<Superstep<Read<Red>>, Sequence<Repeat<SendThenLook<Blue>>>>, Superstep<Read<Blue>>>;
    Flat flat_program;
    Nested nested_program;
    get_step<SendThenLook<Blue>>(flat_program).times = get_step<SendThenLook<Blue>>(nested_program).times = 2;
    auto const flat = everywhere<Flat>({4, 3}, seed_all, 1, flat_program);
    auto const nested = everywhere<Nested>({4, 3}, seed_all, 1, nested_program);
    check_same(flat.last(), nested.last());
    CHECK(words_of(*flat.mesh) == words_of(*nested.mesh));
}

TEST_CASE("no threads asked for is one thread, and more threads than tiles do no harm")
{
    for (std::uint32_t threads : {0u, 1u, 16u}) {
        CAPTURE(threads);
        Mesh<Sequence<Superstep<Wind>, UntilQuiet<Unwind>>> mesh{{}, {1, 1}, {.threads = threads}};
        mesh.state<Spring>(TileId::at(0, 0)).left = 9;
        CHECK(mesh.run().steps[1].passes == 9);
        CHECK(mesh.state<Spring>(TileId::at(0, 0)).left == 0);
    }
}
