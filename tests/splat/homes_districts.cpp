// test: unoptimised asan, without tsan, cost 20
// Homes on tiles that have no room for a window of each tile: districts of tiles share an entry of the table.
#include "support.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/render/homes_renderer.hpp>

using namespace tilemesh;
namespace homes = splat::homes;

namespace {
using Rows = render::HomesRenderer<homes::HostPolicies<>>;
using CheckedRows = render::HomesRenderer<homes::HostPolicies<>, CheckedMesh>;
using Values = render::HomesRenderer<homes::DistrictPolicies<1>>;

/// A tile of a wafer: 48 KB, of which code and stacks take a sixth.
constexpr MachineSize wafer{"wafer", 10'000, 48 * 1024, 8 * 1024, 1, 850'000};

render::Setup choice_of(std::uint32_t district, splat::Sizes const& sizes)
{
    auto c = splat::homes_setup;
    c.machine.sram_bytes = 1u << 26;
    c.machine.tiles = 10'000;
    c.sizes = sizes;
    c.district = district;
    return c;
}
render::Setup wafer_choice(std::uint32_t district)
{
    auto c = splat::homes_setup;
    c.machine = wafer;
    c.sizes = splat::homes::homes_sizes(25, 150, 8, 8);
    c.district = district;
    return c;
}
RendererOptions on(Grid grid)
{
    return {.grid = {grid.width, grid.height}, .digest = true};
}
/// In each round, is the table of every tile that of the hulls of the districts' windows?
template <class Renderer>
std::uint64_t wrong_hulls(Renderer& renderer, std::uint32_t side)
{
    auto const& mesh = std::as_const(renderer.mesh());
    auto const& fold = renderer.fold();
    auto const across = (fold.x.tiles + side - 1) / side, down = (fold.y.tiles + side - 1) / side;
    std::vector<homes::WindowNotice> hulls(across * down, {homes::infinite_depth, 0, 0xffffffffu});
    for (std::uint32_t y = 0; y < fold.y.tiles; ++y)
        for (std::uint32_t x = 0; x < fold.x.tiles; ++x) {
            auto const& window = mesh.template state<homes::Window>(TileId::at(x, y));
            auto& hull = hulls[y / side * across + x / side];
            if (side == 1) hull = {window.lo_depth, window.hi_depth, window.finished}; // as the tile says it, also when it is done
            if (side == 1 || window.done()) continue;
            hull = {std::min(hull.lo_depth, window.lo_depth), std::max(hull.hi_depth, window.hi_depth), hull.finished & window.finished};
        }
    std::uint64_t wrong = 0;
    for (TileId const tile : mesh.grid().tiles()) {
        auto const table = mesh.template state<homes::Table>(tile);
        wrong += table.size() != hulls.size() || std::memcmp(table.begin(), hulls.data(), hulls.size() * sizeof hulls[0]) != 0;
    }
    return wrong;
}
} // namespace

TEST_CASE("districts: 10,000 tiles of 48 KB have room for a table of districts, and none for one of tiles")
{
    RendererOptions o = on({100, 100});
    Extent2 const frame{640, 360};
    std::uint64_t const records = 250'000;
    auto const bytes_of = [&](render::HomesLayout const& layout, std::string const& name) {
        for (auto const& line : render::ledger_of(layout.setup))
            if (std::string(line.name.text, line.name.size) == name) return line.bytes;
        return 0u;
    };
    CHECK_THROWS_WITH_AS(render::layout_homes(wafer_choice(1), o, frame, records), doctest::Contains("windows of all tiles has 34568 bytes"), Error);
    // 40 x 72 tiles hold blocks: 20 x 36 districts of 2 x 2, 10 x 18, 5 x 9, 3 x 5, 2 x 3, 1 x 2, one.
    std::vector<std::uint32_t> const tables{20 * 36, 10 * 18, 5 * 9, 3 * 5, 2 * 3, 1 * 2, 1}, columns{20, 10, 5, 3, 2, 1, 1};
    for (std::uint32_t i = 0; i < tables.size(); ++i) {
        auto const layout = render::layout_homes(wafer_choice(2u << i), o, frame, records);
        CHECK(layout.setup.district == 2u << i);
        CHECK(bytes_of(layout, homes::Table::name) == 8 + 12 * tables[i]);
        CHECK(bytes_of(layout, homes::WindowNotices::name) == 8 * (8 + 12 * columns[i]));
        CHECK(tilemesh::render::sram_bytes_of(layout.setup) <= wafer.sram_bytes);
        CHECK(std::uint64_t{layout.setup.sizes.homes} * 10'000 >= records);
    }
    // 0 takes the smallest that fits: here, and on Mk2, where it is one tile.
    CHECK(render::layout_homes(wafer_choice(0), o, frame, records).setup.district == 2);
    auto large = wafer_choice(0);
    large.sizes.storage = 350; // leaves less room
    CHECK(render::layout_homes(large, o, frame, records).setup.district == 4);
    auto mk2 = splat::homes_setup;
    mk2.district = 0;
    CHECK(render::layout_homes(mk2, {}, {1280, 720}, 1000).setup.district == 1);
    // The ledger grows with the districts: four times as many tiles have the same table, if a district's side is doubled.
    auto const table = [&](std::uint32_t side, std::uint32_t district) {
        return bytes_of(render::layout_homes(wafer_choice(district), on({side, side}), {16 * side, 5 * side}, 100), homes::Table::name);
    };
    CHECK(table(25, 4) == table(50, 8));
    CHECK(table(50, 8) == table(100, 16));
}

TEST_CASE("districts: what cannot work is refused")
{
    CHECK_THROWS_WITH_AS(render::layout_homes(wafer_choice(3), on({10, 10}), {640, 360}, 1000),
                         "districts of 3 x 3 tiles (a side is a power of 2); choose 1, 2, 4, ..., or 0 for the smallest that fits", Error);
    scene::Map const map = support::map_of(support::cloud(5, 1));
    CHECK_THROWS_WITH_AS(Values(map, choice_of(4, homes::homes_sizes(5, 5, 3, 2)), on({2, 2})),
                         "a choice with districts of 4 x 4 tiles (the renderer's policies have 2 x 2); give both the same", Error);
    CHECK_NOTHROW(Values(map, choice_of(0, homes::homes_sizes(5, 5, 3, 2)), on({2, 2})));
    auto none = wafer_choice(0); // an error that no district removes is that of single tiles
    none.sizes.storage = 5000;
    CHECK_THROWS_WITH_AS(render::layout_homes(none, on({100, 100}), {640, 360}, 1000), doctest::Contains("held splats has"), Error);
}

TEST_CASE("districts: the picture is the naive loop's, bit for bit, for any grid and any capacities, on every engine")
{
    constexpr std::uint32_t width = 83, height = 47;
    auto const map = support::map_of(support::cloud(support::fast() ? 60 : 150, 91));
    std::vector<splat::Camera> const views{support::lens(width, height), support::lens(width, height, 0.03f), support::lens(width, height, 0.6f)};
    struct Case {
        Grid grid;
        std::uint32_t district;
        splat::Sizes sizes;
        bool fold;
    };
    for (auto const& c : {Case{{4, 3}, 2, homes::homes_sizes(100, 7, 3, 2), true}, Case{{4, 3}, 1, homes::homes_sizes(100, 7, 3, 2), true}, Case{{5, 7}, 2, homes::homes_sizes(100, 1, 1, 1), false},
                          Case{{5, 7}, 4, homes::homes_sizes(100, 4, 1, 1), true}, Case{{9, 11}, 2, homes::homes_sizes(100, 2, 2, 3), true}, Case{{1, 9}, 2, homes::homes_sizes(100, 7, 1, 1), true},
                          Case{{9, 1}, 4, homes::homes_sizes(100, 7, 1, 1), true}, Case{{1, 1}, 2, homes::homes_sizes(200, 20, 1, 1), true}, Case{{6, 10}, 16, homes::homes_sizes(100, 2, 1, 2), false}}) {
        INFO(c.grid.width, " x ", c.grid.height, " tiles, districts of ", c.district);
        auto const choice = choice_of(c.district, c.sizes);
        auto o = on(c.grid);
        o.fold = c.fold;
        Rows rows(map, choice, o);
        CheckedRows checked(map, choice, o);
        o.threads = 3;
        Rows shared(map, choice, o);
        std::optional<Values> values;
        if (c.district == 2) values.emplace(map, choice, o);
        std::uint64_t told = 0, wrong = 0;
        rows.observe([&](SuperstepEvent const& e) {
            if (e.kernel != homes::Offer<homes::HostPolicies<>>::name) return;
            ++told;
            wrong += wrong_hulls(rows, c.district);
        });
        std::uint64_t rounds = 0;
        for (auto const& view : views) {
            auto const expected = report::render_naive(map.gaussians, view, rows.rules());
            auto const a = rows.render(view), b = shared.render(view), d = checked.render(view);
            CHECK(support::differing_pixels(a.image, expected) == 0);
            CHECK(support::differing_pixels(b.image, expected) == 0);
            CHECK(support::differing_pixels(d.image, expected) == 0);
            CHECK(a.report.digests == b.report.digests);
            CHECK(a.report.digests == d.report.digests);
            CHECK(a.report.homes.unfinished_tiles == 0);
            if (values) {
                auto const v = values->render(view);
                CHECK(support::differing_pixels(v.image, expected) == 0);
                CHECK(v.report.hops == a.report.hops);
                CHECK(v.report.pairs == a.report.pairs);
                CHECK(v.report.homes.rounds == a.report.homes.rounds);
                CHECK(v.report.homes.entries == a.report.homes.entries);
                CHECK(v.report.exchanged_live_bytes == a.report.exchanged_live_bytes);
            }
            rounds += a.report.homes.rounds;
        }
        CHECK(told == rounds);
        CHECK(wrong == 0);
        CHECK(rounds > 2 * views.size());
    }
}

TEST_CASE("districts: a wafer of 100 x 100 tiles of 48 KB renders the naive loop's picture, in several rounds")
{
    constexpr std::uint32_t width = 1600, height = 500; // a block a tile
    auto const map = support::map_of(support::cloud(support::fast() ? 100 : 300, 17));
    auto choice = wafer_choice(8);
    choice.sizes.storage = 1;
    auto o = on({100, 100});
    o.digest = false;
    o.threads = 2;
    Rows rows(map, choice, o);
    auto const view = support::lens(width, height);
    auto const a = rows.render(view);
    CHECK(support::differing_pixels(a.image, report::render_naive(map.gaussians, view, rows.rules())) == 0);
    CHECK(a.report.homes.rounds > 1);
    CHECK(a.report.homes.unfinished_tiles == 0);
    CHECK(rows.fold().x.tiles == 100);
    CHECK(rows.fold().y.tiles == 100);
    CHECK(render::sram_bytes_of(rows.setup()) <= wafer.sram_bytes);
    CHECK(rows.mesh().state<homes::Table>(TileId::at(99, 99)).size() == 13 * 13);
}
