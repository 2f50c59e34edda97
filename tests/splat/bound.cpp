// test: optimised, cost 8
// The bound of float32 pictures against the enclosure of the exact formula: no channel escapes, for any rules, degrees and tilings.
#include "../compare_reports.hpp"
#include "../report/stiff_scene.hpp"
#include "../standard.hpp"
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/report/detail/ball.hpp>
#include <tilemesh/report/enclosure.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/splat/bounded.hpp>

namespace {

using namespace tilemesh;
using splat::BoundedSplat, splat::SortKey;
using tests::Random;
using tests::StiffScene;

/// A tile's list, in the order of the keys or in another one, and its pixels.
template <class Record>
struct Frame {
    Frame(std::vector<Record> const& records, splat::Camera const& camera, splat::Rules const& rules)
    {
        frame.view = splat::make_view(camera, rules);
        frame.tiling = splat::make_tiling(camera.width, camera.height, camera.width, camera.height);
        for (auto const& g : records) {
            auto const s = splat::Access<splat::BoundParameters>::project(g, frame);
            if (!s.visible()) continue;
            keys.push_back({s.depth_key, g.id, static_cast<std::uint32_t>(splats.size())});
            splats.push_back(s);
            wild += s.error.is_wild() ? 1 : 0;
        }
        std::sort(keys.begin(), keys.end());
    }
    void blend(std::uint32_t workers = 1)
    {
        auto const& c = frame.view.camera;
        pixels.assign(std::size_t{c.width} * c.height, {});
        splat::SplatsInOrder<BoundedSplat> const at{splats.data(), keys.data()};
        for (std::uint32_t w = 0; w < workers; ++w)
            splat::BlendBounded::tile({0, c.width, 0, c.height}, frame, static_cast<std::uint32_t>(keys.size()), at, pixels.data(), c.width,
                                      Worker{w, workers});
    }
    /// The picture of `fast`, with the bounds that the pixels have.
    void blend_fast()
    {
        auto const& c = frame.view.camera;
        auto const bounds = pixels;
        splat::PairCount pairs{};
        splat::blend_whole_tile(
            {0, c.width, 0, c.height}, c, frame.view.rules, static_cast<std::uint32_t>(keys.size()),
            [&](std::uint32_t i) noexcept { return splats[keys[i].slot].own(); }, pixels.data(), c.width, &pairs, 1u);
        for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i].alpha = bounds[i].alpha;
    }
    splat::BoundParameters frame{};
    std::vector<BoundedSplat> splats;
    std::vector<SortKey> keys;
    std::vector<splat::WithAlpha<splat::FloatPixel>> pixels;
    std::uint32_t wild = 0;
};

struct Sum {
    std::uint64_t values = 0, escapes = 0, wild = 0;
    std::vector<double> bounds;
    double closest = 0;
};
template <class Pixels>
void compare(Sum& sum, Pixels const& pixels, report::Enclosure const& e)
{
    REQUIRE(3 * pixels.size() == e.middle.size());
    for (std::size_t i = 0; i < e.middle.size(); ++i) {
        auto const& pixel = pixels[i / 3];
        double const off = std::fabs(double{pixel.colour.rgb[i % 3]} - e.middle[i]) - e.radius[i], bound = double{pixel.alpha};
        sum.escapes += off <= bound ? 0 : 1; // NaN is one
        sum.closest = std::max(sum.closest, off / bound);
        if (i % 3 == 0) sum.bounds.push_back(255 * bound);
    }
    sum.values += e.middle.size();
}
template <class Record>
void compare(Sum& sum, std::uint32_t n)
{
    StiffScene<Record> s(n);
    auto const exact = report::enclose(s.records, s.c, s.rules);
    s.rules.arithmetic = splat::Arithmetic::precise;
    Frame<Record> frame(s.records, s.c, s.rules);
    frame.blend(1 + n % 6);
    sum.wild += frame.wild;
    compare(sum, frame.pixels, exact);
    s.rules.arithmetic = splat::Arithmetic::fast; // the bound of both pictures
    Frame<Record> both(s.records, s.c, s.rules);
    both.blend();
    compare(sum, both.pixels, exact);
    both.blend_fast();
    compare(sum, both.pixels, exact);
}

/// 16 x 16 pixels, 45 degrees.
splat::Camera small_camera()
{
    splat::Camera c{};
    c.width = c.height = 16, c.fx = c.fy = 16, c.cx = c.cy = 8.25f, c.near_depth = 0.2f;
    for (int i = 0; i < 3; ++i) c.rotation[i][i] = 1;
    return c;
}
/// n Gaussians one behind the other, and what a pixel sees of one. Their colours: at least .5, or 0 and 1.
struct Behind {
    splat::Camera camera = small_camera();
    std::vector<splat::Gaussian> records;
    Behind(std::uint32_t n, bool black_and_white, Random& random)
    {
        for (std::uint32_t i = 0; i < n; ++i) {
            auto& g = records.emplace_back();
            g = {};
            g.mean_world[0] = random.uniform(-.5f, .5f), g.mean_world[1] = random.uniform(-.5f, .5f), g.mean_world[2] = 2 + static_cast<float>(i);
            for (float& q : g.rotation) q = random.uniform(-1, 1);
            for (float& v : g.log_scale) v = random.uniform(-3, 0);
            for (float& v : g.colour) v = black_and_white ? static_cast<float>(i) : random.uniform(.5f, 1);
            g.opacity = random.uniform(.4f, .8f), g.id = splat::GaussianId{i + 1};
        }
    }
    float alpha(std::size_t i, std::uint32_t x, std::uint32_t y) const
    {
        auto const s = splat::project(records[i], splat::make_view(camera, {}), {16, 16});
        return splat::alpha_at(s, static_cast<float>(x) + 0.5f - camera.cx, static_cast<float>(y) + 0.5f - camera.cy);
    }
};

TEST_CASE("no channel of stiff scenes escapes its bound: all rules, all degrees, needles, walls, opaque and huge splats")
{
    Sum sum;
    for (std::uint32_t n = 0; n < (tests::fast() ? 16 : 220); ++n) {
        if (n % 4 == 0) compare<splat::Gaussian>(sum, n);
        else if (n % 4 == 1) compare<splat::ShadedGaussian<1>>(sum, n);
        else if (n % 4 == 2) compare<splat::ShadedGaussian<2>>(sum, n);
        else compare<splat::ShadedGaussian<3>>(sum, n);
    }
    CHECK(sum.escapes == 0);
    std::sort(sum.bounds.begin(), sum.bounds.end());
    CHECK(sum.bounds[sum.bounds.size() / 2] < 0.1); // levels: a bound that says nothing would be easy
    CHECK(sum.closest > 0.01);
    MESSAGE(sum.values << " values, median " << sum.bounds[sum.bounds.size() / 2] << ", p99 " << sum.bounds[sum.bounds.size() * 99 / 100]
                       << " levels, largest error / bound " << sum.closest << ", " << sum.wild << " wild splats");
}

/// An error in every splat that is a hundredth of what is derived lets values escape.
TEST_CASE("the bound is not a hundred times too large where needles decide")
{
    std::uint64_t escapes = 0;
    for (std::uint32_t n = 1; n < 60; n += 5) { // needles
        StiffScene<splat::Gaussian> const s(n);
        Frame<splat::Gaussian> frame(s.records, s.c, s.rules);
        for (auto& splat : frame.splats) splat.error.r0 *= 0.01f, splat.error.r2 *= 0.01f;
        frame.blend();
        Sum sum;
        compare(sum, frame.pixels, report::enclose(s.records, s.c, s.rules));
        escapes += sum.escapes;
    }
    CHECK(escapes > 0);
}

TEST_CASE("a float that decides otherwise at the cut, or at the stop, is bounded")
{
    Random random(11);
    Sum sum;
    std::uint32_t cuts = 0, stops = 0;
    for (std::uint32_t n = 0; n < 200; ++n) {
        Behind const scene(3, false, random);
        auto const& [c, records] = scene;
        splat::Rules rules;
        bool const at_cut = n % 2 == 0;
        std::uint32_t const x = n % 8 + 4, y = n / 8 % 8 + 4;
        float const first = scene.alpha(0, x, y), second = scene.alpha(1, x, y);
        if (first < 0.01f || second < 0.01f) continue;
        if (at_cut) rules.alpha_min = first;
        else if (n % 4 == 1) rules.transmittance_min = 1 - first;
        else rules.transmittance_min = 1 - first, rules.stop = splat::Stop::before_crossing;
        Frame<splat::Gaussian> frame(records, c, rules);
        frame.blend();
        auto const e = report::enclose(records, c, rules);
        compare(sum, frame.pixels, e);
        double const off = std::fabs(double{frame.pixels[y * 16 + x].colour.rgb[0]} - e.middle[3 * (y * 16 + x)]);
        (at_cut ? cuts : stops) += off > 0.001 ? 1 : 0;
    }
    CHECK(sum.escapes == 0);
    CHECK(cuts > 3); // the floats did decide otherwise
    CHECK(stops > 5);
}

/// The float stops at the first splat, within its error of the limit, and the second is within its error of the cut: the exact formula may see it.
TEST_CASE("a colour behind a doubtful stop and at a doubtful cut is bounded")
{
    Random random(1);
    Sum sum;
    std::uint32_t tried = 0;
    for (std::uint32_t n = 0; n < 1500; ++n) {
        Behind const scene(2, true, random);
        auto const& [c, records] = scene;
        splat::Rules rules;
        if (n % 4 == 3) rules.stop = splat::Stop::before_crossing;
        float const first = scene.alpha(0, n % 8 + 4, n / 8 % 8 + 4), second = scene.alpha(1, n % 8 + 4, n / 8 % 8 + 4);
        if (first < 0.05f || second < 0.02f || first < 1.5f * second) continue;
        rules.transmittance_min = std::nextafter(1 - first, 2.0f), rules.alpha_min = std::nextafter(second, 2.0f);
        Frame<splat::Gaussian> frame(records, c, rules);
        frame.blend();
        compare(sum, frame.pixels, report::enclose(records, c, rules));
        ++tried;
    }
    CHECK(tried > 100);
    CHECK(sum.escapes == 0);
}

TEST_CASE("tiles that cut blocks count the pairs of `precise`, and have the bounds of the whole frame")
{
    StiffScene<splat::Gaussian> const s(4);
    Frame<splat::Gaussian> frame(s.records, s.c, s.rules);
    frame.blend();
    auto const n = static_cast<std::uint32_t>(frame.keys.size());
    splat::SplatsInOrder<BoundedSplat> const at{frame.splats.data(), frame.keys.data()};
    auto const own = [&](std::uint32_t i) noexcept { return frame.splats[frame.keys[i].slot].own(); };
    auto precise = s.rules;
    precise.arithmetic = splat::Arithmetic::precise;
    std::uint32_t contributing = 0;
    for (auto const& rect : {splat::PixelRect{0, 24, 0, 48}, splat::PixelRect{24, 39, 0, 7}, splat::PixelRect{24, 39, 7, 48}, splat::PixelRect{39, 64, 0, 48}}) {
        std::vector<splat::WithAlpha<splat::FloatPixel>> bounded(std::size_t{64} * 48), whole(bounded.size());
        std::vector<splat::FloatPixel> plain(bounded.size());
        splat::PairCount of_whole{}, of_plain{};
        auto const of_tile = splat::BlendBounded::tile(rect, frame.frame, n, at, bounded.data(), 64, Worker{0, 1});
        splat::BlendBounded::whole(rect, frame.frame, n, at, whole.data(), 64, &of_whole, 1u);
        splat::blend_whole_tile(rect, s.c, precise, n, own, plain.data(), 64, &of_plain, 1u);
        CHECK(of_tile.contributing == of_plain.contributing);
        CHECK(of_whole.contributing == of_plain.contributing);
        CHECK(of_tile.evaluated == of_whole.evaluated);
        contributing += of_tile.contributing;
        std::uint32_t other = 0;
        for (std::uint32_t y = rect.y0; y < rect.y1; ++y)
            for (std::uint32_t x = rect.x0; x < rect.x1; ++x) {
                auto const at_tile = std::size_t{64} * (y - rect.y0) + (x - rect.x0);
                auto const& want = frame.pixels[std::size_t{64} * y + x];
                for (auto const* got : {&bounded[at_tile], &whole[at_tile]}) other += std::memcmp(got, &want, sizeof want) != 0 ? 1 : 0;
                other += std::memcmp(&plain[at_tile], &want.colour, sizeof want.colour) != 0 ? 1 : 0;
            }
        CHECK(other == 0);
    }
    CHECK(contributing > 1000);
}

TEST_CASE("depths are compared exactly, and a run in another order is bounded")
{
    Random random(3);
    auto c = small_camera();
    c.cx = c.cy = 8;
    for (int i = 0; i < 20'000; ++i) {
        for (float& v : c.rotation[2]) v = random.uniform(-1, 1);
        float a[3], b[3];
        for (int k = 0; k < 3; ++k) a[k] = random.uniform(-4, 4), b[k] = i % 3 == 0 ? a[k] : std::nextafter(a[k], random.uniform(-9, 9));
        report::detail::ExactSum exact;
        for (int k = 0; k < 3; ++k) exact.add_product(c.rotation[2][k], a[k], 1), exact.add_product(c.rotation[2][k], b[k], -1);
        if (splat::detail::depth_order(c, a, b) != exact.sign()) FAIL_CHECK("pair ", i);
    }
    float const tiny[3] = {1e-35f, 0, 0}, zero[3] = {0, 0, 0};
    c.rotation[2][0] = 1e-6f;
    CHECK(splat::detail::depth_order(c, tiny, zero) == 2); // a product that is not exact
    CHECK(splat::detail::depth_order(c, zero, zero) == 0);

    // Twelve splats of one key, blended in the wrong order.
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) c.rotation[i][k] = i == k ? 1.0f : 0.0f;
    std::vector<splat::Gaussian> records;
    for (std::uint32_t i = 0; i < 12; ++i) {
        splat::Gaussian g{};
        g.mean_world[0] = random.uniform(-.3f, .3f), g.mean_world[1] = random.uniform(-.3f, .3f), g.mean_world[2] = 2, g.rotation[0] = 1;
        for (float& v : g.log_scale) v = -1.5f;
        for (float& v : g.colour) v = random.uniform(0, 1);
        g.opacity = 0.3f, g.id = splat::GaussianId{i + 1};
        records.push_back(g);
    }
    splat::Rules rules;
    Frame<splat::Gaussian> frame(records, c, rules);
    Sum right, wrong, unsaid;
    auto const e = report::enclose(records, c, rules);
    frame.blend();
    compare(right, frame.pixels, e);
    std::reverse(frame.keys.begin(), frame.keys.end());
    frame.blend();
    compare(wrong, frame.pixels, e);
    for (std::uint32_t i = 0; i < frame.keys.size(); ++i) frame.keys[i].depth_key += 32 * i; // nobody would look
    frame.blend();
    compare(unsaid, frame.pixels, e);
    CHECK(right.escapes == 0);
    CHECK(*std::max_element(right.bounds.begin(), right.bounds.end()) < 0.1);
    CHECK(wrong.escapes == 0);
    CHECK(unsaid.escapes > 100);
}

TEST_CASE("a mesh that bounds: the picture of `precise`, one bound for all tilings, threads and engines, and no escape; `fast` too")
{
    auto map = scene::built_in_map();
    for (std::size_t i = 0; i < map.gaussians.size() / 8; ++i) map.gaussians[i] = map.gaussians[8 * i]; // so that few tiles have room
    map.gaussians.resize(map.gaussians.size() / 8);
    auto const camera = scene::built_in_camera({160, 90});
    splat::Rules rules = splat::lossless.rules;
    for (auto const arithmetic : {splat::Arithmetic::precise, splat::Arithmetic::fast}) {
        if (tests::fast() && arithmetic == splat::Arithmetic::fast) break;
        RendererOptions options{.arithmetic = arithmetic};
        auto const render = [&]<class R>(std::type_identity<R>, Grid grid, unsigned threads) {
            options.grid = grid, options.threads = threads;
            R renderer(map, options);
            auto frame = renderer.render(camera);
            rules = renderer.rules();
            CHECK(frame.report.lost.empty());
            return frame;
        };
        auto const first = render(std::type_identity<BasicRenderer<splat::Bounded>>{}, {40, 36}, 1);
        auto const plain = render(std::type_identity<BasicRenderer<splat::Lossless>>{}, {40, 36}, 2);
        for (auto const grid : {Grid{20, 18}, Grid{37, 11}}) {
            auto const other = render(std::type_identity<BasicRenderer<splat::Bounded>>{}, grid, 2);
            CHECK(other.image.rgb == first.image.rgb);
            CHECK(other.alpha.values == first.alpha.values);
        }
        auto const again = render(std::type_identity<BasicRenderer<splat::Bounded>>{}, {40, 36}, 3);
        CHECK(again.alpha.values == first.alpha.values);
        CHECK(report::first_difference(again.report, first.report) == "");
        if (arithmetic == splat::Arithmetic::precise) {
            CHECK(first.image.rgb == plain.image.rgb);
            auto const checked = render(std::type_identity<BasicRenderer<splat::Bounded, CheckedMesh>>{}, {40, 36}, 1);
            CHECK(checked.alpha.values == first.alpha.values);
            CHECK(report::first_difference(checked.report, first.report) == "");
        }
        auto const e = report::enclose(map.gaussians, camera, rules, {.threads = 2});
        std::uint64_t escapes = 0;
        double largest = 0;
        for (auto const* image : {&first.image, &plain.image})
            for (std::size_t i = 0; i < e.middle.size(); ++i) {
                double const bound = double{first.alpha.values[i / 3]};
                escapes += std::fabs(double{image->rgb[i]} - e.middle[i]) - e.radius[i] <= bound ? 0 : 1;
                largest = std::max(largest, 255 * bound);
            }
        CHECK(escapes == 0);
        CHECK(largest < 20);
        MESSAGE("largest bound " << largest << " levels");
    }
}

} // namespace
