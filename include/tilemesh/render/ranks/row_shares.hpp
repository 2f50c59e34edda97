#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// The rows of a map, of which each process of an engine has a share: process p has the rows first(p)..last(p)-1. Shares follow one another
/// in the order of the processes. One process has all rows.
class RowShares {
public:
    RowShares() = default;
    /// One process.
    explicit RowShares(std::uint64_t rows) : begin_{0, rows} {}
    /// Equal shares: they differ by at most one row.
    RowShares(std::uint64_t rows, std::uint32_t processes, std::uint32_t own) : begin_(std::size_t{processes} + 1), own_(own)
    {
        for (std::size_t p = 0; p <= processes; ++p) begin_[p] = part_of(rows, p, processes);
    }
    /// Shares of any size, of which this process has `rows` rows. Every process calls it.
    template <class M>
    static RowShares of_parts(M& mesh, std::uint64_t rows)
    {
        RowShares shares(mesh.rank(), {});
        mesh.together([&] { shares.begin_.assign(std::size_t{mesh.ranks()} + 1, 0); });
        for (std::size_t p = shares.own_ + std::size_t{1}; p < shares.begin_.size(); ++p) shares.begin_[p] = rows;
        mesh.sum(shares.begin_.data(), shares.begin_.size());
        return shares;
    }

    /// The rows of all processes, the first row of this one, and the row behind its last.
    std::uint64_t rows() const noexcept { return begin_.back(); }
    std::uint32_t first() const noexcept { return static_cast<std::uint32_t>(begin_[own_]); }
    std::uint64_t last() const noexcept { return begin_[own_ + std::size_t{1}]; }
    std::uint64_t first(std::uint32_t process) const noexcept { return begin_[process]; }
    std::uint64_t last(std::uint32_t process) const noexcept { return begin_[process + std::size_t{1}]; }
    bool is_own(std::uint32_t row) const noexcept { return row >= begin_[own_] && row < begin_[own_ + std::size_t{1}]; }
    /// The process that has a row.
    std::uint32_t process_of(std::uint64_t row) const noexcept
    {
        return static_cast<std::uint32_t>(std::upper_bound(begin_.begin(), begin_.end(), row) - begin_.begin()) - 1;
    }
    /// The first row of part `p` of equal parts.
    static std::uint64_t part_of(std::uint64_t rows, std::uint64_t p, std::uint64_t parts) noexcept
    {
        return rows / parts * p + rows % parts * p / parts;
    }

private:
    RowShares(std::uint32_t own, std::vector<std::uint64_t>&& begin) noexcept : begin_(std::move(begin)), own_(own) {}

    std::vector<std::uint64_t> begin_{0, 0}; ///< the first row of each process; last, the number of all
    std::uint32_t own_ = 0;
};

/// Gets items from the processes that have them. `wanted` are rows in ascending order; `item_of(row)` makes the item of a row of this process.
/// Returns the items of the wanted rows. Every process calls it. Memory: twice the items that this process gets or sends.
template <class Item, class M, class ItemOf>
std::vector<Item> fetch_rows(M& mesh, RowShares const& shares, std::vector<std::uint32_t> wanted, ItemOf const& item_of)
{
    std::vector<std::uint64_t> counts;
    mesh.together([&] {
        counts.assign(mesh.ranks(), 0);
        for (auto const row : wanted) ++counts[shares.process_of(row)];
    });
    auto const asked = mesh.deal(std::move(wanted), counts);
    std::vector<Item> items;
    mesh.together([&] {
        items.reserve(asked.size());
        for (auto const row : asked) items.push_back(item_of(row));
    });
    return mesh.deal(std::move(items), counts);
}

}}} // namespace tilemesh::render
