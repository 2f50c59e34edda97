#pragma once
#include <tilemesh/splat/blending_cells.hpp>

/// Blends cells for a target whose vectors hold two rows of a cell and that has 32 registers: all sums stay in registers, and one loop does what
/// `start`, `weigh` and `colour` do (blending_cells.hpp), with the same bits. Splats here need no more than the recurrence and the clamp.
///
/// Three splats are in progress in a turn of a loop, each in another stage: a core does not look far enough ahead for the whole way of one, about 85
/// cycles. So two numbers more of a list are read.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat::detail {

inline constexpr std::uint32_t wide_lanes = 2 * cell_width;
using Wide = Floats<wide_lanes>;
using Half = Floats<cell_width>;
static_assert(wide_lanes == 16 && cell_height == 4, "the rows are written out");

/// Are cells blended so where the set in use has the lanes? Not by a tile's worker: it has no memory for a second cell.
template <std::uint32_t Size>
inline constexpr bool blends_wide = (Size > 16) && most_native_lanes == wide_lanes;

TILEMESH_KERNEL Wide joined(Half const& low, Half const& high) noexcept
{
    Wide both;
    join(low, high, both);
    return both;
}
/// The powers of two of exponents and rises, as in `put_first`, without clamps. Denormals are 0 (`Rule::Denormals`). So a column that begins below
/// `lowest_exponent` is 0, or NaN after its first row, and has no pixel above the cut (`steepest_rise`). Another one has sqrt(a) |off| <=
/// sqrt(126) there (no opacity is above 1), and rises by at most 2 sqrt(126 a) + a = 49 with a <= `sharpest`: nothing overflows.
template <class Rule>
TILEMESH_KERNEL Wide wide_power(Wide const& x) noexcept
{
#if defined(__AVX512F__)
    constexpr unsigned short all = 0xffff;
    constexpr int nearest = 0, current = 4;
    Wide const n = __builtin_ia32_rndscaleps_mask(x, nearest, x, all, current);
    return __builtin_ia32_scalefps512_mask(polynomial<Rule::degree, wide_lanes>(x - n), n, x, all, current);
#else
    auto const lowest = broadcast<wide_lanes>(lowest_exponent), steepest = broadcast<wide_lanes>(steepest_rise);
    return power_of_two<Rule::degree, wide_lanes>(between<wide_lanes>(x, lowest, steepest));
#endif
}
/// Blends splats into a cell whose rows 0 and 1 lie in one vector and 2 and 3 in another. Returns 1 if a pixel goes on.
template <class Rule, class Stop, bool Clamped>
struct BlendStacked {
    template <class Set, class AnyCell, std::uint32_t Size, class Number>
    TILEMESH_KERNEL static std::uint32_t run(AnyCell& cell, CellChunk<Size> const& c, Number const* list, std::uint32_t n, CellPlace const& at,
                                             Rules const& rules) noexcept
    {
        if constexpr (Set::most_lanes < wide_lanes) {
            return 0; // this set is not asked
        } else {
            constexpr std::uint32_t N = wide_lanes;
            Half const xs = __builtin_convertvector(counted_lanes<cell_width>(), Half) + static_cast<float>(at.column) + 0.5f - at.cx;
            float const y = static_cast<float>(at.row) + 0.5f - at.cy;
            Cuts<N> const least(rules);
            Wide t0 = load<N>(cell.transmittance[0]), t1 = load<N>(cell.transmittance[2]);
            Wide r0 = load<N>(cell.red[0]), r1 = load<N>(cell.red[2]), g0 = load<N>(cell.green[0]), g1 = load<N>(cell.green[2]);
            Wide b0 = load<N>(cell.blue[0]), b1 = load<N>(cell.blue[2]);
            [[maybe_unused]] Wide sum0{}, sum1{}, z0{}, z1{};
            if constexpr (AnyCell::has_depth) {
                sum0 = load<N>(cell.weight[0]), sum1 = load<N>(cell.weight[2]);
                z0 = load<N>(cell.depth[0]), z1 = load<N>(cell.depth[2]);
            }
            Words<N> seen{};
            Wide power = wide_power<Rule>(first_and_rise(c, list[0], xs, y)), exponent = first_and_rise(c, list[1], xs, y);
            for (std::uint32_t h = 0; h < n; ++h) {
                std::uint32_t const i = list[h];
                Half first, ratio;
                split(power, first, ratio);
                power = wide_power<Rule>(exponent);
                exponent = first_and_rise(c, list[h + 2], xs, y);
                CellSplat const& s = c.splats[i];
                Half const q = broadcast<cell_width>(c.q[i]);
                Half const second = first * ratio, ratio1 = q * ratio, third = second * ratio1, fourth = third * (q * ratio1);
                Wide const w0 = weighed<Stop, N>(t0, seen, at_alpha_max<Clamped, N>(joined(first, second), least.most), least);
                Wide const w1 = weighed<Stop, N>(t1, seen, at_alpha_max<Clamped, N>(joined(third, fourth), least.most), least);
                float const red = s.red, green = s.green, blue = s.blue;
                r0 = multiply_add_lanes<N>(red, w0, r0), r1 = multiply_add_lanes<N>(red, w1, r1);
                g0 = multiply_add_lanes<N>(green, w0, g0), g1 = multiply_add_lanes<N>(green, w1, g1);
                b0 = multiply_add_lanes<N>(blue, w0, b0), b1 = multiply_add_lanes<N>(blue, w1, b1);
                if constexpr (AnyCell::has_depth) {
                    float const depth = depth_of_key(s.depth_key);
                    sum0 = sum0 + w0, sum1 = sum1 + w1;
                    z0 = multiply_add_lanes<N>(depth, w0, z0), z1 = multiply_add_lanes<N>(depth, w1, z1);
                }
            }
            put<N>(cell.transmittance[0], t0), put<N>(cell.transmittance[2], t1);
            put<N>(cell.red[0], r0), put<N>(cell.red[2], r1), put<N>(cell.green[0], g0), put<N>(cell.green[2], g1);
            put<N>(cell.blue[0], b0), put<N>(cell.blue[2], b1);
            if constexpr (AnyCell::has_depth) {
                put<N>(cell.weight[0], sum0), put<N>(cell.weight[2], sum1);
                put<N>(cell.depth[0], z0), put<N>(cell.depth[2], z1);
            }
            Words<cell_width> low, high;
            split(seen, low, high);
            store(cell.contributing, Words<cell_width>(load_words<cell_width>(cell.contributing) + low + high));
            return any_pixel<N>((t0 >= least.transmittance) | (t1 >= least.transmittance));
        }
    }

private:
    /// The exponents of a splat in the first row of a cell, and its rise.
    template <std::uint32_t Size>
    TILEMESH_KERNEL static Wide first_and_rise(CellChunk<Size> const& c, std::uint32_t i, Half const& xs, float y) noexcept
    {
        auto const e = exponents<cell_width>(c, i, xs, y);
        return joined(e.power, e.rise);
    }
};

/// Blends splats into two cells side by side, with a row of both in one vector; `at` is the left one's place. Returns 1 if a pixel of the left cell
/// goes on, plus 2 if one of the right cell does.
template <class Rule, class Stop, bool Clamped>
struct BlendPair {
    template <class Set, class AnyCell, std::uint32_t Size, class Number>
    TILEMESH_KERNEL static std::uint32_t run(AnyCell& left, AnyCell& right, CellChunk<Size> const& c, Number const* list, std::uint32_t n,
                                             CellPlace const& at, Rules const& rules) noexcept
    {
        if constexpr (Set::most_lanes < wide_lanes) {
            return 0; // this set is not asked
        } else {
            constexpr std::uint32_t N = wide_lanes;
            Wide const xs = __builtin_convertvector(counted_lanes<N>(), Wide) + static_cast<float>(at.column) + 0.5f - at.cx;
            float const y = static_cast<float>(at.row) + 0.5f - at.cy;
            Cuts<N> const least(rules);
            Wide t[cell_height], r[cell_height], g[cell_height], b[cell_height];
            load_rows(t, left.transmittance, right.transmittance, CellRows{});
            load_rows(r, left.red, right.red, CellRows{}), load_rows(g, left.green, right.green, CellRows{});
            load_rows(b, left.blue, right.blue, CellRows{});
            Words<N> seen{};
            auto exponent = exponents<N>(c, list[0], xs, y);
            Wide next_first = wide_power<Rule>(exponent.power), next_ratio = wide_power<Rule>(exponent.rise);
            exponent = exponents<N>(c, list[1], xs, y);
            for (std::uint32_t h = 0; h < n; ++h) {
                std::uint32_t const i = list[h];
                Wide const first = next_first, ratio = next_ratio;
                next_first = wide_power<Rule>(exponent.power), next_ratio = wide_power<Rule>(exponent.rise);
                exponent = exponents<N>(c, list[h + 2], xs, y);
                CellSplat const& s = c.splats[i];
                float const q = c.q[i], red = s.red, green = s.green, blue = s.blue;
                Wide const second = first * ratio, ratio1 = q * ratio, third = second * ratio1, fourth = third * (q * ratio1);
                Wide const w0 = weighed<Stop, N>(t[0], seen, at_alpha_max<Clamped, N>(first, least.most), least);
                Wide const w1 = weighed<Stop, N>(t[1], seen, at_alpha_max<Clamped, N>(second, least.most), least);
                Wide const w2 = weighed<Stop, N>(t[2], seen, at_alpha_max<Clamped, N>(third, least.most), least);
                Wide const w3 = weighed<Stop, N>(t[3], seen, at_alpha_max<Clamped, N>(fourth, least.most), least);
                r[0] = multiply_add_lanes<N>(red, w0, r[0]), r[1] = multiply_add_lanes<N>(red, w1, r[1]);
                r[2] = multiply_add_lanes<N>(red, w2, r[2]), r[3] = multiply_add_lanes<N>(red, w3, r[3]);
                g[0] = multiply_add_lanes<N>(green, w0, g[0]), g[1] = multiply_add_lanes<N>(green, w1, g[1]);
                g[2] = multiply_add_lanes<N>(green, w2, g[2]), g[3] = multiply_add_lanes<N>(green, w3, g[3]);
                b[0] = multiply_add_lanes<N>(blue, w0, b[0]), b[1] = multiply_add_lanes<N>(blue, w1, b[1]);
                b[2] = multiply_add_lanes<N>(blue, w2, b[2]), b[3] = multiply_add_lanes<N>(blue, w3, b[3]);
            }
            store_rows(t, left.transmittance, right.transmittance, CellRows{});
            store_rows(r, left.red, right.red, CellRows{}), store_rows(g, left.green, right.green, CellRows{});
            store_rows(b, left.blue, right.blue, CellRows{});
            Words<cell_width> one, other;
            split(seen, one, other);
            store(left.contributing, Words<cell_width>(load_words<cell_width>(left.contributing) + one));
            store(right.contributing, Words<cell_width>(load_words<cell_width>(right.contributing) + other));
            Words<N> const going = (t[0] >= least.transmittance) | (t[1] >= least.transmittance) | (t[2] >= least.transmittance) |
                                   (t[3] >= least.transmittance);
            split(going, one, other);
            return any_pixel<cell_width>(one) | any_pixel<cell_width>(other) << 1;
        }
    }

private:
    using Rows = float[cell_height][cell_width];
    template <std::uint32_t... V>
    TILEMESH_KERNEL static void load_rows(Wide (&v)[cell_height], Rows const& left, Rows const& right,
                                          std::integer_sequence<std::uint32_t, V...>) noexcept
    {
        ((v[V] = joined(load<cell_width>(left[V]), load<cell_width>(right[V]))), ...);
    }
    TILEMESH_KERNEL static void store_both(Wide const& v, float* left, float* right) noexcept
    {
        Half one, other;
        split(v, one, other);
        put<cell_width>(left, one), put<cell_width>(right, other);
    }
    template <std::uint32_t... V>
    TILEMESH_KERNEL static void store_rows(Wide const (&v)[cell_height], Rows& left, Rows& right,
                                           std::integer_sequence<std::uint32_t, V...>) noexcept
    {
        (store_both(v[V], left[V], right[V]), ...);
    }
};

}}} // namespace tilemesh::splat::detail
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
