#pragma once
#include <cstdint>

namespace tilemesh { inline namespace v0_2 { namespace splat::homes {

/// The counters of a tile in a frame. They are exact on every engine.
struct Counts {
    static constexpr char const* name = "counters";
    std::uint32_t visible;      ///< records of this home with something on screen
    std::uint32_t sent;         ///< parcels that this home gave to channels
    std::uint32_t hops;         ///< parcels given to channels, also those of other homes
    std::uint32_t asked;        ///< tiles that the parcels of this home name
    std::uint32_t arrived;      ///< parcels that named this tile; the sum over all tiles is that of `asked`
    std::uint32_t early;        ///< of these, before the window: the table has depths, not whole keys; or outside it, but in the district's
    std::uint32_t refused;      ///< of these, no room: they come again in a later round
    std::uint32_t channel_full; ///< waits for a slot of a channel
    std::uint32_t no_credit;    ///< waits for a slot of the FIFO behind a channel
    std::uint32_t rounds;       ///< in which the tile was not done
    // For a cost model, in the last pass of Deliver.
    std::uint32_t left, passed, settled, turned_away, compared, scanned;

    /// The counter of a wait.
    std::uint32_t& refusals(bool short_of_credit) noexcept { return short_of_credit ? no_credit : channel_full; }
    std::uint32_t by_channels() const noexcept { return channel_full + no_credit; }
};
static_assert(sizeof(Counts) <= 64);

inline constexpr std::uint32_t pairs_a_count = 2; ///< strips of blocks and of cells are whole units
/// The Gaussian-pixel pairs of each worker. Workers share a block in strips of 2 columns: 10 pixels of a block, 8 of a cell.
struct Work {
    static constexpr char const* name = "pair counters";
    static constexpr std::uint32_t max_workers = 6;
    std::uint32_t evaluated[max_workers];    ///< in units of pairs_a_count
    std::uint32_t contributing[max_workers]; ///< pairs
    std::uint32_t before[max_workers];       ///< `evaluated` before the last pass
};

}}} // namespace tilemesh::splat::homes
