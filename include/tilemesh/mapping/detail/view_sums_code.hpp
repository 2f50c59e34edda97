#pragma once
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/mapping/detail/parallel.hpp>
#include <tilemesh/mapping/view_sums.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/footprint.hpp>
#include <tilemesh/splat/map/insert.hpp>

namespace tilemesh { inline namespace v0_2 { namespace mapping {

namespace detail {
inline std::string by(std::uint32_t width, std::uint32_t height)
{
    return std::to_string(width) + " x " + std::to_string(height);
}
/// Throws `Error` for a camera that no frame can be rendered with, and for a target of another size than the camera's.
inline void expect_target(Target const& target, splat::Camera const& camera)
{
    scene::check_camera(camera);
    scene::check_no_panorama(camera, "a derivative");
    scene::check_no_shutter(camera, "a derivative by the map");
    if (target.width != camera.width || target.height != camera.height || target.pixels.size() != std::size_t{camera.width} * camera.height)
        throw Error("a target of " + by(target.width, target.height) + " pixels is no picture of this camera (it has " +
                    by(camera.width, camera.height) + "); give pictures of the camera's size");
}
} // namespace detail

inline Target make_target(report::Image const& colour, report::Plane const& depth)
{
    if (!depth.empty() && (depth.width != colour.width || depth.height != colour.height))
        throw Error("the depths of a target cannot have " + detail::by(depth.width, depth.height) + " pixels (its picture has " +
                    detail::by(colour.width, colour.height) + "); give pictures of one size");
    Target t{colour.width, colour.height, std::vector<splat::TargetPixel>(std::size_t{colour.width} * colour.height)};
    for (std::size_t i = 0; i < t.pixels.size(); ++i)
        t.pixels[i] = {{colour.rgb[3 * i], colour.rgb[3 * i + 1], colour.rgb[3 * i + 2]}, depth.empty() ? 0.0f : depth.values[i]};
    return t;
}

inline double Fit::psnr_db() const noexcept
{
    return -10.0 * std::log10(squares / (3.0 * static_cast<double>(pixels)));
}

/// What a thread works in.
struct ViewSums::Workspace {
    splat::map::WalkMemory<8, 128> memory;
};

inline ViewSums::ViewSums(ViewOptions const& options) : options_(options)
{
    if (!splat::map::has_whole_blocks(options.tile))
        throw Error("tiles cannot have " + detail::by(options.tile.tile_width, options.tile.tile_height) +
                    " pixels (sums are rounded by blocks of " + detail::by(splat::block_width, splat::block_height) +
                    "); take multiples of these");
    if (options.threads == 0) throw Error("no thread cannot add up a view (threads is 0); take 1 or more");
    auto const& l = options.loss;
    for (float const weight : {l.colour, l.depth, l.huber_colour, l.huber_depth})
        if (!(weight >= 0 && weight <= 1e6f))
            throw Error("a weight or width of the loss is " + std::to_string(weight) + " (it is from 0 to 1e6); change it");
    if (!(l.limit >= 1e-3f && l.limit <= 1e6f))
        throw Error("the limit of slopes is " + std::to_string(l.limit) + " (it is from 0.001 to 1e6); change it");
}
inline ViewSums::~ViewSums() = default;
inline ViewSums::ViewSums(ViewSums&&) noexcept = default;
inline ViewSums& ViewSums::operator=(ViewSums&&) noexcept = default;

inline Fit ViewSums::measure(std::span<splat::Splat const> splats, std::span<splat::Gaussian const> records, splat::View const& view,
                             Target const& target, Seen* seen)
{
    return run(splats, records, view, target, false, seen);
}
inline Fit ViewSums::add_up(std::span<splat::Splat const> splats, std::span<splat::Gaussian const> records, splat::View const& view,
                            Target const& target)
{
    return run(splats, records, view, target, true, nullptr);
}

/// Sorts by a radix of 11 bits. Depths are positive, so their bits order as they do; bits that all keys share are skipped.
inline void ViewSums::sort(std::span<splat::Splat const> splats, std::span<splat::Gaussian const> records)
{
    keys_.clear(), rows_.clear();
    std::uint64_t all = ~std::uint64_t{0}, any = 0;
    for (std::size_t i = 0; i < splats.size(); ++i) {
        if (!splats[i].visible()) continue;
        auto const depth = std::uint64_t{splats[i].depth_key};
        auto const key = depth << 32 | static_cast<std::uint32_t>(records[i].id);
        keys_.push_back(key), rows_.push_back(static_cast<std::uint32_t>(i));
        all &= key, any |= key;
    }
    other_keys_.resize(keys_.size()), other_rows_.resize(rows_.size());
    constexpr unsigned bits = 11;
    for (unsigned shift = 0; shift < 64; shift += bits) {
        constexpr std::uint64_t digit = (1u << bits) - 1;
        if (((any ^ all) >> shift & digit) == 0) continue;
        std::vector<std::uint32_t> count(digit + 2, 0);
        for (auto const key : keys_) ++count[(key >> shift & digit) + 1];
        for (std::size_t d = 1; d < count.size(); ++d) count[d] += count[d - 1];
        for (std::size_t i = 0; i < keys_.size(); ++i) {
            auto const to = count[keys_[i] >> shift & digit]++;
            other_keys_[to] = keys_[i], other_rows_[to] = rows_[i];
        }
        keys_.swap(other_keys_), rows_.swap(other_rows_);
    }
    sorted_.resize(rows_.size());
    for (std::size_t i = 0; i < rows_.size(); ++i) sorted_[i] = splats[rows_[i]];
}
/// Lists the splats of each tile, front to back.
inline void ViewSums::bin(splat::Tiling const& tiling)
{
    std::size_t const tiles = std::size_t{tiling.columns} * tiling.rows;
    begin_.assign(tiles + 1, 0);
    auto const each = [&](auto const& f) {
        for (std::uint32_t i = 0; i < sorted_.size(); ++i) {
            auto const box = splat::tiles_of(sorted_[i], tiling);
            for (std::uint32_t y = box.first.y(); y <= box.last.y(); ++y)
                for (std::uint32_t x = box.first.x(); x <= box.last.x(); ++x) f(std::size_t{y} * tiling.columns + x, i);
        }
    };
    each([&](std::size_t tile, std::uint32_t) { ++begin_[tile + 1]; });
    for (std::size_t t = 0; t < tiles; ++t) begin_[t + 1] += begin_[t];
    listed_.resize(begin_[tiles]);
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    each([&](std::size_t tile, std::uint32_t i) { listed_[next[tile]++] = i; });
}

inline void ViewSums::show(splat::map::BlendedBlock const& block, float const (&background)[3], Seen& to) noexcept
{
    for (std::uint32_t y = block.live.y0; y < block.live.y1; ++y)
        for (std::uint32_t x = block.live.x0; x < block.live.x1; ++x) {
            auto const p = splat::map::shown(splat::map::pixel_of(block, x, y), background);
            std::copy_n(p.rgb, 3, to.colour.pixel(x, y));
            to.depth.at(x, y) = p.depth;
            to.cover.at(x, y) = p.cover;
        }
}

inline Fit ViewSums::run(std::span<splat::Splat const> splats, std::span<splat::Gaussian const> records, splat::View const& view,
                         Target const& target, bool with_sums,
                         Seen* seen)
{
    auto const& camera = view.camera;
    detail::expect_target(target, camera);
    auto const tiling = splat::make_tiling(camera.width, camera.height, options_.tile.tile_width, options_.tile.tile_height);
    sort(splats, records);
    bin(tiling);
    if (with_sums) sums_.assign(splats.size(), {});
    std::uint32_t const across = (camera.width + splat::block_width - 1) / splat::block_width,
        down = (camera.height + splat::block_height - 1) / splat::block_height;
    losses_.assign(std::size_t{across} * down, {});
    if (seen != nullptr)
        *seen = {report::Image(camera.width, camera.height), report::Plane(camera.width, camera.height),
                 report::Plane(camera.width, camera.height)};
    while (workspaces_.size() < options_.threads) workspaces_.push_back(std::make_unique<Workspace>());

    std::atomic<std::uint32_t> arrived{0};
    std::size_t const tiles = std::size_t{tiling.columns} * tiling.rows;
    std::atomic<std::size_t> next{0};
    splat::map::WalkRules const rules{view.rules, options_.loss};
    auto const work = [&](std::size_t) noexcept {
        auto& memory = workspaces_[arrived++]->memory;
        for (std::size_t t = next++; t < tiles; t = next++) {
            auto const tile = splat::pixels_of(tiling, camera, TileId::at(static_cast<std::uint32_t>(t % tiling.columns),
                                                                          static_cast<std::uint32_t>(t / tiling.columns)));
            auto const* const list = listed_.data() + begin_[t];
            splat::map::walk_whole_tile(
                memory, tile, camera, rules, begin_[t + 1] - begin_[t],
                [&](std::uint32_t i) noexcept -> splat::Splat const& { return sorted_[list[i]]; },
                target.pixels.data() + std::size_t{tile.y0} * camera.width + tile.x0, camera.width,
                [&](auto const& block, splat::map::BlockLoss const& loss) noexcept {
                    auto const row = static_cast<std::size_t>(block.at.row) / splat::block_height;
                    losses_[row * across + static_cast<std::size_t>(block.at.column) / splat::block_width] = loss;
                    if (seen != nullptr) show(block, view.rules.background, *seen);
                    return with_sums;
                },
                [&](std::uint32_t i, splat::map::SplatSums const& s) noexcept {
                    auto& to = sums_[rows_[list[i]]];
                    for (std::uint32_t k = 0; k < splat::map::sums; ++k) __atomic_fetch_add(&to.of[k], s.of[k],
                        __ATOMIC_RELAXED); // any order: integers
                });
        }
    };
    detail::in_parallel(options_.threads, options_.threads, work);

    Fit fit;
    for (auto const& loss : losses_) fit.loss += double{loss.loss}, fit.squares += double{loss.squares}, fit.pixels += loss.pixels;
    return fit;
}

}}} // namespace tilemesh::mapping
