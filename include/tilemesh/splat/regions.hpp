#pragma once
#include <tilemesh/splat/footprint.hpp>
#include <tilemesh/splat/operations.hpp>
#include <tilemesh/splat/policy_set.hpp>
#include <tilemesh/splat/sizes.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// What the host tells every tile at the start of a frame.
struct FrameParameters {
    static constexpr char const* name = "frame parameters";
    View view;
    Tiling tiling;
    std::uint32_t view_changed;  ///< 0: the view of the last frame, whose splats still hold
    std::uint32_t resend_copies; ///< 1: send all copies again, because a full storage lost some; no neighbour is known to hold one
    std::uint32_t readdress;     ///< 1: what is under way was addressed in another view (a bound cut the last frame)
};

// --- state of a tile ------------------------------------------------------------------------------------------------------------
// The type of a region depends on a set of policies; its slots are a member of `Sizes`. `Storage<S>`, for a setup or a set of policies S,
// is the region under S's policies.

namespace region {
template <class P>
struct Storage : Buffer<typename P::Record> {
    using Buffer<typename P::Record>::Buffer;
    static constexpr char const* name = "storage";
    static constexpr auto slots = &Sizes::storage;
};
} // namespace region
/// The records a tile holds: Gaussians anchored here, and the copies that bloom brought. `Marks` and `Splats` go with it,
/// slot by slot.
template <class S>
using Storage = region::Storage<PoliciesOf<S>>;

/// What a tile knows of a stored record.
struct Mark {
    GaussianId id;
    std::uint32_t bits;

    static constexpr std::uint32_t copy = 1u << 8;    ///< somebody else is the anchor
    static constexpr std::uint32_t leaving = 1u << 9; ///< anchored elsewhere now; goes as soon as there is room
    static constexpr std::uint32_t owes = 1u << 10;   ///< a neighbour may have to be sent a copy: bloom looks
    static constexpr std::uint32_t listed = 1u << 11; ///< the depth sort's own, while it runs: the order has this slot
    /// The neighbour on side d holds this record too: it was sent there, or came from there.
    static constexpr std::uint32_t shared(Direction d) noexcept { return 1u << index(d); }
    /// The neighbour on side d should have it, but the channel was full (`drop`).
    static constexpr std::uint32_t refused(Direction d) noexcept { return 16u << index(d); }
    static constexpr std::uint32_t all_sides = 0xfu, refused_any = 0xf0u;
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
namespace region {
template <class P>
struct Marks : Buffer<MarkOf<P>> {
    using Buffer<MarkOf<P>>::Buffer;
    static constexpr char const* name = "marks";
    static constexpr auto slots = &Sizes::storage;
    static constexpr auto budgeted_if = &Sizes::lists_fit;
};
template <class P>
struct Splats : Buffer<typename P::Projected> {
    using Buffer<typename P::Projected>::Buffer;
    static constexpr char const* name = "projected records";
    static constexpr auto slots = &Sizes::storage;
    static constexpr auto budgeted_if = &Sizes::lists_fit;
};
} // namespace region
template <class S>
using Marks = region::Marks<PoliciesOf<S>>;
/// The projected records of this frame: the screen cache. `Access::splat_of` gives the splat of an entry.
template <class S>
using Splats = region::Splats<PoliciesOf<S>>;

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
struct SortKeys : Buffer<SortKey> {
    using Buffer<SortKey>::Buffer;
    static constexpr char const* name = "sort keys";
    static constexpr auto slots = &Sizes::storage;
    static constexpr auto budgeted_if = &Sizes::lists_fit;
};
/// The slots of the splats that touch the tile, in depth order. It is the same type for all policies.
template <class>
using Order = SortKeys;

namespace region {
template <class Pixel>
struct Framebuffer : Buffer<Pixel> {
    using Buffer<Pixel>::Buffer;
    static constexpr char const* name = "framebuffer";
    static constexpr auto slots = &Sizes::tile_pixels;
};
} // namespace region
/// The tile's slice of the picture, row by row of the tile's own rectangle; sized by the host when it sets the tiling.
template <class S>
using Framebuffer = region::Framebuffer<typename S::Pixel>;

/// What a tile counts in a frame; Project begins it at zero but for the last two, which are kept. Exact on every engine.
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
    std::uint32_t copies;        ///< copies on the tile when its order was last made
    /// Not 0: slots came, went or began or ceased to show since the order was made. Whoever does that counts it, the host too;
    /// only DepthSort sets it back.
    std::uint32_t changes;
};
static_assert(sizeof(Counts) <= 64, "small enough to lie beside the heads of a tile's lists");

/// Flow control's memory: see routing.hpp.
struct FlowControl {
    static constexpr char const* name = "credits and flow control";
    std::uint32_t leaving;       ///< records in storage that wait to go
    std::uint32_t waiting;       ///< records in the FIFOs
    std::uint32_t sent[2];       ///< on the first leg's two sides, in the superstep before
};

/// Whether stored records may owe copies that were not sent yet.
struct OwedCopies {
    static constexpr char const* name = "bloom debts";
    std::uint32_t open;          ///< not fewer than the slots with Mark::owes that routing did not bring
    std::uint32_t first;         ///< 1 until bloom has run once in this frame: mail is older than the view; 0 outside the picture
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
    static constexpr std::uint32_t wire_bytes = ::tilemesh::wire_bytes<Record> + sizeof(TileId);
};
using Addressed = AddressedRecord<Gaussian>;
/// The projected form of a copy: 60 bytes, good for this frame's view only.
struct ScreenCopy {
    Splat splat;
    GaussianId id;
};
static_assert(sizeof(Addressed) == 64 && sizeof(ScreenCopy) == 60, "messages are whole records");

/// What routing and bloom send under a set of policies.
template <class S>
using RoadMessage = typename S::Addressing::template Message<typename S::Record>;
template <class S>
using BeamMessage = typename S::Copies::template Message<typename S::Record>;

namespace region {
template <class P>
struct Road : Channel<RoadMessage<P>> {
    static constexpr char const* name = "road";
    static constexpr auto slots = &Sizes::road;
};
template <class P, bool Routes = P::routes>
struct Beam : Channel<BeamMessage<P>> {
    static constexpr char const* name = "beam";
    static constexpr auto slots = &Sizes::beam;
};
/// The paper has one set of channels: routing is over when bloom begins.
template <class P>
struct Beam<P, true> : Beam<P, false> {
    using memory_of = Road<P>;
    static constexpr auto memory_shared = &Sizes::one_channel_memory;
};
/// Does the saturation policy hold by its type, not by a parameter at run time?
template <class Saturation, class = void>
inline constexpr bool always_holds = false;
template <class Saturation>
inline constexpr bool always_holds<Saturation, std::enable_if_t<Saturation::holds>> = true;
template <class P, std::uint32_t Side>
struct Waiting : Buffer<RoadMessage<P>> {
    using Buffer<RoadMessage<P>>::Buffer;
    static constexpr char const* name = Side == 0 ? "waiting (side 0)" : "waiting (side 1)";
    static constexpr auto slots = &Sizes::waiting;
    static constexpr std::uint32_t least_slots = always_holds<typename P::Saturation> ? 1 : 0; ///< without a slot, no credit is given
};
} // namespace region
/// Carries records to their anchor tiles.
template <class S>
using Road = region::Road<PoliciesOf<S>>;
/// Carries copies from a record's anchor tile to all tiles its footprint touches.
template <class S>
using Beam = region::Beam<PoliciesOf<S>>;
/// Records under way that arrived on the first leg and found no room ahead; one FIFO a side of that leg.
template <class S, std::uint32_t Side>
using Waiting = region::Waiting<PoliciesOf<S>, Side>;

// --- helpers that several kernels share ------------------------------------------------------------------------------------

/// Does the tile hold pixels? On one that does not there are no copies, and none are under way to it.
TILEMESH_KERNEL bool in_picture(Here const& here, FrameParameters const& frame) noexcept
{
    return here.tile.x() < frame.tiling.columns && here.tile.y() < frame.tiling.rows;
}

/// What a tile must know of an entry's footprint.
struct Reach {
    TileId anchor;
    bool visible;
    bool here;             ///< touches this tile
    std::uint32_t sides;   ///< touches the neighbour on side d: bit index(d), as in Mark::shared
};
/// The sides of tile t on which its children are in the tree that is rooted at `anchor`, as bits.
TILEMESH_KERNEL std::uint32_t child_sides(TileId anchor, TileId t) noexcept
{
    std::uint32_t sides = 0;
    for (Direction d : news) sides |= is_child(anchor, t, d) ? Mark::shared(d) : 0u;
    return sides;
}

inline constexpr std::uint32_t no_slot = 0xffffffffu;

/// The first of n items that `is_it`, or `no_slot`. Looks at 16 at once, which a compiler makes one or a few vector compares.
template <class Item, class IsIt>
std::uint32_t first_of(Item const* items, std::uint32_t n, IsIt const& is_it) noexcept
{
    constexpr std::uint32_t at_once = 16;
    std::uint32_t i = 0;
    for (; i + at_once <= n; i += at_once) {
        std::uint32_t hits = 0;
        for (std::uint32_t k = 0; k < at_once; ++k) hits += is_it(items[i + k]) ? 1u : 0u;
        if (hits != 0) break;
    }
    for (; i < n; ++i)
        if (is_it(items[i])) return i;
    return no_slot;
}
/// The slot of record `id`, or `no_slot`.
template <class MarkList>
std::uint32_t find(MarkList const& marks, GaussianId id) noexcept
{
    return first_of(marks.begin(), marks.size(), [id](auto const& mark) noexcept { return mark.id == id; });
}
/// Takes slot i out of storage, marks and projected records.
template <class A, class B, class C>
TILEMESH_KERNEL void remove_slot(A& storage, B& marks, C& splats, std::uint32_t i) noexcept
{
    storage.swap_remove(i);
    marks.swap_remove(i);
    splats.swap_remove(i);
}

}}} // namespace tilemesh::splat
