// test: optimised, cost 8
// Exact rays: their rectangles hold what rays see, their words are those of double precision, and their pictures do not depend on the mesh.
#include "../report/stiff_scene.hpp"
#include "../standard.hpp"
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/report/exact_rays.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/lens.hpp>
#include <tilemesh/splat/exact.hpp>

namespace {

using namespace tilemesh;
using splat::Camera;
using splat::Gaussian;
using tests::StiffScene;

constexpr char const* lenses[] = {"pinhole",
                                  "opencv,0.2624,-0.9531,-0.0054,0.0026,1.1633",
                                  "opencv,0.3,-0.1,0.001,-0.002,0.02,0.35,-0.05,0.01",
                                  "fov,0.93",
                                  "fisheye,-0.02,0.01,-0.002,0.0003",
                                  "equirectangular"};
/// The camera with a lens; those that see all round see 230 and 360 degrees from side to side.
Camera through(char const* lens, Camera c)
{
    c.lens = scene::lens_of_text(lens);
    float const width = static_cast<float>(c.width);
    if (c.lens.kind == splat::LensKind::fisheye) c.fx = c.fy = width / 4;
    if (c.lens.kind == splat::LensKind::equirectangular) c.fx = c.fy = width / 6.2831853f, c.cx = width / 2, c.cy = static_cast<float>(c.height) / 2;
    scene::check_camera(c);
    return c;
}
/// A ray as pixels have it: z = 1, or length 1.
bool ray_at(Camera const& c, std::uint32_t x, std::uint32_t y, std::array<double, 3>& ray)
{
    double d[3];
    if (!splat::ray_of<double>(c, x + 0.5 - double{c.cx}, y + 0.5 - double{c.cy}, d)) return false;
    double const size = splat::sees_behind(c.lens.kind) ? std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) : d[2];
    for (std::size_t k = 0; k < 3; ++k) ray[k] = d[k] / size;
    return true;
}
/// The power that a splat's words give, and how far in front of the camera (above 0) the nearest point is.
double power_of(splat::ExactSplat const& s, std::array<double, 3> const& ray, double& ahead)
{
    double first = 0, second = 0, depth = 1;
    for (std::size_t k = 0; k < 3; ++k) {
        double const d = ray[k] - double{s.towards[k]};
        first += d * double{s.first[k]}, second += d * double{s.second[k]}, depth += d * double{s.depth[k]};
    }
    ahead = depth;
    double const q = first * first + second * second;
    return -q / (depth * depth + double{s.spread} * q);
}

struct Found {
    std::uint64_t outside = 0, boxes = 0, needed = 0, splats = 0;
    double worst = 0;
};
/// Compares every splat of a scene at every pixel with double precision.
void look(Found& found, StiffScene<Gaussian> const& s, char const* lens)
{
    auto const camera = through(lens, s.c);
    auto const view = splat::make_view(camera, s.rules);
    splat::TileSize const tile{16, 16};
    struct Ray {
        std::uint32_t x, y;
        std::array<double, 3> to;
    };
    std::vector<Ray> rays;
    for (std::uint32_t y = 0; y < camera.height; ++y)
        for (std::uint32_t x = 0; x < camera.width; ++x)
            if (Ray ray{x, y, {}}; ray_at(view.camera, x, y, ray.to)) rays.push_back(ray);
    for (auto const& g : s.records) {
        report::detail::RayGaussian exact;
        double const alpha_min = double{s.rules.alpha_min};
        if (!report::detail::before_rays(g, view.camera, s.rules, alpha_min, exact)) continue;
        if (std::fabs(exact.depth - double{view.camera.near_depth}) < 1e-5) continue; // either may be right
        auto const e = splat::project_exact(g, view, tile);
        auto const rect = e.rect();
        found.splats += e.visible() ? 1 : 0;
        found.boxes += e.visible() ? std::uint64_t{rect.x1 - rect.x0} * (rect.y1 - rect.y0) : 0;
        for (auto const& [x, y, ray] : rays) {
            auto const d = report::detail::times(exact.whitening, ray), away = report::detail::cross(exact.mean, d);
            if (!(report::detail::dot(exact.mean, d) > 0)) continue;
            double const squared = report::detail::dot(away, away) / report::detail::dot(d, d), alpha = exact.opacity * std::exp(-0.5 * squared);
            if (!(alpha > alpha_min * 1.00005)) continue;
            ++found.needed;
            bool const inside = e.visible() && x >= rect.x0 && x < rect.x1 && y >= rect.y0 && y < rect.y1;
            found.outside += inside ? 0 : 1;
            if (!inside) continue;
            double ahead = 0;
            double const own = double{e.opacity} * std::exp(power_of(e, ray, ahead));
            if (std::fabs(ahead) < 1e-4) continue; // the nearest point is beside the camera: one rounding says whether it is before it
            found.worst = std::max(found.worst, ahead > 0 ? std::fabs(own - alpha) : 1.0);
        }
    }
}

TEST_CASE("a rectangle holds every pixel whose ray has an alpha of alpha_min: needles, huge and near Gaussians, through every lens")
{
    for (std::string const lens : lenses) {
        CAPTURE(lens);
        Found found;
        for (std::uint32_t n = 0; n < (tests::fast() ? 12 : 120); ++n) look(found, StiffScene<Gaussian>(n), lens.c_str());
        CHECK(found.outside == 0);
        CHECK(found.needed > 10'000);
        CHECK(found.worst < 5e-5);
        CHECK(found.boxes < 5 * found.needed); // a rectangle that is all of the picture would hold them, too
        MESSAGE(lens << ": " << found.splats << " splats, " << found.boxes << " pixels of rectangles for " << found.needed
                     << ", largest error of alpha " << found.worst);
    }
}

TEST_CASE("rays in lanes have the bits of one float, and point where those of double precision do")
{
    using splat::detail::FloatLanes;
    using splat::detail::OneFloat;
    for (std::string const lens : lenses) {
        CAPTURE(lens);
        auto const c = splat::make_view(through(lens.c_str(), scene::built_in_camera({320, 240})), {}).camera;
        double worst = 0;
        std::uint32_t other = 0, unlike = 0;
        for (std::uint32_t y = 0; y < c.height; y += 3)
            for (std::uint32_t x = 0; x < c.width; x += 8) {
                float const v = (static_cast<float>(y) + 0.5f - c.cy) / c.fy;
                splat::detail::Floats<8> u, same; // `broadcast` returns lanes: another ABI without AVX
                for (std::uint32_t i = 0; i < 8; ++i) u[i] = (static_cast<float>(x + i) + 0.5f - c.cx) / c.fx, same[i] = v;
                splat::detail::LensRay<FloatLanes<8>> const all(c, u, same);
                for (std::uint32_t i = 0; i < 8; ++i) {
                    splat::detail::LensRay<OneFloat> const one(c, u[i], v);
                    float const lane[3] = {all.ray.x[i], all.ray.y[i], all.ray.z[i]}, own[3] = {one.ray.x, one.ray.y, one.ray.z};
                    other += (all.seen[i] != 0) != one.seen || std::memcmp(lane, own, sizeof own) != 0 ? 1 : 0;
                    std::array<double, 3> exact;
                    bool const seen = ray_at(c, x + i, y, exact);
                    unlike += seen != one.seen ? 1 : 0;
                    for (std::size_t k = 0; k < 3 && seen && one.seen; ++k) worst = std::max(worst, std::fabs(double{own[k]} - exact[k]));
                }
            }
        CHECK(other == 0);
        CHECK(unlike <= 2); // pixels at the border of what the lens sees
        CHECK(worst < 2e-6);
    }
}

/// Tiles with room for the built-in map.
struct Roomy : splat::Exact {
    using Machine = splat::RoomyMachine;
};
RendererOptions roomy(std::uint32_t tile_width, std::uint32_t tile_height, unsigned threads)
{
    RendererOptions options{.threads = threads};
    options.tile = {tile_width, tile_height};
    options.sizes = splat::Exact::sizes, options.sizes->storage = 45'000, options.sizes->tile_pixels = 48 * 32;
    return options;
}

TEST_CASE("the mesh's picture is that of double precision, with equal bits over tilings, threads and engines")
{
    auto const map = scene::built_in_map();
    for (std::string const lens : {"pinhole", "fisheye,-0.02,0.01", "equirectangular"}) {
        CAPTURE(lens);
        auto const camera = through(lens.c_str(), scene::built_in_camera({96, 64}));
        BasicRenderer<Roomy> one(map, roomy(32, 20, 1)), other(map, roomy(17, 13, 2));
        auto const picture = one.render(camera);
        CHECK(picture.report.lost.empty());
        CHECK(picture.image.rgb == other.render(camera).image.rgb);
        CHECK(picture.depth.values == other.render(camera).depth.values);
        auto moved = camera;
        moved.position[0] += 0.3f;
        (void)other.render(moved);
        CHECK(picture.image.rgb == other.render(camera).image.rgb); // as before a step and back
        auto exact = report::render_exact_rays(map.gaussians, camera, one.rules(), 2);
        double sum = 0;
        for (std::size_t i = 0; i < exact.rgb.size(); ++i) {
            double const off = std::isnan(exact.rgb[i]) ? 0.0 : double{exact.rgb[i]} - double{picture.image.rgb[i]};
            sum += off * off;
        }
        double const psnr = -10 * std::log10(sum / static_cast<double>(exact.rgb.size()));
        CHECK(psnr > 75); // splats of nearly equal depths may change places
        MESSAGE(lens << ": " << psnr << " dB");
        if (tests::fast()) continue;
        BasicRenderer<Roomy, CheckedMesh> checked(map, roomy(48, 32, 1));
        CHECK(picture.image.rgb == checked.render(camera).image.rgb);
    }
}

/// A shell of Gaussians all round the camera, with a colour that follows the direction.
scene::Map shell()
{
    scene::Map map;
    tests::Random random(5);
    for (std::uint32_t i = 0; i < 4000; ++i) {
        Gaussian g{};
        float d[3], length = 0;
        for (float& v : d) v = random.uniform(-1, 1), length += v * v;
        if (length < 0.01f || length > 1) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            g.mean_world[k] = (2 + 0.0005f * static_cast<float>(i)) * d[k] / std::sqrt(length), g.colour[k] = 0.5f + 0.4f * d[k] / std::sqrt(length);
            g.log_scale[k] = -1.2f;
        }
        g.rotation[0] = 1, g.opacity = 0.9f, g.id = splat::GaussianId{i + 1};
        map.gaussians.push_back(g);
    }
    return map;
}

TEST_CASE("a panorama has no seam and no hole at its poles, and turns with its camera")
{
    auto const map = shell();
    auto camera = through("equirectangular", scene::built_in_camera({128, 64}));
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) camera.rotation[i][k] = i == k ? 1.0f : 0.0f;
    for (float& v : camera.position) v = 0;
    camera.near_depth = 0.1f;
    BasicRenderer<Roomy> renderer(map, roomy(32, 20, 2));
    auto const before = renderer.render(camera);
    float least = 1, step = 0;
    for (float const alpha : before.alpha.values) least = std::min(least, alpha);
    CHECK(least > 0.99f); // no hole
    auto const at = [](RenderedFrame const& f, std::uint32_t x, std::uint32_t y, std::uint32_t k) { return f.image.rgb[3 * (128 * y + x) + k]; };
    for (std::uint32_t y = 0; y < 64; ++y)
        for (std::uint32_t k = 0; k < 3; ++k) step = std::max(step, std::fabs(at(before, 0, y, k) - at(before, 127, y, k)));
    CHECK(step < 0.06f); // neighbours within the picture differ as much
    // A quarter of a turn around the vertical axis: x becomes -z.
    auto turned = camera;
    float const quarter[3][3] = {{0, 0, -1}, {0, 1, 0}, {1, 0, 0}};
    std::memcpy(turned.rotation, quarter, sizeof quarter);
    auto const after = renderer.render(turned);
    double worst = 0;
    for (std::uint32_t y = 0; y < 64; ++y)
        for (std::uint32_t x = 0; x < 128; ++x)
            for (std::uint32_t k = 0; k < 3; ++k)
                worst = std::max(worst, std::fabs(double{at(after, x, y, k)} - double{at(before, (x + 32) % 128, y, k)}));
    CHECK(worst < 1e-4);
}

TEST_CASE("programs that draw conics refuse a panorama, with a sentence")
{
    auto const camera = through("equirectangular", scene::built_in_camera({96, 64}));
    auto const said = tests::error_of([&] { (void)Renderer{scene::built_in_map()}.render(camera); });
    CHECK(said == "a panorama (this program of the tiles takes a Gaussian for a conic, which it is neither at a pole nor on both sides of the seam); "
                  "render it by exact rays: render_map --exact-rays, or splat::Exact");
    auto const other = tests::error_of([&] { (void)Renderer{scene::built_in_map(), {.program = report::Program::homes}}.render(camera); });
    CHECK(other.substr(0, 12) == "a panorama (");
    auto rolling = scene::built_in_camera({96, 64});
    rolling.shutter.turn[1] = 0.01f;
    auto const rays = tests::error_of([&] { (void)BasicRenderer<Roomy>(scene::built_in_map(), roomy(32, 20, 1)).render(rolling); });
    CHECK(rays.substr(0, 62) == "a camera with a rolling shutter (a program of exact rays takes");
}

TEST_CASE("what cannot be drawn is invisible: behind the near plane, too faint, not finite, a size of zero without dilation")
{
    auto const camera = scene::built_in_camera({96, 64});
    splat::Rules rules;
    Gaussian good{};
    for (std::size_t k = 0; k < 3; ++k) good.mean_world[k] = camera.position[k] + 2 * camera.rotation[2][k], good.log_scale[k] = -2;
    good.rotation[0] = 1, good.opacity = 0.5f;
    auto const visible = [&](Gaussian const& g) { return splat::project_exact(g, splat::make_view(camera, rules), {16, 16}).visible(); };
    CHECK(visible(good));
    float const nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    auto const with = [&](auto const& change) {
        auto g = good;
        change(g);
        return visible(g);
    };
    CHECK_FALSE(with([&](Gaussian& g) {
        for (std::size_t k = 0; k < 3; ++k) g.mean_world[k] = camera.position[k] - camera.rotation[2][k];
    }));
    CHECK_FALSE(with([&](Gaussian& g) { g.opacity = 0.003f; }));
    for (float const v : {nan, infinity, -infinity}) {
        CHECK_FALSE(with([&](Gaussian& g) { g.mean_world[1] = v; }));
        CHECK_FALSE(with([&](Gaussian& g) { g.colour[1] = v; }));
        CHECK(with([&](Gaussian& g) { g.log_scale[1] = v; }) == (v == -infinity)); // a disc
        CHECK_FALSE(with([&](Gaussian& g) { g.rotation[1] = v; }));
    }
    rules.dilation = 0;
    CHECK_FALSE(with([&](Gaussian& g) {
        for (float& v : g.log_scale) v = -infinity;
    }));
    CHECK(with([&](Gaussian& g) {
        for (float& v : g.log_scale) v = 80;
    })); // it fills the picture
}

} // namespace
