#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
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
inline Chips mk2_chips()
{
    return {40, 36, 600, 30,
            "document: 2.8 Tb/s of IPU-Fabric (cambrian-ai.com on GC200), which is 350 GB/s, or 33 bytes a cycle at 1.325 GHz for each of four "
            "sides and two directions, if they share it evenly; guess: a latency of 600 cycles, because no number was found"};
}

namespace model_detail {
inline constexpr std::uint64_t most_crossing_cycles = 1'000'000'000'000, most_crossing_millicycles = 10'000'000;

/// The borders between the chips of a grid.
class Crossings {
public:
    /// Throws Error for chips with one side of 0, and for numbers above their limits.
    Crossings(Chips const& chips, Grid grid) : chips_(chips), grid_(grid)
    {
        if ((chips.columns == 0) != (chips.rows == 0))
            throw Error("chips of " + std::to_string(chips.columns) + " x " + std::to_string(chips.rows) +
                        " tiles (0 x 0 means that the grid is one chip); give both sides");
        if (chips.crossing_cycles > most_crossing_cycles || chips.crossing_millicycles_a_byte > most_crossing_millicycles)
            throw Error("borders between chips cannot take " + std::to_string(chips.crossing_cycles) + " cycles and " +
                        std::to_string(chips.crossing_millicycles_a_byte) + " millicycles a byte (they go up to " +
                        std::to_string(most_crossing_cycles) + " and " + std::to_string(most_crossing_millicycles) + "); give smaller numbers");
        if (chips.columns == 0) return;
        across_ = (grid.width + chips.columns - 1) / chips.columns;
        down_ = (grid.height + chips.rows - 1) / chips.rows;
        bytes_.resize(std::size_t{4} * across_ * down_);
    }
    std::uint32_t chips() const noexcept { return across_ * down_; }

    /// The bytes over the busiest border in one direction, if every link carries its capacity.
    std::uint64_t of_capacity(std::uint32_t bytes_a_link) const noexcept
    {
        std::uint32_t const east = across_ > 1 ? std::min(chips_.rows, grid_.height) : 0;
        std::uint32_t const south = down_ > 1 ? std::min(chips_.columns, grid_.width) : 0;
        return std::uint64_t{bytes_a_link} * std::max(east, south);
    }
    /// The bytes over the busiest border in one direction, of the messages of a superstep.
    std::uint64_t of_messages(SuperstepSample const& s)
    {
        if (chips() <= 1) return 0;
        std::fill(bytes_.begin(), bytes_.end(), 0);
        for (auto const& t : s.tiles) {
            auto const tile = grid_.tile(t.tile);
            auto const from = chip_of(tile);
            for (Direction d : news)
                if (chip_of(grid_.neighbour(tile, d, s.edge)) != from) bytes_[4 * from + index(d)] += t.sent_bytes[index(d)];
        }
        return *std::max_element(bytes_.begin(), bytes_.end());
    }
    /// The cycles of a border for so many bytes; 0 if none cross.
    std::uint64_t cycles(std::uint64_t bytes) const noexcept
    {
        if (bytes == 0) return 0;
        auto const milli = chips_.crossing_millicycles_a_byte;
        return chips_.crossing_cycles + bytes / 1000 * milli + (bytes % 1000 * milli + 999) / 1000; // no product exceeds 64 bits
    }

private:
    std::size_t chip_of(TileId t) const noexcept { return std::size_t{t.y() / chips_.rows} * across_ + t.x() / chips_.columns; }

    Chips chips_;
    Grid grid_;
    std::uint32_t across_ = 1, down_ = 1;  ///< chips
    std::vector<std::uint64_t> bytes_;     ///< of each chip and direction
};
} // namespace model_detail

}} // namespace tilemesh
