#include "everywhere.hpp"
#include <tilemesh/mpi/bands.hpp>

using namespace engine_test;

namespace {
std::uint64_t largest(mpi::Bands const& bands, std::vector<std::uint32_t> const& weights)
{
    std::uint64_t most = 0;
    for (std::uint32_t r = 0; r < bands.ranks(); ++r) {
        std::uint64_t sum = 0;
        for (auto y = bands.first(r); y < bands.last(r); ++y) sum += weights[y];
        most = std::max(most, sum);
    }
    return most;
}
/// The least largest sum of all ways to cut rows from `first` on into bands.
std::uint64_t best(std::vector<std::uint32_t> const& weights, std::size_t first, std::uint32_t ranks)
{
    std::uint64_t sum = 0, least = ~std::uint64_t{0};
    if (ranks == 1) {
        for (auto y = first; y < weights.size(); ++y) sum += weights[y];
        return sum;
    }
    for (auto y = first;; ++y) {
        least = std::min(least, std::max(sum, best(weights, y, ranks - 1)));
        if (y == weights.size()) return least;
        sum += weights[y];
    }
}
} // namespace

TEST_CASE("bands follow one another and have every row; without weights they differ by at most one row")
{
    for (std::uint32_t height : {1u, 2u, 7u, 36u, 65535u})
        for (std::uint32_t n : {1u, 2u, 3u, 7u, 64u}) {
            CAPTURE(height);
            CAPTURE(n);
            mpi::Bands const bands{height, n};
            CHECK(bands.first(0) == 0);
            CHECK(bands.last(n - 1) == height);
            for (std::uint32_t r = 0; r < n; ++r) {
                CHECK(bands.last(r) >= bands.first(r));
                CHECK(bands.last(r) - bands.first(r) >= height / n);
                CHECK(bands.last(r) - bands.first(r) <= (height + n - 1) / n);
                if (r > 0) CHECK(bands.first(r) == bands.last(r - 1));
                if (bands.first(r) != bands.last(r)) {
                    CHECK(bands.rank_of(bands.first(r)) == r);
                    CHECK(bands.rank_of(bands.last(r) - 1) == r);
                }
            }
        }
}

TEST_CASE("with weights, no cut has a smaller largest sum")
{
    Random random{3};
    for (int again = 0; again < 60; ++again) {
        std::vector<std::uint32_t> weights(1 + random.below(7));
        for (auto& w : weights) w = random.below(3) == 0 ? 0 : random.below(20);
        auto const n = 1 + random.below(4);
        CAPTURE(again);
        auto const height = static_cast<std::uint32_t>(weights.size());
        mpi::Bands const bands{height, n, weights};
        CHECK(bands.last(n - 1) == height);
        CHECK(largest(bands, weights) == best(weights, 0, n));
    }
    mpi::Bands const none{6, 3, std::vector<std::uint32_t>(6, 0)}; // no work at all: equal rows
    CHECK(none.last(0) == 2);
    CHECK(none.last(1) == 4);
    std::vector<std::uint32_t> const most(65535, 0xffffffffu); // sums beyond 32 bits
    CHECK(mpi::Bands{65535, 3, most}.last(0) == 21845);
    std::vector<std::uint32_t> const halves{0x80000000u, 0x80000000u, 0, 0, 0, 0}; // a sum of 2^32 is not a sum of 0
    CHECK(largest(mpi::Bands{6, 2, halves}, halves) == 0x80000000u);
}
