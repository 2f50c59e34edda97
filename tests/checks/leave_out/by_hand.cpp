// The smallest frame's projection as one would write it who needs no more: one colour a record, one view, nothing that spans two tiles. No templates, no policies, no features; of the library only its plain records and the leaf functions that all kernels share.
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

inline void project_records(FrameParameters const& frame, Records const& storage, Projected const& splats, Counts& counts) noexcept
{
    Counts const before = counts;
    counts = Counts{};
    counts.copies = before.copies;
    counts.changes = before.changes;
    if (frame.view_changed == 0 && frame.resend_copies == 0) {
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
    project_records(frame, storage, splats, counts);
}
} // namespace by_hand
