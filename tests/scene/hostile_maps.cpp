// test: unoptimised asan
#include "../splat/runner.hpp"
#include "ply_writer.hpp"
#include "support.hpp"
#include <initializer_list>

// Hostile maps, from their file to the picture: every pixel is finite, the picture equals the naive one, and every lost Gaussian is counted.
// stability/hostile.cpp has hostile numbers in any field of records.
using namespace scene_test;
using namespace tilemesh;

namespace {

/// The default renderer.
std::unique_ptr<support::Runner> renderer_of(scene::Map const& map, RendererOptions const& options)
{
    return support::make_runner<splat::Referenced<splat::Lossless>>(map, options);
}

constexpr int x = 0, z = 2, f_dc_0 = 3, opacity = 6, scale_0 = 7, rot_0 = 10;

/// At the origin, looking along z.
splat::Camera front()
{
    auto camera = support::flat_camera(64, 48);
    camera.fx = camera.fy = 40;
    camera.cx = 32;
    camera.cy = 24.25f;
    return camera;
}

/// A ball in front of the camera.
Row ball(double at_x, double at_y, double at_z)
{
    return {{at_x, at_y, at_z, 0.5, -0.25, 1, 2, -1.5, -1.5, -1.5, 1, 0.25, 0, 0}};
}

/// Six plain rows, and the fourth in the middle and in front of them, for a hostile value.
std::vector<Row> rows_around(Row const& middle)
{
    return {ball(-1, -1, 4), ball(1, -1, 4.5), ball(-1, 1, 5), middle, ball(1, 1, 4), ball(0, 0.5, 6), ball(0.2, 0, 2.5)};
}

/// Renders the loaded map in three views, with both footprints, and checks each picture and its counters. Returns whether a record was
/// unplaced.
bool render_all(scene::Map const& map, splat::Camera const& camera)
{
    auto turned = support::lens(64, 48, 0.3f);
    turned.position[0] = camera.position[0] + 0.5f;
    auto back = camera;
    back.rotation[0][0] = back.rotation[2][2] = -1;
    bool any_unplaced = false;
    for (auto const footprint : {splat::Footprint::opacity_box, splat::Footprint::three_sigma_square}) {
        auto const renderer = renderer_of(map, {.grid = {4, 3}, .footprint = footprint, .arithmetic = splat::Arithmetic::precise});
        auto rules = renderer->rules();
        rules.footprint = footprint;
        for (auto const& view : {camera, turned, back}) {
            auto const frame = renderer->render(view);
            auto const& r = frame.report;
            std::size_t not_finite = 0;
            for (float v : frame.image.rgb) not_finite += std::isfinite(v) ? 0 : 1;
            CHECK(not_finite == 0);
            CHECK(support::differing_pixels(frame.image, report::render_naive(map.gaussians, view, rules, renderer->missing(r))) == 0);
            auto const& n = r.gaussians;
            // Counted at the beginning of the frame; some of these may find no room.
            CHECK(n.visible + n.parked == map.gaussians.size());
            CHECK(renderer->owned_ids().size() + n.unplaced == map.gaussians.size());
            CHECK(n.dropped + n.under_way == 0);
            CHECK(r.lost.size() == n.unplaced + r.lost_copies);
            any_unplaced = any_unplaced || n.unplaced != 0;
        }
    }
    return any_unplaced;
}

double const inf = static_cast<double>(infinity);

} // namespace

TEST_CASE("a Gaussian that cannot be drawn does not change the picture of the others")
{
    auto const picture = [](Row const& row) {
        Ply ply;
        ply.rows = rows_around(row);
        auto const renderer = renderer_of(read(ply), {.grid = {4, 3}, .arithmetic = splat::Arithmetic::precise});
        return renderer->render(front()).image;
    };
    auto const others = picture(ball(0, 0, -5));
    CHECK(support::differing_pixels(picture(ball(0, 0, 3)), others) > 100);
    auto const changes = [&](std::initializer_list<int> fields, double value) {
        Row row = ball(0, 0, 3);
        for (int field : fields) row.f[field] = value;
        return support::differing_pixels(picture(row), others);
    };
    for (double value : {1e30, -1e30, 3e38, -3e38}) CHECK(changes({x}, value) == 0);
    for (double value : {-1e30, -3e38, 0.2, 1e-40}) CHECK(changes({z}, value) == 0);
    for (double value : {3.6e6, 1e30, 3e38}) CHECK(changes({f_dc_0 + 1}, value) == 0);
    for (double value : {-1000.0, -3e38, -inf}) CHECK(changes({opacity}, value) == 0);
    // Values whose square no float can hold: the splat is as wide as the frame and not invisible.
    for (double value : {20.0, 50.0, 100.0, 1e30, 3e38}) CHECK(changes({scale_0, scale_0 + 1, scale_0 + 2}, value) == 64 * 48);
    CHECK(changes({rot_0, rot_0 + 1}, 0) == 0);
    CHECK(changes({opacity}, inf) > 100);
    CHECK(changes({scale_0}, -inf) > 10);
}

TEST_CASE("a camera at a Gaussian's centre, a hair before it, inside a huge one")
{
    for (double const depth : {0.0, 1e-45, 0.2, 0.2000001, 0.5, -1.0})
        for (double const size : {-87.0, -10.0, -1.5, 0.0, 3.0, 10.0, 30.0, 1e30}) {
            CAPTURE(depth);
            CAPTURE(size);
            Ply ply;
            ply.rows = rows_around(ball(0, 0, depth));
            for (int axis = 0; axis < 3; ++axis) ply.rows[3].f[scale_0 + axis] = size;
            CHECK_FALSE(render_all(read(ply), front()));
        }
    // The near plane as close as it can be.
    Ply ply;
    ply.rows = rows_around(ball(0, 0, 1e-38));
    ply.rows[4] = ball(1e-30, 0, 1e-30);
    auto camera = front();
    for (float const near : {1e-45f, 1e-38f, 1e-20f}) {
        camera.near_depth = near;
        CHECK_FALSE(render_all(read(ply), camera));
    }
}

TEST_CASE("a camera so far away that depths are infinite")
{
    Ply ply;
    ply.rows = rows_around(ball(0, 0, 3e38));
    ply.rows[4] = ball(0, 0, 3e38);
    ply.rows[5] = ball(3e38, 0, 3e38);
    auto camera = front();
    for (float const away : {-3e38f, -1e30f, 3e38f}) {
        camera.position[2] = away;
        CHECK_FALSE(render_all(read(ply), camera));
    }
}

TEST_CASE("many Gaussians at one point: equal depths, then more than a tile can store")
{
    for (std::size_t const count : {std::size_t{1000}, std::size_t{2600}}) {
        CAPTURE(count);
        Ply ply;
        ply.rows.assign(count, ball(0.1, 0.1, 3));
        for (std::size_t i = 0; i < count; ++i) {
            ply.rows[i].f[f_dc_0] = 0.01 * static_cast<double>(i % 100);
            ply.rows[i].f[opacity] = -4.0 + 0.001 * static_cast<double>(i);
        }
        auto const map = read(ply);
        REQUIRE(map.gaussians.size() == count);
        CHECK(render_all(map, front()) == (count > splat::Lossless::sizes.storage));
    }
}
