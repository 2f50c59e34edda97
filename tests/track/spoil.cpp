#include "support.hpp"
#include <tilemesh/report/image.hpp>
#include <tilemesh/track/spoil.hpp>

using namespace track_test;
using namespace tilemesh;

namespace {

report::Image grey(std::uint32_t width, std::uint32_t height, float level)
{
    report::Image image{width, height};
    for (float& v : image.rgb) v = level;
    return image;
}
report::Plane wall(std::uint32_t width, std::uint32_t height, float z)
{
    report::Plane plane{width, height};
    for (float& v : plane.values) v = z;
    return plane;
}
track::Spoiling nothing()
{
    return {0.0, false, 0.0, 0.0, 0.0, 0.0, 1};
}

} // namespace

TEST_CASE("each fault has its size: noise, gain, 8 bits, depth error, holes")
{
    std::uint32_t const width = 200, height = 150;
    auto const n = static_cast<double>(3 * width * height);
    auto untouched = grey(width, height, 0.3f);
    auto z = wall(width, height, 2.0f);
    track::spoil(untouched, z, 7, nothing());
    CHECK(untouched.rgb == grey(width, height, 0.3f).rgb);
    CHECK(z.values == wall(width, height, 2.0f).values);

    auto s = nothing();
    s.noise = 0.02;
    auto noisy = grey(width, height, 0.5f);
    track::spoil(noisy, z, 7, s);
    double mean = 0.0, square = 0.0, fourth = 0.0, neighbours = 0.0, channels = 0.0;
    for (std::size_t i = 0; i < noisy.rgb.size(); ++i) {
        double const e = (double{noisy.rgb[i]} - 0.5) / 0.02;
        mean += e / n, square += e * e / n, fourth += e * e * e * e / n;
        if (i >= 3) neighbours += e * (double{noisy.rgb[i - 3]} - 0.5) / 0.02 / n;
        if (i % 3 != 0) channels += e * (double{noisy.rgb[i - 1]} - 0.5) / 0.02 / n;
    }
    // 90,000 numbers: a standard error of 0.0033 for means and products.
    CHECK(std::fabs(mean) < 0.015);
    CHECK(std::fabs(square - 1.0) < 0.02);
    CHECK(std::fabs(fourth - 2.9) < 0.1); // 3 - 1.2 / 12, of twelve uniform numbers
    CHECK(std::fabs(neighbours) < 0.015);
    CHECK(std::fabs(channels) < 0.015);

    s = nothing();
    s.gain_drift = 0.1;
    auto dark = grey(4, 4, 0.5f);
    report::Plane none;
    track::spoil(dark, none, 16, s); // near the swing's far end
    CHECK(dark.rgb[0] == doctest::Approx(0.5 * (1.0 - 0.1 * std::sin(1.6) * std::sin(1.6))));
    CHECK(track::gain_of(s, 0) == 1.0);

    s = nothing();
    s.eight_bits = true;
    auto steps = grey(4, 1, 0.0f);
    steps.rgb = {-0.5f, 0.0f, 0.0019f, 0.002f, 0.5f, 0.998f, 1.0f, 1.5f, 0.25f, 0.75f, 100.0f, -0.0f};
    track::spoil(steps, none, 0, s);
    std::array<int, 12> const levels{0, 0, 0, 1, 128, 254, 255, 255, 64, 191, 255, 0};
    for (std::size_t i = 0; i < 12; ++i) CHECK(steps.rgb[i] == static_cast<float>(levels[i] / 255.0));

    s = nothing();
    s.depth_noise = 0.01;
    s.depth_holes = 0.1;
    z = wall(width, height, 4.0f);
    z.values[5] = std::numeric_limits<float>::quiet_NaN(), z.values[6] = -1.0f;
    track::spoil(untouched, z, 3, s);
    CHECK(z.values[5] == 0.0f);
    CHECK(z.values[6] == 0.0f);
    double holes = 0.0, error = 0.0;
    for (float const v : z.values) {
        REQUIRE(v >= 0.0f);
        holes += v == 0.0f ? 1.0 : 0.0;
        if (v > 0.0f) error += std::pow(double{v} / 4.0 - 1.0, 2.0);
    }
    double const pixels = width * height;
    CHECK(std::fabs(holes / pixels - 0.1) < 0.01);
    CHECK(std::sqrt(error / (pixels - holes)) == doctest::Approx(0.01).epsilon(0.02));
    s.depth_holes = 1.0;
    track::spoil(untouched, z, 3, s);
    for (float const v : z.values) REQUIRE(v == 0.0f);
}

TEST_CASE("the same bits for any number of threads, and others for another frame or seed")
{
    track::Spoiling const s;
    auto const run = [&](std::uint64_t frame, std::uint64_t seed, unsigned threads) {
        auto own = s;
        own.seed = seed;
        auto picture = grey(37, 23, 0.4f);
        auto z = wall(37, 23, 3.0f);
        track::spoil(picture, z, frame, own, threads);
        auto all = picture.rgb;
        all.insert(all.end(), z.values.begin(), z.values.end());
        return all;
    };
    auto const one = run(5, 1, 1);
    for (unsigned const threads : {2u, 3u, 7u, 23u, 100u}) CHECK(run(5, 1, threads) == one);
    CHECK(run(6, 1, 1) != one);
    CHECK(run(5, 2, 1) != one);
    // Written down from another program: the numbers are the same on every machine.
    CHECK(track::random_bits(1, 5, 100, 2) == 0xd132f4dc7fecde73u);
}

TEST_CASE("motion blur: three poses on the camera's way, and the mean of their pictures")
{
    track::Twist const step{{0.2, 0.0, 0.1}, {0.0, 0.06, 0.02}};
    scene::Pose const at{track::rotation_by({0.1, 0.2, 0.3}), {1, 2, 3}};
    auto const after = track::moved(at, step), before = track::moved(at, {-step.rho, -step.phi});
    auto const poses = track::shutter_poses(before, at, after, 0.5);
    CHECK(poses[1].position == at.position);
    CHECK(degrees_between(poses[0].rotation, poses[2].rotation) == doctest::Approx(0.5 * degrees_between(at.rotation, after.rotation)));
    CHECK(glm::length(poses[2].position - track::moved(at, {0.25 * step.rho, 0.25 * step.phi}).position) < 1e-14);
    CHECK(glm::length(poses[0].position - track::moved(at, {-0.25 * step.rho, -0.25 * step.phi}).position) < 1e-14);
    auto const closed = track::shutter_poses(before, at, after, 0.0);
    CHECK(glm::length(closed[0].position - at.position) == 0.0);

    std::array<report::Image, 3> const pictures{grey(2, 2, 0.0f), grey(2, 2, 0.25f), grey(2, 2, 0.5f)};
    CHECK(track::mean_of(pictures).rgb[7] == 0.25f);
    std::array<report::Image, 2> const unlike{grey(2, 2, 0.0f), grey(2, 3, 0.0f)};
    CHECK_THROWS_AS(track::mean_of(unlike), Error);
    CHECK_THROWS_AS(track::mean_of({}), Error);
}

TEST_CASE("faults of no size are refused")
{
    report::Plane none;
    auto picture = grey(2, 2, 0.5f);
    for (double const bad : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
        for (auto const member : {&track::Spoiling::noise, &track::Spoiling::depth_noise, &track::Spoiling::depth_holes, &track::Spoiling::gain_drift, &track::Spoiling::shutter}) {
            track::Spoiling s;
            s.*member = bad;
            CHECK_THROWS_AS(track::spoil(picture, none, 0, s), Error);
        }
    CHECK(picture.rgb == grey(2, 2, 0.5f).rgb);
    auto other = wall(3, 2, 1.0f);
    CHECK_THROWS_AS(track::spoil(picture, other, 0, {}), Error);
}
