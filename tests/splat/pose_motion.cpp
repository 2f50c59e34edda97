// test: unoptimised test, without tsan, cost 6
#include "pose_reference.hpp"
#include "scenes.hpp"
#include <tilemesh/splat/pose/blend.hpp>
#include <tilemesh/splat/pose/terms.hpp>
#include <tilemesh/splat/pose/tile.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;
namespace reference = support::pose;

namespace {
using D = reference::OneDouble;
using F = splat::detail::OneFloat;
using reference::Pixel;

/// All pairs blend: nothing is cut off and nothing stops.
Rules without_cuts()
{
    Rules m;
    m.alpha_min = 0;
    m.transmittance_min = 0;
    m.arithmetic = Arithmetic::precise;
    return m;
}
/// The words of a splat that the templates read, in arithmetic A.
template <class A>
struct Words {
    pose::MovingSplat<A> moving;
    typename A::Real opacity, colour[3];
};
/// Of splats that the reference projected, by the definitions of the words.
std::vector<Words<D>> words_of(std::vector<reference::Splat> const& splats)
{
    std::vector<Words<D>> out;
    for (auto const& s : splats) {
        double const k = s.b / s.a;
        double along = 0, across = 0;
        for (int i = 0; i < 3; ++i) along += s.v1[i] * s.u3[i], across += (s.v2[i] - k * s.v1[i]) * s.u3[i];
        out.push_back(
            {{s.u, s.v, s.z, -0.5 / s.a, k, -0.5 * s.a / s.d, along / s.a, across / s.a}, s.opacity, {s.colour[0], s.colour[1], s.colour[2]}});
    }
    return out;
}
/// Of splats that the kernel projects in float.
std::vector<Words<F>> words_of(std::vector<Gaussian> const& order, View const& view)
{
    std::vector<Words<F>> out;
    for (auto const& g : order) {
        auto const s = pose::project(g, view, TileSize{view.camera.width, view.camera.height});
        if (!s.visible()) continue;
        out.push_back({{s.mean_px[0], s.mean_px[1], s.depth(), s.along, s.slope, s.across, s.terms.along_depth, s.terms.across_depth},
                       s.opacity, {s.colour[0], s.colour[1], s.colour[2]}});
    }
    return out;
}
template <class A>
std::array<pose::PowerMotion<A>, 6> motions_of(pose::detail::MotionBasis<A> const& basis)
{
    using pose::Column, pose::power_motion;
    return {power_motion<Column::rho_x>(basis), power_motion<Column::rho_y>(basis), power_motion<Column::rho_z>(basis),
            power_motion<Column::phi_x>(basis), power_motion<Column::phi_y>(basis), power_motion<Column::phi_z>(basis)};
}
/// The derivative by all motions with the kernels' templates.
template <class A>
reference::Derivative by_templates(std::vector<Words<A>> const& splats, View const& view)
{
    using Real = typename A::Real;
    auto const& c = view.camera;
    auto const& m = view.rules;
    std::vector<std::array<pose::PowerMotion<A>, 6>> motions;
    std::vector<std::array<Real, 3>> places; // of the means in view space, or the rays of a fisheye
    for (auto const& s : splats) {
        pose::detail::MotionBasis<A> const basis(s.moving, view);
        auto const& ray = basis.mean.ray;
        if (basis.by_angle) places.push_back({ray.x, ray.y, ray.z});
        else places.push_back({basis.sx * s.moving.depth, basis.sy * s.moving.depth, 1});
        motions.push_back(motions_of(basis));
    }
    reference::Derivative d;
    for (std::uint32_t y = 0; y < c.height; ++y)
        for (std::uint32_t x = 0; x < c.width; ++x) {
            pose::MovingPixel<A> p{};
            p.t = 1;
            for (std::size_t i = 0; i < splats.size(); ++i) {
                auto const& s = splats[i].moving;
                Real const dx = Real(x) + Real(0.5) - Real(c.cx) - s.mean_x, off = Real(y) + Real(0.5) - Real(c.cy) - s.mean_y - s.slope * dx;
                Real const raw = splats[i].opacity * std::exp(s.along * dx * dx + s.across * off * off);
                auto const& colour = splats[i].colour;
                pose::MovingPaint<A> const paint{{colour[0], colour[1], colour[2]}, s.depth, places[i][0], places[i][1], places[i][2],
                                                    c.lens.kind == LensKind::fisheye};
                auto const motion = [&](auto j) { return motions[i][decltype(j)::value]; };
                pose::blend_moving_pair<true, A>(p, std::min(raw, Real(m.alpha_max)), true, !(raw > Real(m.alpha_max)), dx, off, paint, motion, pose::AllMotions{});
            }
            Real const weight = 1 - p.t, depth = weight > 0 ? p.z / weight : 0;
            bool const angle = c.lens.kind == LensKind::fisheye;
            Real const of_depth[6] = {
                pose::depth_motion<0>(p, weight, depth, angle), pose::depth_motion<1>(p, weight, depth, angle), pose::depth_motion<2>(p, weight, depth, angle),
                pose::depth_motion<3>(p, weight, depth, angle), pose::depth_motion<4>(p, weight, depth, angle), pose::depth_motion<5>(p, weight, depth, angle)};
            for (std::uint32_t j = 0; j < 6; ++j)
                d[j].push_back({{p.dcolour[0][j], p.dcolour[1][j], p.dcolour[2][j]}, p.dt[j], weight > 0 ? of_depth[j] : 0});
        }
    return d;
}
/// The errors of a derivative, relative to its rms over the frame, by column and value.
struct Errors {
    std::vector<double> all;
    double most = 0;
    std::uint64_t not_numbers = 0;
    /// `picture`: depth counts only where something is seen, because it is a quotient.
    void add(reference::Derivative const& mine, reference::Derivative const& truth, std::vector<Pixel> const& picture)
    {
        auto const seen = [&](std::uint32_t i, std::size_t k) { return i != 4 || picture[k].transmittance < 0.999; };
        for (std::uint32_t j = 0; j < 6; ++j)
            for (std::uint32_t i = 0; i < Pixel::values; ++i) {
                double squares = 0;
                for (std::size_t k = 0; k < truth[j].size(); ++k) squares += seen(i, k) ? truth[j][k].value(i) * truth[j][k].value(i) : 0;
                double const rms = std::sqrt(squares / double(truth[j].size()));
                if (!(rms > 1e-6)) continue; // rounding of the differences is larger
                for (std::size_t k = 0; k < truth[j].size(); ++k) {
                    if (!seen(i, k)) continue;
                    double const error = std::fabs(mine[j][k].value(i) - truth[j][k].value(i)) / rms;
                    if (std::isnan(error)) ++not_numbers;
                    all.push_back(error);
                    most = std::max(most, error);
                }
            }
    }
    double quantile(double q)
    {
        std::sort(all.begin(), all.end());
        return all.at(std::min(all.size() - 1, std::size_t(q * double(all.size()))));
    }
};
/// Adds a scene's errors: of the templates in double, against differences.
void compare(Errors& errors, std::vector<Gaussian> const& order, reference::Camera const& c, View const& view, Rules const& rules)
{
    auto const splats = reference::projected(order, c, rules);
    errors.add(by_templates(words_of(splats), view), reference::central_differences(order, c, rules, 1e-5), reference::render(splats, c, rules));
}
/// The error of a value in the L2 norm of a frame, relative to the value, over the pixels that count.
template <class Counts>
double l2_error(reference::Derivative const& mine, reference::Derivative const& exact, std::uint32_t i, Counts const& counts)
{
    double error = 0, all = 0;
    for (std::uint32_t j = 0; j < 6; ++j)
        for (std::size_t k = 0; k < exact[j].size(); ++k)
            if (counts(k)) error += std::pow(mine[j][k].value(i) - exact[j][k].value(i), 2), all += std::pow(exact[j][k].value(i), 2);
    return std::sqrt(error / all);
}
/// A few Gaussians that are hard to differentiate: needles, discs, splats smaller than the dilation, opaque ones, means far off the axis,
/// close to the near plane, and behind the camera.
std::vector<Gaussian> hard_scene(std::uint64_t seed)
{
    support::Random random(seed);
    std::vector<Gaussian> out;
    for (std::uint32_t i = 0; i < 10; ++i) {
        Gaussian g{};
        std::uint32_t const kind = random.below(8);
        float const z = kind == 0 ? random.uniform(0.21f, 0.3f) : kind == 1 ? -random.uniform(0.1f, 2.0f) : random.uniform(0.5f, 4.0f);
        float const wide = kind == 2 ? 2.5f : 0.7f; // beyond the limit of the Jacobian's slopes
        g.mean_world[0] = random.uniform(-wide, wide) * std::fabs(z);
        g.mean_world[1] = random.uniform(-wide, wide) * std::fabs(z);
        g.mean_world[2] = z;
        for (float& c : g.colour) c = random.uniform(0, 1.5f);
        g.opacity = kind == 3 ? 1.0f : random.uniform(0.05f, 0.99f);
        for (float& q : g.rotation) q = random.uniform(-1, 1);
        for (float& s : g.log_scale) s = std::log(std::fabs(z)) + random.uniform(-3.0f, -0.5f);
        if (kind == 2) for (float& s : g.log_scale) s += 1; // reaches into the frame
        if (kind == 4) g.log_scale[0] += 1.0f, g.log_scale[1] -= 5, g.log_scale[2] -= 5;
        if (kind == 5) g.log_scale[0] -= 6;
        if (kind == 6) for (float& s : g.log_scale) s -= 4;
        if (kind == 7) g.log_scale[0] = -std::numeric_limits<float>::infinity();
        g.id = GaussianId{i + 1};
        out.push_back(g);
    }
    return out;
}
/// Without those whose Jacobian a step of the differences begins or ceases to clamp, or which such a step takes through the near plane.
std::vector<Gaussian> away_from_limits(std::vector<Gaussian> order, reference::Camera const& c, Rules const& m)
{
    std::erase_if(order, [&](Gaussian const& g) {
        reference::Splat s;
        reference::project(g, c, m, s);
        bool const at_limit = c.bent.lens.kind == LensKind::fisheye ? std::hypot(s.p[0], s.p[1]) < 1e-3 * s.z && s.p[2] < 0 // straight behind
                              : c.bent.lens.kind == LensKind::pinhole
                                  ? std::fabs(std::fabs(s.u / c.fx) - c.limit_x) < 1e-3 || std::fabs(std::fabs(s.v / c.fy) - c.limit_y) < 1e-3
                                  : std::hypot(s.p[0], s.p[1]) > (double{c.bent.lens.limit} - 1e-3) * s.p[2]; // beyond it the Jacobian does not move
        return at_limit || s.z < c.near_depth + 1e-4;
    });
    return order;
}
/// An ordinary cloud, front to back.
std::vector<Gaussian> plain_scene(std::uint64_t seed, reference::Camera const& c, Rules const& rules)
{
    auto order = support::cloud(30, seed);
    for (auto& g : order) g.colour[0] = std::min(g.colour[0], 1.0f);
    return away_from_limits(reference::sorted(order, c, rules), c, rules);
}
Camera small_lens()
{
    auto c = support::lens(16, 12, 0.1f);
    c.fy *= 1.1f; // so that a swap of fx and fy shows
    return c;
}
} // namespace

TEST_CASE("pose motion: it agrees with central differences in double on hard scenes, also through lenses of slopes, and in float with double")
{
    struct Row {
        char const* name;
        Lens lens;
        float limit;
        std::uint64_t seed;
    };
    for (Row const& row : {Row{"slopes to 1.3", {}, 1.3f, 1300},
                           {"slopes to 0.5", {}, 0.5f, 500},
                           {"all slopes", {}, 0, 0},
                           {"radial and tangential", {LensKind::opencv, {0.26f, -0.4f, 0.2f, 0, 0, 0}, {-0.0054f, 0.0026f}, 0, 0}, 1.3f, 0},
                           {"rational", {LensKind::opencv, {0.3f, -0.1f, 0.02f, 0.35f, -0.05f, 0.01f}, {0.001f, -0.002f}, 0, 0}, 1.3f, 0},
                           {"barrel", {LensKind::opencv, {-0.28f, 0.07f, 0, 0, 0, 0}, {}, 0, 0}, 1.3f, 0},
                           {"fov", {LensKind::fov, {0.93f}, {}, 0, 0}, 1.3f, 0},
                           {"fisheye", {LensKind::fisheye, {-0.02f, 0.01f, -0.002f, 0.0003f}, {}, 0, 0}, 1.3f, 0}}) {
        auto camera = small_lens();
        if (row.lens.kind == LensKind::fisheye) camera.fx *= 0.5f, camera.fy *= 0.5f; // it sees behind itself

        camera.lens = row.lens;
        auto rules = without_cuts();
        rules.jacobian_limit = row.limit;
        auto const view = make_view(camera, rules);
        auto const c = reference::camera_of(camera, rules);
        Errors errors;
        double most = 0;
        std::uint64_t scenes = 0;
        for (std::uint64_t seed = 1; seed <= (support::fast() ? 20u : 67u); ++seed) {
            auto const order = away_from_limits(reference::sorted(hard_scene(seed + row.seed), c, rules), c, rules);
            if (order.empty()) continue;
            ++scenes;
            compare(errors, order, c, view, rules);
            auto const cloud = plain_scene(seed, c, rules);
            auto const exact = by_templates(words_of(reference::projected(cloud, c, rules)), view), mine = by_templates(words_of(cloud, view), view);
            for (std::uint32_t i = 0; i < 4; ++i) most = std::max(most, l2_error(mine, exact, i, [](auto) { return true; }));
        }
        MESSAGE(std::string(row.name) << ": p50 " << errors.quantile(0.5) << ", p99 " << errors.quantile(0.99) << ", largest " << errors.most
                                      << " of " << errors.all.size() << "; float " << most);
        CHECK(scenes > 10);
        CHECK(errors.not_numbers == 0);
        CHECK(errors.quantile(0.99) < 1e-5);
        if (row.lens.kind == LensKind::pinhole) CHECK(errors.most < 1e-3);
        CHECK(most < 2e-5);
    }
}

TEST_CASE("pose motion: float is within 1e-5 of double in the L2 norm of a frame, and alpha_max stops the motion of a splat")
{
    auto const camera = small_lens();
    double most = 0;
    for (float clamp : {1.0f, 0.5f}) {
        auto rules = without_cuts();
        rules.alpha_max = clamp;
        auto const view = make_view(camera, rules);
        auto const c = reference::camera_of(camera, rules);
        for (std::uint64_t seed = 1; seed <= 20; ++seed) {
            auto const order = plain_scene(seed, c, rules);
            auto const splats = reference::projected(order, c, rules);
            auto const exact = by_templates(words_of(splats), view), mine = by_templates(words_of(order, view), view);
            auto const picture = reference::render(splats, c, rules);
            for (std::uint32_t i = 0; i < Pixel::values; ++i) // not the depth of a pixel that does not count
                most = std::max(most, l2_error(mine, exact, i, [&](std::size_t k) { return i != 4 || picture[k].transmittance <= 0.5; }));
            if (clamp < 1 && seed == 1) {
                Errors errors;
                compare(errors, order, c, view, rules);
                CHECK(errors.quantile(0.98) < 1e-5); // the others lie where a step crosses the clamp
            }
        }
    }
    MESSAGE("largest relative L2 error " << most);
    CHECK(most < 1e-5);
}

TEST_CASE("pose motion: no splat gives NaN or infinity")
{
    auto const camera = small_lens();
    support::Random random(5);
    std::uint32_t visible = 0;
    std::vector<Gaussian> all;
    for (float dilation : {0.3f, 0.0f}) {
        Rules rules = without_cuts();
        rules.dilation = dilation;
        auto const view = make_view(camera, rules);
        for (std::uint32_t i = 0; i < 20000; ++i) {
            auto g = hard_scene(i / 10 + 1)[i % 10];
            support::spoil(g, random, 6);
            all.push_back(g);
            for (auto const& s : words_of(std::vector<Gaussian>{g}, view)) {
                ++visible;
                for (auto const& m : motions_of(pose::detail::MotionBasis<F>(s.moving, view)))
                    for (float const v : {m.dx_1, m.off_1, m.dx_2, m.mixed, m.off_2}) REQUIRE(std::isfinite(v));
            }
        }
    }
    CHECK(visible > 1000);
    auto const view = make_view(camera, Rules{});
    for (std::uint32_t n : {0u, 1u, 15u, 16u, 17u, 40000u}) {
        std::vector<pose::Terms> terms(n + 1, pose::Terms{7, 7});
        pose::terms_of_all(all.data(), n, view, TileSize{16, 12}, terms.data());
        std::uint32_t different = 0;
        for (std::uint32_t i = 0; i < n; ++i) {
            auto const one = pose::terms_of(all[i], view, TileSize{16, 12});
            different += std::memcmp(&one, &terms[i], sizeof one) != 0 ? 1 : 0;
        }
        CHECK(different == 0);
        CHECK(terms[n].along_depth == 7);
    }
}

TEST_CASE("pose motion: a pair that does not take part changes nothing, however far its power moves")
{
    pose::MovingPixel<F> p{};
    p.t = 0.5f;
    for (float& d : p.dt) d = 0.25f;
    auto const before = p;
    pose::MovingPaint<F> const paint{{1, 1, 1}, 2, 1, 1, 1, true};
    auto const motion = [](auto) { return pose::PowerMotion<F>{1e30f, 1e30f, 1e30f, -1e30f, 1e30f}; };
    // Off the splat's reach the products overflow: infinity, or infinity minus infinity.
    pose::blend_moving_pair<true, F>(p, 0.5f, false, false, 1e12f, 1e12f, paint, motion, pose::AllMotions{});
    CHECK(std::memcmp(&p, &before, sizeof p) == 0);
    // Where alpha is clamped, the pair takes part and its power does not move.
    pose::blend_moving_pair<true, F>(p, 0.5f, true, false, 1e12f, 1e12f, paint, motion, pose::AllMotions{});
    CHECK(p.t == 0.25f);
    for (float const d : p.dt) CHECK(d == 0.125f);
    for (float const d : p.dz) CHECK(d == 0.25f);
}

namespace {
constexpr std::uint32_t most_splats = 64;
using Chunk = pose::detail::MovingChunk<most_splats>;
struct Blended {
    pose::MovingRow rows[block_height];
    Chunk chunk;
    pose::detail::OpenPart part;
    std::vector<std::uint32_t> hits;
    std::uint32_t contributing = 0;
};
/// A block at (16, 5) after all splats, with N lanes.
template <std::uint32_t N, class Stop>
Blended blended(std::vector<pose::PoseSplat> const& splats, View const& view)
{
    using Set = splat::detail::GivenSet<N>;
    Blended b;
    auto const n = splat::detail::fill(Set{}, b.chunk, 0, static_cast<std::uint32_t>(splats.size()),
                                                                [&](std::uint32_t i) -> Splat const& { return splats[i]; });
    REQUIRE(n == splats.size());
    for (std::uint32_t i = 0; i < most_splats; ++i) {
        auto const& terms = splats[i < n ? i : 0].terms;
        b.chunk.along_depth[i] = terms.along_depth, b.chunk.across_depth[i] = terms.across_depth;
    }
    Set::template call<pose::detail::CompleteMotions>(b.chunk, n, view);
    pose::detail::begin_part(b.part, b.rows, 16, 5, 0, PixelRect{18, 32, 5, 10}, view.camera); // two dead lanes
    b.hits.resize(most_splats + 16);
    b.hits.resize(Set::template call<splat::detail::ListHits>(b.chunk, n, b.part.at, b.hits.data()));
    for (std::uint32_t k = 0; k < block_height; ++k)
        b.contributing += Set::template call<pose::detail::BlendMovingRow<true, Stop>>(b.rows[k], b.chunk, b.hits.data(), static_cast<std::uint32_t>(b.hits.size()),
                                                                                     b.part.at, k, view.rules);
    return b;
}
} // namespace
TILEMESH_EXACT_BEGIN
namespace {
/// Blends one pair after the other into one pixel, and compares it with lane i of row k. Returns the fields that differ.
template <class Stop>
std::uint32_t different_fields(Blended const& b, std::uint32_t k, std::uint32_t i, Rules const& m)
{
    auto const& c = b.chunk;
    pose::MovingPixel<F> p{};
    p.t = 16 + i >= 18 ? 1.0f : -1.0f;
    for (auto const hit : b.hits) {
        std::uint32_t const s = hit & splat::detail::Hit::number;
        auto const column = static_cast<std::int32_t>(16 + i);
        bool const covered = column >= c.x0[s] && column < c.x1[s] &&
                             splat::detail::covered_rows.bits[(hit >> splat::detail::Hit::limits_at) * block_height + k] != 0;
        float const dx = b.part.at.xs[i] - c.mean_x[s], dy = b.part.at.ys[k] - c.mean_y[s], off = F::multiply_add(-c.slope[s], dx, dy);
        float const power = F::multiply_add(c.along[s] * dx, dx, c.across[s] * off * off);
        auto const e = splat::detail::exponential_lanes<4>(splat::detail::broadcast<4>(power), lowest_power_for(m.alpha_min));
        float const raw = c.opacity[s] * e[0], alpha = std::min(raw, m.alpha_max);
        bool takes_part = covered && alpha >= m.alpha_min && p.t >= m.transmittance_min;
        if (Stop::drops_crossing && takes_part && p.t - alpha * p.t < m.transmittance_min) p.t = -p.t, takes_part = false;
        pose::MovingPaint<F> const paint{{c.red[s], c.green[s], c.blue[s]}, c.depth[s], c.view_x[s], c.view_y[s], c.by_angle ? c.ahead[s] : 0.0f, c.by_angle};
        auto const motion = [&](auto j) {
            auto const& of = c.motion[decltype(j)::value];
            return pose::PowerMotion<F>{of[0][s], of[1][s], of[2][s], of[3][s], of[4][s]};
        };
        pose::blend_moving_pair<true, F>(p, alpha, takes_part, takes_part && !(raw > m.alpha_max), dx, off, paint, motion, pose::AllMotions{});
    }
    float fields[pose::MovingRow::fields] = {p.t, p.colour[0], p.colour[1], p.colour[2]};
    for (std::uint32_t j = 0; j < 6; ++j) {
        fields[4 + j] = p.dt[j], fields[31 + j] = p.dz[j];
        for (std::uint32_t v = 0; v < 3; ++v) fields[10 + 6 * v + j] = p.dcolour[v][j];
    }
    fields[28] = p.z, fields[29] = p.x, fields[30] = p.y, fields[37] = p.ahead;
    std::uint32_t different = 0;
    for (std::uint32_t f = 0; f < pose::MovingRow::fields; ++f) different += fields[f] == b.rows[k].field[f][i] ? 0 : 1;
    return different;
}
} // namespace
TILEMESH_EXACT_END

TEST_CASE("pose motion: rows of pixels have the bits of pairs that are blended one by one, for 2, 4, 8 and 16 lanes")
{
    auto const check = [](auto stop, std::uint32_t n, float alpha_max) {
        using Stop = decltype(stop);
        Rules rules;
        rules.alpha_max = alpha_max;
        auto const view = make_view(support::lens(48, 32), rules);
        std::vector<pose::PoseSplat> splats;
        for (auto g : support::cloud(400, n)) {
            for (float& s : g.log_scale) s = std::max(s, -1.3f); // so that many reach the block
            g.opacity = std::min(g.opacity, 0.4f);
            auto const s = pose::project(g, view, TileSize{48, 32});
            if (s.visible() && splats.size() < n) splats.push_back(s);
        }
        std::sort(splats.begin(), splats.end(), [](auto const& a, auto const& b) { return a.depth_key < b.depth_key; });
        REQUIRE(splats.size() == n);
        auto const b = blended<4, Stop>(splats, view);
        std::uint32_t different = 0;
        for (std::uint32_t k = 0; k < block_height; ++k)
            for (std::uint32_t i = 0; i < block_width; ++i) different += different_fields<Stop>(b, k, i, rules);
        CHECK(different == 0);
        if (n > 40) CHECK(b.hits.size() > 16); // more than are kept at once
        if (n > 1) CHECK(b.contributing > 5 * n / 2);
        for (auto const& other : {blended<2, Stop>(splats, view), blended<8, Stop>(splats, view), blended<16, Stop>(splats, view)}) {
            CHECK(std::memcmp(b.rows, other.rows, sizeof b.rows) == 0);
            CHECK(b.contributing == other.contributing);
        }
    };
    for (std::uint32_t n : {1u, 20u, 64u})
        for (float alpha_max : {0.99f, 0.2f}) {
            check(splat::detail::StopEachPixel{}, n, alpha_max);
            check(splat::detail::StopBeforeCrossing{}, n, alpha_max);
        }
}

TEST_CASE("pose motion: colour, transmittance and depth agree with central differences in double on whole maps")
{
    support::with_front_views([](std::string const& name, std::vector<Gaussian> const& map, Camera const& whole) {
        auto rules = without_cuts();
        rules.jacobian_limit = 0; // it depends on the frame's size, and these frames are windows of the picture
        reference::Derivative mine, truth;
        std::vector<Pixel> picture;
        double difference = 0, all = 0;
        for (std::uint32_t window = 0; window < (support::fast() ? 2u : 6u); ++window) {
            auto camera = whole;
            camera.width = 4, camera.height = 2;
            camera.cx -= static_cast<float>(whole.width) * (0.2f + 0.11f * static_cast<float>(window));
            camera.cy -= static_cast<float>(whole.height) * (0.7f - 0.09f * static_cast<float>(window));
            auto const view = make_view(camera, rules);
            auto const c = reference::camera_of(camera, rules);
            auto const order = away_from_limits(reference::sorted(map, c, rules), c, rules);
            auto const splats = reference::projected(order, c, rules);
            auto const own = by_templates(words_of(splats), view), of_float = by_templates(words_of(order, view), view);
            auto const differences = reference::central_differences(order, c, rules, 3e-6); // their own error is 1e-5 with 1e-5
            for (std::uint32_t j = 0; j < 6; ++j) {
                mine[j].insert(mine[j].end(), own[j].begin(), own[j].end());
                truth[j].insert(truth[j].end(), differences[j].begin(), differences[j].end());
                for (std::size_t k = 0; k < own[j].size(); ++k)
                    for (std::uint32_t i = 0; i < 3; ++i) {
                        double const e = of_float[j][k].value(i) - own[j][k].value(i);
                        difference += e * e, all += own[j][k].value(i) * own[j][k].value(i);
                    }
            }
            auto const pixels = reference::render(splats, c, rules);
            picture.insert(picture.end(), pixels.begin(), pixels.end());
        }
        Errors errors;
        errors.add(mine, truth, picture);
        MESSAGE(name << ": p50 " << errors.quantile(0.5) << ", p99 " << errors.quantile(0.99) << ", largest " << errors.most << " of " << errors.all.size() << "; float " << std::sqrt(difference / all));
        CHECK(errors.not_numbers == 0);
        CHECK(errors.quantile(0.99) < 1e-5);
        CHECK(errors.most < 1e-3);
        CHECK(std::sqrt(difference / all) < 1e-5);
    });
}
