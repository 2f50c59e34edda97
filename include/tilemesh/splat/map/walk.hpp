#pragma once
#include <tilemesh/splat/map/loss.hpp>
#include <tilemesh/splat/map/sums.hpp>
#include <utility>

/// The second walk through a block's splats, front to back. What lies behind a pair of a splat and a pixel is the pixel's total minus
/// what has passed: there is no reversed list and no stored transmittance.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // the functions are always inlined, so it does not matter how a wide vector is passed
namespace tilemesh { inline namespace v0_2 { namespace splat::map {

/// A pixel (or lanes of pixels) on the second walk.
template <class A>
struct WalkingPixel {
    typename A::Real t;    ///< transmittance in front of the next pair
    typename A::Real left; ///< the part of the total that is not passed yet
};
/// A pixel's slopes by colour, depth sum and last transmittance.
template <class A>
struct PixelSlopes {
    typename A::Real colour[3], depth, through;
};
/// The words of a splat that a pair needs besides its alpha and its offsets.
template <class A>
struct WalkingPaint {
    typename A::Real colour[3], depth;
    typename A::Real most; ///< bounds the slope by the depth sum: the limit over the depth
};
/// The ten sums in raw offsets: gP times 1, dx, off, dx^2, dx off, off^2; then those of `w_red` and on.
template <class A>
struct PairSums {
    typename A::Real of[sums];
};

/// The rules of a pair on the second walk.
struct PairRules {
    float transmittance_min, limit;
    LastPair last_pair;
};

/// One pair, with alpha as blending has it. With q, the total's slope by the pair's weight, gP = w q - alpha B, and B is what lies behind
/// the pair, `left`, over 1 - alpha. The pair that ends the pixel is an exception. There `left` is a difference of equal numbers, and 1 -
/// alpha may be 0; so B follows from the rule of the stop (`LastPair`), and rounding is amplified by at most 1 / transmittance_min.
///
/// `takes_part`: the lanes that blend. `follows`: the lanes whose alpha follows the power; alpha_max clamps the others. The clip bounds
/// |gP| by limit w, also where an input was not finite.
template <class A>
TILEMESH_KERNEL void walk_pair(WalkingPixel<A>& p, typename A::Real const& alpha, typename A::Mask const& takes_part,
                               typename A::Mask const& follows, typename A::Real const& dx, typename A::Real const& off,
                               WalkingPaint<A> const& paint, PixelSlopes<A> const& slopes, PairRules const& rules, PairSums<A>& s) noexcept
{
    using Real = typename A::Real;
    Real const zero = A::all(0.0f);
    Real const w = A::select(takes_part, alpha * p.t, zero);
    Real const q = A::multiply_add(slopes.colour[0], paint.colour[0],
                                   A::multiply_add(slopes.colour[1], paint.colour[1],
                                                   A::multiply_add(slopes.colour[2], paint.colour[2], slopes.depth * paint.depth)));
    Real const passes = A::select(takes_part, w * q, zero);
    p.left = p.left - passes;
    Real const next = p.t - w;
    auto const ends = next < A::all(rules.transmittance_min > 0 ? rules.transmittance_min : 1e-30f);
    Real const at_the_end = p.t * (rules.last_pair == LastPair::alike ? q : slopes.through);
    Real const behind = A::select(ends, at_the_end, p.left / (A::all(1.0f) - alpha));
    p.t = next;

    Real const most = A::all(rules.limit) * w;
    Real slope = A::multiply_add(-alpha, behind, passes);
    slope = splat::detail::clamp<A>(slope, -most, most);
    slope = A::select(A::every(takes_part, follows), slope, zero);
    Real const by_dx = slope * dx, by_off = slope * off;
    s.of[gp] = s.of[gp] + slope;
    s.of[gp_x] = s.of[gp_x] + by_dx;
    s.of[gp_o] = s.of[gp_o] + by_off;
    s.of[gp_xx] = A::multiply_add(by_dx, dx, s.of[gp_xx]);
    s.of[gp_xo] = A::multiply_add(by_dx, off, s.of[gp_xo]);
    s.of[gp_oo] = A::multiply_add(by_off, off, s.of[gp_oo]);
    s.of[w_red] = A::multiply_add(w, slopes.colour[0], s.of[w_red]);
    s.of[w_green] = A::multiply_add(w, slopes.colour[1], s.of[w_green]);
    s.of[w_blue] = A::multiply_add(w, slopes.colour[2], s.of[w_blue]);
    s.of[w_depth] = A::multiply_add(w, splat::detail::clamp<A>(slopes.depth, -paint.most, paint.most), s.of[w_depth]);
}
/// Raw offsets to X and O: sums times powers of sqrt(-2 along) and sqrt(-2 across).
template <class A>
TILEMESH_KERNEL Moments<A> in_own_units(PairSums<A> const& s, typename A::Real const& along, typename A::Real const& across) noexcept
{
    typename A::Real const x = A::square_root(A::all(-2.0f) * along), o = A::square_root(A::all(-2.0f) * across);
    return {{s.of[gp], s.of[gp_x] * x, s.of[gp_o] * o, s.of[gp_xx] * x * x, s.of[gp_xo] * x * o, s.of[gp_oo] * o * o, s.of[w_red],
             s.of[w_green], s.of[w_blue], s.of[w_depth]}};
}

/// The sums of a splat, in groups of four words.
inline constexpr std::uint32_t padded_sums = 12;

/// A chunk of splats with what the second walk needs besides, and their sums over the blocks so far, in quanta.
template <std::uint32_t Size>
struct alignas(splat::detail::vector_bytes) WalkChunk : splat::detail::Chunk<Size> {
    float depth[Size], most[Size];
    float scale[Size][padded_sums]; ///< raw sums to quanta
    std::int32_t quanta[Size][padded_sums];

    /// `splat::detail::Chunk::take` for splat i < n, with empty sums.
    void prepare(std::uint32_t i, Splat const& s, float dilation, float limit) noexcept
    {
        depth[i] = s.depth();
        most[i] = limit / depth[i];
        float const unit = quanta_per_unit(s, dilation, limit), x = std::sqrt(-2.0f * s.along), o = std::sqrt(-2.0f * s.across);
        float const all[padded_sums] = {unit, unit * x, unit * o, unit * x * x, unit * x * o, unit * o * o, unit, unit, unit,
                                        unit * depth[i], 0, 0};
        for (std::uint32_t k = 0; k < padded_sums; ++k) {
            scale[i][k] = all[k] < 1e38f ? all[k] : 1e38f; // a dot without dilation: 0 times infinity would be NaN
            quanta[i][k] = 0;
        }
    }
    SplatSums sums_of(std::uint32_t i) const noexcept
    {
        SplatSums s;
        for (std::uint32_t k = 0; k < sums; ++k) s.of[k] = quanta[i][k];
        return s;
    }
};

/// A block on the second walk.
struct alignas(splat::detail::vector_bytes) WalkingBlock {
    float transmittance[block_height][block_width];
    BlockSlopes slopes;
};

namespace detail {
/// Adds four sums of a block, of which each has 16 columns, to a splat's quanta. The order is that of the columns, whatever the lanes:
/// column i and column i + 8, then i + 4, i + 2, i + 1.
TILEMESH_KERNEL void add_four(float const (*columns)[block_width], float const* scale, std::int32_t* quanta) noexcept
{
    using namespace splat::detail;
    Floats<4> of[4];
    for (std::uint32_t k = 0; k < 4; ++k)
        of[k] = (load<4>(columns[k]) + load<4>(columns[k] + 8)) + (load<4>(columns[k] + 4) + load<4>(columns[k] + 12));
    float x[4], y[4], z[4], w[4];
    store_transposed(of[0], of[1], of[2], of[3], x, y, z, w);
    Floats<4> const scaled = ((load<4>(x) + load<4>(z)) + (load<4>(y) + load<4>(w))) * load<4>(scale);
    Floats<4> const half = scaled < 0.0f ? broadcast<4>(-0.5f) : broadcast<4>(0.5f);
    store(quanta, Words<4>(load_words<4>(quanta) + FloatLanes<4>::truncate(scaled + half)));
}

/// Written out: GCC 12 would keep the sums in memory for a loop.
template <std::uint32_t N, std::uint32_t... K>
TILEMESH_KERNEL void store_sums(float (*columns)[block_width], std::uint32_t column, PairSums<splat::detail::FloatLanes<N>> const& s,
                                std::integer_sequence<std::uint32_t, K...>) noexcept
{
    (splat::detail::store(columns[K] + column, s.of[K]), ...);
}

/// Walks through the splats of `hits`, at most blended_between_looks, in a block, and adds the block's sums of each splat to its quanta.
/// The pairs that take part and their alphas are those of BlendBlock<Stop>, bit for bit.
template <class Stop>
struct WalkBlock {
    template <class Set, std::uint32_t Size>
    TILEMESH_KERNEL static void run(WalkingBlock& block, WalkChunk<Size>& c, std::uint32_t const* hits, std::uint32_t n,
                                    splat::detail::BlockPlace const& at, Rules const& m, LossRules const& loss) noexcept
    {
        using namespace splat::detail;
        constexpr std::uint32_t N = Set::most_lanes;
        using A = FloatLanes<N>;
        float const lowest = lowest_power_for(m.alpha_min);
        PairRules const rules{m.transmittance_min, loss.limit, loss.last_pair};
        alignas(vector_bytes) float columns[padded_sums][block_width] = {};
        for (std::uint32_t h = 0; h < n; ++h) {
            std::uint32_t const i = hits[h] & Hit::number, pattern = hits[h] >> Hit::limits_at;
            std::uint32_t const first = pattern / (block_height + 1), last = pattern % (block_height + 1);
            WalkingPaint<A> const paint{{broadcast<N>(c.red[i]), broadcast<N>(c.green[i]), broadcast<N>(c.blue[i])},
                                        broadcast<N>(c.depth[i]), broadcast<N>(c.most[i])};
            for (std::uint32_t column = 0; column < block_width; column += N) {
                auto s = PairSums<A>();
                Words<N> const place = counted_lanes<N>() + (at.column + static_cast<std::int32_t>(column));
                Floats<N> const dx = load<N>(at.xs + column) - c.mean_x[i], opacity = opacity_of<N>(c, i, place);
                for (std::uint32_t k = first; k < last; ++k) {
                    Floats<N> const dy = broadcast<N>(at.ys[k] - c.mean_y[i]);
                    Floats<N> const off = multiply_add_lanes<N>(broadcast<N>(-c.slope[i]), dx, dy);
                    Floats<N> const power = multiply_add_lanes<N>(c.along[i] * dx, dx, c.across[i] * off * off);
                    Floats<N> const raw = opacity * exponential_lanes<N>(power, lowest);
                    Words<N> const follows = ~(raw > m.alpha_max);
                    Floats<N> const alpha = raw < m.alpha_max ? raw : broadcast<N>(m.alpha_max);
                    WalkingPixel<A> p{load<N>(block.transmittance[k] + column), load<N>(block.slopes.left[k] + column)};
                    Words<N> takes_part = (alpha >= m.alpha_min) & (p.t >= m.transmittance_min);
                    if constexpr (Stop::drops_crossing) {
                        Words<N> const crosses = takes_part & (p.t - alpha * p.t < m.transmittance_min);
                        p.t = crosses ? -p.t : p.t;
                        takes_part &= ~crosses;
                    }
                    PixelSlopes<A> const slopes{{load<N>(block.slopes.colour[0][k] + column),
                                                 load<N>(block.slopes.colour[1][k] + column), load<N>(block.slopes.colour[2][k] + column)},
                                                load<N>(block.slopes.depth[k] + column), load<N>(block.slopes.through[k] + column)};
                    walk_pair<A>(p, alpha, takes_part, follows, dx, off, paint, slopes, rules, s);
                    store(block.transmittance[k] + column, p.t);
                    store(block.slopes.left[k] + column, p.left);
                }
                store_sums<N>(columns, column, s, std::make_integer_sequence<std::uint32_t, sums>{});
            }
            for (std::uint32_t k = 0; k < padded_sums; k += 4) add_four(columns + k, c.scale[i] + k, c.quanta[i] + k);
        }
    }
};
} // namespace detail

}}} // namespace tilemesh::splat::map
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
