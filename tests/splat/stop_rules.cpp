// test: unoptimised test, without asan tsan
// The stop rule of 3D Gaussian Splatting, which differs from the model's, and a setup with its own blending.
#include "../compare_reports.hpp"
#include "blended.hpp"
#include "runner.hpp"

#pragma GCC diagnostic ignored "-Wpsabi" // more lanes than the target has are passed between functions that vanish

using namespace tilemesh;
using namespace tilemesh::splat;
namespace inner = tilemesh::splat::detail;

TILEMESH_EXACT_BEGIN
namespace {

using Scene = support::SortedSplats;
using Picture = support::Blended;

/// A cloud of larger splats; every third is opaque or almost opaque, so many pixels stop.
std::vector<Gaussian> dense(std::uint32_t n, std::uint64_t seed)
{
    auto all = support::cloud(n, seed);
    for (auto& g : all) {
        for (float& s : g.log_scale) s += 1.5f;
        if (static_cast<std::uint32_t>(g.id) % 3 == 0) g.opacity = static_cast<std::uint32_t>(g.id) % 6 == 0 ? 1.0f : 0.97f;
    }
    return all;
}
/// The loop of 3D Gaussian Splatting over one pixel's splats: a term that would leave less than the limit is left out and ends the pixel.
Picture naive(Scene const& v)
{
    Picture out;
    for (std::uint32_t y = 0; y < v.camera.height; ++y)
        for (std::uint32_t x = 0; x < v.camera.width; ++x) {
            float through = 1, rgb[3] = {0, 0, 0};
            for (auto const& s : v.splats) {
                auto const r = s.rect();
                if (x < r.x0 || x >= r.x1 || y < r.y0 || y >= r.y1) continue;
                float const alpha =
                    std::min(alpha_at(s, float(x) + 0.5f - v.camera.cx, float(y) + 0.5f - v.camera.cy), v.rules.alpha_max);
                if (alpha < v.rules.alpha_min) continue;
                float const weight = alpha * through, left = through - weight;
                if (left < v.rules.transmittance_min) break;
                for (int c = 0; c < 3; ++c) rgb[c] = multiply_add(weight, s.colour[c], rgb[c]);
                through = left;
                ++out.contributing;
            }
            out.pixels.push_back({{rgb[0], rgb[1], rgb[2]}});
        }
    return out;
}
/// The kernel over the frame in tiles.
template <class Stop, std::uint32_t Lanes = inner::native_lanes, class Rule = inner::EachPair>
Picture blend(Scene const& v, std::uint32_t tile_width, std::uint32_t tile_height)
{
    return support::blended_in_tiles(
        v, tile_width, tile_height,
        [&](PixelRect const& tile, std::uint32_t n, auto const& at, FloatPixel* pixels, Picture& picture) {
            PairCount count{};
            inner::blend_tile_by<Rule, Stop, Lanes, 32, 128>(tile, v.camera, v.rules, n, at, pixels, v.camera.width, Worker{0, 1}, &count,
                                                             1);
            picture.count(count);
        });
}

/// Layers that cover a whole small frame, the first in front. The opacities are those in the middle of pixel (10, 10).
Scene layers(std::vector<float> const& opacities, float limit)
{
    auto camera = support::flat_camera(20, 20);
    camera.cx = camera.cy = 10.5f;
    std::vector<Gaussian> all;
    for (std::size_t i = 0; i < opacities.size(); ++i) {
        all.push_back(support::ball(static_cast<std::uint32_t>(i + 1), 0, 0, 1000, opacities[i]));
        for (float& c : all.back().colour) c = 1;
    }
    Rules rules;
    rules.transmittance_min = limit;
    return Scene(std::move(all), camera, rules);
}
/// The value of pixel (10, 10) for layers of colour 1.
template <class Stop>
float middle(std::vector<float> const& opacities, float limit)
{
    return blend<Stop>(layers(opacities, limit), 20, 20).pixels[10 * 20 + 10].rgb[1];
}

/// A setup's own rule.
struct BlendDropping {
    template <class SplatAt, class Pixel>
    static PairCount tile(PixelRect const& tile, FrameParameters const& frame, std::uint32_t n, SplatAt const& at, Pixel* pixels,
                          std::uint32_t stride_px, Worker worker) noexcept
    {
        PairCount pairs{};
        blend(tile, frame, n, at, pixels, stride_px, worker, &pairs, 1);
        return pairs;
    }
    template <class SplatAt, class Pixel>
    static void whole(PixelRect const& tile, FrameParameters const& frame, std::uint32_t n, SplatAt const& at, Pixel* pixels,
                      std::uint32_t stride_px, PairCount* counts, std::uint32_t workers) noexcept
    {
        blend(tile, frame, n, at, pixels, stride_px, Worker{0, 1}, counts, workers);
    }

private:
    template <class SplatAt, class Pixel>
    static void blend(PixelRect const& tile, FrameParameters const& frame, std::uint32_t n, SplatAt const& at, Pixel* pixels,
                      std::uint32_t stride_px, Worker worker, PairCount* counts, std::uint32_t workers) noexcept
    {
        if (tile.empty()) return;
        inner::blend_tile_by<inner::EachPair, inner::StopBeforeCrossing, inner::native_lanes, 32, 128>(
            tile, frame.view.camera, frame.view.rules, n, at, pixels, stride_px, worker, counts, workers);
    }
};
struct Dropping : support::Whole {
    using Blending = BlendDropping;
};
RendererOptions options_with(std::uint32_t threads)
{
    return {.threads = threads, .tile = {32, 20}, .sizes = support::sized<support::Whole>(100, 3000)};
}
template <template <class, class> class Engine>
RenderedFrame dropping(Scene const& v, std::uint32_t threads = 1)
{
    BasicRenderer<Dropping, Engine> renderer{support::map_of(v.gaussians), options_with(threads)};
    renderer.rules() = v.rules;
    return renderer.render(v.camera);
}
template <template <class, class> class Engine>
RenderedFrame ordinary(Scene const& v)
{
    auto const runner = support::make_runner<support::Whole, Engine>(support::map_of(v.gaussians), options_with(1));
    runner->rules() = v.rules;
    return runner->render(v.camera);
}
bool same_bits(Picture const& a, report::Image const& b)
{
    return a.pixels.size() * sizeof(FloatPixel) == b.rgb.size() * sizeof(float) &&
           std::memcmp(a.pixels.data(), b.rgb.data(), a.pixels.size() * sizeof(FloatPixel)) == 0;
}

} // namespace
TILEMESH_EXACT_END

TEST_CASE("stop before crossing: 3DGS's loop, bit for bit, for any tiling and any lanes")
{
    for (float const limit : {1e-4f, 1e-3f, 3e-2f, 0.5f})
        for (float const alpha_max : {0.99f, 1.0f}) {
            Rules rules;
            rules.transmittance_min = limit;
            rules.alpha_max = alpha_max;
            Scene const v(dense(700, 41), support::lens(150, 71), rules);
            auto const truth = naive(v);
            auto const ours = blend<inner::StopBeforeCrossing>(v, 32, 20);
            CHECK(ours == truth);
            CHECK(ours.contributing == truth.contributing);
            CHECK(blend<inner::StopBeforeCrossing>(v, 150, 71) == truth);
            CHECK(blend<inner::StopBeforeCrossing>(v, 13, 7) == truth);
            CHECK(blend<inner::StopBeforeCrossing, 4>(v, 32, 20) == truth);
            CHECK(blend<inner::StopBeforeCrossing, 8>(v, 17, 3) == truth);
            CHECK(blend<inner::StopBeforeCrossing, 16>(v, 32, 20) == truth);
            // On this map the rule makes a difference: it blends fewer terms.
            auto const model_rule = blend<inner::StopEachPixel>(v, 32, 20);
            CHECK_FALSE(model_rule == truth);
            CHECK(model_rule.contributing > truth.contributing);
        }
}

TEST_CASE("stop before crossing: the recurrence's bits do not depend on the tiling")
{
    Rules rules;
    rules.transmittance_min = 1e-2f;
    rules.alpha_max = 0.99f;
    Scene const v(dense(700, 43), support::lens(150, 71), rules);
    auto const whole = blend<inner::StopBeforeCrossing, 8, inner::FastRule>(v, 150, 71);
    CHECK(blend<inner::StopBeforeCrossing, 8, inner::FastRule>(v, 32, 20) == whole);
    CHECK(blend<inner::StopBeforeCrossing, 4, inner::FastRule>(v, 13, 7) == whole);
    CHECK_FALSE(blend<inner::StopEachPixel, 8, inner::FastRule>(v, 32, 20) == whole);
}

TEST_CASE("stop before crossing: a pixel exactly at the limit goes on, one below it ends without the term")
{
    // Halves are exact: 1/2 and 1/4 are left.
    CHECK(middle<inner::StopBeforeCrossing>({0.5f, 0.5f, 0.5f}, 0.25f) == 0.75f);
    CHECK(middle<inner::StopEachPixel>({0.5f, 0.5f, 0.5f}, 0.25f) == 0.875f);
    CHECK(middle<inner::StopBeforeCrossing>({0.5f, 0.5f, 0.5f}, std::nextafter(0.25f, 1.0f)) == 0.5f);
    CHECK(middle<inner::StopEachPixel>({0.5f, 0.5f, 0.5f}, std::nextafter(0.25f, 1.0f)) == 0.75f);
    // With a limit of 1 no term is blended; the model's rule blends the first.
    CHECK(middle<inner::StopBeforeCrossing>({0.5f, 0.5f}, 1.0f) == 0.0f);
    CHECK(middle<inner::StopEachPixel>({0.5f, 0.5f}, 1.0f) == 0.5f);
}

TEST_CASE("stop before crossing: a pixel that has dropped a term is finished, even if the next term is faint")
{
    CHECK(middle<inner::StopBeforeCrossing>({0.5f, 0.75f, 0.25f}, 0.25f) == 0.5f); // 0.25 would leave 0.375
    CHECK(middle<inner::StopBeforeCrossing>({0.5f, 0.25f}, 0.25f) == 0.625f);
    CHECK(middle<inner::StopBeforeCrossing>({1.0f, 0.25f}, 1e-4f) == 0.0f); // an opaque term always crosses
    CHECK(middle<inner::StopBeforeCrossing>({0.5f, 1.0f, 0.25f, 0.25f, 0.25f}, 1e-4f) == 0.5f);
}

TEST_CASE("stop before crossing: a limit of 0 never stops")
{
    Rules rules;
    rules.transmittance_min = 0;
    Scene const v(dense(700, 47), support::lens(150, 71), rules);
    auto const picture = blend<inner::StopBeforeCrossing>(v, 32, 20), same = blend<inner::StopEachPixel>(v, 32, 20);
    CHECK(picture == same);
    CHECK(picture == naive(v));
    CHECK(picture.contributing == same.contributing);
    CHECK(middle<inner::StopBeforeCrossing>({1.0f, 1.0f}, 0.0f) == 1.0f);
}

TEST_CASE("stop before crossing: a block whose pixels have all ended looks at no more than 64 further splats")
{
    auto const evaluated = [](float opacity) {
        auto const v = layers(std::vector<float>(1000, opacity), 1e-2f);
        return blend<inner::StopBeforeCrossing>(v, 20, 20).evaluated;
    };
    CHECK(evaluated(0.9f) == 8 * 80 * 64); // 2 x 4 blocks; two layers are blended, the third ends every pixel
    CHECK(evaluated(1e-2f) == 8 * 80 * 512); // 0.99^458 is the last above a hundredth
}

TEST_CASE("a setup's own blending is what the mesh composites by, run by workers or whole")
{
    Rules rules;
    rules.transmittance_min = 1e-2f;
    rules.alpha_max = 0.99f;
    Scene const v(dense(700, 53), support::lens(150, 71), rules);
    auto const truth = naive(v);
    auto const by_rules = blend<inner::StopEachPixel>(v, 150, 71);
    REQUIRE_FALSE(truth == by_rules);

    auto const by_workers = dropping<CheckedMesh>(v);
    CHECK(same_bits(truth, by_workers.image));
    CHECK(by_workers.report.pairs_contributing == truth.contributing);
    for (std::uint32_t const threads : {1u, 3u}) {
        auto const whole = dropping<PortMesh>(v, threads);
        CHECK(same_bits(truth, whole.image));
        CHECK(report::first_difference(whole.report, by_workers.report) == "");
    }
    CHECK(same_bits(by_rules, ordinary<CheckedMesh>(v).image));
    CHECK(same_bits(by_rules, ordinary<PortMesh>(v).image));
    CHECK(ordinary<PortMesh>(v).report.pairs_contributing == by_rules.contributing);
}
