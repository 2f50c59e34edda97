#pragma once
#include <tilemesh/splat/harmonics.hpp>
#include <tilemesh/splat/regions.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// How kernels read the records of a tile. It depends on the type of the frame's parameters. This default is the machine's way: a tile
/// holds values and projects them. A host may specialise it for its own type of parameters (render/host_form.hpp).
template <class Parameters>
struct Access {
    /// The record projected into this frame's view: its entry of `Splats`.
    template <class Record>
    static Splat project(Record const& record, Parameters const& frame) noexcept
    {
        return splat::project(record, frame.view, frame.tiling);
    }
    /// The frame's parameters for a loop that writes words. A host form returns a copy: the compiler must assume that a write changes the
    /// addresses in them.
    TILEMESH_KERNEL static Parameters const& hold(Parameters const& frame) noexcept { return frame; }
    /// Tells the memory that a kernel is about to read a list. It does nothing on a machine of SRAM.
    template <class List>
    TILEMESH_KERNEL static void about_to_read(List const&) noexcept
    {
    }
    /// The splat of an entry of `Splats`, and the bits of its depth.
    TILEMESH_KERNEL static Splat const& splat_of(Parameters const&, Splat const& s) noexcept { return s; }
    TILEMESH_KERNEL static std::uint32_t depth_bits(Parameters const&, Splat const& s) noexcept
    {
        return __builtin_bit_cast(std::uint32_t, s.depth);
    }
    TILEMESH_KERNEL static Reach reach(Here const& here, Parameters const& frame, Splat const& s) noexcept
    {
        std::uint32_t sides = 0;
        for (Direction d : news)
            if (here.grid.has_neighbour(here.tile, d) && covers(s, frame.tiling, here.grid.neighbour(here.tile, d)))
                sides |= Mark::shared(d);
        return {s.anchor, s.visible(), covers(s, frame.tiling, here.tile), sides};
    }
    /// Does the entry's splat touch this tile?
    TILEMESH_KERNEL static bool is_here(Here const& here, Parameters const& frame, Splat const& s) noexcept
    {
        return covers(s, frame.tiling, here.tile);
    }
    /// The slot of the record that a message brings, or `no_slot`.
    template <class MarkList, class Message>
    TILEMESH_KERNEL static std::uint32_t slot_of(MarkList const& marks, Splat const*, Message const& message) noexcept
    {
        return find(marks, message.id);
    }
    /// Is there nothing to do for a slot with these mark bits, because its record touches the same tiles as in the last view? If so,
    /// `row_state` is 1 for a visible record. A tile that holds values cannot know without projecting the record, and says no.
    TILEMESH_KERNEL static bool is_settled(Parameters const&, Splat const&, std::uint32_t, std::uint32_t&) noexcept { return false; }
    /// Did an anchored record of this tile begin or cease to show on the tile? `covered`: it shows now.
    TILEMESH_KERNEL static bool coverage_changed(Here const& here, Parameters const& frame, Splat const& before, bool covered,
                                                 std::uint32_t, std::uint32_t) noexcept
    {
        return covers(before, frame.tiling, here.tile) != covered;
    }
    /// Bytes on the machine of a message of routing, and of bloom.
    template <class Message>
    static std::uint32_t road_bytes(Parameters const&) noexcept
    {
        return wire_bytes<Message>;
    }
    template <class Message>
    static std::uint32_t beam_bytes(Parameters const&) noexcept
    {
        return wire_bytes<Message>;
    }
};

/// How kernels of these policies read records.
template <class S>
using AccessOf = Access<typename S::Parameters>;

}}} // namespace tilemesh::splat
