#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace engine::detail {

/// A set of tiles. It has one bit per tile, and one bit for each word of 64 tiles that is not zero. To go through the set costs its tiles,
/// and one word for each 4,096 tiles of the grid. Two objects share no cache line.
class alignas(64) TileSet {
public:
    explicit TileSet(std::uint32_t tiles = 0)
        : words_((std::size_t{tiles} + 63) / 64), groups_((words_.size() + 63) / 64)
    {
    }
    bool empty() const noexcept { return !any_; }
    void insert(std::uint32_t tile) noexcept
    {
        words_[tile / 64] |= std::uint64_t{1} << (tile % 64);
        groups_[tile / 4096] |= std::uint64_t{1} << (tile / 64 % 64);
        any_ = true;
    }
    /// Inserts the tiles first..last-1.
    void insert(std::uint32_t first, std::uint32_t last) noexcept
    {
        while (first < last) {
            if (first % 64 != 0 || last - first < 64) {
                insert(first++);
                continue;
            }
            words_[first / 64] = ~std::uint64_t{0};
            groups_[first / 4096] |= std::uint64_t{1} << (first / 64 % 64);
            any_ = true;
            first += 64;
        }
    }
    /// Moves all of `other`, a set of the same grid, into this one.
    void take(TileSet& other) noexcept
    {
        if (other.empty()) return;
        for (std::size_t g = 0; g < groups_.size(); ++g) {
            auto bits = other.groups_[g];
            if (bits == 0) continue;
            groups_[g] |= bits;
            other.groups_[g] = 0;
            for (; bits != 0; bits &= bits - 1) {
                auto const i = g * 64 + static_cast<std::size_t>(std::countr_zero(bits));
                words_[i] |= other.words_[i];
                other.words_[i] = 0;
            }
        }
        other.any_ = false;
        any_ = true;
    }
    void clear() noexcept
    {
        if (empty()) return;
        for (std::size_t g = 0; g < groups_.size(); ++g) {
            for (auto bits = groups_[g]; bits != 0; bits &= bits - 1)
                words_[g * 64 + static_cast<std::size_t>(std::countr_zero(bits))] = 0;
            groups_[g] = 0;
        }
        any_ = false;
    }
    /// Writes the tiles in order to `out`, which has room for all, empties the set, and returns their number.
    std::uint32_t list(std::uint32_t* out) noexcept
    {
        auto* const begin = out;
        for (std::size_t g = 0; g < groups_.size(); ++g) {
            for (auto bits = groups_[g]; bits != 0; bits &= bits - 1) {
                auto const i = g * 64 + static_cast<std::size_t>(std::countr_zero(bits));
                for (auto tiles = words_[i]; tiles != 0; tiles &= tiles - 1)
                    *out++ = static_cast<std::uint32_t>(i * 64) + static_cast<std::uint32_t>(std::countr_zero(tiles));
                words_[i] = 0;
            }
            groups_[g] = 0;
        }
        any_ = false;
        return static_cast<std::uint32_t>(out - begin);
    }

private:
    std::vector<std::uint64_t> words_, groups_;
    bool any_ = false;
};

}}} // namespace tilemesh::engine::detail
