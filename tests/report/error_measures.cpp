#include "picture_of_formula.hpp"
#include "../standard.hpp"
#include <tilemesh/report/error_measures.hpp>

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
    for (auto& value : image.rgb) value = static_cast<float>(random() >> 8) * 0x1p-24f * 1.5f - 0.2f;
    return image;
}

/// PSNR, SSIM and L1 by their formulas, each window a plain loop over its 121 weights. Beyond the border a picture goes on with its last
/// pixel, or is 0.
enum class Beyond { last_pixel, zero };
struct Plain {
    double psnr_db, ssim, l1;
};
Plain plain_measures(Image const& a, Image const& b, Beyond beyond)
{
    auto const width = static_cast<int>(a.width), height = static_cast<int>(a.height);
    double weights[121], total = 0.0, squares = 0.0, absolutes = 0.0, ssim = 0.0;
    for (int k = 0; k < 121; ++k) total += weights[k] = std::exp(-((k % 11 - 5) * (k % 11 - 5) + (k / 11 - 5) * (k / 11 - 5)) / (2.0 * 1.5 * 1.5));
    for (int channel = 0; channel < 3; ++channel)
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                auto const value = [&](Image const& image, int k) {
                    auto const column = std::clamp(x + k % 11 - 5, 0, width - 1), row = std::clamp(y + k / 11 - 5, 0, height - 1);
                    if (beyond == Beyond::zero && (column != x + k % 11 - 5 || row != y + k / 11 - 5)) return 0.0;
                    return double{image.rgb[static_cast<std::size_t>(3 * (row * width + column) + channel)]};
                };
                double const difference = value(a, 60) - value(b, 60); // the middle
                squares += difference * difference, absolutes += std::fabs(difference);
                double mean_a = 0.0, mean_b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0; // means first, then central moments
                for (int k = 0; k < 121; ++k) mean_a += weights[k] / total * value(a, k), mean_b += weights[k] / total * value(b, k);
                for (int k = 0; k < 121; ++k) {
                    double const weight = weights[k] / total, da = value(a, k) - mean_a, db = value(b, k) - mean_b;
                    aa += weight * da * da, bb += weight * db * db, ab += weight * da * db;
                }
                ssim += (2 * mean_a * mean_b + 1e-4) * (2 * ab + 9e-4) / ((mean_a * mean_a + mean_b * mean_b + 1e-4) * (aa + bb + 9e-4));
            }
    double const n = 3.0 * width * height;
    return {10.0 * std::log10(n / squares), ssim / n, absolutes / n};
}

std::string error_of(Image const& image, Image const& reference)
{
    return tests::error_of([&] { (void)compare(image, reference); });
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
    for (std::size_t i = 0; i < 3000; ++i) image.rgb[i] = static_cast<float>(i * 7 % 3000 + 1) / 4096.0f * (i % 2 == 0 ? 1.0f : -1.0f);
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
    for (auto const& size : {std::pair{1u, 1u}, {2u, 30u}, {30u, 3u}, {11u, 11u}, {24u, 19u}}) {
        auto const width = size.first, height = size.second; // Clang 14 captures no structured binding
        INFO(width, " x ", height);
        auto const a = noise(width, height, 1);
        auto b = noise(width, height, 2);
        CHECK(near(compare(a, b).ssim, plain_measures(a, b, Beyond::last_pixel).ssim, 1e-12));
        for (std::size_t i = 0; i < b.rgb.size(); ++i) b.rgb[i] = a.rgb[i] + 0.1f * (b.rgb[i] - 0.5f);
        auto const similar = compare(a, b).ssim;
        CHECK(near(similar, plain_measures(a, b, Beyond::last_pixel).ssim, 1e-12));
        CHECK(similar < 1.0);
        CHECK(near(compare(b, a).ssim, similar, 1e-12));
    }
}

TEST_CASE("a picture and a photograph are compared as plain loops in double compare them")
{
    for (auto const& size : {std::pair{1u, 1u}, {3u, 40u}, {11u, 11u}, {37u, 10u}}) {
        auto const width = size.first, height = size.second; // Clang 14 captures no structured binding
        INFO(width, " x ", height);
        auto const a = noise(width, height, 3), b = noise(width, height, 4);
        auto const measures = tilemesh::report::compare_pictures(a, b);
        auto const plain = plain_measures(a, b, Beyond::zero);
        CHECK(near(measures.psnr_db, plain.psnr_db, 1e-11));
        CHECK(near(measures.ssim, plain.ssim, 1e-12));
        CHECK(near(measures.l1, plain.l1, 1e-13));
    }
}

TEST_CASE("pictures with known PSNR, SSIM and L1")
{
    using tilemesh::report::compare_pictures;
    // By a third program (NumPy, float64): the evaluation script's formula on these pictures.
    auto const a = picture_of_formula(24, 17);
    Image turned{24, 17}, faded{24, 17};
    for (std::uint32_t y = 0; y < 17; ++y)
        for (std::uint32_t x = 0; x < 24; ++x)
            for (std::uint32_t c = 0; c < 3; ++c) {
                turned.pixel((x + 1) % 24, y)[c] = a.pixel(x, y)[c];
                faded.pixel(x, y)[c] = (std::floor(a.pixel(x, y)[c] * 255.0f / 2.0f + 0.25f) + 60.0f) / 255.0f;
            }
    auto const other = compare_pictures(a, turned), pale = compare_pictures(a, faded);
    CHECK(near(other.psnr_db, 7.732278443692731, 1e-6));
    CHECK(near(other.ssim, 0.16011945910575257, 1e-7));
    CHECK(near(other.l1, 0.3392349128212682, 1e-7));
    CHECK(near(other.largest, 0.9725490193814039, 1e-7));
    CHECK(other.largest_at == std::array<std::uint32_t, 2>{11, 16});
    CHECK(near(pale.psnr_db, 16.75045100268919, 1e-6));
    CHECK(near(pale.ssim, 0.8457498856453807, 1e-7));
    CHECK(near(pale.l1, 0.1255927187340407, 1e-7));
    CHECK(pale.largest_at == std::array<std::uint32_t, 2>{4, 4});

    // One pixel: the windows see it with the weight g of their middle, and zeros elsewhere.
    double total = 0.0;
    for (int i = -5; i <= 5; ++i) total += std::exp(i * i / -4.5);
    double const g = 1.0 / (total * total), m = 0.75 * g, n = 0.5 * g;
    auto const one = compare_pictures(flat(1, 1, 0.75f), flat(1, 1, 0.5f));
    CHECK(near(one.ssim, (2 * m * n + 1e-4) * (2 * (0.375 * g - m * n) + 9e-4) /
                             ((m * m + n * n + 1e-4) * (0.5625 * g - m * m + 0.25 * g - n * n + 9e-4)), 1e-13));
    CHECK(near(one.psnr_db, 12.041199826559248, 1e-12));
    CHECK(one.l1 == 0.25);
    // Zeros outside the picture are structure that both pictures have: the border raises the SSIM of 0.92309 that `compare` gives.
    CHECK(near(compare_pictures(flat(20, 15, 0.75f), flat(20, 15, 0.5f)).ssim, 0.8694674331879252, 1e-12));

    auto const equal = compare_pictures(a, a);
    CHECK(equal.psnr_db == std::numeric_limits<double>::infinity());
    CHECK(equal.ssim == 1.0);
    CHECK(equal.l1 == 0.0);
    CHECK(equal.largest == 0.0);
    CHECK(equal.largest_at == std::array<std::uint32_t, 2>{0, 0});
}

TEST_CASE("a pixel that a mask leaves out does not count")
{
    auto a = flat(30, 20, 0.5f), b = flat(30, 20, 0.75f), masked = b;
    for (std::uint32_t y = 0; y < 20; ++y)
        for (std::uint32_t x = 0; x < 30; ++x)
            if (x < 10) std::fill_n(masked.pixel(x, y), 3, std::numeric_limits<float>::quiet_NaN());
    for (std::uint32_t y = 0; y < 20; ++y) a.pixel(3, y)[0] = 9.0f; // a blot under the mask
    auto const measures = tilemesh::report::compare_pictures(a, masked);
    CHECK(near(measures.l1, 0.25, 1e-12));
    CHECK(near(measures.psnr_db, -20 * std::log10(0.25), 1e-12));
    CHECK(measures.largest == 0.25);
    CHECK(measures.largest_at == std::array<std::uint32_t, 2>{10, 0});
    CHECK(measures.ssim > 0.75);
    CHECK(measures.ssim < 1);
    CHECK(tilemesh::report::error_picture(a, masked).pixel(3, 4)[0] == 0.0f);
    for (auto& value : masked.rgb) value = std::numeric_limits<float>::quiet_NaN();
    CHECK_THROWS_WITH_AS(tilemesh::report::compare_pictures(a, masked), doctest::Contains("no pixel of the reference counts"), tilemesh::Error);
}

TEST_CASE("the largest difference is that of a channel, and the first of equals")
{
    auto a = flat(5, 4, 0.25f), b = a;
    b.pixel(3, 1)[2] = 1.25f;
    b.pixel(1, 2)[0] = -0.75f;
    b.pixel(0, 0)[1] = 0.5f;
    auto const measures = tilemesh::report::compare_pictures(a, b);
    CHECK(measures.largest == 1.0);
    CHECK(measures.largest_at == std::array<std::uint32_t, 2>{3, 1});
    CHECK(tilemesh::report::compare_pictures(b, a).largest_at == measures.largest_at);

    auto const error = tilemesh::report::error_picture(a, b);
    CHECK(error.pixel(3, 1)[2] == 1.0f);
    CHECK(error.pixel(1, 2)[0] == 1.0f);
    CHECK(error.pixel(0, 0)[1] == 0.25f);
    CHECK(std::count(error.rgb.begin(), error.rgb.end(), 0.0f) == 57);
    auto const black = tilemesh::report::error_picture(a, a);
    CHECK(std::count(black.rgb.begin(), black.rgb.end(), 0.0f) == 60);

    CHECK_THROWS_WITH_AS(tilemesh::report::compare_pictures(a, flat(4, 5, 0.0f)), doctest::Contains("5 x 4, the reference 4 x 5"), tilemesh::Error);
    CHECK_THROWS_AS(tilemesh::report::error_picture(a, flat(5, 3, 0.0f)), tilemesh::Error);
    b.pixel(2, 2)[1] = std::numeric_limits<float>::infinity();
    CHECK_THROWS_WITH_AS(tilemesh::report::compare_pictures(a, b), doctest::Contains("pixel 2, 2, channel 1"), tilemesh::Error);
}

TEST_CASE("a clamped picture has values from 0 to 1")
{
    Image image{1, 2};
    image.rgb = {-0.0f, 1.0f, 0.3f, -2.0f, 7.0f, std::numeric_limits<float>::quiet_NaN()};
    CHECK(tilemesh::report::clamped(image).rgb == std::vector<float>{0.0f, 1.0f, 0.3f, 0.0f, 1.0f, 0.0f});
}

TEST_CASE("SSIM of one channel is a third of the loss")
{
    auto const reference = noise(16, 16, 5);
    double loss = 0.0;
    auto all = reference;
    for (std::uint32_t channel = 0; channel < 3; ++channel) {
        auto image = reference;
        for (std::size_t i = channel; i < image.rgb.size(); i += 3) all.rgb[i] = image.rgb[i] = 1.0f - reference.rgb[i];
        auto const ssim = compare(image, reference).ssim;
        CHECK(ssim < 0.9);
        loss += 1.0 - ssim;
    }
    CHECK(near(1.0 - compare(all, reference).ssim, loss, 1e-12));
}

TEST_CASE("the measures do not depend on which is the reference")
{
    auto const a = noise(21, 12, 3), b = noise(21, 12, 4);
    auto const forth = compare(a, b), back = compare(b, a);
    CHECK(forth.rmse > 0.1);
    using Errors = tilemesh::report::ErrorMeasures;
    for (auto const measure : {&Errors::rmse, &Errors::max_levels, &Errors::p999_levels, &Errors::mae, &Errors::share_over_one_level})
        CHECK(forth.*measure == back.*measure);
}

TEST_CASE("what is not finite is refused by name")
{
    auto const good = flat(6, 5, 0.5f);
    CHECK(error_of(good, good).empty());
    constexpr float infinity = std::numeric_limits<float>::infinity();
    for (float const bad : {std::numeric_limits<float>::quiet_NaN(), infinity, -infinity}) {
        auto broken = good;
        broken.pixel(3, 2)[1] = broken.pixel(5, 4)[2] = bad;
        auto const text = error_of(broken, good);
        CHECK(tests::has(text, "the picture is not finite at pixel 3, 2, channel 1"));
        CHECK(tests::has(text, "); "));
        CHECK(tests::has(error_of(good, broken), "the reference is not finite at pixel 3, 2, channel 1"));
        CHECK_FALSE(error_of(broken, broken).empty());
    }
}

TEST_CASE("pictures of different sizes are refused")
{
    auto const picture = flat(6, 5, 0.5f);
    auto const text = error_of(picture, flat(5, 6, 0.5f));
    for (auto const* part : {"6 x 5", "5 x 6", "); "}) CHECK(tests::has(text, part));
    auto bent = picture;
    bent.rgb.pop_back();
    for (auto const& other : {flat(5, 5, 0.5f), flat(6, 4, 0.5f), flat(10, 3, 0.5f), bent}) CHECK_FALSE(error_of(picture, other).empty());
    CHECK_FALSE(error_of(bent, picture).empty());
    CHECK_FALSE(error_of(Image{}, Image{}).empty());
}

TEST_SUITE_END();
