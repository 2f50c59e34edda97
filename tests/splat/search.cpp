// test: without tsan
// Searches in lists of one or two words, against a loop.
#include "../standard.hpp"
#include <tilemesh/splat/regions.hpp>
#include <tilemesh/splat/search.hpp>

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
std::vector<std::uint32_t> all_by_loop(std::vector<std::uint32_t> const& words, std::uint32_t bits)
{
    std::vector<std::uint32_t> all;
    for (std::uint32_t i = 0; i < words.size(); ++i)
        if ((words[i] & bits) != 0) all.push_back(i);
    return all;
}
/// All numbers that calls with room for `most` list, one call after the other. A call that lists none, and does not end, would go on for ever.
std::vector<std::uint32_t> listed_up(std::vector<Mark> const& marks, std::uint32_t n, std::uint32_t bits, std::uint32_t most)
{
    std::vector<std::uint32_t> all, some(most);
    std::uint32_t calls = 0;
    for (std::uint32_t at = 0; at < n && calls <= n; ++calls) {
        auto const k = list_up_with_bits(marks.data(), at, n, bits, some.data(), most);
        all.insert(all.end(), some.begin(), some.begin() + static_cast<std::ptrdiff_t>(k));
    }
    CHECK(calls <= n);
    return all;
}
std::vector<std::uint32_t> listed_down(std::vector<Mark> const& marks, std::uint32_t n, std::uint32_t bits, std::uint32_t most)
{
    std::vector<std::uint32_t> all, some(most);
    std::uint32_t calls = 0;
    for (std::uint32_t end = n; end != 0 && calls <= n; ++calls) {
        auto const k = list_down_with_bits(marks.data(), end, bits, some.data(), most);
        all.insert(all.begin(), std::make_reverse_iterator(some.begin() + static_cast<std::ptrdiff_t>(k)), some.rend());
    }
    CHECK(calls <= n);
    return all;
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
            auto const numbers = at < n ? std::vector<std::uint32_t>{at} : std::vector<std::uint32_t>{};
            CHECK(listed_up(marks, n, 0x80000000u, fewest_listed) == numbers);
            CHECK(listed_down(marks, n, 0x80000000u, fewest_listed) == numbers);
        }
}

TEST_CASE("search: the first and all of several, random lists")
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
        auto const most = fewest_listed + static_cast<std::uint32_t>(random() % 50);
        CHECK(listed_up(marks, n, wanted, most) == all_by_loop(bits, wanted));
        CHECK(listed_down(marks, n, wanted, most) == all_by_loop(bits, wanted));
    }
}
