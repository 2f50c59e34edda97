// test: optimised, cost 10
// Pictures that enclose the exact formula, against the textbook's formula in binary128: covariance R S S^T R^T, J W Sigma W^T J^T, inverse. It
// shares no formula with the enclosure, and its functions have series of their own.
#include "../standard.hpp"
#include "stiff_scene.hpp"
#include <tilemesh/report/detail/ball.hpp>
#include <tilemesh/report/enclosure.hpp>
#include <tilemesh/report/reference_double.hpp>

namespace {

using namespace tilemesh;
using tests::Random;
using tests::StiffScene;
using Decided = report::Enclosure::Decided;
#if defined(__SIZEOF_FLOAT128__)
__extension__ typedef __float128 Quad;
#else
using Quad = long double; // 64-bit ARM has these 113 bits
#endif

Quad root(Quad x)
{
    if (!(x > 0)) return 0;
    Quad s = std::sqrt(static_cast<double>(x));
    for (int i = 0; i < 4; ++i) s = (s + x / s) / 2;
    return s;
}
Quad power_of_e(Quad x) // by halving: e^x = (e^(x / 2^k))^(2^k)
{
    int halvings = 0;
    for (; x > Quad(0.01) || x < Quad(-0.01); ++halvings) x /= 2;
    Quad sum = 1, term = 1;
    for (int i = 1; i < 20; ++i) term *= x / i, sum += term;
    for (; halvings > 0; --halvings) sum *= sum;
    return sum;
}
Quad less(Quad a, Quad b) { return a < b ? a : b; }
Quad more(Quad a, Quad b) { return a > b ? a : b; }
Quad rounded_up(Quad x) { return Quad(std::ceil(static_cast<double>(x))); } // far from a whole number in these scenes, or exactly one
Quad rounded_down(Quad x) { return Quad(std::floor(static_cast<double>(x))); }

/// The real spherical harmonics of degree 1 to 3 as 3D Gaussian Splatting lists them, with their constants as roots.
std::array<Quad, 15> harmonics(Quad x, Quad y, Quad z)
{
    Quad const pi = Quad(3.141592653589793116) + Quad(1.2246467991473532e-16) - Quad(2.9947698097183397e-33);
    auto const c = [&](int top, int bottom) { return root(Quad(top) / Quad(bottom) / pi); };
    Quad const xx = x * x, yy = y * y, zz = z * z;
    return {-c(3, 4) * y, c(3, 4) * z, -c(3, 4) * x,
            c(15, 4) * x * y, -c(15, 4) * y * z, c(5, 16) * (2 * zz - xx - yy), -c(15, 4) * x * z, c(15, 16) * (xx - yy),
            -c(35, 32) * y * (3 * xx - yy), c(105, 4) * x * y * z, -c(21, 32) * y * (4 * zz - xx - yy), c(7, 16) * z * (2 * zz - 3 * xx - 3 * yy),
            -c(21, 32) * x * (4 * zz - xx - yy), c(105, 16) * z * (xx - yy), -c(35, 32) * x * (xx - 3 * yy)};
}

/// A picture, and planes of depth and alpha.
struct Textbook {
    std::vector<Quad> rgb, depth, alpha;
};
template <class Record>
Textbook textbook(std::vector<Record> const& records, splat::Camera const& c, splat::Rules const& rules)
{
    struct Splat {
        Quad x, y, xx, xy, yy, z, opacity, colour[3], x0, x1, y0, y1;
        double xd, yd, xxd, xyd, yyd; // to tell what is far below any cut
        splat::GaussianId id;
    };
    std::vector<Splat> all;
    Quad const near_depth = rules.near_plane == splat::NearPlane::fixed ? 0.2f : c.near_depth;
    for (auto const& g : records) {
        Quad d[3], v[3] = {}, scale[3][3] = {}, q[4], length = 0;
        for (int k = 0; k < 3; ++k) d[k] = Quad(g.mean_world[k]) - Quad(c.position[k]);
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) v[i] += Quad(c.rotation[i][k]) * d[k];
        if (!(v[2] > near_depth)) continue;
        for (float const value : g.rotation) length += Quad(value) * Quad(value);
        for (int i = 0; i < 4; ++i) q[i] = Quad(g.rotation[i]) / root(length);
        Quad const w = q[0], x = q[1], y = q[2], z = q[3];
        Quad const r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                              {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                              {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k)
                for (int j = 0; j < 3; ++j) scale[i][k] += r[i][j] * power_of_e(2 * Quad(g.log_scale[j])) * r[k][j];
        Quad jx = v[0] / v[2], jy = v[1] / v[2];
        if (rules.jacobian_limit > 0) {
            auto const bound = [&](float given, Quad centre, Quad size, Quad focal) {
                if (given > 0) return Quad(given);
                bool const half = rules.slope_border == splat::SlopeBorder::of_half_width;
                return Quad(rules.jacobian_limit) * (half ? size / 2 : more(centre, size - centre)) / focal;
            };
            Quad const lx = bound(rules.slope_limit[0], c.cx, static_cast<double>(c.width), c.fx);
            Quad const ly = bound(rules.slope_limit[1], c.cy, static_cast<double>(c.height), c.fy);
            jx = more(-lx, less(lx, jx)), jy = more(-ly, less(ly, jy));
        }
        Quad const jacobian[2][3] = {{c.fx / v[2], 0, -c.fx * jx / v[2]}, {0, c.fy / v[2], -c.fy * jy / v[2]}};
        Quad m[2][3] = {}, cov[2][2] = {};
        for (int i = 0; i < 2; ++i)
            for (int k = 0; k < 3; ++k)
                for (int j = 0; j < 3; ++j) m[i][k] += jacobian[i][j] * Quad(c.rotation[j][k]);
        for (int i = 0; i < 2; ++i)
            for (int k = 0; k < 2; ++k)
                for (int j = 0; j < 3; ++j)
                    for (int n = 0; n < 3; ++n) cov[i][k] += m[i][j] * scale[j][n] * m[k][n];
        Quad const a = cov[0][0] + Quad(rules.dilation), b = cov[0][1], e = cov[1][1] + Quad(rules.dilation), det = a * e - b * b;
        if (!(det > 0)) continue;
        Splat s{};
        s.x = c.fx * v[0] / v[2] + c.cx, s.y = c.fy * v[1] / v[2] + c.cy, s.z = v[2], s.x1 = s.y1 = 1e6;
        s.xx = e / det, s.xy = -b / det, s.yy = a / det, s.opacity = g.opacity, s.id = g.id;
        if (rules.coverage == splat::Coverage::preserved)
            s.opacity *= root(more(Quad(25) / 1000000, (cov[0][0] * cov[1][1] - b * b) / det));
        for (int k = 0; k < 3; ++k) s.colour[k] = g.colour[k];
        if constexpr (Record::sh_degree > 0) {
            Quad const far = root(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
            auto const basis = harmonics(d[0] / far, d[1] / far, d[2] / far);
            for (std::uint32_t i = 0; i < splat::harmonics_per_channel(Record::sh_degree); ++i)
                for (std::uint32_t k = 0; k < 3; ++k) s.colour[k] += basis[i] * Quad(g.harmonics[3 * i + k]);
            for (Quad& v2 : s.colour) v2 = more(v2, 0);
        }
        Quad const middle = (a + e) / 2, apart = root((a - e) * (a - e) / 4 + b * b);
        if (rules.footprint == splat::Footprint::three_sigma_square) {
            Quad const half = rounded_up(3 * root(middle + apart));
            s.x0 = rounded_down(s.x - half), s.x1 = rounded_down(s.x + half), s.y0 = rounded_down(s.y - half), s.y1 = rounded_down(s.y + half);
        } else if (rules.footprint == splat::Footprint::three_sigma_tiles) {
            Quad const half = rounded_up(3 * root(middle + root(more(Quad(1) / 10, apart * apart))));
            auto const first = [&](Quad mean) { return 16 * rounded_down((mean - Quad(0.5) - half) / 16); };
            auto const last = [&](Quad mean) { return 16 * rounded_down((mean + Quad(14.5) + half) / 16) - 1; };
            s.x0 = first(s.x), s.x1 = last(s.x), s.y0 = first(s.y), s.y1 = last(s.y);
        }
        s.xd = static_cast<double>(s.x), s.yd = static_cast<double>(s.y), s.xxd = static_cast<double>(s.xx), s.xyd = static_cast<double>(s.xy),
        s.yyd = static_cast<double>(s.yy);
        all.push_back(s);
    }
    std::sort(all.begin(), all.end(), [](Splat const& a, Splat const& b) { return a.z != b.z ? a.z < b.z : a.id < b.id; });
    Textbook out;
    std::size_t const pixels = std::size_t{c.width} * c.height;
    out.rgb.resize(3 * pixels), out.depth.resize(pixels), out.alpha.resize(pixels);
    double const least_power = std::log(double{rules.alpha_min}) - 0.5;
    for (std::uint32_t y = 0; y < c.height; ++y)
        for (std::uint32_t x = 0; x < c.width; ++x) {
            Quad t = 1, depth = 0, weight = 0;
            std::size_t const at = std::size_t{y} * c.width + x;
            Quad* const p = &out.rgb[3 * at];
            for (auto const& e : all) {
                if (x < e.x0 || x > e.x1 || y < e.y0 || y > e.y1) continue;
                double const far_x = x + 0.5 - e.xd, far_y = y + 0.5 - e.yd;
                double const size = e.xxd * far_x * far_x + e.yyd * far_y * far_y, cross = e.xyd * far_x * far_y;
                if (-size / 2 - cross + 1e-9 * (size + std::fabs(cross)) < least_power) continue;
                Quad const dx = x + Quad(0.5) - e.x, dy = y + Quad(0.5) - e.y, power = -(e.xx * dx * dx + e.yy * dy * dy) / 2 - e.xy * dx * dy;
                Quad alpha = e.opacity * power_of_e(power);
                if (alpha < Quad(rules.alpha_min)) continue;
                alpha = less(alpha, rules.alpha_max);
                Quad const behind = t * (1 - alpha);
                bool const crosses = behind < Quad(rules.transmittance_min);
                if (crosses && rules.stop == splat::Stop::before_crossing) break;
                for (int k = 0; k < 3; ++k) p[k] += t * alpha * e.colour[k];
                depth += t * alpha * e.z, weight += t * alpha;
                t = behind;
                if (crosses) break;
            }
            for (int k = 0; k < 3; ++k) p[k] += t * Quad(rules.background[k]);
            out.alpha[at] = 1 - t, out.depth[at] = weight > 0 ? depth / weight : Quad(0);
        }
    return out;
}

struct Sum {
    std::uint64_t values = 0, escapes = 0, undecided = 0, in_wide = 0;
    double widest = 0, widest_plane = 0, least_ratio = 1e9;

    /// Counts escapes; calls f(i, distance) for each value.
    template <class F>
    void add(std::vector<Quad> const& truth, std::vector<double> const& middle, std::vector<double> const& radius, F const& f)
    {
        REQUIRE(middle.size() == truth.size());
        for (std::size_t i = 0; i < truth.size(); ++i) {
            auto const away = std::fabs(static_cast<double>(truth[i] - Quad(middle[i])));
            escapes += away <= radius[i] ? 0 : 1; // NaN is one
            f(i, away);
        }
        values += truth.size();
    }
};
template <class Record>
void compare(Sum& sum, std::uint32_t n)
{
    StiffScene<Record> const s(n);
    auto const truth = textbook(s.records, s.c, s.rules);
    auto const e = report::enclose(s.records, s.c, s.rules, {.threads = 1 + n % 2, .planes = true});
    REQUIRE(e.not_enclosed.empty());
    sum.add(truth.rgb, e.middle, e.radius, [&](std::size_t i, double away) {
        if (e.decided[i / 3] == Decided::in_double && away > 0) sum.least_ratio = std::min(sum.least_ratio, e.radius[i] / away);
    });
    for (auto const& [of_truth, plane] : {std::pair(&truth.depth, &e.depth), std::pair(&truth.alpha, &e.alpha)}) {
        sum.add(*of_truth, plane->middle, plane->radius, [](std::size_t, double) {});
        sum.widest_plane = std::max(sum.widest_plane, *std::max_element(plane->radius.begin(), plane->radius.end()));
    }
    if (n % 16 == 3) { // without cut-offs
        auto rules = s.rules;
        rules.alpha_min = 1e-20f, rules.alpha_max = 1, rules.transmittance_min = 0, rules.stop = splat::Stop::after_crossing;
        rules.footprint = splat::Footprint::opacity_box;
        auto const whole = report::enclose(s.records, s.c, s.rules, {.cuts = report::Cuts::none});
        sum.add(textbook(s.records, s.c, rules).rgb, whole.middle, whole.radius, [&](std::size_t, double) {});
        sum.widest = std::max(sum.widest, 255 * whole.widest());
    }
    sum.undecided += e.count(Decided::undecided), sum.in_wide += e.count(Decided::in_wide);
    sum.widest = std::max(sum.widest, 255 * e.widest());
}

/// Scenes `first` to `last` - 1.
Sum compared(std::uint32_t first, std::uint32_t last)
{
    Sum sum;
    for (std::uint32_t n = first; n < last; ++n) {
        if (n % 4 == 0) compare<splat::Gaussian>(sum, n);
        else if (n % 4 == 1) compare<splat::ShadedGaussian<1>>(sum, n);
        else if (n % 4 == 2) compare<splat::ShadedGaussian<2>>(sum, n);
        else compare<splat::ShadedGaussian<3>>(sum, n);
    }
    CHECK(sum.values >= std::uint64_t{last - first} * 5 * 64 * 48);
    CHECK(sum.escapes == 0);
    CHECK(sum.widest < 1e-6);
    CHECK(sum.widest_plane < 1e-9);
    MESSAGE(sum.values << " values, widest " << sum.widest << " levels, in 100 bits " << sum.in_wide << ", least bound / error " << sum.least_ratio);
    return sum;
}

TEST_CASE("a million values of random scenes are enclosed: all rules, all degrees, needles, walls, opaque and huge splats; depth and alpha")
{
    auto const sum = compared(0, tests::fast() ? 12 : 66);
    CHECK(sum.undecided == 0);
    CHECK(sum.least_ratio < 50); // a bound a thousand times as large would prove little
}
TEST_CASE("slow: a thousand million values are enclosed")
{
    CHECK(compared(66, 66 + 63'000).values > 950'000'000);
}

TEST_CASE("numbers of two doubles are within their bounds, in any order of sizes and signs")
{
    using report::detail::Wide;
    Random random(5);
    auto const any = [&](int spread) {
        auto const x = std::ldexp(static_cast<double>(random.uniform(-1, 1)), static_cast<int>(random.uniform(-1, 1) * static_cast<float>(spread)));
        double const y = x * static_cast<double>(random.uniform(-1, 1)) * 0x1p-53;
        return report::detail::two_sum(x + x * static_cast<double>(random.uniform(-1, 1)) * 0x1p-25, y);
    };
    auto const quad = [](Wide const& w) { return Quad(w.hi) + Quad(w.lo); };
    double worst[3] = {};
    for (int i = 0; i < (tests::fast() ? 100'000 : 1'000'000); ++i) {
        int const spread = i % 3 == 0 ? 1 : 60;
        Wide const a = any(spread);
        Wide const b = i % 7 == 0 ? Wide(-a.hi, a.lo / 3) : any(spread); // a sum that cancels
        if (a.hi == 0 || b.hi == 0) continue;
        Quad const exact[3] = {(Quad(a.hi) + Quad(b.hi)) + (Quad(a.lo) + Quad(b.lo)), quad(a) * quad(b), quad(a) / quad(b)};
        Wide const ours[3] = {a + b, a * b, a / b};
        for (int k = 0; k < 3; ++k) {
            Quad const off = quad(ours[k]) - exact[k];
            double const size = std::fabs(static_cast<double>(exact[k]));
            if (size > 0) worst[k] = std::max(worst[k], std::fabs(static_cast<double>(off)) / size * 0x1p106);
            CHECK(std::fabs(ours[k].lo) <= 0x1p-53 * std::fabs(ours[k].hi) * 1.0001);
        }
    }
    MESSAGE("units of 2^-106: sum " << worst[0] << ", product " << worst[1] << ", quotient " << worst[2]);
    CHECK(worst[0] <= 3.01 + 0.1); // and the reference's own rounding
    CHECK(worst[1] <= 9);
    CHECK(worst[2] <= 18);
    CHECK(worst[2] > 1);
}

/// One pixel on the axis, looking along z.
splat::Camera one_pixel()
{
    splat::Camera c{};
    for (int i = 0; i < 3; ++i) c.rotation[i][i] = 1;
    c.fx = c.fy = 8, c.cx = c.cy = 0.5f, c.near_depth = 0.25f, c.width = c.height = 1;
    return c;
}
splat::Gaussian ball(float z, float opacity, float grey, std::uint32_t id)
{
    splat::Gaussian g{};
    g.mean_world[2] = z, g.opacity = opacity, g.rotation[0] = 1, g.id = splat::GaussianId{id};
    for (int k = 0; k < 3; ++k) g.colour[k] = grey, g.log_scale[k] = -1;
    return g;
}

TEST_CASE("a pixel that no number of digits decides encloses both outcomes")
{
    splat::Rules rules;
    rules.alpha_min = 0.25f;
    std::vector<splat::Gaussian> const faint{ball(2, 0.25f, 1, 1)}; // alpha is alpha_min in the middle: exactly, and balls are wider than that
    auto const e = report::enclose(faint, one_pixel(), rules);
    CHECK(e.count(Decided::undecided) == 1);
    CHECK(e.middle[0] - e.radius[0] <= 0);
    CHECK(e.middle[0] + e.radius[0] >= 0.25);
    CHECK(e.middle[0] + e.radius[0] < 0.2501);
    // A stop at exactly the limit: the second one counts or does not.
    rules.alpha_min = 1 / 255.0f, rules.transmittance_min = 0.5f;
    for (auto const stop : {splat::Stop::after_crossing, splat::Stop::before_crossing}) {
        rules.stop = stop;
        std::vector<splat::Gaussian> const two{ball(2, 0.5f, 1, 1), ball(3, 0.5f, 0.5f, 2)};
        auto const both = report::enclose(two, one_pixel(), rules);
        CHECK(both.count(Decided::undecided) == 1);
        bool const after = stop == splat::Stop::after_crossing;
        double const least = after ? 0.5 : 0.0, most = after ? 0.625 : 0.5;
        CHECK(both.middle[0] - both.radius[0] <= least);
        CHECK(both.middle[0] + both.radius[0] >= most);
        CHECK(both.radius[0] < 0.5 * (most - least) + 0.0001 + (after ? 0.0 : 0.07));
    }
}

TEST_CASE("order: depths that differ in the last bit, ties by id, whatever the order of the records")
{
    splat::Rules const rules;
    auto const picture = [&](std::vector<splat::Gaussian> const& records) {
        auto const e = report::enclose(records, one_pixel(), rules);
        CHECK(e.count(Decided::in_double) == 1);
        CHECK(e.radius[0] < 1e-12);
        return e.middle[0];
    };
    auto const near = ball(2, 0.5f, 1, 9), tie = ball(2, 0.5f, 0, 3), behind = ball(std::nextafter(2.0f, 3.0f), 0.5f, 0, 1);
    CHECK(picture({near, behind}) == doctest::Approx(0.5));
    CHECK(picture({behind, near}) == doctest::Approx(0.5));
    CHECK(picture({near, tie}) == doctest::Approx(0.25));
    CHECK(picture({tie, near}) == doctest::Approx(0.25));
}

TEST_CASE("what is not drawn, what is not enclosed, and what is refused")
{
    splat::Rules rules;
    auto const c = one_pixel();
    auto const nothing = report::enclose(std::vector<splat::Gaussian>{}, c, rules);
    CHECK(nothing.middle == std::vector<double>(3));
    CHECK(nothing.splats == 0);
    auto bad = ball(2, 0.5f, 1, 1), bright = bad, at_plane = bad, huge = bad, flat = bad;
    bad.mean_world[0] = std::numeric_limits<float>::quiet_NaN();
    bright.colour[1] = 2e6f;
    at_plane.mean_world[2] = 0.25f;
    huge.log_scale[1] = 101, huge.id = splat::GaussianId{3};
    auto const e = report::enclose(std::vector{bad, bright, at_plane, huge}, c, rules);
    CHECK(e.splats == 0);
    CHECK(e.not_enclosed == std::vector<std::uint64_t>{3});
    huge.log_scale[1] = -std::numeric_limits<float>::infinity(); // a size of 0 is drawn
    CHECK(report::enclose(std::vector{huge}, c, rules).not_enclosed == std::vector<std::uint64_t>{3});
    // A footprint of 3 sigma that no double holds: without a limit the splat is enclosed.
    auto wide = c;
    wide.fx = wide.fy = 1e38f;
    auto far_out = ball(0.3f, 1, 1, 4);
    far_out.log_scale[0] = 95, far_out.log_scale[1] = far_out.log_scale[2] = -90;
    for (auto const footprint : {splat::Footprint::three_sigma_square, splat::Footprint::three_sigma_tiles}) {
        rules.footprint = footprint;
        CHECK(report::enclose(std::vector{far_out}, wide, rules).not_enclosed == std::vector<std::uint64_t>{4});
    }
    rules.footprint = splat::Footprint::opacity_box;
    // Without a limit nothing stops, however dark it gets.
    rules.transmittance_min = 0;
    std::vector<splat::Gaussian> many;
    for (std::uint32_t i = 0; i < 100; ++i) many.push_back(ball(1 + 0.01f * static_cast<float>(i), 0.9f, 0.5f, i + 1));
    CHECK(report::enclose(many, c, rules).count(Decided::in_double) == 1);
    rules.transmittance_min = 5e-3f;
    bright.colour[1] = -2e6f;
    CHECK(report::enclose(std::vector{bright}, c, rules).splats == 0);
    // A term that may be there may also be the last one: a dot that no ball decides takes the pixel below the limit.
    flat.opacity = 0.9f;
    for (float& s : flat.log_scale) s = -100;
    auto behind = flat;
    behind.mean_world[2] = 3, behind.id = splat::GaussianId{2}, behind.colour[0] = 0, behind.opacity = 0.8f;
    for (float& s : behind.log_scale) s = 1;
    splat::Rules dots;
    dots.dilation = 0, dots.transmittance_min = 0.2f;
    auto const both = report::enclose(std::vector{flat, behind}, c, dots);
    CHECK(both.middle[0] - both.radius[0] <= 0.0);
    CHECK(both.middle[0] + both.radius[0] >= 0.9);
    rules.dilation = 0;
    for (float& s : flat.log_scale) s = -100; // a dot without dilation: all of the opacity on its mean, 0 beside it
    auto const dot = report::enclose(std::vector{flat}, c, rules); // no ball tells where its mean is to 1e-43 of a pixel
    CHECK(dot.count(Decided::undecided) == 1);
    CHECK(dot.middle[0] - dot.radius[0] <= 0);
    CHECK(dot.middle[0] + dot.radius[0] >= 0.5);
    rules.alpha_min = 0;
    CHECK(tests::error_of([&] { report::enclose(std::vector{flat}, c, rules); }).starts_with("an enclosure for an alpha_min of 0 ("));
    CHECK(tests::error_of([&] { report::certify(nothing, report::Image(2, 1)); }) ==
          "a picture of 2 x 1 pixels (the enclosure has 1 x 1); take the picture of this camera");
}

TEST_CASE("a certificate is never below the distance; the worst pixels are named")
{
    StiffScene<splat::Gaussian> const s(4);
    auto const e = report::enclose(s.records, s.c, s.rules, {.threads = 2});
    auto picture = report::render_double(s.records, s.c, s.rules, report::Cuts::same);
    auto c = report::certify(e, picture);
    CHECK(c.largest < 1e-4);
    CHECK(c.beyond == 0);
    CHECK(c.worst.empty());
    picture.pixel(7, 5)[1] += 0.5f, picture.pixel(9, 40)[2] -= 0.25f;
    c = report::certify(e, picture);
    CHECK(c.largest >= 127.49);
    CHECK(c.largest < 127.51);
    REQUIRE(c.worst.size() == 2);
    CHECK(c.worst[0].x == 7);
    CHECK(c.worst[0].y == 5);
    CHECK(c.worst[1].x == 9);
    CHECK(c.worst[1].y == 40);
    CHECK(tests::has(report::text_of(c), "every channel within 129/255 of the exact formula ("));
    // In 8 bits, half a level is its own; what is brighter than 1 is clamped.
    auto bytes = report::render_double(s.records, s.c, s.rules, report::Cuts::same);
    for (float& v : bytes.rgb) v = std::round(255 * std::clamp(v, 0.0f, 1.0f)) / 255;
    CHECK(report::certify(e, bytes, {true, 0.5 / 255}).largest < 1e-4);
    CHECK(report::certify(e, bytes, {true, 0}).largest > 0.4);
    CHECK(report::certify(e, bytes, {false, 0.5 / 255}).largest > 1);
    picture.pixel(0, 0)[0] = std::numeric_limits<float>::quiet_NaN();
    CHECK(report::certify(e, picture).largest == std::numeric_limits<double>::infinity());
}

} // namespace
