// EXPECT: this routing rule is not dimension-ordered
#include "source.hpp"
#include <tilemesh/splat/frame_program.hpp>

// Along the longer way first: it changes from columns to rows and back.
struct LongestFirst {
    static constexpr char const* name = "longest_first";
    static constexpr tilemesh::Direction first_leg[2] = {tilemesh::Direction::west, tilemesh::Direction::east};
    static constexpr tilemesh::Direction towards(tilemesh::TileId from, tilemesh::TileId to) noexcept
    {
        auto const columns = to.x() > from.x() ? to.x() - from.x() : from.x() - to.x();
        auto const rows = to.y() > from.y() ? to.y() - from.y() : from.y() - to.y();
        if (columns > rows) return to.x() > from.x() ? tilemesh::Direction::east : tilemesh::Direction::west;
        return to.y() > from.y() ? tilemesh::Direction::south : tilemesh::Direction::north;
    }
};
struct Setup : tilemesh::splat::Lossless {
    using Routing = LongestFirst;
};

tilemesh::Vote run(Source& source)
{
    return tilemesh::run_kernel<tilemesh::splat::Route<Setup>>(source);
}
