// test: unoptimised test, cost 3
#include "map_reference.hpp"
#include <tilemesh/splat/map/tile.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;
namespace reference = support::map;
using reference::D;

namespace {
using support::sorted_splats;
/// A picture that the map does not explain: residuals of both signs, holes in the depth, pixels that do not count.
std::vector<TargetPixel> random_target(Camera const& camera, std::uint64_t seed)
{
    support::Random random(seed);
    std::vector<TargetPixel> out(std::size_t{camera.width} * camera.height);
    for (auto& p : out) {
        for (float& v : p.rgb) v = random.uniform(0, 1);
        p.depth = random.below(9) == 0 ? 0.0f : random.uniform(0.5f, 3.0f);
        if (random.below(50) == 0) p.rgb[1] = std::numeric_limits<float>::quiet_NaN();
    }
    return out;
}
struct Sums {
    std::vector<map::SplatSums> of;
    double loss = 0;
    std::uint32_t pixels = 0;

    bool operator==(Sums const& other) const { return pixels == other.pixels && support::same_bits(of, other.of); }
};
/// The sums of a frame over tiles, workers that take turns, and blocks in an order of the test's.
template <std::uint32_t Lanes, std::uint32_t Group, std::uint32_t Size>
Sums sums_over(std::vector<Splat> const& splats, View const& view, map::LossRules const& loss, std::vector<TargetPixel> const& target, TileSize size,
               std::uint32_t workers = 1, std::uint64_t order = 0)
{
    auto const memory = std::make_unique<map::WalkMemory<Group, Size>>();
    auto const tiling = make_tiling(view.camera.width, view.camera.height, size.tile_width, size.tile_height);
    Sums out{std::vector<map::SplatSums>(splats.size()), 0, 0};
    std::vector<std::uint32_t> tiles(tiling.columns * tiling.rows);
    std::iota(tiles.begin(), tiles.end(), 0u);
    support::Random random(order);
    for (auto i = static_cast<std::uint32_t>(tiles.size()); order != 0 && i > 1; --i) std::swap(tiles[i - 1], tiles[random.below(i)]);
    for (auto const t : tiles) {
        auto const tile = pixels_of(tiling, view.camera, TileId::at(t % tiling.columns, t / tiling.columns));
        for (std::uint32_t w = 0; w < workers; ++w)
            map::walk_tile<Lanes>(
                *memory, tile, view.camera, map::WalkRules{view.rules, loss}, static_cast<std::uint32_t>(splats.size()),
                    [&](std::uint32_t i) noexcept -> Splat const& { return splats[i]; },
                target.data() + std::size_t{tile.y0} * view.camera.width + tile.x0, view.camera.width, Worker{w, workers},
                [&](auto const&, map::BlockLoss const& one) noexcept {
                    out.loss += double{one.loss}, out.pixels += one.pixels;
                    return true;
                },
                [&](std::uint32_t i, map::SplatSums const& s) noexcept { out.of[i] += s; });
    }
    return out;
}
map::LossRules const usual_loss{1, 0.5f, 0, 0.1f, 4};
} // namespace

TEST_CASE("map sums: equal bits over tilings of whole blocks, workers, lanes, orders, and sizes of chunks")
{
    for (auto const stop : {Stop::after_crossing, Stop::before_crossing}) {
        Rules rules;
        rules.stop = stop;
        rules.alpha_max = 0.99f;
        rules.background[1] = 0.25f;
        auto const camera = support::lens(100, 63); // cuts blocks at its borders
        auto const view = make_view(camera, rules);
        auto const splats = sorted_splats(support::cloud(support::fast() ? 200 : 600, 3), view);
        auto const target = random_target(camera, 7);
        auto const first = sums_over<4, 8, 128>(splats, view, usual_loss, target, {32, 20});
        std::uint32_t with_sums = 0;
        for (auto const& s : first.of) with_sums += s.empty() ? 0 : 1;
        CHECK(with_sums > splats.size() / 3);
        CHECK(first.pixels > 100 * 63 * 9 / 10);
        CHECK(sums_over<4, 1, 16>(splats, view, usual_loss, target, {16, 5}, 1, 1) == first);
        CHECK(sums_over<8, 2, 16>(splats, view, usual_loss, target, {16, 10}, 3, 2) == first);
        CHECK(sums_over<16, 3, 32>(splats, view, usual_loss, target, {48, 35}, 6, 3) == first);
        CHECK(sums_over<2, 8, 128>(splats, view, usual_loss, target, {112, 65}, 2) == first);
        CHECK(sums_over<splat::detail::lanes_in_use, 8, 128>(splats, view, usual_loss, target, {64, 40}, 1, 4) == first);
        // A tile that cuts blocks rounds their parts on their own: other bits, so such tiles are refused by whoever needs equal maps.
        CHECK_FALSE(map::has_whole_blocks({24, 20}));
        CHECK_FALSE(map::has_whole_blocks({32, 21}));
        CHECK_FALSE(map::has_whole_blocks({0, 5}));
        CHECK(map::has_whole_blocks({32, 20}));
    }
}

TEST_CASE("map sums: the second walk ends with the transmittances of the first, bit for bit")
{
    using Set = splat::detail::GivenSet<4>;
    auto const check = [](auto stop) {
        using StopRule = decltype(stop);
        Rules rules;
        rules.alpha_max = 0.99f;
        auto const view = make_view(support::lens(48, 30), rules);
        auto cloud = support::cloud(120, 2);
        for (auto& g : cloud)
            for (float& s : g.log_scale) s = std::max(s, -1.5f);
        auto splats = sorted_splats(cloud, view);
        REQUIRE(splats.size() >= 64);
        auto const chunk = std::make_unique<map::WalkChunk<64>>();
        auto& plain = static_cast<splat::detail::Chunk<64>&>(*chunk);
        splat::detail::fill(Set{}, plain, 0, 64, [&](std::uint32_t i) -> Splat const& { return splats[i]; });
        for (std::uint32_t i = 0; i < 64; ++i) chunk->prepare(i, splats[i], rules.dilation, 4);
        splat::detail::OpenBlock<true> open;
        open.begin(16, 10, 0, {18, 48, 0, 30}, view.camera); // two dead columns
        map::WalkingBlock block{};
        std::memcpy(block.transmittance, open.state.transmittance, sizeof block.transmittance);
        std::uint32_t hits[64 + 16];
        auto const count = Set::call<splat::detail::ListHits>(std::as_const(plain), 64u, open.at, &hits[0]);
        splat::detail::RowLimits const limits{rules.alpha_min};
        Set::call<splat::detail::BlendBlock<StopRule>>(open.state, std::as_const(plain), hits, count, open.at, rules, limits);
        Set::call<map::detail::WalkBlock<StopRule>>(block, *chunk, hits, count, open.at, rules, map::LossRules{});
        CHECK(std::memcmp(block.transmittance, open.state.transmittance, sizeof block.transmittance) == 0);
        std::uint32_t stopped = 0;
        for (auto const& row : open.state.transmittance)
            for (float const t : row) stopped += t < rules.transmittance_min;
        CHECK(stopped > 20); // dead ones are 10
    };
    check(splat::detail::StopEachPixel{});
    check(splat::detail::StopBeforeCrossing{});
}

TEST_CASE("map sums: float is within 2e-5 of double, with alpha up to 1, and the last pair is not a difference")
{
    std::vector<double> errors;
    for (std::uint64_t seed = 0; seed < (support::fast() ? 10u : 40u); ++seed) {
        auto const scene = reference::stiff_scene(seed);
        auto const last_pair = seed % 2 == 0 ? map::LastPair::as_cut : map::LastPair::alike;
        Rules rules;
        rules.alpha_max = 1;
        auto const view = make_view(scene.camera, rules);
        auto const splats = sorted_splats(scene.gaussians, view);
        auto const width = scene.camera.width, height = scene.camera.height;
        auto const linear = reference::random_slopes(std::size_t{width} * height, seed);
        float const lowest = lowest_power_for(rules.alpha_min), limit = 256; // nothing is clipped

        // In double, pixel by pixel, with the decisions of float.
        std::vector<map::PairSums<D>> truth(splats.size());
        std::vector<double> left(linear.size());
        for (std::uint32_t y = 0; y < height; ++y)
            for (std::uint32_t x = 0; x < width; ++x) {
                float const px = static_cast<float>(x) + 0.5f - scene.camera.cx, py = static_cast<float>(y) + 0.5f - scene.camera.cy;
                auto const& g = linear[y * width + x];
                double t = 1, total = 0;
                struct Taken {
                    std::uint32_t i;
                    double alpha, dx, off;
                };
                std::vector<Taken> taken;
                float stops = 1;
                for (std::uint32_t i = 0; i < splats.size(); ++i) {
                    auto const& s = splats[i];
                    auto const r = s.rect();
                    float const single = std::min(alpha_at(s, px, py, lowest), 1.0f);
                    if (x < r.x0 || x >= r.x1 || y < r.y0 || y >= r.y1 || !(single >= rules.alpha_min) ||
                        !(stops >= rules.transmittance_min)) continue;
                    stops = stops - single * stops;
                    double const dx = double{px} - double{s.mean_px[0]}, off = double{py} - double{s.mean_px[1]} - double{s.slope} * dx;
                    double const alpha = std::min(1.0,
                                                  double{s.opacity} * std::exp(double{s.along} * dx * dx + double{s.across} * off * off));
                    taken.push_back({i, alpha, dx, off});
                    double const q = g[0] * double{s.colour[0]} + g[1] * double{s.colour[1]} + g[2] * double{s.colour[2]};
                    total += alpha * t * (q + g[3] * double{s.depth()});
                    t -= alpha * t;
                }
                left[y * width + x] = total + g[4] * t;
                map::WalkingPixel<D> p{1, left[y * width + x]};
                for (auto const& one : taken) {
                    auto const& s = splats[one.i];
                    map::walk_pair<D>(p, one.alpha, true, true, one.dx, one.off,
                                      {{double{s.colour[0]}, double{s.colour[1]}, double{s.colour[2]}}, double{s.depth()}, 1e30},
                                      {{g[0], g[1], g[2]}, g[3], g[4]},
                                      {&one == &taken.back() && !(stops >= rules.transmittance_min) ? 2.0f : 1e-30f, 1e30f, last_pair},
                                      truth[one.i]);
                }
            }

        // The kernel.
        using Set = splat::detail::GivenSet<4>;
        auto const chunk = std::make_unique<map::WalkChunk<64>>();
        auto const n = static_cast<std::uint32_t>(splats.size());
        REQUIRE(splat::detail::fill(Set{}, static_cast<splat::detail::Chunk<64>&>(*chunk), 0, n,
                                    [&](std::uint32_t i) -> Splat const& { return splats[i]; }) == n);
        std::vector<map::Moments<D>> exact;
        std::vector<double> finer; // quanta are finer here: their own error is another test's
        for (std::uint32_t i = 0; i < n; ++i) {
            exact.push_back(map::in_own_units<D>(truth[i], double{splats[i].along}, double{splats[i].across}));
            chunk->prepare(i, splats[i], rules.dilation, limit);
            double largest = 1e-30;
            for (double const v : exact[i].of) largest = std::max(largest, std::fabs(v) * std::max(1.0, double{splats[i].depth()}));
            finer.push_back(std::exp2(std::floor(26 - std::log2(largest * double{map::quanta_per_unit(splats[i], rules.dilation,
                limit)}))));
            for (float& v : chunk->scale[i]) v *= static_cast<float>(finer[i]);
        }
        for (std::uint32_t y = 0; y < height; y += block_height)
            for (std::uint32_t x = 0; x < width; x += block_width) {
                splat::detail::OpenBlock<true> open;
                open.begin(x, y, 0, {0, width, 0, height}, scene.camera);
                map::WalkingBlock block{};
                std::memcpy(block.transmittance, open.state.transmittance, sizeof block.transmittance);
                for (std::uint32_t j = 0; j < block_height && y + j < height; ++j)
                    for (std::uint32_t i = 0; i < block_width; ++i) {
                        auto const& g = linear[(y + j) * width + x + i];
                        for (std::size_t c = 0; c < 3; ++c) block.slopes.colour[c][j][i] = static_cast<float>(g[c]);
                        block.slopes.depth[j][i] = static_cast<float>(g[3]), block.slopes.through[j][i] = static_cast<float>(g[4]);
                        block.slopes.left[j][i] = static_cast<float>(left[(y + j) * width + x + i]);
                    }
                std::uint32_t hits[64 + 16];
                auto const count = Set::call<splat::detail::ListHits>(static_cast<splat::detail::Chunk<64> const&>(*chunk), n, open.at,
                                                                      &hits[0]);
                Set::call<map::detail::WalkBlock<splat::detail::StopEachPixel>>(block, *chunk, hits, count, open.at, rules,
                                                                                map::LossRules{1, 0, 0, 0, limit, last_pair});
            }
        double squares = 0, most = 0;
        for (auto const& one : exact) squares += one.of[map::gp] * one.of[map::gp];
        double const rms = std::sqrt(squares / n);
        for (std::uint32_t i = 0; i < n; ++i) {
            auto const mine = map::moments_of(chunk->sums_of(i), splats[i], rules.dilation, limit);
            for (std::uint32_t k = 0; k < map::sums; ++k) most = std::max(most,
                                                                          std::fabs(double{mine.of[k]} / finer[i] - exact[i].of[k]) / rms);
        }
        errors.push_back(most);
    }
    std::sort(errors.begin(), errors.end());
    double const nine_tenths = errors[errors.size() * 9 / 10 - 1];
    MESSAGE("largest error over the rms of the sum of gP: median scene " << errors[errors.size() / 2] << ", of nine tenths "
                                                                         << nine_tenths << ", worst " << errors.back());
    CHECK(nine_tenths < 2e-5);
    CHECK(errors.back() < 1e-4); // rounding behind a pair is amplified by 1 / (1 - alpha), at most 1 / transmittance_min
}

TEST_CASE("map sums: the pair that ends a pixel, by hand")
{
    for (auto const last : {map::LastPair::alike, map::LastPair::as_cut}) {
        // Two pairs: alpha 0.5, then alpha 1. Colours 1 and 3, a slope of 2 by the colour and of 8 by the last transmittance.
        map::WalkingPixel<D> p{1, 0.5 * 2 * 1 + 0.5 * 2 * 3};
        map::PairSums<D> first{}, second{};
        map::PixelSlopes<D> const slopes{{2, 0, 0}, 0, 8};
        map::PairRules const rules{5e-3f, 100, last};
        map::walk_pair<D>(p, 0.5, true, true, 2, 3, {{1, 0, 0}, 1, 100}, slopes, rules, first);
        CHECK(p.t == 0.5);
        CHECK(p.left == 3);
        CHECK(first.of[map::gp] == 1 - 0.5 * (3 / 0.5)); // w q - alpha left / (1 - alpha)
        CHECK(first.of[map::gp_xo] == first.of[map::gp] * 6);
        CHECK(first.of[map::w_red] == 1);
        map::walk_pair<D>(p, 1.0, true, true, 2, 3, {{3, 0, 0}, 1, 100}, slopes, rules, second);
        CHECK(p.t == 0);
        CHECK(second.of[map::gp] == (last == map::LastPair::alike ? 0 : 3 - 0.5 * 8));
        CHECK(second.of[map::w_red] == 1);
        // The clip, alpha_max, and a pair that takes no part.
        map::PairSums<D> other{};
        p = {1, 1000};
        map::walk_pair<D>(p, 0.5, true, true, 1, 1, {{1, 0, 0}, 1, 100}, slopes, {5e-3f, 4, last}, other);
        CHECK(other.of[map::gp] == -4 * 0.5);
        other = {};
        map::walk_pair<D>(p, 0.5, true, false, 1, 1, {{1, 0, 0}, 1, 100}, slopes, rules, other);
        CHECK(other.of[map::gp] == 0);
        CHECK(other.of[map::w_red] == 0.5 * 0.5 * 2);
        auto const before = p;
        map::walk_pair<D>(p, 0.5, false, true, 1, 1, {{1, 0, 0}, 1, 100}, slopes, rules, other);
        CHECK(p.t == before.t);
        CHECK(p.left == before.left);
        CHECK(other.of[map::w_red] == 0.5 * 0.5 * 2);
    }
}

TEST_CASE("map sums: no set of pixels exceeds the bound, and a frame in which each pair is at the clip stays below 2^30 quanta")
{
    // The lattice sums themselves, in double, over all pixels of the rectangle.
    support::Random random(11);
    double most = 0;
    for (std::uint32_t n = 0; n < (support::fast() ? 300u : 3000u); ++n) {
        Rules rules;
        rules.dilation = n % 5 == 0 ? 0.0f : 0.3f;
        rules.alpha_min = n % 3 == 0 ? 1.0f / 8160 : 1.0f / 255;
        auto const view = make_view(support::flat_camera(40, 40), rules);
        auto g = support::ball(1, random.uniform(-2, 42), random.uniform(-2, 42), 1, random.uniform(0.01f, 1));
        for (float& s : g.log_scale) s = random.uniform(-5, 2.5f);
        for (float& q : g.rotation) q = random.uniform(-1, 1);
        auto const s = project(g, view, TileSize{40, 40});
        if (!s.visible()) continue;
        double sums[6] = {};
        auto const r = s.rect();
        for (std::uint32_t y = r.y0; y < r.y1; ++y)
            for (std::uint32_t x = r.x0; x < r.x1; ++x) {
                double const dx = x + 0.5 - double{s.mean_px[0]}, off = y + 0.5 - double{s.mean_px[1]} - double{s.slope} * dx;
                double const hat_x = dx * std::sqrt(-2 * double{s.along}), hat_o = off * std::sqrt(-2 * double{s.across});
                double const alpha = double{s.opacity} * std::exp(-0.5 * (hat_x * hat_x + hat_o * hat_o));
                double const parts[6] = {1, std::fabs(hat_x), std::fabs(hat_o), hat_x * hat_x, std::fabs(hat_x * hat_o), hat_o * hat_o};
                for (int k = 0; k < 6; ++k) sums[k] += alpha * parts[k];
            }
        for (double const v : sums) most = std::max(most, v / double{map::largest_sum(s, rules.dilation)});
    }
    MESSAGE("largest sum over its bound: " << most);
    CHECK(most <= 1 + 1e-5);
    CHECK(most > 0.9); // the bound is near

    // A loss so steep that all slopes are at their limits, of one sign.
    Rules const rules;
    auto const camera = support::lens(96, 60);
    auto const view = make_view(camera, rules);
    for (std::uint32_t n : {1u, 40u}) {
        auto cloud = support::cloud(n, n);
        for (auto& g : cloud)
            for (float& s : g.log_scale) s = std::max(s, n == 1 ? -0.5f : -7.0f);
        auto const splats = sorted_splats(cloud, view);
        REQUIRE(!splats.empty());
        std::vector<TargetPixel> const target(std::size_t{96} * 60, TargetPixel{{-9, -9, -9}, 0.1f});
        auto const s = sums_over<4, 8, 128>(splats, view, {1e9f, 1e9f, 0, 0, 4}, target, {32, 20});
        std::int64_t largest = 0; // the absolute value of the least int32 is no int32
        for (auto const& one : s.of)
            for (auto const v : one.of) largest = std::max(largest, std::abs(std::int64_t{v}));
        CHECK(largest < map::most_quanta);
        CHECK(largest > map::most_quanta / 16); // and few bits are wasted
    }
}

TEST_CASE("map sums: what is not a number stays in its pixel, and no sum leaves its bound")
{
    support::Random random(9);
    float const infinity = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    float const odd[] = {0, -0.0f, -1, 1e-38f, 1e-30f, 1e18f, -1e30f, 3e38f, infinity, -infinity, nan};
    auto const camera = support::lens(48, 30);
    for (std::uint64_t seed = 1; seed <= (support::fast() ? 8u : 40u); ++seed) {
        Rules rules;
        rules.alpha_max = seed % 2 == 0 ? 0.99f : 1.0f;
        rules.dilation = seed % 3 == 0 ? 0.0f : 0.3f;
        rules.transmittance_min = seed % 5 == 0 ? 0.0f : 5e-3f;
        auto const view = make_view(camera, rules);
        auto cloud = support::cloud(60, seed);
        for (auto& g : cloud) {
            support::spoil(g, random, 12);
            for (float& v : g.colour)
                if (random.below(12) == 0) v = odd[random.below(std::size(odd))];
        }
        auto const splats = sorted_splats(cloud, view);
        auto target = random_target(camera, seed);
        for (auto& p : target)
            if (random.below(10) == 0) p.rgb[random.below(3)] = odd[random.below(11)], p.depth = odd[random.below(11)];
        auto const s = sums_over<4, 8, 128>(splats, view, {1, 0.5f, 0.1f, 0, 4}, target, {32, 20});
        CHECK(std::isfinite(s.loss));
        for (std::size_t i = 0; i < s.of.size(); ++i) {
            auto const m = map::moments_of(s.of[i], splats[i], rules.dilation, 4);
            for (std::uint32_t k = 0; k < map::sums; ++k) {
                CHECK(std::abs(std::int64_t{s.of[i].of[k]}) < map::most_quanta);
                CHECK(std::isfinite(m.of[k]));
            }
        }
        CHECK(sums_over<8, 3, 32>(splats, view, {1, 0.5f, 0.1f, 0, 4}, target, {16, 5}, 2, 3) == s);
    }
}

TEST_CASE("map sums: the slopes of a block are the derivatives of its loss, and a masked pixel has none")
{
    using Set = splat::detail::GivenSet<4>;
    support::Random random(3);
    float const background[3] = {0.1f, 0.6f, 0.3f};
    for (auto const& rules : {map::LossRules{1, 0, 0, 0, 4}, {1.5f, 0.5f, 0.2f, 0.1f, 4}, {0, 1, 0, 0, 4}}) {
        splat::detail::DepthBlock block{};
        map::BlockTarget target;
        for (std::uint32_t j = 0; j < block_height; ++j)
            for (std::uint32_t i = 0; i < block_width; ++i) {
                float const t = block.transmittance[j][i] = random.uniform(0, 0.9f);
                for (auto* field : {block.red, block.green, block.blue}) field[j][i] = random.uniform(0, 1) * (1 - t);
                block.depth[j][i] = random.uniform(0.5f, 3) * (1 - t);
                for (auto& field : target.field) field[j][i] = random.uniform(0.1f, 2);
            }
        target.field[1][2][3] = std::numeric_limits<float>::quiet_NaN();
        target.field[3][4][7] = 0;
        // The loss of pixel (i, j) in double.
        auto const loss_of = [&](std::uint32_t j, std::uint32_t i, double const(&v)[5]) {
            auto const robust = [](double r,
                                   double width) { return std::fabs(r) < width ? r * r / (2 * width) : std::fabs(r) - width / 2; };
            double sum = 0, covered = 1 - v[4], seen = double{target.field[3][j][i]};
            for (int c = 0; c < 3; ++c) {
                if (std::isnan(target.field[1][j][i])) return 0.0;
                sum += double{rules.colour} / 3 * robust(v[c] + v[4] * double{background[c]} - double{target.field[c][j][i]},
                                                         double{rules.huber_colour});
            }
            if (covered > 0.5 && seen > 0) sum += double{rules.depth} * robust((v[3] / covered - seen) / seen, double{rules.huber_depth});
            return sum;
        };
        map::BlockSlopes slopes;
        map::BlockLoss loss;
        Set::call<map::detail::MakeSlopes>(static_cast<splat::detail::DepthBlockFields const&>(block), target, background, rules,
                                           slopes, loss);
        double total = 0;
        for (std::uint32_t j = 0; j < block_height; ++j)
            for (std::uint32_t i = 0; i < block_width; ++i) {
                double const at[5] = {block.red[j][i], block.green[j][i], block.blue[j][i], block.depth[j][i], block.transmittance[j][i]};
                double const mine[5] = {slopes.colour[0][j][i], slopes.colour[1][j][i], slopes.colour[2][j][i], slopes.depth[j][i],
                                        slopes.through[j][i]};
                total += loss_of(j, i, at);
                double left = 0;
                for (int k = 0; k < 5; ++k) {
                    double up[5], down[5];
                    std::copy(at, at + 5, up), std::copy(at, at + 5, down);
                    up[k] += 1e-6, down[k] -= 1e-6;
                    CHECK(mine[k] == doctest::Approx((loss_of(j, i, up) - loss_of(j, i, down)) / 2e-6).epsilon(1e-4));
                    left += mine[k] * at[k];
                }
                CHECK(double{slopes.left[j][i]} == doctest::Approx(left).epsilon(1e-4));
            }
        CHECK(double{loss.loss} == doctest::Approx(total).epsilon(1e-5));
        CHECK(loss.pixels == 79);
    }
}
