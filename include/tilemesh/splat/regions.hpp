#pragma once
#include <tilemesh/splat/counts.hpp>
#include <tilemesh/splat/footprint.hpp>
#include <tilemesh/splat/operations.hpp>
#include <tilemesh/splat/policy_set.hpp>
#include <tilemesh/splat/search.hpp>
#include <tilemesh/splat/setup.hpp>
#include <type_traits>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The parameters that the host sends to every tile at the start of a frame.
struct FrameParameters {
    static constexpr char const* name = "frame parameters";
    static constexpr bool bends = false; ///< a tile that projects has no code for lenses; `LensParameters` has
    static constexpr bool exact_rays = false; ///< ... nor for panoramas; those of splat/exact.hpp have
    static constexpr std::uint32_t item_bytes(Setup const& s) noexcept; ///< also of the host's parameters, which have addresses of tables
    View view;
    Tiling tiling;
    std::uint8_t view_changed;  ///< 0: the view is that of the last frame, and its splats are still valid
    std::uint8_t resend_copies; ///< 1: send all copies again, because a full storage lost some; all Mark::shared bits are cleared
    std::uint8_t readdress;     ///< 1: records under way were addressed in another view, because a bound cut the last frame
    std::uint8_t unused = 0;    ///< fills the word
};
static_assert(sizeof(FrameParameters) == sizeof(View) + sizeof(Tiling) + 4, "parameters are whole words");

/// The parameters of a program whose cameras may have any lens (splat/lens.hpp). A setup type takes them: `using Parameters = LensParameters;`.
struct LensParameters : FrameParameters {
    static constexpr bool bends = true;
};

constexpr std::uint32_t FrameParameters::item_bytes(Setup const& s) noexcept
{
    return s.own_parameter_bytes != 0 ? s.own_parameter_bytes : static_cast<std::uint32_t>(sizeof(FrameParameters));
}

// --- state of a tile ------------------------------------------------------------------------------------------------------------
// The bytes that the machine stores and sends for a record under a setup. Regions say their bytes by these functions, so a ledger is that of
// the machine, whatever form of records a host stores.

constexpr std::uint32_t record_bytes(std::uint32_t sh_degree) noexcept
{
    return static_cast<std::uint32_t>(sizeof(Gaussian)) + 12 * harmonics_per_channel(sh_degree);
}
constexpr std::uint32_t record_bytes(Setup const& s) noexcept
{
    return s.own_record_bytes != 0 ? s.own_record_bytes : record_bytes(s.sh_degree);
}
static_assert(record_bytes(1) == sizeof(ShadedGaussian<1>) && record_bytes(3) == sizeof(ShadedGaussian<3>));
constexpr std::uint32_t road_bytes(Setup const& s) noexcept
{
    return record_bytes(s) + (s.carried ? static_cast<std::uint32_t>(sizeof(TileId)) : 0u);
}
constexpr std::uint32_t beam_bytes(Setup const& s) noexcept
{
    return s.reusable ? record_bytes(s) : static_cast<std::uint32_t>(sizeof(Splat) + sizeof(GaussianId)); // ScreenCopy
}
constexpr std::uint32_t pixel_bytes(Setup const& s) noexcept
{
    return s.own_pixel_bytes != 0 ? s.own_pixel_bytes : (s.colour == ColourFormat::rgbx8 ? 4u : 12u) + (s.depth ? 4u : 0u) + (s.alpha ? 4u : 0u);
}

// The type of a region depends on a set of policies. Its number of slots is a member of `Sizes`. `Storage<S>`, for a setup or a set of
// policies S, is the region under S's policies.

namespace region {
template <class P>
struct Storage : Buffer<typename P::Record> {
    static constexpr char const* name = "storage";
    static constexpr auto slots = &Sizes::storage;
    static constexpr std::uint32_t item_bytes(Setup const& s) noexcept { return record_bytes(s); }
};
} // namespace region
/// The records that a tile holds: Gaussians anchored on it or on their way, and copies that bloom brought. `Marks` and `Splats` have one entry for
/// each slot.
template <class S>
using Storage = region::Storage<PoliciesOf<S>>;

/// The id of a stored record, and what the tile knows of the record.
struct Mark {
    GaussianId id;
    std::uint32_t bits;

    static constexpr std::uint32_t copy = 1u << 8;    ///< the record's anchor is another tile
    static constexpr std::uint32_t leaving = 1u << 9; ///< its anchor is now another tile; it leaves as soon as there is room
    static constexpr std::uint32_t owes = 1u << 10;   ///< a neighbour may need a copy; bloom must check
    static constexpr std::uint32_t listed = 1u << 11; ///< used by the depth sort while it runs: the order has this slot
    /// A leaving record leaves on side d. Only leaving records have one of these bits, and they have exactly one.
    static constexpr std::uint32_t leaves(Direction d) noexcept { return 1u << (12 + index(d)); }
    static constexpr std::uint32_t leaves_any = 0xf000u;
    Direction leaves_on() const noexcept
    {
        std::uint32_t const side = (bits & leaves_any) >> 12; // 1, 2, 4 or 8
        return news[(side >> 1) - (side >> 3)];
    }
    /// The neighbour on side d holds this record too: it was sent there or came from there.
    static constexpr std::uint32_t shared(Direction d) noexcept { return 1u << index(d); }
    /// The neighbour on side d should have a copy, but the channel was full (`drop`).
    static constexpr std::uint32_t refused(Direction d) noexcept { return 16u << index(d); }
    static constexpr std::uint32_t all_sides = 0xfu, refused_any = 0xf0u;
    bool is(std::uint32_t bit) const noexcept { return (bits & bit) != 0; }
};
/// The mark of a setup without routing and bloom: every record is anchored where it is.
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
    static constexpr char const* name = "marks";
    static constexpr auto slots = &Sizes::storage;
    static constexpr auto budgeted_if = &Sizes::lists_fit;
    static constexpr std::uint32_t item_bytes(Setup const& s) noexcept { return s.routes || s.blooms ? sizeof(Mark) : sizeof(AnchorMark); }
};
template <class P>
struct Splats : Buffer<typename P::Projected> {
    static constexpr char const* name = "projected records";
    static constexpr auto slots = &Sizes::storage;
    static constexpr auto budgeted_if = &Sizes::lists_fit;
};
} // namespace region
template <class S>
using Marks = region::Marks<PoliciesOf<S>>;
/// The projected records of this frame. `Access::splat_of` returns the splat of an entry.
template <class S>
using Splats = region::Splats<PoliciesOf<S>>;

/// The key of the depth order: the view depth as a word (depth_key.hpp), then the id.
struct SortKey {
    std::uint32_t depth_key;
    GaussianId id;
    std::uint32_t slot;
};
constexpr bool operator<(SortKey const& a, SortKey const& b) noexcept
{
    return a.depth_key != b.depth_key ? a.depth_key < b.depth_key : a.id < b.id;
}
struct SortKeys : Buffer<SortKey> {
    static constexpr char const* name = "sort keys";
    static constexpr auto slots = &Sizes::storage;
    static constexpr auto budgeted_if = &Sizes::lists_fit;
};
/// The slots of the splats that touch the tile, in depth order. All policies share this type.
template <class>
using Order = SortKeys;

namespace region {
template <class Pixel>
struct Framebuffer : Buffer<Pixel> {
    static constexpr char const* name = "framebuffer";
    static constexpr auto slots = &Sizes::tile_pixels;
    static constexpr std::uint32_t item_bytes(Setup const& s) noexcept { return pixel_bytes(s); }
};
} // namespace region
/// The tile's slice of the picture, row by row of the tile's own rectangle. The host sizes it when it sets the tiling.
template <class S>
using Framebuffer = region::Framebuffer<typename S::Pixel>;

/// The memory of flow control (routing.hpp).
struct FlowControl {
    static constexpr char const* name = "credits and flow control";
    static constexpr bool is_present(Setup const& s) noexcept { return s.routes; }
    std::uint32_t leaving;       ///< records in storage that wait to leave
    std::uint32_t waiting;       ///< records in the FIFOs
    std::uint32_t sent[2];       ///< records sent to the two sides of the first leg in the previous pass
};

/// Says whether stored records may owe copies that are not sent yet.
struct OwedCopies {
    static constexpr char const* name = "bloom debts";
    static constexpr bool is_present(Setup const& s) noexcept { return s.blooms; }
    std::uint32_t open;          ///< upper bound for the slots with Mark::owes, without those that routing brought
    std::uint32_t first;         ///< 1 until bloom has run once in this frame, because mail is then older than the view; 0 outside the picture
};

// --- channels ------------------------------------------------------------------------------------------------------------

/// A record with its anchor tile, which is computed once a frame: 64 bytes at degree 0.
template <class Record>
struct AddressedRecord {
    Record record;
    TileId anchor;
};
using Addressed = AddressedRecord<Gaussian>;
/// A copy in projected form: 60 bytes, valid for this frame's view only.
struct ScreenCopy {
    Splat splat;
    GaussianId id;
};
static_assert(sizeof(Addressed) == 64 && sizeof(ScreenCopy) == 60, "messages are whole records");

/// The messages of routing and of bloom under a set of policies.
template <class S>
using RoadMessage = typename S::Addressing::template Message<typename S::Record>;
template <class S>
using BeamMessage = typename S::Copies::template Message<typename S::Record>;

namespace region {
template <class P>
struct Road : Channel<RoadMessage<P>> {
    static constexpr char const* name = "road";
    static constexpr auto slots = &Sizes::road;
    static constexpr bool is_present(Setup const& s) noexcept { return s.routes; }
    static constexpr std::uint32_t item_bytes(Setup const& s) noexcept { return road_bytes(s); }
};
template <class P, bool Routes = P::routes>
struct Beam : Channel<BeamMessage<P>> {
    static constexpr char const* name = "beam";
    static constexpr auto slots = &Sizes::beam;
    static constexpr bool is_present(Setup const& s) noexcept { return s.blooms; }
    static constexpr std::uint32_t item_bytes(Setup const& s) noexcept { return beam_bytes(s); }
};
/// The paper has one set of channels for both: routing has ended when bloom begins.
template <class P>
struct Beam<P, true> : Beam<P, false> {
    using memory_of = Road<P>;
    static constexpr auto memory_shared = &Sizes::one_channel_memory;
};
/// Is the saturation policy `hold` by its type, not by a parameter at run time?
template <class Saturation, class = void>
inline constexpr bool always_holds = false;
template <class Saturation>
inline constexpr bool always_holds<Saturation, std::enable_if_t<Saturation::holds>> = true;
template <class P, std::uint32_t Side>
struct Waiting : Buffer<RoadMessage<P>> {
    static constexpr char const* name = Side == 0 ? "waiting (side 0)" : "waiting (side 1)";
    static constexpr auto slots = &Sizes::waiting;
    static constexpr bool is_present(Setup const& s) noexcept { return s.routes && s.holds; }
    static constexpr std::uint32_t item_bytes(Setup const& s) noexcept { return road_bytes(s); }
    static constexpr std::uint32_t least_slots = always_holds<typename P::Saturation> ? 1 : 0; ///< without a slot, the tile could give no credit
};
} // namespace region
/// The channel that carries records to their anchor tiles.
template <class S>
using Road = region::Road<PoliciesOf<S>>;
/// The channel that carries copies from a record's anchor tile to all tiles that its footprint touches.
template <class S>
using Beam = region::Beam<PoliciesOf<S>>;
/// Records under way that arrived on the first leg and found no room ahead. There is one FIFO for each side of that leg.
template <class S, std::uint32_t Side>
using Waiting = region::Waiting<PoliciesOf<S>, Side>;

// --- functions that several kernels share ----------------------------------------------------------------------------------

/// Does the tile hold pixels? A tile without pixels has no copies, and no copy is on its way there.
TILEMESH_KERNEL bool in_picture(Here const& here, FrameParameters const& frame) noexcept
{
    return here.tile.x() < frame.tiling.columns && here.tile.y() < frame.tiling.rows;
}

/// The facts about an entry's footprint that a tile needs.
struct Reach {
    TileId anchor;
    bool visible;
    bool here;             ///< the footprint touches this tile
    std::uint32_t sides;   ///< the neighbours that the footprint touches: bit index(d) for side d, as in Mark::shared
};
/// The sides of tile t on which its children lie in the tree that is rooted at `anchor`, as bits.
TILEMESH_KERNEL std::uint32_t child_sides(TileId anchor, TileId t) noexcept
{
    std::uint32_t sides = 0;
    for (Direction d : news) sides |= is_child(anchor, t, d) ? Mark::shared(d) : 0u;
    return sides;
}

/// Returns the slot of record `id`, or `no_slot`.
template <class MarkList>
std::uint32_t find(MarkList const& marks, GaussianId id) noexcept
{
    return first_with_word(marks.begin(), marks.size(), static_cast<std::uint32_t>(id));
}
/// Removes slot i from storage, marks and projected records.
template <class A, class B, class C>
TILEMESH_KERNEL void remove_slot(A& storage, B& marks, C& splats, std::uint32_t i) noexcept
{
    storage.swap_remove(i);
    marks.swap_remove(i);
    splats.swap_remove(i);
}

}}} // namespace tilemesh::splat
