#pragma once
#include <algorithm>
#include <cstddef>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/model/chips.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

TILEMESH_HOST Chips mk2_chips()
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
    std::uint64_t of_capacity(SuperstepSample const& s) noexcept
    {
        std::uint64_t const rows = across_ > 1 ? std::min(chips_.rows, grid_.height) : 0;
        std::uint64_t const columns = down_ > 1 ? std::min(chips_.columns, grid_.width) : 0;
        auto const east = s.capacity_towards(Direction::east), west = s.capacity_towards(Direction::west);
        auto const south = s.capacity_towards(Direction::south), north = s.capacity_towards(Direction::north);
        auto const along = rows * std::max(east, west), down = columns * std::max(south, north);
        // The border east of the first chip or, if more goes the other way, west of the second; and so for south and north.
        if (along >= down) busiest_ = {NetworkResource::border, {east >= west ? 0u : 1u, 0}, east >= west ? 'e' : 'w'};
        else busiest_ = {NetworkResource::border, {0, south >= north ? 0u : 1u}, south >= north ? 's' : 'n'};
        return std::max(along, down);
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
        auto const most = std::max_element(bytes_.begin(), bytes_.end());
        auto const at = static_cast<std::uint32_t>(most - bytes_.begin());
        auto const side = static_cast<Direction>(at % 4);
        busiest_ = {NetworkResource::border, {at / 4 % across_, at / 4 / across_},
                    side == Direction::east ? 'e' : side == Direction::west ? 'w' : side == Direction::south ? 's' : 'n'};
        return *most;
    }
    /// The cycles of a border for so many bytes; 0 if none cross.
    std::uint64_t cycles(std::uint64_t bytes) const noexcept
    {
        if (bytes == 0) return 0;
        auto const milli = chips_.crossing_millicycles_a_byte;
        return chips_.crossing_cycles + bytes / 1000 * milli + (bytes % 1000 * milli + 999) / 1000; // no product exceeds 64 bits
    }
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
