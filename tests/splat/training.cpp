// test: optimised, without test asan tsan, needs data, cost 20
// The quality `training`: the rules of 3D Gaussian Splatting's rasteriser, one by one and together against a rasteriser of the test's own in
// double; and the background.
#include "blended.hpp"
#include "runner.hpp"
#include "scenes.hpp"
#include "training_reference.hpp"
#include <tilemesh/render/homes_renderer.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/scene/records.hpp>
#include <tilemesh/splat/quality.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;
using support::make_runner;

TILEMESH_EXACT_BEGIN
namespace {

using Colour = std::array<float, 3>;
constexpr Colour pink{0.75f, 0.25f, 0.5f};

Rules on(Rules rules, Colour const& background)
{
    for (std::size_t c = 0; c < 3; ++c) rules.background[c] = background[c];
    return rules;
}
Rules training(Colour const& background = {})
{
    return on(with_quality(Rules{}, Quality::training), background);
}

/// Looks along +z; a mean at (x, y, 65536) falls on pixel coordinate (x, y) without rounding. The lens is so long that slopes change no
/// variance by more than 1e-5.
Camera exact_camera(std::uint32_t width, std::uint32_t height)
{
    auto camera = support::flat_camera(width, height);
    camera.fx = camera.fy = 65536;
    return camera;
}
/// A ball whose projected variance is 99.9 pixels squared after the dilation, with the mean at (x, y) of `exact_camera`. With the least
/// difference of eigenvalues its radius is ceil(3 sqrt(99.9 + sqrt(0.1))) = 31; without, it would be 30. Alpha is above 1/255 up to a
/// distance of 33.27 pixels.
Gaussian wide_ball(float x, float y, std::uint32_t id = 1)
{
    auto g = support::ball(id, x, y, std::sqrt(99.6f), 1.0f);
    g.mean_world[2] = 65536;
    return g;
}

bool close(float a, double b) { return std::fabs(double{a} - b) <= 2e-6; }
bool shows(report::Image const& image, std::uint32_t x, std::uint32_t y)
{
    return image.pixel(x, y)[0] != 0;
}
bool same(report::Image const& a, report::Image const& b)
{
    return support::differing_pixels(a, b) == 0;
}
/// PSNR against a picture in double; peak 1.
double psnr(report::Image const& a, std::vector<double> const& b)
{
    double sum = 0;
    REQUIRE(a.rgb.size() == b.size());
    for (std::size_t i = 0; i < b.size(); ++i) sum += (double{a.rgb[i]} - b[i]) * (double{a.rgb[i]} - b[i]);
    return -10 * std::log10(sum / static_cast<double>(b.size()));
}
double largest_difference(std::vector<double> const& a, std::vector<double> const& b)
{
    double most = 0;
    REQUIRE(a.size() == b.size());
    for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::fabs(a[i] - b[i]));
    return most;
}
/// Frames of the program of homes, in chapters if `homes` a tile are too few for the map.
std::unique_ptr<render::Core> homes_of(scene::Map const& map, Rules const& rules, std::uint32_t homes = 1000, bool planes = false)
{
    auto choice = splat::homes_setup;
    choice.machine.sram_bytes = 1u << 24;
    choice.sizes.homes = homes;
    choice.rules = rules;
    choice.alpha = choice.depth = planes;
    return render::make_core(map, choice, {.threads = 2, .grid = {3, 2}, .held_slots = 50});
}
/// One pixel type, by the kernel of the rules' arithmetic.
template <class Pixel>
std::vector<Pixel> blended(support::SortedSplats const& v)
{
    return support::blend<splat::detail::lanes_in_use, Pixel>(v, v.rules.arithmetic, v.camera.width, v.camera.height).pixels;
}

/// A camera whose near plane lets the near records through that `training` culls, and culls others that it shows.
Camera nearer(float near_depth)
{
    auto camera = support::lens(150, 71, 0.05f);
    camera.near_depth = near_depth;
    return camera;
}
/// Larger splats than those of `cloud`, a third of them opaque or nearly opaque, so that many pixels stop.
std::vector<Gaussian> crowd(std::uint32_t n, std::uint64_t seed)
{
    auto all = support::cloud(n, seed);
    for (auto& g : all) {
        auto const id = static_cast<std::uint32_t>(g.id);
        for (float& s : g.log_scale) s += 1.5f;
        if (id % 3 == 0) g.opacity = id % 6 == 0 ? 0.9999f : 0.97f;
        if (id % 11 == 0) g.mean_world[2] *= 0.15f; // some nearer than 0.2
    }
    return all;
}

} // namespace
TILEMESH_EXACT_END

TEST_CASE("training: the constants of the rasteriser")
{
    auto const m = training();
    CHECK(std::string(name(Quality::training)) == "training");
    CHECK(m.alpha_min == 1.0f / 255);
    CHECK(m.alpha_max == 0.99f);
    CHECK(m.transmittance_min == 1e-4f);
    CHECK(m.stop == Stop::before_crossing);
    CHECK(m.footprint == Footprint::three_sigma_tiles);
    CHECK(m.near_plane == NearPlane::fixed);
    Rules odd;
    odd.dilation = 0, odd.jacobian_limit = 0, odd.arithmetic = Arithmetic::fast;
    CHECK(with_quality(odd, Quality::training).dilation == 0.3f);
    CHECK(with_quality(odd, Quality::training).jacobian_limit == 1.3f);
    CHECK(with_quality(odd, Quality::training).arithmetic == Arithmetic::fast);
}

TEST_CASE("training: alpha is at most 0.99, and the background shows through the rest")
{
    auto const camera = exact_camera(32, 16);
    auto g = wide_ball(8.5f, 8.5f);
    g.opacity = 0.995f;
    auto const image = report::render_naive(std::vector{g}, camera, training(pink));
    for (int c = 0; c < 3; ++c) CHECK(close(image.pixel(8, 8)[c], 0.99 * double{g.colour[c]} + 0.01 * double{pink[static_cast<std::size_t>(c)]}));
    // Without the clamp it would be 0.995.
    auto open = training(pink);
    open.alpha_max = 1;
    CHECK(close(report::render_naive(std::vector{g}, camera, open).pixel(8, 8)[0], 0.995 * double{g.colour[0]} + 0.005 * double{pink[0]}));
}

TEST_CASE("training: a pixel stops before the term that would leave less than 1e-4, and adds the background to what is left")
{
    auto const camera = exact_camera(32, 16);
    std::vector<Gaussian> layers;
    for (float const opacity : {1.0f, 0.9f, 0.95f, 0.1f}) {
        layers.push_back(wide_ball(8.5f, 8.5f, static_cast<std::uint32_t>(layers.size()) + 1));
        layers.back().opacity = opacity;
        for (float& c : layers.back().colour) c = opacity == 0.95f ? 100.0f : 1.0f;
    }
    // Two layers leave 0.01 and 0.001. The third would leave 5e-5. The fourth would leave enough, but comes behind the stop.
    auto const stopped = report::render_naive(layers, camera, training(pink));
    for (int c = 0; c < 3; ++c) CHECK(close(stopped.pixel(8, 8)[c], 0.999 + 0.001 * double{pink[static_cast<std::size_t>(c)]}));
    auto blends = training(pink);
    blends.stop = Stop::after_crossing;
    CHECK(close(report::render_naive(layers, camera, blends).pixel(8, 8)[0], 0.999 + 0.00095 * 100 + 5e-5 * double{pink[0]}));
    // A third layer of 0.85 leaves 1.5e-4, and the fourth one is blended.
    layers[2].opacity = 0.85f;
    CHECK(close(report::render_naive(layers, camera, training(pink)).pixel(8, 8)[0],
                0.999 + 0.00085 * 100 + 1.5e-5 + 1.35e-4 * double{pink[0]}));
}

TEST_CASE("training: a splat is in the 16 x 16 tiles that its square touches, as the rasteriser counts them")
{
    auto const camera = exact_camera(120, 70);
    auto square_alone = training();
    square_alone.footprint = Footprint::three_sigma_square;
    struct Row {
        float middle; ///< the mean is so many pixels right of, or below, the middle of the first pixel
        std::uint32_t pixel;
        bool shows;
        std::optional<bool> in_square{}; ///< with the footprint of the square alone
    };
    for (Row const& row :
         {// The far end: 34 + 31 = 65 touches the tile of pixels 64 to 79, anything less does not, although pixel 64 is within 3 sigma.
          Row{34, 64, true},
          {34, 66, true, false}, // outside the square, in a tile that it touches
          {33.9375f, 64, false, true},
          {33.9375f, 63, true},
          // The near end: 47 - 31 = 16 touches the tile of pixels 16 to 31, anything less the first tile too.
          {47, 15, false},
          {47, 16, true},
          {46.9375f, 15, true},
          {46.9375f, 14, true}, // 32.94 pixels from the mean, outside the square
          // The borders of the frame: a square that reaches less than a pixel into it is not drawn; the last tile is cut by the frame.
          {-30, 0, true},
          {-30.0625f, 0, false, true},
          {150.5f, 119, true}})
        for (bool const down : {false, true}) {
            if (down && row.middle > 100) continue; // the frame has 70 rows
            CAPTURE(row.middle);
            CAPTURE(row.pixel);
            CAPTURE(down);
            std::vector const one{down ? wide_ball(40.5f, row.middle + 0.5f) : wide_ball(row.middle + 0.5f, 40.5f)};
            auto const seen = [&](Rules const& rules) {
                return shows(report::render_naive(one, camera, rules), down ? 40 : row.pixel, down ? row.pixel : 40);
            };
            CHECK(seen(training()) == row.shows);
            if (row.in_square) CHECK(seen(square_alone) == *row.in_square);
            // All of it agrees with the rasteriser in double.
            CHECK(psnr(report::render_naive(one, camera, training()), support::rasterised(one, camera, {})) > 120);
        }
}

TEST_CASE("training: means at a depth of 0.2 or nearer are culled, whatever the camera says")
{
    auto camera = support::flat_camera(32, 16);
    camera.cx = 16, camera.cy = 8;
    auto g = support::ball(1, 0, 0, 1e-4f);
    for (float const near_depth : {0.01f, 0.2f, 5.0f}) {
        CAPTURE(near_depth);
        camera.near_depth = near_depth;
        g.mean_world[2] = 0.2f;
        CHECK_FALSE(shows(report::render_naive(std::vector{g}, camera, training()), 16, 8));
        g.mean_world[2] = std::nextafter(0.2f, 1.0f);
        CHECK(shows(report::render_naive(std::vector{g}, camera, training()), 16, 8));
        CHECK(report::render_double(std::vector{g}, camera, training(), report::Cuts::same).pixel(16, 8)[0] > 0);
        // Other qualities have the camera's plane.
        CHECK(shows(report::render_naive(std::vector{g}, camera, Rules{}), 16, 8) == (g.mean_world[2] > near_depth));
    }
}

TEST_CASE("training: at least 90 dB against the rasteriser in double, which the library's reference equals")
{
    std::vector<std::pair<scene::Map, Camera>> views;
    for (std::uint64_t seed : {71u, 72u, 73u})
        for (float const near_depth : {0.01f, 2.0f}) views.emplace_back(support::map_of(crowd(500, seed)), nearer(near_depth));
    if (char const* const name = std::getenv("TILEMESH_STAND_IN"); name == nullptr || *name == '\0') {
        auto const& s = support::scenes<640>().front(); // Sloth where there are real maps
        auto camera = s.cameras.front().second;
        if (!support::fast()) views.emplace_back(scene::built_in_map(), scene::built_in_camera({640, 360}));
        if (!support::data().empty()) views.emplace_back(s.map, camera);
    }
    for (std::size_t i = 0; i < views.size(); ++i) {
        CAPTURE(i);
        auto map = scene::at_degree(views[i].first, 0);
        auto const& camera = views[i].second;
        auto const truth = support::rasterised(map.gaussians, camera, pink);
        CHECK(largest_difference(truth, report::render_double_unrounded(map.gaussians, camera, training(pink), report::Cuts::same, 2)) < 1e-7);
        for (auto const arithmetic : {Arithmetic::precise, Arithmetic::fast}) {
            auto const runner = make_runner<support::Referenced<support::Whole>>(
                map, {.threads = 2, .grid = {8, 8}, .arithmetic = arithmetic, .quality = Quality::training, .background = pink,
                      .sizes = support::sized<support::Whole>(400, static_cast<std::uint32_t>(map.gaussians.size()) + 1, 400)});
            auto const frame = runner->render(camera);
            REQUIRE(frame.report.lost.empty());
            auto const decibels = psnr(frame.image, truth);
            MESSAGE("view ", i, std::string(arithmetic == Arithmetic::fast ? ", fast: " : ", precise: "), decibels, " dB");
            CHECK(decibels >= 90);
        }
    }
}

TEST_CASE("training: the naive loop's bits for any tiling, threads, engine and program; fast has its own bits everywhere")
{
    auto const map = support::map_of(crowd(700, 81));
    auto const camera = nearer(0.01f);
    auto const naive = report::render_naive(map.gaussians, camera, training(pink));
    auto const slots = support::sized<support::Whole>(400, 1000);
    report::Image first_fast;
    std::uint64_t contributing = 0;
    for (auto const arithmetic : {Arithmetic::precise, Arithmetic::fast}) {
        auto rules = training(pink);
        rules.arithmetic = arithmetic;
        report::Image expected = naive;
        bool first = true;
        auto const check = [&](RenderedFrame const& frame) {
            REQUIRE(frame.report.lost.empty());
            if (first && arithmetic == Arithmetic::fast) expected = frame.image;
            if (first) contributing = frame.report.pairs_contributing;
            first = false;
            CHECK(same(frame.image, expected));
            CHECK(frame.report.pairs_contributing == contributing);
        };
        for (auto const& tile : {Extent2{32, 20}, Extent2{16, 16}, Extent2{13, 7}, Extent2{150, 71}})
            for (std::uint32_t const threads : {1u, 2u, 3u})
                check(make_runner<support::Referenced<support::Whole>>(map, {.threads = threads, .tile = tile, .arithmetic = arithmetic,
                                                                             .quality = Quality::training, .background = pink, .sizes = slots})
                          ->render(camera));
        check(make_runner<support::Whole, CheckedMesh>(
                  map, {.tile = {32, 20}, .arithmetic = arithmetic, .quality = Quality::training, .background = pink, .sizes = slots})
                  ->render(camera));
        check(homes_of(map, rules)->render(camera));
        check(homes_of(map, rules, 50)->render(camera)); // 300 homes for 700 records: chapters
    }
}

TEST_CASE("training: planes; a pixel that stopped keeps its alpha, and the background changes neither alpha nor depth")
{
    using Planes = WithAlpha<WithDepth<FloatPixel>>;
    auto const records = crowd(500, 91);
    support::SortedSplats const black(records, nearer(0.2f), training()), pinks(records, nearer(0.2f), training(pink));
    auto const a = blended<Planes>(black), b = blended<Planes>(pinks);
    auto const bytes = blended<WithAlpha<Rgbx8Pixel>>(pinks);
    auto crossing = training(pink);
    crossing.stop = Stop::after_crossing;
    auto const c = blended<Planes>(support::SortedSplats(records, nearer(0.2f), crossing));
    std::uint64_t stopped = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        CHECK(a[i].alpha == b[i].alpha);
        CHECK(a[i].colour.depth == b[i].colour.depth);
        CHECK((a[i].alpha >= 0 && a[i].alpha <= 1 - 1e-4f));
        stopped += c[i].alpha > 1 - 1e-4f ? 1 : 0;
        for (std::size_t k = 0; k < 3; ++k) {
            float const colour = b[i].colour.colour.rgb[k];
            CHECK(close(colour, double{a[i].colour.colour.rgb[k]} + (1 - double{a[i].alpha}) * double{pink[k]}));
            CHECK((bytes[i].colour.word >> (8 * k) & 255u) == Rgbx8Pixel::level(colour));
        }
    }
    CHECK(stopped > 100); // with this rule none of them has so little left
    // Homes have the same planes, also in chapters.
    auto const frame = homes_of(support::map_of(records), training(pink), 30, true)->render(nearer(0.2f));
    for (std::uint32_t y = 0; y < 71; ++y)
        for (std::uint32_t x = 0; x < 150; ++x) {
            auto const& pixel = b[std::size_t{y} * 150 + x];
            REQUIRE(frame.alpha.at(x, y) == pixel.alpha);
            REQUIRE(frame.depth.at(x, y) == pixel.colour.depth);
            REQUIRE(std::memcmp(frame.image.pixel(x, y), pixel.colour.colour.rgb, 12) == 0);
        }
}

TEST_CASE("background: C + T background under every quality, in every program; an empty pixel is the background")
{
    auto const map = support::map_of(support::cloud(60, 5));
    auto const camera = support::lens(96, 64);
    std::vector<Rules> models{Rules{}};
    for (auto const quality : {Quality::evaluation, Quality::viewing, Quality::on_sensor, Quality::training})
        models.push_back(with_quality({}, quality));
    for (auto const& rules : models) {
        support::SortedSplats const scene(map.gaussians, camera, rules);
        auto const alone = blended<WithAlpha<FloatPixel>>(scene);
        auto const image = report::render_naive(map.gaussians, camera, on(rules, pink));
        std::uint64_t empty = 0;
        for (std::size_t i = 0; i < alone.size(); ++i) {
            empty += alone[i].alpha == 0 ? 1 : 0;
            for (std::size_t c = 0; c < 3; ++c)
                CHECK(close(image.rgb[3 * i + c], double{alone[i].colour.rgb[c]} + (1 - double{alone[i].alpha}) * double{pink[c]}));
        }
        CHECK(empty > 0);
        CHECK(psnr(image, report::render_double_unrounded(map.gaussians, camera, on(rules, pink), report::Cuts::same)) > 90);
        auto const runner = make_runner<support::Referenced<support::Whole>>(map, {.tile = {16, 8}});
        runner->rules() = on(rules, pink);
        CHECK(same(runner->render(camera).image, image));
        CHECK(same(homes_of(map, on(rules, pink))->render(camera).image, image));
    }
    // Tiles without a record, on a mesh and with homes.
    auto away = camera;
    away.position[2] = 100;
    auto const runner = make_runner<support::Referenced<support::Whole>>(map, {.tile = {16, 8}, .background = pink});
    auto const checked = make_runner<support::Whole, CheckedMesh>(map, {.tile = {16, 8}, .background = pink});
    for (auto const& frame : {runner->render(away), checked->render(away), homes_of(map, on({}, pink))->render(away)})
        for (std::uint32_t y = 0; y < 64; ++y)
            for (std::uint32_t x = 0; x < 96; ++x) REQUIRE(std::memcmp(frame.image.pixel(x, y), pink.data(), 12) == 0);
}

TEST_CASE("background: no frame keeps that of another one, and black is what it was without")
{
    auto const map = support::map_of(crowd(300, 17));
    auto const camera = support::lens(96, 64);
    auto const without = report::render_naive(map.gaussians, camera, Rules{});
    auto const tiles = make_runner<support::Referenced<support::Whole>>(map, {.threads = 2, .tile = {16, 8}});
    auto const homes = homes_of(map, Rules{});
    for (auto const& background : {Colour{}, pink, pink, Colour{1, 1, 1}, Colour{0, 0, 1}, Colour{}}) {
        tiles->rules() = on(Rules{}, background);
        homes->rules() = on(Rules{}, background);
        auto const expected = report::render_naive(map.gaussians, camera, on(Rules{}, background));
        CHECK(same(expected, without) == (background == Colour{}));
        CHECK(same(tiles->render(camera).image, expected));
        CHECK(same(homes->render(camera).image, expected));
    }
}

TEST_CASE("training: a footprint of its own replaces the quality's")
{
    RendererOptions const square{.footprint = Footprint::three_sigma_square, .quality = Quality::training};
    CHECK(with_options(Rules{}, square).footprint == Footprint::three_sigma_square);
    CHECK(with_options(Rules{}, square).stop == Stop::before_crossing);
    auto const homes = homes_of(support::map_of(crowd(300, 23)), with_options(Rules{}, square));
    CHECK(homes->rules().footprint == Footprint::three_sigma_square);
}
