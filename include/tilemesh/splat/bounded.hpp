#pragma once
#include <tilemesh/splat/blending.hpp>
#include <tilemesh/splat/bound.hpp>
#include <tilemesh/splat/fitted.hpp>
#include <tilemesh/splat/frame_program.hpp>
#include <tilemesh/splat/setup_types.hpp>

/// A frame whose alpha plane is a bound: each channel of the picture is within it of the exact formula (bound.hpp). It is a setup with
/// policies of its own, so the library's other programs have no byte and no instruction of it: `BasicRenderer<splat::Bounded>`.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat {

/// A splat with its error. Its rectangle is where the exact formula may light a pixel, so the mesh brings it to all these tiles; the
/// picture's own rectangle is beside it. The mean serves the exact order.
struct BoundedSplat : Splat {
    AlphaError error{};
    std::uint32_t own_columns = 0, own_rows = 0;
    float mean_world[3] = {};

    BoundedSplat() = default;
    explicit BoundedSplat(Splat const& s) noexcept : Splat(s), own_columns(s.columns), own_rows(s.rows) {}
    /// The splat of the picture.
    Splat own() const noexcept
    {
        Splat s = *this;
        s.columns = own_columns, s.rows = own_rows;
        return s;
    }
};
struct BoundParameters : FrameParameters {};

template <>
struct Access<BoundParameters> : Access<FrameParameters> {
    TILEMESH_KERNEL static BoundParameters const& hold(BoundParameters const& frame) noexcept { return frame; }
    template <class Record>
    static BoundedSplat project(Record const& g, BoundParameters const& frame) noexcept
    {
        auto const& view = frame.view;
        Splat const s = splat::project<Pinhole>(g, view, frame.tiling);
        BoundedSplat out(s);
        out.error = alpha_error(g, s, view, view.rules.arithmetic == Arithmetic::fast);
        for (int k = 0; k < 3; ++k) out.mean_world[k] = g.mean_world[k];
        out.columns = out.error.columns, out.rows = out.error.rows;
        if (out.columns == 0) return BoundedSplat();
        if (!s.visible()) { // only the exact formula may have it
            float const at_x = 0.5f * static_cast<float>((out.columns & 0xffffu) + (out.columns >> 16)),
                        at_y = 0.5f * static_cast<float>((out.rows & 0xffffu) + (out.rows >> 16));
            std::uint32_t const x = detail::pixel_within(at_x, out.columns) / frame.tiling.tile_width,
                                y = detail::pixel_within(at_y, out.rows) / frame.tiling.tile_height;
            out.anchor = TileId{x | y << 16};
            std::uint32_t const key = splat::depth_key(g, view);
            out.depth_key = key != 0 ? key : key_of_depth(view.camera.near_depth);
            if (key == 0) out.error.most = 1; // so its place is not known
        }
        return out;
    }
};

namespace detail {
/// The sign of depth(a) - depth(b), by six products of floats without rounding; 2 if products are too small to be exact.
inline int depth_order(Camera const& c, float const (&a)[3], float const (&b)[3]) noexcept
{
    constexpr float half = 4097.0f, least = 0x1p-100f; // 2^12 + 1: halves of 12 bits (Veltkamp 1968)
    float part[16] = {};
    int n = 0;
    auto const add = [&](float v) noexcept { // components that do not overlap, of increasing size (Shewchuk 1997)
        int kept = 0;
        for (int i = 0; i < n; ++i) {
            float const sum = part[i] + v, low = rest_of_sum<float>(part[i], v, sum);
            if (low != 0) part[kept++] = low;
            v = sum;
        }
        if (v != 0) part[kept++] = v;
        n = kept;
    };
    for (int k = 0; k < 3; ++k) {
        float const w = c.rotation[2][k], w1 = half * w - (half * w - w), w2 = w - w1;
        for (int from = 0; from < 2; ++from) {
            float const m = from == 0 ? a[k] : -b[k], p = w * m;
            if (p != 0 ? !(std::fabs(p) > least && std::fabs(p) < 1e30f && std::fabs(m) < 1e30f) : m != 0 && w != 0) return 2;
            float const m1 = half * m - (half * m - m), m2 = m - m1;
            add(((w1 * m1 - p) + w1 * m2 + w2 * m1) + w2 * m2);
            add(p);
        }
    }
    return n == 0 ? 0 : part[n - 1] > 0 ? 1 : -1;
}

/// Says which splats of a list may stand in another order. Depths of close keys are compared exactly. A run of such keys that is not in the exact
/// order is one run for the bound.
///
/// Keys are close if they are at most 16 steps apart. A step is at least 2^-28 of the depth. Before its rounding to a step, a key's depth is
/// off by at most 2^-32 of the sum of the magnitudes |w d| (depth_key.hpp), and that sum is at most 64 depths (`alpha_error`). So a key is off
/// by at most 4.5 steps, and two of them by 9.
template <class SplatAt>
class Runs {
public:
    Runs(SplatAt const& at, Camera const& camera, std::uint32_t n) noexcept : at_(at), camera_(camera), n_(n) {}
    InRun operator()(std::uint32_t i) noexcept // i rises by 1
    {
        if (i >= end_) {
            bool wrong = false;
            begin_ = i, end_ = i + 1;
            for (; end_ < n_; ++end_) {
                SortKey const &p = at_.keys[end_ - 1], &q = at_.keys[end_];
                if (q.depth_key - p.depth_key > close_keys) break;
                BoundedSplat const &a = at_.splats[p.slot], &b = at_.splats[q.slot];
                int const sign = depth_order(camera_, a.mean_world, b.mean_world);
                wrong = wrong || sign > 0 || (sign == 0 && b_is_before(q, p)) || a.error.has_wild_depth() || b.error.has_wild_depth();
            }
            run_ = wrong && end_ - begin_ > 1;
        }
        return {run_ && i == begin_, run_ && i != begin_};
    }

private:
    static constexpr std::uint32_t close_keys = 16;
    static bool b_is_before(SortKey const& b, SortKey const& a) noexcept { return b.id < a.id; }
    SplatAt const& at_;
    Camera const& camera_;
    std::uint32_t n_, begin_ = 0, end_ = 0;
    bool run_ = false;
};

/// A chunk of a tile's list (blending_hits.hpp), where the splats' rectangles are those in which the exact formula may light a pixel, and their
/// ellipses those of the cut within its error.
template <std::uint32_t Size>
struct BoundedChunk : Chunk<Size> {
    BoundedSplat const* splats[Size];
    InRun runs[Size];
    float most_colour[Size];
    bool certain[Size]; ///< `bound_certain_pixels` may be asked
    bool has_runs;

    template <class Set, class SplatAt>
    std::uint32_t fill_with(Set const& set, std::uint32_t begin, std::uint32_t n, SplatAt const& at, Runs<SplatAt>& in_run) noexcept
    {
        std::uint32_t const most = fill(set, static_cast<Chunk<Size>&>(*this), begin, n, [&](std::uint32_t i) noexcept {
            BoundedSplat const& s = at.splats[at.keys[i].slot];
            Splat wider = s;
            wider.faintest = s.error.is_wild() ? -std::numeric_limits<float>::infinity() : s.faintest - 1.1f * s.error.at_cut;
            return wider;
        });
        has_runs = false;
        for (std::uint32_t i = 0; i < most; ++i) {
            BoundedSplat const& s = *(splats[i] = &at.splats[at.keys[begin + i].slot]);
            runs[i] = in_run(begin + i);
            bool const alone = !runs[i].first && !runs[i].later;
            has_runs = has_runs || !alone;
            float const green_blue = s.colour[1] > s.colour[2] ? s.colour[1] : s.colour[2];
            most_colour[i] = s.colour[0] > green_blue ? s.colour[0] : green_blue;
            certain[i] = alone && !s.error.is_wild() && s.error.border_certain != 0 && s.columns == s.own_columns && s.rows == s.own_rows &&
                         s.colour[0] >= 0 && s.colour[1] >= 0 && s.colour[2] >= 0;
        }
        return most;
    }
    /// Adds the splats that begin a run to the hits of a block: it must know them wherever they are.
    std::uint32_t add_runs(std::uint32_t* hits, std::uint32_t count, std::uint32_t most) const noexcept
    {
        std::uint32_t all[Size], n = 0, next = 0;
        for (std::uint32_t i = 0; i < most; ++i)
            if (next < count && (hits[next] & Hit::number) == i) all[n++] = hits[next++];
            else if (runs[i].first) all[n++] = i;
        std::memcpy(hits, all, n * sizeof *hits);
        return n;
    }
};
/// Adds a splat of a chunk to N pixels of a row, whatever is in doubt. It is called, so that the loop around it has all registers.
template <bool Drops, std::uint32_t N>
struct BoundAny {
    template <class Set, std::uint32_t Size>
    TILEMESH_KERNEL static void run(BoundRow& row, std::uint32_t column, BoundedChunk<Size> const& c, std::uint32_t k, Floats<N> const& dx, float dy,
                                    Rules const& m, std::uint32_t x, std::uint32_t y, Words<N>& seen) noexcept
    {
        BoundedSplat const& s = *c.splats[k];
        bound_pixels<N, Drops>(row, column, s.own(), s.error, dx, dy, m, x, y, c.runs[k], seen);
    }
};
/// Blends splats into a block, and adds them to its bound, row by row. Returns the number of pairs that contributed.
template <class Stop>
struct BlendAndBound {
    template <class Set, std::uint32_t Size>
    TILEMESH_KERNEL static std::uint32_t run(BoundRow* rows, BoundedChunk<Size> const& c, std::uint32_t const* hits, std::uint32_t n,
                                             BlockPlace const& at, Rules const& m) noexcept
    {
        constexpr std::uint32_t N = Set::most_lanes < block_width ? Set::most_lanes : block_width;
        alignas(vector_bytes) float opacities[blended_between_looks][N];
        std::uint32_t listed[blended_between_looks + 2];
        Words<N> seen{};
        for (std::uint32_t column = 0; column < block_width; column += N) {
            Words<N> const columns = counted_lanes<N>() + (at.column + static_cast<std::int32_t>(column));
            for (std::uint32_t h = 0; h < n; ++h) put<N>(opacities[h], opacity_of<N>(c, hits[h] & Hit::number, columns));
            for (std::uint32_t r = 0; r < block_height; ++r) {
                std::uint32_t const y = static_cast<std::uint32_t>(at.row) + r, count = in_row(c, hits, n, static_cast<std::int32_t>(y), listed);
                blend_row<Set, N>(rows[r], column, c, hits, &opacities[0][0], listed, count, at, r, m, seen);
            }
        }
        std::uint32_t all = 0;
        for (std::uint32_t i = 0; i < N; ++i) all += static_cast<std::uint32_t>(seen[i]);
        return all;
    }

private:
    /// Lists the hits that have a row, or begin a run, and two numbers more.
    template <std::uint32_t Size>
    static std::uint32_t in_row(BoundedChunk<Size> const& c, std::uint32_t const* hits, std::uint32_t n, std::int32_t y, std::uint32_t* to) noexcept
    {
        std::uint32_t count = 0;
        for (std::uint32_t h = 0; h < n; ++h) { // no branch: a predictor cannot know the splats
            std::uint32_t const k = hits[h] & Hit::number;
            to[count] = h;
            count += ((y >= c.y0[k] ? 1u : 0u) & (y < c.y1[k] ? 1u : 0u)) | (c.runs[k].first ? 1u : 0u);
        }
        to[count] = to[count + 1] = 0;
        return count;
    }
    template <std::uint32_t N>
    TILEMESH_KERNEL static Floats<N> power_in_row(Splat const& s, Floats<N> const& xs, float y) noexcept
    {
        return power_at<N>(s, Floats<N>(xs - s.mean_px[0]), y - s.mean_px[1]);
    }
    template <class Set, std::uint32_t N, std::uint32_t Size>
    TILEMESH_KERNEL static void blend_row(BoundRow& row, std::uint32_t column, BoundedChunk<Size> const& c, std::uint32_t const* hits,
                                          float const* opacities, std::uint32_t const* listed, std::uint32_t n, BlockPlace const& at,
                                          std::uint32_t r, Rules const& m, Words<N>& seen) noexcept
    {
        constexpr bool drops = Stop::drops_crossing;
        float const lowest = lowest_power_for(m.alpha_min), y = at.ys[r];
        Floats<N> const xs = load<N>(at.xs + column);
        BoundPixels<N> pixels(row, column);
        auto const listed_splat = [&](std::uint32_t h) noexcept -> BoundedSplat const& { return *c.splats[hits[listed[h]] & Hit::number]; };
        // Three splats are in progress, each in another stage (cell_wide.hpp).
        BoundedAlpha<N> next(listed_splat(0).error, power_in_row<N>(listed_splat(0), xs, y), load<N>(opacities + N * listed[0]), m, lowest);
        Floats<N> power = power_in_row<N>(listed_splat(1), xs, y);
        for (std::uint32_t h = 0; h < n; ++h) {
            std::uint32_t const k = hits[listed[h]] & Hit::number;
            BoundedSplat const& s = *c.splats[k];
            BoundedAlpha<N> const of = next;
            next = BoundedAlpha<N>(listed_splat(h + 1).error, power, load<N>(opacities + N * listed[h + 1]), m, lowest);
            power = power_in_row<N>(listed_splat(h + 2), xs, y);
            float const near_cut = (1.2f * s.error.at_cut + 4 * 0x1p-24f) * m.alpha_min;
            if (c.certain[k] && bound_certain_pixels<N, drops>(pixels, s, s.error, of, c.most_colour[k], near_cut, m, seen)) continue;
            pixels.store_in(row, column);
            Set::template call<BoundAny<drops, N>>(row, column, c, k, Floats<N>(xs - s.mean_px[0]), y - s.mean_px[1], m,
                                                   static_cast<std::uint32_t>(at.column), static_cast<std::uint32_t>(at.row) + r, seen);
            pixels = BoundPixels<N>(row, column);
        }
        pixels.store_in(row, column);
    }
};

/// Blends the picture of `precise` and its bound into those blocks of a tile that are a worker's (blend_tile_in_blocks), `most_open` at a time. A
/// block looks whether it is done after 64 splats of its own, so its pairs depend neither on `Size` nor on `most_open`.
template <class Stop, std::uint32_t N, std::uint32_t Size, std::uint32_t most_open, class SplatAt, class Pixel>
void blend_and_bound(PixelRect const& tile, Camera const& camera, Rules const& rules, std::uint32_t n, SplatAt const& at, Pixel* pixels,
                     std::uint32_t stride_px, Worker worker, PairCount* counts, std::uint32_t workers) noexcept
{
    struct Open {
        BlockPlace at;
        BoundRow rows[block_height];
        std::uint32_t number, blended;
        bool done;
    };
    if (tile.empty()) return;
    SetOf<N> const set{};
    Open group[most_open];
    BoundedChunk<Size> chunk;
    std::uint32_t hits[Size + SetOf<N>::most_lanes];
    std::uint32_t const left = tile.x0 / block_width * block_width, across = (tile.x1 - left + block_width - 1) / block_width;
    std::uint32_t const top = tile.y0 / block_height * block_height, blocks = across * ((tile.y1 - top + block_height - 1) / block_height);
    for (std::uint32_t next = worker.index; next < blocks;) {
        std::uint32_t open = 0;
        for (; open < most_open && next < blocks; ++open, next += worker.count) {
            Open& block = group[open];
            block.at = place_of(left + next % across * block_width, top + next / across * block_height, camera);
            auto const x = static_cast<std::uint32_t>(block.at.column), y = static_cast<std::uint32_t>(block.at.row);
            std::uint32_t const x0 = x > tile.x0 ? 0 : tile.x0 - x, x1 = x < tile.x1 ? tile.x1 - x : 0;
            for (std::uint32_t r = 0; r < block_height; ++r) block.rows[r].begin(rules, x0, y + r >= tile.y0 && y + r < tile.y1 ? x1 : 0);
            block.number = next, block.blended = 0, block.done = false;
        }
        Runs<SplatAt> runs(at, camera, n);
        std::uint32_t going = open;
        for (std::uint32_t begin = 0; begin < n && going != 0; begin += Size) {
            std::uint32_t const most = chunk.fill_with(set, begin, n, at, runs);
            for (std::uint32_t b = 0; b < open; ++b) {
                Open& block = group[b];
                if (block.done) continue;
                std::uint32_t count = set.template call<ListHits>(static_cast<Chunk<Size> const&>(chunk), most, block.at, &hits[0]);
                if (chunk.has_runs) count = chunk.add_runs(hits, count, most);
                auto& pairs = counts[block.number % workers];
                for (std::uint32_t done = 0; done < count;) {
                    if (block.blended >= blended_between_looks && !chunk.runs[hits[done] & Hit::number].later) {
                        block.blended = 0;
                        block.done = true;
                        for (auto const& row : block.rows) block.done = block.done && row.is_done(rules.transmittance_min);
                        if (block.done) break;
                    }
                    std::uint32_t const room = block.blended < blended_between_looks ? blended_between_looks - block.blended : 1;
                    std::uint32_t const part = count - done < room ? count - done : room;
                    pairs.contributing += set.template call<BlendAndBound<Stop>>(&block.rows[0], chunk, hits + done, part, block.at, rules);
                    pairs.evaluated += part * (block_width * block_height / pairs_a_count);
                    done += part, block.blended += part;
                }
                if (block.done) --going;
            }
        }
        for (std::uint32_t b = 0; b < open; ++b) {
            auto const x = static_cast<std::uint32_t>(group[b].at.column), y = static_cast<std::uint32_t>(group[b].at.row);
            std::uint32_t const x0 = x > tile.x0 ? x : tile.x0, x1 = x + block_width < tile.x1 ? x + block_width : tile.x1;
            std::uint32_t const y0 = y > tile.y0 ? y : tile.y0, y1 = y + block_height < tile.y1 ? y + block_height : tile.y1;
            for (std::uint32_t at_y = y0; at_y < y1; ++at_y) {
                BoundRow const& row = group[b].rows[at_y - y];
                Pixel* const to = pixels + (at_y - tile.y0) * stride_px;
                for (std::uint32_t at_x = x0; at_x < x1; ++at_x) {
                    Pixel& pixel = to[at_x - tile.x0];
                    pixel = Pixel::make(row.blended(at_x - x, rules.background));
                    pixel.alpha = row.bound(at_x - x);
                }
            }
        }
    }
}
} // namespace detail

/// Blends the picture of `precise`, and writes the bound in the place of alpha. With `fast`, the bound is also that of the picture of `fast`.
struct BlendBounded {
    /// A worker has little memory: one block, and chunks of 16 splats.
    template <class Frame, class SplatAt, class Pixel>
    static PairCount tile(PixelRect const& tile, Frame const& frame, std::uint32_t n, SplatAt const& at, Pixel* pixels, std::uint32_t stride_px,
                          Worker worker) noexcept
    {
        PairCount pairs{};
        by_stop<detail::native_lanes, 16, 1>(tile, frame, n, at, pixels, stride_px, worker, &pairs, 1u);
        return pairs;
    }
    template <class Frame, class SplatAt, class Pixel>
    static void whole(PixelRect const& tile, Frame const& frame, std::uint32_t n, SplatAt const& at, Pixel* pixels, std::uint32_t stride_px,
                      PairCount* counts, std::uint32_t workers) noexcept
    {
        by_stop<detail::lanes_in_use, 128, 8>(tile, frame, n, at, pixels, stride_px, Worker{0, 1}, counts, workers);
    }

private:
    template <std::uint32_t Lanes, std::uint32_t Size, std::uint32_t Open, class Frame, class... Arguments>
    static void by_stop(PixelRect const& tile, Frame const& frame, Arguments const&... rest) noexcept
    {
        auto const& view = frame.view;
        if (view.rules.stop == Stop::before_crossing)
            detail::blend_and_bound<detail::StopBeforeCrossing, Lanes, Size, Open>(tile, view.camera, view.rules, rest...);
        else
            detail::blend_and_bound<detail::StopEachPixel, Lanes, Size, Open>(tile, view.camera, view.rules, rest...);
    }
};

namespace detail {
constexpr Setup make_bounded() noexcept
{
    Setup s = make_lossless();
    s.name = "bounded";
    s.alpha = true;
    s.sizes.storage = 1400; // 52 bytes more a slot than `lossless`, and 4 a pixel
    return s;
}
} // namespace detail
inline constexpr Setup bounded = detail::make_bounded();
/// With harmonics up to `Degree`. Harmonics that a map does not have are zero.
template <std::uint32_t Degree>
struct BoundedOf : SetupType<bounded> {
    using Machine = Mk2;
    using Record = GaussianOfDegree<Degree>;
    static constexpr Sizes sizes = detail::sizes_with<BoundedSplat>(bounded, Degree);
    using Projected = BoundedSplat;
    using Parameters = BoundParameters;
    using Blending = BlendBounded;
};
using Bounded = BoundedOf<0>;

}}} // namespace tilemesh::v0_2::splat
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
