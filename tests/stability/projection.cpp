#include "catalogue.hpp"
#include "reference.hpp"
#include <tilemesh/scene/detail/ply_gaussian.hpp>
#include <tilemesh/scene/ply.hpp>
#include <tilemesh/splat/depth_sort.hpp>
#include <tilemesh/splat/harmonics.hpp>

// Rows 1 to 38 of the catalogue: projection and covariance.
using namespace stability;
using tilemesh::splat::Footprint;
using tilemesh::splat::Splat;

namespace {
constexpr float point = -87; // the logarithm of a size that is practically 0

std::string percent(double part)
{
    return number(100 * part) + " %";
}
std::string tenths(double v)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.1f", v);
    return text;
}

Gaussian gaussian(float x, float y, float z, float s0, float s1, float s2)
{
    return {{x, y, z}, {0.2f, 0.5f, 0.8f}, 1, {1, 0, 0, 0}, {s0, s1, s2}, tilemesh::splat::GaussianId{1}};
}

/// The library and a naive variant on the pixels of `count` random Gaussians.
struct Compared {
    Spread ours, naive;
    double ours_dropped = 0, naive_dropped = 0; ///< share of Gaussians that are not drawn although a pixel sees 1/255 of them
    double naive_positive = 0;                  ///< share of exponents above 0
    double ours_positive = 0;
};
template <class Make>
Compared compare(std::uint32_t count, Make const& make, naive::Variant const& variant = {}, bool exact_determinant = false)
{
    support::Random random(7);
    Compared result;
    std::uint32_t pixels = 0;
    for (std::uint32_t n = 0; n < count; ++n) {
        Camera const camera = plain_camera();
        Gaussian g{};
        random_rotation(g, random);
        make(g, random);
        auto const s = make_sample(g, camera, uncut(), random);
        auto const ours = our_splat(g, camera, uncut());
        auto theirs = naive::project(g, camera, variant);
        if (exact_determinant) {
            auto const t = truth<double>(g, camera, uncut());
            theirs.determinant = float(t.determinant);
            theirs.conic = naive::conic(theirs.screen, theirs.determinant);
            theirs.x = camera.fx * theirs.view.x / theirs.view.z + camera.cx;
            theirs.y = camera.fy * theirs.view.y / theirs.view.z + camera.cy;
            theirs.opacity = g.opacity;
            theirs.drawn = true;
        }
        bool seen = false;
        for (std::size_t i = 0; i < Sample::pixels; ++i) {
            seen = seen || s.alpha[i] > 1.0 / 255;
            result.ours.add(s, i, our_alpha(ours, camera, s.x[i], s.y[i]));
            result.naive.add(s, i, naive::alpha_at(theirs, s.x[i], s.y[i]));
            float const dx = float(s.x[i]) + 0.5f - theirs.x, dy = float(s.y[i]) + 0.5f - theirs.y;
            result.naive_positive += theirs.drawn && naive::power(theirs.conic, dx, dy) > 0 ? 1 : 0;
            result.ours_positive += ours.along > 0 || ours.across > 0 ? 1 : 0;
            ++pixels;
        }
        result.ours_dropped += seen && !ours.visible() ? 1 : 0;
        result.naive_dropped += seen && !(theirs.drawn && theirs.determinant > 0) ? 1 : 0;
    }
    result.ours_dropped /= count;
    result.naive_dropped /= count;
    result.naive_positive /= pixels;
    return result;
}
void place(Gaussian& g, support::Random& random, float z_low, float z_high)
{
    float const z = random.uniform(z_low, z_high);
    g.mean_world[0] = random.uniform(-0.66f, 0.66f) * z; // the frame is 0.64 by 0.36
    g.mean_world[1] = random.uniform(-0.38f, 0.38f) * z;
    g.mean_world[2] = z;
    g.opacity = random.uniform(0.1f, 1);
}
std::string found(Spread const& e)
{
    return "alpha off by " + number(e.max_error()) + ", rho " + number(e.max_rho());
}
void report_rho(int row, char const* input, Compared const& c)
{
    CHECK(c.ours.max_rho() <= 4);
    CHECK(c.ours_dropped == 0);
    CHECK(c.naive.max_rho() > 4);
    std::string const dropped = c.naive_dropped > 0 ? ", " + percent(c.naive_dropped) + " dropped" : "";
    report({row, input, found(c.naive) + dropped, found(c.ours) + ", none dropped", "rho <= 4", true});
}

void needle(Gaussian& g, support::Random& random)
{
    place(g, random, 0.5f, 5);
    g.log_scale[0] = random.uniform(-2, 1);
    g.log_scale[1] = g.log_scale[2] = std::log(1e-4f);
}
void long_needle(Gaussian& g, support::Random& random)
{
    place(g, random, 0.5f, 5);
    g.log_scale[0] = random.uniform(1, 4);
    g.log_scale[1] = g.log_scale[2] = std::log(1e-3f);
}

/// The log scale of a standard deviation.
float log_of(double sigma)
{
    return float(std::log(sigma));
}
std::array<Rules, 2> both_footprints()
{
    std::array<Rules, 2> both;
    both[1].footprint = Footprint::three_sigma_square;
    return both;
}
/// The covariance on the screen that a splat stands for.
struct Screen {
    double a, b, c, determinant;
    explicit Screen(Splat const& s)
        : a(-0.5 / double(s.along)), b(double(s.slope) * a), c((-0.5 * a / double(s.across) + b * b) / a), determinant(-0.5 * a / double(s.across))
    {}
};
void turn_about_z(Gaussian& g, float half_angle)
{
    g.rotation[0] = std::cos(half_angle);
    g.rotation[3] = std::sin(half_angle);
}
naive::Splat without_near_plane(Gaussian const& g, Camera const& c)
{
    naive::Variant variant;
    variant.near_plane = false;
    return naive::project(g, c, variant);
}
/// Is alpha the opacity in every part of the frame?
bool covers_frame(Splat const& s, Camera const& c, float opacity, double tolerance)
{
    auto const r = s.rect();
    if (!s.visible() || r.x0 != 0 || r.y0 != 0 || r.x1 != c.width || r.y1 != c.height) return false;
    for (std::uint32_t y = 0; y < c.height; y += 7)
        for (std::uint32_t x = 0; x < c.width; x += 13)
            if (!(std::fabs(double(our_alpha(s, c, x, y)) / double(opacity) - 1) <= tolerance)) return false;
    return true;
}
/// Is alpha a number from 0 to 1 all over the frame?
bool finite_alpha(Splat const& s, Camera const& c)
{
    for (std::uint32_t y = 0; y < c.height; y += 7)
        for (std::uint32_t x = 0; x < c.width; x += 13)
            if (float const alpha = our_alpha(s, c, x, y); !(alpha >= 0 && alpha <= 1)) return false;
    return true;
}

/// The largest entry of R R^T - I, for the rotation that `project` makes from a quaternion. It is found from the splats of three balls
/// without two of their axes, in front of three cameras. Infinite if one of them is not drawn.
double not_orthogonal(float const (&q)[4])
{
    Rules rules = uncut();
    rules.dilation = 1e-12f;
    double worst = 0;
    for (std::size_t first = 0; first < 3; ++first) {
        Camera c = plain_camera();
        std::memset(c.rotation, 0, sizeof c.rotation);
        for (std::size_t i = 0; i < 3; ++i) c.rotation[i][(first + i) % 3] = 1;
        c.fx = c.fy = 1;
        double diagonal = -1, beside = 0;
        for (int axis = 0; axis < 3; ++axis) {
            Gaussian g = gaussian(0, 0, 0, point, point, point);
            g.mean_world[(first + 2) % 3] = 1;
            std::copy(q, q + 4, g.rotation);
            g.log_scale[axis] = 0;
            auto const s = our_splat(g, c, rules);
            if (!s.visible()) return std::numeric_limits<double>::infinity();
            diagonal += Screen(s).a - double(rules.dilation);
            beside += Screen(s).b;
        }
        worst = std::max({worst, std::fabs(diagonal), std::fabs(beside)});
    }
    return worst;
}
double not_orthogonal(naive::Matrix3 const& r)
{
    double worst = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            double sum = i == j ? -1 : 0;
            for (int k = 0; k < 3; ++k) sum += double(r.m[i][k]) * double(r.m[j][k]);
            worst = std::isfinite(sum) ? std::max(worst, std::fabs(sum)) : std::numeric_limits<double>::infinity();
        }
    return worst;
}
/// The largest error of alpha against the truth, over a box that is three times as long as wide and turned by q.
double turned_box_error(float const (&q)[4])
{
    Gaussian g = gaussian(0.1f, 0.05f, 2, log_of(0.03), log_of(0.01), log_of(0.02));
    std::copy(q, q + 4, g.rotation);
    Camera const c = plain_camera();
    auto const t = truth<double>(g, c, uncut());
    auto const s = our_splat(g, c, uncut());
    double worst = 0;
    for (std::uint32_t y = 340; y < 430; y += 3)
        for (std::uint32_t x = 640; x < 740; x += 3) worst = std::max(worst, std::fabs(double(our_alpha(s, c, x, y)) - true_alpha(t, c, x, y)));
    return worst;
}

/// Calls the loader for one row: position, f_dc, opacity, scales, rotation.
char const* load_row(std::initializer_list<double> fields, Gaussian& g)
{
    tilemesh::scene::detail::GaussianRow row{};
    std::copy(fields.begin(), fields.end(), row.begin());
    return tilemesh::scene::detail::make_gaussian(row, g);
}
constexpr double infinity = std::numeric_limits<double>::infinity();
} // namespace

TEST_CASE("row 1: needles")
{
    report_rho(1, "needles 0.14 to 2.7 by 1e-4, z 0.5 to 5", compare(5000, needle));
}

TEST_CASE("row 2: needles longer than their distance")
{
    auto const c = compare(5000, long_needle);
    CHECK(c.naive_dropped > 0.05);
    report_rho(2, "needles 2.7 to 55 by 1e-3", c);
}

TEST_CASE("row 3: an accurate determinant of rounded entries saves no needle")
{
    naive::Variant variant;
    variant.determinant = naive::determinant_kahan;
    auto const c = compare(5000, long_needle, variant);
    CHECK(c.naive_dropped > 0.01);
    report_rho(3, "as row 2; naive with Kahan's determinant", c);
}

TEST_CASE("row 4: nor does an exact determinant under a conic")
{
    auto const c = compare(5000, long_needle, {}, true);
    CHECK(c.ours_positive == 0);
    CHECK(c.ours.max_rho() <= 4);
    CHECK(c.naive_positive > 0);
    CHECK(c.naive.max_rho() > 4);
    report({4, "as row 2; naive with the exact determinant", found(c.naive) + ", exponent above 0 in " + percent(c.naive_positive),
            found(c.ours) + ", never above 0", "exponent <= 0", true});
}

TEST_CASE("row 5: a conic with correctly rounded entries against the LDL^T form of the same")
{
    support::Random random(5);
    double worst_conic = 0, worst_ours = 0;
    for (int n = 0; n < 3000; ++n) {
        double const angle = double(random.uniform(0, 3.14159f)), p = std::cos(angle), q = std::sin(angle);
        double const large = 1e6, small = double(0.3f);
        Truth<double> t{};
        t.a = large * p * p + small * q * q;
        t.b = (large - small) * p * q;
        t.c = large * q * q + small * p * p;
        t.determinant = large * small;
        Splat s{};
        s.along = float(-0.5 / t.a);
        s.slope = float(t.b / t.a);
        s.across = float(-0.5 * t.a / t.determinant);
        s.opacity = 1;
        naive::Conic const k{float(t.c / t.determinant), float(-t.b / t.determinant), float(t.a / t.determinant)};
        for (int i = 0; i < 10; ++i) {
            double const on = double(random.uniform(-640, 640)), off = double(random.uniform(-1.5f, 1.5f));
            float const dx = float(on * p - off * q), dy = float(on * q + off * p);
            double const right = std::exp(t.power_at(double(dx), double(dy)));
            worst_conic = std::max(worst_conic, std::fabs(double(std::exp(std::min(0.0f, naive::power(k, dx, dy)))) - right));
            worst_ours = std::max(worst_ours, std::fabs(double(tilemesh::splat::alpha_at(s, dx, dy)) - right));
        }
    }
    CHECK(worst_ours <= 1e-4);
    CHECK(worst_conic > 1e-4);
    report(
        {5, "1000 x 0.55 px, entries correctly rounded", "alpha off by " + number(worst_conic), "alpha off by " + number(worst_ours), "1e-4", true});
}

TEST_CASE("row 6: discs")
{
    report_rho(6, "discs 0.05 to 1 by 1e-6", compare(5000, [](Gaussian& g, support::Random& random) {
                   place(g, random, 0.5f, 5);
                   g.log_scale[0] = random.uniform(-3, 0);
                   g.log_scale[1] = random.uniform(-3, 0);
                   g.log_scale[2] = std::log(1e-6f);
               }));
}

TEST_CASE("row 7: close-ups")
{
    report_rho(7, "z 0.21 to 1, log scale -3 +- 1.5", compare(5000, [](Gaussian& g, support::Random& random) {
                   place(g, random, 0.21f, 1);
                   for (float& s : g.log_scale) { // a sum of 12 is normal enough
                       s = -6;
                       for (int i = 0; i < 12; ++i) s += random.uniform(0, 1);
                       s = -3 + 1.5f * s;
                   }
               }));
}

TEST_CASE("row 8: an ordinary scene")
{
    auto const c = compare(5000, [](Gaussian& g, support::Random& random) {
        place(g, random, 2, 10);
        for (float& s : g.log_scale) s = random.uniform(-4, 0.5f);
    });
    CHECK(c.ours.max_error() <= 1e-5);
    CHECK(c.naive.max_error() > 1e-5);
    report({8, "z 2 to 10, sigma 0.02 to 1.6", "alpha off by " + number(c.naive.max_error()), "alpha off by " + number(c.ours.max_error()), "1e-5",
            true});
}

TEST_CASE("row 9 does not apply")
{
    does_not_apply(9, "the model has no anti-aliasing factor: its dilation does not dim a splat");
}

TEST_CASE("row 10: a point has the radius of its dilation")
{
    Rules rules;
    rules.footprint = Footprint::three_sigma_square;
    Camera c = plain_camera();
    c.cx = 640.5f;
    c.cy = 360.5f;
    Gaussian const g = gaussian(0, 0, 1, point, point, point);
    auto const r = our_splat(g, c, rules).rect();
    auto const n = naive::project(g, c);
    float const radius = naive::radius(n.screen, n.determinant);
    double const ratio = double(naive::largest_eigenvalue(n.screen, n.determinant)) / double(0.3f);
    CHECK(r.x0 == 640 - 2); // 3 sqrt(0.3) = 1.64
    CHECK(r.x1 == 640 + 3);
    CHECK(r.y0 == 360 - 2);
    CHECK(r.y1 == 360 + 3);
    CHECK(radius == 3);
    CHECK(ratio > 2);
    report({10, "point: covariance 0.3 I", "lambda x " + number(ratio) + ", radius 3", "radius 2", "exact", true});
}

TEST_CASE("row 11: an isotropic splat of 100 pixels has a radius of 300")
{
    Rules rules;
    rules.footprint = Footprint::three_sigma_square;
    rules.dilation = 0;
    Camera c = plain_camera();
    c.fx = c.fy = 100;
    c.cx = 640.5f;
    c.cy = 360.5f;
    Gaussian const g = gaussian(0, 0, 1, 0, 0, 0);
    auto const r = our_splat(g, c, rules).rect();
    naive::Variant variant;
    variant.dilation = 0;
    auto const n = naive::project(g, c, variant);
    CHECK(r.x0 == 640 - 300);
    CHECK(r.x1 == 640 + 301);
    CHECK(naive::radius(n.screen, n.determinant) == 301);
    report({11, "isotropic, 100 px", "radius 301", "radius 300", "exact", true});
}

TEST_CASE("row 12: the short axis of a splat of 5000 by 0.55 pixels")
{
    support::Random random(12);
    double worst_ours = 0, worst_naive = 0;
    int negative = 0;
    constexpr int samples = 5000;
    Camera c = plain_camera();
    c.fx = c.fy = 5000;
    for (int n = 0; n < samples; ++n) {
        Gaussian g = gaussian(0, 0, 1, 0, point, point);
        turn_about_z(g, random.uniform(0, 3.14159f));
        auto const t = truth<double>(g, c, Rules{});
        auto const smallest = [](double a, double b, double cc, double determinant) {
            return determinant / ((a + cc) / 2 + std::hypot((a - cc) / 2, b));
        };
        double const right = smallest(t.a, t.b, t.c, t.determinant);
        auto const s = our_splat(g, c, Rules{});
        REQUIRE(s.visible());
        Screen const screen(s);
        worst_ours = std::max(worst_ours, std::fabs(smallest(screen.a, screen.b, screen.c, screen.determinant) / right - 1));
        auto const theirs = naive::covariance_screen(naive::covariance_world(g), c, {0, 0, 1}, 1.3f, 0.3f);
        double const lambda = double(naive::smallest_eigenvalue(theirs, naive::determinant(theirs)));
        negative += lambda < 0 ? 1 : 0;
        worst_naive = std::max(worst_naive, std::fabs(lambda / right - 1));
    }
    CHECK(worst_ours <= 8 * u);
    CHECK(worst_naive > 1);
    report({12, "5000 x 0.55 px, any direction", "lambda_min off by x" + number(worst_naive) + ", negative in " + percent(double(negative) / samples),
            "off by " + number(worst_ours), "8u", true});
}

TEST_CASE("row 13: three sigma that are a whole number of pixels")
{
    support::Random random(13);
    int naive_up = 0, ours_up = 0, samples = 0, inside = 0, outside = 0;
    for (float sigma : {1.0f, 10.0f, 300.0f})
        for (int n = 0; n < 1000; ++n, ++samples) {
            Camera c = plain_camera();
            c.width = c.height = 4096;
            c.cx = c.cy = 2048.5f;
            c.fx = c.fy = sigma;
            Gaussian g = gaussian(0, 0, 1, 0, -1, -1);
            turn_about_z(g, random.uniform(0, 3.14159f));
            Rules rules;
            rules.dilation = 0;
            rules.footprint = Footprint::three_sigma_square;
            auto const square = our_splat(g, c, rules).rect();
            int const radius = (int(square.x1) - int(square.x0) - 1) / 2, right = 3 * int(sigma);
            CHECK(radius >= right);
            CHECK(radius <= right + 1);
            ours_up += radius > right ? 1 : 0;
            naive::Variant variant;
            variant.dilation = 0;
            auto const theirs = naive::project(g, c, variant);
            naive_up += int(naive::radius(theirs.screen, theirs.determinant)) != right ? 1 : 0;

            // The default box: no pixel outside it sees alpha_min.
            rules.footprint = Footprint::opacity_box;
            auto const s = our_splat(g, c, rules);
            auto const t = truth<double>(g, c, rules);
            auto const r = s.rect();
            auto const test = [&](std::uint32_t x, std::uint32_t y) {
                if (!(true_alpha(t, c, x, y) >= double(rules.alpha_min))) return;
                ++(x >= r.x0 && x < r.x1 && y >= r.y0 && y < r.y1 ? inside : outside);
            };
            for (std::uint32_t y = r.y0 - 2; y < r.y1 + 2; ++y)
                for (std::uint32_t x : {r.x0 - 2, r.x0 - 1, r.x0, r.x1 - 1, r.x1, r.x1 + 1}) test(x, y);
            for (std::uint32_t x = r.x0 - 2; x < r.x1 + 2; ++x)
                for (std::uint32_t y : {r.y0 - 2, r.y0 - 1, r.y0, r.y1 - 1, r.y1, r.y1 + 1}) test(x, y);
        }
    CHECK(outside == 0);
    CHECK(inside > 0);
    report({13, "sigma 1, 10, 300 px, turned", "ceil(3 sigma) one more in " + percent(double(naive_up) / samples),
            "one more in " + percent(double(ours_up) / samples) + ", never less; no visible pixel outside", "superset", false});
}

TEST_CASE("row 14: variances whose squares overflow")
{
    Camera c = plain_camera();
    c.fx = c.fy = 1;
    float const scale = float(0.5 * std::log(2e19));
    Gaussian g = gaussian(0, 0, 1, scale, scale, scale);
    g.opacity = 0.7f;
    for (auto const& rules : both_footprints()) CHECK(covers_frame(our_splat(g, c, rules), c, g.opacity, 4 * u));
    auto const screen = naive::covariance_screen(naive::covariance_world(g), c, {0, 0, 1}, 1.3f, 0.3f);
    float const mid = 0.5f * (screen.a + screen.c), inner = mid * mid - naive::determinant(screen);
    CHECK(std::isnan(inner));
    CHECK(std::isnan(std::max(inner, 0.1f))); // max(0.1, inner) is 0.1, by the order of its arguments alone
    report({14, "a = c = 2e19 px^2", "mid^2 - det is NaN", "opacity all over the frame", "4u", true});
}

TEST_CASE("row 15: no eigenvectors, no 0/0")
{
    Camera const c = plain_camera();
    Gaussian const g = gaussian(0, 0, 2, -3, -4, -5); // b = 0, a > c
    auto const t = truth<double>(g, c, Rules{});
    CHECK(t.b == 0);
    CHECK(t.a > t.c);
    // normalize((b, lambda_max - a)), with the exact lambda_max = a.
    float const x = 0, y = float(t.a) - float(t.a), length = std::sqrt(x * x + y * y);
    CHECK(std::isnan(x / length));
    CHECK(std::isnan(y / length));
    for (auto const& rules : both_footprints()) {
        auto const s = our_splat(g, c, rules);
        CHECK(s.visible());
        CHECK(s.slope == 0.0f);
        CHECK(finite_alpha(s, c));
    }
    report({15, "b = 0, a >= c", "eigenvector 0/0", "needs none", "finite", true});
}

TEST_CASE("row 16: a quaternion of zeros is refused and counted")
{
    float const zero[4] = {0, 0, 0, 0};
    Gaussian g = gaussian(0, 0, 2, -3, -3, -3);
    std::copy(zero, zero + 4, g.rotation);
    naive::Variant formula;
    formula.unit = naive::raw;
    CHECK(naive::project(g, plain_camera(), formula).drawn);          // the formula makes it the identity
    CHECK(std::isnan(naive::project(g, plain_camera()).determinant)); // and NaN where it is normalised
    CHECK_FALSE(our_splat(g, plain_camera(), Rules{}).visible());

    Gaussian loaded{};
    CHECK(load_row({0, 0, 2, 0, 0, 0, 1, -3, -3, -3, 0, 0, 0, 0}, loaded) != nullptr);
    std::string text = "ply\nformat ascii 1.0\nelement vertex 3\n";
    for (auto const& name : tilemesh::scene::detail::needed_properties) text += "property float " + std::string(name) + "\n";
    text += "end_header\n0 0 2 0 0 0 1 -3 -3 -3 1 0 0 0\n0 0 2 0 0 0 1 -3 -3 -3 0 0 0 0\n0 0 3 0 0 0 1 -3 -3 -3 0 0 0 1\n";
    std::istringstream file(text);
    auto const map = tilemesh::scene::read_ply(file, "three.ply");
    CHECK(map.rejected == 1);
    CHECK(map.gaussians.size() == 2);
    report({16, "q = (0, 0, 0, 0)", "drawn as the identity, or NaN", "row refused and counted; invisible", "exact", true});
}

TEST_CASE("row 17: tiny quaternions")
{
    float const tiny[4] = {1e-23f, 0, 1e-23f, 0};
    double const theirs = not_orthogonal(naive::rotation(naive::normalised(tiny))), ours = not_orthogonal(tiny);
    CHECK(ours <= 1e-6);
    CHECK(turned_box_error(tiny) <= 1e-5); // 90 degrees about y
    CHECK_FALSE(theirs <= 1e-6);
    Gaussian g{};
    CHECK(load_row({0, 0, 2, 0, 0, 0, 1, -3, -3, -3, 1e-23, 0, 1e-23, 0}, g) == nullptr);
    CHECK(std::fabs(g.rotation[0] - 0.70710678f) <= 1e-7f);
    CHECK(std::fabs(g.rotation[2] - 0.70710678f) <= 1e-7f);
    report({17, "q = (1e-23, 0, 1e-23, 0)", "NaN", "R R^T - I " + number(ours), "1e-6", true});
}

TEST_CASE("row 18: huge quaternions")
{
    float const large[4] = {1e20f, 1e20f, 0, 0}; // 90 degrees about x
    auto const r = naive::rotation(naive::normalised(large));
    double const ours = not_orthogonal(large);
    CHECK(ours <= 1e-6);
    CHECK(turned_box_error(large) <= 1e-5);
    CHECK(r.m[1][1] == 1.0f); // the identity; the right entry is 0
    Gaussian g{};
    CHECK(load_row({0, 0, 2, 0, 0, 0, 1, -3, -3, -3, 1e20, 1e20, 0, 0}, g) == nullptr);
    CHECK(std::fabs(g.rotation[1] - 0.70710678f) <= 1e-7f);
    report({18, "q = (1e20, 1e20, 0, 0)", "the identity, silently", "R R^T - I " + number(ours), "1e-6", true});
}

TEST_CASE("row 19: quaternions that are not normalised")
{
    support::Random random(19);
    double ours = 0, theirs[3] = {};
    float const norms[3] = {1.001f, 1.01f, 2};
    for (int n = 0; n < 1000; ++n) {
        Gaussian g{};
        random_rotation(g, random);
        auto const unit = naive::normalised(g.rotation);
        for (int i = 0; i < 3; ++i) {
            float const q[4] = {unit.w * norms[i], unit.x * norms[i], unit.y * norms[i], unit.z * norms[i]};
            ours = std::max(ours, not_orthogonal(q));
            theirs[i] = std::max(theirs[i], not_orthogonal(naive::rotation(naive::raw(q))));
        }
    }
    CHECK(ours <= 1e-6);
    for (double e : theirs) CHECK(e > 1e-6);
    report({19, "norm of q 1.001, 1.01, 2", "R R^T - I " + number(theirs[0]) + ", " + number(theirs[1]) + ", " + number(theirs[2]), number(ours),
            "1e-6", true});
}

TEST_CASE("row 20: scales whose square or fourth power overflows")
{
    Camera const c = plain_camera();
    int bad = 0;
    for (float scale : {22.2f, 44.4f, 88.0f, 88.8f}) {
        Gaussian g = gaussian(0.6f, 0.6f, 2, scale, scale, scale);
        g.opacity = 0.7f;
        for (auto const& rules : both_footprints()) CHECK_MESSAGE(covers_frame(our_splat(g, c, rules), c, g.opacity, 4 * u), "log scale ", scale);
        auto const n = naive::project(g, c);
        bad += std::isfinite(n.determinant) && std::isfinite(naive::alpha_at(n, 3, 3)) ? 0 : 1;
        // One such axis, and two.
        for (int axes = 1; axes <= 2; ++axes) {
            for (float& s : g.log_scale) s = -5;
            for (int i = 0; i < axes; ++i) g.log_scale[i] = scale;
            g.rotation[1] = 0.2f;
            g.rotation[3] = 0.3f;
            CHECK(finite_alpha(our_splat(g, c, Rules{}), c));
        }
    }
    CHECK(bad == 4);
    // Up to 1e18 pixels a needle is in the right place.
    auto const needles = compare(2000, [](Gaussian& g, support::Random& random) {
        place(g, random, 1, 5);
        g.log_scale[0] = random.uniform(12, 30);
        g.log_scale[1] = g.log_scale[2] = random.uniform(-7, -3);
    });
    CHECK(needles.ours.max_rho() <= 4);
    CHECK(needles.ours_dropped == 0);
    report({20, "log scale 22.2, 44.4, 88.8", "determinant or alpha not finite",
            "opacity all over the frame; needles to e^30: rho " + number(needles.ours.max_rho()), "finite; rho <= 4", true});
}

TEST_CASE("row 21: scales whose square or fourth power is zero")
{
    Camera const c = plain_camera();
    Gaussian const dot = gaussian(0.011f, 0.007f, 2, point, point, point);
    auto const want = our_splat(dot, c, Rules{});
    double worst = 0;
    for (float scale : {-26.0f, -43.7f, -52.0f, -87.0f, -200.0f}) {
        Gaussian g = dot;
        for (float& s : g.log_scale) s = scale;
        auto const s = our_splat(g, c, Rules{});
        CHECK(std::fabs(s.along / want.along - 1) <= 1e-6f);
        CHECK(std::fabs(s.across / want.across - 1) <= 1e-6f);
        auto const t = truth<double>(g, c, Rules{});
        for (std::uint32_t x = 643; x < 648; ++x) worst = std::max(worst, std::fabs(double(our_alpha(s, c, x, 363)) - true_alpha(t, c, x, 363)));
        CHECK(naive::project(g, c).determinant > 0);
        // Without dilation nothing keeps the determinant positive: invisible, not NaN.
        Rules bare;
        bare.dilation = 0;
        CHECK(finite_alpha(our_splat(g, c, bare), c));
    }
    CHECK(worst <= 1e-5);
    report({21, "log scale -26, -43.7, -52", "a point; the dilation saves it", "a point, alpha off by " + number(worst), "finite", false});
}

TEST_CASE("row 22: a size of zero and an opacity of 0 or 1 are values")
{
    auto const over_eager = [](std::initializer_list<double> fields) { // a filter of finite rows keeps these
        return std::all_of(fields.begin(), fields.end(), [](double v) { return std::isfinite(v); });
    };
    Gaussian g{};
    CHECK(load_row({0, 0, 2, 0, 0, 0, infinity, -infinity, -3, -3, 1, 0, 0, 0}, g) == nullptr);
    CHECK_FALSE(over_eager({0, 0, 2, 0, 0, 0, infinity, -infinity, -3, -3, 1, 0, 0, 0}));
    CHECK(g.opacity == 1.0f);
    CHECK(tilemesh::splat::exponential(g.log_scale[0]) < 1e-37f);
    auto const s = our_splat(g, plain_camera(), Rules{});
    CHECK(s.visible());
    CHECK(finite_alpha(s, plain_camera()));
    CHECK(load_row({0, 0, 2, 0, 0, 0, -infinity, -3, -3, -3, 1, 0, 0, 0}, g) == nullptr);
    CHECK(g.opacity == 0.0f);
    CHECK_FALSE(our_splat(g, plain_camera(), Rules{}).visible());
    CHECK(load_row({0, 0, 2, 0, 0, 0, 1, infinity, -3, -3, 1, 0, 0, 0}, g) != nullptr); // an infinite size is not valid
    report({22, "log scale -inf, logit +-inf", "a filter of finite rows drops them", "loaded: size 0, opacity 0 or 1", "exact", true});
}

TEST_CASE("row 23 does not apply")
{
    does_not_apply(23, "the model has no three-dimensional smoothing filter whose normalisation this is");
}

TEST_CASE("row 24: at the camera")
{
    Camera c = plain_camera();
    Gaussian const g = gaussian(1e-11f, 1e-11f, 1e-10f, log_of(0.01), log_of(0.01), log_of(0.01));
    CHECK_FALSE(our_splat(g, c, Rules{}).visible());
    auto const n = without_near_plane(g, c);
    CHECK(std::isnan(n.determinant));
    CHECK(n.drawn); // NaN <= 0 is false
    c.near_depth = 0;
    CHECK(finite_alpha(our_splat(g, c, Rules{}), c));
    report({24, "z = 1e-10, sigma 0.01", "determinant NaN passes det <= 0", "culled; finite without a near plane", "culled", true});
}

TEST_CASE("row 25: a radius beyond the integers")
{
    Camera c = plain_camera();
    c.near_depth = 0;
    Gaussian const g = gaussian(0, 0, 1e-8f, log_of(0.0123), log_of(0.0123), log_of(0.0123));
    for (auto const& rules : both_footprints()) CHECK(covers_frame(our_splat(g, c, rules), c, 1, 4 * u));
    auto const n = without_near_plane(g, c);
    float const radius = 3.0f * std::sqrt(n.screen.a);
    CHECK(radius > 2147483648.0f);
    CHECK(naive::to_int(radius) < 0);
    report({25, "z = 1e-8", "radius " + number(double(radius)) + " px does not fit an int", "the whole frame", "defined", true});
}

TEST_CASE("row 26: visible iff z > near")
{
    Camera const c = plain_camera();
    Gaussian g = gaussian(0, 0, 0.2f, log_of(0.05), log_of(0.05), log_of(0.05));
    CHECK_FALSE(our_splat(g, c, Rules{}).visible());
    CHECK_FALSE(naive::project(g, c).drawn);
    g.mean_world[2] = std::nextafter(0.2f, 1.0f);
    CHECK(our_splat(g, c, Rules{}).visible());
    CHECK(naive::project(g, c).drawn);
    report({26, "z = 0.2f and the next float", "invisible, visible", "invisible, visible", "exact", false});
}

TEST_CASE("row 27: behind the camera")
{
    Camera const c = plain_camera();
    Gaussian const small = gaussian(0.1f, 0.1f, -1, -3, -3, -3), large = gaussian(0.1f, 0.1f, -0.01f, 1, 1, 1);
    CHECK(naive::alpha_at(without_near_plane(small, c), 540, 260) > 0.9f); // mirrored
    CHECK(naive::alpha_at(without_near_plane(large, c), 640, 360) > 0.9f); // all over the frame
    CHECK_FALSE(our_splat(small, c, Rules{}).visible());
    CHECK_FALSE(our_splat(large, c, Rules{}).visible());
    report({27, "z = -1; z = -0.01 and sigma 2.7", "without a near plane a mirrored splat, a flash", "culled", "no contribution", true});
}

TEST_CASE("row 28: a mean at the camera centre")
{
    Camera c = plain_camera();
    for (int i = 0; i < 3; ++i) c.position[i] = 1.5f;
    Gaussian const g = gaussian(1.5f, 1.5f, 1.5f, -1, -1, -1);
    float const d[3] = {g.mean_world[0] - c.position[0], g.mean_world[1] - c.position[1], g.mean_world[2] - c.position[2]};
    CHECK(std::isnan(d[2] / std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]))); // the naive view direction
    for (float near_depth : {0.2f, 0.0f}) {
        c.near_depth = near_depth;
        auto const s = our_splat(g, c, Rules{});
        CHECK_FALSE(s.visible());
        for (float v : {s.mean_px[0], s.mean_px[1], s.along, s.slope, s.across, s.depth(), s.faintest}) CHECK(std::isfinite(v));
    }
    // And just in front of it, if the colour depends on the direction.
    tilemesh::splat::ShadedGaussian<3> shaded{};
    static_cast<Gaussian&>(shaded) = gaussian(0, 0, 0, -20, -20, -20);
    std::fill(std::begin(shaded.harmonics), std::end(shaded.harmonics), 0.1f);
    c = plain_camera();
    c.near_depth = 0;
    std::uint32_t seen = 0;
    for (float z : {0.0f, 1e-45f, 1e-38f, 1e-30f, 1e-20f, 1e-8f, 1.0f, 1e8f, 1e20f, 1e30f, 3e38f}) {
        shaded.mean_world[2] = z;
        auto const s = our_splat(shaded, c, Rules{});
        seen += s.visible() ? 1 : 0;
        for (float v : s.colour) CHECK(std::isfinite(v));
        CHECK(finite_alpha(s, c));
    }
    CHECK(seen >= 5);
    report({28, "mean = camera centre", "view direction 0/0", "culled; in front of it a finite colour", "finite", true});
}

TEST_CASE("row 29: divided by the depth, nothing added to it")
{
    Camera c = plain_camera();
    c.fx = c.fy = 1024; // a power of two: the division alone is rounded
    c.near_depth = 1e-5f;
    c.cx = 0;
    Gaussian const g = gaussian(0.625f * 1e-4f, 0, 1e-4f, -12, -12, -12);
    double const right = 1024 * double(g.mean_world[0]) / double(g.mean_world[2]);
    auto const s = our_splat(g, c, Rules{});
    REQUIRE(s.visible());
    float const reciprocal = 1.0f / (g.mean_world[2] + 1e-7f);
    double const bias = std::fabs(double(c.fx * g.mean_world[0] * reciprocal) - right);
    double const ours = std::fabs(double(s.mean_px[0]) - right);
    CHECK(ours <= u * right);
    CHECK(bias > u * right);
    CHECK(bias > 0.5);
    report({29, "z = 1e-4; 1 / (w + 1e-7)", "mean off by " + number(bias) + " px", number(ours) + " px", "u", true});
}

TEST_CASE("row 30: coordinates far from the origin")
{
    support::Random random(30);
    double worst_ours = 0, worst[4] = {};
    for (int magnitude = 0; magnitude < 4; ++magnitude)
        for (int n = 0; n < 2000; ++n) {
            Camera c = plain_camera();
            Gaussian turn{};
            random_rotation(turn, random);
            auto const r = rotation_of<double>(turn.rotation);
            float const z = random.uniform(2, 10);
            double const view[3] = {double(random.uniform(-0.6f, 0.6f) * z), double(random.uniform(-0.35f, 0.35f) * z), double(z)};
            Gaussian g = gaussian(0, 0, 0, -3, -3, -3);
            for (std::size_t i = 0; i < 3; ++i) {
                c.position[i] = random.uniform(0.5f, 1) * std::pow(10.0f, float(4 + magnitude));
                double p = double(c.position[i]);
                for (std::size_t k = 0; k < 3; ++k) {
                    c.rotation[k][i] = float(r[k][i]);
                    p += r[k][i] * view[k];
                }
                g.mean_world[i] = float(p);
            }
            auto const t = truth<double>(g, c, Rules{});
            auto const s = our_splat(g, c, Rules{});
            if (!s.visible()) continue; // the grid of floats at 1e7 is a metre: some leave the frame
            worst_ours = std::max(worst_ours, std::hypot(double(s.mean_px[0]) - t.x, double(s.mean_px[1]) - t.y));
            auto const v = naive::view_point(c, g.mean_world);
            worst[magnitude] = std::max(worst[magnitude], std::hypot(double(c.fx * v.x / v.z) - t.x, double(c.fy * v.y / v.z) - t.y));
        }
    CHECK(worst_ours <= 1e-3);
    CHECK(worst[2] > 1);
    for (double e : worst) CHECK(e > 1e-3);
    report({30, "coordinates 1e4, 1e5, 1e6, 1e7; W p + t",
            "mean off by " + number(worst[0]) + ", " + number(worst[1]) + ", " + number(worst[2]) + ", " + number(worst[3]) + " px",
            number(worst_ours) + " px at every magnitude", "1e-3 px", true});
}

TEST_CASE("row 31: coordinates that a float cannot hold lose their offset before they are loaded")
{
    // A record holds floats: coordinates loaded at 5.5e6 m are on a grid of 0.5 m. The offset must be subtracted from the map and the
    // camera in double, before either is made.
    support::Random random(31);
    double const offset[3] = {5.5e6, 4.5e5, 5.1e6};
    double ours = 0, direct = 0;
    for (int n = 0; n < 1000; ++n) {
        double const local[3] = {double(random.uniform(-3, 3)), double(random.uniform(-2, 2)), double(random.uniform(9, 11))};
        double const right[2] = {1000 * local[0] / local[2], 1000 * local[1] / local[2]};
        auto const error = [&](double const(&shift)[3]) {
            double const at[3] = {local[0] + offset[0] - shift[0], local[1] + offset[1] - shift[1], local[2] + offset[2] - shift[2]};
            Gaussian g{};
            REQUIRE(load_row({at[0], at[1], at[2], 0, 0, 0, 5, -3, -3, -3, 1, 0, 0, 0}, g) == nullptr);
            Camera c = plain_camera();
            for (int i = 0; i < 3; ++i) c.position[i] = float(offset[i] - shift[i]);
            auto const s = our_splat(g, c, Rules{});
            return std::hypot(double(s.mean_px[0]) - right[0], double(s.mean_px[1]) - right[1]);
        };
        double const none[3] = {};
        ours = std::max(ours, error(offset));
        direct = std::max(direct, error(none));
    }
    CHECK(ours <= 0.01);
    CHECK(direct > 10);
    report({31, "UTM, 5.5e6 m", "loaded as it is: mean off by " + number(direct) + " px",
            "offset taken off in double by the user: " + number(ours) + " px", "0.01 px", true});
}

TEST_CASE("row 32: one Gaussian at 7e8 does not spoil the order of the others")
{
    support::Random random(32);
    Camera const c = plain_camera();
    struct Item {
        double depth;
        std::uint32_t id;
    };
    std::vector<Item> items;
    std::vector<tilemesh::splat::SortKey> keys;
    for (std::uint32_t n = 1; n <= 5000; ++n) {
        float const z = n == 1 ? 7e8f : n == 2 ? 5.3e8f : random.uniform(1, 10);
        Gaussian const g = gaussian(0.1f * z, 0.1f * z, z, -2, -2, -2);
        auto const s = our_splat(g, c, Rules{});
        REQUIRE(s.visible());
        items.push_back({truth<double>(g, c, Rules{}).depth, n});
        keys.push_back({s.depth_key, tilemesh::splat::GaussianId{n}, n});
    }
    std::sort(items.begin(), items.end(), [](Item const& a, Item const& b) { return a.depth != b.depth ? a.depth < b.depth : a.id < b.id; });
    tilemesh::splat::detail::heap_sort(keys.data(), std::uint32_t(keys.size()));
    std::uint32_t ours_wrong = 0, naive_ties = 0;
    auto const range_key = [&](Item const& i) { // 16 bits over the range of depths
        return static_cast<std::uint32_t>((i.depth - items.front().depth) / (items.back().depth - items.front().depth) * 65535);
    };
    for (std::size_t i = 0; i < items.size(); ++i) {
        ours_wrong += items[i].id != static_cast<std::uint32_t>(keys[i].id) ? 1 : 0;
        if (i > 0 && items[i].depth > items[i - 1].depth) naive_ties += range_key(items[i]) == range_key(items[i - 1]) ? 1 : 0;
    }
    CHECK(ours_wrong == 0);
    CHECK(naive_ties > 4900);
    report({32, "5000 depths 1 to 10, two of 5.3e8 and 7e8", std::to_string(naive_ties) + " false ties of 16-bit keys over the range",
            "0 out of order", "order kept", true});
}

TEST_CASE("row 33: the Jacobian's clamp is a knob, and does nothing inside the frustum")
{
    // Half of the width that the middle 68.27 % of the projected samples take: P(x/z < k) = Phi((k z0 - x0) / (s sqrt(1 + k^2))).
    auto const samples_px = [](double x, double z, double s) {
        auto const quantile = [&](double sign) {
            double k = x / z;
            for (int i = 0; i < 100; ++i) k = (x + sign * s * std::sqrt(1 + k * k)) / z;
            return k;
        };
        return 1000 * (quantile(1) - quantile(-1)) / 2;
    };
    Camera c = plain_camera();
    struct Case {
        float x, z, s;
    };
    std::string clamped, open, samples;
    for (auto const& [x, z, s] : {Case{3, 2, 0.05f}, Case{50, 1, 0.1f}}) {
        c.cx = 640 - 1000 * x / z; // in the frame, but the clamp ignores the principal point
        Gaussian const g = gaussian(x, 0, z, log_of(double(s)), log_of(double(s)), log_of(double(s)));
        double const right = samples_px(double(x), double(z), double(s));
        double found[2];
        for (int off = 0; off < 2; ++off) {
            Rules rules;
            if (off == 1) rules.jacobian_limit = 0;
            auto const splat = our_splat(g, c, rules);
            REQUIRE(splat.visible());
            auto const t = truth<double>(g, c, rules);
            CHECK(std::fabs(-0.5 / double(splat.along) / t.a - 1) < 1e-6);
            found[off] = std::sqrt(-0.5 / double(splat.along) - double(rules.dilation));
        }
        CHECK(std::fabs(found[1] / right - 1) < 0.02);
        auto const n = naive::project(g, c); // always clamped
        double const of_naive = std::sqrt(double(n.screen.a) - 0.3);
        CHECK(of_naive / right < 0.75);
        clamped += (clamped.empty() ? "" : " and ") + tenths(of_naive);
        open += (open.empty() ? "" : " and ") + tenths(found[1]);
        samples += (samples.empty() ? "" : " and ") + tenths(right);
    }
    support::Random random(33);
    for (int n = 0; n < 2000; ++n) {
        Gaussian g{};
        random_rotation(g, random);
        place(g, random, 0.5f, 5);
        for (float& s : g.log_scale) s = random.uniform(-6, 0);
        Rules off;
        off.jacobian_limit = 0;
        auto const a = our_splat(g, plain_camera(), Rules{}), b = our_splat(g, plain_camera(), off);
        CHECK(std::memcmp(&a, &b, sizeof a) == 0);
    }
    report({33, "x/z 1.5 and 50; samples take " + samples + " px", "clamped: " + clamped + " px",
            "knob off: " + open + " px; inactive in the frustum", "2 % of the samples", true});
}

TEST_CASE("row 34: the clamp turns a needle far off the axis")
{
    Camera c = plain_camera();
    c.cx = 640 - 10000;
    c.cy = 360 - 3000;
    Gaussian const g = gaussian(10, 3, 1, point, point, log_of(0.1)); // along z: points at the principal point
    auto const degrees = [](double a, double b, double cc) { return 0.5 * std::atan2(2 * b, a - cc) * 180 / 3.14159265358979; };
    double const right = std::atan2(3, 10) * 180 / 3.14159265358979;
    double found[3];
    for (int off = 0; off < 3; ++off) {
        Rules rules;
        if (off == 0) rules.slope_border = tilemesh::splat::SlopeBorder::of_half_width;
        if (off == 1) rules.jacobian_limit = 0;
        auto const s = our_splat(g, c, rules);
        REQUIRE(s.visible());
        Screen const screen(s);
        found[off] = degrees(screen.a, screen.b, screen.c);
        auto const t = truth<double>(g, c, rules);
        CHECK(std::fabs(found[off] - degrees(t.a, t.b, t.c)) < 0.01);
    }
    auto const n = naive::project(g, c);
    double const naive_turn = std::fabs(degrees(double(n.screen.a), double(n.screen.b), double(n.screen.c)) - right);
    CHECK(std::fabs(found[1] - right) < 0.1);
    CHECK(naive_turn > 0.1);
    CHECK(std::fabs(found[0] - right) > 12);  // the trainers' bound, which knows no principal point
    CHECK(std::fabs(found[2] - right) < 0.1); // the default's bound follows the picture
    report({34, "mean (10, 3, 1), needle along z", "turned by " + number(naive_turn) + " degrees",
            "knob off: " + number(std::fabs(found[1] - right)) + "; the default's bound follows the picture", "0.1 degrees", true});
}

TEST_CASE("row 35: what the linearised projection itself is off by")
{
    Camera const c = plain_camera();
    Gaussian const g = gaussian(0, 0, 2, log_of(0.5), log_of(0.5), log_of(0.5));
    auto const s = our_splat(g, c, Rules{});
    double const ours = std::sqrt(-0.5 / double(s.along) - double(Rules{}.dilation));
    double const samples = 1000 / std::sqrt(4.0 / 0.25 - 1); // the middle 68.27 % of x/z
    auto const n = naive::project(g, c);
    CHECK(std::fabs(ours / 250 - 1) < 1e-6);
    CHECK(std::fabs(std::sqrt(double(n.screen.a) - 0.3) / 250 - 1) < 1e-6);
    CHECK(samples / ours > 1.02);
    CHECK(samples / ours < 1.04);
    report({35, "sigma 0.5 at z 2, on the axis", "250 px", number(ours) + " px where samples take " + number(samples) + ": the model's error",
            "1e-6 of the formula", false});
}

TEST_CASE("row 36 does not apply")
{
    does_not_apply(36, "the model has no anti-aliasing factor: a splat below a pixel grows by the dilation, as in 3DGS");
}

TEST_CASE("row 37: a radius of 3e9 pixels covers the frame")
{
    Camera c = plain_camera();
    c.fx = c.fy = 1;
    Gaussian g = gaussian(0, 0, 1, log_of(1e9), log_of(1e9), log_of(1e9));
    for (auto const& rules : both_footprints()) CHECK(covers_frame(our_splat(g, c, rules), c, 1, 4 * u));
    // The canonical rectangle of 16-pixel tiles: the radius is an int.
    float const mean = 640;
    int const radius = naive::to_int(3e9f), columns = 1280 / 16;
    int const first = std::min(columns, std::max(0, naive::to_int((mean - float(radius)) / 16)));
    int const last = std::min(columns, std::max(0, naive::to_int((mean + float(radius) + 15) / 16)));
    CHECK(radius == std::numeric_limits<int>::min());
    CHECK(last <= first);
    report({37, "radius 3e9 px", "(int) is INT_MIN: not drawn", "the whole frame", "exact", true});
}

namespace {
/// The largest number of blocks of the compositing kernel that a tile of at most `pixels` pixels touches, in any place.
std::uint64_t most_blocks(std::uint64_t pixels)
{
    using tilemesh::splat::block_height;
    using tilemesh::splat::block_width;
    std::uint64_t most = 0;
    for (std::uint64_t w = 1; w <= 65535 && w <= pixels; ++w) {
        std::uint64_t const h = std::min<std::uint64_t>(pixels / w, 65535);
        most = std::max(most, ((w + block_width - 2) / block_width + 1) * ((h + block_height - 2) / block_height + 1));
    }
    return most;
}
void counters_suffice(Rules const& m, tilemesh::splat::Sizes const& sizes)
{
    constexpr std::uint64_t end = std::uint64_t{1} << 32;
    CHECK(std::uint64_t{sizes.storage} * most_blocks(sizes.tile_pixels) < end);
    // An upper bound for the terms of a pixel: each leaves at most 1 - alpha_min of its transmittance.
    auto const terms = static_cast<std::uint64_t>(std::log(double(m.transmittance_min)) / std::log1p(-double(m.alpha_min))) + 2;
    CHECK(std::min<std::uint64_t>(terms, sizes.storage) * sizes.tile_pixels < end);
}
} // namespace

TEST_CASE("row 38: 1.5 million full-screen splats on 1,440 tiles are counted in 64 bits")
{
    using tilemesh::report::FrameReport;
    static_assert(std::is_same_v<decltype(FrameReport::pairs), std::uint64_t> && std::is_same_v<decltype(FrameReport::copies), std::uint64_t> &&
                  std::is_same_v<decltype(FrameReport::messages), std::uint64_t>);
    std::uint64_t const copies = std::uint64_t{1491309} * 1440; // 1,491,308 are the last that fit
    CHECK(static_cast<std::int32_t>(static_cast<std::uint32_t>(copies)) < 0);
    FrameReport r;
    r.copies += copies;
    r.pairs += copies * 640;
    CHECK(r.copies == 2147484960u);
    CHECK(r.pairs / 640 == copies);
    // The counts of a tile within a frame, which have 32 bits.
    auto const suffice = []<class S>(S, tilemesh::splat::Sizes const& sizes = S::sizes) {
        Rules m;
        m.transmittance_min = S::transmittance_min;
        counters_suffice(m, sizes);
        if (sizes.tile_pixels <= 640) counters_suffice(with_quality(m, tilemesh::splat::Quality::evaluation), sizes); // what takes most terms
    };
    suffice(tilemesh::splat::Lossless{});
    suffice(tilemesh::splat::Paper{});
    suffice(tilemesh::splat::Prototype{});
    suffice(tilemesh::splat::Lossless{}, roomy(tilemesh::splat::Lossless::sizes)); // no machine of SRAM: with the model's own alpha_min
    report({38, "1,491,309 full-screen splats x 1,440 tiles", "a 32-bit count is negative", "64 bits; no tile's own count overflows", "exact", true});
}

TEST_CASE("a needle of any length along the ray is the point that it looks like from its end")
{
    auto camera = support::flat_camera(64, 64);
    camera.cx = camera.cy = 32;
    for (float log_scale : {0.0f, 20.0f, 82.0f, 85.0f, 88.0f, 1e30f}) {
        auto g = support::ball(1, 0, 0, 0.1f);
        g.mean_world[2] = 3;
        g.log_scale[2] = log_scale;
        g.log_scale[0] = g.log_scale[1] = -8.0f;
        auto const s =
            tilemesh::splat::project(g, tilemesh::splat::make_view(camera, tilemesh::splat::Rules{}), tilemesh::splat::make_tiling(64, 64, 16, 16));
        INFO("log scale ", log_scale);
        REQUIRE(s.visible());
        CHECK(s.along == doctest::Approx(-0.5 / (0.3 + std::pow(1000.0 / 3 * std::exp(-8.0), 2))));
        CHECK(s.across == doctest::Approx(s.along));
        CHECK(tilemesh::splat::alpha_at(s, 0.5f, 0.5f) < g.opacity);
    }
}
