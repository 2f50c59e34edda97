#include "direct.hpp"
#include "statistics.hpp"
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <span>
#include <tilemesh/splat/project_all.hpp>
#include <utility>

namespace bench {

namespace {

/// The paper's tile at 1280 x 720.
constexpr std::uint32_t tile_width = 32, tile_height = 20;
/// The number of records projected at a time. Their splats (14 KiB) are still in the first cache when the keys are made.
constexpr std::uint32_t batch = 256;
/// Bits of one radix pass: 2,048 counters are 8 KiB.
constexpr std::uint32_t digit_bits = 11;

/// The beginning of a thread's part of n items.
std::uint32_t part(std::size_t n, std::uint32_t thread, std::uint32_t threads)
{
    return static_cast<std::uint32_t>(n * thread / threads);
}

} // namespace

splat::PairCount blend_as_the_machine(splat::PixelRect const& tile, splat::View const& view, std::uint32_t n,
                                      splat::Splat const* splats, std::uint32_t const* rows, splat::FloatPixel* pixels,
                                      std::uint32_t stride_px) noexcept
{
    splat::PairCount count{};
    splat::blend_whole_tile(
        tile, view.camera, view.rules, n, [=](std::uint32_t i) noexcept -> splat::Splat const& { return splats[rows[i]]; },
        pixels, stride_px, &count, 1);
    return count;
}

Direct::Direct(std::span<splat::Gaussian const> gaussians)
    : gaussians_(gaussians.begin(), gaussians.end()), splats_(gaussians.size()), ranges_(gaussians.size())
{
    std::sort(gaussians_.begin(), gaussians_.end(), [](auto const& a, auto const& b) { return a.id < b.id; });
}

void Direct::render(splat::Camera const& camera, splat::Rules const& rules, Team& team, BlendTile blend_tile)
{
    Stopwatch frame, stage;
    auto const view = splat::make_view(camera, rules);
    auto const threads = team.size();
    width_ = camera.width;
    height_ = camera.height;
    tiling_ = splat::make_tiling(width_, height_, tile_width, tile_height);
    auto const tiles = tiling_.columns * tiling_.rows;
    pixels_.resize(std::size_t{width_} * height_);
    begin_.resize(tiles + 1);
    shares_.resize(threads);

    team.run([&](std::uint32_t t) { project(t, threads, view); });
    stages_.project = stage.lap();

    team.run([&](std::uint32_t t) { sort(shares_[t]); });
    visible_ = 0;
    for (auto const& s : shares_) visible_ += static_cast<std::uint32_t>(s.keys.size());
    sorted_.resize(visible_);
    ordered_.resize(visible_);
    if (threads <= 2) team.run([&](std::uint32_t t) { merge(t, threads); });
    else merge(0, threads);
    stages_.sort = stage.lap();

    team.run([&](std::uint32_t t) { count(t, threads); });
    place();
    team.run([&](std::uint32_t t) { fill(t, threads); });
    stages_.bin = stage.lap();

    tilemesh::engine::detail::Shares tiles_left(threads); // a thread has the same tiles in each frame, as long as it has some left
    tiles_left.set(tiles);
    team.run([&](std::uint32_t t) { blend(t, view, blend_tile, tiles_left); });
    stages_.blend = stage.lap();

    pairs_ = contributing_ = 0;
    for (auto const& s : shares_) {
        pairs_ += s.evaluated * splat::pairs_a_count;
        contributing_ += s.contributing;
    }
    stages_.total = frame.lap();
}

void Direct::project(std::uint32_t thread, std::uint32_t threads, splat::View const& view)
{
    auto& keys = shares_[thread].keys;
    auto const begin = part(gaussians_.size(), thread, threads), end = part(gaussians_.size(), thread + 1, threads);
    keys.resize(end - begin);
    std::uint32_t n = 0;
    for (auto first = begin; first < end; first += batch) {
        auto const last = std::min(first + batch, end);
        splat::project_all(gaussians_.data() + first, last - first, view, tiling_, splats_.data() + first);
        for (auto row = first; row < last; ++row) { // without a branch: the key of an invisible splat is overwritten
            keys[n] = {splats_[row].depth_key, row};
            n += splats_[row].visible() ? 1 : 0;
        }
    }
    keys.resize(n);
    for (auto const& key : keys) {
        auto const r = splats_[key.row].rect();
        ranges_[key.row] = {static_cast<std::uint16_t>(r.x0 / tile_width),
                            static_cast<std::uint16_t>((r.x1 - 1) / tile_width),
                            static_cast<std::uint16_t>(r.y0 / tile_height),
                            static_cast<std::uint16_t>((r.y1 - 1) / tile_height)};
    }
}

/// Radix sort by those bits of the depth in which the keys differ. It is stable: equal depths keep the order of their ids.
void Direct::sort(Share& share)
{
    auto& keys = share.keys;
    if (keys.empty()) return;
    auto low = keys.front().depth, high = low;
    for (auto const& k : keys) low = std::min(low, k.depth), high = std::max(high, k.depth);
    auto const bits = static_cast<std::uint32_t>(std::bit_width(high - low));
    auto const passes = (bits + digit_bits - 1) / digit_bits;
    if (passes == 0) return;
    auto const digit = (bits + passes - 1) / passes;
    auto const mask = (1u << digit) - 1;
    std::array<std::array<std::uint32_t, 1u << digit_bits>, (32 + digit_bits - 1) / digit_bits> counts;
    for (std::uint32_t p = 0; p < passes; ++p) std::fill_n(counts[p].begin(), mask + 1, 0u);
    for (auto const& k : keys)
        for (std::uint32_t p = 0; p < passes; ++p) ++counts[p][((k.depth - low) >> (p * digit)) & mask];
    share.other.resize(keys.size());
    for (std::uint32_t p = 0; p < passes; ++p) {
        std::uint32_t sum = 0;
        for (std::uint32_t d = 0; d <= mask; ++d) sum += std::exchange(counts[p][d], sum);
        for (auto const& k : keys) share.other[counts[p][((k.depth - low) >> (p * digit)) & mask]++] = k;
        keys.swap(share.other);
    }
}

/// Merges the threads' keys. Of equal depths, the keys of the lower thread come first, because its ids are lower. Two threads write one
/// half of the result each; bisection finds where a half begins in either input (merge path: Odeh et al. 2012).
void Direct::merge(std::uint32_t thread, std::uint32_t threads)
{
    auto const nearer = [](Key const& a, Key const& b) { return a.depth < b.depth; };
    if (threads == 1) {
        sorted_.swap(shares_[0].keys);
    } else if (threads == 2) {
        auto const &a = shares_[0].keys, &b = shares_[1].keys;
        auto const taken_of_a = [&](std::uint32_t of) { // how many of the first `of` results are a's
            auto low = of > b.size() ? of - static_cast<std::uint32_t>(b.size()) : 0u;
            auto high = std::min(of, static_cast<std::uint32_t>(a.size()));
            while (low < high) {
                auto const middle = (low + high) / 2;
                if (nearer(b[of - middle - 1], a[middle])) high = middle;
                else low = middle + 1;
            }
            return low;
        };
        auto const begin = part(visible_, thread, 2), end = part(visible_, thread + 1, 2);
        auto i = taken_of_a(begin), j = begin - i;
        auto const i_end = taken_of_a(end), j_end = end - i_end;
        auto* out = sorted_.data() + begin;
        while (i < i_end && j < j_end) { // without a branch: which key comes next cannot be predicted
            bool const second = nearer(b[j], a[i]);
            *out++ = second ? b[j] : a[i];
            j += second ? 1 : 0;
            i += second ? 0 : 1;
        }
        while (i < i_end) *out++ = a[i++];
        while (j < j_end) *out++ = b[j++];
    } else { // merges one thread's keys after the other: with many threads a machine has other limits
        std::vector<Key> merged = std::move(shares_[0].keys), both;
        for (std::uint32_t t = 1; t < threads; ++t) {
            both.resize(merged.size() + shares_[t].keys.size());
            std::merge(merged.begin(), merged.end(), shares_[t].keys.begin(), shares_[t].keys.end(), both.begin(), nearer);
            merged.swap(both);
        }
        sorted_ = std::move(merged);
    }
}

/// The entries per tile of this thread's part of the sorted splats: four corners per splat, then sums along both axes.
void Direct::count(std::uint32_t thread, std::uint32_t threads)
{
    auto& share = shares_[thread];
    auto const columns = tiling_.columns, rows = tiling_.rows;
    auto const stride = columns + 1; // splats that begin after the last tile are not counted
    share.count.assign(std::size_t{stride} * (rows + 1), 0);
    auto* const c = share.count.data();
    for (auto i = part(visible_, thread, threads), end = part(visible_, thread + 1, threads); i < end; ++i) {
        auto const r = ordered_[i] = ranges_[sorted_[i].row];
        ++c[r.y0 * stride + r.x0];
        --c[r.y0 * stride + r.x1 + 1];
        --c[(r.y1 + 1) * stride + r.x0];
        ++c[(r.y1 + 1) * stride + r.x1 + 1];
    }
    for (std::uint32_t y = 0; y < rows; ++y) {
        std::int32_t along = 0;
        for (std::uint32_t x = 0; x < columns; ++x) {
            along += c[y * stride + x];
            c[y * stride + x] = along + (y > 0 ? c[(y - 1) * stride + x] : 0);
        }
    }
}

/// The beginning of each tile's list, and of each thread's entries in it. A lower thread has nearer splats.
void Direct::place()
{
    auto const columns = tiling_.columns, stride = columns + 1;
    for (auto& s : shares_) s.next.resize(begin_.size());
    std::uint32_t at = 0, tile = 0;
    for (std::uint32_t y = 0; y < tiling_.rows; ++y)
        for (std::uint32_t x = 0; x < columns; ++x, ++tile) {
            begin_[tile] = at;
            for (auto& s : shares_) {
                s.next[tile] = at;
                at += static_cast<std::uint32_t>(s.count[y * stride + x]);
            }
        }
    begin_[tile] = at;
    list_.resize(at);
}

void Direct::fill(std::uint32_t thread, std::uint32_t threads)
{
    auto* const next = shares_[thread].next.data();
    auto* const list = list_.data();
    auto const columns = tiling_.columns;
    for (auto i = part(visible_, thread, threads), end = part(visible_, thread + 1, threads); i < end; ++i) {
        auto const row = sorted_[i].row;
        auto const r = ordered_[i];
        std::uint32_t const across = r.x1 - r.x0, down = r.y1 - r.y0;
        auto const first = r.y0 * columns + r.x0;
        if ((across | down) <= 1) {
            // Most splats touch 1, 2 or 4 tiles, which a branch predictor cannot predict. So there are four stores without a branch. A
            // store for a tile that repeats another one does not advance; the last store always advances, and overwrites it.
            auto const store = [&](std::uint32_t tile, std::uint32_t advance) {
                auto& at = next[tile];
                list[at] = row;
                at += advance;
            };
            store(first + down * columns + across, across & down);
            store(first + down * columns, down);
            store(first + across, across);
            store(first, 1);
            continue;
        }
        for (std::uint32_t y = 0; y <= down; ++y)
            for (auto tile = first + y * columns, last = tile + across; tile <= last; ++tile) list[next[tile]++] = row;
    }
}

void Direct::blend(std::uint32_t thread, splat::View const& view, BlendTile blend_tile, tilemesh::engine::detail::Shares& tiles_left)
{
    auto& share = shares_[thread];
    share.evaluated = share.contributing = 0;
    for (std::uint32_t first, last; tiles_left.take(thread, first, last);)
        for (auto tile = first; tile < last; ++tile) {
            auto const at = tilemesh::TileId::at(tile % tiling_.columns, tile / tiling_.columns);
            auto const rect = splat::pixels_of(tiling_, view.camera, at);
            auto const count =
                blend_tile(rect, view, begin_[tile + 1] - begin_[tile], splats_.data(), list_.data() + begin_[tile],
                           pixels_.data() + std::size_t{rect.y0} * width_ + rect.x0, width_);
            share.evaluated += count.evaluated;
            share.contributing += count.contributing;
        }
}

bool Direct::equals(tilemesh::report::Image const& image) const noexcept
{
    static_assert(sizeof(splat::FloatPixel) == 3 * sizeof(float));
    return image.width == width_ && image.height == height_ && !pixels_.empty() &&
           std::memcmp(image.rgb.data(), pixels_.data(), pixels_.size() * sizeof(splat::FloatPixel)) == 0;
}

tilemesh::report::Image Direct::image() const
{
    tilemesh::report::Image image(width_, height_);
    std::memcpy(image.rgb.data(), pixels_.data(), pixels_.size() * sizeof(splat::FloatPixel));
    return image;
}

std::uint64_t Direct::bytes() const noexcept
{
    auto const of = [](auto const& v) { return std::uint64_t{v.capacity()} * sizeof v[0]; };
    auto sum =
        of(gaussians_) + of(splats_) + of(ranges_) + of(ordered_) + of(sorted_) + of(list_) + of(begin_) + of(pixels_);
    for (auto const& s : shares_) sum += of(s.keys) + of(s.other) + of(s.count) + of(s.next);
    return sum;
}

} // namespace bench
