// test: unoptimised test, without asan tsan
// The named qualities: their cut-offs; each is cheaper than the one before and has a larger error; and a renderer with a quality renders
// with its cut-offs, also if records are culled for it.
#include "../compare_reports.hpp"
#include "runner.hpp"
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/splat/quality.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;
using support::make_runner;

namespace {

constexpr Quality qualities[] = {Quality::evaluation, Quality::viewing, Quality::on_sensor};

static_assert(with_quality({}, Quality::evaluation).alpha_min == 1.0f / (32 * 255));
static_assert(with_quality({}, Quality::evaluation).transmittance_min == 1e-4f);
static_assert(with_quality({}, Quality::viewing).alpha_min == 1.0f / 128);
static_assert(with_quality({}, Quality::viewing).transmittance_min == 5e-3f);
static_assert(with_quality({}, Quality::on_sensor).alpha_min == 1.0f / 64);
static_assert(with_quality({}, Quality::on_sensor).transmittance_min == 1e-2f);

// The cut-offs without a quality: the library's, and those of 3D Gaussian Splatting in the presets of the paper's machine.
static_assert(Rules{}.alpha_min == 1.0f / 255 && Rules{}.transmittance_min == 5e-3f);
static_assert(Lossless::transmittance_min == 5e-3f && Fitted<Lossless, 3, false>::transmittance_min == 5e-3f);
static_assert(Paper::transmittance_min == 1e-4f && Prototype::transmittance_min == 1e-4f && support::Room<Paper>::transmittance_min == 1e-4f);

bool same_bits(Rules const& a, Rules const& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

struct Desk {
    scene::Map map = scene::built_in_map();
    Camera camera = scene::frame_whole(map, {320, 180});
};
Desk const& desk()
{
    static Desk const d;
    return d;
}

constexpr Extent2 tile{16, 10};

std::unique_ptr<support::Runner> desk_runner(std::optional<Quality> quality)
{
    return make_runner<Referenced<support::Whole>>(
        desk().map, {.tile = tile, .arithmetic = Arithmetic::fast, .quality = quality, .sizes = roomy(Lossless::sizes)});
}
RenderedFrame rendered(std::optional<Quality> quality)
{
    return desk_runner(quality)->render(desk().camera);
}

} // namespace

TEST_CASE("quality: its name, its two cut-offs, and nothing else")
{
    CHECK(std::string(name(Quality::evaluation)) == "evaluation");
    CHECK(std::string(name(Quality::viewing)) == "viewing");
    CHECK(std::string(name(Quality::on_sensor)) == "on_sensor");
    Rules odd;
    odd.alpha_min = 0.125f;
    odd.alpha_max = 0.75f;
    odd.transmittance_min = 0.25f;
    odd.dilation = 0.5f;
    odd.jacobian_limit = 2;
    odd.footprint = Footprint::three_sigma_square;
    odd.arithmetic = Arithmetic::fast;
    for (auto const quality : qualities) {
        CAPTURE(name(quality));
        auto const with = with_quality(odd, quality);
        CHECK_FALSE(same_bits(with, odd));
        auto back = with;
        back.alpha_min = odd.alpha_min;
        back.transmittance_min = odd.transmittance_min;
        CHECK(same_bits(back, odd));
        CHECK(same_bits(with_quality(with, quality), with));
    }
}

TEST_CASE("quality: presets keep their own stop until a quality is asked for")
{
    auto const map = support::map_of(support::cloud(20, 3));
    auto const rules_of = [&]<class S>(S) { return make_runner<S>(map)->rules(); };
    CHECK(rules_of(Lossless{}).transmittance_min == 5e-3f);
    for (auto const& rules : {rules_of(Paper{}), rules_of(Prototype{})}) {
        CHECK(rules.transmittance_min == 1e-4f);
        CHECK(rules.alpha_min == 1.0f / 255);
        CHECK(rules.alpha_max == 0.99f);
    }
    auto const asked = make_runner<Referenced<Paper>>(map, {.quality = Quality::viewing});
    CHECK(asked->rules().transmittance_min == 5e-3f);
    CHECK(asked->rules().alpha_min == 1.0f / 128);
    CHECK(asked->rules().alpha_max == 0.99f);
    CHECK(asked->rules().footprint == Footprint::three_sigma_square);
}

TEST_CASE("quality: fewer pairs and a larger error, from evaluation to the default to viewing to on_sensor")
{
    auto const exact = report::render_double(desk().map.gaussians, desk().camera, Rules{}, report::Cuts::none);
    std::vector<RenderedFrame> frames;
    for (auto const& quality : std::initializer_list<std::optional<Quality>>{Quality::evaluation, std::nullopt, Quality::viewing,
                                                                             Quality::on_sensor})
        frames.push_back(rendered(quality));
    double last = 0;
    for (std::size_t i = 0; i < frames.size(); ++i) {
        CAPTURE(i);
        CHECK(frames[i].report.lost.empty());
        if (i > 0) CHECK(frames[i].report.pairs < frames[i - 1].report.pairs);
        auto const error = report::compare(frames[i].image, exact);
        CHECK(error.rmse > last);
        last = error.rmse;
    }
    CHECK(last < 0.01);

    // The cut-offs of `evaluation` change a byte only by rounding.
    auto const cut = report::render_double(desk().map.gaussians, desk().camera, with_quality({}, Quality::evaluation), report::Cuts::same);
    CHECK(report::compare(cut, exact).max_levels < 0.5);
}

TEST_CASE("quality: asked for in the options or written into the model, the same bits")
{
    for (auto const quality : {Quality::evaluation, Quality::viewing, Quality::on_sensor, Quality::training}) {
        CAPTURE(name(quality));
        auto const asked = rendered(quality);
        auto const told = desk_runner(std::nullopt);
        told->rules() = with_quality(told->rules(), quality);
        CHECK(same_bits(told->rules(), desk_runner(quality)->rules()));
        auto const written = told->render(desk().camera);
        CHECK(support::differing_pixels(asked.image, written.image) == 0);
        CHECK(report::first_difference(asked.report, written.report) == "");
        CHECK(support::differing_pixels(asked.image, rendered(std::nullopt).image) > 0);
    }
}

TEST_CASE("quality: the records culled for it are those that it does not show")
{
    // Three of the balls are visible under some of the four: 1/8160 < 1/1000 < 1/255 < 1/200 < 1/128 < 1/100 < 1/64.
    auto records = support::cloud(300, 5);
    auto const faint = [&](float opacity) {
        auto g = support::ball(static_cast<std::uint32_t>(records.size()) + 1, 0, 0, 0.1f, opacity);
        g.mean_world[2] = 2;
        records.push_back(g);
    };
    for (float const opacity : {0.0001f, 0.001f, 0.005f, 0.01f}) faint(opacity);
    auto const map = support::map_of(records);
    auto const camera = support::lens(96, 64);
    std::vector<Camera> const path{camera};
    auto const tiling = [](Camera const& c) { return make_tiling(c.width, c.height, 16, 8); };
    std::vector<std::uint64_t> culled;
    for (auto const quality : qualities) {
        CAPTURE(name(quality));
        RendererOptions const options{.tile = {16, 8}, .quality = quality};
        auto const rules = with_quality(Rules{}, quality);
        auto const demand = scene::demand_of(map, std::span(path), rules, tiling);
        culled.push_back(demand.culled);
        auto const frame = support::renderer_for<support::NoRouting>(map, demand, options).render(camera);
        auto const all = make_runner<Referenced<support::Whole>>(map, options)->render(camera);
        CHECK(support::differing_pixels(frame.image, all.image) == 0);
        CHECK(frame.report.pairs == all.report.pairs);
        CHECK(frame.report.gaussians.visible == all.report.gaussians.visible);
        CHECK(frame.report.gaussians.parked == all.report.gaussians.parked);

        // A demand for another model is refused, because the picture would have holes.
        auto const others = scene::demand_of(map, std::span(path), Rules{}, tiling);
        REQUIRE(others.culled != 0);
        auto wrong = support::renderer_for<support::NoRouting>(map, others, options);
        CHECK_THROWS_AS(wrong.render(camera), Error);
    }
    REQUIRE(culled.size() == 3);
    CHECK(culled[0] > 0);
    CHECK(culled[0] < culled[1]);
    CHECK(culled[1] < culled[2]);
}
