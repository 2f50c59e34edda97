#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/render/host_form.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/homes/regions.hpp>
#include <tilemesh/splat/projection.hpp>
#include <tilemesh/splat/view.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// The records of a map and their homes: which rows are on the mesh, in even shares of all tiles, and which come later, in chapters.
///
/// A map with more records than homes comes in chapters, the nearest records in front of the camera first. A chapter has the next keys
/// (depth, id) in order, as many as there are homes, so no later chapter has a record in front of one of an earlier chapter.
///
/// `P`: policies of splat/homes. `Host`: that of the mesh (render/host.hpp).
template <class P, class Host>
class HomesRecords {
public:
    using Records = typename Host::Records;
    static constexpr bool by_reference = std::is_same_v<typename P::Record, splat::Reference>;

    HomesRecords(scene::Map map, std::uint32_t degree) : table_(std::move(map), degree) {}

    Records& table() noexcept { return table_; }
    Records const& table() const noexcept { return table_; }
    /// The rows that are on their homes, tile by tile.
    std::vector<std::uint32_t> const& on_homes() const noexcept { return rows_; }

    /// Deals the rows to the tiles of a grid, one by one, in the order of the tiles. Neighbours in a map are often neighbours in the scene;
    /// dealt, they load no tile more than others. If the map does not come in chapters, all rows go to their homes.
    void begin(Host& host, Grid grid, bool chapters)
    {
        host.template reorder<typename P::Record>(table_, [&](std::uint32_t row) {
            return static_cast<std::uint32_t>(first_of(table_.all_rows(), row % grid.size(), grid) + row / grid.size());
        });
        if (chapters) return;
        host.step([&] {
            rows_.resize(table_.rows());
            for (std::uint32_t row = 0; row < table_.rows(); ++row) rows_[row] = row;
        });
        load(host);
    }

    /// The keys of the records in front of the camera: those of this process, and the number of all.
    struct Chapters {
        std::vector<std::uint64_t> keys;
        std::uint64_t all = 0;
    };
    Chapters chapters_of(Host& host, splat::View const& view)
    {
        auto const n = table_.rows();
        host.step([&] { depths_.resize(n); });
        host.on_threads(n, [&](std::uint32_t first, std::uint32_t last) {
            for (auto row = first; row < last; ++row) depths_[row] = splat::depth_key(table_.gaussians()[row], view);
        });
        Chapters chapters;
        host.step([&] {
            chapters.keys.reserve(n);
            for (std::uint32_t row = 0; row < n; ++row)
                if (depths_[row] != 0) chapters.keys.push_back(key(row));
        });
        struct Keys {
            std::uint64_t count;
        };
        chapters.all = host.template total<Keys>([&](Keys& all) { all.count = chapters.keys.size(); }).count;
        return chapters;
    }
    /// Puts the records number `done` to `done + n` onto their homes. Returns their keys, and the first key behind them.
    typename Host::KeyRange load_chapter(Host& host, Chapters& chapters, std::uint64_t done, std::uint64_t n)
    {
        auto const keys = host.range_of(chapters.keys, done, n);
        host.step([&] {
            rows_.clear();
            for (std::uint32_t row = 0; row < table_.rows(); ++row) // in the order of rows, so that homes do not depend on the standard library
                if (depths_[row] != 0 && key(row) >= keys.from && key(row) < keys.to) rows_.push_back(row);
        });
        load(host);
        return keys;
    }

private:
    std::uint64_t key(std::uint32_t row) const noexcept { return std::uint64_t{depths_[row]} << 32 | static_cast<std::uint32_t>(table_.id(row)); }
    /// The first record of a tile's share, if n records are shared out among all tiles in even shares.
    static std::uint64_t first_of(std::uint64_t n, std::uint32_t tile, Grid grid) noexcept
    {
        return n / grid.size() * tile + std::min<std::uint64_t>(tile, n % grid.size());
    }
    void load(Host& host)
    {
        auto& mesh = host.mesh();
        auto const grid = mesh.grid();
        host.template deal<typename P::Record>(
            rows_.size(), [&](std::uint64_t n, std::uint32_t tile) { return first_of(n, tile, grid); },
            [&](std::uint32_t i) {
                if constexpr (by_reference)
                    return splat::Reference{table_.id(rows_[i]), i};
                else
                    return table_.template record<typename P::Record>(rows_[i]);
            },
            [&](TileId tile, std::uint64_t n, auto const& next) {
                auto home = mesh.template state<splat::homes::Home<P>>(tile);
                auto seen = mesh.template state<splat::homes::Seen<P>>(tile);
                auto offers = mesh.template state<splat::homes::Offers>(tile);
                home.truncate(0), seen.truncate(0), offers.truncate(0);
                auto const index = grid.index_of(tile);
                for (auto i = first_of(n, index + 1, grid) - first_of(n, index, grid); i > 0; --i) {
                    home.push(next());
                    seen.push({});
                    offers.push({});
                }
            });
    }

    Records table_;
    std::vector<std::uint32_t> rows_;
    std::vector<std::uint32_t> depths_; ///< keys, by rows; 0 if the record is not in front of the camera
};

}}} // namespace tilemesh::render
