#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/model/network.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// A grid of tiles that lie on several chips. Chips of columns x rows tiles lie side by side, from tile (0, 0) on; the last chip of a row or
/// column may be cut. Two neighbouring chips share a border. All links between tiles over a border share the border's bandwidth, each way.
///
/// An exchange in which bytes cross a border lasts at least crossing_cycles + bytes * crossing_millicycles_a_byte / 1,000, rounded up, for
/// the border and the direction with the most bytes. Meanwhile the other links move theirs.
struct Chips {
    std::uint32_t columns = 0, rows = 0;                ///< tiles of a chip; both 0: the grid is one chip
    std::uint64_t crossing_cycles = 0;                  ///< latency of a border, at most 10^12
    std::uint64_t crossing_millicycles_a_byte = 0;      ///< of a border, in one direction; at most 10^7
    std::string source = {};                            ///< of the two numbers: a document, or "guess: ..."
    friend bool operator==(Chips const&, Chips const&) = default;
};

/// Mk2 chips of 40 x 36 tiles, as in the paper's grid. The bandwidth is from a document; no number for the latency was found.
TILEMESH_HOST Chips mk2_chips();

namespace model_detail {
inline constexpr std::uint64_t most_crossing_cycles = 1'000'000'000'000, most_crossing_millicycles = 10'000'000;

/// The borders between the chips of a grid.
class Crossings {
public:
    /// Throws Error for chips with one side of 0, and for numbers above their limits.
    TILEMESH_HOST Crossings(Chips const& chips, Grid grid);
    std::uint32_t chips() const noexcept { return across_ * down_; }

    /// The bytes over the busiest border in one direction, if every link carries its capacity.
    TILEMESH_HOST std::uint64_t of_capacity(SuperstepSample const& s) noexcept;
    /// The bytes over the busiest border in one direction, of the messages of a superstep.
    TILEMESH_HOST std::uint64_t of_messages(SuperstepSample const& s);
    /// The cycles of a border for so many bytes; 0 if none cross.
    TILEMESH_HOST std::uint64_t cycles(std::uint64_t bytes) const noexcept;
    /// The border that the last call of of_capacity or of_messages was about: the first of the busiest.
    NetworkResource const& busiest() const noexcept { return busiest_; }

private:
    std::size_t chip_of(TileId t) const noexcept { return std::size_t{t.y() / chips_.rows} * across_ + t.x() / chips_.columns; }

    Chips chips_;
    Grid grid_;
    std::uint32_t across_ = 1, down_ = 1;  ///< chips
    std::vector<std::uint64_t> bytes_;     ///< of each chip and direction
    NetworkResource busiest_{};
};
} // namespace model_detail

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/chips_code.hpp>
#endif
