#pragma once
#include <tilemesh/splat/harmonics.hpp>
#include <tilemesh/splat/regions.hpp>
#include <type_traits>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The splats of a tile in the order of the keys, as blending reads them. `Entry`: what the tile holds of each, a Splat or more.
template <class Entry>
struct SplatsInOrder {
    Entry const* splats;
    SortKey const* keys;
    TILEMESH_KERNEL Splat const& operator()(std::uint32_t i) const noexcept { return splats[keys[i].slot]; }
};

/// The held splats of a tile in the order of a list of key numbers.
template <class Entry>
struct HeldInOrder {
    Entry const* held;
    SortKey const* keys;
    std::uint32_t const* order;
    TILEMESH_KERNEL Splat const& operator()(std::uint32_t i) const noexcept { return held[keys[order[i]].slot]; }
};

/// The way in which kernels read the records of a tile. It depends on the type of the frame's parameters. This default is the way of the
/// machine: a tile holds values and projects them. A host may specialise it for its own type of parameters (splat/references.hpp).
///
/// A record of another type than the map's, as one in fewer bytes, has a member `id` and `sh_degree`. Kernels store it, send it and read
/// its id; all else they ask of `project`. A specialisation for a setup's own parameters makes it (`stored`) and projects it; the
/// parameters hold what all records share. See `stores_own_form`.
template <class Parameters>
struct Access {
    /// Returns the record projected into this frame's view. The result is an entry of `Splats`.
    template <class Record>
    static Splat project(Record const& record, Parameters const& frame) noexcept
    {
        return splat::project<OpticsOf<Parameters>>(record, frame.view, frame.tiling);
    }
    /// Is the entry of a stored record the same in every view?
    static constexpr bool entries_last = false;
    /// Is there a host's shortcut? The kernels of homes then take it, with the same words.
    static constexpr bool on_host = false;
    /// Returns the frame's parameters for a loop that writes words. A host form returns a copy; without it the compiler would have to
    /// assume that a write changes the addresses in the parameters.
    TILEMESH_KERNEL static Parameters const& hold(Parameters const& frame) noexcept { return frame; }
    /// Tells the memory that a kernel will read a list soon. It does nothing on a machine of SRAM.
    template <class List>
    TILEMESH_KERNEL static void about_to_read(List const&) noexcept
    {
    }
    /// Tells the memory that a kernel will ask for an entry's reach soon.
    TILEMESH_KERNEL static void about_to_reach(Parameters const&, Splat const&) noexcept {}
    /// Tells the memory that a kernel will change this mark soon.
    template <class M>
    TILEMESH_KERNEL static void about_to_change(M const&) noexcept
    {
    }
    /// Tells the memory that a kernel will ask for the depth of an entry soon.
    TILEMESH_KERNEL static void about_to_order(Parameters const&, Splat const&) noexcept {}
    /// Tells the memory that a kernel will send this record, and ask for the reach of its entry. `about_to_find`: that it will look for a
    /// message's record; `about_to_take`: that it will also ask for the reach of this record.
    template <class Record>
    TILEMESH_KERNEL static void about_to_send(Parameters const&, Splat const&, Record const&) noexcept
    {
    }
    template <class Message>
    TILEMESH_KERNEL static void about_to_find(Parameters const&, Message const&) noexcept
    {
    }
    template <class Message>
    TILEMESH_KERNEL static void about_to_take(Parameters const&, Message const&) noexcept
    {
    }
    /// Returns the splat of an entry of `Splats`. `depth_key` returns the key of its depth.
    TILEMESH_KERNEL static Splat const& splat_of(Parameters const&, Splat const& s) noexcept { return s; }
    /// Returns a function object for blending: called with i, it returns the splat of `keys[i]`.
    template <class Entry>
    TILEMESH_KERNEL static SplatsInOrder<Entry> in_order(Parameters const&, Entry const* splats, SortKey const* keys) noexcept
    {
        return {splats, keys};
    }
    template <class Entry>
    TILEMESH_KERNEL static HeldInOrder<Entry> in_order(Parameters const&, Entry const* held, SortKey const* keys,
                                                       std::uint32_t const* order) noexcept
    {
        return {held, keys, order};
    }
    TILEMESH_KERNEL static std::uint32_t depth_key(Parameters const&, Splat const& s) noexcept
    {
        return s.depth_key;
    }
    TILEMESH_KERNEL static Reach reach(Here const& here, Parameters const& frame, Splat const& s) noexcept
    {
        std::uint32_t sides = 0;
        for (Direction d : news)
            if (here.grid.has_neighbour(here.tile, d) && covers(s, frame.tiling, here.grid.neighbour(here.tile, d)))
                sides |= Mark::shared(d);
        return {s.anchor, s.visible(), covers(s, frame.tiling, here.tile), sides};
    }
    /// The anchor of a visible entry.
    TILEMESH_KERNEL static TileId anchor_of(Parameters const&, Splat const& s) noexcept { return s.anchor; }
    /// Does the entry's splat touch this tile?
    TILEMESH_KERNEL static bool is_here(Here const& here, Parameters const& frame, Splat const& s) noexcept
    {
        return covers(s, frame.tiling, here.tile);
    }
    /// Finds the records that messages bring among those of the tile, in one pass of a kernel.
    class Lookup {
    public:
        /// Returns the slot of the message's record, or `no_slot`.
        template <class MarkList, class Message>
        TILEMESH_KERNEL std::uint32_t slot_of(Here const&, Parameters const&, MarkList const& marks, Splat const*,
                                              Message const& message) noexcept
        {
            return find(marks, message.id);
        }
        /// The kernel adds this entry to the tile's records.
        TILEMESH_KERNEL void add(Splat const&) noexcept {}
    };
    /// Is there nothing to do for a slot with these mark bits, because its record touches the same tiles as in the last view? If yes,
    /// `row_state` is 1 for a visible record. A tile that holds values would have to project the record to know this, so it answers no.
    TILEMESH_KERNEL static bool is_settled(Parameters const&, Splat const&, std::uint32_t, std::uint32_t&) noexcept { return false; }
    /// Does the host know what moved since the last view, and did no frame leave records under way? Then `moved` is 1 for a record that
    /// touches other tiles or has another anchor, otherwise 0; and `was_visible` says whether it was visible. `visible`: it is now.
    TILEMESH_KERNEL static constexpr bool knows_what_moved(Parameters const&) noexcept { return false; }
    TILEMESH_KERNEL static std::uint32_t moved(Parameters const&, Splat const&) noexcept { return 1; }
    TILEMESH_KERNEL static std::uint32_t was_visible(Parameters const&, Splat const&, std::uint32_t visible) noexcept { return visible; }
    /// May an anchored record have begun or ceased to touch this tile? `covered`: it touches the tile now.
    TILEMESH_KERNEL static bool coverage_changed(Here const& here, Parameters const& frame, Splat const& before, bool covered,
                                                 std::uint32_t) noexcept
    {
        return covers(before, frame.tiling, here.tile) != covered;
    }
    /// Tells the host that the list of the tile's splats changed. `keeps_pixels`: is the tile's slice of the picture the one that it would
    /// composite? The machine does not remember this: it composites every tile in every frame.
    TILEMESH_KERNEL static void list_changed(Here const&, Parameters const&) noexcept {}
    TILEMESH_KERNEL static bool keeps_pixels(Here const&, Parameters const&) noexcept { return false; }
    /// The bytes of one message of routing on the machine. `beam_bytes`: those of one message of bloom.
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

/// The way in which kernels of these policies read records.
template <class S>
using AccessOf = Access<typename S::Parameters>;

/// Do tiles store a form of their own of the map's records? Then `Access<Parameters>::stored<Record>(Gaussian const&, Parameters const&)`
/// makes it when the host loads a record, and `FrameRenderer::begin_with` sets the parameters for that. A record without an id says that
/// the form has no place for that Gaussian.
template <class S, class = void>
inline constexpr bool stores_own_form = false;
template <class S>
inline constexpr bool stores_own_form<S, std::void_t<decltype(AccessOf<S>::template stored<typename S::Record>(
                                             std::declval<Gaussian const&>(), std::declval<typename S::Parameters const&>()))>> = true;

}}} // namespace tilemesh::splat
