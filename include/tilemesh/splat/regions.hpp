#pragma once
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/splat/footprint.hpp>

namespace tilemesh::splat {

/// What the host tells every tile at the start of a frame.
struct FrameParameters {
    static constexpr char const* name = "frame parameters";
    View view;
    Tiling tiling;
    std::uint32_t view_changed;  ///< 0: the view of the last frame, whose splats still hold
    std::uint32_t anew;          ///< 1: trust no neighbour to hold a copy (after a full storage lost some): send all again
    std::uint32_t readdress;     ///< 1: what is under way was addressed in another view (a bound cut the last frame)
};

// --- state of a tile; `S` is a Setup (setup.hpp), which gives the slots -----------------------------------------------------

/// The records a tile holds: Gaussians anchored here, and the copies that bloom brought. `Marks` and `Splats` go with it,
/// slot by slot.
template <class S>
struct Storage : Buffer<typename S::Record, S::storage_slots, Limited> {
    using Buffer<typename S::Record, S::storage_slots, Limited>::Buffer;
    static constexpr char const* name = "storage";
};

/// What a tile knows of a stored record.
struct Mark {
    GaussianId id;
    std::uint32_t bits;

    static constexpr std::uint32_t copy = 1u << 8;    ///< somebody else is the anchor
    static constexpr std::uint32_t leaving = 1u << 9; ///< anchored elsewhere now; goes as soon as there is room
    /// The neighbour on side d holds this record too: it was sent there, or came from there.
    static constexpr std::uint32_t shared(Direction d) noexcept { return 1u << index(d); }
    /// The neighbour on side d should have it, but the channel was full (`drop`).
    static constexpr std::uint32_t refused(Direction d) noexcept { return 16u << index(d); }
    bool is(std::uint32_t bit) const noexcept { return (bits & bit) != 0; }
};
/// The same where nothing routes or blooms: each record is anchored where it is.
struct AnchorMark {
    GaussianId id;
    static constexpr std::uint32_t bits = 0;
    bool is(std::uint32_t) const noexcept { return false; }
};
template <class S>
using MarkOf = std::conditional_t<S::routes || S::blooms, Mark, AnchorMark>;
template <class S>
struct Marks : Buffer<MarkOf<S>, S::storage_slots> {
    using Buffer<MarkOf<S>, S::storage_slots>::Buffer;
    static constexpr char const* name = "marks";
    static constexpr bool budgeted = S::lists_fit;
};

/// The projected records of this frame: the screen cache.
template <class S>
struct Splats : Buffer<Splat, S::storage_slots> {
    using Buffer<Splat, S::storage_slots>::Buffer;
    static constexpr char const* name = "projected records";
    static constexpr bool budgeted = S::lists_fit;
};

/// Depth order: the view depth's bits (all visible depths are positive, so bits order as floats do), then the id.
struct SortKey {
    std::uint32_t depth_bits;
    GaussianId id;
    std::uint32_t slot;
};
constexpr bool operator<(SortKey const& a, SortKey const& b) noexcept
{
    return a.depth_bits != b.depth_bits ? a.depth_bits < b.depth_bits : a.id < b.id;
}
template <class S>
struct Order : Buffer<SortKey, S::storage_slots> {
    using Buffer<SortKey, S::storage_slots>::Buffer;
    static constexpr char const* name = "sort keys";
    static constexpr bool budgeted = S::lists_fit;
};

/// The tile's slice of the picture, row by row of the tile's own rectangle; sized by the host when it sets the tiling.
template <class S>
struct Framebuffer : Buffer<typename S::Pixel, S::tile_pixels> {
    using Buffer<typename S::Pixel, S::tile_pixels>::Buffer;
    static constexpr char const* name = "framebuffer";
};

/// What a tile counts in a frame; Project begins it at zero. Exact on every engine.
struct Counts {
    static constexpr char const* name = "counters";
    std::uint32_t visible;       ///< anchored here or leaving, with something on screen
    std::uint32_t parked;        ///< nothing on screen: stays where it is
    std::uint32_t moved;         ///< anchored elsewhere since this frame
    std::uint32_t hops;          ///< records sent to a neighbour on their way to their anchor
    std::uint32_t channel_full;  ///< refusals: no slot in the channel; a record that waits three supersteps counts three
    std::uint32_t no_credit;     ///< refusals: a slot, but no room promised behind it
    std::uint32_t storage_full;  ///< anchored records that found no storage: unplaced (hold) or dropped
    std::uint32_t copies_full;   ///< copies that found no storage
    std::uint32_t copies_refused;///< copies that found no slot in the channel and were given up (drop)
    std::uint32_t projected;     ///< projections computed
};
static_assert(sizeof(Counts) <= 64, "small enough to lie beside the heads of a tile's lists");

/// Flow control's memory: see routing.hpp.
struct Traffic {
    static constexpr char const* name = "credits and flow control";
    std::uint32_t leaving;       ///< records in storage that wait to go
    std::uint32_t waiting;       ///< records in the FIFOs
    std::uint32_t sent[2];       ///< on the first leg's two sides, in the superstep before
};

/// Whether stored records may owe copies that were not sent yet.
struct Debts {
    static constexpr char const* name = "bloom debts";
    std::uint32_t open;
    std::uint32_t first;         ///< 1 until bloom has run once in this frame: mail is older than the view
};

/// Gaussian-pixel pairs, counted by each worker for itself; `blocks` in whole blocks, so that 32 bits hold any frame.
struct Work {
    static constexpr char const* name = "pair counters";
    static constexpr std::uint32_t max_workers = 6;
    std::uint32_t blocks[max_workers];
    std::uint32_t contributing[max_workers];
};

// --- channels ------------------------------------------------------------------------------------------------------------

/// A record with its anchor tile, computed once a frame: 64 bytes at degree 0.
template <class Record>
struct AddressedRecord {
    Record record;
    TileId anchor;
};
using Addressed = AddressedRecord<Gaussian>;
/// The projected form of a copy: 60 bytes, good for this frame's view only.
struct ScreenCopy {
    Splat splat;
    GaussianId id;
};
static_assert(sizeof(Addressed) == 64 && sizeof(ScreenCopy) == 60, "messages are whole records");

/// What routing and bloom send under a setup.
template <class S>
using RoadMessage = typename S::Addressing::template Message<typename S::Record>;
template <class S>
using BeamMessage = typename S::Copies::template Message<typename S::Record>;

/// Carries records to their anchor tiles.
template <class S>
struct Road : Channel<RoadMessage<S>, S::template slots<RoadMessage<S>>(S::road_bytes), typename S::ChannelRule> {
    static constexpr char const* name = "road";
};
/// Carries copies from a record's anchor tile to all tiles its footprint touches.
template <class S, bool Own = !S::one_channel_memory || !S::routes>
struct Beam : Channel<BeamMessage<S>, S::template slots<BeamMessage<S>>(S::beam_bytes), typename S::ChannelRule> {
    static constexpr char const* name = "beam";
};
/// The paper has one set of channels: routing is over when bloom begins.
template <class S>
struct Beam<S, false> : Beam<S, true> {
    using memory_of = Road<S>;
};

/// Records under way that arrived on the first leg and found no room ahead; one FIFO a side of that leg.
template <class S, std::uint32_t Side>
struct Waiting : Buffer<RoadMessage<S>, S::template slots<RoadMessage<S>>(S::waiting_bytes), Limited> {
    using Buffer<RoadMessage<S>, S::template slots<RoadMessage<S>>(S::waiting_bytes), Limited>::Buffer;
    static constexpr char const* name = Side == 0 ? "waiting (side 0)" : "waiting (side 1)";
};

namespace detail {
/// SRAM that one slot of storage takes, with what goes with it slot by slot.
template <class S>
constexpr std::uint32_t slot_bytes() noexcept
{
    return static_cast<std::uint32_t>(sizeof(typename S::Record) +
                                      (S::lists_fit ? sizeof(MarkOf<S>) + sizeof(Splat) + sizeof(SortKey) : 0));
}
} // namespace detail

// --- helpers that several kernels share ------------------------------------------------------------------------------------

inline constexpr std::uint32_t nowhere = 0xffffffffu;

/// The slot of record `id`, or `nowhere`.
template <class MarkList>
TILEMESH_KERNEL std::uint32_t find(MarkList const& marks, GaussianId id) noexcept
{
    for (std::uint32_t i = 0, n = marks.size(); i < n; ++i)
        if (marks[i].id == id) return i;
    return nowhere;
}

/// Takes slot i out of storage, marks and projected records.
template <class A, class B, class C>
TILEMESH_KERNEL void remove_slot(A& storage, B& marks, C& splats, std::uint32_t i) noexcept
{
    storage.swap_remove(i);
    marks.swap_remove(i);
    splats.swap_remove(i);
}

} // namespace tilemesh::splat
