#include "picture_of_formula.hpp"
#include "../standard.hpp"
#include <tilemesh/report/resample.hpp>

namespace {

using tilemesh::report::Image;
using tilemesh::report::resized_as_photograph;

std::vector<int> levels(Image const& image)
{
    std::vector<int> all;
    for (float const value : image.rgb) {
        float const level = 255.0f * value;
        CHECK(std::fabs(level - std::round(level)) < 1e-4f);
        all.push_back(static_cast<int>(std::round(level)));
    }
    return all;
}

} // namespace

TEST_SUITE_BEGIN("report");

TEST_CASE("a photograph is resized to the levels of Pillow's bicubic filter")
{
    // The levels were computed with Pillow 9.4: Image.resize(size, Image.BICUBIC).
    CHECK(levels(resized_as_photograph(picture_of_formula(7, 5), 3, 2)) ==
          std::vector<int>{80, 134, 184, 117, 142, 113, 130, 126, 139, 133, 144, 113, 129, 142, 117, 137, 127, 104});
    CHECK(levels(resized_as_photograph(picture_of_formula(8, 8), 4, 4)) ==
          std::vector<int>{49,  128, 203, 124, 144, 122, 98,  154, 135, 153, 120, 101, 129, 163, 133, 140, 108, 115, 121, 137, 106, 153, 123, 131,
                           145, 95,  107, 133, 175, 76,  129, 185, 91,  112, 123, 143, 136, 146, 116, 59,  139, 156, 66,  172, 145, 124, 93,  159});
    // Only the rows shrink: their pass alone, 9 x 6 to 9 x 2.
    CHECK(levels(resized_as_photograph(picture_of_formula(9, 6), 9, 2)) ==
          std::vector<int>{39,  136, 197, 90,  158, 178, 181, 110, 107, 101, 121, 128, 83,  174, 110, 127, 147, 123, 168, 67,  158, 144, 171, 70,  118, 145, 115,
                           103, 123, 143, 174, 123, 93,  165, 135, 91,  104, 165, 94,  106, 197, 96,  169, 138, 88,  102, 129, 129, 134, 124, 151, 127, 117, 137});
    // It may grow, and overshoots are clamped: 5 x 3 to 8 x 7, the first and the last row.
    auto const grown = levels(resized_as_photograph(picture_of_formula(5, 3), 8, 7));
    REQUIRE(grown.size() == 168);
    CHECK(std::vector<int>(grown.begin(), grown.begin() + 24) ==
          std::vector<int>{0, 86, 177, 10, 100, 205, 47, 139, 219, 126, 237, 101, 132, 243, 116, 62, 154, 255, 38, 128, 255, 30, 121, 236});
    CHECK(std::vector<int>(grown.end() - 24, grown.end()) ==
          std::vector<int>{69, 160, 255, 90, 194, 160, 138, 220, 32, 227, 133, 136, 241, 42, 169, 182, 0, 108, 168, 147, 94, 167, 255, 93});
}

TEST_CASE("a photograph of 640 x 479 pixels is resized to the levels of Pillow's bicubic filter")
{
    std::uint32_t digest = 0;
    for (int const level : levels(resized_as_photograph(picture_of_formula(640, 479), 213, 160))) digest = 31 * digest + static_cast<std::uint32_t>(level);
    CHECK(digest == 2353991629u);
}

TEST_CASE("a photograph keeps its pixels in its own size; one pixel is the mean of a flat picture")
{
    auto const photograph = picture_of_formula(13, 9);
    CHECK(resized_as_photograph(photograph, 13, 9).rgb == photograph.rgb);
    Image flat{6, 4};
    for (auto& value : flat.rgb) value = 0.4f;
    CHECK(resized_as_photograph(flat, 1, 1).rgb == std::vector<float>{0.4f, 0.4f, 0.4f});
    for (auto& value : flat.rgb) value = 1.5f; // clamped first
    CHECK(resized_as_photograph(flat, 3, 2).rgb == std::vector<float>(18, 1.0f));
}

TEST_CASE("a size that no picture has is refused")
{
    CHECK_THROWS_WITH_AS(resized_as_photograph(Image{2, 2}, 0, 1), doctest::Contains("cannot resize a picture of 2 x 2 pixels to 0 x 1"), tilemesh::Error);
    CHECK_THROWS_AS(resized_as_photograph(Image{2, 2}, 1, 65536), tilemesh::Error);
    CHECK_THROWS_AS(resized_as_photograph(Image{}, 1, 1), tilemesh::Error);
    Image bent{2, 2};
    bent.rgb.pop_back();
    CHECK_THROWS_AS(resized_as_photograph(bent, 1, 1), tilemesh::Error);
}

TEST_SUITE_END();
