#include "../splat/support.hpp"
#include "catalogue.hpp"
#include "machines.hpp"
#include <tilemesh/splat/depth_sort.hpp>

// The order of the layers: rows 56 to 63 of the catalogue.
using namespace tilemesh;
using namespace tilemesh::splat;
using stability::Kind;
using stability::number;

namespace {

std::uint32_t bits_of(float v)
{
    return __builtin_bit_cast(std::uint32_t, v);
}

/// The picture of a naive renderer: a stable sort by depth alone, in the order in which the records arrived. It blends as the library does.
report::Image stable_picture(std::vector<Gaussian> const& arrived, Camera const& camera)
{
    Rules const rules;
    auto const view = make_view(camera, rules);
    auto const tiling = make_tiling(camera.width, camera.height, camera.width, camera.height);
    std::vector<Splat> splats;
    for (auto const& g : arrived)
        if (auto const s = project(g, view, tiling); s.visible()) splats.push_back(s);
    std::stable_sort(splats.begin(), splats.end(), [](Splat const& a, Splat const& b) { return a.depth_key < b.depth_key; });
    report::Image image(camera.width, camera.height);
    std::vector<float> through(std::size_t{camera.width} * camera.height, 1.0f);
    for (auto const& s : splats) {
        auto const r = s.rect();
        for (auto y = r.y0; y < r.y1; ++y)
            for (auto x = r.x0; x < r.x1; ++x) {
                float& t = through[std::size_t{y} * camera.width + x];
                float const alpha = alpha_at(s, static_cast<float>(x) + 0.5f - camera.cx, static_cast<float>(y) + 0.5f - camera.cy);
                if (t < rules.transmittance_min || alpha < rules.alpha_min) continue;
                for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] += alpha * t * s.colour[c];
                t -= alpha * t;
            }
    }
    return image;
}
double largest_difference(report::Image const& a, report::Image const& b)
{
    double most = 0;
    for (std::size_t i = 0; i < a.rgb.size(); ++i) most = std::max(most, 255 * std::fabs(double{a.rgb[i]} - double{b.rgb[i]}));
    return most;
}
report::Image on_mesh(std::vector<Gaussian> const& gaussians, Camera const& camera, RendererOptions const& options = {.tile = {16, 8}})
{
    return stability::render(Kind::roomy, support::map_of(gaussians), camera, options).image;
}
template <class T>
void shuffle(std::vector<T>& items, support::Random& random)
{
    for (auto n = static_cast<std::uint32_t>(items.size()); n > 1; --n) std::swap(items[n - 1], items[random.below(n)]);
}

Gaussian coloured(std::uint32_t id, float x, float y, float depth, float sigma, float opacity, float red, float blue)
{
    auto g = support::ball(id, x * depth / 1000, y * depth / 1000, sigma, opacity);
    g.mean_world[2] = depth;
    g.colour[0] = red, g.colour[1] = 0, g.colour[2] = blue;
    return g;
}

/// A key that counts its compares.
struct Counted {
    std::uint32_t value;
    inline static std::uint64_t compares = 0;
};
bool operator<(Counted a, Counted b)
{
    ++Counted::compares;
    return a.value < b.value;
}
} // namespace

TEST_CASE("row 56: two layers of one depth look the same in either order of arrival")
{
    auto camera = support::flat_camera(20, 20);
    camera.cx = camera.cy = 10.5f;
    std::vector<Gaussian> const one{coloured(1, 0, 0, 1000, 1000, 0.5f, 1, 0), coloured(2, 0, 0, 1000, 1000, 0.5f, 0, 1)};
    std::vector<Gaussian> const two{one[1], one[0]};
    double const naive = largest_difference(stable_picture(one, camera), stable_picture(two, camera));
    auto const a = on_mesh(one, camera), b = on_mesh(two, camera);
    CHECK(naive == doctest::Approx(63.8).epsilon(0.01));
    CHECK(support::differing_pixels(a, b) == 0);
    CHECK(a.pixel(10, 10)[0] == 0.5f);
    stability::report({56, "two equal depths, red and blue 0.5, swapped", number(naive) + " levels", number(largest_difference(a, b)) + " levels",
                       "bit-exact", true});
}

TEST_CASE("row 57: 64 layers on 8 depths look the same in any order of arrival")
{
    auto camera = support::flat_camera(40, 24);
    camera.cx = camera.cy = 10.5f;
    support::Random random(57);
    std::vector<Gaussian> layers;
    for (std::uint32_t i = 0; i < 64; ++i)
        layers.push_back(coloured(i + 1, random.uniform(-8, 8), random.uniform(-8, 8), 1000.0f + static_cast<float>(i % 8), 30, 0.5f,
                                  random.uniform(0, 1), random.uniform(0, 1)));
    auto const first_stable = stable_picture(layers, camera), first = on_mesh(layers, camera);
    double naive = 0;
    std::uint64_t differing = 0;
    for (int trial = 0; trial < 8; ++trial) {
        shuffle(layers, random);
        naive = std::max(naive, largest_difference(first_stable, stable_picture(layers, camera)));
        differing += support::differing_pixels(first, on_mesh(layers, camera));
    }
    CHECK(naive > 10);
    CHECK(differing == 0);
    stability::report({57, "64 layers on 8 depths, 8 orders of arrival", number(naive) + " levels (a stable sort)",
                       std::to_string(differing) + " pixels differ", "bit-exact", true});
}

TEST_CASE("row 58: a wall that faces the camera looks the same on tiles of every size")
{
    std::uint32_t const n = support::fast() ? 3'000 : 20'000;
    auto const camera = support::lens(160, 96);
    support::Random random(58);
    std::vector<Gaussian> wall;
    for (std::uint32_t i = 0; i < n; ++i) {
        Gaussian g = support::ball(i + 1, random.uniform(-2.6f, 2.6f), random.uniform(-1.6f, 1.6f), 0.02f, random.uniform(0.1f, 0.9f));
        g.mean_world[2] = 3;
        for (float& c : g.colour) c = random.uniform(0, 1);
        wall.push_back(g);
    }
    auto turned = camera; // the wall in the camera's frame: equal depths, but for rounding
    turned.rotation[0][0] = turned.rotation[2][2] = std::cos(0.3f);
    turned.rotation[0][2] = std::sin(0.3f);
    turned.rotation[2][0] = -std::sin(0.3f);
    for (auto& g : wall) {
        float const x = g.mean_world[0], z = g.mean_world[2];
        g.mean_world[0] = turned.rotation[0][0] * x + turned.rotation[2][0] * z;
        g.mean_world[2] = turned.rotation[0][2] * x + turned.rotation[2][2] * z;
    }
    auto const view = make_view(turned, Rules{});
    std::vector<float> depths;
    for (auto const& g : wall)
        if (auto const s = project(g, view, make_tiling(160, 96, 160, 96)); s.visible()) depths.push_back(s.depth());
    std::sort(depths.begin(), depths.end());
    std::uint32_t ties = 0;
    for (std::size_t i = 1; i < depths.size(); ++i) ties += depths[i] == depths[i - 1] ? 1 : 0;
    CHECK(ties > depths.size() / 2);

    // A naive mesh: each tile sorts its records stably in their order of arrival, and that order depends on the tiling.
    auto const naive_on = [&](std::uint32_t width, std::uint32_t height) {
        report::Image image(160, 96);
        for (std::uint32_t ty = 0; ty * height < 96; ++ty)
            for (std::uint32_t tx = 0; tx * width < 160; ++tx) {
                auto arrived = wall; // its own records first, then the neighbours'
                std::stable_partition(arrived.begin(), arrived.end(), [&](Gaussian const& g) {
                    auto const anchor = project(g, view, make_tiling(160, 96, width, height)).anchor;
                    return anchor == TileId::at(tx, ty);
                });
                auto const picture = stable_picture(arrived, turned);
                for (auto y = ty * height; y < std::min(96u, (ty + 1) * height); ++y)
                    for (auto x = tx * width; x < std::min(160u, (tx + 1) * width); ++x) std::memcpy(image.pixel(x, y), picture.pixel(x, y), 12);
            }
        return image;
    };
    auto const naive = support::differing_pixels(naive_on(160, 48), naive_on(80, 96));
    CHECK(naive > 0);

    auto const whole = report::render_naive(wall, turned, Rules{});
    std::uint64_t differing = 0;
    std::uint32_t threads = 0;
    for (Extent2 tile : {Extent2{160, 96}, {80, 96}, {32, 20}, {16, 16}, {7, 13}}) {
        shuffle(wall, random); // the order of rows does not count either, nor do threads
        differing += support::differing_pixels(whole, on_mesh(wall, turned, {.threads = 1 + threads++ % 3, .tile = tile}));
    }
    CHECK(differing == 0);
    stability::report(
        {58, "a wall of " + std::to_string(n) + ", " + number(100.0 * ties / static_cast<double>(depths.size())) + " % have a twin in depth",
         std::to_string(naive) + " of 15360 pixels differ between two tilings", std::to_string(differing) + " pixels differ, 5 tilings",
         "bit-exact over tile sizes", true});
}

TEST_CASE("row 59: the bits of every depth that is drawn are ordered as the depths are")
{
    CHECK(bits_of(-1.0f) > bits_of(1.0f)); // raw bits put -1 behind 1
    CHECK(bits_of(-0.0f) > bits_of(0.0f)); // and tell the zeros apart
    auto camera = support::flat_camera(20, 20);
    camera.near_depth = std::numeric_limits<float>::denorm_min();
    auto const view = make_view(camera, Rules{});
    auto const tiling = make_tiling(20, 20, 20, 20);
    std::uint32_t shown = 0, wrong = 0;
    std::vector<float> depths{-1, -0.0f, 0.0f, -1e-40f, 1e-40f, 1, std::nextafter(1.0f, 2.0f), 3e38f};
    support::Random random(59);
    for (int i = 0; i < 20'000; ++i) depths.push_back(std::ldexp(random.uniform(-1, 1), static_cast<int>(random.below(60)) - 20));
    std::vector<std::pair<float, std::uint32_t>> keys;
    for (float z : depths) {
        auto g = support::ball(1, 0, 0);
        g.mean_world[2] = z;
        auto const s = project(g, view, tiling);
        if (!s.visible()) continue;
        ++shown;
        wrong += s.depth() > 0 ? 0 : 1;
        keys.emplace_back(s.depth(), s.depth_key);
    }
    std::sort(keys.begin(), keys.end(), [](auto const& a, auto const& b) { return a.second < b.second; });
    for (std::size_t i = 1; i < keys.size(); ++i) wrong += keys[i].first < keys[i - 1].first ? 1 : 0;
    CHECK(shown > 5'000);
    CHECK(wrong == 0);
    stability::report({59, "depths of both signs, the zeros, denormal", "-1 sorts behind 1, -0 behind 0",
                       std::to_string(wrong) + " out of order; only z > near is drawn", "exact", true});
}

TEST_CASE("row 60: depths that are NaN never reach the sort")
{
    support::Random random(60);
    std::vector<Gaussian> gaussians;
    for (std::uint32_t i = 0; i < 5'000; ++i) {
        auto g = support::ball(i + 1, random.uniform(-1, 1), random.uniform(-1, 1), 0.5f);
        g.mean_world[2] = random.below(50) == 0 ? std::numeric_limits<float>::quiet_NaN() : random.uniform(0.5f, 100);
        gaussians.push_back(g);
    }
    // The same sort on the bare floats: std::sort with such a comparison is undefined.
    std::vector<float> naive;
    for (auto const& g : gaussians) naive.push_back(g.mean_world[2]);
    splat::detail::heap_sort(naive.data(), static_cast<std::uint32_t>(naive.size()));
    naive.erase(std::remove_if(naive.begin(), naive.end(), [](float z) { return std::isnan(z); }), naive.end());
    std::uint32_t naive_inversions = 0;
    for (std::size_t i = 1; i < naive.size(); ++i) naive_inversions += naive[i] < naive[i - 1] ? 1 : 0;

    auto camera = support::flat_camera(64, 64);
    camera.cx = camera.cy = 32;
    auto const view = make_view(camera, Rules{});
    std::vector<SortKey> keys;
    for (std::uint32_t i = 0; i < gaussians.size(); ++i)
        if (auto const s = project(gaussians[i], view, make_tiling(64, 64, 64, 64)); s.visible()) keys.push_back({s.depth_key, gaussians[i].id, i});
    splat::detail::heap_sort(keys.data(), static_cast<std::uint32_t>(keys.size()));
    std::uint32_t inversions = 0;
    for (std::size_t i = 1; i < keys.size(); ++i)
        inversions += gaussians[keys[i].slot].mean_world[2] >= gaussians[keys[i - 1].slot].mean_world[2] ? 0 : 1;
    REQUIRE(keys.size() > 3'000);
    CHECK(naive_inversions > 0);
    CHECK(inversions == 0);
    auto const picture = on_mesh(gaussians, camera);
    CHECK(support::differing_pixels(picture, report::render_naive(gaussians, camera, Rules{})) == 0);
    stability::report(
        {60, "5000 depths, 2 % NaN", std::to_string(naive_inversions) + " inversions", std::to_string(inversions) + " inversions", "exact", true});
}

TEST_CASE("row 61: a hundred thousand depths, no two equal keys")
{
    std::uint32_t const n = 100'000;
    support::Random random(61);
    std::vector<float> depths;
    for (std::uint32_t i = 0; i < n; ++i) depths.push_back(random.uniform(0.2f, 100));
    std::vector<std::pair<std::uint32_t, float>> coarse;
    std::vector<SortKey> keys;
    for (std::uint32_t i = 0; i < n; ++i) {
        coarse.emplace_back(static_cast<std::uint32_t>((depths[i] - 0.2f) / 99.8f * 65535), depths[i]);
        keys.push_back({bits_of(depths[i]), GaussianId{i + 1}, i});
    }
    std::stable_sort(coarse.begin(), coarse.end(), [](auto const& a, auto const& b) { return a.first < b.first; });
    splat::detail::heap_sort(keys.data(), n);
    std::uint32_t naive_ties = 0, naive_inversions = 0, ties = 0, inversions = 0, equal_depths = 0;
    for (std::uint32_t i = 1; i < n; ++i) {
        naive_ties += coarse[i].first == coarse[i - 1].first ? 1 : 0;
        naive_inversions += coarse[i].second < coarse[i - 1].second ? 1 : 0;
        ties += keys[i - 1] < keys[i] ? 0 : 1;
        inversions += depths[keys[i].slot] < depths[keys[i - 1].slot] ? 1 : 0;
        equal_depths += keys[i].depth_key == keys[i - 1].depth_key ? 1 : 0;
    }
    CHECK(naive_ties > n / 3);
    CHECK(naive_inversions > 0);
    CHECK(ties == 0);
    CHECK(inversions == 0);
    stability::report(
        {61, "100,000 depths in 0.2..100", std::to_string(naive_ties) + " ties, " + std::to_string(naive_inversions) + " inversions with 16-bit keys",
         std::to_string(ties) + " ties (" + std::to_string(equal_depths) + " equal depths), " + std::to_string(inversions) + " inversions", "exact",
         true});
}

TEST_CASE("row 62: sorted and equal keys cost no more compares than others")
{
    std::uint32_t const n = 3200;
    double const bound = 2.0 * n * std::log2(double{n});
    std::uint64_t const naive = std::uint64_t{n} * (n - 1) / 2; // a quicksort by the last key: each part has one key less
    std::uint64_t ours = 0;
    for (int kind = 0; kind < 4; ++kind) {
        std::vector<Counted> keys(n);
        support::Random random(62);
        for (std::uint32_t i = 0; i < n; ++i) keys[i].value = kind == 0 ? i : kind == 1 ? 7 : kind == 2 ? n - i : random.bits();
        Counted::compares = 0;
        splat::detail::heap_sort(keys.data(), n);
        ours = std::max(ours, Counted::compares);
        CHECK(std::is_sorted(keys.begin(), keys.end(), [](Counted a, Counted b) { return a.value < b.value; }));
    }
    CHECK(static_cast<double>(naive) > bound);
    CHECK(static_cast<double>(ours) <= bound);
    stability::report({62, "3200 keys, sorted or all equal", std::to_string(naive) + " compares", std::to_string(ours) + " compares",
                       "2 n log2 n = " + std::to_string(static_cast<int>(bound)), true});
}

TEST_CASE("row 63: what is behind the last key stays out of the sort")
{
    // Ten live keys, followed by one of an earlier frame that would be the smallest.
    std::uint32_t const n = 10;
    std::vector<std::uint32_t> live{50, 20, 90, 30, 70, 10, 80, 40, 60, 100, 1};
    auto naive = live, ours = live;
    std::sort(naive.begin(), naive.begin() + n + 1); // `n` as the last index
    splat::detail::heap_sort(ours.data(), n);
    CHECK(naive[0] == 1);
    CHECK(ours[0] == 10);
    CHECK(ours[n - 1] == 100);
    CHECK(ours[n] == 1);
    stability::report({63, "sort(0, n) with the last index meant", "a stale key is first", "untouched", "exact", true});
}
