#pragma once
#include <limits>
#include <tilemesh/splat/pose/blend.hpp>
#include <tilemesh/splat/pose/sums.hpp>
#include <tilemesh/splat/target_pixel.hpp>

/// Blended pixels with their derivatives to the rows of a least-squares problem: residuals against a target, averaged over cells.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // the functions are always inlined, so it does not matter how a wide vector is passed
namespace tilemesh { inline namespace v0_2 { namespace splat::pose {

using splat::TargetPixel;
/// A pixel counts if its splats cover it by more than this share. Where a target has a depth, residuals of the depth count too.
inline constexpr float least_coverage = 0.5f;

namespace detail {
/// A row of a block's targets: three colours, depth. Pixels outside the tile are NaN, so that they do not count.
struct TargetRow {
    float field[4][block_width];
};

/// The rows of the pixels of a MovingRow.
template <bool Depth>
struct MakeRows {
    template <class Set>
    TILEMESH_KERNEL static void run(MovingRow const& row, TargetRow const& target, float const (&background)[3], SumRules const& rules, bool by_angle,
                                    CellRows& rows) noexcept
    {
        using namespace splat::detail;
        constexpr std::uint32_t N = Set::most_lanes;
        using A = FloatLanes<N>;
        Floats<N> const zero{}, one = broadcast<N>(1.0f), most = broadcast<N>(1e18f);
        for (std::uint32_t column = 0; column < block_width; column += N) {
            auto const p = load_pixels<N>(row, column, Depth);
            Floats<N> const through = A::magnitude(p.t), weight = one - through;
            Words<N> counts = weight > least_coverage;
            Floats<N> residual[3], gained[3], motion[3][motions];
            for (std::uint32_t c = 0; c < 3; ++c) {
                gained[c] = rules.gain * multiply_add_lanes<N>(through, broadcast<N>(background[c]), p.colour[c]);
                residual[c] = gained[c] + rules.offset - load<N>(target.field[c] + column);
                counts &= A::magnitude(residual[c]) < most; // false for NaN
                for (std::uint32_t j = 0; j < motions; ++j) {
                    motion[c][j] = rules.gain * multiply_add_lanes<N>(p.dt[j], broadcast<N>(background[c]), p.dcolour[c][j]);
                    if (j < 3) motion[c][j] = motion[c][j] * rules.scene_depth;
                    counts &= A::magnitude(motion[c][j]) < most;
                }
            }
            for (std::uint32_t c = 0; c < 3; ++c) {
                store(rows.residual[c] + column, A::select(counts, residual[c], zero));
                store(rows.gained[c] + column, A::select(counts, gained[c], zero));
                for (std::uint32_t j = 0; j < motions; ++j) store(rows.motion[c][j] + column, A::select(counts, motion[c][j], zero));
            }
            store(rows.counted + column, A::select(counts, one, zero));
            if constexpr (Depth) {
                Floats<N> const seen = load<N>(target.field[3] + column), depth = p.z / weight, off = (depth - seen) / seen;
                Words<N> deep = counts & (seen > 0.0f) & (A::magnitude(off) < most);
                Floats<N> moves[motions] = {depth_motion<0>(p, weight, depth, by_angle), depth_motion<1>(p, weight, depth, by_angle),
                                            depth_motion<2>(p, weight, depth, by_angle), depth_motion<3>(p, weight, depth, by_angle),
                                            depth_motion<4>(p, weight, depth, by_angle), depth_motion<5>(p, weight, depth, by_angle)};
                for (std::uint32_t j = 0; j < motions; ++j) {
                    moves[j] = moves[j] / seen;
                    if (j < 3) moves[j] = moves[j] * rules.scene_depth;
                    deep &= A::magnitude(moves[j]) < most;
                }
                store(rows.residual[CellRows::depth_channel] + column, A::select(deep, off, zero));
                for (std::uint32_t j = 0; j < motions; ++j)
                    store(rows.motion[CellRows::depth_channel][j] + column, A::select(deep, moves[j], zero));
                store(rows.depth_counted + column, A::select(deep, one, zero));
            }
        }
    }
};
} // namespace detail

/// The cells of a column of blocks in progress. Cells are 2 x 2, 4 x 4 or 8 x 8 pixels of the frame's grid.
struct OpenCells {
    CellRows sum; ///< lane i: the sum over the pixels of cell i of the column, so far

    /// Adds a row of pixels: each cell adds its pixels from left to right.
    void add(CellRows const& rows, std::uint32_t cell) noexcept
    {
        if (cell == 2) add_by<2>(rows);
        else if (cell == 4) add_by<4>(rows);
        else add_by<8>(rows);
    }
    /// Makes means of the sums: over the pixels that count, and for the depth over those with a depth. A cell has a depth if more than half
    /// of its pixels that count have one.
    void close() noexcept
    {
        for (std::uint32_t i = 0; i < block_width; ++i) {
            float const n = sum.counted[i], deep = sum.depth_counted[i];
            float const share = n > 0 ? 1.0f / n : 0.0f, deep_share = 2 * deep > n ? 1.0f / deep : 0.0f;
            for (std::uint32_t c = 0; c < CellRows::channels; ++c) {
                float const by = c == CellRows::depth_channel ? deep_share : share;
                sum.residual[c][i] *= by;
                if (c < 3) sum.gained[c][i] *= by;
                for (auto& column : sum.motion[c]) column[i] *= by;
            }
            sum.counted[i] = n > 0 ? 1.0f : 0.0f;
            sum.depth_counted[i] = deep_share > 0 ? 1.0f : 0.0f;
        }
    }
    void clear() noexcept { sum = {}; }

private:
    template <std::uint32_t Cell>
    void add_by(CellRows const& rows) noexcept
    {
        static_assert(sizeof(CellRows) % (block_width * sizeof(float)) == 0, "fields of one lane a pixel");
        auto const* const from = rows.counted;
        float* const to = sum.counted;
        constexpr std::uint32_t fields = sizeof(CellRows) / (block_width * sizeof(float)), cells = block_width / Cell;
        for (std::uint32_t f = 0; f < fields; ++f) {
            float sums[cells];
            for (std::uint32_t i = 0; i < cells; ++i) sums[i] = to[f * block_width + i];
            for (std::uint32_t k = 0; k < Cell; ++k)
                for (std::uint32_t i = 0; i < cells; ++i) sums[i] += from[f * block_width + i * Cell + k];
            for (std::uint32_t i = 0; i < cells; ++i) to[f * block_width + i] = sums[i];
        }
    }
};

}}} // namespace tilemesh::splat::pose
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
