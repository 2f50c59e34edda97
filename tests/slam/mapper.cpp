// test: cost 2
#include "support.hpp"

using namespace tilemesh;
using slam::Mapper, slam::MapperOptions, slam::Optimiser;
namespace on_slam = support::slam;

namespace {
/// Four keyframes of the wall.
scene::Map grown(MapperOptions const& o, std::vector<slam::Keyframe>* facts = nullptr)
{
    Mapper mapper({}, 2, o);
    auto const views = on_slam::keyframes(4);
    for (std::size_t k = 0; k < 4; ++k) {
        auto const one = mapper.add(views.cameras[k], views.targets[k]);
        if (facts != nullptr) facts->push_back(one);
    }
    CHECK(mapper.keyframes() == 4);
    mapper.refine(6);
    return mapper.map();
}
bool same(scene::Map const& a, scene::Map const& b)
{
    return support::same_bits(a.gaussians, b.gaussians);
}
} // namespace

TEST_CASE("mapper: half of the steps take the newest keyframe, a quarter a window, a quarter any")
{
    std::set<std::size_t> near, far;
    for (std::uint64_t seed = 0; seed < 40; ++seed)
        for (std::uint32_t step = 0; step < 40; ++step) {
            auto const k = slam::keyframe_of_step(20, step, 8, seed);
            CHECK(k == slam::keyframe_of_step(20, step, 8, seed));
            if (step % 2 == 0) CHECK(k == 20);
            if (step % 4 == 1) near.insert(k);
            if (step % 4 == 3) far.insert(k);
        }
    CHECK(near.size() == 8);
    CHECK(*near.begin() == 13);
    CHECK(*near.rbegin() == 20);
    CHECK(far.size() == 21);
    for (std::uint32_t step = 0; step < 8; ++step) {
        CHECK(slam::keyframe_of_step(0, step, 8, 1) == 0);
        CHECK(slam::keyframe_of_step(2, step, 8, 1) <= 2);
        if (step % 4 == 1) CHECK(slam::keyframe_of_step(9, step, 1, 1) == 9);
    }
}

TEST_CASE("mapper: more steps take each keyframe once in a round, and make all of them better")
{
    std::set<std::vector<std::size_t>> orders;
    for (std::uint32_t round = 0; round < 10; ++round) {
        std::vector<std::size_t> order;
        for (std::uint32_t i = 0; i < 7; ++i) order.push_back(slam::keyframe_of_round(7, 7 * round + i, 1));
        orders.insert(order);
        std::sort(order.begin(), order.end());
        CHECK(order == std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 6});
    }
    CHECK(orders.size() > 5);

    Mapper mapper({}, 2);
    mapper.refine(5); // no keyframe
    CHECK(mapper.map().gaussians.empty());
    auto const views = on_slam::keyframes(3);
    for (std::size_t k = 0; k < 3; ++k) mapper.add(views.cameras[k], views.targets[k]);
    auto const mean = [&] { return support::mapping::mean_psnr(mapper, views); };
    auto const before = mean();
    auto const gaussians = mapper.map().gaussians.size();
    mapper.refine(30);
    MESSAGE("PSNR from " << before << " to " << mean());
    CHECK(mean() > before + 0.5);
    CHECK(mapper.map().gaussians.size() == gaussians);
}

TEST_CASE("mapper: `stop` ends the steps of a keyframe and of refine, and says so")
{
    auto const views = on_slam::keyframes(1);
    int asked = 0;
    slam::MapperOptions options;
    options.first_steps = 5;
    options.stop = [&] { return ++asked == 3; };
    Mapper stopped({}, 2, options);
    auto const key = stopped.add(views.cameras[0], views.targets[0]);
    CHECK(key.stopped);
    CHECK(key.steps == 3);
    CHECK(stopped.refine(4) == 4);
    asked = 1;
    CHECK(stopped.refine(4) == 1);

    options.first_steps = 3; // the last step is not asked about
    asked = 0;
    Mapper whole({}, 2, options);
    auto const other = whole.add(views.cameras[0], views.targets[0]);
    CHECK_FALSE(other.stopped);
    CHECK(other.steps == 3);
    CHECK(other.psnr_db != key.psnr_db); // rates fade over all steps that were asked for
}

TEST_CASE("mapper: the first keyframe fills each cell with a depth, and the same picture again nearly none")
{
    auto const views = on_slam::keyframes(1);
    auto const& camera = views.cameras[0];
    auto target = views.targets[0];
    std::size_t open = 0, holes = 0;
    for (std::uint32_t y = 0; y < 60; ++y)
        for (std::uint32_t x = 0; x < 96; ++x) {
            auto& depth = target.pixels[96 * y + x].depth;
            if (y < 8 && x < 10) depth = 0, ++holes; // 4 x 5 cells without a depth
            open += depth > 0;
        }
    Mapper mapper({}, 2);
    CHECK(mapper.open_share(camera, target) == doctest::Approx(double(open) / (96 * 60)));
    auto const first = mapper.add(camera, target);
    CHECK(first.inserted == 48 * 30 - 20);
    CHECK(holes == 80);
    CHECK(first.steps == 60);
    CHECK(first.gaussians == first.inserted - first.removed);
    CHECK(first.psnr_db > 24);
    CHECK(first.psnr_db == mapper.measure(camera, target).psnr_db());
    CHECK(mapper.open_share(camera, target) < 0.02);
    for (auto const& g : mapper.map().gaussians) CHECK((static_cast<std::uint32_t>(g.id) >> 20) == 1);
    auto const second = mapper.add(camera, target);
    CHECK(second.steps == 30);
    CHECK(second.inserted < 144);
    CHECK(second.psnr_db > first.psnr_db);
    std::set<splat::GaussianId> ids;
    for (auto const& g : mapper.map().gaussians) ids.insert(g.id);
    CHECK(ids.size() == mapper.map().gaussians.size());
}

TEST_CASE("mapper: without steps, a keyframe only inserts and removes, by the rules of both")
{
    auto start = on_slam::wall();
    start.gaussians.resize(5);
    for (std::size_t i = 0; i < 5; ++i) start.gaussians[i].mean_world[2] = -5; // behind the camera
    start.gaussians[1].opacity = 0.017f;
    start.gaussians[3].log_scale[1] = std::log(0.61f); // of 2 * 0.3
    MapperOptions o;
    o.first_steps = 0;
    Mapper mapper(start, 2, o);
    auto const camera = scene::make_camera(on_slam::pose(0), on_slam::lens(6, 4));
    mapping::Target target{6, 4, std::vector<splat::TargetPixel>(24, {{0.25f, 0.5f, 0.75f}, 2})};
    for (std::size_t i = 0; i < 24; ++i) target.pixels[i].depth = i % 6 < 2 ? 2.0f : 0.0f; // the first of three columns of cells
    auto const k = mapper.add(camera, target);
    CHECK(k.inserted == 2);
    CHECK(k.removed == 2);
    CHECK(k.gaussians == 5);
    auto const& map = mapper.map();
    CHECK(map.gaussians[0].id == splat::GaussianId{1});
    CHECK(map.gaussians[1].id == splat::GaussianId{3});
    CHECK(map.gaussians[2].id == splat::GaussianId{5});
    CHECK(map.gaussians[3].id == splat::GaussianId{(1u << 20) + 1});
    CHECK(map.gaussians[4].id == splat::GaussianId{(1u << 20) + 4});
    CHECK(map.gaussians[4].colour[0] == 0.25f);
    CHECK(map.gaussians[4].mean_world[2] == doctest::Approx(2));
    CHECK(mapper.keyframes() == 1);
}

TEST_CASE("mapper: the map has equal bits over threads and tilings, with each optimiser, and others over seeds")
{
    for (auto const optimiser : {Optimiser::adam, Optimiser::by_kind}) {
        MapperOptions o;
        o.optimiser = optimiser;
        o.first_steps = 20, o.steps = 12;
        std::vector<slam::Keyframe> facts;
        auto const first = grown(o, &facts);
        CHECK(facts[0].inserted == 1440);
        CHECK(facts[3].psnr_db > 20);
        std::set<splat::GaussianId> ids;
        std::set<std::uint32_t> keyframes;
        for (auto const& g : first.gaussians) ids.insert(g.id), keyframes.insert(static_cast<std::uint32_t>(g.id) >> 20);
        CHECK(ids.size() == first.gaussians.size());
        CHECK(keyframes == std::set<std::uint32_t>{1, 2, 3, 4});
        o.threads = 2;
        o.tile = {16, 5};
        CHECK(same(first, grown(o)));
        o.threads = 3;
        o.tile = {64, 40};
        CHECK(same(first, grown(o)));
        o.seed = 2;
        CHECK_FALSE(same(first, grown(o)));
    }
    CHECK(std::string(slam::name_of(Optimiser::adam)) == "adam");
    CHECK(std::string(slam::name_of(Optimiser::by_kind)) == "by-kind");
}

TEST_CASE("mapper: what it cannot do, it refuses with a line")
{
    float const infinity = std::numeric_limits<float>::infinity();
    for (float const depth : {0.0f, -1.0f, infinity, std::numeric_limits<float>::quiet_NaN()})
        CHECK(tests::error_of([&] { Mapper({}, depth); }).find("scene depth") != std::string::npos);
    struct Row {
        void (*change)(MapperOptions&);
        char const* text;
    };
    for (Row const& row : {Row{[](MapperOptions& o) { o.rate = 0; }, "a rate of 0"},
                           {[](MapperOptions& o) { o.window = 0; }, "a window of 0"},
                           {[](MapperOptions& o) { o.insert.cell = 0; }, "cells of 0"},
                           {[](MapperOptions& o) {
                                o.tile = {10, 10};
                            },
                            "tiles cannot have 10 x 10"}}) {
        MapperOptions o;
        row.change(o);
        CHECK(tests::has(tests::error_of([&] { Mapper({}, 1, o); }), row.text));
    }
    auto map = on_slam::wall();
    map.gaussians[2].id = splat::GaussianId{1u << 20};
    CHECK(tests::error_of([&] { Mapper(map, 1); }).find("the id 1048576 cannot grow") != std::string::npos);
    map.gaussians[2].id = splat::GaussianId{(1u << 20) - 1};
    CHECK(tests::error_of([&] { Mapper(map, 1); }).empty());

    Mapper mapper({}, 2);
    auto const camera = scene::make_camera(on_slam::pose(0), on_slam::lens());
    mapping::Target const small{4, 4, std::vector<splat::TargetPixel>(16)};
    CHECK(tests::error_of([&] { mapper.add(camera, small); }).find("4 x 4") != std::string::npos);
    CHECK(tests::error_of([&] { mapper.open_share(camera, small); }).find("4 x 4") != std::string::npos);
    CHECK(mapper.keyframes() == 0);
    auto huge = camera;
    huge.width = 4096, huge.height = 1024;
    CHECK(tests::error_of([&] { mapper.add(huge, small); }).find("too many cells") != std::string::npos);
}
