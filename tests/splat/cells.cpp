// test: without tsan
// Blending in cells: the lists of cells, the recurrence and its exceptions, against precise arithmetic and against double precision.
#include "blended.hpp"
#include <tilemesh/splat/logarithm.hpp>

#pragma GCC diagnostic ignored "-Wpsabi" // more lanes than the target has are passed between functions that vanish

using namespace tilemesh;
using namespace tilemesh::splat;
namespace inner = tilemesh::splat::detail;

namespace {
using Scene = support::SortedSplats;
using support::varied, support::with;
template <std::uint32_t Lanes = inner::lanes_in_use>
support::Blended<support::DeepPixel> deep(Scene const& scene, Arithmetic arithmetic, std::uint32_t tile_width, std::uint32_t tile_height)
{
    return support::blend<Lanes, support::DeepPixel>(scene, arithmetic, tile_width, tile_height);
}
std::vector<Rules> all_rules()
{
    return {Rules{},
            with([](Rules& m) { m.alpha_max = 0.99f; }),
            with([](Rules& m) { m.dilation = 0; }),
            with([](Rules& m) { m.alpha_min = 1.0f / 8160; }),
            with([](Rules& m) { m.footprint = Footprint::three_sigma_square; }),
            with([](Rules& m) { m.footprint = Footprint::three_sigma_tiles, m.stop = Stop::before_crossing, m.transmittance_min = 1e-4f; }),
            with([](Rules& m) { m.stop = Stop::before_crossing, m.transmittance_min = 0.5f; })};
}
/// What a pixel is in double precision, with the cuts of the rules.
struct Truth {
    double rgb[3] = {}, depth = 0, weight = 0, transmittance = 1;
};
Truth truth_at(Scene const& scene, std::uint32_t x, std::uint32_t y)
{
    Truth p;
    auto const& m = scene.rules;
    for (auto const& s : scene.splats) {
        auto const r = s.rect();
        if (x < r.x0 || x >= r.x1 || y < r.y0 || y >= r.y1) continue;
        double const dx = x + 0.5 - double{scene.camera.cx} - double{s.mean_px[0]}, dy = y + 0.5 - double{scene.camera.cy} - double{s.mean_px[1]};
        double const off = dy - double{s.slope} * dx;
        double const alpha = std::min(double{s.opacity} * std::exp(double{s.along} * dx * dx + double{s.across} * off * off), double{m.alpha_max});
        if (alpha < double{m.alpha_min}) continue;
        double const weight = alpha * p.transmittance;
        if (m.stop == Stop::before_crossing && p.transmittance - weight < double{m.transmittance_min}) break;
        for (int c = 0; c < 3; ++c) p.rgb[c] += weight * double{s.colour[c]};
        p.depth += weight * double{s.depth()};
        p.weight += weight;
        p.transmittance -= weight;
        if (p.transmittance < double{m.transmittance_min}) break;
    }
    return p;
}
} // namespace

TEST_CASE("cells: a picture is above 90 dB against double precision with the same cuts, and so are its planes")
{
    for (auto const& rules : all_rules()) {
        Scene const scene(varied(900, 61), support::lens(250, 131), rules);
        auto const picture = deep(scene, Arithmetic::fast, 32, 20);
        double squares = 0, alphas = 0, depths = 0;
        for (std::uint32_t y = 0; y < 131; ++y)
            for (std::uint32_t x = 0; x < 250; ++x) {
                auto const truth = truth_at(scene, x, y);
                auto const& pixel = picture.pixels[std::size_t{y} * 250 + x];
                for (int c = 0; c < 3; ++c) squares += std::pow(double{pixel.colour.colour.rgb[c]} - truth.rgb[c], 2);
                alphas += std::pow(double{pixel.alpha} - (1 - truth.transmittance), 2);
                if (truth.weight > 0.01) depths += std::pow(double{pixel.colour.depth} * truth.weight / truth.depth - 1, 2);
            }
        auto const pixels = 250.0 * 131.0;
        CHECK(-10 * std::log10(squares / (3 * pixels)) > 90);
        CHECK(-10 * std::log10(alphas / pixels) > 90);
        CHECK(-10 * std::log10(depths / pixels) > 80); // relative, where the weight is above a hundredth: a flip at the cut is a larger share
    }
}

TEST_CASE("cells: every pixel above the cut is in a listed cell, and no pixel below it is drawn; alpha is within 2e-5 of precise")
{
    for (auto rules : all_rules()) {
        rules.stop = Stop::after_crossing;
        std::size_t lost = 0, gained = 0, drawn = 0;
        double relative = 0;
        for (auto g : varied(support::fast() ? 400 : 2000, 62)) {
            for (float& c : g.colour) c = 1;
            Scene const one({g}, support::lens(120, 75), rules);
            auto const precise = deep(one, Arithmetic::precise, 120, 75), fast = deep(one, Arithmetic::fast, 120, 75);
            for (std::size_t i = 0; i < precise.pixels.size(); ++i) {
                float const u = precise.pixels[i].colour.colour.rgb[0], v = fast.pixels[i].colour.colour.rgb[0];
                lost += u > rules.alpha_min * 1.0001f && v == 0 ? 1 : 0;
                gained += v > rules.alpha_min * 1.0001f && u == 0 ? 1 : 0;
                drawn += v != 0 ? 1 : 0;
                if (u != 0 && v != 0) relative = std::max(relative, std::fabs(double{u} - double{v}) / double{u});
            }
        }
        CHECK(lost == 0);
        CHECK(gained == 0);
        CHECK(drawn > 1000);
        MESSAGE("largest relative difference of alpha: ", relative);
        CHECK(relative > 0); // otherwise the recurrence was never used
        CHECK(relative < 2e-5);
    }
}

TEST_CASE("cells: a pixel barely above the cut is listed, though it is alone in its cell and far from the frame's middle")
{
    auto const camera = support::lens(6000, 32);
    Rules rules;
    rules.arithmetic = Arithmetic::fast;
    support::Random random(66);
    std::size_t lost = 0, gained = 0, tried = 0;
    std::vector<FloatPixel> pixels(8 * 4);
    for (int trial = 0; trial < 4000; ++trial) {
        // A small splat, whose mean is left or right of a cell. Its own row crosses the cell's nearest column.
        auto const column = 8 * static_cast<std::uint32_t>(random.uniform(1, 749)), row = 4 * static_cast<std::uint32_t>(random.uniform(0, 8));
        bool const left = trial % 2 == 0;
        float const x = static_cast<float>(left ? column : column + 7) + 0.5f - camera.cx, y = static_cast<float>(row + static_cast<std::uint32_t>(trial / 2 % 4)) + 0.5f - camera.cy;
        Splat s{};
        float const away = random.uniform(0.6f, 2.0f);
        s.mean_px[0] = left ? x - away : x + away;
        s.slope = random.uniform(-0.5f, 0.5f);
        s.mean_px[1] = y - s.slope * (x - s.mean_px[0]); // the pixel is the ellipse's rightmost or leftmost point
        s.along = -random.uniform(2.0f, 5.0f) / (away * away), s.across = -random.uniform(0.5f, 1.5f);
        s.depth_key = splat::key_of_depth(1), s.opacity = 1;
        s.opacity = rules.alpha_min * 1.00003f / alpha_at(s, x, y);
        if (!(s.opacity < 0.99f)) continue;
        s.faintest = logarithm(rules.alpha_min / s.opacity) - 0.01f; // as in a projection
        for (float& c : s.colour) c = 1;
        s.columns = 6000u << 16, s.rows = 32u << 16;
        auto const at = [&](std::uint32_t) noexcept -> Splat const& { return s; };
        PairCount counts[1] = {};
        blend_whole_tile(PixelRect{column, column + 8, row, row + 4}, camera, rules, 1, at, pixels.data(), 8, counts, 1);
        lost += counts[0].contributing == 0 ? 1 : 0;
        ++tried;
        // A rectangle of 16-pixel tiles may end before the pixel. A tile beyond it does not have the splat, so no tile shows it there.
        s.columns = left ? column << 16 : 6000u << 16 | (column + 8);
        blend_whole_tile(PixelRect{column, column + 8, row, row + 4}, camera, rules, 1, at, pixels.data(), 8, &(counts[0] = {}), 1);
        gained += counts[0].contributing;
    }
    CHECK(tried > 1000);
    CHECK(lost == 0);
    CHECK(gained == 0);
}

TEST_CASE("cells: needles whose means are far away are within 2e-5 of precise, also where the principal point is between pixels")
{
    support::Random random(67);
    double most = 0;
    std::size_t drawn = 0, alone = 0, wild = 0;
    for (int k = 0; k < (support::fast() ? 2000 : 10000); ++k) {
        auto camera = support::lens(64, 40);
        if (k % 2 == 0) camera.cx += 0.217f, camera.cy += 0.377f; // so that the distances of two rows are not rounded alike
        float const length = std::exp(random.uniform(0.0f, 16.0f)), turn = random.uniform(0.0f, 3.14f), z = random.uniform(1.0f, 4.0f);
        Gaussian const g{{std::cos(2 * turn) * length, std::sin(2 * turn) * length, z}, {1, 1, 1}, random.uniform(0.3f, 0.99f),
                         {std::cos(turn), 0, 0, std::sin(turn)}, {std::log(length), random.uniform(-9, -2), -9}, GaussianId{1}};
        Scene const one({g}, camera);
        auto const precise = deep(one, Arithmetic::precise, 64, 40), fast = deep(one, Arithmetic::fast, 64, 40);
        for (std::size_t i = 0; i < precise.pixels.size(); ++i) {
            float const u = precise.pixels[i].colour.colour.rgb[0], v = fast.pixels[i].colour.colour.rgb[0];
            wild += v >= 0 && v <= 1 ? 0 : 1;
            if (u == 0 || v == 0) {
                alone += std::max(u, v) > 5e-3f ? 1 : 0; // only a faint value may be in one picture alone
                continue;
            }
            most = std::max(most, std::fabs(double{u} - double{v}));
            ++drawn;
        }
    }
    MESSAGE("largest difference of alpha: ", most);
    CHECK(drawn > 10000);
    CHECK(alone == 0);
    CHECK(wild == 0);
    CHECK(most < 2e-5);
}

TEST_CASE("cells: bits and counts do not depend on tiles and lanes")
{
    for (auto const& rules : all_rules()) {
        Scene const scene(varied(600, 63), support::lens(250, 131), rules);
        auto const whole = deep(scene, Arithmetic::fast, 250, 131);
        CHECK(whole == deep(scene, Arithmetic::fast, 32, 20));
        CHECK(whole == deep(scene, Arithmetic::fast, 13, 7));
        CHECK(whole == deep(scene, Arithmetic::fast, 1, 131));
        CHECK(whole == deep<16>(scene, Arithmetic::fast, 100, 3));
        CHECK(whole == deep<8>(scene, Arithmetic::fast, 9, 50));
        CHECK(whole == deep<4>(scene, Arithmetic::fast, 32, 20));
        CHECK(whole == deep<2>(scene, Arithmetic::fast, 32, 20));
        CHECK(whole == deep<1>(scene, Arithmetic::fast, 32, 20));
    }
}

namespace {
/// A tile's pixels, and the pairs of each of its cells.
struct Counted {
    std::vector<FloatPixel> pixels = std::vector<FloatPixel>(64 * 40);
    PairCount counts[80] = {};
};
template <std::uint32_t Lanes>
Counted blend_and_count(Scene const& scene)
{
    Rules rules = scene.rules;
    rules.arithmetic = Arithmetic::fast;
    auto const at = [&](std::uint32_t i) noexcept -> Splat const& { return scene.splats[i]; };
    Counted result;
    blend_whole_tile<Lanes>(PixelRect{0, 64, 0, 40}, scene.camera, rules, static_cast<std::uint32_t>(scene.splats.size()), at,
                            result.pixels.data(), 64, result.counts, 80);
    return result;
}
} // namespace

TEST_CASE("cells: two cells at once have the bits and the counts of each by itself")
{
    for (auto const& rules : all_rules())
        for (std::uint32_t n : {1u, 60u, 130u, 900u}) {
            auto gaussians = varied(n, 66 + n);
            for (auto& g : gaussians) { // opaque walls over a few cells: neighbours stop at different splats
                g.mean_world[0] *= 0.3f, g.mean_world[1] *= 0.3f;
                if (static_cast<std::uint32_t>(g.id) % 9 == 0) g.opacity = 1, g.log_scale[0] = g.log_scale[1] = -2.5f;
            }
            Scene const scene(gaussians, support::lens(64, 40), rules);
            auto const one = blend_and_count<8>(scene), two = blend_and_count<16>(scene), four = blend_and_count<4>(scene);
            CHECK(std::memcmp(one.pixels.data(), two.pixels.data(), one.pixels.size() * sizeof(FloatPixel)) == 0);
            CHECK(std::memcmp(one.counts, two.counts, sizeof one.counts) == 0);
            CHECK(std::memcmp(one.counts, four.counts, sizeof one.counts) == 0);
        }
}

TEST_CASE("cells: the cells that a splat reaches do not depend on the window")
{
    Scene const scene(varied(900, 64), support::lens(256, 128), with([](Rules& m) { m.transmittance_min = 0; }));
    auto const whole = deep(scene, Arithmetic::fast, 256, 128);
    for (auto const& size : {std::pair(8u, 4u), std::pair(32u, 20u), std::pair(64u, 128u), std::pair(40u, 12u)}) {
        auto const tiles = deep(scene, Arithmetic::fast, size.first, size.second);
        CHECK(tiles.evaluated == whole.evaluated);
        CHECK(tiles.contributing == whole.contributing);
    }
    CHECK(whole.evaluated > whole.contributing);
    CHECK(whole.evaluated < 3 * whole.contributing);
}

TEST_CASE("cells: alpha does not exceed alpha_max or 1 where splats are opaque")
{
    for (float const alpha_max : {1.0f, 0.99f, 0.3f}) {
        Rules rules;
        rules.alpha_max = alpha_max;
        auto gaussians = varied(500, 65);
        for (auto& g : gaussians) {
            g.opacity = 1;
            for (float& c : g.colour) c = 1;
            Scene const one({g}, support::lens(120, 75), rules);
            float most = 0;
            for (auto const& p : deep(one, Arithmetic::fast, 120, 75).pixels) most = std::max(most, p.alpha);
            CHECK(most <= alpha_max);
        }
    }
}
