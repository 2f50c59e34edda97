#include "catalogue.hpp"
#include "reference.hpp"

using namespace stability;

// rho = error of alpha / (error from moving every input by one ulp + u): 1 is as good as the inputs allow.
namespace {
/// Half of them in front of the identity camera, half in front of a random camera.
Sample random_sample(support::Random& random, bool posed)
{
    Camera c = plain_camera();
    c.fx = random.uniform(900, 1100);
    c.fy = random.uniform(900, 1100);
    c.cx = random.uniform(600, 680);
    c.cy = random.uniform(330, 390);
    Gaussian g{};
    float const z = random.uniform(0.3f, 5);
    float const view[3] = {random.uniform(-0.9f, 0.9f) * z, random.uniform(-0.55f, 0.55f) * z, z}; // frame: 0.64 and 0.36
    for (int i = 0; i < 3; ++i) g.mean_world[i] = view[i];
    if (posed) {
        Gaussian turn{};
        random_rotation(turn, random);
        auto const r = rotation_of<double>(turn.rotation);
        for (std::size_t i = 0; i < 3; ++i) {
            c.position[i] = random.uniform(-2, 2);
            double p = double(c.position[i]);
            for (std::size_t k = 0; k < 3; ++k) {
                c.rotation[k][i] = float(r[k][i]);
                p += r[k][i] * double(view[k]);
            }
            g.mean_world[i] = float(p);
        }
    }
    random_rotation(g, random);
    for (float& s : g.log_scale) s = random.uniform(-8, 2);
    g.opacity = random.uniform(0.01f, 1);
    return make_sample(g, c, uncut(), random);
}

/// A disc seen along its plane, almost upright or almost level. One variance on the screen is the result of a cancellation. The determinant
/// must be off by the same factor, because alpha depends on their ratio.
Sample edge_on_disc(support::Random& random, bool upright)
{
    Gaussian g{};
    float const z = random.uniform(0.5f, 5);
    g.mean_world[0] = random.uniform(-0.64f, 0.64f) * z;
    g.mean_world[1] = random.uniform(-0.36f, 0.36f) * z;
    g.mean_world[2] = z;
    // The normal: across the view ray, tilted by 1e-4 to 0.1.
    double const slope_x = double(g.mean_world[0]) / double(z), slope_y = double(g.mean_world[1]) / double(z);
    double normal[3] = {upright ? 1.0 : 0.0, upright ? 0.0 : 1.0, upright ? -slope_x : -slope_y};
    double const tilt = std::pow(10.0, double(random.uniform(-4, -1)));
    for (double& v : normal) v += tilt * double(random.uniform(-1, 1));
    double const length = std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    // From the z axis onto the normal, after a turn about z.
    double const w = 1 + normal[2] / length, x = -normal[1] / length, y = normal[0] / length;
    double const turn = double(random.uniform(0, 3.14159f)), p = std::cos(turn), q = std::sin(turn);
    g.rotation[0] = float(w * p);
    g.rotation[1] = float(x * p + y * q);
    g.rotation[2] = float(y * p - x * q);
    g.rotation[3] = float(w * q);
    g.log_scale[0] = random.uniform(-2, 2);
    g.log_scale[1] = random.uniform(-2, 2);
    g.log_scale[2] = random.uniform(-8, -4);
    g.opacity = random.uniform(0.1f, 1);
    return make_sample(g, plain_camera(), uncut(), random);
}

float naive_alpha(Sample const& s, std::size_t i)
{
    return naive::alpha_at(naive::project(s.g, s.camera), s.x[i], s.y[i]);
}
float absolute_mean_alpha(Sample const& s, std::size_t i)
{
    auto splat = our_splat(s.g, s.camera, uncut());
    splat.mean_px[0] += s.camera.cx;
    splat.mean_px[1] += s.camera.cy;
    return tilemesh::splat::alpha_at(splat, static_cast<float>(s.x[i]) + 0.5f, static_cast<float>(s.y[i]) + 0.5f);
}

/// Every kernel on all samples.
struct Kernels {
    Spread ours, naive, absolute;
    std::uint32_t lit = 0; ///< pixels that see more than 1/255

    void add(Sample const& s)
    {
        auto const splat = our_splat(s.g, s.camera, uncut());
        for (std::size_t i = 0; i < Sample::pixels; ++i) {
            ours.add(s, i, our_alpha(splat, s.camera, s.x[i], s.y[i]));
            naive.add(s, i, naive_alpha(s, i));
            absolute.add(s, i, absolute_mean_alpha(s, i));
            lit += s.alpha[i] > 1.0 / 255 ? 1 : 0;
        }
    }
    void show() const
    {
        MESSAGE(ours.size(), " pixels, ", lit, " of them see more than 1/255");
        for (auto const& [name, e] : {std::pair{"ours", &ours}, {"naive", &naive}, {"ours with an absolute mean", &absolute}})
            MESSAGE(name, ": rho median ", e->rho(0.5), ", p99 ", e->rho(0.99), ", max ", e->max_rho(), "; alpha off by at most ", e->max_error());
    }
};
} // namespace

TEST_CASE("rho: no alpha is off by more than 4 times what its inputs' last bits excuse; the naive kernel's is")
{
    constexpr std::uint32_t samples = 50000;
    support::Random random(4);
    Kernels kernels;
    for (std::uint32_t n = 0; n < samples; ++n) kernels.add(random_sample(random, n % 2 == 1));
    kernels.show();
    CHECK(kernels.ours.size() == samples * Sample::pixels);
    CHECK(kernels.lit > kernels.ours.size() / 2);
    CHECK(kernels.ours.max_rho() <= 4);
    CHECK(kernels.naive.max_rho() > 100);
    CHECK(kernels.absolute.max_rho() > 4);
}

TEST_CASE("rho: nor for discs seen along their plane")
{
    constexpr std::uint32_t samples = 20000;
    support::Random random(40);
    Kernels kernels;
    for (std::uint32_t n = 0; n < samples; ++n) kernels.add(edge_on_disc(random, n % 2 == 1));
    kernels.show();
    CHECK(kernels.lit > kernels.ours.size() / 2);
    CHECK(kernels.ours.max_rho() <= 4);
    CHECK(kernels.naive.max_rho() > 100);
}

namespace {
/// The textbook formula, in a type that is wide enough: J W R S S^T R^T W^T J^T + dilation, and its inverse.
long double textbook_alpha(Sample const& s, std::size_t pixel)
{
    using T = long double;
    using Matrix = std::array<std::array<T, 3>, 3>;
    auto const product = [](Matrix const& a, Matrix const& b, bool transposed) {
        Matrix out{};
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j)
                for (std::size_t k = 0; k < 3; ++k) out[i][j] += a[i][k] * (transposed ? b[j][k] : b[k][j]);
        return out;
    };
    Camera const& c = s.camera;
    Rules const rules = uncut();
    Matrix w{}, scaled = rotation_of<T>(s.g.rotation);
    T t[3] = {};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            w[i][j] = T(c.rotation[i][j]);
            t[i] += w[i][j] * (T(s.g.mean_world[j]) - T(c.position[j]));
            scaled[i][j] *= std::exp(T(s.g.log_scale[j]));
        }
    T const limit_x = T(rules.jacobian_limit) * std::max(T(c.cx), T(c.width) - T(c.cx)) / T(c.fx),
            limit_y = T(rules.jacobian_limit) * std::max(T(c.cy), T(c.height) - T(c.cy)) / T(c.fy);
    T const x = std::clamp(t[0] / t[2], -limit_x, limit_x), y = std::clamp(t[1] / t[2], -limit_y, limit_y);
    Matrix const j{{{T(c.fx) / t[2], 0, -T(c.fx) * x / t[2]}, {0, T(c.fy) / t[2], -T(c.fy) * y / t[2]}, {0, 0, 0}}};
    Matrix const jw = product(j, w, false), sigma = product(scaled, scaled, true);
    Matrix const screen = product(product(jw, sigma, false), jw, true);
    T const a = screen[0][0] + T(rules.dilation), b = screen[0][1], d = screen[1][1] + T(rules.dilation);
    T const dx = T(s.x[pixel]) + T(0.5) - T(c.cx) - T(c.fx) * t[0] / t[2];
    T const dy = T(s.y[pixel]) + T(0.5) - T(c.cy) - T(c.fy) * t[1] / t[2];
    return T(s.g.opacity) * std::exp(-(d * dx * dx - 2 * b * dx * dy + a * dy * dy) / (2 * (a * d - b * b)));
}
} // namespace

TEST_CASE("rho: the truth in double is that of a wider type, and of the textbook's formula in it")
{
    support::Random random(41);
    double worst = 0, worst_textbook = 0;
    for (int n = 0; n < 3000; ++n) {
        auto const s = n % 3 == 2 ? edge_on_disc(random, n % 2 == 1) : random_sample(random, n % 2 == 1);
        auto const wide = truth<long double>(s.g, s.camera, uncut());
        for (std::size_t i = 0; i < Sample::pixels; ++i) {
            auto const off = [&](long double right) { return std::fabs(s.alpha[i] - double(right)) / (s.moved[i] + u); };
            worst = std::max(worst, off(true_alpha(wide, s.camera, s.x[i], s.y[i])));
            worst_textbook = std::max(worst_textbook, off(textbook_alpha(s, i)));
        }
    }
    MESSAGE("off by ", worst, " and ", worst_textbook, " of what is measured");
    CHECK(worst < 1e-4);
    CHECK(worst_textbook < 0.01);
}
