#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// Numbers by 64-bit keys: fill it, sort it once, then look numbers up. It is one type for all tables of the host, because each type of
/// hash table would cost every program that renders a fifth of a second of compile time.
class SortedTable {
public:
    void add(std::uint64_t key, std::uint32_t value) { rows_.emplace_back(key, value); }
    /// Call this before the first look-up. Returns false if a key is there twice.
    bool sort()
    {
        std::sort(rows_.begin(), rows_.end());
        for (std::size_t i = 1; i < rows_.size(); ++i)
            if (rows_[i - 1].first == rows_[i].first) return false;
        return true;
    }
    /// The number of a key; the least of several. Null if the key is not there.
    std::uint32_t const* find(std::uint64_t key) const noexcept
    {
        std::size_t first = 0, last = rows_.size();
        while (first < last) {
            auto const middle = first + (last - first) / 2;
            if (rows_[middle].first < key)
                first = middle + 1;
            else
                last = middle;
        }
        return first < rows_.size() && rows_[first].first == key ? &rows_[first].second : nullptr;
    }
    bool has(std::uint64_t key) const noexcept { return find(key) != nullptr; }
    void reserve(std::size_t rows) { rows_.reserve(rows); }

private:
    std::vector<std::pair<std::uint64_t, std::uint32_t>> rows_;
};

}}} // namespace tilemesh::render
