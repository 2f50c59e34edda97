// test: unoptimised test asan tsan
// Statistics of one pass: a state that no vote and no digest is about. And what CheckedMesh says of a kernel that is not quiet.
#include "everywhere.hpp"
#include "programs.hpp"

#define main main_of_traffic
#include "../../examples/traffic.cpp"
#undef main

using namespace engine_test;

namespace {

struct Ticks : Buffer<std::uint32_t, 4> {};
struct Wire : Channel<std::uint32_t, 1, Edge::drop> {};
struct Total {
    std::uint32_t pad, left, seen;
};
struct Tally {
    static constexpr bool per_pass = true;
    std::uint32_t steps, zero;
};
struct CountDown { // adds to the tally without clearing it
    Vote operator()(Total& total, Tally& tally) const noexcept
    {
        tally.zero = 100 + tally.steps;
        ++tally.steps;
        if (total.left != 0) --total.left;
        return total.left != 0 ? Vote::busy : Vote::quiet;
    }
    struct Work {
        enum Kind : std::uint32_t { step };
        static constexpr char const* names[] = {"step"};
    };
    static Operations<Work> operations(Tally const& tally) noexcept { return {{{tally.steps}}}; }
};
struct CountDownWithout {
    Vote operator()(Total& total) const noexcept
    {
        if (total.left != 0) --total.left;
        return total.left != 0 ? Vote::busy : Vote::quiet;
    }
};
using CountProgram = Sequence<Superstep<CountDown>, UntilQuiet<CountDown>>;
using CountProgramWithout = Sequence<Superstep<CountDownWithout>, UntilQuiet<CountDownWithout>>;

constexpr Grid grid{4, 3};
template <class M>
void load(M& mesh)
{
    for (auto [tile, total] : mesh.template states<Total>()) total.left = 1 + tile.x();
}
/// A mesh of random traffic after its run: the program of examples/traffic.cpp.
template <class M>
RunCounters drive(M& mesh)
{
    mesh.template limit<::Road>(4);
    std::mt19937 random{1};
    for (auto [tile, waiting] : mesh.template states<::Waiting>())
        for (int i = 0; i < 30; ++i) waiting.push({mesh.grid().tile(random() % 64u)});
    return mesh.run();
}

} // namespace

TEST_CASE("the program of the traffic example runs on CheckedMesh, with the counters, words and operations of Mesh")
{
    using Program = Sequence<Superstep<Forward>, UntilQuiet<Forward>>;
    Mesh mesh{Program{}, Grid{8, 8}, Traced<Mk2>{}, {.threads = 2, .digest = true}};
    CheckedMesh checked{Program{}, Grid{8, 8}, Traced<Mk2>{}, {.digest = true}};
    auto const run = drive(mesh);
    check_same(drive(checked), run);
    CHECK(words_of(checked) == words_of(mesh));
    REQUIRE(mesh.trace().supersteps.size() == checked.trace().supersteps.size());
    std::uint64_t hops = 0;
    for (std::size_t i = 0; i < mesh.trace().supersteps.size(); ++i) {
        auto const &a = mesh.trace().supersteps[i].tiles, &b = checked.trace().supersteps[i].tiles;
        REQUIRE(a.size() == b.size());
        for (std::size_t t = 0; t < a.size(); ++t) {
            CHECK(a[t].operations == b[t].operations);
            hops += a[t].operations[Work::hop];
        }
    }
    CHECK(hops == run.messages()); // each pass counts its own hops
}

TEST_CASE("within an observer, the last superstep of the trace is that of the event")
{
    auto const check = [](auto& mesh) {
        std::size_t events = 0;
        std::uint64_t hops = 0;
        mesh.observe([&](SuperstepEvent const& event) {
            REQUIRE(mesh.trace().supersteps.size() == ++events);
            auto const& superstep = mesh.trace().supersteps.back();
            CHECK(superstep.step == event.step);
            CHECK(superstep.tiles.size() == event.tile_runs);
            std::uint64_t of_pass = 0;
            for (auto const& tile : superstep.tiles) of_pass += tile.operations[Work::hop];
            CHECK(of_pass == event.messages);
            hops += of_pass;
        });
        auto const run = drive(mesh);
        CHECK(hops == run.messages());
        CHECK(events == run.steps[0].passes + run.steps[1].passes);
    };
    using Program = Sequence<Superstep<Forward>, UntilQuiet<Forward>>;
    Mesh mesh{Program{}, Grid{8, 8}, Traced<Mk2>{}, {.threads = 2}};
    CheckedMesh checked{Program{}, Grid{8, 8}, Traced<Mk2>{}};
    check(mesh);
    check(checked);
}

TEST_CASE("live_bytes are those of messages; a trace counts the 8-byte head of each end that carried something, too")
{
    Mesh mesh{Sequence<Superstep<Forward>, UntilQuiet<Forward>>{}, Grid{8, 8}, Traced<Mk2>{}};
    auto const run = drive(mesh);
    std::uint64_t traced = 0, ends = 0, live = 0;
    for (auto const& superstep : mesh.trace().supersteps)
        for (auto const& tile : superstep.tiles)
            for (auto bytes : tile.sent_bytes) {
                traced += bytes;
                ends += bytes != 0 ? 1 : 0;
                CHECK((bytes == 0 || (bytes >= 8 + 4 && bytes <= 8 + 4 * 4))); // one to four parcels of 4 bytes
            }
    for (auto const& step : run.steps) live += step.live_bytes;
    CHECK(live == 4 * run.messages());
    CHECK(traced == live + 8 * ends);
}

TEST_CASE("per_pass statistics are 0 when a kernel begins, and keep the words of the last run of their tile")
{
    auto const check = [](auto& mesh) {
        load(mesh);
        auto const run = mesh.run();
        CHECK(run.steps[1].passes == 3);
        for (auto [tile, tally] : mesh.template states<Tally>()) {
            CHECK(tally.steps == 1);
            CHECK(tally.zero == 100);
        }
        std::uint64_t steps = 0;
        for (auto const& superstep : mesh.trace().supersteps)
            for (auto const& tile : superstep.tiles) steps += tile.operations[0];
        CHECK(steps == 3 * (1 + 2 + 3 + 4)); // a column of three tiles for each number
    };
    Mesh mesh{CountProgram{}, grid, Traced<Mk2>{}};
    CheckedMesh checked{CountProgram{}, grid, Traced<Mk2>{}};
    check(mesh);
    check(checked);
    mesh.state<Tally>(TileId::at(2, 1)) = {77, 88}; // the host's words: an engine clears them before the kernel
    check(mesh);
}

TEST_CASE("per_pass statistics take SRAM, and no digest has them")
{
    Mesh with{CountProgram{}, grid, {.digest = true}};
    Mesh without{CountProgramWithout{}, grid, {.digest = true}};
    CHECK(with.sram_bytes() == without.sram_bytes() + sizeof(Tally));
    load(with);
    load(without);
    CHECK(with.run().digests == without.run().digests);
}

namespace {

enum class Lie { word, list_size, item, message, note, vote };
template <Lie What>
struct Liar { // counts to 5, and says each time that it is done; tile (0, 0) votes busy as long as it has something left
    Vote operator()(Here here, Total& total, Ticks& ticks, In<Wire>, Out<Wire> out) const noexcept
    {
        if (total.left == 0) return Vote::quiet;
        if (here.tile == TileId::at(0, 0)) return --total.left != 0 ? Vote::busy : Vote::quiet;
        if constexpr (What == Lie::word) {
            if (total.seen < 5) ++total.seen;
        } else if constexpr (What == Lie::list_size) {
            (void)ticks.try_push(9);
        } else if constexpr (What == Lie::item) {
            if (ticks.size() < 2) {
                ticks.resize(2);
                ticks[0] = ticks[1] = 6;
            }
            ++ticks[1];
        } else if constexpr (What == Lie::message) {
            if (total.pad != 0) out[Direction::east].push(1);
            total.pad = 1;
        } else if constexpr (What == Lie::note) {
            if (total.pad != 0) out[Direction::east].set_note(1);
            total.pad = 1;
        } else {
            if (total.pad != 0) return Vote::busy;
            total.pad = 1;
        }
        return Vote::quiet;
    }
};
template <Lie What>
std::string caught(bool check = true, std::uint32_t busy = 0)
{
    CheckedMesh<Sequence<Superstep<Liar<What>>, UntilQuiet<Liar<What>>>> mesh{{}, grid, {.check_quiet_tiles = check}};
    mesh.template state<Total>(TileId::at(1, 2)).left = 1;
    mesh.template state<Total>(TileId::at(0, 0)).left = busy;
    return error_of([&] { mesh.run(); });
}
constexpr char end_of_text[] = "Vote says busy while running again without mail would change a word); vote busy earlier";

} // namespace

TEST_CASE("a wrong quiet vote is found where every tile votes quiet and beside a busy one, and the error names the state and the word")
{
    std::string const quiet = " on a tile that was quiet and had no mail (", place = " [tile (1, 2), superstep 1 (Liar)]";
    for (std::uint32_t busy : {0u, 4u}) {
        CAPTURE(busy);
        CHECK(caught<Lie::word>(true, busy) == "a kernel changed state Total" + quiet + "word 2, at byte 8, was 1 and became 2; " + end_of_text +
                                                   ", or keep statistics of one pass in a per_pass state" + place);
        CHECK(caught<Lie::list_size>(true, busy) == "a kernel changed list Ticks" + quiet + "its size was 1 and became 2; " + end_of_text + place);
        CHECK(caught<Lie::item>(true, busy) == "a kernel changed list Ticks" + quiet + "word 0 of item 1 was 7 and became 8; " + end_of_text + place);
        CHECK(caught<Lie::message>(true, busy) == "a kernel sent on channel Wire" + quiet + end_of_text + place);
        CHECK(caught<Lie::note>(true, busy) == "a kernel sent on channel Wire" + quiet + end_of_text + place);
        CHECK(caught<Lie::vote>(true, busy) == "a kernel voted busy" + quiet + end_of_text + place);
        CHECK(caught<Lie::word>(false, busy).empty()); // the check is off
    }
}

TEST_CASE("the pass that looks for wrong votes leaves the states, mail and counters of an honest program")
{
    auto const run = [](bool check) {
        CheckedMesh<CountProgram, Traced<Mk2>> mesh{{}, grid, {.digest = true, .check_quiet_tiles = check}};
        load(mesh);
        auto counters = mesh.run();
        return std::tuple(counters, words_of(mesh), mesh.trace().supersteps.size());
    };
    auto const with = run(true), without = run(false);
    check_same(std::get<0>(with), std::get<0>(without));
    CHECK(std::get<1>(with) == std::get<1>(without));
    CHECK(std::get<2>(with) == std::get<2>(without));
}

namespace {

template <bool Early>
struct Stop { // all other tiles follow tile (0, 0) one pass later; `Early`: they vote quiet one pass too early
    Vote operator()(Here here, Total& total) const noexcept
    {
        if (total.seen < 3) ++total.seen;
        std::uint32_t const last = Early && here.tile != TileId::at(0, 0) ? 2 : 3;
        return total.seen < last ? Vote::busy : Vote::quiet;
    }
};
struct DelayedSender { // sends in its third run, and says after each that it is done
    Vote operator()(Total& total, In<Wire> in, Out<Wire> out) const noexcept
    {
        for (auto side : news)
            for (auto word : in[side]) total.seen += word;
        if (total.pad < 3 && ++total.pad == 3) out.to_all(1u);
        return Vote::quiet;
    }
};
template <class Program>
std::string refused()
{
    CheckedMesh<Program> mesh{{}, grid};
    return error_of([&] { mesh.run(); });
}

} // namespace

TEST_CASE("wrong quiet votes: too early, and of senders that wait; a step for which nobody voted is no vote")
{
    CHECK(refused<Sequence<Superstep<Stop<false>>, UntilQuiet<Stop<false>>>>().empty());
    CHECK(has(refused<Sequence<Superstep<Stop<true>>, UntilQuiet<Stop<true>>>>(), "word 2, at byte 8, was 2 and became 3"));
    CHECK(has(refused<Sequence<Superstep<DelayedSender>, UntilQuiet<DelayedSender>>>(), "word 0, at byte 0, was 1 and became 2"));
    CHECK(refused<Sequence<UntilQuiet<Stop<false>>, Superstep<Stop<false>>>>().empty());     // at the start of a run nobody has voted
    CHECK(refused<Sequence<Superstep<CountDown>, UntilQuiet<Stop<false>>>>().empty());       // the votes were about another kernel
}

namespace {

struct Shout {
    Vote operator()(In<Wire>, Out<Wire> out) const noexcept
    {
        out.to_all(1u);
        return Vote::quiet;
    }
};
struct Hear {
    void operator()(Total& total, In<Wire> in, Out<Wire>) const noexcept
    {
        for (auto side : news)
            for (auto word : in[side]) total.seen += word;
    }
};

} // namespace

TEST_CASE("what a kernel sends when it is only tried on a tile does not arrive")
{
    using Program = Sequence<UntilQuiet<Shout>, Repeat<Hear>>;
    CheckedMesh<Program> mesh{Program{{}, {3}}, grid};
    auto const run = mesh.run();
    CHECK(run.steps[0].passes == 0);
    CHECK(run.steps[1].exchanges == 0);
    for (auto [tile, total] : mesh.states<Total>()) CHECK(total.seen == 0);
}

TEST_CASE("a run in which no tile runs, because nobody has voted, is an error if a pass would change a word")
{
    std::string const text = "a run in which no tile ran (UntilQuiet runs the tiles that voted busy, and nobody had voted; another run of the kernel "
                             "would change a word); begin with Superstep<";
    CHECK(refused<UntilQuiet<Liar<Lie::word>>>().empty()); // it has nothing to do
    CHECK(refused<UntilQuiet<Stop<false>>>() == text + "Stop> [tile (0, 0)]");
    CHECK(refused<Sequence<UntilQuiet<CountDown>, UntilQuiet<Stop<false>>>>() == text + "Stop> [tile (0, 0)]");
    CheckedMesh<UntilQuiet<Stop<false>>> without{{}, grid, {.check_quiet_tiles = false}};
    CHECK(error_of([&] { without.run(); }).empty());
    CheckedMesh<UntilQuiet<Stop<false>>> mesh{{}, grid};
    for (auto [tile, total] : mesh.states<Total>()) total.seen = 3; // done
    CHECK(error_of([&] { mesh.run(); }).empty());
    mesh.state<Total>(TileId::at(2, 1)).seen = 2;
    for (int run = 0; run < 2; ++run) CHECK(error_of([&] { mesh.run(); }) == text + "Stop> [tile (2, 1)]");
    CHECK(mesh.state<Total>(TileId::at(2, 1)).seen == 2); // put back
    mesh.state<Total>(TileId::at(2, 1)).seen = 3;
    CHECK(error_of([&] { mesh.run(); }).empty());
}
