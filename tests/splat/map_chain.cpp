// test: optimised, needs data, cost 5
#include "map_reference.hpp"
#include "scenes.hpp"
#include <tilemesh/splat/map/loss.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;
namespace reference = support::map;
using reference::D;
using F = splat::detail::OneFloat;

namespace {
char const* const kind_names[map::kinds] = {"mean", "log-scale", "quaternion", "logit", "colour"};

/// Errors by kind, relative to the rms of the kind in a scene.
struct Errors {
    std::vector<double> of[map::kinds];

    void add(std::vector<std::array<double, map::parameters>> const& mine, std::vector<std::array<double, map::parameters>> const& truth)
    {
        for (std::uint32_t kind = 0; kind < map::kinds; ++kind) {
            auto const p = map::places_of(static_cast<map::Kind>(kind));
            double squares = 0, n = 0;
            for (auto const& t : truth)
                for (std::uint32_t k = p.first; k < p.end; ++k) squares += t[k] * t[k], ++n;
            double const rms = std::sqrt(squares / n);
            for (std::size_t i = 0; i < truth.size() && rms > 0; ++i)
                for (std::uint32_t k = p.first; k < p.end; ++k) of[kind].push_back(std::fabs(mine[i][k] - truth[i][k]) / rms);
        }
    }
    void check(std::string const& name)
    {
        for (std::uint32_t kind = 0; kind < map::kinds; ++kind) {
            auto& all = of[kind];
            REQUIRE(!all.empty());
            CHECK(std::none_of(all.begin(), all.end(), [](double e) { return std::isnan(e); }));
            std::sort(all.begin(), all.end());
            double const p99 = all[std::min(all.size() - 1, std::size_t(0.99 * double(all.size())))];
            MESSAGE(name << ", " << std::string(kind_names[kind]) << ": p99 " << p99 << ", largest " << all.back() << " of " << all.size());
            CHECK(p99 < 1e-5);
            CHECK(all.back() < 1e-3);
        }
    }
};

/// The slopes of Gaussian i by Richardson's extrapolation of central differences.
std::array<double, map::parameters> differences(reference::Frame const& f, reference::Camera const& c, Rules const& rules,
                                                reference::Linear const& slopes, std::uint32_t i)
{
    auto const& s = f.splats[i];
    std::vector<std::size_t> touched;
    for (std::size_t pixel = 0; pixel < f.pixels.size(); ++pixel)
        if (std::any_of(f.pixels[pixel].begin(), f.pixels[pixel].end(),
                        [&](auto const& p) { return p.splat == i; })) touched.push_back(pixel);
    double const thin = std::sqrt(std::min(s.a, s.d / s.a)), fat = std::sqrt(std::max(s.a, s.d / s.a));
    auto const& g = f.gaussians[i];
    double const length = std::sqrt(g[6] * g[6] + g[7] * g[7] + g[8] * g[8] + g[9] * g[9]);
    std::array<double, map::parameters> out{};
    for (std::uint32_t k = 0; k < map::parameters; ++k) {
        // About 1e-4 of the smallest length that matters.
        double const step = 1e-4 * (k < 3 ? std::min(s.z / std::max(c.fx, c.fy) * thin, s.z) / std::max(1.0, fat / 20) : k >= 6 &&
                                    k < 10 ? length * thin / fat : 1.0);
        double by[2];
        for (int half = 0; half < 2; ++half) {
            double const h = step / (1 << half);
            double value[2] = {0, 0};
            for (int side = 0; side < 2; ++side) {
                auto moved = g;
                moved[k] += side == 1 ? h : -h;
                reference::Splat other;
                reference::project(moved, c, rules, other);
                for (auto const pixel : touched)
                    value[side] += reference::loss_of(f, pixel, double(pixel % c.width) + 0.5 - c.cx,
                                                      double(pixel / c.width) + 0.5 - c.cy, slopes[pixel], i, other);
            }
            by[half] = (value[1] - value[0]) / (2 * h);
        }
        out[k] = (4 * by[1] - by[0]) / 3;
    }
    return out;
}
std::uint32_t bent = 0; ///< Gaussians that were compared through a lens
/// Compares the chain rule with differences for every `every`-th Gaussian.
void compare(Errors& errors, std::vector<Gaussian> const& gaussians, Camera const& camera, Rules const& rules, std::uint64_t seed,
             std::size_t every = 1)
{
    auto const view = make_view(camera, rules);
    auto c = support::pose::camera_of(camera, rules);
    c.limit_x = view.rules.slope_limit[0], c.limit_y = view.rules.slope_limit[1];
    auto const f = reference::frozen(gaussians, c, rules);
    auto const slopes = reference::random_slopes(f.pixels.size(), seed);
    auto const moments = reference::moments(f, c, rules, slopes);
    std::vector<std::array<double, map::parameters>> mine, truth;
    for (std::size_t i = 0; i < f.gaussians.size(); i += every) {
        auto const& g = f.gaussians[i];
        double const sx = std::fabs(f.splats[i].u / c.fx), sy = std::fabs(f.splats[i].v / c.fy);
        if (std::fabs(sx - c.limit_x) < 1e-3 || std::fabs(sy - c.limit_y) < 1e-3) continue; // a step begins or ceases to clamp
        if (camera.lens.kind == LensKind::fisheye) ++bent;
        else if (camera.lens.kind != LensKind::pinhole) { // beyond a lens's limit its Jacobian does not move
            auto const& p = f.splats[i].p;
            if (std::hypot(p[0], p[1]) > (double{c.bent.lens.limit} - 1e-3) * p[2]) continue;
            ++bent;
        }
        map::Slopes<D> one;
        REQUIRE(map::chain_rule<D>(reference::words_of(g), view, moments[i], one));
        mine.emplace_back();
        std::copy_n(one.of, map::parameters, mine.back().begin());
        truth.push_back(differences(f, c, rules, slopes, static_cast<std::uint32_t>(i)));
    }
    errors.add(mine, truth);
}
} // namespace

TEST_CASE("map slopes: parameters agree with central differences in double on 200 stiff scenes, with frozen sets")
{
    using Case = std::tuple<float, Stop, Coverage>;
    for (auto const& [alpha_max, stop, coverage] :
         {Case{0.99f, Stop::after_crossing, Coverage::of_record}, Case{1.0f, Stop::after_crossing, Coverage::of_record},
          Case{0.99f, Stop::before_crossing, Coverage::of_record}, Case{0.99f, Stop::after_crossing, Coverage::preserved}}) {
        Rules rules;
        rules.alpha_max = alpha_max;
        rules.stop = stop;
        rules.coverage = coverage;
        Errors errors;
        for (std::uint64_t seed = 0; seed < (support::fast() ? 6u : 67u); ++seed) {
            auto const scene = reference::stiff_scene(seed);
            compare(errors, scene.gaussians, scene.camera, rules, seed);
        }
        std::string const when = stop == Stop::after_crossing ? "after" : "before";
        errors.check(when + " crossing, alpha_max " + (alpha_max < 1 ? "0.99" : "1") +
                     (coverage == Coverage::preserved ? ", preserved coverage" : ""));
    }
}

TEST_CASE("map slopes: through lenses they agree with central differences in double")
{
    for (auto const& [name, lens] : {std::pair<char const*, Lens>{"radial and tangential", {LensKind::opencv, {0.26f, -0.4f, 0.2f, 0, 0, 0}, {-0.0054f, 0.0026f}, 0, 0}},
                                     {"rational", {LensKind::opencv, {0.3f, -0.1f, 0.02f, 0.35f, -0.05f, 0.01f}, {0.001f, -0.002f}, 0, 0}},
                                     {"fov", {LensKind::fov, {0.93f}, {}, 0, 0}},
                                     {"fisheye", {LensKind::fisheye, {-0.02f, 0.01f, -0.002f, 0.0003f}, {}, 0, 0}}}) {
        bent = 0;
        Errors errors;
        for (std::uint64_t seed = 0; seed < (support::fast() ? 6u : 67u); ++seed) {
            auto scene = reference::stiff_scene(seed);
            scene.camera.lens = lens;
            compare(errors, scene.gaussians, scene.camera, {}, seed);
        }
        CHECK(bent > 50);
        errors.check(name);
    }
}

TEST_CASE("map slopes: parameters agree with central differences in double on whole maps")
{
    support::with_front_views([](std::string const& name, std::vector<Gaussian> const& map, Camera const& whole) {
        Rules rules;
        Errors errors;
        for (std::uint32_t window = 0; window < (support::fast() ? 1u : 4u); ++window) {
            auto const x = whole.width * (3 * window + 4) / 20, y = whole.height * (9 - window) / 20;
            auto const camera = window_of(whole, {x, x + 24, y, y + 10});
            compare(errors, map, camera, bounds_of(whole, rules), window, 37); // of those that the window does not show, all slopes are 0
        }
        errors.check(name);
    });
}

TEST_CASE("map slopes: in float they are within 2e-5 of double in the L2 norm of a kind, from the same moments")
{
    double most = 0;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        auto const scene = reference::stiff_scene(seed);
        Rules const rules;
        auto const view = make_view(scene.camera, rules);
        support::Random random(seed);
        double error[map::kinds] = {}, all[map::kinds] = {};
        for (auto const& g : scene.gaussians) {
            map::Moments<F> single;
            map::Moments<D> twice;
            for (std::uint32_t k = 0; k < map::sums; ++k) twice.of[k] = double{single.of[k] = random.uniform(-1, 1)};
            map::Slopes<F> mine;
            map::Slopes<D> truth;
            if (!map::slopes_of(g, view, single, mine)) continue;
            auto p = reference::parameters_of(g);
            auto words = reference::words_of(p);
            words.opacity = double{g.opacity};
            REQUIRE(map::chain_rule<D>(words, view, twice, truth));
            for (std::uint32_t kind = 0; kind < map::kinds; ++kind)
                for (auto k = map::places_of(static_cast<map::Kind>(kind)).first; k < map::places_of(static_cast<map::Kind>(kind)).end; ++k)
                    error[kind] += std::pow(double{mine.of[k]} - truth.of[k], 2), all[kind] += std::pow(truth.of[k], 2);
        }
        for (std::uint32_t kind = 0; kind < map::kinds; ++kind) most = std::max(most, std::sqrt(error[kind] / all[kind]));
    }
    MESSAGE("largest relative L2 error " << most);
    CHECK(most < 2e-5);
}

TEST_CASE("map slopes: no Gaussian gives NaN or infinity; a black one has a slope, and a saturated one has none by its logit")
{
    support::Random random(5);
    std::uint32_t sound = 0, shown = 0;
    for (float dilation : {0.3f, 0.0f}) {
        Rules rules;
        rules.dilation = dilation;
        for (std::uint64_t seed = 0; seed < 50; ++seed) {
            auto const scene = reference::stiff_scene(seed);
            auto const view = make_view(scene.camera, rules);
            for (auto g : scene.gaussians) {
                support::spoil(g, random, 7);
                auto const s = project(g, view, TileSize{48, 32});
                if (!s.visible()) continue;
                ++shown;
                map::SplatSums quanta;
                for (auto& v : quanta.of) v = static_cast<std::int32_t>(random.bits() % (1u << 30)) - (1 << 29);
                auto const m = map::moments_of(quanta, s, dilation, 4);
                map::Slopes<F> out;
                sound += map::slopes_of(g, view, m, out);
                for (float const v : out.of) REQUIRE(std::isfinite(v));
            }
        }
    }
    CHECK(shown > 1000);
    CHECK(sound > shown * 3 / 4); // the others are spoilt

    auto g = support::ball(1, 8, 6, 2, 1.0f);
    for (float& c : g.colour) c = 0;
    auto const view = make_view(support::flat_camera(16, 12), Rules{});
    map::Moments<F> m{};
    for (float& v : m.of) v = 1;
    map::Slopes<F> out;
    REQUIRE(map::slopes_of(g, view, m, out));
    CHECK(out.of[map::places_of(map::Kind::logit).first] == 0);
    for (std::uint32_t i = 0; i < 3; ++i) CHECK(out.of[map::places_of(map::Kind::colour).first + i] == 1);
}

TEST_CASE("map loss: a residual's loss and slope, absolute and Huber, by hand")
{
    using map::detail::Robust;
    CHECK(Robust<F>(0.5f, 0).loss == 0.5f);
    CHECK(Robust<F>(0.5f, 0).slope == 1);
    CHECK(Robust<F>(-0.25f, 0).slope == -1);
    CHECK(Robust<F>(0.0f, 0).slope == 0);
    CHECK(Robust<F>(0.5f, 2).loss == 0.0625f);
    CHECK(Robust<F>(0.5f, 2).slope == 0.25f);
    CHECK(Robust<F>(-3.0f, 2).loss == 2);
    CHECK(Robust<F>(-3.0f, 2).slope == -1);
}
