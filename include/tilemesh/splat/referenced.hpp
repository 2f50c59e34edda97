#pragma once
#include <tilemesh/splat/regions.hpp>

/// The host's form of a setup in which tiles and channels hold references instead of records.
///
/// The machine moves values: records of 60 bytes and more, each tile projects its own. A host that simulates it has one memory,
/// and may keep one instance of a record, project it once a view, and move its row. The same kernels run on both forms; the
/// capacities in slots, the bytes on the wire, every counter and every bit of the picture are those of the values. The ledger
/// is that of the values too: ask `Tile<Machine, Frame<S>>` of S, not of `Referenced<S>`.
namespace tilemesh::splat {

/// A record's place in the host's table, with its id.
template <class Record>
struct Reference {
    static constexpr std::uint32_t sh_degree = Record::sh_degree;
    static constexpr std::uint32_t wire_bytes = sizeof(Record);
    GaussianId id;
    std::uint32_t row;
};
/// And of a projected copy (ScreenCopies).
template <class Record>
struct ScreenReference : Reference<Record> {
    static constexpr std::uint32_t wire_bytes = sizeof(ScreenCopy);
};
/// What ScreenCopies send for a record of this type.
template <class Record>
struct ScreenCopyOf {
    using type = ScreenCopy;
};
template <class Record>
struct ScreenCopyOf<Reference<Record>> {
    using type = ScreenReference<Record>;
};

/// An entry of `Splats`: a row of the host's table.
struct SplatRow {
    std::uint32_t row;
};

/// An address in the host's memory, as words of a broadcast.
template <class T>
class HostPointer {
public:
    HostPointer() noexcept = default;
    explicit HostPointer(T const* p) noexcept { __builtin_memcpy(words_, &p, sizeof p); }
    TILEMESH_KERNEL T const* get() const noexcept
    {
        T const* p;
        __builtin_memcpy(&p, words_, sizeof words_);
        return p;
    }

private:
    std::uint32_t words_[sizeof(T const*) / 4] = {};
};

/// What a new view changed for a record, as far as tiles must know. A byte, so that the table of a whole map stays in the
/// processor's nearest caches.
struct Standing {
    static constexpr std::uint8_t visible = 1;
    static constexpr std::uint8_t moved = 2;    ///< other tiles than in the last view, another anchor, or put on the mesh by the host
    static constexpr std::uint8_t appeared = 4; ///< or disappeared
};

/// The tiles that a record touches in a view, first to last, and its anchor.
struct Touched {
    TileId first, last, anchor;
    std::uint32_t visible; ///< 0 or 1
};

/// The frame's parameters, and the host's table of this view, by rows.
struct ReferencedParameters : FrameParameters {
    static constexpr char const* name = "frame parameters and references";
    HostPointer<Splat> splats;
    HostPointer<Touched> touched;
    HostPointer<std::uint8_t> standings;
    HostPointer<std::uint32_t> depths;     ///< bits
};

template <class Record>
TILEMESH_KERNEL SplatRow projected(Reference<Record> const& g, ReferencedParameters const&) noexcept
{
    return {g.row};
}
TILEMESH_KERNEL ReferencedParameters at_hand(ReferencedParameters const& frame) noexcept
{
    return frame;
}
/// A host asks for all of its cache lines at once: the lists of a tile are short and far from those of the tile before, and one
/// line after the other would cost as many waits.
template <class List>
TILEMESH_KERNEL void about_to_read(ReferencedParameters const&, List const& list) noexcept
{
    constexpr std::uint32_t items_a_line = 64 / sizeof(typename List::value_type);
    for (std::uint32_t i = 0, n = list.size(); i < n; i += items_a_line) __builtin_prefetch(list.begin() + i);
}
TILEMESH_KERNEL Splat const& look(ReferencedParameters const& frame, SplatRow s) noexcept
{
    return frame.splats.get()[s.row];
}
TILEMESH_KERNEL std::uint32_t depth_bits(ReferencedParameters const& frame, SplatRow s) noexcept
{
    return frame.depths.get()[s.row];
}

/// By its row: four bytes a slot to look at instead of eight.
template <class MarkList, class Record>
std::uint32_t find(MarkList const& marks, ReferencedParameters const&, SplatRow const* splats, Reference<Record> const& message) noexcept
{
    return detail::first_of(splats, marks.size(), [row = message.row](SplatRow s) noexcept { return s.row == row; });
}
TILEMESH_KERNEL Reach reach(Here const& here, ReferencedParameters const& frame, SplatRow s) noexcept
{
    Touched const& t = frame.touched.get()[s.row];
    // A range lies in the grid, so that a side beyond the grid's edge is in none.
    std::uint32_t const x = here.tile.x() - t.first.x(), columns = t.last.x() - t.first.x();
    std::uint32_t const y = here.tile.y() - t.first.y(), rows = t.last.y() - t.first.y();
    auto const bit = [](bool yes) noexcept { return yes ? 1u : 0u; };
    std::uint32_t const in_x = bit(x <= columns) & t.visible, in_y = bit(y <= rows) & t.visible;
    std::uint32_t const sides = (in_x & bit(y - 1 <= rows)) << index(Direction::north) |
                                (in_y & bit(x + 1 <= columns)) << index(Direction::east) |
                                (in_y & bit(x - 1 <= columns)) << index(Direction::west) |
                                (in_x & bit(y + 1 <= rows)) << index(Direction::south);
    return {t.anchor, t.visible != 0, (in_x & in_y) != 0, sides};
}
TILEMESH_KERNEL bool is_here(Here const& here, ReferencedParameters const& frame, SplatRow s) noexcept
{
    return reach(here, frame, s).here;
}

/// Setup S by reference. Its channels and lists have the slots of S, whatever the policies and pixels.
template <class S>
struct Referenced : S {
    using Value = S;
    using Record = Reference<typename S::Record>;
    using Projected = SplatRow;
    using Parameters = ReferencedParameters;
};

/// The setup whose machine S simulates: S itself, or what is referenced.
template <class S>
struct ValueOf {
    using type = S;
    static constexpr bool referenced = false;
};
template <class S>
struct ValueOf<Referenced<S>> {
    using type = S;
    static constexpr bool referenced = true;
};

} // namespace tilemesh::splat
