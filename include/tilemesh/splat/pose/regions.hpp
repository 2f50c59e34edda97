#pragma once
#include <tilemesh/splat/pose/tile.hpp>
#include <tilemesh/splat/regions.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat::pose {

/// Does a host run the program, so that a worker's memory may lie on its thread's stack? The machine's workers need a region for it.
template <class Parameters>
inline constexpr bool has_host_stack = false;

namespace region {
template <class P>
struct Target : Buffer<TargetPixel> {
    static constexpr char const* name = "target";
    static constexpr auto slots = &Sizes::tile_pixels;
};
} // namespace region
/// The tile's slice of the target picture, row by row of the tile's own rectangle. The host writes it.
template <class S>
using Target = region::Target<PoliciesOf<S>>;

/// The memory of the workers, one row of a block each.
struct Workspaces {
    static constexpr char const* name = "forward mode workspaces";
    Workspace<1, 1> of[Work::max_workers];
};
/// The sums of a tile, by workers.
struct TileTotals {
    static constexpr char const* name = "sums by workers";
    Totals of[Work::max_workers];
};
}}} // namespace tilemesh::splat::pose
