#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/model/network.hpp>

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

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/chips_code.hpp>
#endif
