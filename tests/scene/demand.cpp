#include "../splat/support.hpp"
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/scene/records.hpp>

using namespace tilemesh;
using scene::Demand;
using scene::demand_of;

namespace {
Demand along(scene::Map const& map, std::vector<splat::Camera> const& path, std::uint32_t tile = 16)
{
    return demand_of(map, std::span(path), splat::Rules{}, [&](splat::Camera const& c) { return splat::make_tiling(c.width, c.height, tile, tile); });
}
} // namespace

TEST_CASE("demand: opacities, and the records that they make invisible")
{
    auto map = support::map_of({support::ball(1, 8, 8, 0.01f, 0.5f), support::ball(2, 24, 8, 0.01f, 0.001f),
                                support::ball(3, 40, 8, 0.01f, 0.995f), support::ball(4, 900, 8, 0.01f, 0.99f)});
    auto const d = along(map, {support::flat_camera(64, 64)});
    CHECK(d.gaussians == 4);
    CHECK(d.views == 1);
    CHECK(d.least_opacity == 0.001f);
    CHECK(d.greatest_opacity == 0.995f);
    CHECK(d.nearly_opaque == 1); // 0.99 is not above the clamp
    CHECK(d.too_faint == 1);
    CHECK(d.culled == 2); // the faint one, and the one that is off screen
    CHECK(d.visible == std::vector<bool>{true, false, true, false});
    auto const kept = scene::needed(map, d);
    REQUIRE(kept.gaussians.size() == 2);
    CHECK(kept.gaussians[0].id == splat::GaussianId{1});
    CHECK(kept.gaussians[1].id == splat::GaussianId{3});
}

TEST_CASE("demand: whether records move or span tiles, the largest footprint, ties")
{
    auto const camera = support::flat_camera(64, 64);
    auto moved = camera;
    moved.cx = 1;
    // Middles of tiles of 16: the footprint of a ball of 0.55 pixels is 3 wide.
    auto const inside = support::map_of({support::ball(1, 8, 8), support::ball(2, 24, 40), support::ball(3, 24, 41)});
    auto const spanning = support::map_of({support::ball(1, 16, 8), support::ball(2, 24, 40, 10.0f)});

    CHECK_FALSE(along(inside, {camera}).moves);
    CHECK_FALSE(along(inside, {camera, camera, camera}).moves);
    CHECK(along(inside, {camera, camera, moved}).moves);
    CHECK_FALSE(along(inside, {camera}).spans);
    CHECK(along(inside, {camera}).footprint_columns == 1);
    CHECK(along(inside, {camera}).ties == 3);
    CHECK(along(spanning, {camera}).spans);
    CHECK(along(spanning, {camera}).footprint_columns == 4);
    CHECK(along(spanning, {camera}).footprint_rows == 4);
    CHECK_FALSE(along(spanning, {camera}, 64).spans); // one tile for the frame

    // Only in a later view: the scan is exact for a path of any length.
    std::vector<splat::Camera> path(40, camera);
    path.back() = camera;
    path.back().cx = 8; // now the ball at 8 is on a border
    CHECK(along(inside, path).spans);

    auto different = inside;
    different.gaussians[1].mean_world[2] = 1001;
    CHECK(along(different, {camera}).ties == 2);

    // The cameras are unknown: records may move, and footprints may span tiles.
    auto const any = demand_of(inside);
    CHECK(any.moves);
    CHECK(any.spans);
    CHECK(any.visible.empty());
    CHECK(scene::needed(inside, any).gaussians.size() == 3);

    CHECK(along(support::map_of({}), {camera}).culled == 0);
    CHECK_FALSE(along(support::map_of({}), {camera}).spans);
}

TEST_CASE("demand: a record that only one view of many shows is kept, with its harmonics")
{
    auto const camera = support::flat_camera(64, 64);
    auto away = camera;
    away.cx = 5000;
    auto map = support::map_of({support::ball(1, 700, 8), support::ball(2, -4980, 8), support::ball(3, 8, 8)});
    map.sh_degree = 1;
    for (int i = 0; i < 27; ++i) map.harmonics.push_back(static_cast<float>(i));
    std::vector<splat::Camera> path(50, camera);
    path[37] = away;
    auto const d = along(map, path);
    CHECK(d.visible == std::vector<bool>{false, true, true});
    CHECK(d.culled == 1);
    auto const kept = scene::needed(map, d);
    REQUIRE(kept.gaussians.size() == 2);
    REQUIRE(kept.harmonics.size() == 18);
    CHECK(kept.harmonics[0] == 9.0f);
    CHECK(kept.harmonics[9] == 18.0f);
}

TEST_CASE("demand: the degree is that of the highest coefficient that is not zero")
{
    auto const degree_with = [](std::uint32_t map_degree, std::size_t row, std::size_t at, float value) {
        auto map = support::map_of({support::ball(1, 8, 8), support::ball(2, 8, 8)});
        map.sh_degree = map_degree;
        auto const floats = 3 * splat::harmonics_per_channel(map_degree);
        map.harmonics.assign(2 * floats, 0.0f);
        map.gaussians[0].colour[0] = -1;
        if (floats != 0) map.harmonics[row * floats + at] = value;
        auto const d = demand_of(map);
        auto const kept = scene::needed(map, d);
        CHECK(kept.sh_degree == d.sh_degree);
        CHECK(kept.harmonics.size() == 2 * 3 * splat::harmonics_per_channel(d.sh_degree));
        if (d.sh_degree > 0) CHECK(kept.harmonics[row * 3 * splat::harmonics_per_channel(d.sh_degree) + at] == value);
        CHECK(kept.gaussians[0].colour[0] == (d.sh_degree == 0 && map_degree != 0 ? 0.0f : -1.0f));
        CHECK(d.shaded == (d.sh_degree == 0 ? 0u : 1u));
        return d.sh_degree;
    };
    CHECK(degree_with(0, 0, 0, 0) == 0);
    CHECK(degree_with(3, 0, 0, 0) == 0);
    CHECK(degree_with(3, 1, 0, 1) == 1);
    CHECK(degree_with(3, 0, 8, 1) == 1);
    CHECK(degree_with(3, 0, 9, 1) == 2);
    CHECK(degree_with(3, 1, 23, 1) == 2);
    CHECK(degree_with(3, 1, 24, 1) == 3);
    CHECK(degree_with(3, 0, 44, -1) == 3);
    CHECK(degree_with(1, 0, 8, 1e-30f) == 1);
}

TEST_CASE("records: of the setup's degree, with zeros above the map's")
{
    auto map = support::map_of({support::ball(1, 8, 8), support::ball(2, 9, 8)});
    map.sh_degree = 1;
    for (int i = 0; i < 18; ++i) map.harmonics.push_back(static_cast<float>(i + 1));
    auto const records = scene::records<splat::ShadedGaussian<2>>(map);
    REQUIRE(records.size() == 2);
    CHECK(records[1].id == splat::GaussianId{2});
    CHECK(records[1].harmonics[0] == 10.0f);
    CHECK(records[1].harmonics[8] == 18.0f);
    CHECK(records[1].harmonics[9] == 0.0f);
    CHECK(records[1].harmonics[23] == 0.0f);
    CHECK_THROWS_AS(scene::records<splat::Gaussian>(map), Error);
    auto const lower = scene::at_degree(map, 0);
    CHECK(lower.harmonics.empty());
    CHECK(scene::records<splat::Gaussian>(lower).size() == 2);
    CHECK(scene::at_degree(map, 3).sh_degree == 1);
}

TEST_CASE("demand: a demand of another map is refused, and the lower degree counts")
{
    auto map = support::map_of({support::ball(1, 8, 8), support::ball(2, 9, 8)});
    map.sh_degree = 2;
    for (int i = 0; i < 48; ++i) map.harmonics.push_back(1);
    auto const d = demand_of(map);
    auto const lower = scene::needed(scene::at_degree(map, 1), d); // the degree was cut after the scan
    CHECK(lower.sh_degree == 1);
    CHECK(lower.harmonics.size() == 18);
    CHECK_THROWS_AS(scene::needed(support::map_of({support::ball(1, 8, 8)}), d), Error);
    map.harmonics.pop_back();
    CHECK_THROWS_AS(scene::records<splat::ShadedGaussian<3>>(map), Error);
    CHECK_THROWS_AS(scene::at_degree(map, 1), Error);
}

TEST_CASE("a map whose harmonics do not fit its degree is refused wherever they are read")
{
    auto const refused = [](scene::Map const& map, char const* why) {
        auto const says = [&](auto const& call) { return tests::has(tests::error_of(call), why); };
        Demand d;
        d.gaussians = map.gaussians.size();
        d.sh_degree = map.sh_degree;
        CHECK(says([&] { demand_of(map); }));
        CHECK(says([&] { along(map, {support::flat_camera(64, 64)}); }));
        CHECK(says([&] { scene::needed(map, d); }));
        CHECK(says([&] { scene::records<splat::ShadedGaussian<3>>(map); }));
        CHECK(says([&] { scene::at_degree(map, 3); }));
        CHECK(says([&] { scene::turned(map, scene::Turn::x90); }));
        CHECK(says([&] { scene::join_maps({map, map}); }));
        CHECK(says([&] { scene::join_maps({map}); }));
    };
    auto map = support::map_of({support::ball(1, 8, 8), support::ball(2, 9, 8)});
    for (std::uint32_t degree = 0; degree <= 3; ++degree) {
        std::size_t const right = 2 * 3 * splat::harmonics_per_channel(degree);
        map.sh_degree = degree;
        for (std::size_t size : {std::size_t{0}, right - (degree != 0 ? 1 : 0), right + 1, right / 2, 3 * right}) {
            map.harmonics.assign(size, 0.25f);
            if (size == right) CHECK(demand_of(map).sh_degree == degree);
            else refused(map, "fill in all of them");
        }
    }
    for (std::uint32_t degree : {4u, 5u, 37836u, 0xffffffffu}) {
        map.sh_degree = degree;
        for (std::size_t size : {std::size_t{0}, std::size_t{144}}) {
            map.harmonics.assign(size, 0.25f);
            refused(map, "fill in degree 3 at most");
        }
    }
    auto const small = support::map_of({support::ball(1, 8, 8), support::ball(2, 9, 8)});
    auto d = demand_of(small);
    d.visible.assign(1, true);
    CHECK_THROWS_AS(scene::needed(small, d), Error);
}

TEST_CASE("demand: it holds for the scanned views with their model, and for any view if nothing was left out")
{
    auto const camera = support::flat_camera(64, 64);
    auto other = camera;
    other.cx = 1;
    splat::Rules fainter;
    fainter.alpha_min = 1e-3f;
    auto const view = splat::make_view(camera, splat::Rules{});
    auto const d = along(support::map_of({support::ball(1, 8, 8), support::ball(2, 900, 8)}), {camera});
    CHECK(d.holds_for(view));
    splat::Rules stops_later = view.rules; // what is visible does not depend on these
    stops_later.transmittance_min = 1e-4f;
    stops_later.alpha_max = 0.99f;
    stops_later.arithmetic = splat::Arithmetic::fast;
    CHECK(d.holds_for(splat::make_view(camera, stops_later)));
    CHECK_FALSE(d.holds_for(splat::make_view(other, splat::Rules{})));
    CHECK_FALSE(d.holds_for(splat::make_view(camera, fainter)));
    CHECK(along(support::map_of({support::ball(1, 8, 8)}), {camera}).holds_for(splat::make_view(other, splat::Rules{})));
}
