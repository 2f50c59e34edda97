// test: without test asan tsan, needs data, cost 20
// LargestFirst: what changes the picture most goes first and stays.
#include "references.hpp"
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/splat/contribution.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;
using support::compare, support::LargestDrop, support::LargestHold, support::make_runner;

namespace {
/// A list of a tile, for a ranking alone.
template <class T>
struct List {
    std::vector<T> items;
    std::uint32_t size() const { return static_cast<std::uint32_t>(items.size()); }
    T& operator[](std::uint32_t i) { return items[i]; }
    T const& operator[](std::uint32_t i) const { return items[i]; }
};

/// One tile of 32 x 32 pixels with records, and the next tile to the right.
struct OneTile {
    FrameParameters frame{make_view(support::flat_camera(64, 32), Rules{}), make_tiling(64, 32, 32, 32), 1, 0, 0};
    Here here{TileId::at(0, 0), Grid{2, 1}};
    List<Mark> marks;
    List<Splat> splats;
    splat::detail::Ranking<PoliciesOf<LargestDrop>> ranking;

    Splat splat(float x, float y, float sigma, float z = 1000, float opacity = 0.9f) const
    {
        auto g = support::ball(1, x * z / 1000, y * z / 1000, sigma * z / 1000, opacity);
        g.mean_world[2] = z;
        return project(g, frame.view, frame.tiling);
    }
    void put(std::uint32_t id, Splat const& s, std::uint32_t bits = 0)
    {
        marks.items.push_back({GaussianId{id}, bits});
        splats.items.push_back(s);
    }
    std::uint32_t slot_for(std::uint32_t id, Splat const& s, bool copy = false)
    {
        return ranking.slot_for(here, frame, marks, splats, s, GaussianId{id}, copy);
    }
};

double psnr(report::Image const& image, report::Image const& whole) { return report::compare(image, whole).psnr_db; }

/// Renders a path, and checks in every frame that no id is lost or doubled, and that the picture lacks exactly the listed records.
template <class S>
void check_conservation(RendererOptions options, std::uint32_t slots, std::uint32_t records,
                        std::vector<splat::Gaussian> const& gaussians = support::cloud(250, 31),
                        std::vector<float> const& turns = {0.0f, 0.0f, 0.03f, -0.4f, 3.1f, 0.01f})
{
    options.sizes = support::sized<S>(slots, records);
    auto const runner = make_runner<Referenced<S>>(support::map_of(gaussians), options);
    for (float turn : turns) {
        INFO("slots ", slots, ", records ", records, ", turn ", turn);
        auto const camera = support::lens(120, 80, turn);
        auto const frame = runner->render(camera);
        auto const& n = frame.report.gaussians;
        auto const owned = runner->owned_ids();
        CHECK(std::adjacent_find(owned.begin(), owned.end()) == owned.end());
        CHECK(owned.size() + n.dropped + n.unplaced == gaussians.size());
        CHECK(frame.report.peak_storage <= records);
        auto const shown = report::render_naive(gaussians, camera, runner->rules(), runner->missing(frame.report));
        CHECK(support::differing_pixels(frame.image, shown) == 0);
    }
}
} // namespace

TEST_CASE("contribution: the coverage of a splat is its integral, cut by its rectangle")
{
    OneTile const tile{};
    auto const s = tile.splat(16, 16, 3); // its rectangle lies in the picture
    CHECK(splat::detail::coverage_of(s) == doctest::Approx(0.9 * 2 * 3.14159265 * (9 + 0.3)).epsilon(1e-3));
    auto const fainter = tile.splat(16, 16, 3, 1000, 0.45f);
    CHECK(splat::detail::coverage_of(fainter) == doctest::Approx(0.45 * 2 * 3.14159265 * (9 + 0.3)).epsilon(1e-3));
    auto const wide = tile.splat(16, 16, 1000);
    CHECK(splat::detail::coverage_of(wide) == doctest::Approx(0.9 * 64 * 32));
    CHECK(splat::detail::coverage_of(tile.splat(-900, 16, 3)) == 0); // not visible
}

TEST_CASE("contribution: a full tile gives up the record that covers least, and of equal ones that with the larger id")
{
    OneTile tile;
    tile.put(10, tile.splat(8, 8, 2));
    tile.put(11, tile.splat(24, 8, 1.5f));
    tile.put(12, tile.splat(8, 24, 3));
    CHECK(tile.slot_for(20, tile.splat(24, 24, 1)) == no_slot);
    CHECK(tile.slot_for(20, tile.splat(24, 8, 1.5f)) == no_slot);
    CHECK(tile.slot_for(9, tile.splat(24, 8, 1.5f)) == 1);
    tile.marks[1] = {GaussianId{9}, tile.ranking.rank_bits()};
    CHECK(tile.slot_for(20, tile.splat(24, 24, 2.5f)) == 1);
    CHECK((tile.marks[0].bits & 0xffffu) == 0); // a rank stands beside a mark's other bits
    OneTile empty;
    CHECK(empty.slot_for(1, empty.splat(8, 8, 2)) == no_slot);
}

TEST_CASE("contribution: a record behind others counts less, in the cells of the tile in which it is behind them")
{
    OneTile tile;
    for (std::uint32_t i = 0; i < 20; ++i) tile.put(10 + i, tile.splat(8, 8, 3, 500, 1.0f));
    tile.put(40, tile.splat(24, 24, 2, 1000, 0.1f));
    // Behind the twenty nearly nothing is seen: an opaque record there is less than the faint one in the other corner.
    CHECK(tile.slot_for(50, tile.splat(8, 8, 1, 1000, 1.0f)) == no_slot);
    // In front of them, or in another corner, it is more.
    CHECK(tile.slot_for(50, tile.splat(8, 8, 1, 400, 1.0f)) == 20);
    CHECK(tile.slot_for(50, tile.splat(24, 8, 1, 1000, 1.0f)) == 20);
}

TEST_CASE("contribution: a copy counts on its tile, a record with the copies that come from here")
{
    OneTile tile;
    tile.put(10, tile.splat(16, 16, 1));
    auto const across = tile.splat(32, 16, 1.2f); // half of it lies on the next tile
    CHECK(tile.slot_for(20, across, true) == no_slot);
    CHECK(tile.slot_for(20, across, false) == 0);
}

TEST_CASE("contribution: a side takes all records of the octaves for which it has room")
{
    OneTile const tile{};
    splat::detail::SideCuts cuts;
    auto const large = splat::detail::SideCuts::octave_of(tile.splat(16, 16, 4));
    auto const small = splat::detail::SideCuts::octave_of(tile.splat(16, 16, 1));
    CHECK(large > small);
    CHECK(splat::detail::SideCuts::octave_of(tile.splat(-900, 16, 3)) == 0);
    CHECK(splat::detail::SideCuts::octave_of(tile.splat(16, 16, 1e6f)) < 64);
    for (int i = 0; i < 3; ++i) cuts.add(Direction::east, large);
    for (int i = 0; i < 2; ++i) cuts.add(Direction::east, small);
    cuts.add(Direction::west, small);
    cuts.close(Direction::east, 4);
    CHECK(cuts.has_room(Direction::east, large));
    CHECK_FALSE(cuts.has_room(Direction::east, small)); // 5 are more than 4
    cuts.close(Direction::east, 5);
    CHECK(cuts.has_room(Direction::east, small));
    cuts.close(Direction::west, 0);
    CHECK_FALSE(cuts.has_room(Direction::west, small));
}

TEST_CASE("contribution: values and references, threads and the engine that checks have the same bits, counters and tiles")
{
    auto const map = support::map_of(support::cloud(300, 31));
    for (RendererOptions const& options : {RendererOptions{.grid = {7, 6}, .storage_slots = 22}, RendererOptions{.grid = {5, 4}, .channel_slots = 2},
                                           RendererOptions{.grid = {6, 5}, .hops = 2, .channel_slots = 3, .storage_slots = 30}}) {
        compare<LargestDrop>(map, options, support::path());
        compare<LargestHold>(map, options, support::path());
        auto const checked = make_runner<LargestDrop, CheckedMesh>(map, options), threads = make_runner<LargestDrop>(map, options);
        for (float turn : {0.0f, 0.0f, 0.03f, -0.4f}) {
            auto const camera = support::lens(120, 80, turn);
            CHECK(support::differing_pixels(checked->render(camera).image, threads->render(camera).image) == 0);
            CHECK(checked->on_tiles() == threads->on_tiles());
        }
    }
}

TEST_CASE("contribution: every id is on a tile, under way, or listed, for every capacity from 1 on")
{
    for (std::uint32_t records : {1u, 2u, 3u, 7u, 20u, 60u})
        for (std::uint32_t slots : {1u, 2u, 9u}) {
            check_conservation<LargestDrop>({.grid = {7, 6}}, slots, records < 6 ? 6 : records); // the map must fit on the tiles at first
            check_conservation<LargestHold>({.grid = {7, 6}}, slots, records < 6 ? 6 : records);
            check_conservation<LargestDrop>({.grid = {20, 16}}, slots, records);
        }
}

TEST_CASE("contribution: a record comes to a tile whose copy of it has just given up its slot")
{
    // Two tiles of 20 slots for 40 records, so that both are full. The camera jumps, and anchors move to the tile beside, which has copies. A
    // record that settles first takes the slot of such a copy, and the record of the copy settles in the same pass.
    std::vector<float> const jumps{0, 0.3f, -0.3f, 0.6f, 0};
    check_conservation<LargestHold>({.grid = {2, 1}}, 9, 20, support::cloud(40, 10), jumps);
    check_conservation<LargestHold>({.grid = {3, 3}}, 9, 5, support::cloud(40, 12), jumps);
    check_conservation<LargestDrop>({.grid = {2, 1}}, 9, 20, support::cloud(40, 10), jumps);
}

TEST_CASE("contribution: where nothing is full, picture and messages are those of first come")
{
    auto const map = support::map_of(support::cloud(300, 21));
    auto const largest = make_runner<Referenced<LargestHold>>(map, {.grid = {7, 6}}), first = make_runner<Referenced<support::Whole>>(map, {.grid = {7, 6}});
    for (float turn : {0.0f, 0.0f, 0.03f, -0.4f}) {
        auto const a = largest->render(support::lens(120, 80, turn)), b = first->render(support::lens(120, 80, turn));
        CHECK(support::differing_pixels(a.image, b.image) == 0);
        CHECK(a.report.messages == b.report.messages);
        CHECK(a.report.exchanges.total() == b.report.exchanges.total());
        CHECK(a.report.lost.empty());
    }
    CHECK(render::sram_bytes_of(largest->facts()) == render::sram_bytes_of(first->facts()));
}

TEST_CASE("contribution: the 250k map with the prototype's 100 and 800 slots is at least 6 dB nearer to the whole picture")
{
    auto const data = support::data();
    if (data.empty()) return;
    auto const map = scene::load_ply(data / "maps" / "playbot_250k.ply");
    auto const camera = scene::frame_whole(map, {1280, 720});
    RendererOptions const options{.threads = 2, .channel_slots = 100, .storage_slots = 800};
    auto const of = [&]<class S>(S) {
        auto runner = make_runner<Referenced<S>>(map, options);
        return runner->render(camera).image;
    };
    auto const first = of(support::Room<support::DropBase>{});
    auto const largest = of(LargestDrop{}), held = of(LargestHold{});
    auto const whole = report::render_naive(map.gaussians, camera, make_runner<Referenced<LargestDrop>>(map, options)->rules());
    CHECK(psnr(largest, whole) > psnr(first, whole) + 10);
    CHECK(psnr(held, whole) > psnr(first, whole) + 10);
}
