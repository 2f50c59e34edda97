#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <tilemesh/render/project_records.hpp>
#include <tilemesh/render/ranks/row_shares.hpp>
#include <tilemesh/splat/footprint.hpp>
#include <tilemesh/splat/projection.hpp>
#include <tilemesh/splat/view.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// The work of each row of a grid's tiles in a view: 1 for each tile with pixels, and 1 for each tile that a splat touches. An engine over
/// several processes cuts the grid into bands of equal work. Weights change the bands, but no result.
///
/// A tile stores, projects, sorts and blends each splat that touches it, so the number of these splats stands for its work. Blending that
/// stops early, and the size of a footprint within a tile, are not counted.
class RowWeights {
public:
    /// `height`: the rows of the grid; rows without pixels have no work.
    RowWeights(splat::Tiling const& tiling, std::uint32_t height) : tiling_(tiling), work_(height) {}

    /// Adds the tiles with pixels. Of several processes, one does it.
    void add_tiles() noexcept
    {
        for (std::size_t y = 0; y < std::min<std::size_t>(tiling_.rows, work_.size()); ++y) work_[y] += tiling_.columns;
    }
    /// Adds the tiles that a splat touches. A splat with nothing on screen adds nothing.
    void add(splat::Splat const& s) noexcept
    {
        if (!s.visible()) return;
        auto const range = splat::tiles_of(s, tiling_);
        for (auto y = range.first.y(); y <= range.last.y(); ++y) work_[y] += range.last.x() - range.first.x() + 1u;
    }

    /// The work of each row. Several processes add up what they have counted.
    std::vector<std::uint64_t>& work() noexcept { return work_; }

    /// The work in words of 32 bits, smaller by a power of two if it is too large. A row with work keeps at least 1.
    std::vector<std::uint32_t> weights() const
    {
        std::uint64_t most = 0;
        for (auto const w : work_) most = std::max(most, w);
        unsigned shift = 0;
        while (most >> shift > std::numeric_limits<std::uint32_t>::max()) ++shift;
        std::vector<std::uint32_t> weights;
        weights.reserve(work_.size());
        for (auto const w : work_) weights.push_back(static_cast<std::uint32_t>(w == 0 ? 0 : std::max<std::uint64_t>(w >> shift, 1)));
        return weights;
    }

private:
    splat::Tiling tiling_;
    std::vector<std::uint64_t> work_;
};

/// The work of each row of tiles in a view. Each process of a group projects its share of the map. `whole`: `records` are those of the whole
/// map.
template <class Group, class Records>
std::vector<std::uint32_t> weights_of_rows(Group& group, Records const& records, bool whole, std::uint32_t height, splat::View const& view,
                                           splat::Tiling const& tiling)
{
    std::optional<RowWeights> rows;
    group.together([&] {
        rows.emplace(tiling, height);
        if (group.rank() == 0) rows->add_tiles();
        RowShares mine(records.rows());
        if (whole) mine = RowShares(records.rows(), group.ranks(), group.rank());
        constexpr std::uint32_t at_once = 256;
        splat::Splat splats[at_once];
        auto const last = static_cast<std::uint32_t>(mine.last());
        for (auto row = mine.first(); row < last; row += at_once) {
            auto const some = std::min(at_once, last - row);
            project_rows(records, row, some, view, tiling, splats);
            for (std::uint32_t i = 0; i < some; ++i) rows->add(splats[i]);
        }
    });
    group.sum(rows->work().data(), rows->work().size());
    std::vector<std::uint32_t> weights;
    group.together([&] { weights = rows->weights(); });
    return weights;
}

}}} // namespace tilemesh::render
