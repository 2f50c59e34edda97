#pragma once
#include <tilemesh/splat/blending_hits.hpp>
#include <tilemesh/splat/exponential.hpp>
#include <tilemesh/splat/pose/motion.hpp>
#include <utility>

/// Blends splats front to back into a row of pixels, and carries the derivatives by the six motions beside it (forward mode).
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // the functions are always inlined, so it does not matter how a wide vector is passed
namespace tilemesh { inline namespace v0_2 { namespace splat::pose {

/// A pixel (or lanes of pixels) and its derivative by the six motions, front to back.
template <class A>
struct MovingPixel {
    using Real = typename A::Real;
    Real t, colour[3];                       ///< transmittance, the sum of w c
    Real dt[motions], dcolour[3][motions];
    Real z, x, y;                            ///< the sums of w times the means in view space; through a fisheye, of the depth and of the ray's x, y
    Real ahead;                              ///< through a fisheye, of the ray's z
    Real dz[motions];                        ///< the sum of dw times the depth; the means' own motion follows from x, y and t
};
/// The words of a splat that a pair of a splat and a pixel needs, besides its power.
template <class A>
struct MovingPaint {
    typename A::Real colour[3], z, x, y, ahead;
    bool by_angle = false; ///< through a fisheye: `ahead` counts
};

namespace detail {
/// A pair's products of the offsets, for the motions of its power.
template <class A>
struct PairOffsets {
    typename A::Real dx, off, dx_dx, dx_off, off_off;
};
/// Column J of one pair, with the transmittance `t` in front of it. It is a function because a compiler need not inline a lambda.
template <std::uint32_t J, bool Depth, class A>
TILEMESH_KERNEL void blend_column(MovingPixel<A>& p, typename A::Real const& t, typename A::Real const& alpha, typename A::Mask const& moves,
                                  PairOffsets<A> const& at, MovingPaint<A> const& paint, PowerMotion<A> const& m) noexcept
{
    using Real = typename A::Real;
    Real dp = m.dx_1 * at.dx;
    dp = A::multiply_add(m.off_1, at.off, dp);
    dp = A::multiply_add(m.dx_2, at.dx_dx, dp);
    dp = A::multiply_add(m.mixed, at.dx_off, dp);
    dp = A::multiply_add(m.off_2, at.off_off, dp);
    dp = A::select(moves, dp, A::all(0.0f));
    Real const dw = alpha * A::multiply_add(t, dp, p.dt[J]);
    p.dcolour[0][J] = A::multiply_add(dw, paint.colour[0], p.dcolour[0][J]);
    p.dcolour[1][J] = A::multiply_add(dw, paint.colour[1], p.dcolour[1][J]);
    p.dcolour[2][J] = A::multiply_add(dw, paint.colour[2], p.dcolour[2][J]);
    p.dt[J] = p.dt[J] - dw;
    if constexpr (Depth) p.dz[J] = A::multiply_add(dw, paint.z, p.dz[J]);
}
/// The pair itself, with w = alpha T.
template <bool Depth, class A>
TILEMESH_KERNEL void blend_pair(MovingPixel<A>& p, typename A::Real const& w, MovingPaint<A> const& paint) noexcept
{
    p.colour[0] = A::multiply_add(w, paint.colour[0], p.colour[0]);
    p.colour[1] = A::multiply_add(w, paint.colour[1], p.colour[1]);
    p.colour[2] = A::multiply_add(w, paint.colour[2], p.colour[2]);
    if constexpr (Depth) {
        p.z = A::multiply_add(w, paint.z, p.z);
        p.x = A::multiply_add(w, paint.x, p.x);
        p.y = A::multiply_add(w, paint.y, p.y);
        if (paint.by_angle) p.ahead = A::multiply_add(w, paint.ahead, p.ahead);
    }
    p.t = p.t - w;
}
} // namespace detail

/// One pair: C += w c, T -= w with w = alpha T, and dw = alpha (T dP + dT), dC += dw c, dT -= dw. The sets of pairs (cut-offs, stop, depth
/// order) are those of the blending and count as constant. `takes_part`: the lanes that blend. `moves`: those of them in which alpha follows
/// the power; alpha_max clamps the others. It selects alpha and dP and never multiplies by a mask: outside its reach a splat's power may
/// move by infinity. `motion(J)` is the PowerMotion of column J.
template <bool Depth, class A, class MotionOf, std::uint32_t... J>
TILEMESH_KERNEL void blend_moving_pair(MovingPixel<A>& p, typename A::Real const& of_power, typename A::Mask const& takes_part,
                                       typename A::Mask const& moves, typename A::Real const& dx, typename A::Real const& off,
                                       MovingPaint<A> const& paint, MotionOf const& motion,
                                       std::integer_sequence<std::uint32_t, J...>) noexcept
{
    using Real = typename A::Real;
    Real const alpha = A::select(takes_part, of_power, A::all(0.0f)), w = alpha * p.t;
    detail::PairOffsets<A> const at{dx, off, dx * dx, dx * off, off * off};
    (detail::blend_column<J, Depth, A>(p, p.t, alpha, moves, at, paint, motion(std::integral_constant<std::uint32_t, J>{})), ...);
    detail::blend_pair<Depth, A>(p, w, paint);
}

/// The derivative of a pixel's depth D = z / W by motion J, with W = 1 - T: (dz + (0, 0, W, y, -x, 0) + D dT) / W. Through a fisheye (`by_angle`) the
/// second term is (x, y, ahead, 0, 0, 0).
template <std::uint32_t J, class A>
TILEMESH_KERNEL typename A::Real depth_motion(MovingPixel<A> const& p, typename A::Real const& weight, typename A::Real const& depth,
                                              bool by_angle = false) noexcept
{
    typename A::Real sum = A::multiply_add(depth, p.dt[J], p.dz[J]);
    if (by_angle) {
        if constexpr (J == 0) sum = sum + p.x;
        if constexpr (J == 1) sum = sum + p.y;
        if constexpr (J == 2) sum = sum + p.ahead;
        return sum / weight;
    }
    if constexpr (J == 2) sum = sum + weight;
    if constexpr (J == 3) sum = sum + p.y;
    if constexpr (J == 4) sum = sum - p.x;
    return sum / weight;
}

using AllMotions = std::make_integer_sequence<std::uint32_t, motions>;

/// A row of pixels in memory, field by field: T, three colours, dT, three times dC, z, x, y, dz, ahead.
struct MovingRow {
    static constexpr std::uint32_t fields = 4 + 4 * motions + 3 + motions + 1;
    float field[fields][block_width];
};

namespace detail {
/// The fields that do not depend on a motion.
template <class A, class F>
TILEMESH_KERNEL void each_plain_field(MovingPixel<A>& p, bool depth, F const& f) noexcept
{
    f(0, p.t);
    for (std::uint32_t c = 0; c < 3; ++c) f(1 + c, p.colour[c]);
    if (depth) f(28, p.z), f(29, p.x), f(30, p.y), f(37, p.ahead);
}
/// The fields of motion j.
template <class A, class F>
TILEMESH_KERNEL void each_field_of(std::uint32_t j, MovingPixel<A>& p, bool depth, F const& f) noexcept
{
    f(4 + j, p.dt[j]);
    for (std::uint32_t c = 0; c < 3; ++c) f(10 + 6 * c + j, p.dcolour[c][j]);
    if (depth) f(31 + j, p.dz[j]);
}
template <std::uint32_t N>
struct LoadField {
    MovingRow const& row;
    std::uint32_t column;
    TILEMESH_KERNEL void operator()(std::uint32_t i, splat::detail::Floats<N>& v) const noexcept
    {
        v = splat::detail::load<N>(row.field[i] + column);
    }
};
template <std::uint32_t N>
struct StoreField {
    MovingRow& row;
    std::uint32_t column;
    TILEMESH_KERNEL void operator()(std::uint32_t i, splat::detail::Floats<N> const& v) const noexcept
    {
        splat::detail::store(row.field[i] + column, v);
    }
};
/// Loads N columns of a row.
template <std::uint32_t N>
TILEMESH_KERNEL MovingPixel<splat::detail::FloatLanes<N>> load_pixels(MovingRow const& row, std::uint32_t column, bool depth) noexcept
{
    MovingPixel<splat::detail::FloatLanes<N>> p;
    p.z = p.x = p.y = p.ahead = splat::detail::Floats<N>{};
    for (auto& dz : p.dz) dz = splat::detail::Floats<N>{};
    LoadField<N> const load{row, column};
    each_plain_field(p, depth, load);
    for (std::uint32_t j = 0; j < motions; ++j) each_field_of(j, p, depth, load);
    return p;
}

/// A chunk of splats with the motions of their powers: one array per field.
template <std::uint32_t Size>
struct alignas(splat::detail::vector_bytes) MovingChunk : splat::detail::Chunk<Size> {
    static constexpr std::uint32_t coefficients = 5;
    float along_depth[Size], across_depth[Size];
    float depth[Size], view_x[Size], view_y[Size], ahead[Size];   ///< the mean in view space; or the distance and the ray of a fisheye
    bool by_angle;                                                ///< a fisheye
    float motion[motions][coefficients][Size];

    template <std::uint32_t N, Column J>
    TILEMESH_KERNEL void complete_column(std::uint32_t i, MotionBasis<splat::detail::FloatLanes<N>> const& basis) noexcept
    {
        auto const m = power_motion<J>(basis);
        auto& to = motion[static_cast<std::uint32_t>(J)];
        splat::detail::store(to[0] + i, m.dx_1);
        splat::detail::store(to[1] + i, m.off_1);
        splat::detail::store(to[2] + i, m.dx_2);
        splat::detail::store(to[3] + i, m.mixed);
        splat::detail::store(to[4] + i, m.off_2);
    }
    /// Computes the motions of the first n splats, and of those that fill their last lanes.
    template <std::uint32_t N>
    TILEMESH_KERNEL void complete_motions(std::uint32_t n, View const& view) noexcept
    {
        using A = splat::detail::FloatLanes<N>;
        using splat::detail::load;
        by_angle = view.camera.lens.kind == LensKind::fisheye;
        for (std::uint32_t i = 0; i < n; i += N) {
            for (std::uint32_t k = i; k < i + N; ++k) depth[k] = depth_of_key(this->depth_key[k]);
            MovingSplat<A> const s{load<N>(this->mean_x + i), load<N>(this->mean_y + i), load<N>(depth + i),
                                   load<N>(this->along + i),  load<N>(this->slope + i),  load<N>(this->across + i),
                                   load<N>(along_depth + i),  load<N>(across_depth + i)};
            MotionBasis<A> const basis(s, view);
            if (by_angle) {
                splat::detail::store(view_x + i, basis.mean.ray.x), splat::detail::store(view_y + i, basis.mean.ray.y);
                splat::detail::store(ahead + i, basis.mean.ray.z);
            } else {
                splat::detail::store(view_x + i, splat::detail::Floats<N>(basis.sx * s.depth));
                splat::detail::store(view_y + i, splat::detail::Floats<N>(basis.sy * s.depth));
            }
            complete_column<N, Column::rho_x>(i, basis);
            complete_column<N, Column::rho_y>(i, basis);
            complete_column<N, Column::rho_z>(i, basis);
            complete_column<N, Column::phi_x>(i, basis);
            complete_column<N, Column::phi_y>(i, basis);
            complete_column<N, Column::phi_z>(i, basis);
        }
    }
};
struct CompleteMotions {
    template <class Set, std::uint32_t Size>
    TILEMESH_KERNEL static void run(MovingChunk<Size>& chunk, std::uint32_t n, View const& view) noexcept
    {
        chunk.template complete_motions<Set::most_lanes>(n, view);
    }
};

/// The motions of a chunk's splat i.
template <class A, std::uint32_t Size>
struct MotionIn {
    MovingChunk<Size> const& chunk;
    std::uint32_t i;

    template <std::uint32_t J>
    TILEMESH_KERNEL PowerMotion<A> operator()(std::integral_constant<std::uint32_t, J>) const noexcept
    {
        auto const& of = chunk.motion[J];
        return {A::all(of[0][i]), A::all(of[1][i]), A::all(of[2][i]), A::all(of[3][i]), A::all(of[4][i])};
    }
};

/// The pairs of up to 16 splats and N pixels that take part, in order: what the derivatives read of them.
template <std::uint32_t N>
struct MovingPairs {
    static constexpr std::uint32_t most = 16;
    std::uint32_t count;
    std::uint32_t splat[most];
    splat::detail::Floats<N> dx[most], off[most], alpha[most], t[most];
    splat::detail::Words<N> moves[most];
};
/// Blends the pairs into motions J... of a row.
template <bool Depth, std::uint32_t N, std::uint32_t Size, std::uint32_t... J>
TILEMESH_KERNEL void blend_motions(MovingRow& row, std::uint32_t column, MovingChunk<Size> const& c, MovingPairs<N> const& pairs,
                                   std::integer_sequence<std::uint32_t, J...>) noexcept
{
    using namespace splat::detail;
    using A = FloatLanes<N>;
    MovingPixel<A> p; // only the fields of these motions are used
    (each_field_of(J, p, Depth, LoadField<N>{row, column}), ...);
    for (std::uint32_t h = 0; h < pairs.count; ++h) {
        std::uint32_t const i = pairs.splat[h];
        Floats<N> const dx = pairs.dx[h], off = pairs.off[h];
        PairOffsets<A> const at{dx, off, dx * dx, dx * off, off * off};
        MovingPaint<A> const paint{{broadcast<N>(c.red[i]), broadcast<N>(c.green[i]), broadcast<N>(c.blue[i])}, broadcast<N>(c.depth[i]), Floats<N>{},
                                   Floats<N>{}, Floats<N>{}};
        (blend_column<J, Depth, A>(p, pairs.t[h], pairs.alpha[h], pairs.moves[h], at, paint,
                                   MotionIn<A, Size>{c, i}(std::integral_constant<std::uint32_t, J>{})), ...);
    }
    (each_field_of(J, p, Depth, StoreField<N>{row, column}), ...);
}
/// Blends the pairs into all motions, three after three or two after two: their fields, 5 vectors a motion, stay in registers, and those of
/// all six would not. Targets with 16 lanes have 32 registers, the others 16.
template <bool Depth, std::uint32_t N, std::uint32_t Size>
TILEMESH_KERNEL void blend_all_motions(MovingRow& row, std::uint32_t column, MovingChunk<Size> const& c, MovingPairs<N>& pairs) noexcept
{
    if constexpr (N == 16) {
        blend_motions<Depth, N>(row, column, c, pairs, std::integer_sequence<std::uint32_t, 0, 1, 2>{});
        blend_motions<Depth, N>(row, column, c, pairs, std::integer_sequence<std::uint32_t, 3, 4, 5>{});
    } else {
        blend_motions<Depth, N>(row, column, c, pairs, std::integer_sequence<std::uint32_t, 0, 1>{});
        blend_motions<Depth, N>(row, column, c, pairs, std::integer_sequence<std::uint32_t, 2, 3>{});
        blend_motions<Depth, N>(row, column, c, pairs, std::integer_sequence<std::uint32_t, 4, 5>{});
    }
    pairs.count = 0;
}

/// Blends the splats of `hits` that cover row `k` of a block into the row. The alpha of a pair and the set of pairs are those of `precise`
/// blending, bit for bit. Returns the number of pairs that contributed.
template <bool Depth, class Stop>
struct BlendMovingRow {
    template <class Set, std::uint32_t Size>
    TILEMESH_KERNEL static std::uint32_t run(MovingRow& row, MovingChunk<Size> const& c, std::uint32_t const* hits, std::uint32_t n,
                                             splat::detail::BlockPlace const& at, std::uint32_t k, Rules const& m) noexcept
    {
        using namespace splat::detail;
        constexpr std::uint32_t N = Set::most_lanes;
        using A = FloatLanes<N>;
        float const lowest = lowest_power_for(m.alpha_min);
        std::uint32_t contributing = 0;
        for (std::uint32_t column = 0; column < block_width; column += N) {
            if (!A::any(load<N>(row.field[0] + column) >= m.transmittance_min)) continue; // all have stopped
            MovingPixel<A> p; // without its derivatives
            each_plain_field(p, Depth, LoadField<N>{row, column});
            MovingPairs<N> pairs;
            pairs.count = 0;
            Words<N> const columns = counted_lanes<N>() + (at.column + static_cast<std::int32_t>(column));
            Floats<N> const xs = load<N>(at.xs + column);
            Words<N> counted{};
            std::int32_t const first = at.column + static_cast<std::int32_t>(column), end = first + static_cast<std::int32_t>(N);
            for (std::uint32_t h = 0; h < n;) { // the derivatives follow once per so many pairs
                for (; h < n && pairs.count < MovingPairs<N>::most; ++h) {
                    std::uint32_t const i = hits[h] & Hit::number;
                    if (c.x0[i] >= end || c.x1[i] <= first) continue;
                    if (covered_rows.bits[(hits[h] >> Hit::limits_at) * block_height + k] == 0) continue;
                    auto const offset = __builtin_bit_cast(UnsignedWords<N>, Words<N>(columns - c.x0[i]));
                    Words<N> const covered = offset < static_cast<std::uint32_t>(c.x1[i] - c.x0[i]);
                    Floats<N> const dx = xs - c.mean_x[i], dy = broadcast<N>(at.ys[k] - c.mean_y[i]);
                    Floats<N> const off = multiply_add_lanes<N>(broadcast<N>(-c.slope[i]), dx, dy);
                    Floats<N> const power = multiply_add_lanes<N>(c.along[i] * dx, dx, c.across[i] * off * off);
                    Floats<N> alpha = c.opacity[i] * exponential_lanes<N>(power, lowest);
                    Words<N> const follows = ~(alpha > m.alpha_max);
                    alpha = alpha < m.alpha_max ? alpha : broadcast<N>(m.alpha_max);
                    Words<N> takes_part = covered & (alpha >= m.alpha_min) & (p.t >= m.transmittance_min);
                    if constexpr (Stop::drops_crossing) {
                        Words<N> const crosses = takes_part & (p.t - alpha * p.t < m.transmittance_min);
                        p.t = crosses ? -p.t : p.t;
                        takes_part &= ~crosses;
                    }
                    if (!A::any(takes_part)) continue;
                    counted = takes_part ? counted + 1 : counted;
                    MovingPaint<A> paint{{broadcast<N>(c.red[i]), broadcast<N>(c.green[i]), broadcast<N>(c.blue[i])}, Floats<N>{}, Floats<N>{},
                                         Floats<N>{}, Floats<N>{}};
                    if constexpr (Depth) paint.z = broadcast<N>(c.depth[i]), paint.x = broadcast<N>(c.view_x[i]), paint.y = broadcast<N>(c.view_y[i]),
                                         paint.by_angle = c.by_angle;
                    if (paint.by_angle) paint.ahead = broadcast<N>(c.ahead[i]);
                    alpha = A::select(takes_part, alpha, Floats<N>{});
                    std::uint32_t const at_pair = pairs.count++;
                    pairs.splat[at_pair] = i;
                    pairs.dx[at_pair] = dx, pairs.off[at_pair] = off;
                    pairs.alpha[at_pair] = alpha, pairs.t[at_pair] = p.t;
                    pairs.moves[at_pair] = takes_part & follows;
                    blend_pair<Depth, A>(p, Floats<N>(alpha * p.t), paint);
                }
                if (pairs.count != 0) blend_all_motions<Depth, N>(row, column, c, pairs);
            }
            each_plain_field(p, Depth, StoreField<N>{row, column});
            std::uint32_t counts[N];
            store(counts, counted);
            for (std::uint32_t one : counts) contributing += one;
        }
        return contributing;
    }
};
} // namespace detail

}}} // namespace tilemesh::splat::pose
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
