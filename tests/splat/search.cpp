// test: without tsan
// Searches in lists of one or two words, against a loop.
#include <doctest/doctest.h>
#include <random>
#include <tilemesh/splat/regions.hpp>
#include <tilemesh/splat/search.hpp>
#include <vector>

using namespace tilemesh;
using namespace tilemesh::splat;

namespace {
struct Row {
    std::uint32_t row;
};
std::uint32_t first_by_loop(std::vector<std::uint32_t> const& words, std::uint32_t n, std::uint32_t word)
{
    for (std::uint32_t i = 0; i < n; ++i)
        if (words[i] == word) return i;
    return no_slot;
}
std::uint32_t last_by_loop(std::vector<std::uint32_t> const& words, std::uint32_t n, std::uint32_t bits)
{
    for (std::uint32_t i = n; i-- > 0;)
        if ((words[i] & bits) != 0) return i;
    return no_slot;
}
} // namespace

TEST_CASE("search: every place in lists of every size to 70, and none")
{
    for (std::uint32_t n = 0; n <= 70; ++n)
        for (std::uint32_t at = 0; at <= n; ++at) { // n: nowhere
            CAPTURE(n);
            CAPTURE(at);
            std::vector<Row> rows(n + 1, Row{7});
            std::vector<Mark> marks(n + 1, Mark{GaussianId{7}, 9}); // the other word is never what is looked for
            rows[at].row = 9;
            marks[at] = {GaussianId{9}, 7};
            std::uint32_t const expected = at < n ? at : no_slot;
            CHECK(first_with_word(rows.data(), n, 9) == expected);
            CHECK(first_with_word(marks.data(), n, 9) == expected);
            for (auto& mark : marks) mark = {GaussianId{0xffffffffu}, 1};
            marks[at].bits = 0x80000001u;
            CHECK(last_with_bits(marks.data(), n, 0x80000000u) == expected);
        }
}

TEST_CASE("search: the first and the last of several, random lists")
{
    std::mt19937 random(5);
    for (std::uint32_t round = 0; round < 2000; ++round) {
        auto const n = static_cast<std::uint32_t>(random() % 300), kinds = 1 + static_cast<std::uint32_t>(random() % 400);
        std::vector<std::uint32_t> words(n), bits(n);
        std::vector<Mark> marks(n);
        for (std::uint32_t i = 0; i < n; ++i) {
            words[i] = static_cast<std::uint32_t>(random() % kinds);
            bits[i] = 1u << random() % 32 & (random() % 8 == 0 ? 0xffffffffu : 0xffu);
            marks[i] = {GaussianId{words[i]}, bits[i]};
        }
        auto const word = static_cast<std::uint32_t>(random() % kinds), wanted = 1u << random() % 32 | 1u << random() % 32;
        CHECK(first_with_word(words.data(), n, word) == first_by_loop(words, n, word));
        CHECK(first_with_word(marks.data(), n, word) == first_by_loop(words, n, word));
        CHECK(last_with_bits(marks.data(), n, wanted) == last_by_loop(bits, n, wanted));
    }
}
