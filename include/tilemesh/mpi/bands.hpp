#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <tilemesh/error.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace mpi {

/// The rows of a grid, cut into one band of neighbouring rows for each rank. Bands follow one another from north to south. A band may be
/// empty.
class Bands {
public:
    /// Bands of equal height: they differ by at most one row.
    Bands(std::uint32_t height, std::uint32_t ranks) : begin_(std::size_t{ranks} + 1)
    {
        for (std::size_t r = 0; r <= ranks; ++r) begin_[r] = static_cast<std::uint32_t>(std::uint64_t{height} * r / ranks);
    }
    /// Bands of equal work, for a weight per row (in any unit): no other bands have a smaller largest sum of weights. Without weights, or if
    /// all are 0, bands of equal height. Throws Error if there is not one weight for each row.
    Bands(std::uint32_t height, std::uint32_t ranks, std::vector<std::uint32_t> const& weights) : Bands(height, ranks)
    {
        if (weights.empty()) return;
        if (weights.size() != height)
            throw Error(std::to_string(weights.size()) + " row weights (the grid has " + std::to_string(height) +
                        " rows); give one for each row, or none");
        std::uint64_t least = 0, most = 0;
        for (auto w : weights) {
            least = std::max<std::uint64_t>(least, w);
            most += w;
        }
        if (most == 0) return;
        while (least < most) { // the smallest sum that no band needs to exceed
            auto const sum = least + (most - least) / 2;
            if (cut(weights, sum)) most = sum;
            else least = sum + 1;
        }
        cut(weights, most);
    }

    std::uint32_t ranks() const noexcept { return static_cast<std::uint32_t>(begin_.size()) - 1; }
    std::uint32_t height() const noexcept { return begin_.back(); }
    /// The rows of a rank: first(rank)..last(rank)-1.
    std::uint32_t first(std::uint32_t rank) const noexcept { return begin_[rank]; }
    std::uint32_t last(std::uint32_t rank) const noexcept { return begin_[rank + 1]; }
    /// The rank that has a row.
    std::uint32_t rank_of(std::uint32_t row) const noexcept
    {
        return static_cast<std::uint32_t>(std::upper_bound(begin_.begin(), begin_.end(), row) - begin_.begin()) - 1;
    }

private:
    /// Gives each rank as many rows as its sum of weights allows. Returns false if rows are left; then it leaves the bands as they are.
    bool cut(std::vector<std::uint32_t> const& weights, std::uint64_t most)
    {
        auto begin = begin_;
        std::size_t row = 0;
        for (std::size_t r = 1; r < begin.size(); ++r) {
            for (std::uint64_t sum = 0; row < weights.size() && sum + weights[row] <= most; ++row) sum += weights[row];
            begin[r] = static_cast<std::uint32_t>(row);
        }
        if (row != weights.size()) return false;
        begin_ = std::move(begin);
        return true;
    }

    std::vector<std::uint32_t> begin_; ///< the first row of each rank; last, the height
};

}}} // namespace tilemesh::mpi
