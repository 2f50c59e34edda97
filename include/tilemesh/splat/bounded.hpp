#pragma once
#include <tilemesh/splat/blending.hpp>
#include <tilemesh/splat/bound.hpp>
#include <tilemesh/splat/fitted.hpp>
#include <tilemesh/splat/frame_program.hpp>
#include <tilemesh/splat/setup_types.hpp>

/// A frame whose alpha plane is a bound: each channel of the picture is within it of the exact formula (bound.hpp). It is a setup with
/// policies of its own, so the library's other programs have no byte and no instruction of it: `BasicRenderer<splat::Bounded>`.
TILEMESH_EXACT_BEGIN
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

/// `fast` differs from `precise` by at most this share of alpha (tests/splat/blending.cpp).
inline constexpr float error_of_fast = 2e-5f;

template <>
struct Access<BoundParameters> : Access<FrameParameters> {
    TILEMESH_KERNEL static BoundParameters const& hold(BoundParameters const& frame) noexcept { return frame; }
    template <class Record>
    static BoundedSplat project(Record const& g, BoundParameters const& frame) noexcept
    {
        auto const& view = frame.view;
        Splat const s = splat::project(g, view, frame.tiling);
        BoundedSplat out(s);
        out.error = alpha_error(g, s, view, view.rules.arithmetic == Arithmetic::fast ? error_of_fast : 0.0f);
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
                wrong = wrong || sign > 0 || (sign == 0 && b_is_before(q, p)) || a.error.is_wild() || b.error.is_wild();
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

/// Writes the bounds of the pixels that a worker blends (blend_tile_in_blocks): every count-th block.
template <class SplatAt, class Pixel>
void bound_blocks(PixelRect const& tile, Camera const& c, Rules const& m, std::uint32_t n, SplatAt const& at, Pixel* pixels, std::uint32_t stride_px,
                  Worker worker) noexcept
{
    if (tile.empty()) return;
    std::uint32_t const left = tile.x0 / block_width * block_width, across = (tile.x1 - left + block_width - 1) / block_width;
    std::uint32_t const top = tile.y0 / block_height * block_height, blocks = across * ((tile.y1 - top + block_height - 1) / block_height);
    for (std::uint32_t number = worker.index; number < blocks; number += worker.count) {
        std::uint32_t const x = left + number % across * block_width, y = top + number / across * block_height;
        BoundRow<block_width> rows[block_height];
        for (auto& row : rows) row.begin(m);
        Runs<SplatAt> runs(at, c, n);
        for (std::uint32_t i = 0, blended = 0; i < n; ++i) {
            InRun const run = runs(i);
            if (blended >= blended_between_looks && !run.later) {
                bool done = true;
                for (auto const& row : rows) done = done && row.is_done(m.transmittance_min);
                if (done) break;
                blended = 0;
            }
            BoundedSplat const& s = at.splats[at.keys[i].slot];
            std::uint32_t const x0 = s.error.columns & 0xffffu, x1 = s.error.columns >> 16, y0 = s.error.rows & 0xffffu, y1 = s.error.rows >> 16;
            bool const here = x0 < x + block_width && x1 > x && y0 < y + block_height && y1 > y;
            if (!here && !run.first) continue;
            ++blended;
            Splat const own = s.own();
            RowsOf const reach(own, s.error);
            for (std::uint32_t r = 0; r < block_height; ++r)
                if (run.first || (y + r >= y0 && y + r < y1)) bound_row<native_lanes>(rows[r], own, s.error, reach, c, m, x, y + r, run);
        }
        for (std::uint32_t r = 0; r < block_height; ++r)
            for (std::uint32_t i = 0; i < block_width; ++i) {
                if (y + r < tile.y0 || y + r >= tile.y1 || x + i < tile.x0 || x + i >= tile.x1) continue;
                pixels[(y + r - tile.y0) * stride_px + (x + i - tile.x0)].alpha = rows[r].bound(i);
            }
    }
}
} // namespace detail

/// Blends the picture of `precise`, and writes the bound in the place of alpha. With `fast`, the bound is also that of the picture of `fast`.
struct BlendBounded {
    template <class At>
    struct OwnAt {
        At const& at;
        Splat operator()(std::uint32_t i) const noexcept { return at.splats[at.keys[i].slot].own(); }
    };
    static Rules precise(Rules rules) noexcept
    {
        rules.arithmetic = Arithmetic::precise;
        return rules;
    }
    template <class Frame, class SplatAt, class Pixel>
    static PairCount tile(PixelRect const& tile, Frame const& frame, std::uint32_t n, SplatAt const& at, Pixel* pixels, std::uint32_t stride_px,
                          Worker worker) noexcept
    {
        PairCount const pairs = blend_tile(tile, frame.view.camera, precise(frame.view.rules), n, OwnAt<SplatAt>{at}, pixels, stride_px, worker);
        detail::bound_blocks(tile, frame.view.camera, frame.view.rules, n, at, pixels, stride_px, worker);
        return pairs;
    }
    template <class Frame, class SplatAt, class Pixel>
    static void whole(PixelRect const& tile, Frame const& frame, std::uint32_t n, SplatAt const& at, Pixel* pixels, std::uint32_t stride_px,
                      PairCount* counts, std::uint32_t workers) noexcept
    {
        blend_whole_tile(tile, frame.view.camera, precise(frame.view.rules), n, OwnAt<SplatAt>{at}, pixels, stride_px, counts, workers);
        detail::bound_blocks(tile, frame.view.camera, frame.view.rules, n, at, pixels, stride_px, Worker{0, 1});
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
namespace detail {
/// Channels keep their bytes, and so does storage with the lists of its slots.
constexpr Sizes bounded_sizes(std::uint32_t degree) noexcept
{
    constexpr std::uint32_t lists = sizeof(Mark) + sizeof(BoundedSplat) + sizeof(SortKey);
    Sizes sizes = fitted(bounded, degree).sizes;
    sizes.storage = bounded.sizes.storage * (record_bytes(0) + lists) / (record_bytes(degree) + lists);
    return sizes;
}
} // namespace detail
/// With harmonics up to `Degree`. Harmonics that a map does not have are zero.
template <std::uint32_t Degree>
struct BoundedOf : SetupType<bounded> {
    using Machine = Mk2;
    using Record = GaussianOfDegree<Degree>;
    static constexpr Sizes sizes = detail::bounded_sizes(Degree);
    using Projected = BoundedSplat;
    using Parameters = BoundParameters;
    using Blending = BlendBounded;
};
using Bounded = BoundedOf<0>;

}}} // namespace tilemesh::v0_2::splat
TILEMESH_EXACT_END
