// The smallest frame's kernels as one would write them who needs no more: one colour a record, one view, nothing that spans two tiles,
// no depth. No templates, no policies, no features; of the library only its plain records and the leaf functions that all kernels share.
#include <cstdint>
#include <tilemesh/splat/projection.hpp>
#include <tilemesh/splat/regions.hpp>

namespace by_hand {
using namespace tilemesh;
using namespace tilemesh::splat;

// Lists in a tile's memory: head[0] is the size.
struct Records {
    std::uint32_t capacity;
    std::uint32_t* head;
    Gaussian* items;
};
struct Marked {
    std::uint32_t* head;
    AnchorMark* items;
};
struct Projected {
    std::uint32_t* head;
    Splat* items;
};

inline void project_all(FrameParameters const& frame, Records const& storage, Projected const& splats, Counts& counts) noexcept
{
    Counts const before = counts;
    counts = Counts{};
    counts.copies = before.copies;
    counts.changes = before.changes;
    if (frame.view_changed == 0 && frame.anew == 0) {
        counts.visible = before.visible;
        counts.parked = before.parked;
        return;
    }
    std::uint32_t visible = 0, parked = 0;
    std::uint32_t const held = storage.head[0];
    for (std::uint32_t i = held; i-- > 0;) {
        Splat const s = project(storage.items[i], frame.view, frame.tiling);
        std::uint32_t const shows = s.visible() ? 1u : 0u;
        splats.items[i] = s;
        visible += shows;
        parked += 1u - shows;
    }
    counts.visible = visible;
    counts.parked = parked;
    counts.projected = held;
}
[[gnu::flatten]] void project_tile(Here const&, FrameParameters const& frame, Records& storage, Marked&, Projected& splats,
                                   Counts& counts) noexcept
{
    project_all(frame, storage, splats, counts);
}
} // namespace by_hand

TILEMESH_EXACT_BEGIN
namespace by_hand {
struct Block {
    float transmittance[4][16];
    float red[4][16];
    float green[4][16];
    float blue[4][16];
};

std::uint32_t blend(Block& block, Splat const& s, Model const& m, float const* xs, float const* ys, std::uint32_t column,
                    std::uint32_t row) noexcept
{
    PixelRect const rect = s.rect();
    std::uint32_t contributing = 0;
    for (std::uint32_t j = 0; j < 4; ++j) {
        if (row + j < rect.y0 || row + j >= rect.y1) continue;
        std::uint32_t hits = 0;
        for (std::uint32_t i = 0; i < 16; ++i) {
            float alpha = alpha_at(s, xs[i], ys[j]);
            alpha = alpha < m.alpha_max ? alpha : m.alpha_max;
            float const t = block.transmittance[j][i];
            bool const takes_part = (column + i >= rect.x0) & (column + i < rect.x1) & (alpha >= m.alpha_min) &
                                    (t >= m.transmittance_min);
            float const weight = takes_part ? alpha * t : 0.0f;
            block.red[j][i] = multiply_add(weight, s.colour[0], block.red[j][i]);
            block.green[j][i] = multiply_add(weight, s.colour[1], block.green[j][i]);
            block.blue[j][i] = multiply_add(weight, s.colour[2], block.blue[j][i]);
            block.transmittance[j][i] = t - weight;
            hits += takes_part ? 1 : 0;
        }
        contributing += hits;
    }
    return contributing;
}
} // namespace by_hand
TILEMESH_EXACT_END
