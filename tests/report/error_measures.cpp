#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <doctest/doctest.h>
#include <limits>
#include <random>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/image.hpp>

namespace {

using tilemesh::report::compare;
using tilemesh::report::Image;

bool near(double value, double expected, double tolerance)
{
    return std::abs(value - expected) <= tolerance;
}

Image flat(std::uint32_t width, std::uint32_t height, float value)
{
    Image image{width, height};
    std::fill(image.rgb.begin(), image.rgb.end(), value);
    return image;
}

Image noise(std::uint32_t width, std::uint32_t height, std::uint32_t seed)
{
    std::mt19937 random{seed};
    Image image{width, height};
    for (auto& value : image.rgb)
        value = static_cast<float>(random() >> 8) * 0x1p-24f * 1.5f - 0.2f;
    return image;
}

/// SSIM by its formula: for every pixel and channel a double sum over the 121 weights, means first, then central moments.
double brute_ssim(Image const& a, Image const& b)
{
    double weights[11][11];
    double total = 0.0;
    for (int j = -5; j <= 5; ++j)
        for (int i = -5; i <= 5; ++i)
            total += weights[j + 5][i + 5] = std::exp(-(i * i + j * j) / (2.0 * 1.5 * 1.5));
    double sum = 0.0;
    auto const width = static_cast<int>(a.width);
    auto const height = static_cast<int>(a.height);
    for (int channel = 0; channel < 3; ++channel)
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                auto const value = [&](Image const& image, int i, int j) {
                    auto const column = std::min(std::max(x + i, 0), width - 1);
                    auto const row = std::min(std::max(y + j, 0), height - 1);
                    return double{
                        image.rgb[static_cast<std::size_t>(3 * (row * width + column) + channel)]};
                };
                double mean_a = 0.0;
                double mean_b = 0.0;
                for (int j = -5; j <= 5; ++j)
                    for (int i = -5; i <= 5; ++i) {
                        mean_a += weights[j + 5][i + 5] / total * value(a, i, j);
                        mean_b += weights[j + 5][i + 5] / total * value(b, i, j);
                    }
                double aa = 0.0;
                double bb = 0.0;
                double ab = 0.0;
                for (int j = -5; j <= 5; ++j)
                    for (int i = -5; i <= 5; ++i) {
                        double const weight = weights[j + 5][i + 5] / total;
                        double const da = value(a, i, j) - mean_a;
                        double const db = value(b, i, j) - mean_b;
                        aa += weight * da * da;
                        bb += weight * db * db;
                        ab += weight * da * db;
                    }
                sum += (2 * mean_a * mean_b + 1e-4) * (2 * ab + 9e-4) /
                       ((mean_a * mean_a + mean_b * mean_b + 1e-4) * (aa + bb + 9e-4));
            }
    return sum / (3.0 * width * height);
}

std::string error_of(Image const& image, Image const& reference)
{
    try {
        (void)compare(image, reference);
    } catch (tilemesh::Error const& error) {
        return error.what();
    }
    return "";
}

} // namespace

TEST_SUITE_BEGIN("report");

TEST_CASE("equal pictures have no error")
{
    for (auto const& image : {noise(17, 13, 1), flat(1, 1, -4.0f), flat(3, 20, 0.0f)}) {
        auto const error = compare(image, image);
        CHECK(error.rmse == 0.0);
        CHECK(error.max_levels == 0.0);
        CHECK(error.p999_levels == 0.0);
        CHECK(error.psnr_db == std::numeric_limits<double>::infinity());
        CHECK(error.ssim == 1.0);
        CHECK(error.mae == 0.0);
        CHECK(error.share_over_one_level == 0.0);
    }
}

TEST_CASE("a constant offset")
{
    // 0.5 and 0.25 are exact: the offset is d = 0.25 everywhere.
    auto const error = compare(flat(20, 15, 0.75f), flat(20, 15, 0.5f));
    CHECK(near(error.rmse, 0.25, 1e-15));
    CHECK(near(error.mae, 0.25, 1e-15));
    CHECK(near(error.max_levels, 63.75, 1e-12));
    CHECK(near(error.p999_levels, 63.75, 1e-12));
    CHECK(near(error.psnr_db, 12.041199826559248, 1e-12)); // -20 log10 0.25
    CHECK(error.share_over_one_level == 1.0);
    // No structure: only the luminance term, (2 * 0.375 + 1e-4) / (0.5625 + 0.25 + 1e-4).
    CHECK(near(error.ssim, 0.7501 / 0.8126, 1e-12));
}

TEST_CASE("a single spike")
{
    auto const reference = flat(10, 10, 0.0f);
    auto image = reference;
    image.pixel(4, 7)[1] = 3.0f; // above 1: no value is clamped
    auto const error = compare(image, reference);
    CHECK(near(error.rmse, std::sqrt(9.0 / 300.0), 1e-15));
    CHECK(near(error.mae, 0.01, 1e-15));
    CHECK(error.max_levels == 765.0);
    CHECK(error.p999_levels == 765.0); // rank ceil(0.999 * 300) = 300: the largest
    CHECK(near(error.psnr_db, -10.0 * std::log10(0.03), 1e-12));
    CHECK(error.share_over_one_level == 0.01);
    CHECK(error.ssim < 1.0);
    CHECK(error.ssim > 0.0);
}

TEST_CASE("PSNR is negative where the error is above the peak")
{
    CHECK(near(compare(flat(2, 2, 10.0f), flat(2, 2, 0.0f)).psnr_db, -20.0, 1e-12));
}

TEST_CASE("p99.9 is the nearest rank")
{
    // 3000 values with the errors 1/4096 .. 3000/4096 in disorder (7 and 3000 share no factor).
    Image image{100, 10};
    for (std::size_t i = 0; i < 3000; ++i)
        image.rgb[i] = static_cast<float>(i * 7 % 3000 + 1) / 4096.0f * (i % 2 == 0 ? 1.0f : -1.0f);
    auto const error = compare(image, Image{100, 10});
    CHECK(error.p999_levels == 255.0 * 2997.0 / 4096.0); // ceil(0.999 * 3000) = 2997
    CHECK(error.max_levels == 255.0 * 3000.0 / 4096.0);
    CHECK(near(error.mae, 1500.5 / 4096.0, 1e-13));

    // 2997 values: ceil(2994.003) = 2995, so two are above.
    Image shorter{999, 1};
    for (std::size_t i = 0; i < 3; ++i) shorter.rgb[700 * i] = static_cast<float>(1 + i);
    CHECK(compare(shorter, Image{999, 1}).p999_levels == 255.0);

    // 1002 values: ceil(1000.998) = 1001, so one value is above.
    Image other{334, 1};
    other.rgb[500] = 1.0f;
    other.rgb[20] = 0.5f;
    CHECK(compare(other, Image{334, 1}).p999_levels == 127.5);
}

TEST_CASE("the share over one level counts pixels and not values")
{
    auto const reference = flat(4, 1, 0.0f);
    auto image = reference;
    image.pixel(0, 0)[0] = 1.01f / 255.0f;
    image.pixel(0, 0)[2] = -1.01f / 255.0f;
    image.pixel(1, 0)[1] = 0.99f / 255.0f;
    CHECK(compare(image, reference).share_over_one_level == 0.25);
}

TEST_CASE("SSIM is that of its definition")
{
    struct Size {
        std::uint32_t width, height;
    };
    for (auto const& size : {Size{1, 1}, Size{2, 30}, Size{30, 3}, Size{11, 11}, Size{24, 19}}) {
        auto const width = size.width;
        auto const height = size.height;
        CAPTURE(width);
        CAPTURE(height);
        auto const a = noise(width, height, 1);
        auto b = noise(width, height, 2);
        CHECK(near(compare(a, b).ssim, brute_ssim(a, b), 1e-12));
        for (std::size_t i = 0; i < b.rgb.size(); ++i)
            b.rgb[i] = a.rgb[i] + 0.1f * (b.rgb[i] - 0.5f);
        auto const similar = compare(a, b).ssim;
        CHECK(near(similar, brute_ssim(a, b), 1e-12));
        CHECK(similar < 1.0);
        CHECK(near(compare(b, a).ssim, similar, 1e-12));
    }
}

TEST_CASE("SSIM of one channel is a third of the loss")
{
    auto const reference = noise(16, 16, 5);
    double loss = 0.0;
    auto all = reference;
    for (std::uint32_t channel = 0; channel < 3; ++channel) {
        auto image = reference;
        for (std::size_t i = channel; i < image.rgb.size(); i += 3)
            all.rgb[i] = image.rgb[i] = 1.0f - reference.rgb[i];
        auto const ssim = compare(image, reference).ssim;
        CHECK(ssim < 0.9);
        loss += 1.0 - ssim;
    }
    CHECK(near(1.0 - compare(all, reference).ssim, loss, 1e-12));
}

TEST_CASE("the measures do not depend on which is the reference")
{
    auto const a = noise(21, 12, 3);
    auto const b = noise(21, 12, 4);
    auto const forth = compare(a, b);
    auto const back = compare(b, a);
    CHECK(forth.rmse > 0.1);
    CHECK(forth.rmse == back.rmse);
    CHECK(forth.max_levels == back.max_levels);
    CHECK(forth.p999_levels == back.p999_levels);
    CHECK(forth.mae == back.mae);
    CHECK(forth.share_over_one_level == back.share_over_one_level);
}

TEST_CASE("what is not finite is refused by name")
{
    auto const good = flat(6, 5, 0.5f);
    CHECK(error_of(good, good).empty());
    for (float const bad :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
          -std::numeric_limits<float>::infinity()}) {
        auto broken = good;
        broken.pixel(3, 2)[1] = bad;
        broken.pixel(5, 4)[2] = bad;
        auto text = error_of(broken, good);
        CHECK(text.find("the picture is not finite at pixel 3, 2, channel 1") != std::string::npos);
        CHECK(text.find("); ") != std::string::npos);
        text = error_of(good, broken);
        CHECK(text.find("the reference is not finite at pixel 3, 2, channel 1") !=
              std::string::npos);
        CHECK_FALSE(error_of(broken, broken).empty());
    }
}

TEST_CASE("pictures of different sizes are refused")
{
    auto const text = error_of(flat(6, 5, 0.5f), flat(5, 6, 0.5f));
    CHECK(text.find("6 x 5") != std::string::npos);
    CHECK(text.find("5 x 6") != std::string::npos);
    CHECK(text.find("); ") != std::string::npos);
    CHECK_FALSE(error_of(flat(6, 5, 0.5f), flat(5, 5, 0.5f)).empty());
    CHECK_FALSE(error_of(flat(6, 5, 0.5f), flat(6, 4, 0.5f)).empty());
    CHECK_FALSE(error_of(flat(6, 5, 0.5f), flat(10, 3, 0.5f)).empty());
    CHECK_FALSE(error_of(Image{}, Image{}).empty());
    auto bent = flat(6, 5, 0.5f);
    bent.rgb.pop_back();
    CHECK_FALSE(error_of(bent, flat(6, 5, 0.5f)).empty());
    CHECK_FALSE(error_of(flat(6, 5, 0.5f), bent).empty());
}

TEST_SUITE_END();
