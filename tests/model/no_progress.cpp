// test: unoptimised test asan, without tsan
#include "../engine/everywhere.hpp"
#include <tilemesh/model/no_progress.hpp>

// Programs that never become quiet: the repetition is found and named; programs that make progress are left alone; most_passes stops a run.
using namespace engine_test;

namespace {
struct Parcel {
    std::uint32_t weight;
};
struct Track : Channel<Parcel, 2> {};
struct Point {
    std::uint32_t sends; ///< 1 + the side to which a tile passes its messages on; 0: it keeps them
    std::uint32_t kept;
};
/// Passes a message on to the side to which the tile points.
struct Hand {
    void operator()(Point& point, In<Track> in, Out<Track> out) const noexcept
    {
        for (Direction from : news)
            for (auto const& p : in[from]) {
                if (point.sends == 0) ++point.kept;
                else out[news[point.sends - 1]].push(p);
            }
    }
};
/// Sends the first parcels; the host sets their number.
struct First {
    std::uint32_t parcels;
};
struct Launch {
    void operator()(First& first, Point const& point, Out<Track> out) const noexcept
    {
        for (; first.parcels > 0; --first.parcels) out[news[point.sends - 1]].push({first.parcels});
    }
};
using Handing = Sequence<Superstep<Launch>, UntilQuiet<Hand>>;

void point(auto& mesh, TileId t, Direction d) { mesh.template state<Point>(t).sends = 1 + index(d); }
/// Every tile of a row but the last points eastwards; the first one sends parcels.
void point_along(auto& mesh, Grid row, std::uint32_t parcels)
{
    for (std::uint32_t x = 0; x + 1 < row.width; ++x) point(mesh, TileId::at(x, 0), Direction::east);
    mesh.template state<First>(TileId::at(0, 0)).parcels = parcels;
}

/// The trace of a run that most_passes stops, and its error.
struct Stopped {
    Trace trace;
    std::string error;
};
template <class Program, class Load>
Stopped stopped(Grid grid, std::uint32_t most_passes, Load const& load)
{
    Stopped out;
    bool first = true;
    auto const on = [&](auto& mesh) {
        load(mesh);
        auto const error = error_of([&] { mesh.run(); });
        CHECK(has(error_of([&] { mesh.run(); }), "a mesh that stopped on an error cannot run again"));
        if (first) out = {mesh.trace(), error};
        CHECK(mesh.trace() == out.trace);
        CHECK(error == out.error);
        first = false;
    };
    using Machine = Traced<Mk2>;
    CheckedMesh<Program, Machine> one{{}, grid, {.most_passes = most_passes, .explain = explain_no_progress}};
    on(one);
    for (auto threads : thread_counts) {
        Mesh<Program, Machine> mesh{{}, grid, {.threads = threads, .most_passes = most_passes, .explain = explain_no_progress}};
        on(mesh);
    }
    return out;
}

TileId const ring[] = {TileId::at(1, 1), TileId::at(2, 1), TileId::at(2, 2), TileId::at(1, 2)};
Direction const ring_sides[] = {Direction::east, Direction::south, Direction::west, Direction::north};
constexpr Grid four{4, 4};
void round_four(auto& mesh)
{
    for (int i = 0; i < 4; ++i) point(mesh, ring[i], ring_sides[i]);
}
} // namespace

TEST_CASE("no progress: a parcel that goes round four tiles for ever")
{
    auto const s = stopped<Handing>(four, 100, [](auto& mesh) {
        round_four(mesh);
        mesh.template state<First>(ring[2]).parcels = 1;
    });
    auto const r = no_progress(s.trace, four);
    CHECK(!r.empty());
    CHECK(r.step == 1);
    CHECK(r.kernel == "Hand");
    CHECK(r.supersteps == 101);
    CHECK(r.period == 4);
    CHECK(r.first == 1);
    CHECK(r.tiles.empty()); // each tile runs in one of four supersteps
    CHECK(r.waiting.empty());
    CHECK(r.cycle == std::vector<TileSide>{{5, Direction::east}, {6, Direction::south}, {10, Direction::west}, {9, Direction::north}});
    CHECK(r.links == std::vector<TileSideUse>{{{5, Direction::east}, 1, 12, false, false},
                                          {{6, Direction::south}, 1, 12, false, false},
                                          {{9, Direction::north}, 1, 12, false, false},
                                          {{10, Direction::west}, 1, 12, false, false}});
    CHECK(text_of(r) == "step 1 (Hand) does the same every 4 supersteps from superstep 1 of the run on\n"
                        "messages can go round 4 tiles: (1, 1) east, (2, 1) south, (2, 2) west, (1, 2) north\n"
                        "4 links carry messages: (1, 1) east, (2, 1) south, (1, 2) north, (2, 2) west\n");
    CHECK(s.error + "\n" == "step 1 is not quiet after 100 passes (tiles vote busy or have mail, and most_passes allows no more); allow "
                            "more, or see what repeats [superstep 101 (Hand)]\n" +
                                text_of(r));
    CHECK(text_of(r, 1).find("messages can go round 4 tiles: (1, 1) east and 3 more\n") != std::string::npos);
}

TEST_CASE("no progress: a way into a ring, and a way out of it, are not part of the cycle")
{
    auto const s = stopped<Handing>(four, 40, [](auto& mesh) {
        round_four(mesh);
        point(mesh, TileId::at(0, 0), Direction::east); // in from the corner
        point(mesh, TileId::at(1, 0), Direction::south);
        mesh.template state<First>(TileId::at(0, 0)).parcels = 2;
    });
    auto const r = no_progress(s.trace, four);
    CHECK(r.period == 4);
    CHECK(r.first == 2); // on the way in, only the first superstep belongs to the step
    CHECK(r.cycle.size() == 4);
    CHECK(r.links.size() == 4);
    CHECK(r.links[0].full); // both parcels
    CHECK(has(text_of(r), "4 of them are full each time: (1, 1) east"));
}

TEST_CASE("no progress: at an edge a message comes back to its tile; one tile")
{
    for (Grid grid : {Grid{3, 2}, Grid{1, 1}}) {
        auto const last = TileId::at(grid.width - 1, 0);
        auto const s = stopped<Handing>(grid, 20, [&](auto& mesh) {
            point(mesh, last, Direction::east);
            mesh.template state<First>(last).parcels = 1;
        });
        auto const r = no_progress(s.trace, grid);
        CHECK(r.period == 1);
        CHECK(r.cycle == std::vector<TileSide>{{grid.index_of(last), Direction::east}});
        CHECK(r.tiles == std::vector<std::uint32_t>{grid.index_of(last)});
        CHECK(r.waiting.empty());
        CHECK(has(text_of(r), "does the same every superstep from superstep 1"));
        CHECK(has(text_of(r), "messages can go round 1 tile: (" + std::to_string(last.x()) + ", 0) east\n"));
        CHECK(has(text_of(r), "1 tile runs in every superstep: ("));
    }
}

namespace {
/// Each tile has a parcel for the next tile of the ring, and room for one parcel. It sends when the next tile reports free room.
struct Load {
    std::uint32_t parcels, ahead; ///< 1 + side of the next tile; 0: not in the ring
    std::uint32_t tells;          ///< 1: it reports how full it is
    std::uint32_t credit;         ///< number of parcels that it may send at first
};
struct Room : Channel<Parcel, 1> {};
struct Wait {
    Vote operator()(Load& load, In<Room> in, Out<Room> out) const noexcept
    {
        if (load.ahead == 0) return Vote::quiet;
        for (Direction from : news) load.parcels += in[from].size();
        Direction const ahead = news[load.ahead - 1];
        bool const free = in[ahead].note() == 2;
        if (load.parcels != 0 && (free || load.credit != 0)) {
            out[ahead].push({1});
            --load.parcels;
            load.credit = 0;
        }
        if (load.tells != 0)
            for (Direction d : news)
                if (d != ahead) out[d].set_note(load.parcels == 0 ? 2 : 1);
        return load.parcels != 0 ? Vote::busy : Vote::quiet;
    }
};
struct Begin {
    Vote operator()(Load const& load) const noexcept { return load.parcels != 0 ? Vote::busy : Vote::quiet; }
};
using Waiting = Sequence<Superstep<Begin>, UntilQuiet<Wait>>;
void load_ring(auto& mesh, std::uint32_t tells, std::uint32_t credit = 0)
{
    for (int i = 0; i < 4; ++i) mesh.template state<Load>(ring[i]) = {1 + credit, 1 + index(ring_sides[i]), tells, credit};
}
} // namespace

TEST_CASE("no progress: four tiles that wait, each for the next")
{
    auto s = stopped<Waiting>(four, 50, [](auto& mesh) { load_ring(mesh, 0); });
    auto r = no_progress(s.trace, four);
    CHECK(r.period == 1);
    CHECK(r.cycle.empty());
    CHECK(r.links.empty());
    CHECK(r.waiting == std::vector<std::uint32_t>{5, 6, 9, 10});
    CHECK(r.tiles == r.waiting);
    CHECK(text_of(r) == "step 1 (Wait) does the same every superstep from superstep 1 of the run on\n"
                        "no message moves\n"
                        "4 tiles run in every superstep and send no message (busy, or woken by mail; for whom they wait is not in a "
                        "trace): (1, 1), (2, 1), (1, 2), (2, 2)\n");
    CHECK(has(s.error, "no message moves"));
    CHECK(r.sent_last.empty());

    // Each tile has a second parcel, which it may send at once. Then it waits for the tile to which it sent.
    s = stopped<Waiting>(four, 50, [](auto& mesh) { load_ring(mesh, 0, 1); });
    r = no_progress(s.trace, four);
    CHECK(r.period == 1);
    CHECK(r.first == 2);
    CHECK(r.waiting == std::vector<std::uint32_t>{5, 6, 9, 10});
    CHECK(r.links.empty());
    CHECK(r.wait_cycle == std::vector<TileSide>{{5, Direction::east}, {6, Direction::south}, {10, Direction::west}, {9, Direction::north}});
    CHECK(has(text_of(r), "the last messages of these tiles went over 4 links: (1, 1) east, (2, 1) south, (1, 2) north, (2, 2) west\n"
                          "a guess: if a tile waits for the tile to which it sent last, 4 tiles wait for each other in a circle: "
                          "(1, 1) east, (2, 1) south, (2, 2) west, (1, 2) north\n"));
    CHECK(has(text_of(r, 1), "the last messages of these tiles went over 4 links: (1, 1) east and 3 more\n"));

    // The same with tiles that report to three sides: notes are not messages, so no cycle contains them.
    s = stopped<Waiting>(four, 50, [](auto& mesh) { load_ring(mesh, 1); });
    r = no_progress(s.trace, four);
    CHECK(r.period == 1);
    CHECK(r.cycle.empty());
    CHECK(r.waiting == std::vector<std::uint32_t>{1, 2, 4, 5, 6, 7, 8, 9, 10, 11, 13, 14}); // notes wake the neighbours
    CHECK(r.links.size() == 12);
    CHECK(std::all_of(r.links.begin(), r.links.end(), [](auto const& use) { return use.notes_only; }));
    CHECK(has(text_of(r), "no message moves\n12 links carry notes alone: (1, 1) north, (1, 1) west, (1, 1) south, "));
}

TEST_CASE("no progress: programs that make progress and end have an empty report")
{
    Grid const row{200, 1};
    on_each<Handing, Traced<Mk2>>(row, [&](auto& mesh) {
        point_along(mesh, row, 2);
        mesh.run();
        auto const r = no_progress(mesh.trace(), row);
        CHECK(r.empty());
        CHECK(r.supersteps == 199);
        CHECK(r.links.empty());
        CHECK(r.cycle.empty());
        CHECK(text_of(r) == "step 1 (Hand) repeats nothing in its last 199 supersteps: it goes on, or its period is longer\n");
    });
    // Stopped while it still makes progress.
    auto const s = stopped<Handing>(row, 100, [&](auto& mesh) { point_along(mesh, row, 1); });
    CHECK(no_progress(s.trace, row).empty());
    CHECK(has(s.error, "repeats nothing in its last 101 supersteps"));

    CHECK(no_progress({}, row).empty());
    CHECK(text_of(no_progress({}, row)) == "the trace does not end with a step that runs until quiet\n");
    Trace other;
    other.kernels = {"K"};
    other.supersteps.assign(50, {0, false, 0, false, {}});
    CHECK(no_progress(other, row).empty());
}

TEST_CASE("no progress: as many passes as needed are no error; a limit one lower is an error")
{
    Grid const row{10, 1};
    auto const run = [&](auto& mesh) {
        point_along(mesh, row, 1);
        return error_of([&] { mesh.run(); });
    };
    for (std::uint32_t most : {0u, 9u, 8u}) { // nine hops
        CAPTURE(most);
        Mesh<Handing> mesh{{}, row, {.most_passes = most}};
        auto const error = run(mesh);
        CheckedMesh<Handing> slow{{}, row, {.most_passes = most}};
        CHECK(run(slow) == error);
        CHECK(error == (most != 8 ? ""
                                  : "step 1 is not quiet after 8 passes (tiles vote busy or have mail, and most_passes allows no more); "
                                    "allow more, or see what repeats on a Traced machine [superstep 9 (Hand)]"));
    }
    // Without `explain` the engine has no report, and says how to get it.
    Mesh<Handing, Traced<Mk2>> traced{{}, row, {.most_passes = 8}};
    CHECK(run(traced) == "step 1 is not quiet after 8 passes (tiles vote busy or have mail, and most_passes allows no more); "
                         "allow more, or see what repeats (set explain to explain_no_progress) [superstep 9 (Hand)]");
    // A bound of the program is not an error, and applies first. Other kinds of steps are not bounded.
    using Bounded = Sequence<Superstep<Launch>, Repeat<Hand>, UntilQuiet<Hand>>;
    Mesh<Bounded> mesh{{{}, {5}, {1}}, row, {.most_passes = 1}};
    CHECK(run(mesh).empty());
}

TEST_CASE("no progress: the number of supersteps that must repeat")
{
    Trace trace;
    trace.kernels = {"K"};
    auto const add = [&](std::uint32_t tile, std::uint32_t count) {
        trace.supersteps.push_back({0, true, 24, true, {{tile, {{count}}, {0, 12, 0, 0}}}});
    };
    Grid const grid{8, 1};
    for (std::uint32_t i = 0; i < 15; ++i) add(3, 1);
    CHECK(no_progress(trace, grid).empty());
    CHECK(no_progress(trace, grid, 15).period == 1);
    add(3, 1);
    CHECK(no_progress(trace, grid).period == 1);
    CHECK(no_progress(trace, grid).first == 0);
    trace.supersteps[0].tiles[0].operations.settled_bytes = 1;
    CHECK(no_progress(trace, grid).empty());
    CHECK(no_progress(trace, grid, 2).first == 1);
    // A growing number is progress.
    trace.supersteps.clear();
    for (std::uint32_t i = 0; i < 40; ++i) add(3, i);
    CHECK(no_progress(trace, grid).empty());
    // Periods of 8 and 9. A period longer than half of 16 must repeat only twice.
    for (std::uint32_t period : {8u, 9u}) {
        trace.supersteps.clear();
        for (std::uint32_t i = 0; i < 2 * period; ++i) add(0, i % period);
        CHECK(no_progress(trace, grid).period == period);
        trace.supersteps.erase(trace.supersteps.begin());
        CHECK(no_progress(trace, grid).empty());
    }
    // The last superstep differs.
    for (std::uint32_t i = 0; i < 40; ++i) add(3, 1);
    add(4, 1);
    CHECK(no_progress(trace, grid).empty());
    CHECK(has(error_of([&] { no_progress(trace, {3, 1}); }), "the trace and the grid of one run"));
}

TEST_CASE("no progress: a cycle among many links, and streams without one")
{
    // A stream whose messages settle: period 1, no cycle.
    Trace trace;
    trace.kernels = {"K"};
    trace.supersteps.assign(20, {0, true, 24, true, {{0, {}, {0, 24, 0, 0}}, {1, {}, {0, 24, 0, 0}}, {2, {{}, 16}, {}}}});
    auto r = no_progress(trace, {4, 1});
    CHECK(r.period == 1);
    CHECK(r.cycle.empty());
    CHECK(r.settled_bytes == 16);
    CHECK(r.links.size() == 2);
    CHECK(r.waiting == std::vector<std::uint32_t>{2});
    CHECK(has(text_of(r), "16 bytes a period settle: this may be a steady stream\n"));
    CHECK(has(text_of(r), "2 of them are full each time"));
    // Every tile sends to all sides: some closed walk exists, and each of its links leads to the next.
    Grid const grid{5, 4};
    for (auto& s : trace.supersteps) {
        s.tiles.clear();
        for (std::uint32_t t = 0; t < grid.size(); ++t) s.tiles.push_back({t, {}, {12, 12, 12, 12}});
    }
    r = no_progress(trace, grid);
    REQUIRE(!r.cycle.empty());
    for (std::size_t i = 0; i < r.cycle.size(); ++i)
        CHECK(grid.index_of(grid.neighbour(grid.tile(r.cycle[i].tile), r.cycle[i].side)) == r.cycle[(i + 1) % r.cycle.size()].tile);
    CHECK(has(text_of(r), "80 links carry messages: (0, 0) north, "));
    CHECK(has(text_of(r), " and 64 more\n"));
    // Eastwards along each row, but not over the edge: no cycle. Over the edge: the last tile's own link.
    for (auto& s : trace.supersteps)
        for (auto& t : s.tiles) {
            std::uint32_t const last = grid.tile(t.tile).x() + 1 == grid.width ? 0 : 12;
            t = {t.tile, {}, {0, last, 0, 0}};
        }
    CHECK(no_progress(trace, grid).cycle.empty());
    for (auto& s : trace.supersteps) s.tiles.back().sent_bytes[1] = 12;
    CHECK(no_progress(trace, grid).cycle == std::vector<TileSide>{{grid.size() - 1, Direction::east}});
}
