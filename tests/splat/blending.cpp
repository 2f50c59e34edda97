// test: without tsan
#include "blended.hpp"

#pragma GCC diagnostic ignored "-Wpsabi" // more lanes than the target has are passed between functions that vanish

using namespace tilemesh;
using namespace tilemesh::splat;
namespace inner = tilemesh::splat::detail;

namespace {
using Scene = support::SortedSplats;
using support::blend, support::with;

Scene varied(std::uint32_t n, std::uint32_t seed, Rules const& rules = {})
{
    return Scene(support::varied(n, seed), support::lens(250, 131), rules);
}
/// Layers of colour 1 that cover a whole small frame, the first in front, with these opacities in the middle of pixel (10, 10). Returns the
/// pairs that are evaluated, and the pixel's value.
std::pair<std::uint64_t, float> middle(std::vector<float> const& opacities, float limit, Stop stop)
{
    auto camera = support::flat_camera(20, 20);
    camera.cx = camera.cy = 10.5f;
    std::vector<Gaussian> all;
    for (float const opacity : opacities) {
        all.push_back(support::ball(static_cast<std::uint32_t>(all.size()) + 1, 0, 0, 1000, opacity));
        for (float& c : all.back().colour) c = 1;
    }
    Rules rules;
    rules.transmittance_min = limit, rules.stop = stop;
    auto const picture = blend(Scene(std::move(all), camera, rules), Arithmetic::precise, 20, 20);
    return {picture.evaluated, picture.pixels[10 * 20 + 10].rgb[1]};
}
} // namespace

TEST_CASE("blending: precise is the naive loop, bit for bit, and counts its pairs, with both rules of the stop")
{
    std::vector<Rules> all{Rules{},
                           with([](Rules& m) { m.alpha_max = 0.99f; }),
                           with([](Rules& m) { m.alpha_min = 0; }),
                           with([](Rules& m) { m.transmittance_min = 0; }),
                           with([](Rules& m) { m.transmittance_min = 0.5f; }),
                           with([](Rules& m) { m.footprint = Footprint::three_sigma_square; }),
                           with([](Rules& m) { m.dilation = 0; })};
    for (float const limit : {0.0f, 1e-4f, 1e-3f, 3e-2f, 0.5f})
        for (float const alpha_max : {0.99f, 1.0f}) {
            auto& m = all.emplace_back();
            m.stop = Stop::before_crossing, m.transmittance_min = limit, m.alpha_max = alpha_max;
        }
    for (auto const& rules : all) {
        auto gaussians = support::varied(900, 31);
        for (auto& g : gaussians)
            if (rules.stop == Stop::before_crossing) { // many pixels stop
                for (float& s : g.log_scale) s += 1.5f;
                if (static_cast<std::uint32_t>(g.id) % 3 == 0) g.opacity = 0.97f;
            }
        Scene const scene(std::move(gaussians), support::lens(250, 131), rules);
        auto const picture = blend(scene, Arithmetic::precise, 32, 20), loop = support::by_loop(scene);
        CHECK(picture == loop);
        auto const naive = report::render_naive(scene.gaussians, scene.camera, scene.rules);
        CHECK(std::memcmp(naive.rgb.data(), loop.pixels.data(), naive.rgb.size() * sizeof(float)) == 0);
        CHECK(picture.contributing <= picture.evaluated);
        if (rules.stop == Stop::after_crossing) continue;
        auto other = scene;
        other.rules.stop = Stop::after_crossing;
        auto const model_rule = blend(other, Arithmetic::precise, 32, 20);
        CHECK((model_rule == picture) == (rules.transmittance_min == 0)); // otherwise it blends more terms
        CHECK(model_rule.contributing >= picture.contributing);
    }
}

TEST_CASE("blending: either arithmetic gives the same bits for any tiling, lanes and workers")
{
    for (auto const& rules : {Rules{}, with([](Rules& m) { m.stop = Stop::before_crossing, m.transmittance_min = 1e-2f, m.alpha_max = 0.99f; })})
        for (auto arithmetic : {Arithmetic::precise, Arithmetic::fast}) {
            auto const scene = varied(700, 32, rules);
            auto const whole = blend(scene, arithmetic, 250, 131), tiles = blend(scene, arithmetic, 32, 20);
            CHECK(whole == tiles);
            CHECK(whole == blend(scene, arithmetic, 17, 13));
            CHECK(whole == blend(scene, arithmetic, 1, 131));
            CHECK(whole == blend(scene, arithmetic, 250, 3));
            CHECK(whole == blend<16>(scene, arithmetic, 32, 20));
            CHECK(whole == blend<8>(scene, arithmetic, 32, 20));
            CHECK(whole == blend<4>(scene, arithmetic, 32, 20));
            CHECK(whole == blend<2>(scene, arithmetic, 32, 20));
            CHECK(whole == blend<1>(scene, arithmetic, 32, 20));
            for (std::uint32_t workers : {1u, 2u, 6u, 9u}) { // 9: more than a tile has blocks of 16 x 5
                auto const by_workers = blend(scene, arithmetic, 32, 20, workers);
                CHECK(whole == by_workers);
                CHECK(by_workers.evaluated == tiles.evaluated);
            }
        }
}

TEST_CASE(
    "blending: a pixel exactly at the limit goes on, one below it ends: with the term, or before crossing without it, even if the next term is faint")
{
    struct Row {
        std::vector<float> opacities;
        float limit, before, after; ///< the values of the two rules
    };
    float const above = std::nextafter(0.25f, 1.0f);
    for (Row const& row : {Row{{0.5f, 0.5f, 0.5f}, 0.25f, 0.75f, 0.875f}, // halves are exact: 1/2 and 1/4 are left
                           {{0.5f, 0.5f, 0.5f}, above, 0.5f, 0.75f},
                           {{0.5f, 0.5f}, 1.0f, 0, 0.5f},               // with a limit of 1 only the model's rule blends a term
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

TEST_CASE("blending, stop before crossing: a block whose pixels have all ended looks at no more than 64 further splats")
{
    auto const evaluated = [](float opacity) { return middle(std::vector<float>(1000, opacity), 1e-2f, Stop::before_crossing).first; };
    CHECK(evaluated(0.9f) == 8 * 80 * 64);   // 2 x 4 blocks; two layers are blended, the third ends every pixel
    CHECK(evaluated(1e-2f) == 8 * 80 * 512); // 0.99^458 is the last above a hundredth
}

TEST_CASE("blending: one thread for all workers counts what each of them counts")
{
    auto const scene = varied(900, 33);
    PixelRect const tile{30, 71, 18, 60}; // 4 x 9 blocks or 6 x 11 cells, cut on all sides
    auto const at = [&](std::uint32_t i) noexcept -> Splat const& { return scene.splats[i]; };
    std::vector<FloatPixel> pixels(41 * 42);
    for (auto arithmetic : {Arithmetic::precise, Arithmetic::fast})
        for (std::uint32_t n : {0u, 1u, 15u, 16u, 17u, 127u, 128u, 129u, 250u}) {
            Rules rules = scene.rules;
            rules.arithmetic = arithmetic;
            PairCount counts[6] = {};
            blend_whole_tile(tile, scene.camera, rules, n, at, pixels.data(), 41, counts, 6);
            for (std::uint32_t w = 0; w < 6; ++w) {
                auto const one = blend_tile(tile, scene.camera, rules, n, at, pixels.data(), 41, Worker{w, 6});
                CHECK(counts[w].evaluated == one.evaluated);
                CHECK(counts[w].contributing == one.contributing);
            }
        }
}

TILEMESH_EXACT_BEGIN
namespace {
/// Four lanes, as WebAssembly has them, whose blocks are blended rows by rows or all rows at once.
template <bool RowsApart>
struct FourLanes : inner::GivenSet<4> {
    static constexpr bool blends_rows_apart = RowsApart;
    template <class Work, class... Args>
    static auto call(Args&&... args) noexcept
    {
        return Work::template run<FourLanes>(args...);
    }
};
/// A block's state and its contributing pairs, after all splats of the scene.
template <class Stop, bool RowsApart, bool HasDepth>
std::pair<inner::OpenBlock<HasDepth>, std::uint32_t> one_block(Scene const& scene, std::uint32_t bx, std::uint32_t by, PixelRect const& tile)
{
    using Set = FourLanes<RowsApart>;
    constexpr std::uint32_t size = 128;
    auto const n = static_cast<std::uint32_t>(scene.splats.size());
    auto const at = [&](std::uint32_t i) noexcept -> Splat const& { return scene.splats[i]; };
    std::pair<inner::OpenBlock<HasDepth>, std::uint32_t> result{};
    auto& [block, contributing] = result;
    block.begin(bx, by, 0, tile, scene.camera);
    inner::RowLimits const limits{scene.rules.alpha_min};
    inner::Chunk<size> chunk{};
    std::uint32_t hits[size + 4];
    for (std::uint32_t begin = 0; begin < n; begin += size) {
        auto const most = inner::fill(inner::GivenSet<4>{}, chunk, begin, n, at);
        auto const count = inner::GivenSet<4>::call<inner::ListHits>(chunk, most, block.at, &hits[0]);
        for (std::uint32_t done = 0; done < count;) {
            auto const part = std::min(inner::blended_between_looks, count - done);
            contributing += Set::template call<inner::BlendBlock<Stop>>(block.state, chunk, hits + done, part, block.at, scene.rules, limits);
            done += part;
        }
    }
    return result;
}
template <class Stop, bool HasDepth>
void check_rows_apart(Scene const& scene)
{
    PixelRect const tile{3, 247, 2, 129}; // cuts blocks on all sides
    std::uint32_t contributing = 0;
    for (std::uint32_t by = 0; by < 130; by += block_height)
        for (std::uint32_t bx = 0; bx < 250; bx += block_width) {
            auto const [together, a] = one_block<Stop, false, HasDepth>(scene, bx, by, tile);
            auto const [apart, b] = one_block<Stop, true, HasDepth>(scene, bx, by, tile);
            REQUIRE(std::memcmp(&together.state, &apart.state, sizeof together.state) == 0);
            REQUIRE(a == b);
            contributing += a;
        }
    CHECK(contributing > 0);
}
} // namespace
TILEMESH_EXACT_END

TEST_CASE("blending: rows blended apart, as in WebAssembly, have the bits and the counts of rows blended together")
{
    auto const scene = varied(700, 83);
    check_rows_apart<inner::StopEachPixel, false>(scene);
    check_rows_apart<inner::StopBeforeCrossing, true>(scene);
    check_rows_apart<inner::StopEachPixel, true>(scene);
    check_rows_apart<inner::StopEachPixel, false>(varied(300, 84, with([](Rules& m) { m.alpha_max = 0.99f; })));
}

TEST_CASE("blending: a polynomial of each degree has the error that it claims")
{
    auto const error = [](auto rule) {
        constexpr int degree = decltype(rule)::degree;
        double most = 0;
        for (int i = -126 * 64; i <= 126 * 64; ++i) {
            float const x = static_cast<float>(i) / 64 + (i < 126 * 64 ? 0.0078f : 0.0f);
            auto const y = inner::power_of_two<degree, 4>(inner::broadcast<4>(x));
            most = std::max(most, std::fabs(double{y[0]} / std::exp2(double{x}) - 1));
        }
        return most;
    };
    CHECK(error(inner::Recurrence<3>{}) == doctest::Approx(7.5e-5).epsilon(0.05));
    CHECK(error(inner::Recurrence<4>{}) == doctest::Approx(2.6e-6).epsilon(0.1));
    CHECK(error(inner::Recurrence<5>{}) < 3e-7);
    CHECK(error(inner::Recurrence<5>{}) > 7e-8);
}

TEST_CASE("blending: pixels outside a rectangle get nothing, however bright the splat")
{
    auto const camera = support::flat_camera(48, 30);
    for (std::uint32_t x0 : {0u, 1u, 15u, 16u, 17u, 31u})
        for (std::uint32_t y0 : {0u, 1u, 4u, 5u, 6u, 14u})
            for (std::uint32_t size : {1u, 2u, 5u, 6u, 11u}) {
                Splat s{};
                s.along = s.across = -1e-9f;
                s.opacity = 0.5f;
                s.faintest = -5;
                s.depth_key = splat::key_of_depth(1);
                for (float& c : s.colour) c = 1;
                s.columns = x0 | (x0 + size) << 16;
                s.rows = y0 | (y0 + size) << 16;
                for (auto arithmetic : {Arithmetic::precise, Arithmetic::fast}) {
                    Rules rules;
                    rules.arithmetic = arithmetic;
                    std::vector<FloatPixel> pixels(48 * 30);
                    auto const at = [&](std::uint32_t) noexcept -> Splat const& { return s; };
                    PairCount counts[1] = {};
                    blend_whole_tile(PixelRect{0, 48, 0, 30}, camera, rules, 1, at, pixels.data(), 48, counts, 1);
                    bool right = counts[0].contributing == size * size;
                    for (std::uint32_t y = 0; y < 30; ++y)
                        for (std::uint32_t x = 0; x < 48; ++x) {
                            bool const inside = x >= x0 && x < x0 + size && y >= y0 && y < y0 + size;
                            right = right && (inside ? std::fabs(pixels[y * 48 + x].rgb[0] - 0.5f) < 1e-5f : pixels[y * 48 + x].rgb[0] == 0);
                        }
                    CHECK(right);
                }
            }
}

TEST_CASE("blending: an opaque wall stops a block or a cell within 64 splats")
{
    struct Row {
        Arithmetic arithmetic;
        std::uint32_t height; ///< of a block of 16 x 5, or two cells of 8 x 8
        float stop;
        std::uint32_t layers; ///< 0.05^2 is the first power below 5e-3, 0.05^4 below 1e-4
    };
    for (Row const& row : {Row{Arithmetic::precise, 5, Rules{}.transmittance_min, 2},
                           {Arithmetic::precise, 5, 1e-4f, 4},
                           {Arithmetic::fast, 8, Rules{}.transmittance_min, 2}})
        for (std::uint32_t n : {1u, 2u, 3u, 4u, 5u, 63u, 64u, 65u, 127u, 128u, 129u, 1000u}) {
            CAPTURE(row.height);
            CAPTURE(row.stop);
            Splat s{};
            s.along = s.across = -1e-9f;
            s.opacity = 0.95f;
            s.faintest = -5;
            s.depth_key = splat::key_of_depth(1);
            s.columns = 0u | 16u << 16;
            s.rows = 0u | row.height << 16;
            auto const at = [&](std::uint32_t) noexcept -> Splat const& { return s; };
            auto const camera = support::flat_camera(16, row.height);
            Rules rules;
            rules.transmittance_min = row.stop;
            rules.arithmetic = row.arithmetic;
            std::vector<FloatPixel> pixels(16 * row.height);
            PairCount counts[1] = {};
            blend_whole_tile(PixelRect{0, 16, 0, row.height}, camera, rules, n, at, pixels.data(), 16, counts, 1);
            CHECK(counts[0].evaluated * pairs_a_count == 16 * row.height * std::min(n, 64u));
            CHECK(counts[0].contributing == 16 * row.height * std::min(n, row.layers));
            auto const one = blend_tile(PixelRect{0, 16, 0, row.height}, camera, rules, n, at, pixels.data(), 16, Worker{0, 1});
            CHECK(one.evaluated == counts[0].evaluated);
            CHECK(one.contributing == counts[0].contributing);
        }
}

#if defined(__SSE__)
TEST_CASE("blending: small splats meet no denormal operand, and the caller's floating-point mode stays")
{
    constexpr unsigned flags = 0x3fu, denormal_operand = 0x2u, underflow = 0x10u, flush_to_zero = 0x8000u;
    auto gaussians = support::cloud(900, 48);
    for (auto& g : gaussians) {
        for (float& s : g.log_scale) s = -6; // a few pixels wide: far columns of their cells are below 2^-126
        if (static_cast<std::uint32_t>(g.id) % 2 != 0) g.log_scale[0] = -3; // needles: so are the corners of their rectangles
        g.opacity = 0.01f + 0.1f * std::fmod(static_cast<float>(static_cast<std::uint32_t>(g.id)), 9.0f);
    }
    Scene const scene(std::move(gaussians), support::lens(250, 131));
    auto const at = [&](std::uint32_t i) noexcept -> Splat const& { return scene.splats[i]; };
    std::vector<FloatPixel> pixels(250 * 131);
    unsigned const mine = __builtin_ia32_stmxcsr();
    for (unsigned const mode : {0u, flush_to_zero})
        for (auto const arithmetic : {Arithmetic::precise, Arithmetic::fast}) {
            Rules rules = scene.rules;
            rules.arithmetic = arithmetic;
            PairCount counts[1] = {};
            unsigned const before = (mine & ~(flags | flush_to_zero)) | mode;
            __builtin_ia32_ldmxcsr(before);
            blend_whole_tile(PixelRect{0, 250, 0, 131}, scene.camera, rules, static_cast<std::uint32_t>(scene.splats.size()), at,
                             pixels.data(), 250, counts, 1);
            unsigned const after = __builtin_ia32_stmxcsr();
            __builtin_ia32_ldmxcsr(mine);
            CHECK(counts[0].contributing > 1000);
            CHECK((after & ~flags) == before);
            CHECK((after & denormal_operand) == 0);
            if (arithmetic == Arithmetic::precise) CHECK((after & underflow) == 0); // its arithmetic stays normal, without a mode
        }
}
#endif
