// The library's counterpart of by_hand.cpp, cut to the smallest frame by the setup alone.
#include "setups.hpp"
#include <tilemesh/splat/frame_start.hpp>

namespace leave_out {
using namespace tilemesh;

[[gnu::flatten]] void project_tile(Here const& here, FrameParameters const& frame, Storage<minimal>& storage,
                                   Marks<minimal>& marks, Splats<minimal>& splats, Counts& counts) noexcept
{
    (void)splat::detail::begin_frame<minimal>(here, frame, storage, marks, splats, counts, {});
}
} // namespace leave_out
