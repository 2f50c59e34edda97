// test: unoptimised test
#include "../splat/pose_case.hpp"
#include "../splat/pose_reference.hpp"
#include "points.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/track/pose_evaluator.hpp>

using namespace tilemesh;
using namespace tilemesh::track;

// A tile of Mk2 holds the program and its memory.
using TrackedLossless = splat::pose::Tracked<splat::Lossless>;
static_assert(Tile<Mk2, splat::pose::PoseFrame<TrackedLossless>, TrackedLossless>::bytes <= Mk2::sram_bytes);

namespace {
using support::pose::same_sums, support::pose::sums_case;
using Case = support::pose::SumsCase;

/// A cloud that covers most pixels, and a target near it: the picture of another pose, brighter, with holes in its depth.
Case made_case(std::uint32_t width, std::uint32_t height, std::uint32_t n, std::uint64_t seed)
{
    auto c = sums_case(width, height, n, seed);
    c.camera = support::lens(width, height);
    auto frame = Renderer(c.map, splat::with_planes(splat::lossless, true, true)).render(support::lens(width, height, 0.01f));
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x) {
            for (int k = 0; k < 3; ++k) frame.image.pixel(x, y)[k] = frame.image.pixel(x, y)[k] * 1.1f + 0.02f * float((x * 7 + y * 13) % 5);
            if ((x + y) % 11 == 0) frame.depth.at(x, y) = 0;
            if ((3 * x + y) % 97 == 0) frame.image.pixel(x, y)[1] = std::numeric_limits<float>::quiet_NaN();
        }
    c.target = {std::move(frame.image), std::move(frame.depth)};
    return c;
}
template <class E>
NormalEquations evaluate(Case const& c, TrackOptions const& o, EvaluatorOptions const& e = {})
{
    E evaluator(c.map, {c.camera.width, c.camera.height}, e);
    return evaluator.evaluate(c.camera, c.target, o);
}
/// Options with an exposure, and its gain.
TrackOptions exposed(std::uint32_t cell, Jacobian jacobian)
{
    return {.level = {cell, jacobian, {0.05, -0.02}}, .with_exposure = true, .scene_depth = 1.7f};
}
double const gain = std::exp(0.05);
NormalEquations eight_unknowns()
{
    NormalEquations e;
    e.unknowns = 8;
    return e;
}
/// The sums of the mesh against those of a loop in double.
void check_sums(NormalEquations const& mine, NormalEquations const& e)
{
    CHECK(mine.unknowns == 8);
    CHECK(mine.pixels == e.pixels);
    CHECK(mine.cost == doctest::Approx(e.cost).epsilon(1e-4));
    for (std::uint32_t a = 0; a < 8; ++a) {
        CHECK(std::fabs(mine.g[a] - e.g[a]) < 1e-3 * std::sqrt(e.h[a][a] * e.cost));
        for (std::uint32_t b = 0; b < 8; ++b) CHECK(std::fabs(mine.h[a][b] - e.h[a][b]) < 1e-3 * std::sqrt(e.h[a][a] * e.h[b][b]));
    }
}
} // namespace

TEST_CASE("pose evaluator: sums have equal bits over tilings, threads, engines and forms")
{
    auto const c = made_case(112, 80, 500, 3);
    using ByValue = BasicPoseEvaluator<splat::pose::Tracked<splat::Lossless>>;
    using Checked = BasicPoseEvaluator<TrackedByReference<splat::Lossless>, CheckedMesh>;
    using CheckedByValue = BasicPoseEvaluator<splat::pose::Tracked<splat::Lossless>, CheckedMesh>;
    for (auto jacobian : {Jacobian::forward, Jacobian::gradient, Jacobian::esm})
        for (std::uint32_t cell : {1u, 2u, 4u, 8u})
            for (bool exposure : {false, true}) {
                TrackOptions const o{.level = {cell, jacobian, {0.1, 0.01}},
                                     .with_depth = cell != 2,
                                     .with_exposure = exposure,
                                     .one_in = exposure == (cell != 4) ? 1u : 3u,
                                     .scene_depth = 2.5f};
                auto const first = evaluate<PoseEvaluator>(c, o);
                CHECK(first.pixels > 0);
                CHECK(first.h[0][0] > 0);
                CHECK(same_sums(first, evaluate<PoseEvaluator>(c, o, {2, {16, 40}})));
                CHECK(same_sums(first, evaluate<PoseEvaluator>(c, o, {3, {8, 8}})));
                CHECK(same_sums(first, evaluate<PoseEvaluator>(c, o, {1, {24, 24}})));
                CHECK(same_sums(first, evaluate<PoseEvaluator>(c, o, {1, {56, 8}})));
                CHECK(same_sums(first, evaluate<ByValue>(c, o, {2, {16, 16}})));
                CHECK(same_sums(first, evaluate<Checked>(c, o, {1, {16, 40}})));
                CHECK(same_sums(first, evaluate<CheckedByValue>(c, o, {1, {40, 16}})));
                if (cell == 1) CHECK(same_sums(first, evaluate<PoseEvaluator>(c, o, {1, {17, 13}})));
            }
}

TEST_CASE("pose evaluator: tiles follow from the picture, and storage gets the memory that they leave")
{
    auto const mk2 = size_of_machine<Mk2>();
    auto const is = [](Extent2 a, std::uint32_t w, std::uint32_t h) { return a.width == w && a.height == h; };
    CHECK(is(tracking_tile({1280, 720}, mk2), 16, 40));
    CHECK(is(tracking_tile({640, 480}, mk2), 16, 16));
    CHECK(is(tracking_tile({320, 240}, mk2), 8, 8));
    CHECK(is(tracking_tile({160, 90}, mk2), 8, 8));
    CHECK(is(tracking_tile({1, 1}, mk2), 8, 8));
    auto const bytes = [&](splat::Sizes const& sizes) { return SramLedger<splat::pose::PoseFrame<TrackedLossless>>::bytes(mk2, sizes); };
    for (std::uint32_t pixels : {1u, 64u, 256u, 640u, 1024u, 2500u}) {
        auto sizes = splat::pose::sizes_on<TrackedLossless>(mk2, pixels);
        CHECK(sizes.tile_pixels == pixels);
        CHECK(sizes.storage > 0);
        CHECK(bytes(sizes) <= mk2.sram_bytes);
        ++sizes.storage;
        CHECK(bytes(sizes) > mk2.sram_bytes);
        CHECK(splat::pose::sizes_on<TrackedLossless>(mk2, pixels, 3).storage < sizes.storage);
    }
    CHECK(splat::pose::sizes_on<TrackedLossless>(mk2, 256).storage > 2000);
    CHECK(splat::pose::sizes_on<TrackedLossless>(mk2, 100'000).storage == 0);
    auto const c = sums_case(48, 40, 60, 2);
    CHECK(PoseEvaluator(c.map, {640, 480}).sizes() == splat::pose::sizes_on<TrackedLossless>(mk2, 256));
    CHECK_THROWS_AS(PoseEvaluator(c.map, {4000, 4000}), Error); // no tile has memory for so many pixels
}

TEST_CASE("pose evaluator: pairs are those of precise blending, and a view that comes back has the same sums")
{
    auto const c = sums_case(96, 80, 400, 5);
    PoseEvaluator evaluator(c.map, {96, 80});
    evaluator.set_target(c.target);
    auto const first = evaluator(c.camera, {});
    auto const pairs_of = [](auto const& mesh) {
        std::uint64_t pairs = 0;
        for (TileId const tile : mesh.grid().tiles())
            for (auto n : mesh.template state<splat::Work>(tile).contributing) pairs += n;
        return pairs;
    };
    auto const pairs = pairs_of(std::as_const(evaluator.mesh()));
    render::HostRenderer renderer(c.map, splat::lossless, {.arithmetic = splat::Arithmetic::precise}, {});
    (void)renderer.render(c.camera);
    CHECK(pairs == pairs_of(std::as_const(renderer.mesh())));
    auto const other = evaluator(support::lens(96, 80, 0.05f), {});
    CHECK(!same_sums(first, other));
    CHECK(same_sums(first, evaluator(c.camera, {})));
    CHECK(same_sums(first, evaluator(c.camera, {})));
}

TEST_CASE("pose evaluator: sums agree with residuals and central differences in double")
{
    namespace reference = support::pose;
    for (std::uint32_t cell : {1u, 4u}) {
        auto const c = made_case(48, 40, 150, 7 + cell);
        PoseEvaluator evaluator(c.map, {48, 40});
        auto& rules = evaluator.rules();
        rules.alpha_min = rules.transmittance_min = 0;
        auto const o = exposed(cell, Jacobian::forward);
        auto const mine = evaluator.evaluate(c.camera, c.target, o);

        auto const camera = reference::camera_of(c.camera, rules);
        auto const order = reference::sorted(c.map.gaussians, camera, rules);
        auto const picture = reference::render(reference::projected(order, camera, rules), camera, rules);
        auto const motion = reference::central_differences(order, camera, rules, 1e-5);
        auto e = eight_unknowns();
        for (std::uint32_t cy = 0; cy < 40; cy += cell)
            for (std::uint32_t cx = 0; cx < 48; cx += cell) {
                double j[4][8] = {}, r[4] = {}, n = 0, deep = 0;
                for (std::uint32_t y = cy; y < cy + cell; ++y)
                    for (std::uint32_t x = cx; x < cx + cell; ++x) {
                        std::size_t const i = y * 48 + x;
                        float const* const seen = c.target.colour.pixel(x, y);
                        if (!(picture[i].transmittance < 0.5) || std::isnan(seen[1])) continue;
                        ++n;
                        for (std::uint32_t k = 0; k < 3; ++k) {
                            r[k] += gain * picture[i].colour[k] - 0.02 - double{seen[k]};
                            for (std::uint32_t m = 0; m < 6; ++m) j[k][m] += gain * motion[m][i].colour[k] * (m < 3 ? double{o.scene_depth} : 1.0);
                            j[k][6] += gain * picture[i].colour[k], j[k][7] += 1;
                        }
                        double const z = c.target.depth.at(x, y);
                        if (!(z > 0)) continue;
                        ++deep;
                        r[3] += (picture[i].depth - z) / z;
                        for (std::uint32_t m = 0; m < 6; ++m) j[3][m] += motion[m][i].depth / z * (m < 3 ? double{o.scene_depth} : 1.0);
                    }
                if (n == 0) continue;
                ++e.pixels;
                for (std::uint32_t k = 0; k < 4; ++k) {
                    if (k == 3 && !(2 * deep > n)) continue;
                    double const count = k < 3 ? n : deep;
                    for (double& v : j[k]) v /= count;
                    track_test::add_row(e, j[k], r[k] / count, k < 3 ? 0.1 : 0.05);
                }
            }
        CHECK(e.pixels > 50);
        check_sums(mine, e);
    }
}

TEST_CASE("pose evaluator: bad requests are one line")
{
    auto const c = sums_case(48, 40, 60, 2);
    PoseEvaluator evaluator(c.map, {48, 40}, {1, {12, 40}});
    auto const refused = [&](auto const& ask) {
        auto const text = tests::error_of(ask);
        return tests::has(text, " (") && tests::has(text, "); ") && !tests::has(text, "\n");
    };
    auto const refuses = [&](TrackOptions const& o) { return refused([&] { (void)evaluator.evaluate(c.camera, o); }); };
    TrackOptions o;
    CHECK(refuses(o)); // no target
    evaluator.set_target(c.target);
    (void)evaluator.evaluate(c.camera, o);
    for (std::uint32_t cell : {0u, 3u, 8u, 16u}) {
        o.level.cell = cell;
        CHECK(refuses(o));
    }
    o = {};
    o.one_in = 0;
    CHECK(refuses(o));
    o = {};
    for (float bad : {0.0f, -1.0f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        o.scene_depth = bad;
        CHECK(refuses(o));
    }
    o = {};
    CHECK(refused([&] { (void)evaluator.evaluate(support::lens(40, 40), o); }));
    CHECK(refused([&] { evaluator.set_target({report::Image(47, 40), {}}); }));
    CHECK(refused([&] { evaluator.set_target({report::Image(48, 40), report::Plane(48, 39)}); }));
    std::vector<splat::Gaussian> crowd;
    for (std::uint32_t i = 1; i <= 3000; ++i) {
        auto g = support::ball(i, 0, 0, 30.0f);
        g.mean_world[2] = 3;
        for (float& s : g.log_scale) s = -1;
        crowd.push_back(g);
    }
    PoseEvaluator full(support::map_of(crowd), {48, 40}, {1, {16, 40}});
    full.set_target(c.target);
    CHECK(refused([&] { (void)full.evaluate(c.camera, TrackOptions{}); }));
    // Black pictures and pictures of nothing give sums, not errors.
    auto const nothing = evaluator.evaluate(support::lens(48, 40, 3.14f), TrackOptions{});
    CHECK(nothing.pixels == 0);
    CHECK(nothing.cost == 0);
}

TEST_CASE("pose evaluator: gradients of the picture agree with a loop in double")
{
    struct Cell {
        double rgb[3], depth, seen[3], seen_depth;
        bool covered;
    };
    for (auto jacobian : {Jacobian::gradient, Jacobian::esm})
        for (std::uint32_t cell : {1u, 4u}) {
            auto const c = made_case(58, 40, 300, 11 + cell); // cells of 4 do not divide the frame
            PoseEvaluator evaluator(c.map, {58, 40}, {1, {16, 8}});
            auto const o = exposed(cell, jacobian);
            auto const mine = evaluator.evaluate(c.camera, c.target, o);

            auto const frame = Renderer(c.map, splat::with_planes(splat::lossless, true, true)).render(c.camera);
            std::uint32_t const width = 58 / cell, height = 40 / cell;
            std::vector<Cell> cells;
            for (std::uint32_t y = 0; y < height; ++y)
                for (std::uint32_t x = 0; x < width; ++x) {
                    Cell m{};
                    double alpha = 0, known = 0, n = double(cell) * cell;
                    for (std::uint32_t v = y * cell; v < (y + 1) * cell; ++v)
                        for (std::uint32_t u = x * cell; u < (x + 1) * cell; ++u) {
                            for (int k = 0; k < 3; ++k) m.rgb[k] += double{frame.image.pixel(u, v)[k]} / n, m.seen[k] += double{c.target.colour.pixel(u, v)[k]} / n;
                            alpha += double{frame.alpha.at(u, v)};
                            m.depth += double{frame.alpha.at(u, v)} * double{frame.depth.at(u, v)};
                            if (c.target.depth.at(u, v) > 0) m.seen_depth += double{c.target.depth.at(u, v)}, ++known;
                        }
                    m.covered = alpha > 0.5 * n;
                    m.depth /= alpha;
                    m.seen_depth = 2 * known > n ? m.seen_depth / known : 0;
                    cells.push_back(m);
                }
            auto e = eight_unknowns();
            double const fx = double{c.camera.fx} / cell, fy = double{c.camera.fy} / cell;
            for (std::uint32_t y = 1; y + 1 < height; ++y)
                for (std::uint32_t x = 1; x + 1 < width; ++x) {
                    auto const at = [&](std::uint32_t u, std::uint32_t v) -> Cell const& { return cells[v * width + u]; };
                    Cell const &m = at(x, y), &l = at(x - 1, y), &r = at(x + 1, y), &a = at(x, y - 1), &b = at(x, y + 1);
                    double const sx = (x + 0.5 - double{c.camera.cx} / cell) / fx, sy = (y + 0.5 - double{c.camera.cy} / cell) / fy, z = m.depth, s = double{o.scene_depth};
                    double const du[6] = {fx / z * s, 0, -fx * sx / z * s, -fx * sx * sy, fx * (1 + sx * sx), -fx * sy};
                    double const dv[6] = {0, fy / z * s, -fy * sy / z * s, -fy * (1 + sy * sy), fy * sx * sy, fy * sx};
                    double const dz[6] = {0, 0, s, sy * z, -sx * z, 0};
                    double j[4][8] = {}, res[4];
                    bool counts = m.covered;
                    for (int k = 0; k < 3; ++k) {
                        double gx = 0.5 * gain * (r.rgb[k] - l.rgb[k]), gy = 0.5 * gain * (b.rgb[k] - a.rgb[k]);
                        if (jacobian == Jacobian::esm) gx = 0.5 * gx + 0.25 * (r.seen[k] - l.seen[k]), gy = 0.5 * gy + 0.25 * (b.seen[k] - a.seen[k]);
                        res[k] = gain * m.rgb[k] - 0.02 - m.seen[k];
                        for (int i = 0; i < 6; ++i) j[k][i] = -(gx * du[i] + gy * dv[i]);
                        j[k][6] = gain * m.rgb[k], j[k][7] = 1;
                        counts = counts && std::isfinite(res[k]) && std::isfinite(gx) && std::isfinite(gy);
                    }
                    if (!counts) continue;
                    ++e.pixels;
                    bool const deep = m.seen_depth > 0 && l.covered && r.covered && a.covered && b.covered;
                    if (deep) {
                        res[3] = (z - m.seen_depth) / m.seen_depth;
                        for (int i = 0; i < 6; ++i) j[3][i] = (dz[i] - 0.5 * (r.depth - l.depth) * du[i] - 0.5 * (b.depth - a.depth) * dv[i]) / m.seen_depth;
                    }
                    for (int k = 0; k < (deep ? 4 : 3); ++k) track_test::add_row(e, j[k], res[k], k < 3 ? 0.1 : 0.05);
                }
            CHECK(e.pixels > 30);
            check_sums(mine, e);
        }
}
