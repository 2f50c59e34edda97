// test: unoptimised asan, without tsan
#include "runner.hpp"

using namespace tilemesh;
using namespace tilemesh::splat;
using support::make_runner;

namespace {
Splat splat_of(Gaussian const& g, Camera const& camera, Rules const& rules = {})
{
    return project(g, make_view(camera, rules), make_tiling(camera.width, camera.height, camera.width, camera.height));
}
/// May a pixel of the block see the splat? The arguments are the block's outermost centres, relative to the mean.
bool reaches(Splat const& s, float x0, float x1, float y0, float y1)
{
    namespace detail = tilemesh::splat::detail;
    detail::Chunk<4> chunk{};
    for (std::uint32_t i = 0; i < 4; ++i) chunk.take(i, s);
    chunk.complete<4>(4);
    auto const lanes = [](float v) { return detail::broadcast<4>(v); };
    return detail::reaches<4>(chunk, 0, lanes(x0), lanes(x1), lanes(y0), lanes(y1))[0] != 0;
}
template <class S = support::Whole>
report::Image on_mesh(std::vector<Gaussian> const& gaussians, Camera const& camera, RendererOptions options = {.grid = {1, 1}},
                      Rules const* rules = nullptr)
{
    options.sizes = support::sized<S>(50, 500);
    auto const runner = make_runner<S>(support::map_of(gaussians), options);
    if (rules != nullptr) runner->rules() = *rules;
    return runner->render(camera).image;
}
} // namespace

TEST_CASE("block cull: never leaves out a block in which a pixel sees the splat")
{
    auto const camera = support::lens(256, 128);
    std::uint64_t kept = 0, seen = 0, all = 0;
    auto gaussians = support::cloud(1500, 51);
    for (auto& g : gaussians) // needles and discs: a cull by the nearest box point fails for them
        if (static_cast<std::uint32_t>(g.id) % 2 == 0) g.log_scale[0] += 2, g.log_scale[1] -= 3;
    for (auto const& g : gaussians) {
        auto const s = splat_of(g, camera);
        if (!s.visible()) continue;
        for (std::uint32_t by = 0; by < 125; by += 5)
            for (std::uint32_t bx = 0; bx < 256; bx += 16) {
                bool sees = false;
                for (std::uint32_t y = by; y < by + 5; ++y)
                    for (std::uint32_t x = bx; x < bx + 16; ++x)
                        sees = sees || alpha_at(s, float(x) + 0.5f - camera.cx, float(y) + 0.5f - camera.cy) >= 1.0f / 255;
                float const x0 = float(bx) + 0.5f - camera.cx - s.mean_px[0], y0 = float(by) + 0.5f - camera.cy - s.mean_px[1];
                bool const keeps = reaches(s, x0, x0 + 15, y0, y0 + 4);
                if (sees && !keeps) FAIL("block ", bx, ",", by, " of Gaussian ", static_cast<std::uint32_t>(g.id));
                kept += keeps;
                seen += sees;
                ++all;
            }
    }
    CHECK(seen > 1000);
    CHECK(kept < seen + seen / 20); // and it rarely keeps one without need
    CHECK(kept < all / 4);
}

TEST_CASE("compositing: one Gaussian on its own centre gives opacity times colour")
{
    auto camera = support::flat_camera(40, 40);
    camera.cx = camera.cy = 20.5f; // the centre of pixel 20
    std::vector<Gaussian> one{support::ball(1, 0, 0, 3, 0.75f)};
    auto const image = on_mesh(one, camera);
    for (int c = 0; c < 3; ++c) CHECK(image.pixel(20, 20)[c] == 0.75f * one[0].colour[c]);
    CHECK(image.pixel(0, 0)[0] == 0.0f);
}

TEST_CASE("compositing: front to back, and ties in depth by id")
{
    auto camera = support::flat_camera(20, 20);
    camera.cx = camera.cy = 10.5f;
    auto red = support::ball(2, 0, 0, 3, 0.5f), blue = support::ball(1, 0, 0, 3, 0.5f);
    red.colour[0] = 1, red.colour[1] = red.colour[2] = 0;
    blue.colour[2] = 1, blue.colour[0] = blue.colour[1] = 0;
    auto image = on_mesh({red, blue}, camera); // equal depth: id 1, blue, is in front
    CHECK(image.pixel(10, 10)[2] == 0.5f);
    CHECK(image.pixel(10, 10)[0] == 0.25f);
    red.mean_world[2] = std::nextafter(1000.0f, 0.0f); // an ulp nearer: red is in front
    image = on_mesh({red, blue}, camera);
    CHECK(image.pixel(10, 10)[0] == doctest::Approx(0.5f));
    CHECK(image.pixel(10, 10)[2] == doctest::Approx(0.25f));
    CHECK(image.pixel(10, 10)[0] > image.pixel(10, 10)[2]);
}

TEST_CASE("compositing: opaque layers hide what is behind them exactly, with the 0.99 clamp they do not")
{
    auto camera = support::flat_camera(20, 20);
    camera.cx = camera.cy = 10.5f;
    auto black = support::ball(1, 0, 0, 50, 1.0f), white = support::ball(2, 0, 0, 50, 1.0f);
    for (int c = 0; c < 3; ++c) black.colour[c] = 0, white.colour[c] = 1;
    CHECK(on_mesh({black, white}, camera).pixel(10, 10)[0] == 0.0f);
    Rules clamped;
    clamped.alpha_max = 0.99f;
    CHECK(on_mesh({black, white}, camera, {.grid = {1, 1}}, &clamped).pixel(10, 10)[0] == doctest::Approx(0.0099f));
}

TEST_CASE("compositing: weights and transmittance sum to one")
{
    auto const camera = support::lens(64, 48);
    auto gaussians = support::cloud(400, 61);
    for (auto& g : gaussians)
        for (float& c : g.colour) c = 1;
    auto const image = on_mesh(gaussians, camera);
    float largest = 0;
    for (float v : image.rgb) {
        CHECK(v >= 0.0f);
        largest = std::max(largest, v);
    }
    CHECK(largest <= 1.00001f);
    CHECK(largest > 0.9f);
}

TEST_CASE("the picture does not depend on the tiling: every tile size from 1 x 1, blocks cut at every column and row")
{
    auto const camera = support::lens(67, 41);
    auto const gaussians = support::cloud(250, 71);
    auto const naive = report::render_naive(gaussians, camera, Rules{});
    for (std::uint32_t w = 1; w <= 67; w += (w < 20 ? 1 : 11))
        for (std::uint32_t h : {1u, 3u, 4u, 5u, 13u, 41u}) {
            if (support::fast() && (w * h) % 5 != 0) continue;
            CHECK(support::differing_pixels(on_mesh(gaussians, camera, {.tile = {w, h}}), naive) == 0);
        }
}

TEST_CASE("contributing pairs belong to the picture, not to the tiling")
{
    auto const camera = support::lens(120, 80);
    auto const gaussians = support::cloud(400, 81);
    std::vector<std::uint64_t> contributing;
    for (Extent2 tile : {Extent2{120, 80}, {32, 20}, {16, 4}, {7, 13}}) {
        auto const r = make_runner<support::Whole>(support::map_of(gaussians), {.tile = tile})->render(camera).report;
        contributing.push_back(r.pairs_contributing);
        CHECK(r.pairs >= r.pairs_contributing);
        CHECK(r.pairs % 80 == 0);
    }
    CHECK(contributing[0] > 0);
    for (auto n : contributing) CHECK(n == contributing[0]);
}

TEST_CASE("every cut-off, footprint and clamp: mesh and naive loop agree bit for bit")
{
    auto const camera = support::lens(120, 80);
    auto const gaussians = support::cloud(400, 91);
    for (float alpha_min : {0.0f, 1.0f / 255, 1.0f / 32})
        for (float stop : {0.0f, 1e-4f, 3e-2f})
            for (Footprint footprint : {Footprint::opacity_box, Footprint::three_sigma_square}) {
                Rules rules;
                rules.alpha_min = alpha_min;
                rules.transmittance_min = stop;
                rules.footprint = footprint;
                rules.alpha_max = stop > 1e-3f ? 0.99f : 1.0f;
                rules.jacobian_limit = alpha_min == 0.0f ? 0.0f : 1.3f;
                CHECK(support::differing_pixels(on_mesh(gaussians, camera, {.tile = {32, 20}}, &rules),
                                                report::render_naive(gaussians, camera, rules)) == 0);
            }
}

TEST_CASE("rgbx8: the float picture rounded to levels, clamped, padded")
{
    // The nearest level, halves up, without an error next to a half. Compared with double, in which 255 v + 0.5 is exact.
    for (int k = 0; k < 255; ++k)
        for (float v = std::nextafter(float((k + 0.5) / 255), 0.0f), i = 0; i < 4; ++i, v = std::nextafter(v, 1.0f))
            CHECK(Rgbx8Pixel::level(v) == static_cast<std::uint32_t>(255.0 * double{v} + 0.5));
    auto const word = [](float r, float g, float b) { return Rgbx8Pixel::make({{r, g, b}, 1, 0, 0}).word; };
    CHECK(word(0, 0.5f, 1) == (0u | 128u << 8 | 255u << 16));
    CHECK(word(-1, 3.8f, 0.499f / 255) == (0u | 255u << 8));
    CHECK(word(0.5f / 255, 1.5f / 255, std::nanf("")) == (1u | 2u << 8));
}

TEST_CASE("nothing to draw: no Gaussian, one, all behind; frames of one pixel and one column")
{
    auto const camera = support::lens(33, 9);
    for (float v : on_mesh({}, camera).rgb) CHECK(v == 0.0f);
    auto behind = support::cloud(20, 97);
    for (auto& g : behind) g.mean_world[2] *= -1;
    for (float v : on_mesh(behind, camera).rgb) CHECK(v == 0.0f);
    auto const gaussians = support::cloud(50, 98);
    for (auto const& [w, h] : {std::pair{1u, 1u}, {1u, 30u}, {30u, 1u}}) {
        auto const tiny = support::lens(w, h);
        CHECK(support::differing_pixels(on_mesh(gaussians, tiny, {.tile = {4, 4}}),
                                        report::render_naive(gaussians, tiny, Rules{})) == 0);
    }
}

TEST_CASE("bad requests are refused in one line")
{
    auto const map = support::map_of(support::cloud(50, 99));
    auto blind = support::lens(64, 64), none = blind;
    blind.near_depth = 0;
    none.width = 0;
    struct Row {
        RendererOptions options;
        Camera camera;
        char const* text; ///< empty: it is rendered
    };
    for (Row const& row : {Row{{.grid = {41, 36}}, support::lens(1280, 720), "mk2 has 1472"},
                           {{.grid = {10, 10}}, support::lens(1280, 720), "framebuffer of 640 pixels"},
                           {{.grid = {4, 4}, .tile = {8, 8}}, support::lens(33, 32), "33 x 32"},
                           {{.channel_slots = 201}, support::lens(64, 64), "layout has 200"},
                           {{.storage_slots = 2001}, support::lens(64, 64), "layout has 2000"},
                           {{.grid = {2, 2}, .storage_slots = 12}, support::lens(32, 32), "50 Gaussians"},
                           {{.grid = {2, 2}, .storage_slots = 13}, support::lens(32, 32), ""},
                           {{.grid = {8, 0}}, support::lens(64, 64), "one side of 0"},
                           {{.tile = {0, 8}}, support::lens(64, 64), "one side of 0"},
                           {{}, blind, "near is not positive"},
                           {{}, none, "0 x 64"}}) {
        CAPTURE(row.text);
        auto const error = tests::error_of([&] { (void)make_runner<Referenced<Lossless>>(map, row.options)->render(row.camera); });
        CHECK(tests::has(error, row.text));
        CHECK(error.empty() == (*row.text == '\0'));
    }
    // One set of channels cannot hold what a bound leaves in both.
    CHECK(tests::has(tests::error_of([&] { (void)make_runner<Paper>(map, {.hops = 1}); }), "bounded hops"));
    auto twins = map;
    twins.gaussians[3].id = twins.gaussians[4].id;
    CHECK_THROWS_AS(make_runner<Referenced<Lossless>>(twins), Error);
}
