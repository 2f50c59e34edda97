// test: unoptimised test, cost 4
#include "support.hpp"
#include <tilemesh/splat/harmonics.hpp>

using namespace tilemesh;
using splat::map::Adam, splat::map::Kind, splat::map::SecondMomentByKind;

namespace {
scene::Map small_cloud(std::uint32_t n, std::uint64_t seed)
{
    auto gaussians = support::cloud(n, seed);
    for (auto& g : gaussians)
        for (float& s : g.log_scale) s = std::max(s, -4.0f);
    return support::map_of(std::move(gaussians));
}
std::vector<splat::Camera> turned_lenses(std::uint32_t width, std::uint32_t height)
{
    std::vector<splat::Camera> out;
    for (float turn : {0.0f, 0.04f, -0.05f, 0.1f}) out.push_back(support::lens(width, height, turn));
    return out;
}
/// The map after steps between which Gaussians come and go, in the order of the ids.
template <class Optimiser>
std::vector<splat::Gaussian> after_growth(scene::Map map, support::mapping::Views const& views, splat::TileSize tile, std::uint32_t threads,
                                          bool reversed)
{
    auto const n = map.gaussians.size(), half = n / 2;
    auto later = std::vector<splat::Gaussian>(map.gaussians.begin() + static_cast<std::ptrdiff_t>(half), map.gaussians.end());
    map.gaussians.resize(half);
    if (reversed) {
        std::reverse(map.gaussians.begin(), map.gaussians.end());
        std::swap(map.gaussians[3], map.gaussians[40]);
        std::reverse(later.begin(), later.end());
    }
    mapping::RefineOptions o;
    o.view = {tile, threads, {1, 0.5f, 0.05f, 0, 4}};
    mapping::Refiner<Optimiser> refiner(std::move(map), o);
    std::uint32_t step = 0;
    auto const steps = [&] {
        for (int i = 0; i < 8; ++i, ++step)
            refiner.step(views.cameras[step % 4], views.targets[step % 4],
                         splat::map::faded(splat::map::usual_rates(2), static_cast<float>(step) / 24));
    };
    steps();
    refiner.add(later);
    steps();
    CHECK(refiner.remove_if([](splat::Gaussian const& g) { return static_cast<std::uint32_t>(g.id) % 3 == 0; }) == n / 3);
    steps();
    CHECK(refiner.map().gaussians.size() == n - n / 3);
    CHECK(refiner.states().size() == n - n / 3);
    auto out = refiner.map().gaussians;
    std::sort(out.begin(), out.end(), [](auto const& a, auto const& b) { return a.id < b.id; });
    return out;
}
template <class Optimiser>
void check_growth()
{
    auto const truth = small_cloud(support::fast() ? 120 : 240, 3);
    auto const views = support::mapping::views_of(truth, turned_lenses(77, 51));
    auto start = support::mapping::spoilt(truth, 2, 5);
    for (auto& g : start.gaussians) // many of one depth in the first view
        if (static_cast<std::uint32_t>(g.id) % 3 != 0) g.mean_world[2] = std::round(4 * g.mean_world[2]) / 4;
    auto const first = after_growth<Optimiser>(start, views, {32, 20}, 1, false);
    std::uint32_t moved = 0;
    for (auto const& g : first) {
        auto const id = static_cast<std::uint32_t>(g.id);
        CHECK(id % 3 != 0);
        moved += std::memcmp(&g, &start.gaussians[id - 1], sizeof g) != 0;
    }
    CHECK(moved > first.size() / 2);
    struct Row {
        splat::TileSize tile;
        std::uint32_t threads;
        bool reversed;
    };
    for (Row const& row :
         {Row{{16, 5}, 2, false}, {{16, 15}, 3, false}, {{64, 40}, 7, false}, {{80, 55}, 1, false}, {{80, 55}, 3, true}, {{48, 10}, 2, true}}) {
        INFO(row.tile.tile_width, " x ", row.tile.tile_height, ", ", row.threads, " threads, reversed: ", row.reversed);
        CHECK(support::same_bits(first, after_growth<Optimiser>(start, views, row.tile, row.threads, row.reversed)));
    }
}
} // namespace

TEST_CASE("refiner: a map that grows and shrinks between 24 steps has equal bits over tilings, threads and orders of the records")
{
    check_growth<Adam>();
    check_growth<SecondMomentByKind>();
}

TEST_CASE("refiner: who stays keeps its state and harmonics, and who comes has seen no step")
{
    auto map = support::map_of({support::ball(1, 10, 12, 4, 0.8f), support::ball(2, 20, 12, 4, 0.8f), support::ball(3, 30, 12, 4, 0.8f)});
    map.sh_degree = 1;
    for (int i = 0; i < 27; ++i) map.harmonics.push_back(static_cast<float>(i));
    auto const camera = support::flat_camera(40, 25);
    mapping::Target const grey{40, 25, std::vector<splat::TargetPixel>(1000, {{0.5f, 0.5f, 0.5f}, 0})};
    mapping::Refiner<Adam> refiner(map);
    for (int i = 0; i < 3; ++i) refiner.step(camera, grey, {0, 0, 0, 0, 0.02f});
    auto const before = refiner.states();
    auto const third = refiner.map().gaussians[2];
    CHECK(refiner.remove_if([](splat::Gaussian const& g) { return static_cast<std::uint32_t>(g.id) == 2; }) == 1);
    REQUIRE(refiner.states().size() == 2);
    CHECK(std::memcmp(&refiner.states()[1], &before[2], sizeof before[2]) == 0);
    CHECK(std::memcmp(&refiner.map().gaussians[1], &third, sizeof third) == 0);
    CHECK(refiner.map().harmonics == std::vector<float>{0, 1, 2, 3, 4, 5, 6, 7, 8, 18, 19, 20, 21, 22, 23, 24, 25, 26});
    std::vector<splat::Gaussian> const more{support::ball(7, 20, 20, 4, 0.8f)};
    refiner.add(more);
    REQUIRE(refiner.map().gaussians.size() == 3);
    CHECK(refiner.states()[2].steps == 0);
    CHECK(refiner.map().harmonics.size() == 27);
    CHECK(refiner.map().harmonics.back() == 0);
    refiner.step(camera, grey, {0, 0, 0, 0, 0.02f});
    CHECK(refiner.states()[2].steps == 1);
    CHECK(refiner.states()[1].steps == 4);
    refiner.add({});
    CHECK(refiner.remove_if([](splat::Gaussian const&) { return true; }) == 3);
    CHECK(refiner.step(camera, grey, {0, 0, 0, 0, 0.02f}).pixels == 1000); // an empty map, and a pixel that nothing covers
    auto const seen = refiner.render(camera);
    CHECK(*std::max_element(seen.cover.values.begin(), seen.cover.values.end()) == 0);
}

TEST_CASE("refiner: one that takes over the records and states of another goes on with its bits, or changes nothing")
{
    auto map = support::map_of({support::ball(1, 10, 12, 4, 0.8f), support::ball(2, 20, 12, 4, 0.8f), support::ball(3, 30, 12, 4, 0.8f)});
    map.sh_degree = 1;
    map.harmonics.assign(27, 0.1f);
    auto const camera = support::flat_camera(40, 25);
    mapping::Target const grey{40, 25, std::vector<splat::TargetPixel>(1000, {{0.5f, 0.3f, 0.2f}, 0})};
    splat::map::Rates const rates{0.01f, 0.01f, 0.01f, 0.01f, 0.02f, 0.01f};
    mapping::Refiner<Adam> first(map), second(map);
    for (int i = 0; i < 3; ++i) first.step(camera, grey, rates);
    first.remove_if([](splat::Gaussian const& g) { return static_cast<std::uint32_t>(g.id) == 2; });
    auto const& is = first.map();
    second.restore(is.gaussians, is.harmonics, first.states(), first.harmonics_states());
    auto const same = [&] {
        auto const& other = second.map();
        return other.gaussians.size() == 2 && support::same_bits(other.gaussians, is.gaussians) && other.harmonics == is.harmonics;
    };
    CHECK(same());
    CHECK(is.harmonics != std::vector<float>(18, 0.1f));
    first.step(camera, grey, rates);
    CHECK_FALSE(same());
    second.step(camera, grey, rates);
    CHECK(same());

    auto const refused = [&](std::size_t states, std::size_t harmonics, std::size_t harmonics_states) {
        return tests::error_of([&] {
            second.restore({is.gaussians[0], is.gaussians[1]}, std::vector<float>(harmonics), std::vector<Adam::State>(states),
                           std::vector<splat::map::HarmonicsStep::State>(harmonics_states));
        });
    };
    CHECK(refused(1, 18, 2) == "a refiner cannot take over 2 Gaussians with 1 states of the optimiser and 18 harmonics (each Gaussian has one "
                               "state, and those of the map's degree); give those of one refiner");
    CHECK_FALSE(refused(3, 18, 2).empty());
    CHECK_FALSE(refused(2, 17, 2).empty());
    CHECK_FALSE(refused(2, 0, 0).empty());
    CHECK_FALSE(refused(2, 18, 1).empty());
    CHECK(same());
}

TEST_CASE("refiner: a spoilt map becomes better, and the views' pictures are the naive ones")
{
    auto const truth = small_cloud(60, 9);
    auto const views = support::mapping::views_of(truth, turned_lenses(64, 40));
    auto const naive = report::render_naive(truth.gaussians, views.cameras[1], mapping::refining_rules());
    mapping::Refiner<> same(truth);
    CHECK(support::same_bits(same.render(views.cameras[1]).colour.rgb, naive.rgb));
    CHECK(std::isinf(same.measure(views.cameras[1], views.targets[1]).psnr_db()));

    mapping::RefineOptions o;
    o.view.loss.depth = 0.5f;
    mapping::Refiner<> refiner(support::mapping::spoilt(truth, 2, 5), o);
    double const before = support::mapping::mean_psnr(refiner, views);
    double first_loss = 0, last_loss = 0;
    for (std::uint32_t i = 0; i < 80; ++i) {
        last_loss = refiner.step(views.cameras[i % 4], views.targets[i % 4],
                                 splat::map::faded(splat::map::usual_rates(2), static_cast<float>(i) / 80)).loss;
        if (i == 0) first_loss = last_loss;
    }
    double const after = support::mapping::mean_psnr(refiner, views);
    MESSAGE("PSNR from " << before << " to " << after << ", loss from " << first_loss << " to " << last_loss);
    CHECK(after > before + 6);
    CHECK(last_loss < 0.5 * first_loss);
}

TEST_CASE("refiner: a black Gaussian becomes bright, a masked picture moves nothing, and what no view shows stays")
{
    auto map = support::map_of({support::ball(1, 20, 12, 4, 0.8f), support::ball(2, 500, 500, 4, 0.8f)});
    for (float& c : map.gaussians[0].colour) c = 0;
    auto const camera = support::flat_camera(40, 25);
    mapping::Target target{40, 25, std::vector<splat::TargetPixel>(1000, {{0.5f, 0.5f, 0.5f}, 0})};
    mapping::Refiner<> refiner(map);
    for (int i = 0; i < 10; ++i) refiner.step(camera, target, {0, 0, 0, 0, 0.02f});
    for (float const c : refiner.map().gaussians[0].colour) CHECK(c > 0.1f);
    CHECK(std::memcmp(&refiner.map().gaussians[1], &map.gaussians[1], sizeof map.gaussians[1]) == 0);
    CHECK(refiner.states()[0].steps == 10);
    CHECK(refiner.states()[1].steps == 0);

    for (auto& p : target.pixels) p.rgb[2] = std::numeric_limits<float>::quiet_NaN();
    mapping::Refiner<> still(map);
    CHECK(still.step(camera, target, splat::map::usual_rates(1)).pixels == 0);
    CHECK(support::same_bits(still.map().gaussians, map.gaussians));
}

TEST_CASE("optimisers: steps by hand, and what keeps a record valid")
{
    splat::map::RecordSlopes slopes{};
    slopes.of[0] = 4;
    slopes.of[splat::map::places_of(Kind::logit).first] = -1;
    slopes.of[splat::map::places_of(Kind::colour).first] = 1;
    splat::map::Rates const rates{0.1f, 0, 0, 1, 0.5f};
    splat::Gaussian g = support::ball(1, 0, 0, 1, 0.5f);
    g.colour[0] = 0.25f;

    auto by_adam = g;
    Adam::State adam{};
    Adam::step(by_adam, slopes, rates, {}, adam);
    CHECK(by_adam.mean_world[0] == doctest::Approx(-0.1)); // the first step is the rate
    CHECK(by_adam.mean_world[1] == 0);
    CHECK(by_adam.opacity == doctest::Approx(1 / (1 + std::exp(-1.0))));
    CHECK(by_adam.colour[0] == 0);
    CHECK(adam.steps == 1);
    Adam::step(by_adam, slopes, rates, {}, adam);
    CHECK(by_adam.mean_world[0] == doctest::Approx(-0.2)); // so is the second, for the same slope

    auto by_kind = g;
    SecondMomentByKind::State state{};
    SecondMomentByKind::step(by_kind, slopes, rates, {}, state, false);
    CHECK(by_kind.mean_world[0] == doctest::Approx(-0.1 * std::sqrt(3.0))); // one of three has all
    CHECK(by_kind.colour[0] == doctest::Approx(0.25 - 0.5 * std::sqrt(3.0))); // not clamped
    for (auto& v : slopes.of) v = 0;
    slopes.of[0] = 2;
    SecondMomentByKind::step(by_kind, slopes, rates, {}, state, false);
    CHECK(by_kind.mean_world[0] == doctest::Approx(-0.1 * std::sqrt(3.0) - 0.1 * 2 / std::sqrt((0.999 * 16 + 4) / 3 / 1.999)));

    // Extreme opacities are moved inside, and a quaternion keeps its length.
    for (float const opacity : {0.0f, 1.0f}) {
        auto extreme = g;
        extreme.opacity = opacity;
        extreme.rotation[0] = 3;
        Adam::State fresh{};
        Adam::step(extreme, slopes, rates, {}, fresh);
        CHECK(extreme.opacity == doctest::Approx(opacity > 0 ? 0.99987661 : 1.2339458e-4));
        CHECK(extreme.rotation[0] == 1);
    }
    CHECK(splat::map::faded({1, 2, 3, 4, 5}, 0).mean == 1);
    CHECK(splat::map::faded({1, 2, 3, 4, 5, 6}, 1).colour == doctest::Approx(0.5));
    CHECK(splat::map::faded({1, 2, 3, 4, 5, 6}, 1).harmonics == doctest::Approx(0.6));
}

TEST_CASE("refiner: the first part of harmonics is not clamped, and the others stay where their rate is 0")
{
    auto map = small_cloud(40, 4);
    map.sh_degree = 1;
    map.harmonics.assign(9 * map.gaussians.size(), 0.1f);
    for (auto& g : map.gaussians)
        for (float& c : g.colour) c -= 0.2f;
    auto const camera = support::lens(48, 30);
    mapping::Refiner<> refiner(map);
    auto const seen = refiner.render(camera);
    std::vector<splat::ShadedGaussian<1>> shaded;
    for (auto const& g : map.gaussians) {
        auto& one = shaded.emplace_back();
        static_cast<splat::Gaussian&>(one) = g;
        for (float& h : one.harmonics) h = 0.1f;
    }
    auto const naive = report::render_naive(shaded, camera, mapping::refining_rules());
    CHECK(support::same_bits(seen.colour.rgb, naive.rgb));
    mapping::Target const dark{48, 30, std::vector<splat::TargetPixel>(48 * 30)};
    for (int i = 0; i < 5; ++i) refiner.step(camera, dark, {0, 0, 0, 0, 0.1f});
    CHECK(refiner.map().harmonics == map.harmonics);
    CHECK(std::any_of(refiner.map().gaussians.begin(), refiner.map().gaussians.end(), [](auto const& g) { return g.colour[0] < -0.3f; }));
}

namespace {
/// The slope of the colour of `s` by each coefficient is the step that HarmonicsStep takes, but for one factor.
template <std::uint32_t Degree>
void check_harmonics()
{
    constexpr std::uint32_t n = splat::harmonics_per_channel(Degree);
    auto const view = splat::make_view(support::lens(48, 30, 0.3f), splat::Rules{});
    splat::Gaussian g = support::ball(1, 0, 0);
    g.mean_world[0] = 0.7f, g.mean_world[1] = -0.4f, g.mean_world[2] = 2;
    std::vector<float> const before(3 * n, 0.125f);
    splat::Splat base{}, other{};
    REQUIRE(splat::shade<Degree>(g, before.data(), view, base));
    splat::map::RecordSlopes slopes{};
    float const by_colour[3] = {0.5f, -1.0f, 0.25f};
    for (std::uint32_t c = 0; c < 3; ++c) slopes.of[splat::map::places_of(Kind::colour).first + c] = by_colour[c];
    auto after = before;
    splat::map::HarmonicsStep::State state{};
    splat::map::HarmonicsStep::step<Degree>(after.data(), g, view, slopes, 0.01f, {}, state);
    CHECK(state.steps == 1);
    double squares = 0, factor = 0;
    for (int pass = 0; pass < 2; ++pass) {
        for (std::uint32_t k = 0; k < n; ++k)
            for (std::uint32_t c = 0; c < 3; ++c) {
                auto changed = before;
                changed[3 * k + c] += 0.0625f;
                REQUIRE(splat::shade<Degree>(g, changed.data(), view, other));
                double const slope = double{by_colour[c]} * double{other.colour[c] - base.colour[c]} / 0.0625;
                if (pass == 0) squares += slope * slope / (3 * n);
                else CHECK(double{after[3 * k + c] - before[3 * k + c]} == doctest::Approx(-factor * slope).epsilon(1e-3).scale(0.01));
            }
        factor = 0.01 / std::sqrt(squares);
    }
}
} // namespace

TEST_CASE("refiner: harmonics move by their slopes, and become better")
{
    check_harmonics<1>();
    check_harmonics<2>();
    check_harmonics<3>();

    auto truth = small_cloud(40, 6);
    truth.sh_degree = 2;
    support::Random random(8);
    for (std::size_t i = 0; i < 24 * truth.gaussians.size(); ++i) truth.harmonics.push_back(random.uniform(-0.3f, 0.3f));
    auto const views = support::mapping::views_of(truth, turned_lenses(48, 30));
    auto start = truth;
    for (float& h : start.harmonics) h = 0;
    mapping::Refiner<> refiner(start);
    double const before = support::mapping::mean_psnr(refiner, views);
    for (std::uint32_t i = 0; i < 120; ++i)
        refiner.step(views.cameras[i % 4], views.targets[i % 4], splat::map::faded({0, 0, 0, 0, 0, 0.02f}, static_cast<float>(i) / 120));
    double const after = support::mapping::mean_psnr(refiner, views);
    MESSAGE("PSNR from " << before << " to " << after);
    CHECK(after > before + 6);
}

TEST_CASE("refiner: what it cannot do, it refuses with a line")
{
    auto const map = small_cloud(3, 1);
    auto const with = [&](auto const& change) {
        mapping::RefineOptions o;
        change(o);
        return tests::error_of([&] { mapping::Refiner<> r(map, o); });
    };
    CHECK(with([](auto& o) { o.view.tile = {24, 20}; }) ==
          "tiles cannot have 24 x 20 pixels (sums are rounded by blocks of 16 x 5); take multiples of these");
    CHECK(with([](auto& o) { o.view.threads = 0; }) == "no thread cannot add up a view (threads is 0); take 1 or more");
    CHECK(with([](auto& o) { o.view.loss.depth = -1; }).find("a weight or width of the loss is -1") == 0);
    CHECK(with([](auto& o) { o.view.loss.limit = 0; }).find("the limit of slopes is 0") == 0);
    mapping::Refiner<> r(map);
    CHECK(tests::error_of([&] { r.measure(support::lens(40, 30), mapping::Target{40, 31, {}}); }) ==
          "a target of 40 x 31 pixels is no picture of this camera (it has 40 x 30); give pictures of the camera's size");
    CHECK(tests::error_of([&] { (void)mapping::make_target(report::Image(4, 3), report::Plane(3, 4)); }) ==
          "the depths of a target cannot have 3 x 4 pixels (its picture has 4 x 3); give pictures of one size");
}
