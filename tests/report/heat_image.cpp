// test: unoptimised test asan
#include "../standard.hpp"
#include <tilemesh/report/heat_image.hpp>
#include <tilemesh/report/image_file.hpp>

namespace {

using tilemesh::Error;
using namespace tilemesh::report;

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double largest = std::numeric_limits<double>::max();

using Bytes = std::array<unsigned, 3>;
constexpr Bytes first = {68, 1, 84}, middle = {33, 145, 140}, last = {253, 231, 37}, gap = {160, 160, 160};

/// Pixel (x, y) as a PNG has it.
Bytes at(Image const& image, std::uint32_t x, std::uint32_t y)
{
    auto const bytes = rgb8(image);
    auto const* const p = &bytes[3 * (std::size_t{y} * image.width + x)];
    return {std::to_integer<unsigned>(p[0]), std::to_integer<unsigned>(p[1]), std::to_integer<unsigned>(p[2])};
}
Bytes colour(double share)
{
    return at(heat_image(std::vector<double>{share}, 1, 1, {0, 1}), 0, 0);
}

/// CIE 1976 lightness of an sRGB colour (IEC 61966-2-1, D65).
double lightness(std::array<float, 3> const& rgb)
{
    auto const linear = [](double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); };
    double const y = 0.2126 * linear(rgb[0]) + 0.7152 * linear(rgb[1]) + 0.0722 * linear(rgb[2]);
    return y > 216.0 / 24389 ? 116 * std::cbrt(y) - 16 : 24389.0 / 27 * y;
}

} // namespace

TEST_CASE("the colours at both ends and in the middle are those of viridis; beyond an end is the end")
{
    CHECK(colour(0) == first);
    CHECK(colour(0.5) == middle);
    CHECK(colour(1) == last);
    CHECK(colour(-3) == first);
    CHECK(colour(7) == last);
    CHECK(heat_colour(not_a_number) == heat_gap);
    CHECK(colour(0.0625) == Bytes{70, 23, 104}); // half-way between (68, 1, 84) and (71, 45, 123), halves up
}

TEST_CASE("lightness rises all the way, and no step is more than three times another")
{
    double before = lightness(heat_colour(0)), least = infinite, most = 0;
    for (int i = 1; i <= 64; ++i) {
        double const now = lightness(heat_colour(i / 64.0));
        least = std::min(least, now - before);
        most = std::max(most, now - before);
        before = now;
    }
    CHECK(least > 0);
    CHECK(most < 3 * least);
    CHECK(before > 85); // from black paper to white
}

TEST_CASE("a map has its cells in rows from the top left, each as large as asked for")
{
    std::vector<double> const values = {0, 1, 2, 3, 4, 4};
    auto const small = heat_image(values, 3, 2, {0, 4});
    CHECK(small.width == 3);
    CHECK(small.height == 2);
    CHECK(at(small, 0, 0) == first);
    CHECK(at(small, 2, 0) == middle);
    CHECK(at(small, 1, 1) == last);
    auto const large = heat_image(values, 3, 2, {0, 4}, 5);
    CHECK(large.width == 15);
    CHECK(large.height == 10);
    bool all = true;
    for (std::uint32_t y = 0; y < 10; ++y)
        for (std::uint32_t x = 0; x < 15; ++x) all = all && at(large, x, y) == at(small, x / 5, y / 5);
    CHECK(all);
    auto const flat = heat_image(values, 3, 2, finite_range(values), 5, 2); // a tile that is wider than high
    CHECK(flat.width == 15);
    CHECK(flat.height == 4);
    for (std::uint32_t y = 0; y < 4; ++y)
        for (std::uint32_t x = 0; x < 15; ++x) all = all && at(flat, x, y) == at(small, x / 5, y / 2);
    CHECK(all);
}

TEST_CASE("zeros, one value everywhere, and values that are none")
{
    for (double const v : {0.0, 5.0, -5.0, largest}) {
        std::vector<double> const values(4, v);
        auto const range = finite_range(values);
        CHECK(range.least == v);
        CHECK(range.most == v);
        CHECK(at(heat_image(values, 2, 2, range), 1, 1) == first);
    }
    CHECK(at(heat_image(std::vector<double>{1}, 1, 1, {0, 0}), 0, 0) == last); // above an empty range

    std::vector<double> const odd = {not_a_number, infinite, -infinite, 1, 2, 3};
    auto const range = finite_range(odd);
    CHECK(range.least == 1);
    CHECK(range.most == 3);
    auto const image = heat_image(odd, 3, 2, range);
    for (std::uint32_t x = 0; x < 3; ++x) CHECK(at(image, x, 0) == gap);
    CHECK(at(image, 0, 1) == first);
    CHECK(at(image, 1, 1) == middle);
    CHECK(at(image, 2, 1) == last);

    std::vector<double> const none = {not_a_number, infinite};
    CHECK(finite_range(none).least == 0);
    CHECK(finite_range(none).most == 0);
    CHECK(at(heat_image(none, 2, 1, finite_range(none)), 1, 0) == gap);
    CHECK(finite_range({}).most == 0);

    std::vector<double> const far = {-largest, 0, largest}; // their difference is no double
    auto const wide = heat_image(far, 3, 1, finite_range(far));
    CHECK(at(wide, 0, 0) == first);
    CHECK(at(wide, 1, 0) == middle);
    CHECK(at(wide, 2, 0) == last);
}

TEST_CASE("a legend goes from the first colour to the last")
{
    auto const bar = heat_legend(9, 2);
    CHECK(at(bar, 0, 0) == first);
    CHECK(at(bar, 4, 1) == middle);
    CHECK(at(bar, 8, 1) == last);
    CHECK(at(heat_legend(1, 1), 0, 0) == first);
    CHECK(tests::has(tests::error_of([] { (void)heat_legend(0, 5); }), "no pixels"));
}

TEST_CASE("what is no map is refused")
{
    std::vector<double> const two = {1, 2};
    CHECK(tests::has(tests::error_of([&] { (void)heat_image(two, 2, 2, {0, 1}); }), "2 values are not 2 x 2"));
    CHECK(tests::has(tests::error_of([&] { (void)heat_image(two, 2, 1, {1, 0}); }), "not in order"));
    CHECK(tests::has(tests::error_of([&] { (void)heat_image(two, 2, 1, {0, infinite}); }), "not finite"));
    CHECK(tests::has(tests::error_of([&] { (void)heat_image(two, 2, 1, {not_a_number, 1}); }), "not finite"));
    CHECK(tests::has(tests::error_of([&] { (void)heat_image(two, 2, 1, {0, 1}, 0); }), "0 x 0 pixels"));
    CHECK(tests::has(tests::error_of([&] { (void)heat_image(two, 2, 1, {0, 1}, 32'768); }), "65536 x 32768 pixels"));
    CHECK(heat_image(two, 2, 1, {0, 1}, 1).width == 2);
    CHECK(tests::has(tests::error_of([] { (void)heat_image({}, 0, 0, {0, 1}); }), "0 x 0 pixels"));
}
