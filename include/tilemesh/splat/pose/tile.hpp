#pragma once
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/splat/blending.hpp>
#include <tilemesh/splat/pose/rows.hpp>

/// The forward evaluation of a tile: it blends the tile's splats with their derivatives and adds up the rows of its pixels.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat::pose {

/// What an evaluation computes.
struct Tracking {
    static constexpr char const* name = "tracking parameters";
    std::uint32_t forward;   ///< 1: forward mode; 0: gradients
    std::uint32_t gradients; ///< 1: gradients of the picture; 2: their mean with those of the target (ESM); 0: forward mode
    std::uint32_t cell;      ///< 1, 2, 4 or 8 pixels; it divides the tile
    std::uint32_t with_depth;
    std::uint32_t unknowns;  ///< 6, or 8 with exposure
    std::uint32_t one_in;    ///< the share of blocks that is evaluated: one in so many
    std::uint32_t seed;      ///< chooses the blocks
    SumRules sums;
};

/// Is this block of the frame evaluated? Blocks are 16 pixels wide. They are 5 high, and `cell` times higher where pixels form cells, so
/// that a block holds whole cells. The choice depends on the frame's grid only.
TILEMESH_KERNEL bool is_chosen(Tracking const& t, std::uint32_t column, std::uint32_t row) noexcept
{
    if (t.one_in <= 1) return true;
    std::uint32_t h = (row / (block_height * t.cell) * 4096u + column / block_width) * 2654435761u ^ t.seed * 0x9e3779b9u;
    h = (h ^ h >> 16) * 0x7feb352du; // the mixing function lowbias32 (Wellons)
    h = (h ^ h >> 15) * 0x846ca68bu;
    return (h ^ h >> 16) % t.one_in == 0;
}

/// The memory of a worker while it evaluates, besides its stack. `Group` parts of blocks are open at once; a part has `Rows` rows.
template <std::uint32_t Group, std::uint32_t Rows>
struct Workspace {
    MovingRow rows[Group][Rows];
    CellRows made;
    OpenCells cells;
    LaneSums sums;
};

/// Where the sums and the contributing pairs of `count` workers go: block i, or with cells column i of blocks, belongs to worker i % count.
struct WorkerSums {
    Totals* totals;
    std::uint32_t* contributing;
    std::uint32_t count;
};

namespace detail {
/// A part of a block in progress.
struct OpenPart {
    splat::detail::BlockPlace at;
    PixelRect live;       ///< the part's pixels that lie in the tile
    std::uint32_t first;  ///< its first row in the block
    std::uint32_t share;  ///< the place in WorkerSums
    bool done;
};
template <std::uint32_t Rows>
void begin_part(OpenPart& part, MovingRow (&rows)[Rows], std::uint32_t column, std::uint32_t row, std::uint32_t first, PixelRect const& tile,
                Camera const& camera) noexcept
{
    part.at.column = static_cast<std::int32_t>(column);
    part.at.row = static_cast<std::int32_t>(row);
    for (std::uint32_t i = 0; i < block_width; ++i) part.at.xs[i] = static_cast<float>(column + i) + 0.5f - camera.cx;
    for (std::uint32_t j = 0; j < block_height; ++j) part.at.ys[j] = static_cast<float>(row + j) + 0.5f - camera.cy;
    std::uint32_t const y0 = row + first, y1 = y0 + Rows;
    part.live = {column > tile.x0 ? column : tile.x0, column + block_width < tile.x1 ? column + block_width : tile.x1, y0 > tile.y0 ? y0 : tile.y0,
                 y1 < tile.y1 ? y1 : tile.y1};
    part.first = first;
    part.done = false;
    for (std::uint32_t k = 0; k < Rows; ++k) {
        rows[k] = {};
        for (std::uint32_t i = 0; i < block_width; ++i) // dead lanes are below every limit
            rows[k].field[0][i] = y0 + k >= part.live.y0 && y0 + k < part.live.y1 && column + i >= part.live.x0 && column + i < part.live.x1 ? 1.0f
                                                                                                                                     : -1.0f;
    }
}
template <std::uint32_t Rows>
bool all_stopped(MovingRow const (&rows)[Rows], float transmittance_min) noexcept
{
    std::uint32_t going = 0;
    for (auto const& row : rows)
        for (float t : row.field[0]) going |= t >= transmittance_min ? 1u : 0u;
    return going == 0;
}

template <bool Depth, class Stop, std::uint32_t N, std::uint32_t Group, std::uint32_t Rows, std::uint32_t Size, class SplatAt, class TermsAt>
void evaluate_by(PixelRect const& tile, View const& view, Tracking const& tracking, std::uint32_t n, SplatAt const& at,
                      TermsAt const& terms_at, TargetPixel const* target, Workspace<Group, Rows>& work, WorkerSums const& shares,
                      Worker worker) noexcept
{
    using namespace splat::detail;
    static_assert(block_height % Rows == 0, "a part is whole rows, and all parts of a block are alike");
    SetOf<N> const set{};
    Rules const& rules = view.rules;
    OpenPart parts[Group];
    MovingChunk<Size> chunk;
    std::uint32_t hits[Size + SetOf<N>::most_lanes];
    std::uint32_t const left = tile.x0 / block_width * block_width, top = tile.y0 / block_height * block_height;
    std::uint32_t const across = (tile.x1 - left + block_width - 1) / block_width, down = (tile.y1 - top + block_height - 1) / block_height;
    constexpr std::uint32_t parts_a_block = block_height / Rows;
    bool const cells = tracking.cell > 1, by_angle = view.camera.lens.kind == LensKind::fisheye;
    work.cells.clear();
    work.made = {};
    work.sums = {};

    // Parts go down one column of blocks after the other, so that cells close in order. With cells, a worker takes whole columns.
    std::uint32_t const most = across * down * parts_a_block;
    for (std::uint32_t next = 0; next < most;) {
        std::uint32_t open = 0;
        for (; open < Group && next < most; ++next) {
            std::uint32_t const block = next / parts_a_block, column = left + block / down * block_width, row = top + block % down * block_height;
            std::uint32_t const share = cells ? block / down : block;
            if (share % worker.count != worker.index || !is_chosen(tracking, column, row + next % parts_a_block * Rows)) continue;
            parts[open].share = share % shares.count;
            begin_part(parts[open], work.rows[open], column, row, next % parts_a_block * Rows, tile, view.camera);
            if (parts[open].live.y0 < parts[open].live.y1) ++open;
        }
        std::uint32_t going = open;
        for (std::uint32_t begin = 0; begin < n && going != 0; begin += Size) {
            std::uint32_t const taken = fill(set, chunk, begin, n, at);
            for (std::uint32_t i = 0; i < (taken + set.lanes() - 1) / set.lanes() * set.lanes(); ++i) {
                Terms const& terms = terms_at(begin + (i < taken ? i : 0));
                chunk.along_depth[i] = terms.along_depth;
                chunk.across_depth[i] = terms.across_depth;
            }
            set.template call<CompleteMotions>(chunk, taken, view);
            for (std::uint32_t b = 0; b < open; ++b) {
                auto& part = parts[b];
                if (part.done) continue;
                std::uint32_t const count = set.template call<ListHits>(chunk, taken, part.at, &hits[0]);
                // rows outside the tile have no pixel that blends
                std::uint32_t const first_row = static_cast<std::uint32_t>(part.at.row) + part.first;
                for (std::uint32_t k = part.live.y0 - first_row; k < part.live.y1 - first_row; ++k)
                    shares.contributing[part.share] += set.template call<BlendMovingRow<Depth, Stop>>(work.rows[b][k], chunk, &hits[0], count,
                                                                                                      part.at, part.first + k, rules);
                if (all_stopped(work.rows[b], rules.transmittance_min)) part.done = true, --going;
            }
        }
        for (std::uint32_t b = 0; b < open; ++b) {
            auto const& part = parts[b];
            for (std::uint32_t y = part.live.y0; y < part.live.y1; ++y) {
                auto const x0 = static_cast<std::uint32_t>(part.at.column);
                float const nan = std::numeric_limits<float>::quiet_NaN();
                TargetRow seen;
                for (std::uint32_t i = 0; i < block_width; ++i) {
                    bool const in = x0 + i >= part.live.x0 && x0 + i < part.live.x1;
                    TargetPixel const none{{nan, nan, nan}, 0};
                    TargetPixel const& pixel = in ? target[(y - tile.y0) * (tile.x1 - tile.x0) + x0 + i - tile.x0] : none;
                    for (std::uint32_t c = 0; c < 3; ++c) seen.field[c][i] = pixel.rgb[c];
                    seen.field[3][i] = pixel.depth;
                }
                auto const& row = work.rows[b][y - static_cast<std::uint32_t>(part.at.row) - part.first];
                set.template call<MakeRows<Depth>>(row, seen, rules.background, tracking.sums, by_angle, work.made);
                CellRows const* finished = &work.made;
                if (cells) {
                    work.cells.add(work.made, tracking.cell);
                    if ((y + 1) % tracking.cell != 0 && y + 1 != tile.y1) continue;
                    work.cells.close();
                    finished = &work.cells.sum;
                }
                if (tracking.unknowns > motions)
                    set.template call<AddRows<most_unknowns>>(*finished, tracking.sums, work.sums);
                else
                    set.template call<AddRows<motions>>(*finished, tracking.sums, work.sums);
                if (cells) work.cells.clear();
            }
            take_sums(work.sums, tracking.unknowns, shares.totals[part.share]);
        }
    }
}
} // namespace detail

/// Evaluates n splats, `at(0)` to `at(n - 1)` from front to back with the derivatives' words `terms_at(i)`, against the targets of a tile's
/// pixels, row by row of its rectangle. It adds the sums of the rows and the pairs that contributed to `shares`. `worker` takes every
/// count-th block, or with cells every count-th column of blocks. Colours, depths and pairs are those of `precise` blending.
///
/// The bits of the sums depend on the frame, the splats and the target only. Cost: 5 rows of 16 pixels for each splat that a block may see,
/// at about 100 operations for a row that it shows in; the workspace; 4 KiB of stack.
template <std::uint32_t Lanes, std::uint32_t Size, std::uint32_t Group, std::uint32_t Rows, class SplatAt, class TermsAt>
void evaluate_tile(PixelRect const& tile, View const& view, Tracking const& tracking, std::uint32_t n, SplatAt const& at,
                   TermsAt const& terms_at, TargetPixel const* target, Workspace<Group, Rows>& work, WorkerSums const& shares,
                   Worker worker) noexcept
{
    if (tile.empty()) return;
    auto const with = [&](auto depth, auto stop) noexcept {
        detail::evaluate_by<decltype(depth)::value, decltype(stop), Lanes, Group, Rows, Size>(tile, view, tracking, n, at, terms_at, target, work,
                                                                                          shares, worker);
    };
    bool const after = view.rules.stop == Stop::after_crossing;
    if (tracking.with_depth != 0)
        after ? with(std::true_type{}, splat::detail::StopEachPixel{}) : with(std::true_type{}, splat::detail::StopBeforeCrossing{});
    else
        after ? with(std::false_type{}, splat::detail::StopEachPixel{}) : with(std::false_type{}, splat::detail::StopBeforeCrossing{});
}

}}} // namespace tilemesh::splat::pose
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
