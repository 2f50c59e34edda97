// test: unoptimised test, without test asan tsan
// Depth and alpha: correct if the setup has them, absent otherwise.
#include "runner.hpp"
#include <tilemesh/report/reference_double.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;

namespace {
using Both = support::Planes;
using Depth = Referenced<WithPixel<support::Whole, WithDepth<FloatPixel>>>;
using Alpha = Referenced<WithPixel<support::Whole, WithAlpha<FloatPixel>>>;

template <class S, template <class, class> class Engine = PortMesh>
RenderedFrame on_mesh(std::vector<Gaussian> const& gaussians, Camera const& camera, RendererOptions options = {.grid = {1, 1}})
{
    options.sizes = support::sized<support::Whole>(50, 500);
    return support::make_runner<S, Engine>(support::map_of(gaussians), options)->render(camera);
}

/// The same Gaussians, with their view depth as red and 1 as green: a picture of them holds sum(w z) and sum(w).
std::vector<Gaussian> painted_with_depth(std::vector<Gaussian> gaussians, Camera const& camera)
{
    for (auto& g : gaussians) {
        auto const s = project(g, make_view(camera, {}), make_tiling(camera.width, camera.height, camera.width, camera.height));
        g.colour[0] = s.depth();
        g.colour[1] = 1;
    }
    return gaussians;
}

template <class S>
std::uint32_t framebuffer_bytes()
{
    for (machine::Region const& r : Tile<typename S::Machine, Frame<S>, S>::ledger())
        if (std::string(r.name.text, r.name.size) == "framebuffer") return r.bytes;
    return 0;
}
} // namespace

TEST_CASE("planes: on Mk2 a tile keeps the requested planes, and storage gives up the slots that they need")
{
    using One = WithPixel<Lossless, WithDepth<FloatPixel>>;
    using Two = WithPixel<Lossless, WithAlpha<WithDepth<FloatPixel>>>;
    CHECK(framebuffer_bytes<One>() - framebuffer_bytes<Lossless>() == 4 * 640);
    CHECK(framebuffer_bytes<Two>() - framebuffer_bytes<Lossless>() == 8 * 640);
    CHECK(Lossless::sizes.storage - One::sizes.storage == 7);
    CHECK(Lossless::sizes.storage - Two::sizes.storage == 26);
    CHECK(WithPixel<Lossless, FloatPixel>::sizes == Lossless::sizes);
    CHECK(WithPixel<Paper, WithDepth<Rgbx8Pixel>>::sizes == Paper::sizes); // its ledger has room
    CHECK(Tile<Mk2, Frame<Two>, Two>::bytes <= Mk2::sram_bytes);
    CHECK(Tile<Mk2, Frame<Two>, Two>::bytes + 136 > Mk2::sram_bytes); // it gives up no more slots than necessary
    using Same = WithPixel<Lossless, FloatPixel>;
    CHECK(Tile<Mk2, Frame<Same>, Same>::bytes == Tile<Mk2, Frame<Lossless>, Lossless>::bytes);
}

TEST_CASE("planes: one surface has its own depth in every pixel that sees it, and 0 elsewhere")
{
    auto camera = support::flat_camera(64, 48);
    camera.cx = camera.cy = 20.5f;
    auto const frame = on_mesh<Both>({support::ball(1, 0, 0, 3, 0.75f)}, camera);
    CHECK(frame.depth.at(20, 20) == 1000.0f);
    CHECK(frame.alpha.at(20, 20) == 0.75f);
    std::uint32_t seen = 0;
    for (std::uint32_t y = 0; y < 48; ++y)
        for (std::uint32_t x = 0; x < 64; ++x) {
            bool const sees = frame.image.pixel(x, y)[1] > 0;
            CHECK(frame.alpha.at(x, y) >= (sees ? 1.0f / 255 : 0.0f));
            CHECK((frame.alpha.at(x, y) > 0) == sees);
            CHECK(frame.depth.at(x, y) == doctest::Approx(sees ? 1000.0 : 0.0).epsilon(3e-7));
            seen += sees;
        }
    CHECK(seen > 100);
    CHECK(seen < 1000);
}

TEST_CASE("planes: two layers mix by their weights")
{
    auto camera = support::flat_camera(20, 20);
    camera.cx = camera.cy = 10.5f;
    auto near = support::ball(1, 0, 0, 3, 0.5f), far = support::ball(2, 0, 0, 3, 0.5f);
    near.mean_world[2] = 500;
    auto const frame = on_mesh<Both>({near, far}, camera);
    CHECK(frame.alpha.at(10, 10) == 0.75f);                                          // 1/2 and half of the rest
    CHECK(frame.depth.at(10, 10) == doctest::Approx((0.5 * 500 + 0.25 * 1000) / 0.75).epsilon(3e-7));
}

TEST_CASE("planes: bit-equal to the naive loop's sums over every tiling and engine, and the colours do not change")
{
    auto const camera = support::lens(67, 41);
    auto const gaussians = support::cloud(250, 171);
    auto const naive = report::render_naive(gaussians, camera, Rules{});
    auto const sums = report::render_naive(painted_with_depth(gaussians, camera), camera, Rules{});
    auto const first = on_mesh<Both>(gaussians, camera);
    std::uint32_t wrong = 0;
    for (std::uint32_t y = 0; y < camera.height; ++y)
        for (std::uint32_t x = 0; x < camera.width; ++x) {
            float const* const s = sums.pixel(x, y);
            wrong += first.depth.at(x, y) != (s[1] > 0 ? s[0] / s[1] : 0.0f);
        }
    CHECK(wrong == 0);
    auto const same = [&](RenderedFrame const& frame) {
        CHECK(support::differing_pixels(frame.image, naive) == 0);
        if (!frame.depth.empty()) CHECK(frame.depth.values == first.depth.values);
        if (!frame.alpha.empty()) CHECK(frame.alpha.values == first.alpha.values);
    };
    for (Extent2 tile : {Extent2{67, 41}, {16, 20}, {7, 13}, {1, 4}}) same(on_mesh<Both>(gaussians, camera, {.tile = tile}));
    same(on_mesh<Both>(gaussians, camera, {.threads = 3, .tile = {9, 9}}));
    same(on_mesh<Both, CheckedMesh>(gaussians, camera, {.tile = {20, 20}}));
    auto const depth = on_mesh<Depth>(gaussians, camera), alpha = on_mesh<Alpha>(gaussians, camera);
    same(depth);
    same(alpha);
    CHECK(depth.alpha.empty());
    CHECK(alpha.depth.empty());
    auto const neither = on_mesh<support::Whole>(gaussians, camera);
    CHECK(neither.depth.empty());
    CHECK(neither.alpha.empty());
}

TEST_CASE("planes: against double, with the same cut-offs")
{
    auto const camera = support::lens(120, 80);
    auto const gaussians = support::cloud(400, 172);
    auto const sums = report::render_double_unrounded(painted_with_depth(gaussians, camera), camera, Rules{}, report::Cuts::same);
    auto const frame = on_mesh<Both>(gaussians, camera);
    // A term at a threshold may be in one sum and not in the other: 1/255 of weight, for depths from 1 to 3.75.
    double largest_alpha = 0, largest_depth = 0;
    std::uint32_t far_off = 0;
    for (std::size_t i = 0; i < frame.depth.values.size(); ++i) {
        double const weight = sums[3 * i + 1];
        double const a = std::abs(frame.alpha.values[i] - weight);
        largest_alpha = std::max(largest_alpha, a);
        if (weight < 0.1) continue;
        double const d = std::abs(frame.depth.values[i] - sums[3 * i] / weight);
        largest_depth = std::max(largest_depth, d);
        far_off += a > 1e-5 || d > 1e-4;
    }
    CHECK(largest_alpha < 1.0 / 255 + 1e-5);
    CHECK(largest_depth < 0.1);
    CHECK(far_off < frame.depth.values.size() / 500);
}

TEST_CASE("planes: a depth beyond the range of float is not drawn, and spoils no pixel")
{
    // Along the view direction the far mean is at infinity in float, but its direction is finite.
    auto camera = support::lens(64, 48);
    float const third = 0.57735027f, half = 0.70710678f, sixth = 0.40824829f;
    float const rows[3][3] = {{half, -half, 0}, {sixth, sixth, -2 * sixth}, {third, third, third}};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) camera.rotation[i][j] = rows[i][j];
    auto gaussians = support::cloud(3, 174);
    float const places[3][3] = {{1, 1, 1}, {1.5f, 1.2f, 1.3f}, {2.5e38f, 2.5e38f, 2.5e38f}};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) gaussians[i].mean_world[j] = places[i][j], gaussians[i].log_scale[j] = -2;
    for (auto& g : gaussians) g.opacity = 0.9f;
    auto const frame = on_mesh<Both>(gaussians, camera);
    std::size_t seen = 0;
    for (float d : frame.depth.values) {
        CHECK(d >= 0.0f);
        CHECK(d < 10.0f);
        seen += d > 0;
    }
    CHECK(seen > 10);
}

TEST_CASE("planes: with the paper's pixels too")
{
    auto const camera = support::lens(60, 40);
    auto const gaussians = support::cloud(150, 173);
    auto const floats = on_mesh<Both>(gaussians, camera);
    auto const eight = on_mesh<support::BytesAndPlanes>(gaussians, camera);
    CHECK(eight.depth.values == floats.depth.values);
    CHECK(eight.alpha.values == floats.alpha.values);
    for (std::size_t i = 0; i < eight.image.rgb.size(); ++i)
        if (eight.image.rgb[i] != static_cast<float>(Rgbx8Pixel::level(floats.image.rgb[i])) / 255.0f) FAIL("channel ", i);
}
