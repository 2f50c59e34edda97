#pragma once
#include <cstdint>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The counters of a tile in a frame. Project resets all of them except the last two, and in an old view `visible` and
/// `parked`. They are exact on every engine.
struct Counts {
    static constexpr char const* name = "counters";
    std::uint32_t visible;       ///< anchored here or leaving, and with something on screen
    std::uint32_t parked;        ///< anchored here with nothing on screen; stays on its tile
    std::uint32_t moved;         ///< records whose anchor became another tile in this frame
    std::uint32_t hops;          ///< records sent to a neighbour on the way to their anchor tile
    std::uint32_t channel_full;  ///< refusals because the channel has no free slot; a record that waits three passes counts three times
    std::uint32_t no_credit;     ///< refusals because the receiver promised no more room, although the channel has a free slot
    std::uint32_t storage_full;  ///< anchored records that found no free storage: unplaced (hold) or dropped (drop)
    std::uint32_t copies_full;   ///< copies that found no free storage
    std::uint32_t copies_refused;///< copies that found no free slot in the channel and were given up (drop)
    std::uint32_t projected;     ///< projections computed
    std::uint32_t copies;        ///< copies on the tile when its depth order was last made
    /// Not 0: since the depth order was made, slots came or left, or records began or ceased to show. Whoever changes slots counts the
    /// change, also the host. Only DepthSort resets it.
    std::uint32_t changes;

    /// The counter of a refusal by a channel.
    std::uint32_t& refusals(bool short_of_credit) noexcept { return short_of_credit ? no_credit : channel_full; }
    std::uint32_t by_channels() const noexcept { return channel_full + no_credit; }
    std::uint32_t by_storage() const noexcept { return storage_full + copies_full; }
};
static_assert(sizeof(Counts) <= 64, "small enough to lie beside the heads of a tile's lists");

/// Evaluated pairs are counted in units of this many, so that 32 bits hold a whole frame. Blocks and cells are whole units.
inline constexpr std::uint32_t pairs_a_count = 16;
/// The Gaussian-pixel pairs, counted by each worker on its own.
struct Work {
    static constexpr char const* name = "pair counters";
    static constexpr std::uint32_t max_workers = 6;
    std::uint32_t evaluated[max_workers];    ///< in units of pairs_a_count
    std::uint32_t contributing[max_workers]; ///< pairs
};

}}} // namespace tilemesh::splat
