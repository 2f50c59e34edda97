// test: unoptimised test asan, cost 8
// A window of a picture is the window of its picture, bit for bit: crops, stereo and off-axis views. And `Coverage::preserved`, the rule of
// trainers with anti-aliasing.
#include "runner.hpp"
#include <tilemesh/render/homes_renderer.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/splat/footprint.hpp>
#include <tilemesh/splat/quality.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;
using support::make_runner;

TILEMESH_EXACT_BEGIN
namespace {

/// Large splats, of which many lie far outside the picture and reach into it, so that their slopes are bounded.
std::vector<Gaussian> wide_cloud(std::uint32_t n, std::uint64_t seed)
{
    auto all = support::cloud(n, seed);
    for (auto& g : all) {
        g.mean_world[0] *= 2.5f;
        g.mean_world[1] *= 2.5f;
        for (float& s : g.log_scale) s = std::min(s + 2.0f, 0.0f);
    }
    return all;
}
/// A camera whose principal point is a multiple of 1/8 pixel, anywhere in the picture or beside it.
Camera any_camera(support::Random& random)
{
    auto camera = support::lens(40 + random.below(60), 30 + random.below(40), random.uniform(-0.4f, 0.4f));
    auto const place = [&](std::uint32_t size) { return 0.125f * static_cast<float>(random.below(16 * size)) - 0.5f * static_cast<float>(size); };
    camera.cx = place(camera.width);
    camera.cy = place(camera.height);
    camera.fy = camera.fx * random.uniform(0.7f, 1.4f);
    return camera;
}
PixelRect any_window(Camera const& c, support::Random& random)
{
    std::uint32_t const x0 = random.below(c.width), y0 = random.below(c.height);
    return {x0, x0 + 1 + random.below(c.width - x0), y0, y0 + 1 + random.below(c.height - y0)};
}
/// The pixels of `part` that differ from those of the window of `whole`.
std::uint64_t differing(report::Image const& part, report::Image const& whole, PixelRect const& window)
{
    REQUIRE(part.width == window.x1 - window.x0);
    REQUIRE(part.height == window.y1 - window.y0);
    std::uint64_t n = 0;
    for (std::uint32_t y = 0; y < part.height; ++y)
        for (std::uint32_t x = 0; x < part.width; ++x)
            n += std::memcmp(part.pixel(x, y), whole.pixel(window.x0 + x, window.y0 + y), 3 * sizeof(float)) != 0 ? 1 : 0;
    return n;
}
/// Records whose slope the picture's rule bounds and that show something.
std::uint32_t bounded(std::vector<Gaussian> const& all, Camera const& camera)
{
    auto const view = make_view(camera, {});
    auto free = view;
    free.rules.slope_limit[0] = free.rules.slope_limit[1] = 1e30f;
    TileSize const tile{camera.width, camera.height};
    return static_cast<std::uint32_t>(std::count_if(all.begin(), all.end(), [&](Gaussian const& g) {
        auto const a = project(g, view, tile), b = project(g, free, tile);
        return a.visible() && std::memcmp(&a, &b, sizeof a) != 0;
    }));
}
std::unique_ptr<render::Core> homes_of(std::vector<Gaussian> const& all, RendererOptions const& options)
{
    auto choice = splat::homes_setup;
    choice.machine.sram_bytes = 1u << 24;
    choice.fit = true;
    return render::make_core(support::map_of(all), choice, options);
}

} // namespace

TEST_CASE("any window of any picture has the bits of the picture")
{
    support::Random random(7);
    std::uint64_t lit = 0;
    std::uint32_t bounds = 0;
    for (std::uint32_t i = 0; i < (support::fast() ? 12u : 60u); ++i) {
        auto const all = wide_cloud(120, 100 + i);
        auto const camera = any_camera(random);
        bounds += bounded(all, camera);
        auto const whole = report::render_naive(all, camera, {});
        for (float const v : whole.rgb) lit += v > 0 ? 1 : 0;
        auto const rules = bounds_of(camera, {});
        for (std::uint32_t k = 0; k < 5; ++k) {
            auto const window = any_window(camera, random);
            INFO("picture ", i, ", window ", window.x0, " ", window.x1, " ", window.y0, " ", window.y1);
            CHECK(differing(report::render_naive(all, window_of(camera, window), rules), whole, window) == 0);
        }
    }
    CHECK(lit > (support::fast() ? 2000u : 10'000u));
    CHECK(bounds > (support::fast() ? 20u : 100u));
}

TEST_CASE("a window that keeps the farther borders needs nothing but its camera: crops of a camera file, both programs, and the reference")
{
    auto const all = wide_cloud(300, 5);
    auto camera = support::lens(96, 60);
    camera.cx = 40, camera.cy = 28; // the farther borders are right and below
    auto const whole = report::render_naive(all, camera, {});
    RendererOptions const options{.threads = 2, .grid = {4, 3}, .arithmetic = Arithmetic::precise};
    auto const anchored = make_runner<Referenced<support::Whole>>(support::map_of(all), options);
    auto const homes = homes_of(all, options);
    auto const in_double = report::render_double_unrounded(std::span<Gaussian const>(all), camera, {}, report::Cuts::same);
    for (PixelRect const window : {PixelRect{72, 96, 40, 60}, PixelRect{1, 96, 7, 60}, PixelRect{95, 96, 59, 60}}) {
        auto const part = window_of(camera, window);
        CHECK(differing(report::render_naive(all, part, {}), whole, window) == 0);
        CHECK(differing(anchored->render(part).image, whole, window) == 0);
        CHECK(differing(homes->render(part).image, whole, window) == 0);
        auto const also_in_double = report::render_double_unrounded(std::span<Gaussian const>(all), part, {}, report::Cuts::same);
        double most = 0;
        for (std::size_t y = 0; y < part.height; ++y)
            for (std::size_t x = 0; x < 3 * std::size_t{part.width}; ++x)
                most = std::max(most, std::fabs(also_in_double[3 * y * part.width + x] - in_double[3 * ((window.y0 + y) * camera.width + window.x0) + x]));
        CHECK(most < 1e-12);
    }
    // A window in the middle does not know the picture's borders, so it takes the picture's bounds.
    PixelRect const middle{30, 50, 20, 40};
    CHECK(differing(report::render_naive(all, window_of(camera, middle), {}), whole, middle) > 0);
    anchored->rules() = bounds_of(camera, anchored->rules());
    homes->rules() = bounds_of(camera, homes->rules());
    CHECK(differing(anchored->render(window_of(camera, middle)).image, whole, middle) == 0);
    CHECK(differing(homes->render(window_of(camera, middle)).image, whole, middle) == 0);
}

TEST_CASE("the bounds of slopes: the farther border; the trainers' half width; none; those that are told")
{
    auto camera = support::lens(100, 80);
    camera.fx = camera.fy = 50;
    auto const limits = [&](float cx, float cy, Rules const& rules) {
        camera.cx = cx, camera.cy = cy;
        auto const& l = make_view(camera, rules).rules.slope_limit;
        return std::pair(l[0], l[1]);
    };
    CHECK(limits(50, 40, {}) == std::pair(1.3f, 1.04f));
    CHECK(limits(50, 40, {}) == limits(50, 40, with_quality({}, Quality::training)));
    CHECK(limits(25, 60, {}) == std::pair(1.95f, 1.56f));
    CHECK(limits(75, 20, {}) == std::pair(1.95f, 1.56f));
    CHECK(limits(-100, 40, {}) == std::pair(5.2f, 1.04f));
    CHECK(limits(25, 60, with_quality({}, Quality::training)) == std::pair(1.3f, 1.04f));
    Rules rules;
    rules.jacobian_limit = 0;
    CHECK(limits(50, 40, rules).first > 1e25f);
    rules.slope_limit[0] = 0.25f;
    CHECK(limits(50, 40, rules).first == 0.25f);
    CHECK(limits(50, 40, rules).second > 1e25f);
    auto const picture = bounds_of(camera, {});
    CHECK(limits(3, 4, picture) == std::pair(picture.slope_limit[0], picture.slope_limit[1]));
}

TEST_CASE("coverage: what is smaller than a pixel keeps its light; what is large keeps its opacity")
{
    auto camera = support::flat_camera(64, 64);
    Rules rules;
    rules.alpha_min = 1e-6f;
    auto const light = [&](float sigma, Rules const& r) {
        auto g = support::ball(1, 32.3f, 31.8f, sigma, 0.01f); // so faint that nothing hides anything
        for (float& c : g.colour) c = 1;
        auto const image = report::render_naive(std::vector{g}, camera, r);
        double sum = 0;
        for (float const v : image.rgb) sum += double{v} / 3;
        return sum;
    };
    constexpr double two_pi = 6.283185307179586;
    for (float const sigma : {0.1f, 0.3f, 1.0f, 4.0f}) {
        auto preserved = rules;
        preserved.coverage = Coverage::preserved;
        double const own = two_pi * double{sigma} * double{sigma} * 0.01;
        INFO("sigma ", sigma);
        CHECK(light(sigma, preserved) == doctest::Approx(own).epsilon(0.02));
        CHECK(light(sigma, rules) == doctest::Approx(own * (1 + 0.3 / (double{sigma} * double{sigma}))).epsilon(0.02));
    }
    // A dimmed splat is that of a fainter record, footprint and all.
    auto dimmed = rules;
    dimmed.coverage = Coverage::preserved;
    TileSize const whole{64, 64};
    auto fainter = support::ball(1, 32.3f, 31.8f, 0.4f, 0.8f);
    auto const by_rule = project(fainter, make_view(camera, dimmed), whole);
    fainter.opacity = by_rule.opacity;
    CHECK(fainter.opacity < 0.3f);
    auto const by_record = project(fainter, make_view(camera, rules), whole);
    CHECK(std::memcmp(&by_rule, &by_record, sizeof by_rule) == 0);
    rules.coverage = Coverage::preserved; // a splat of no size has the bound's share: sqrt(0.000025) = 0.005
    auto point = support::ball(1, 32.5f, 32.5f, 1e-6f, 1);
    auto const s = project(point, make_view(camera, rules), {64, 64});
    CHECK(s.visible());
    CHECK(s.opacity == doctest::Approx(0.005).epsilon(1e-5));
    rules.alpha_min = 1.0f / 255; // then it is too faint, although its record is opaque
    CHECK(project(point, make_view(camera, rules), {64, 64}).visible()); // 0.005 is above 1/255
    point.opacity = 0.7f;
    CHECK_FALSE(project(point, make_view(camera, rules), {64, 64}).visible());
}

TEST_CASE("coverage: kernels, both programs and the naive picture have the same bits, and agree with double")
{
    auto const all = support::cloud(300, 17);
    auto const camera = support::lens(96, 64, 0.1f);
    RendererOptions const options{.threads = 2, .grid = {4, 3}, .arithmetic = Arithmetic::precise, .coverage = Coverage::preserved};
    auto const rules = with_options({}, options);
    auto const naive = report::render_naive(all, camera, rules);
    CHECK(support::differing_pixels(naive, report::render_naive(all, camera, {})) > 1000);
    auto const anchored = make_runner<Referenced<support::Whole>>(support::map_of(all), options);
    CHECK(support::differing_pixels(anchored->render(camera).image, naive) == 0);
    CHECK(support::differing_pixels(homes_of(all, options)->render(camera).image, naive) == 0);
    auto const reference = report::render_double_unrounded(std::span<Gaussian const>(all), camera, rules, report::Cuts::same);
    double sum = 0;
    for (std::size_t i = 0; i < reference.size(); ++i) sum += (reference[i] - double{naive.rgb[i]}) * (reference[i] - double{naive.rgb[i]});
    CHECK(-10 * std::log10(sum / static_cast<double>(reference.size())) > 90);
}
TILEMESH_EXACT_END
