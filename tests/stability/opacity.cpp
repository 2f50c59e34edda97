#include "../scene/ply_writer.hpp"
#include "catalogue.hpp"
#include "kernel_pixel.hpp"
#include "machines.hpp"
#include "reference.hpp"
#include <tilemesh/splat/compositing.hpp>

// Opacity and compositing: rows 39 to 55 of the catalogue.
using namespace tilemesh;
using namespace tilemesh::splat;
using stability::Kind;
using stability::number;

namespace {
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
constexpr float infinity = std::numeric_limits<float>::infinity();
using stability::u; // half a unit in the last place at 1

double levels(double v)
{
    return 255 * v;
}

/// 20 x 20 pixels; the middle of pixel (10, 10) is the principal point.
Camera small_camera()
{
    auto camera = support::flat_camera(20, 20);
    camera.cx = camera.cy = 10.5f;
    return camera;
}
/// A grey splat that covers `small_camera` evenly.
Gaussian layer(std::uint32_t id, float opacity, float grey, float depth = 1000)
{
    auto g = support::ball(id, 0, 0, 1000, opacity);
    g.mean_world[2] = depth;
    for (float& c : g.colour) c = grey;
    return g;
}
/// n white layers of one opacity.
std::vector<Gaussian> layers_of(std::uint32_t n, float opacity)
{
    std::vector<Gaussian> layers;
    for (std::uint32_t i = 0; i < n; ++i) layers.push_back(layer(i + 1, opacity, 1));
    return layers;
}
/// The middle pixel of the mesh's picture.
float middle(std::vector<Gaussian> layers, Rules const* rules = nullptr)
{
    return stability::render(Kind::roomy, support::map_of(std::move(layers)), small_camera(), {.grid = {1, 1}}, rules).image.pixel(10, 10)[0];
}
Splat splat_of(Gaussian const& g, Camera const& camera, Rules const& rules = {})
{
    return stability::our_splat(g, camera, rules);
}

struct Layer {
    float alpha, grey;
};
/// The canonical loop for one pixel: alpha is clamped at 0.99, a layer under 1/255 is skipped, and the layer that would bring T below
/// `stop` is not blended. `Real` is the arithmetic.
template <class Real>
Real canonical_pixel(std::vector<Layer> const& layers, Real clamp = Real(0.99), Real stop = Real(1e-4))
{
    Real c = 0, t = 1;
    for (auto const& l : layers) {
        Real const alpha = std::min(clamp, Real(l.alpha));
        if (alpha < Real(1) / 255) continue;
        Real const after = t * (1 - alpha);
        if (after < stop) break;
        c += Real(l.grey) * alpha * t;
        t = after;
    }
    return c;
}

using stability::KernelPixel;
Rules without_cuts()
{
    Rules m;
    m.alpha_min = m.transmittance_min = 0;
    return m;
}
/// The stop of 3D Gaussian Splatting.
Rules with_its_stop()
{
    Rules m;
    m.transmittance_min = 1e-4f;
    return m;
}
/// With the stop of 3D Gaussian Splatting, white of this alpha behind black of 0.99 is off by at most T_min; `naive` is off by more.
void check_stop(stability::Result row, double naive, float alpha, double truth)
{
    Rules const rules = with_its_stop();
    double const ours = double{middle({layer(1, 0.99f, 0), layer(2, alpha, 1)}, &rules)};
    CHECK(std::fabs(naive - truth) > 1e-4); // T_min times the largest colour
    CHECK(std::fabs(ours - truth) <= 1e-4);
    row.naive = number(levels(std::fabs(naive - truth))) + " levels off";
    row.ours = number(levels(std::fabs(ours - truth))) + " levels off";
    stability::report(row);
}
} // namespace

TEST_CASE("row 39: opacity NaN draws nothing")
{
    // std::min(a, b) is b < a ? b : a, and NaN < 1/255 is false.
    float const naive_alpha = std::min(0.99f, not_a_number * 1.0f);
    bool const naive_skips = naive_alpha < 1.0f / 255;
    float const naive = naive_skips ? 0.0f : naive_alpha;
    CHECK(naive != 0.0f);

    Rules square; // whose size does not depend on the opacity
    square.footprint = Footprint::three_sigma_square;
    CHECK(middle({layer(1, not_a_number, 1)}) == 0.0f);
    CHECK(middle({layer(1, not_a_number, 1)}, &square) == 0.0f);
    auto ply = scene_test::several(3);
    ply.rows[1].f[6] = not_a_number;
    auto const map = scene_test::read(ply);
    CHECK(map.rejected == 1);
    CHECK(map.gaussians.size() == 2);
    stability::report(
        {39, "opacity NaN", "alpha " + number(double{naive}) + ": an opaque blob", "nothing drawn; the loader rejects the row", "exact", true});
}

TEST_CASE("row 40: an infinite scale has no NaN radius: the tiles that are counted are the tiles that draw")
{
    // Inria's test accepts NaN: det is NaN, and so is the radius.
    float const variance = infinity, det = variance * variance - variance * variance;
    bool const naive_accepts = !(det == 0.0f);
    float const radius = std::ceil(3.0f * std::sqrt(0.5f * (variance + variance) + std::sqrt(std::max(0.1f, det))));
    auto const tiles = std::clamp(naive::to_int(10.0f + det + radius), 0, 40) - std::clamp(naive::to_int(10.0f - det - radius), 0, 40);
    CHECK(naive_accepts);
    CHECK(tiles == 0); // counted as visible, but it writes no key

    std::uint64_t wrong = 0;
    auto const camera = small_camera();
    for (int axis = 0; axis < 3; ++axis) {
        auto g = layer(1, 0.9f, 1);
        g.log_scale[axis] = infinity;
        auto runner = stability::make_runner(Kind::roomy, support::map_of({g, layer(2, 0.5f, 1, 1001)}), {.tile = {8, 8}});
        auto const frame = runner->render(camera);
        wrong += frame.report.lost.size() + runner->wrong_tiles(camera) + runner->differing_pixels(frame, camera);
        wrong += stability::finite(frame) ? 0 : 1;
        CHECK(frame.report.gaussians.visible == 1); // the test refuses NaN
        auto ply = scene_test::several(1);
        ply.rows[0].f[7 + axis] = double{infinity};
        CHECK(scene_test::read(ply).rejected == 1);
    }
    CHECK(wrong == 0);
    stability::report({40, "scale Inf", "accepted, det NaN, 0 tiles: garbage keys",
                       std::to_string(wrong) + " tiles or pixels wrong: not drawn, and the loader rejects the row", "exact", true});
}

TEST_CASE("row 41: NaN in any field is never hidden by a maximum")
{
    float const fields[] = {1.0f, not_a_number, 2.0f};
    float largest = 0;
    for (float f : fields) largest = std::max(largest, std::fabs(f));
    bool const naive_accepts = largest <= 1e9f;
    CHECK(naive_accepts);

    std::uint32_t drawn = 0, not_finite = 0;
    for (std::uint32_t field = 0; field < 14; ++field)
        for (float value : {not_a_number, infinity, -infinity}) {
            auto g = layer(1, 0.9f, 1);
            float* const words[] = {g.mean_world, g.mean_world + 1, g.mean_world + 2, g.colour,       g.colour + 1, g.colour + 2,    &g.opacity,
                                    g.rotation,   g.rotation + 1,   g.rotation + 2,   g.rotation + 3, g.log_scale,  g.log_scale + 1, g.log_scale + 2};
            *words[field] = value;
            auto const s = splat_of(g, small_camera());
            if (!s.visible()) continue;
            ++drawn;
            for (float v : {s.mean_px[0], s.mean_px[1], s.along, s.slope, s.across, s.opacity, s.colour[0], s.colour[1], s.colour[2], s.depth()})
                not_finite += std::isfinite(v) ? 0 : 1;
            not_finite += stability::finite(stability::render(Kind::roomy, support::map_of({g}), small_camera(), {.grid = {1, 1}})) ? 0 : 1;
        }
    CHECK(not_finite == 0);
    CHECK(drawn < 42 / 4); // a size of zero and an opacity of one are valid; NaN and infinite places are not
    stability::report({41, "NaN or Inf in each of the 14 fields", "max(m, fabs(NaN)) <= big: accepted",
                       std::to_string(not_finite) + " words or pixels not finite", "exact", true});
}

TEST_CASE("row 42: an opacity under alpha_min has no radius")
{
    float const o = 0.001086f;
    float const power = 2 * std::log(255 * o), root = std::sqrt(power);
    auto const naive = naive::to_int(std::ceil(root));
    CHECK(power == doctest::Approx(-2.57).epsilon(0.01));
    CHECK(naive == std::numeric_limits<int>::min());

    CHECK_FALSE(splat_of(layer(1, o, 1), small_camera()).visible());
    CHECK_FALSE(splat_of(layer(1, std::nextafter(1.0f / 255, 0.0f), 1), small_camera()).visible());
    auto const edge = splat_of(layer(1, 1.0f / 255, 1), small_camera());
    CHECK(edge.visible());
    CHECK(std::isfinite(edge.faintest));
    Rules square;
    square.footprint = Footprint::three_sigma_square;
    CHECK_FALSE(splat_of(layer(1, o, 1), small_camera(), square).visible());
    CHECK(middle({layer(1, o, 1)}) == 0.0f);
    stability::report({42, "opacity 0.001086", "radius " + std::to_string(naive), "invisible", "exact", true});
}

TEST_CASE("row 43: opacities that round to 1 and to 0 stay opacities")
{
    double naive_error = 0, our_error = 0;
    std::string naive, ours;
    for (float logit : {16.64f, -88.73f}) {
        double const truth = 1 / (1 + std::exp(-double{logit}));
        float const simple = 1.0f / (1.0f + std::exp(-logit));
        auto ply = scene_test::several(1);
        ply.rows[0].f[6] = double{logit};
        auto const map = scene_test::read(ply);
        REQUIRE(map.gaussians.size() == 1);
        float const o = map.gaussians[0].opacity;
        naive_error = std::max(naive_error, std::fabs(double{simple} - truth));
        our_error = std::max(our_error, std::fabs(double{o} - truth));
        naive += (naive.empty() ? "" : ", ") + number(double{simple});
        ours += (ours.empty() ? "" : ", ") + number(double{o});
    }
    CHECK(naive_error <= u);
    CHECK(our_error <= u);
    // T - w is 0 behind an opaque layer, not an underflow or a negative number.
    CHECK(middle({layer(1, 1, 0.25f), layer(2, 1, 100)}) == 0.25f);
    stability::report({43, "logit 16.64, -88.73", naive, ours + "; error " + number(our_error), "u", false});
}

TEST_CASE("row 44: opaque black hides opaque white")
{
    float const naive = canonical_pixel<float>({{1, 0}, {1, 1}}, 0.99f, 0.0f);
    float const ours = middle({layer(1, 1, 0), layer(2, 1, 1)});
    CHECK(levels(double{naive}) == doctest::Approx(2.52).epsilon(0.01));
    CHECK(naive != 0.0f);
    CHECK(ours == 0.0f);
    stability::report(
        {44, "opaque black over opaque white", number(levels(double{naive})) + " levels", number(levels(double{ours})) + " levels", "exact", true});
}

TEST_CASE("row 45: two layers at 0.99: the second is blended before the pixel stops")
{
    std::vector<Layer> const layers{{0.99f, 0}, {0.99f, 1}};
    double const truth = (1 - 0.99) * 0.99; // without any cut
    CHECK((1 - 0.99f) * (1 - 0.99f) < 1e-4f);
    CHECK((1 - 0.99) * (1 - 0.99) >= 1e-4);
    double const naive = double{canonical_pixel<float>(layers)}, in_double = canonical_pixel<double>(layers);
    CHECK(levels(in_double - naive) == doctest::Approx(2.52).epsilon(0.01)); // one rounding
    check_stop({45, "two layers at 0.99, black over white", "", "", "T_min * max c = 0.0255 levels", true}, naive, 0.99f, truth);
}

TEST_CASE("row 46: 0.99 black over 0.995 white keeps the layer that crosses the limit")
{
    double const truth = 0.01 * 0.995;
    double const naive = double{canonical_pixel<float>({{0.99f, 0}, {0.995f, 1}}, 1.0f)};
    CHECK(levels(truth) == doctest::Approx(2.54).epsilon(0.01));
    check_stop({46, "0.99 black over 0.995 white", "", "", "T_min = 0.0255 levels", true}, naive, 0.995f, truth);
}

TEST_CASE("row 47: fog under 1/255 is a knob, and its price is known")
{
    std::string naive, ours;
    double worst = 0;
    for (std::uint32_t n : {10u, 100u, 1000u}) {
        double const truth = 1 - std::pow(1 - double{0.0039f}, n);
        auto const fog = layers_of(n, 0.0039f);
        double const skipped = double{canonical_pixel<float>(std::vector<Layer>(n, {0.0039f, 1}))};
        CHECK(skipped == 0);
        CHECK(middle(fog) == 0.0f); // the default has the same cut: E_cut
        Rules open;
        open.alpha_min = 0;
        double const error = std::fabs(double{middle(fog, &open)} - truth);
        CHECK(levels(truth) > 1);
        CHECK(levels(error) <= 1e-2);
        worst = std::max(worst, error);
        naive += (naive.empty() ? "" : ", ") + number(levels(truth));
    }
    stability::report({47, "10, 100, 1000 layers of 0.0039", naive + " levels lost (E_cut, ours by default too)",
                       number(levels(worst)) + " levels with alpha_min = 0", "0.01 levels", true});
}

TEST_CASE("row 48: the edge of an opaque splat is a step of at most one level")
{
    // A row of pixels through the mean; a = sigma^2 + 0.3.
    float const sigma = 20.0f;
    auto camera = support::flat_camera(200, 1);
    camera.cy = 0.5f;
    double const root = std::sqrt(double{sigma} * double{sigma} + 0.3);
    float const centre = static_cast<float>(160.5 - 3.001 * root); // a pixel centre just outside 3 sigma
    auto const g = support::ball(1, centre, 0, sigma, 1);
    auto const s = splat_of(g, camera);
    auto const rect = s.rect();
    auto white = g;
    for (float& c : white.colour) c = 1;
    auto const image = stability::render(Kind::roomy, support::map_of({white}), camera, {.grid = {1, 1}}).image;
    double naive = 0, ours = 0, drawn = 0;
    for (std::uint32_t x = 0; x < camera.width; ++x) {
        double const d = x + 0.5 - double{centre}, alpha = std::exp(-0.5 * d * d / (root * root));
        if (std::fabs(d) > 3 * root) naive = std::max(naive, alpha);
        if (x < rect.x0 || x >= rect.x1) ours = std::max(ours, alpha);
        drawn = std::max(drawn, std::fabs(double{image.pixel(x, 0)[0]} - alpha));
    }
    CHECK(levels(naive) == doctest::Approx(2.83).epsilon(0.02));
    CHECK(levels(naive) > 1);
    CHECK(levels(ours) <= 1);
    CHECK(levels(drawn) <= 1.001);
    stability::report({48, "sigma 20 px, opacity 1: largest alpha outside the footprint", number(levels(naive)) + " levels (3 sigma)",
                       number(levels(ours)) + " levels; picture off by " + number(levels(drawn)), "1 level", true});
}

TEST_CASE("row 49: a million layers of 1e-5: the transmittance keeps three digits")
{
    std::uint32_t const n = support::fast() ? 100'000 : 1'000'000;
    float const alpha = 1e-5f;
    double const truth = std::exp(n * std::log1p(-double{alpha}));
    float naive = 1;
    KernelPixel ours(without_cuts());
    for (std::uint32_t i = 0; i < n; ++i) {
        naive *= 1 - alpha;
        ours.blend(alpha);
    }
    double const tolerance = 1e-9 * n;
    double const naive_error = std::fabs(double{naive} - truth) / truth;
    double const our_error = std::fabs(ours.transmittance() - truth) / truth;
    CHECK(naive_error > tolerance);
    CHECK(our_error <= tolerance);
    stability::report({49, std::to_string(n) + " layers of 1e-5", "T off by " + number(naive_error), "T off by " + number(our_error),
                       "1e-9 a layer, relative", true});
}

TEST_CASE("row 50 does not apply")
{
    KernelPixel pixel(without_cuts());
    for (int i = 0; i < 1000; ++i) pixel.blend(2e-8f);
    CHECK(pixel.transmittance() == 1); // what a log-domain mode would be for
    stability::does_not_apply(50, "layers of 2e-8 are 1e5 times under alpha_min; a log-domain transmittance is an opt-in mode that "
                                  "the library does not have");
}

TEST_CASE("row 51: weights and transmittance sum to one")
{
    auto const bound = [](double n) { return 8 * u * std::sqrt(n) + n * u / 2; };
    // On the mesh: 300 layers; alpha is 1 - T.
    std::vector<Gaussian> layers;
    support::Random random(51);
    for (std::uint32_t i = 0; i < 300; ++i) layers.push_back(layer(i + 1, random.uniform(0.004f, 0.02f), 1));
    auto const frame = stability::render(Kind::roomy, support::map_of(layers), small_camera(), {.grid = {1, 1}});
    double on_mesh = 0;
    for (std::uint32_t y = 0; y < 20; ++y)
        for (std::uint32_t x = 0; x < 20; ++x)
            on_mesh = std::max(on_mesh, std::fabs(double{frame.image.pixel(x, y)[0]} - double{frame.alpha.at(x, y)}));
    CHECK(on_mesh <= bound(300) + u);
    // The kernel alone: a million layers of 1e-5.
    std::uint32_t const n = support::fast() ? 100'000 : 1'000'000;
    KernelPixel ours(without_cuts());
    float t = 1, sum = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
        ours.blend(1e-5f);
        sum += 1e-5f * t;
        t *= 1 - 1e-5f;
    }
    double const naive = std::fabs(double{sum} + double{t} - 1), alone = std::fabs(ours.colour() + ours.transmittance() - 1);
    CHECK(alone <= bound(n));
    stability::report({51, "300 layers on the mesh; " + std::to_string(n) + " of 1e-5", number(naive) + " off",
                       number(on_mesh) + "; " + number(alone) + " off", "8u sqrt n + n u/2", false});
}

TEST_CASE("row 52: a thousand layers in one pass and in segments of 64 agree")
{
    support::Random random(52);
    Rules open = without_cuts();
    double naive = 0, ours = 0;
    for (int trial = 0; trial < 20; ++trial) {
        KernelPixel whole(open);
        float c = 0, t = 1;
        double merged = 0, through = 1, naive_merged = 0, naive_through = 1;
        for (int segment = 0; segment < 1000; segment += 64) {
            KernelPixel part(open);
            float part_c = 0, part_t = 1;
            for (int i = segment; i < std::min(segment + 64, 1000); ++i) {
                float const alpha = random.uniform(0.0f, 0.02f), grey = random.uniform(0, 1);
                whole.blend(alpha, grey);
                part.blend(alpha, grey);
                c += grey * alpha * t, t *= 1 - alpha;
                part_c += grey * alpha * part_t, part_t *= 1 - alpha;
            }
            merged += through * part.colour();
            through *= part.transmittance();
            naive_merged += naive_through * double{part_c};
            naive_through *= double{part_t};
        }
        ours = std::max(ours, std::fabs(merged - whole.colour()));
        naive = std::max(naive, std::fabs(naive_merged - double{c}));
    }
    CHECK(ours <= 1e-5);
    CHECK(naive <= 1e-5);
    stability::report({52, "1000 layers, one pass against segments of 64", number(naive), number(ours), "1e-5", false});
}

TEST_CASE("row 53: the exponential is good to two units in the last place")
{
    // Schraudolph 1999: the argument, scaled, is the bits of the result.
    auto const schraudolph = [](float x) {
        return __builtin_bit_cast(float, static_cast<std::int32_t>(12102203.0f * x + (127.0f * 8388608.0f - 486408.0f)));
    };
    double naive = 0, ours = 0, naive_levels = 0;
    std::uint32_t const n = support::fast() ? 100'000 : 1'000'000;
    for (std::uint32_t i = 0; i < n; ++i) {
        float const x = -12.0f * static_cast<float>(i) / static_cast<float>(n);
        double const truth = std::exp(double{x});
        naive = std::max(naive, std::fabs(double{schraudolph(x)} - truth) / truth);
        naive_levels = std::max(naive_levels, levels(std::fabs(double{schraudolph(x)} - truth)));
        ours = std::max(ours, std::fabs(double{exponential(x)} - truth) / truth);
    }
    CHECK(naive > 4 * u);
    CHECK(ours <= 4 * u);
    stability::report({53, "e^x for x in [-12, 0]", number(100 * naive) + " % = " + number(naive_levels) + " levels", number(ours / u) + " u",
                       "4u relative", true});
}

TEST_CASE("row 54: no power is above zero")
{
    // Needles in rounded a, b, c with an exact determinant: the conic is not negative definite any more.
    float const unguarded = std::exp(89.0f);
    CHECK(std::isinf(unguarded));
    support::Random random(54);
    auto const camera = support::lens(1280, 720);
    std::uint32_t samples = 0, naive_above = 0, ours_above = 0;
    float naive_most = 0;
    for (int i = 0; i < 20'000; ++i) {
        float const turn = random.uniform(0, 3.1415926f);
        Gaussian g = support::ball(1, 0, 0);
        float const z = random.uniform(0.5f, 5);
        g.mean_world[0] = random.uniform(-0.5f, 0.5f) * z;
        g.mean_world[1] = random.uniform(-0.3f, 0.3f) * z;
        g.mean_world[2] = z;
        g.rotation[0] = std::cos(turn / 2), g.rotation[3] = std::sin(turn / 2);
        g.log_scale[0] = random.uniform(1, 4);
        g.log_scale[1] = g.log_scale[2] = std::log(1e-3f);
        auto const s = splat_of(g, camera);
        if (!s.visible()) continue;
        // The covariance of the same needle, in pixels: the third axis hardly counts.
        float const long_px = camera.fx / z * std::exp(g.log_scale[0]), short_px = camera.fx / z * 1e-3f;
        float const c = std::cos(turn), v = std::sin(turn);
        float const a = long_px * long_px * c * c + short_px * short_px * v * v + 0.3f;
        float const d = long_px * long_px * v * v + short_px * short_px * c * c + 0.3f;
        float const b = (long_px * long_px - short_px * short_px) * c * v;
        double const det = double{a} * double{d} - double{b} * double{b};
        if (!(det > 0)) continue;
        float const xx = static_cast<float>(double{d} / det), xy = static_cast<float>(-double{b} / det), yy = static_cast<float>(double{a} / det);
        float const along = random.uniform(-600, 600), across = random.uniform(-0.05f, 0.05f);
        float const dx = along * c - across * v, dy = along * v + across * c;
        float const power = -0.5f * (xx * dx * dx + yy * dy * dy) - xy * dx * dy;
        ++samples;
        naive_above += power > 0 ? 1 : 0;
        naive_most = std::max(naive_most, power);
        float const alpha = alpha_at(s, s.mean_px[0] + dx, s.mean_px[1] + dy);
        ours_above += alpha <= s.opacity && s.along < 0 && s.across < 0 ? 0 : 1;
    }
    REQUIRE(samples > 5000);
    CHECK(naive_above > 0);
    CHECK(ours_above == 0);
    stability::report({54, std::to_string(samples) + " needles, exact det of rounded a, b, c",
                       "power > 0 in " + number(100.0 * naive_above / samples) + " %, at most " + number(double{naive_most}) + "; e^89 = inf",
                       std::to_string(ours_above) + " above the opacity", "power <= 0", true});
}

TEST_CASE("row 55: coincident layers of 0.5 cost eight blends a pixel, fourteen where it stops at 1e-4")
{
    std::uint32_t const n = support::fast() ? 2'000 : 20'000;
    auto const heap = layers_of(n, 0.5f);
    auto camera = support::flat_camera(16, 5);
    camera.cx = 8, camera.cy = 2.5f;
    auto const frame = stability::render(Kind::roomy, support::map_of(heap), camera, {.grid = {1, 1}});
    auto const& r = frame.report;
    CHECK(r.lost.empty());
    CHECK(r.pairs_contributing == 8u * 16 * 5); // 2^-8 is the first power below 5e-3
    CHECK(r.pairs <= 64u * 16 * 5);             // a block looks whether it is finished at every 64th
    Rules const rules = with_its_stop();
    auto const later = stability::render(Kind::roomy, support::map_of(heap), camera, {.grid = {1, 1}}, &rules).report;
    CHECK(later.pairs_contributing == 14u * 16 * 5);
    CHECK(later.pairs <= 64u * 16 * 5);
    std::uint64_t const naive = std::uint64_t{n} * 16 * 5;
    CHECK(naive > 64u * 16 * 5);
    stability::report(
        {55, std::to_string(n) + " coincident layers of 0.5 (a real map has 889,536)", std::to_string(n) + " blends a pixel without a stop",
         std::to_string(r.pairs_contributing / 80) + " blends a pixel, " + std::to_string(r.pairs / 80) + " evaluated", "at most 64", true});
}
