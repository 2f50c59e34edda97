#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// A table of numbers with 64-bit keys. Fill it, sort it once, then look numbers up. All tables of the host have this one type, because
/// each type of hash table would cost every program that renders 0.2 seconds of compile time.
class SortedTable {
public:
    void add(std::uint64_t key, std::uint32_t value) { rows_.emplace_back(key, value); }
    /// Sorts the table; call it before the first look-up. Returns false if two rows have the same key.
    bool sort()
    {
        std::sort(rows_.begin(), rows_.end());
        for (std::size_t i = 1; i < rows_.size(); ++i)
            if (rows_[i - 1].first == rows_[i].first) return false;
        return true;
    }
    /// The number of a key, or null if the table does not have the key. If several rows have the key, it is the least number.
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
