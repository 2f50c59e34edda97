#pragma once
#include <tilemesh/splat/cell_state.hpp>
#include <tilemesh/splat/number.hpp>
#include <utility>

/// Blends splats, front to back, into a cell of 8 x 4 pixels: the arithmetic `fast`. A batch of splats goes through three short loops:
/// `start` (alpha of the first row, and the ratio of the second row to it), `weigh` (the recurrence down the rows, the cut, the stop,
/// w = alpha T) and `colour` (C += w c). So the state that a loop changes stays in 16 registers, and turns of a loop overlap. A target whose
/// vectors hold two rows of a cell has the registers for one loop (cell_wide.hpp).
///
/// The bits of a pixel do not depend on the lanes, on the batches, or on the pixels that are blended beside it.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat::detail {

/// The columns of a cell that are computed at once, for a target with N lanes.
template <std::uint32_t N>
inline constexpr std::uint32_t columns_at_once = N < cell_width ? N : cell_width;

/// Row k of a field.
template <std::uint32_t N, class AnyCell, class Field>
TILEMESH_KERNEL Floats<N> load_row(AnyCell const& cell, Field field, std::uint32_t k, std::uint32_t column) noexcept
{
    return load<N>((cell.*field)[k] + column);
}
template <std::uint32_t N, class AnyCell, class Field>
TILEMESH_KERNEL void store_row(AnyCell& cell, Field field, std::uint32_t k, std::uint32_t column, Floats<N> const& v) noexcept
{
    put<N>((cell.*field)[k] + column, v);
}

/// The splats that are blended at a time, at most.
template <std::uint32_t Size>
inline constexpr std::uint32_t batch_of = Size < 64 ? Size : 64;

/// What a batch of splats has in the columns of a vector. `rows` is alpha first, then w.
template <std::uint32_t N, std::uint32_t Most>
struct alignas(vector_bytes) Batch {
    float first[Most][N], ratio[Most][N];
    float rows[Most][cell_height][N];
};

/// The powers of a splat in the first row of a cell, and its rise to the second row: log2 of alpha, and of the ratio.
template <std::uint32_t W>
struct Exponents {
    Floats<W> power, rise;
};
/// a * b + c, rounded as by multiply_add_lanes.
template <std::uint32_t W>
TILEMESH_KERNEL Floats<W> added_product(Floats<W> const& a, Floats<W> const& b, float c) noexcept
{
#if defined(__FMA__) || defined(__ARM_FEATURE_FMA) || defined(__IPU__)
    return multiply_add_lanes<W>(a, b, broadcast<W>(c));
#else
    return a * b + c;
#endif
}
template <std::uint32_t W, std::uint32_t Size>
TILEMESH_KERNEL Exponents<W> exponents(CellChunk<Size> const& c, std::uint32_t i, Floats<W> const& xs, float y) noexcept
{
    CellSplat const& s = c.splats[i];
    Floats<W> const dx = xs - s.mean_x, dy = broadcast<W>(y - s.mean_y);
    Floats<W> const off = multiply_add_lanes<W>(s.tilt, dx, dy), u = s.across2 * off;
    Floats<W> const power = multiply_add_lanes<W>(s.along2 * dx, dx, added_product<W>(u, off, c.height[i]));
    return {power, u + u + s.across2};
}
/// Stores alpha of all rows. Down a column alpha is a Gaussian of the row, so each ratio of two neighbours is the previous ratio times a
/// constant q = 2^(2 across).
template <std::uint32_t N>
TILEMESH_KERNEL void put_rows(float (&rows)[cell_height][N], Floats<N> const& first, Floats<N> const& first_ratio, float q) noexcept
{
    static_assert(cell_height == 4, "the rows are written out");
    Floats<N> const second = first * first_ratio, ratio = q * first_ratio, third = second * ratio, fourth = third * (q * ratio);
    put<N>(rows[0], first), put<N>(rows[1], second), put<N>(rows[2], third), put<N>(rows[3], fourth);
}
/// The powers of two of one splat.
template <class Rule, std::uint32_t N, std::uint32_t Most>
TILEMESH_KERNEL void put_first(Batch<N, Most>& to, std::uint32_t h, Exponents<N> const& e) noexcept
{
    auto const lowest = broadcast<N>(lowest_exponent);
    put<N>(to.first[h], power_of_two<Rule::degree, N>(at_least<N>(e.power, lowest)));
    put<N>(to.ratio[h], power_of_two<Rule::degree, N>(between<N>(e.rise, lowest, broadcast<N>(steepest_rise))));
}
/// The first row of a batch. The exponents of the next splat are computed while this splat's powers are: so no chain of operations is longer
/// than a core looks ahead. One number more is read.
template <class Rule, std::uint32_t N, std::uint32_t Most, std::uint32_t Size, class Number>
TILEMESH_KERNEL void start(Batch<N, Most>& to, CellChunk<Size> const& c, Number const* list, std::uint32_t n,
                           Floats<N> const& xs, float y) noexcept
{
    auto next = exponents<N>(c, list[0], xs, y);
#if defined(__clang__)
#    pragma clang loop unroll(disable) // lists are short: the rest of an unrolled loop costs more than it saves
#endif
    for (std::uint32_t h = 0; h < n; ++h) {
        auto const now = next;
        next = exponents<N>(c, list[h + 1], xs, y);
        put_first<Rule, N>(to, h, now);
    }
}

/// alpha of the splats that need more than the recurrence. It is called, not inlined, so that the loops have all registers.
template <class Rule>
struct CorrectRows {
    template <class Set, std::uint32_t N, std::uint32_t Most, std::uint32_t Size, class Number>
    TILEMESH_KERNEL static void run(Batch<N, Most>& batch, CellChunk<Size> const& c, Number const* list, std::uint32_t n, CellPlace const& at,
                                    std::uint32_t column, Floats<N> const& xs, float alpha_max) noexcept
    {
        for (std::uint32_t h = 0; h < n; ++h) {
            std::uint32_t const i = list[h];
            put_rows<N>(batch.rows[h], load<N>(batch.first[h]), load<N>(batch.ratio[h]), c.q[i]);
            if (c.special[i] == 0) continue;
            for (std::uint32_t k = 0; k < cell_height; ++k) correct<N>(batch.rows[h][k], c, i, at, column, at.row + k, xs, alpha_max);
        }
    }

private:
    template <std::uint32_t W, std::uint32_t Size>
    TILEMESH_KERNEL static void correct(float* row, CellChunk<Size> const& c, std::uint32_t i, CellPlace const& at, std::uint32_t column,
                                        std::uint32_t y, Floats<W> const& xs, float alpha_max) noexcept
    {
        std::uint32_t const why = c.special[i];
        Floats<W> alpha = load<W>(row);
        if ((why & Special::apart) != 0) {
            auto const power = exponents<W>(c, i, xs, static_cast<float>(y) + 0.5f - at.cy).power;
            alpha = power_of_two<Rule::degree, W>(at_least<W>(power, broadcast<W>(lowest_exponent)));
        }
        alpha = at_most<W>(alpha, broadcast<W>(alpha_max)); // no splat with another reason is above it
        if ((why & Special::clipped) != 0) {
            CellSplat const& s = c.splats[i];
            auto const x0 = static_cast<std::int32_t>(s.columns & 0xffffu), x1 = static_cast<std::int32_t>(s.columns >> 16);
            Words<W> const x = counted_lanes<W>() + static_cast<std::int32_t>(column);
            Words<W> const inside = (x >= x0) & (x < x1);
            bool const covered = y >= (s.rows & 0xffffu) && y < s.rows >> 16;
            alpha = covered ? floats_of<W>(bits_of<W>(alpha) & inside) : Floats<W>{};
        }
        put<W>(row, alpha);
    }
};

/// What `weigh` changes: T of a vector's pixels, and the pairs that contributed.
template <std::uint32_t N>
struct Weighing {
    Floats<N> t[cell_height];
    Words<N> seen;
};
/// The cuts and the clamp of the rules, in all lanes.
template <std::uint32_t N>
struct Cuts {
    Floats<N> alpha, transmittance, most;
    TILEMESH_KERNEL explicit Cuts(Rules const& rules) noexcept
        : alpha(broadcast<N>(rules.alpha_min)), transmittance(broadcast<N>(rules.transmittance_min)), most(broadcast<N>(rules.alpha_max))
    {
    }
};
/// One pair of a splat and N pixels: w = alpha T and T -= w, where alpha passes the cut and the pixel goes on. Returns w.
template <class Stop, std::uint32_t N>
TILEMESH_KERNEL Floats<N> weighed(Floats<N>& t, Words<N>& seen, Floats<N> const& alpha, Cuts<N> const& least) noexcept
{
#if defined(__AVX512F__) && !defined(__clang__)
    if constexpr (N == 16) { // of the code below GCC 12 makes more instructions than masks need
        constexpr int at_least = 29, below = 17, current = 4; // quiet compares, false for NaN
        auto in = __builtin_ia32_cmpps512_mask(alpha, least.alpha, at_least, static_cast<unsigned short>(0xffff), current);
        in = __builtin_ia32_cmpps512_mask(t, least.transmittance, at_least, in, current);
        if constexpr (Stop::drops_crossing) {
            auto const crosses = __builtin_ia32_cmpps512_mask(t - alpha * t, least.transmittance, below, in, current);
            t = floats_of<N>(__builtin_ia32_pxord512_mask(bits_of<N>(t), broadcast_word<N>(-0x7fffffff - 1), bits_of<N>(t), crosses));
            in = static_cast<unsigned short>(in & ~crosses);
        }
        Floats<N> const weight = __builtin_ia32_mulps512_mask(alpha, t, Floats<N>{}, in, current);
        t = t - weight;
        seen = __builtin_ia32_paddd512_mask(seen, broadcast_word<N>(1), seen, in);
        return weight;
    }
#endif
    Words<N> in = alpha >= least.alpha;
    in &= t >= least.transmittance;
    if constexpr (Stop::drops_crossing) {
        Words<N> const crosses = in & (t - alpha * t < least.transmittance);
        t = crosses ? -t : t;
        in &= ~crosses;
    }
    Floats<N> const weight = floats_of<N>(bits_of<N>(alpha) & in) * t;
    t = t - weight;
    if constexpr (N > cell_width)
        seen = in ? seen + 1 : seen; // one instruction where a compare gives bits
    else
        seen -= in; // all bits set are -1
    return weight;
}
template <class Stop, std::uint32_t N, std::uint32_t... V>
TILEMESH_KERNEL void weigh_rows(Weighing<N>& s, float* rows, Cuts<N> const& least, std::integer_sequence<std::uint32_t, V...>) noexcept
{
    (put<N>(rows + V * N, weighed<Stop, N>(s.t[V], s.seen, load<N>(rows + V * N), least)), ...);
}
/// min(alpha, alpha_max) of a splat whose alpha may be larger.
template <bool Clamped, std::uint32_t N>
TILEMESH_KERNEL Floats<N> at_alpha_max(Floats<N> const& alpha, Floats<N> const& most) noexcept
{
    if constexpr (!Clamped) return alpha;
    return at_most<N>(most, alpha); // NaN, which a wide power may give below the cut, stays
}
/// `weigh_rows` of one splat, with alpha by recurrence.
template <class Stop, bool Clamped, std::uint32_t N, std::uint32_t Most>
TILEMESH_KERNEL void weigh_recurring(Weighing<N>& s, Batch<N, Most>& batch, std::uint32_t h, float q, Cuts<N> const& least) noexcept
{
    static_assert(cell_height == 4, "the rows are written out");
    auto& rows = batch.rows[h];
    Floats<N> alpha = load<N>(batch.first[h]), ratio = load<N>(batch.ratio[h]);
    put<N>(rows[0], weighed<Stop, N>(s.t[0], s.seen, at_alpha_max<Clamped, N>(alpha, least.most), least));
    alpha = alpha * ratio, ratio = q * ratio;
    put<N>(rows[1], weighed<Stop, N>(s.t[1], s.seen, at_alpha_max<Clamped, N>(alpha, least.most), least));
    alpha = alpha * ratio, ratio = q * ratio;
    put<N>(rows[2], weighed<Stop, N>(s.t[2], s.seen, at_alpha_max<Clamped, N>(alpha, least.most), least));
    alpha = alpha * ratio;
    put<N>(rows[3], weighed<Stop, N>(s.t[3], s.seen, at_alpha_max<Clamped, N>(alpha, least.most), least));
}
template <std::uint32_t N, class AnyCell, std::uint32_t... V>
TILEMESH_KERNEL void load_weighing(Weighing<N>& s, AnyCell const& cell, std::uint32_t column, std::integer_sequence<std::uint32_t, V...>) noexcept
{
    s.seen = Words<N>{};
    ((s.t[V] = load_row<N>(cell, &CellFields::transmittance, V, column)), ...);
}
template <std::uint32_t N, class AnyCell, std::uint32_t... V>
TILEMESH_KERNEL void store_weighing(Weighing<N> const& s, AnyCell& cell, std::uint32_t column, std::integer_sequence<std::uint32_t, V...>) noexcept
{
    (store_row<N>(cell, &CellFields::transmittance, V, column, s.t[V]), ...);
    std::int32_t* const to = cell.contributing + column;
    store(to, Words<N>(load_words<N>(to) + s.seen));
}
/// 1 if a pixel of the cell goes on, else 0.
template <std::uint32_t N, std::uint32_t... V>
TILEMESH_KERNEL std::uint32_t goes_on(Weighing<N> const& s, Cuts<N> const& least, std::integer_sequence<std::uint32_t, V...>) noexcept
{
    return any_pixel<N>(((s.t[V] >= least.transmittance) | ...));
}
/// The weights w = alpha T of a batch. `Recurs`: alpha comes by recurrence, and may exceed alpha_max if it is `Clamped`; else from the rows.
/// Returns whether a pixel goes on.
template <class Stop, bool Recurs, bool Clamped, std::uint32_t N, std::uint32_t Most, class AnyCell, std::uint32_t Size, class Number>
TILEMESH_KERNEL std::uint32_t weigh(Batch<N, Most>& batch, AnyCell& cell, CellChunk<Size> const& c, Number const* list, std::uint32_t n,
                                    std::uint32_t column, Rules const& rules) noexcept
{
    Weighing<N> s;
    load_weighing<N>(s, cell, column, CellRows{});
    Cuts<N> const least(rules);
#if defined(__clang__)
#    pragma clang loop unroll(disable)
#endif
    for (std::uint32_t h = 0; h < n; ++h) {
        if constexpr (Recurs)
            weigh_recurring<Stop, Clamped, N>(s, batch, h, c.q[list[h]], least);
        else
            weigh_rows<Stop, N>(s, &batch.rows[h][0][0], least, CellRows{});
    }
    store_weighing<N>(s, cell, column, CellRows{});
    return goes_on<N>(s, least, CellRows{});
}

/// Adds w times three words of a splat to three fields of the state.
template <std::uint32_t N, std::uint32_t... V>
TILEMESH_KERNEL void add_colour(Floats<N> (&r)[cell_height], Floats<N> (&g)[cell_height], Floats<N> (&b)[cell_height], float const* rows,
                                CellSplat const& s, std::integer_sequence<std::uint32_t, V...>) noexcept
{
    float const red = s.red, green = s.green, blue = s.blue;
    Floats<N> const w[] = {load<N>(rows + V * N)...};
    ((r[V] = multiply_add_lanes<N>(red, w[V], r[V])), ...);
    ((g[V] = multiply_add_lanes<N>(green, w[V], g[V])), ...);
    ((b[V] = multiply_add_lanes<N>(blue, w[V], b[V])), ...);
}
template <std::uint32_t N, class AnyCell, class Field, std::uint32_t... V>
TILEMESH_KERNEL void load_field(Floats<N> (&v)[cell_height], AnyCell const& cell, Field field, std::uint32_t column,
                                std::integer_sequence<std::uint32_t, V...>) noexcept
{
    ((v[V] = load_row<N>(cell, field, V, column)), ...);
}
template <std::uint32_t N, class AnyCell, class Field, std::uint32_t... V>
TILEMESH_KERNEL void store_field(Floats<N> const (&v)[cell_height], AnyCell& cell, Field field, std::uint32_t column,
                                 std::integer_sequence<std::uint32_t, V...>) noexcept
{
    (store_row<N>(cell, field, V, column, v[V]), ...);
}
/// C += w c.
template <std::uint32_t N, std::uint32_t Most, class AnyCell, std::uint32_t Size, class Number>
TILEMESH_KERNEL void colour(AnyCell& cell, Batch<N, Most> const& batch, CellChunk<Size> const& c, Number const* list, std::uint32_t n,
                            std::uint32_t column) noexcept
{
    Floats<N> r[cell_height], g[cell_height], b[cell_height];
    load_field<N>(r, cell, &CellFields::red, column, CellRows{});
    load_field<N>(g, cell, &CellFields::green, column, CellRows{});
    load_field<N>(b, cell, &CellFields::blue, column, CellRows{});
#if defined(__clang__)
#    pragma clang loop unroll(disable)
#endif
    for (std::uint32_t h = 0; h < n; ++h) add_colour<N>(r, g, b, &batch.rows[h][0][0], c.splats[list[h]], CellRows{});
    store_field<N>(r, cell, &CellFields::red, column, CellRows{});
    store_field<N>(g, cell, &CellFields::green, column, CellRows{});
    store_field<N>(b, cell, &CellFields::blue, column, CellRows{});
}
template <std::uint32_t N, std::uint32_t... V>
TILEMESH_KERNEL void add_depth(Floats<N> (&sum)[cell_height], Floats<N> (&z)[cell_height], float const* rows, float depth,
                               std::integer_sequence<std::uint32_t, V...>) noexcept
{
    ((sum[V] = sum[V] + load<N>(rows + V * N)), ...);
    ((z[V] = multiply_add_lanes<N>(depth, load<N>(rows + V * N), z[V])), ...);
}
/// W += w and Z += w z.
template <std::uint32_t N, std::uint32_t Most, class AnyCell, std::uint32_t Size, class Number>
TILEMESH_KERNEL void depths(AnyCell& cell, Batch<N, Most> const& batch, CellChunk<Size> const& c, Number const* list, std::uint32_t n,
                            std::uint32_t column) noexcept
{
    Floats<N> sum[cell_height], z[cell_height];
    load_field<N>(sum, cell, &DepthCellFields::weight, column, CellRows{});
    load_field<N>(z, cell, &DepthCellFields::depth, column, CellRows{});
    for (std::uint32_t h = 0; h < n; ++h) add_depth<N>(sum, z, &batch.rows[h][0][0], depth_of_key(c.splats[list[h]].depth_key), CellRows{});
    store_field<N>(sum, cell, &DepthCellFields::weight, column, CellRows{});
    store_field<N>(z, cell, &DepthCellFields::depth, column, CellRows{});
}

/// Does `weigh` clamp? Not for a tile's worker, which has no room for more code: there, CorrectRows clamps.
template <std::uint32_t Size>
inline constexpr bool clamps_in_loops = Size > 16;
/// Blends the splats that `list` names, 1 to batch_of<Size> numbers in the chunk, into those columns of a cell that have a bit in `columns`, and
/// perhaps into columns beside them. `special`: the bits of Special that splats of the list may have. Returns 1 if a pixel of these columns goes
/// on. One number more is read.
template <class Rule, class Stop>
struct BlendCell {
    template <class Set, class AnyCell, std::uint32_t Size, class Number>
    TILEMESH_KERNEL static std::uint32_t run(AnyCell& cell, CellChunk<Size> const& c, Number const* list, std::uint32_t n, CellPlace const& at,
                                             std::uint32_t columns, std::uint32_t special, Rules const& rules) noexcept
    {
        constexpr std::uint32_t N = columns_at_once<Set::most_lanes>;
        Batch<N, batch_of<Size>> batch;
        float const y = static_cast<float>(at.row) + 0.5f - at.cy;
        std::uint32_t going = 0;
        for (std::uint32_t column = 0; column < cell_width; column += N) {
            if ((columns >> column & ((1u << N) - 1)) == 0) continue;
            Floats<N> const xs = __builtin_convertvector(counted_lanes<N>(), Floats<N>) + static_cast<float>(at.column + column) + 0.5f - at.cx;
            start<Rule, N>(batch, c, list, n, xs, y);
            if (special == 0) {
                going |= weigh<Stop, true, false, N>(batch, cell, c, list, n, column, rules);
            } else if (clamps_in_loops<Size> && recurs(special)) {
                going |= weigh<Stop, true, clamps_in_loops<Size>, N>(batch, cell, c, list, n, column, rules);
            } else {
                Set::template call<CorrectRows<Rule>>(batch, c, list, n, at, at.column + column, xs, rules.alpha_max);
                going |= weigh<Stop, false, false, N>(batch, cell, c, list, n, column, rules);
            }
            colour<N>(cell, batch, c, list, n, column);
            if constexpr (AnyCell::has_depth) depths<N>(cell, batch, c, list, n, column);
        }
        return going;
    }
};

}}} // namespace tilemesh::splat::detail
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
