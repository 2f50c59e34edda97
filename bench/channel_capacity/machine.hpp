#pragma once
#include <common/machine.hpp>
#include <cstdint>
#include <memory>
#include <tilemesh/scene/map.hpp>

namespace channel_capacity {

namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;

/// What happens at a full list. `hold` and `drop` are policies of the anchored program. `homes` is the program of homes, which holds, and
/// for which storage is the splats that a tile holds in a round.
enum class Saturation { hold, drop, homes };
inline char const* to_string(Saturation s)
{
    return s == Saturation::hold ? "hold" : s == Saturation::drop ? "drop" : "homes";
}

/// The grid of every machine of this bench: the paper's, 40 x 36 tiles.
inline constexpr std::uint32_t grid_columns = 40, grid_rows = 36, tiles = grid_columns * grid_rows;

using Machine = bench::TracedMachine;

struct Limits {
    std::uint32_t storage_slots = 0; ///< 0: as many as one slot per channel leaves
    std::uint32_t hops = 0;          ///< a frame; 0: until quiet
};
/// The preset `lossless` with one of the two policies, and with room for every split of its SRAM. Its channels are unlimited until
/// `limit_channels` is called.
std::unique_ptr<Machine> make_machine(Saturation, scene::Map const&, Limits);

} // namespace channel_capacity
