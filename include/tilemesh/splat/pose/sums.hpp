#pragma once
#include <tilemesh/splat/blending_rules.hpp>
#include <tilemesh/splat/number.hpp>
#include <tilemesh/splat/pose/motion.hpp>
#include <utility>

/// Rows of a least-squares problem to its sums J^T J, J^T r and cost, in integers: whatever the order of the additions, the sums have the
/// same bits.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // the functions are always inlined, so it does not matter how a wide vector is passed
namespace tilemesh { inline namespace v0_2 { namespace splat::pose {

/// An integer of 64 bits as two words, in two's complement.
struct Wide {
    std::uint32_t low, high;

    void add(std::int32_t v) noexcept;
};
constexpr Wide operator+(Wide a, Wide b) noexcept
{
    std::uint32_t const sum = a.low + b.low;
    return {sum, a.high + b.high + (sum < a.low ? 1u : 0u)};
}
inline void Wide::add(std::int32_t v) noexcept
{
    *this = *this + Wide{static_cast<std::uint32_t>(v), v < 0 ? 0xffffffffu : 0u};
}
/// The most unknowns: six motions, the logarithm of the exposure's gain, and its offset.
inline constexpr std::uint32_t most_unknowns = motions + 2;

/// The sums of a part of the frame: the lower triangle of J^T J row by row, J^T r, the cost, and the cells that counted.
struct Totals {
    Wide h[most_unknowns * (most_unknowns + 1) / 2];
    Wide g[most_unknowns];
    Wide cost;
    std::uint32_t cells;
};
constexpr Totals operator+(Totals a, Totals const& b) noexcept
{
    for (std::uint32_t i = 0; i < most_unknowns * (most_unknowns + 1) / 2; ++i) a.h[i] = a.h[i] + b.h[i];
    for (std::uint32_t i = 0; i < most_unknowns; ++i) a.g[i] = a.g[i] + b.g[i];
    a.cost = a.cost + b.cost;
    a.cells += b.cells;
    return a;
}

/// The rules of the sums, which the host sends to every tile.
struct SumRules {
    float gain, offset;          ///< the residual of a colour is gain C + offset - target
    float huber_colour, huber_depth;
    float scene_depth;           ///< S: translations are in units of it
    float exposure_unit;         ///< times the columns of gain and offset, so that they are as large as the others
    float clip;                  ///< c: a row with an entry above it gets the weight (c / its largest entry)^2
    float h_scale, g_scale, cost_scale; ///< powers of two; a cell's sums times these are at most 2^23
};

/// Up to 16 cells in a row: for each of three colours and the depth, a residual and its derivatives, in units of S and radians. A field
/// is 0 where `counted` is.
struct CellRows {
    static constexpr std::uint32_t channels = 4, depth_channel = 3;
    float counted[block_width];                        ///< pixels of the cell that count
    float depth_counted[block_width];                  ///< those of them with a depth
    float residual[channels][block_width];
    float gained[3][block_width];                      ///< gain C: the derivative by the gain's logarithm
    float motion[channels][motions][block_width];
};
static_assert(sizeof(CellRows) == (2 + 4 + 3 + 24) * block_width * 4, "whole words");

/// The sums of up to five rows of cells, lane by lane.
struct LaneSums {
    static constexpr std::uint32_t fields = most_unknowns * (most_unknowns + 1) / 2 + most_unknowns + 1;
    std::int32_t field[fields][block_width];
    std::uint32_t cells;
};

namespace detail {
/// A number times a power of two, rounded to the nearest integer.
template <class A>
TILEMESH_KERNEL typename A::Word rounded(typename A::Real const& v, float scale) noexcept
{
    auto const scaled = v * scale;
    return A::truncate(scaled + A::select(scaled < A::all(0.0f), A::all(-0.5f), A::all(0.5f)));
}

/// Adds the rows of N cells with `Unknowns` unknowns.
template <class A, std::uint32_t Unknowns>
struct LaneRows {
    using Real = typename A::Real;
    static constexpr std::uint32_t entries = Unknowns * (Unknowns + 1) / 2;
    Real h[entries], g[Unknowns], cost;

    TILEMESH_KERNEL LaneRows() noexcept
    {
        for (auto& v : h) v = A::all(0.0f);
        for (auto& v : g) v = A::all(0.0f);
        cost = A::all(0.0f);
    }
    /// One row: Huber's weight, and the weight of a row beyond the clip. `counts`: the lanes that have this row.
    TILEMESH_KERNEL void add(Real const (&j)[Unknowns], Real const& residual, float huber, float clip, typename A::Mask const& counts) noexcept
    {
        add_all(j, residual, huber, clip, counts, std::make_integer_sequence<std::uint32_t, Unknowns>{});
    }

private:
    // The loops over unknowns are written out: GCC 12 keeps them as loops, whose sums are in memory.
    TILEMESH_KERNEL static void take_larger(Real& largest, Real const& v) noexcept
    {
        Real const size = A::magnitude(v);
        largest = A::select(size > largest, size, largest);
    }
    template <std::uint32_t I, std::uint32_t... K>
    TILEMESH_KERNEL void add_entries(Real const (&j)[Unknowns], Real const& residual, Real const& weight,
                                     std::integer_sequence<std::uint32_t, K...>) noexcept
    {
        Real const weighted = weight * j[I];
        g[I] = A::multiply_add(weighted, residual, g[I]);
        ((h[I * (I + 1) / 2 + K] = A::multiply_add(weighted, j[K], h[I * (I + 1) / 2 + K])), ...);
    }
    template <std::uint32_t... I>
    TILEMESH_KERNEL void add_all(Real const (&j)[Unknowns], Real const& residual, float huber, float clip, typename A::Mask const& counts,
                                 std::integer_sequence<std::uint32_t, I...>) noexcept
    {
        Real const zero = A::all(0.0f), one = A::all(1.0f), width = A::all(huber);
        Real const error = A::magnitude(residual);
        auto const inside = error <= width;
        Real weight = A::select(inside, one, width / error);
        Real const loss = A::select(inside, 0.5f * error * error, width * (error - 0.5f * width));
        Real largest = zero;
        (take_larger(largest, j[I]), ...);
        Real const share = A::all(clip) / largest;
        weight = A::select(largest > A::all(clip), weight * (share * share), weight);
        weight = A::select(counts, weight, zero);
        cost = cost + A::select(counts, loss, zero);
        (add_entries<I>(j, residual, weight, std::make_integer_sequence<std::uint32_t, I + 1>{}), ...);
    }
};
template <std::uint32_t N>
TILEMESH_KERNEL void add_words(std::int32_t* to, splat::detail::Words<N> const& v) noexcept
{
    splat::detail::store(to, splat::detail::Words<N>(splat::detail::load_words<N>(to) + v));
}

/// Adds the rows of 16 cells to the lanes' sums.
template <std::uint32_t Unknowns>
struct AddRows {
    template <class Set>
    TILEMESH_KERNEL static void run(CellRows const& rows, SumRules const& rules, LaneSums& sums) noexcept
    {
        using namespace splat::detail;
        constexpr std::uint32_t N = Set::most_lanes, channels = CellRows::channels;
        using A = FloatLanes<N>;
        for (std::uint32_t column = 0; column < block_width; column += N) {
            Words<N> const counts = load<N>(rows.counted + column) > 0.0f, deep = load<N>(rows.depth_counted + column) > 0.0f;
            if (!A::any(counts)) continue;
            LaneRows<A, Unknowns> lanes;
            for (std::uint32_t c = 0; c < channels; ++c) {
                bool const depth = c == CellRows::depth_channel;
                if (depth && !A::any(deep)) continue;
                Floats<N> j[Unknowns];
                for (std::uint32_t i = 0; i < motions; ++i) j[i] = load<N>(rows.motion[c][i] + column);
                if constexpr (Unknowns > motions) {
                    j[motions] = depth ? Floats<N>{} : Floats<N>(load<N>(rows.gained[c < 3 ? c : 0] + column) * rules.exposure_unit);
                    j[motions + 1] = broadcast<N>(depth ? 0.0f : rules.exposure_unit);
                }
                lanes.add(j, load<N>(rows.residual[c] + column), depth ? rules.huber_depth : rules.huber_colour, rules.clip,
                          depth ? deep : counts);
            }
            auto const most = A::all(1.0f / rules.cost_scale * 0x1p23f);
            lanes.cost = A::select(lanes.cost < most, lanes.cost, most);
            std::uint32_t at = 0;
            for (auto const& v : lanes.h) add_words<N>(sums.field[at++] + column, rounded<A>(v, rules.h_scale));
            for (auto const& v : lanes.g) add_words<N>(sums.field[at++] + column, rounded<A>(v, rules.g_scale));
            add_words<N>(sums.field[at] + column, rounded<A>(lanes.cost, rules.cost_scale));
            std::int32_t all[N];
            store(all, Words<N>(counts));
            for (std::int32_t one : all) sums.cells -= static_cast<std::uint32_t>(one);
        }
    }
};
} // namespace detail

/// Adds the lanes of at most five rows to the sums of a worker, and clears them. A lane is at most 5 * 2^23, so 16 of them fit into a word.
inline void take_sums(LaneSums& sums, std::uint32_t unknowns, Totals& totals) noexcept
{
    std::uint32_t const entries = unknowns * (unknowns + 1) / 2;
    for (std::uint32_t i = 0; i < entries + unknowns + 1; ++i) {
        std::int32_t sum = 0;
        for (std::uint32_t k = 0; k < block_width; ++k) sum += sums.field[i][k], sums.field[i][k] = 0;
        (i < entries ? totals.h[i] : i < entries + unknowns ? totals.g[i - entries] : totals.cost).add(sum);
    }
    totals.cells += sums.cells;
    sums.cells = 0;
}

}}} // namespace tilemesh::splat::pose
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
