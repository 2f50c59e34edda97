#pragma once
#include <tilemesh/splat/blending.hpp>
#include <tilemesh/splat/exact_splat.hpp>
#include <tilemesh/splat/fitted.hpp>
#include <tilemesh/splat/frame_program.hpp>
#include <tilemesh/splat/setup_types.hpp>

/// A frame of exact rays (exact_splat.hpp), through a pinhole or any lens: `BasicRenderer<splat::Exact>`. It is a setup with policies of its own, so
/// the library's other programs have no byte and no instruction of it. It has the order, the cut-offs and the stop of `Rules`; both
/// arithmetics are the same, and it has no footprint but the exact one. A pixel without a ray is background.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat {

struct ExactParameters : LensParameters {
    static constexpr bool exact_rays = true;
};

template <>
struct Access<ExactParameters> : Access<LensParameters> {
    TILEMESH_KERNEL static ExactParameters const& hold(ExactParameters const& frame) noexcept { return frame; }
    static ExactSplat project(Gaussian const& g, ExactParameters const& frame) noexcept { return project_exact(g, frame.view, frame.tiling); }
    template <std::uint32_t Degree>
    static ExactSplat project(ShadedGaussian<Degree> const& g, ExactParameters const& frame) noexcept
    {
        ExactSplat s = project_exact(g, frame.view, frame.tiling);
        if (!s.visible() || shade(g, frame.view, s)) return s;
        return {};
    }
};

namespace detail {
/// A block of pixels with their rays, row by row. The transmittance of a pixel outside the tile, without a ray or stopped is negative.
struct alignas(vector_bytes) ExactBlock {
    float t[block_height][block_width], colour[3][block_height][block_width], weight[block_height][block_width], depth[block_height][block_width];
    float ray[3][block_height][block_width];
};
/// Sets the rays, and the transmittances of pixels in the columns [x0, x1) and rows [y0, y1) of the block that see something.
struct BeginExact {
    template <class Set>
    TILEMESH_KERNEL static void run(ExactBlock& block, Camera const& c, std::int32_t column, std::int32_t row, std::int32_t x0, std::int32_t x1,
                                    std::int32_t y0, std::int32_t y1) noexcept
    {
        constexpr std::uint32_t N = Set::most_lanes < block_width ? Set::most_lanes : block_width;
        using A = FloatLanes<N>;
        Floats<N> const zero{};
        for (std::uint32_t r = 0; r < block_height; ++r)
            for (std::uint32_t i = 0; i < block_width; i += N) {
                std::int32_t const y = static_cast<std::int32_t>(r);
                Words<N> const x = counted_lanes<N>() + static_cast<std::int32_t>(i);
                Floats<N> const u = (A::real(x + column) + 0.5f - c.cx) / c.fx;
                LensRay<A> const seen(c, u, broadcast<N>((static_cast<float>(row + y) + 0.5f - c.cy) / c.fy));
                Words<N> const live = seen.seen & (x >= x0) & (x < x1) & broadcast_word<N>(y >= y0 && y < y1 ? -1 : 0);
                store(block.t[r] + i, A::select(live, broadcast<N>(1.0f), broadcast<N>(-1.0f)));
                store(block.ray[0][r] + i, seen.ray.x), store(block.ray[1][r] + i, seen.ray.y), store(block.ray[2][r] + i, seen.ray.z);
                for (auto& channel : block.colour) store(channel[r] + i, zero);
                store(block.weight[r] + i, zero), store(block.depth[r] + i, zero);
            }
    }
};
/// A splat in a block: its pixels there are the columns [x0, x1) and rows [y0, y1).
struct ExactHit {
    ExactSplat const* splat;
    std::int32_t x0, x1, y0, y1;
};
/// Blends splats into a block, one after the other. Returns the number of pairs that contributed.
struct BlendExactHits {
    template <class Set>
    TILEMESH_KERNEL static std::uint32_t run(ExactBlock& block, ExactHit const* hits, std::uint32_t n, Rules const& m) noexcept
    {
        constexpr std::uint32_t N = Set::most_lanes < block_width ? Set::most_lanes : block_width;
        using A = FloatLanes<N>;
        float const lowest = lowest_power_for(m.alpha_min);
        bool const drops = m.stop == Stop::before_crossing;
        Words<N> contributing{};
        for (std::uint32_t h = 0; h < n; ++h) {
            ExactHit const& hit = hits[h];
            ExactSplat const& s = *hit.splat;
            float const view_depth = s.Splat::depth();
            for (std::uint32_t i = 0; i < block_width; i += N) {
                auto const begin = static_cast<std::int32_t>(i);
                if (hit.x1 <= begin || hit.x0 >= begin + static_cast<std::int32_t>(N)) continue;
                Words<N> const x = counted_lanes<N>() + begin;
                Words<N> const columns = (x >= hit.x0) & (x < hit.x1);
                for (auto r = static_cast<std::uint32_t>(hit.y0); r < static_cast<std::uint32_t>(hit.y1); ++r) {
                    Floats<N> const dx = load<N>(block.ray[0][r] + i) - s.towards[0], dy = load<N>(block.ray[1][r] + i) - s.towards[1];
                    Floats<N> const dz = load<N>(block.ray[2][r] + i) - s.towards[2];
                    Floats<N> const first = along<N>(s.first, dx, dy, dz), second = along<N>(s.second, dx, dy, dz);
                    Floats<N> const depth = along<N>(s.depth, dx, dy, dz) + 1.0f, q = multiply_add_lanes<N>(first, first, second * second);
                    Floats<N> const all = multiply_add_lanes<N>(depth, depth, s.spread * q);
                    // Below the power `faintest`, which is .01 below that of alpha_min, alpha is too faint: no quotient, no exponential.
                    Words<N> const open = columns & (depth > 0.0f) & (load<N>(block.t[r] + i) >= m.transmittance_min) & ~(q > -s.faintest * all);
                    if (any_lane<N>(open) == 0) continue;
                    Floats<N> const power = -q / all;
                    Floats<N> const raw = s.opacity * exponential_lanes<N>(power, lowest);
                    Floats<N> const alpha = A::select(raw < m.alpha_max, raw, broadcast<N>(m.alpha_max));
                    Floats<N> t = load<N>(block.t[r] + i);
                    Words<N> takes_part = open & (alpha >= m.alpha_min);
                    if (drops) {
                        Words<N> const crosses = takes_part & (t - alpha * t < m.transmittance_min);
                        t = A::select(crosses, -t, t);
                        takes_part &= ~crosses;
                    }
                    Floats<N> const share = A::select(takes_part, alpha * t, Floats<N>{});
                    for (std::uint32_t k = 0; k < 3; ++k) {
                        float* const to = block.colour[k][r] + i;
                        store(to, multiply_add_lanes<N>(share, broadcast<N>(s.colour[k]), load<N>(to)));
                    }
                    store(block.t[r] + i, t - share);
                    store(block.weight[r] + i, load<N>(block.weight[r] + i) + share);
                    store(block.depth[r] + i, multiply_add_lanes<N>(share, broadcast<N>(view_depth), load<N>(block.depth[r] + i)));
                    contributing -= takes_part; // all bits set are -1
                }
            }
        }
        std::uint32_t all = 0;
        for (std::uint32_t i = 0; i < N; ++i) all += static_cast<std::uint32_t>(contributing[i]);
        return all;
    }

private:
    template <std::uint32_t N>
    TILEMESH_KERNEL static Floats<N> along(float const (&w)[3], Floats<N> const& x, Floats<N> const& y, Floats<N> const& z) noexcept
    {
        return multiply_add_lanes<N>(broadcast<N>(w[0]), x, multiply_add_lanes<N>(broadcast<N>(w[1]), y, w[2] * z));
    }
};

/// Blends those blocks of a tile that are a worker's (blend_tile_in_blocks). A block looks whether it is done after 64 splats of its own.
template <std::uint32_t N, class SplatAt, class Pixel>
void blend_exactly(PixelRect const& tile, View const& view, std::uint32_t n, SplatAt const& at, Pixel* pixels, std::uint32_t stride_px, Worker worker,
                   PairCount* counts, std::uint32_t workers) noexcept
{
    if (tile.empty()) return;
    SetOf<N> const set{};
    Rules const& m = view.rules;
    ExactBlock block;
    ExactHit hits[blended_between_looks];
    std::uint32_t const left = tile.x0 / block_width * block_width, across = (tile.x1 - left + block_width - 1) / block_width;
    std::uint32_t const top = tile.y0 / block_height * block_height, blocks = across * ((tile.y1 - top + block_height - 1) / block_height);
    auto const within = [](std::uint32_t pixel, std::int32_t first, std::uint32_t size) noexcept { // a border of the block, in it
        std::int32_t const at_pixel = static_cast<std::int32_t>(pixel) - first, most = static_cast<std::int32_t>(size);
        return at_pixel < 0 ? 0 : at_pixel < most ? at_pixel : most;
    };
    for (std::uint32_t number = worker.index; number < blocks; number += worker.count) {
        auto const column = static_cast<std::int32_t>(left + number % across * block_width);
        auto const row = static_cast<std::int32_t>(top + number / across * block_height);
        std::int32_t const x0 = within(tile.x0, column, block_width), x1 = within(tile.x1, column, block_width);
        std::int32_t const y0 = within(tile.y0, row, block_height), y1 = within(tile.y1, row, block_height);
        set.template call<BeginExact>(block, view.camera, column, row, x0, x1, y0, y1);
        auto& pairs = counts[number % workers];
        std::uint32_t count = 0;
        bool done = false;
        auto const blend = [&]() noexcept {
            pairs.contributing += set.template call<BlendExactHits>(block, &hits[0], count, m);
            count = 0, done = true;
            for (auto const& t : block.t)
                for (float const left_of_pixel : t) done = done && !(left_of_pixel >= m.transmittance_min);
        };
        for (std::uint32_t i = 0; i < n && !done; ++i) {
            ExactSplat const& s = at.splats[at.keys[i].slot];
            PixelRect const rect = s.rect();
            ExactHit const hit{&s, within(rect.x0, column, block_width), within(rect.x1, column, block_width), within(rect.y0, row, block_height),
                               within(rect.y1, row, block_height)};
            if (hit.x0 >= hit.x1 || hit.y0 >= hit.y1) continue;
            hits[count++] = hit;
            pairs.evaluated += static_cast<std::uint32_t>(hit.y1 - hit.y0) * (block_width / pairs_a_count);
            if (count == blended_between_looks) blend();
        }
        if (count != 0) blend();
        for (std::int32_t y = y0; y < y1; ++y)
            for (std::int32_t x = x0; x < x1; ++x) {
                float const t = std::fabs(block.t[y][x]);
                Blended b{{}, t, block.weight[y][x], block.depth[y][x]};
                for (int k = 0; k < 3; ++k) b.rgb[k] = multiply_add(t, m.background[k], block.colour[k][y][x]);
                pixels[(static_cast<std::uint32_t>(row + y) - tile.y0) * stride_px + (static_cast<std::uint32_t>(column + x) - tile.x0)] =
                    Pixel::make(b);
            }
    }
}
} // namespace detail

struct BlendExactly {
    template <class Frame, class SplatAt, class Pixel>
    static PairCount tile(PixelRect const& tile, Frame const& frame, std::uint32_t n, SplatAt const& at, Pixel* pixels, std::uint32_t stride_px,
                          Worker worker) noexcept
    {
        PairCount pairs{};
        detail::blend_exactly<detail::native_lanes>(tile, frame.view, n, at, pixels, stride_px, worker, &pairs, 1u);
        return pairs;
    }
    template <class Frame, class SplatAt, class Pixel>
    static void whole(PixelRect const& tile, Frame const& frame, std::uint32_t n, SplatAt const& at, Pixel* pixels, std::uint32_t stride_px,
                      PairCount* counts, std::uint32_t workers) noexcept
    {
        detail::blend_exactly<detail::lanes_in_use>(tile, frame.view, n, at, pixels, stride_px, Worker{0, 1}, counts, workers);
    }
};

namespace detail {
constexpr Setup make_exact() noexcept
{
    Setup s = make_lossless();
    s.name = "exact";
    s.depth = s.alpha = true;
    s.sizes.storage = 1380; // 52 bytes more a slot than `lossless`, and 8 a pixel
    return s;
}
} // namespace detail
inline constexpr Setup exact_setup = detail::make_exact();

/// With harmonics up to `Degree`. Harmonics that a map does not have are zero.
template <std::uint32_t Degree>
struct ExactOf : SetupType<exact_setup> {
    using Machine = Mk2;
    using Record = GaussianOfDegree<Degree>;
    static constexpr Sizes sizes = detail::sizes_with<ExactSplat>(exact_setup, Degree);
    using Projected = ExactSplat;
    using Parameters = ExactParameters;
    using Blending = BlendExactly;
};
using Exact = ExactOf<0>;

}}} // namespace tilemesh::v0_2::splat
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
