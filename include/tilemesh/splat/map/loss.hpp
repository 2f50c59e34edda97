#pragma once
#include <tilemesh/splat/blending_block.hpp>
#include <tilemesh/splat/number.hpp>
#include <tilemesh/splat/target_pixel.hpp>

/// The loss of a picture against a target, and its slopes by what blending gave each pixel: colour, depth sum and last transmittance.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // the functions are always inlined, so it does not matter how a wide vector is passed
namespace tilemesh { inline namespace v0_2 { namespace splat::map {

/// A pixel's depth counts if its splats cover it by more than this share.
inline constexpr float least_covered = 0.5f;

/// What lies behind the pair that ends a pixel, as its slope sees it.
enum class LastPair : std::uint32_t {
    alike, ///< more of the same: the pair's shape and opacity get nothing. Maps fit as well or better (bench/mapping)
    as_cut ///< the last transmittance alone: the derivative of the picture as it is
};

/// The loss of a pixel: `colour` times the mean of |r| over the channels, plus `depth` times |D - D*| / D*, with the depth D of the picture
/// and D* of the target. A residual inside a Huber width counts squared; 0 is the absolute value alone.
struct LossRules {
    float colour = 1, depth = 0;
    float huber_colour = 0, huber_depth = 0;
    /// Bounds a pixel's slope by a colour, and what a pair of a splat and a pixel adds to a sum, in units of its weight. Pairs beyond it
    /// are clipped.
    float limit = 4;
    LastPair last_pair = LastPair::alike;
};

/// The targets of a block, field by field: red, green, blue, depth. Pixels that do not count are NaN.
struct alignas(splat::detail::vector_bytes) BlockTarget {
    float field[4][block_height][block_width];
};
/// A block's slopes by the sum of w c, by the depth sum of w z and by the last transmittance. `left` is what the second walk begins with:
/// the sum of all slopes, each times its own sum or transmittance.
struct alignas(splat::detail::vector_bytes) BlockSlopes {
    float colour[3][block_height][block_width];
    float depth[block_height][block_width];
    float through[block_height][block_width];
    float left[block_height][block_width];
};
/// A block's loss, its squared differences of colours, and the pixels that count, as the host reports them.
struct BlockLoss {
    float loss, squares;
    std::uint32_t pixels;
};

namespace detail {
/// A loss and its slope by the residual `r`, for a Huber width; width 0 is |r|, whose slope is 0 at 0.
template <class A>
struct Robust {
    typename A::Real loss, slope;

    TILEMESH_KERNEL Robust(typename A::Real const& r, float width) noexcept
    {
        using Real = typename A::Real;
        Real const zero = A::all(0.0f), one = A::all(1.0f), size = A::magnitude(r);
        Real const sign = A::select(r > zero, one, A::select(r < zero, -one, zero));
        if (width > 0) {
            Real const share = r * (1.0f / width);
            auto const inside = size < A::all(width);
            slope = A::select(inside, share, sign);
            loss = A::select(inside, 0.5f * share * r, size - 0.5f * width);
        } else {
            slope = sign;
            loss = size;
        }
    }
};

/// The slopes of a blended block, and its loss. Requires that no background was added to the block.
struct MakeSlopes {
    template <class Set>
    TILEMESH_KERNEL static void run(splat::detail::DepthBlockFields const& block, BlockTarget const& target, float const (&background)[3],
                                    LossRules const& rules, BlockSlopes& out, BlockLoss& total) noexcept
    {
        using namespace splat::detail;
        constexpr std::uint32_t N = Set::most_lanes;
        using A = FloatLanes<N>;
        float losses[block_width], squares[block_width];
        std::int32_t counted[block_width];
        Floats<N> const zero{}, one = broadcast<N>(1.0f), most = broadcast<N>(1e18f);
        Floats<N> const high = broadcast<N>(rules.limit), low = broadcast<N>(-rules.limit);
        float const share = rules.colour * (1.0f / 3.0f);
        for (std::uint32_t column = 0; column < block_width; column += N) {
            Floats<N> loss = zero, square = zero;
            Words<N> count{};
            for (std::uint32_t y = 0; y < block_height; ++y) {
                Floats<N> const through = A::magnitude(load<N>(block.transmittance[y] + column)), covered = one - through;
                Floats<N> const colour[3] = {load<N>(block.red[y] + column), load<N>(block.green[y] + column),
                                             load<N>(block.blue[y] + column)};
                Floats<N> const seen = load<N>(target.field[3][y] + column);
                Floats<N> residual[3], slope[3], gained = zero;
                Words<N> counts = through <= one;
                for (std::uint32_t c = 0; c < 3; ++c) {
                    residual[c] = multiply_add_lanes<N>(through, broadcast<N>(background[c]),
                                                        colour[c]) - load<N>(target.field[c][y] + column);
                    counts &= A::magnitude(residual[c]) < most; // false for NaN
                }
                for (std::uint32_t c = 0; c < 3; ++c) {
                    residual[c] = A::select(counts, residual[c], zero);
                    Robust<A> const one_channel(residual[c], rules.huber_colour);
                    slope[c] = clamp<A>(one_channel.slope * share, low, high);
                    gained = gained + one_channel.loss * share;
                    square = square + residual[c] * residual[c];
                }
                count = counts ? count + 1 : count;
                Floats<N> by_sum = zero, by_through = zero;
                if (rules.depth > 0) {
                    Floats<N> const sum = load<N>(block.depth[y] + column), depth = sum / covered, off = (depth - seen) / seen;
                    Robust<A> const of_depth(off, rules.huber_depth);
                    Floats<N> const slope_of_sum = of_depth.slope * rules.depth / (seen * covered), slope_of_through = slope_of_sum * depth;
                    Words<N> const deep = counts & (covered > least_covered) & (seen > 0.0f) & (A::magnitude(off) < most) &
                                          (A::magnitude(slope_of_sum) < most) & (A::magnitude(slope_of_through) < most);
                    by_sum = A::select(deep, slope_of_sum, zero);
                    by_through = A::select(deep, slope_of_through, zero);
                    gained = gained + A::select(deep, of_depth.loss * rules.depth, zero);
                }
                loss = loss + gained;
                Floats<N> left = zero;
                for (std::uint32_t c = 0; c < 3; ++c) {
                    by_through = multiply_add_lanes<N>(slope[c], broadcast<N>(background[c]), by_through);
                    left = multiply_add_lanes<N>(slope[c], colour[c], left);
                    store(out.colour[c][y] + column, slope[c]);
                }
                left = multiply_add_lanes<N>(by_sum, load<N>(block.depth[y] + column), left);
                store(out.depth[y] + column, by_sum);
                store(out.through[y] + column, by_through);
                store(out.left[y] + column, multiply_add_lanes<N>(by_through, through, left));
            }
            store(losses + column, loss);
            store(squares + column, square);
            store(counted + column, count);
        }
        total = {0, 0, 0};
        for (std::uint32_t i = 0; i < block_width; ++i) {
            total.loss = total.loss + losses[i];
            total.squares = total.squares + squares[i];
            total.pixels += static_cast<std::uint32_t>(counted[i]);
        }
    }
};
} // namespace detail

}}} // namespace tilemesh::splat::map
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
