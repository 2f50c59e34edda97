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
/// The pairs that are evaluated, and the value of pixel (10, 10), for layers of colour 1.
std::pair<std::uint64_t, float> middle(std::vector<float> const& opacities, float limit, Stop stop)
{
    auto scene = layers(opacities, limit);
    scene.rules.stop = stop;
    auto const picture = support::blend(scene, Arithmetic::precise, 20, 20);
    return {picture.evaluated, picture.pixels[10 * 20 + 10].rgb[1]};
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

} // namespace
TILEMESH_EXACT_END

TEST_CASE("a pixel exactly at the limit goes on, one below it ends: with the term, or before crossing without it, even if the next term is faint")
{
    struct Row {
        std::vector<float> opacities;
        float limit, before, after; ///< the values of the two rules
    };
    float const above = std::nextafter(0.25f, 1.0f);
    for (Row const& row : {Row{{0.5f, 0.5f, 0.5f}, 0.25f, 0.75f, 0.875f}, // halves are exact: 1/2 and 1/4 are left
                           {{0.5f, 0.5f, 0.5f}, above, 0.5f, 0.75f},
                           {{0.5f, 0.5f}, 1.0f, 0, 0.5f}, // with a limit of 1 only the model's rule blends a term
                           {{0.5f, 0.75f, 0.25f}, 0.25f, 0.5f, 0.875f}, // 0.25 would leave 0.375
                           {{0.5f, 0.25f}, 0.25f, 0.625f, 0.625f},
                           {{1.0f, 0.25f}, 1e-4f, 0, 1}, // an opaque term always crosses
                           {{0.5f, 1.0f, 0.25f, 0.25f, 0.25f}, 1e-4f, 0.5f, 1},
                           {{1.0f, 1.0f}, 0, 1, 1}}) { // a limit of 0 never stops
        CAPTURE(row.opacities.size());
        CAPTURE(row.limit);
        CHECK(middle(row.opacities, row.limit, Stop::before_crossing).second == row.before);
        CHECK(middle(row.opacities, row.limit, Stop::after_crossing).second == row.after);
    }
}

TEST_CASE("stop before crossing: a block whose pixels have all ended looks at no more than 64 further splats")
{
    auto const evaluated = [](float opacity) { return middle(std::vector<float>(1000, opacity), 1e-2f, Stop::before_crossing).first; };
    CHECK(evaluated(0.9f) == 8 * 80 * 64); // 2 x 4 blocks; two layers are blended, the third ends every pixel
    CHECK(evaluated(1e-2f) == 8 * 80 * 512); // 0.99^458 is the last above a hundredth
}

TEST_CASE("a setup's own blending is what the mesh composites by, run by workers or whole")
{
    Rules rules;
    rules.transmittance_min = 1e-2f;
    rules.alpha_max = 0.99f;
    Scene const v(support::varied(700, 53), support::lens(150, 71), rules);
    auto crossing = v;
    crossing.rules.stop = Stop::before_crossing;
    auto const truth = support::by_loop(crossing), by_rules = support::by_loop(v);
    REQUIRE_FALSE(truth == by_rules);
    auto const same = [](support::Blended<> const& a, RenderedFrame const& b) {
        return std::memcmp(a.pixels.data(), b.image.rgb.data(), a.pixels.size() * sizeof(FloatPixel)) == 0 &&
               b.report.pairs_contributing == a.contributing;
    };
    auto const by_workers = dropping<CheckedMesh>(v);
    CHECK(same(truth, by_workers));
    for (std::uint32_t const threads : {1u, 3u}) {
        auto const whole = dropping<PortMesh>(v, threads);
        CHECK(same(truth, whole));
        CHECK(report::first_difference(whole.report, by_workers.report) == "");
    }
    CHECK(same(by_rules, ordinary<CheckedMesh>(v)));
    CHECK(same(by_rules, ordinary<PortMesh>(v)));
}
