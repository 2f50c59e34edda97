// test: without asan tsan
#include "../standard.hpp"
#include <tilemesh/splat/exponential.hpp>

using tilemesh::splat::exponential;

namespace {
double ulp(float v)
{
    return static_cast<double>(std::nextafter(v, std::numeric_limits<float>::infinity())) - static_cast<double>(v);
}
} // namespace

TEST_CASE("exponential: within 2 ulp of the double exponential over its whole range")
{
    double worst = 0;
    float worst_at = 0;
    for (float x = -87.0f; x <= 88.0f; x += 0.000737f) { // 237,000 points, spread between every two powers of two
        double const right = std::exp(static_cast<double>(x));
        double const error = std::abs(static_cast<double>(exponential(x)) - right) / ulp(static_cast<float>(right));
        if (error > worst) worst = error, worst_at = x;
    }
    MESSAGE("largest error: ", worst, " ulp at ", worst_at);
    CHECK(worst < 2.0);
}

TEST_CASE("exponential: exact at zero, monotone to a bound at both ends, never infinite")
{
    CHECK(exponential(0.0f) == 1.0f);
    CHECK(exponential(-0.0f) == 1.0f);
    CHECK(exponential(-1e30f) == exponential(-87.0f));
    CHECK(exponential(-std::numeric_limits<float>::infinity()) == exponential(-87.0f));
    CHECK(exponential(std::numeric_limits<float>::infinity()) == exponential(88.0f));
    CHECK(std::isfinite(exponential(1e30f)));
    CHECK(exponential(std::numeric_limits<float>::quiet_NaN()) == exponential(-87.0f));
    CHECK(exponential(-87.0f) > 0.0f);
    float before = 0;
    for (float x = -20.0f; x < 0.01f; x += 0.01f) {
        CHECK(exponential(x) > before);
        before = exponential(x);
    }
    CHECK(exponential(-1e-9f) <= 1.0f); // alpha = opacity * exponential(power) must not pass the opacity
}

TEST_CASE("exponential: no power below zero gives more than 1")
{
    for (std::uint32_t i = 0; i < 0x3f000000u; i += 4099) { // negative floats from -0 down to -0.5
        auto const x = std::bit_cast<float>(i | 0x80000000u);
        if (!(exponential(x) <= 1.0f)) FAIL("above 1 at ", x);
    }
}
