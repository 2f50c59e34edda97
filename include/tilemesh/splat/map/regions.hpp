#pragma once
#include <cstdint>
#include <tilemesh/machine/buffer.hpp>
#include <tilemesh/machine/channel.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/map/loss.hpp>
#include <tilemesh/splat/map/optimise.hpp>
#include <tilemesh/splat/map/sums.hpp>
#include <tilemesh/splat/map/tile.hpp>
#include <tilemesh/splat/projection.hpp>
#include <tilemesh/splat/regions.hpp>
#include <tilemesh/splat/target_pixel.hpp>
#include <tilemesh/splat/view.hpp>
#include <type_traits>

/// What a tile keeps, sends and is told in a mapping step on the mesh (program.hpp).
namespace tilemesh { inline namespace v0_2 { namespace splat::map {

/// The capacities of a mapping step on one tile, in slots. `sizes_on` makes them.
struct MapSizes {
    std::uint32_t records = 0;     ///< Gaussians that rest on the tile, with their optimiser's state
    std::uint32_t entries = 0;     ///< splats in a view: one for each record, and the copies; each also has a sort key
    std::uint32_t sums = 0;        ///< `entries` for each of the workers that walk
    std::uint32_t copies = 0;      ///< messages of casting in one channel end
    std::uint32_t answers = 0;     ///< messages of returning in one channel end
    std::uint32_t road = 0;        ///< records on their way to other tiles in one channel end
    std::uint32_t tile_pixels = 0; ///< pixels of the target
    std::uint32_t tile_blocks = 0;
    std::uint32_t walkers = 0;     ///< workers that walk (`walkers_of`)
    std::uint32_t cells = 0;       ///< cells across a tile, where the map grows
    std::uint32_t cell_slots = 0;  ///< sums of cells in one channel end
};

/// What the host tells every tile: one view, what to do with it, and how to step.
struct StepParameters {
    static constexpr char const* name = "step parameters";
    View view;
    Tiling tiling;
    LossRules loss;
    Rates rates;
    Decays decays;
    std::uint32_t walkers; ///< the workers that walk; each has its own sums
    std::uint32_t rests;   ///< 1: the records move to the tiles of their means in this view
    std::uint32_t steps;   ///< 1: the records make a step by this view
};
static_assert(std::is_trivially_copyable_v<StepParameters> && sizeof(StepParameters) % 4 == 0, "parameters are whole words");

inline constexpr std::uint32_t most_walkers = 6;

constexpr std::uint32_t blocks_of(TileSize const& tile) noexcept
{
    return tile.tile_width / block_width * (tile.tile_height / block_height);
}
/// The workers that share the blocks of a tile: as few as take no longer than all would. Fewer workers need less memory for sums. 4 of 6
/// workers take two blocks each of the 8 of a tile of 32 x 20 pixels.
constexpr std::uint32_t walkers_of(TileSize const& tile, std::uint32_t workers) noexcept
{
    std::uint32_t const blocks = blocks_of(tile), most = workers < most_walkers ? workers : most_walkers;
    if (blocks == 0 || most == 0) return 1;
    std::uint32_t const each = (blocks + most - 1) / most;
    return (blocks + each - 1) / each;
}

/// The Gaussians that rest on the tile, whatever the view shows.
struct Records : Buffer<Gaussian> {
    static constexpr char const* name = "records";
    static constexpr auto slots = &MapSizes::records;
};
/// The optimiser's words of each record.
template <class Optimiser>
struct OptimiserStates : Buffer<typename Optimiser::State> {
    static constexpr char const* name = "optimiser states";
    static constexpr auto slots = &MapSizes::records;
};

/// A splat on a tile: entry i is that of record i; copies follow. A copy lies on the tree of its record's tile: along that tile's row, then
/// along the columns of the splat's rectangle. It may pass tiles that the rectangle does not touch; there it has no key.
struct Entry {
    Splat splat;
    GaussianId id;
    std::uint32_t parent; ///< the copy's slot on the tile from which it came
    std::uint32_t bits;

    static constexpr std::uint32_t copy = 1u << 8;     ///< it came from another tile
    static constexpr std::uint32_t answered = 1u << 9; ///< the copy has returned its sums
    static constexpr std::uint32_t owes_any = 0xfu, waits_any = 0xf0u;
    /// A copy must still be sent to side d.
    static constexpr std::uint32_t owes(Direction d) noexcept { return 1u << index(d); }
    /// The tile on side d has not answered.
    static constexpr std::uint32_t waits(Direction d) noexcept { return 16u << index(d); }
    static constexpr std::uint32_t from(Direction d) noexcept { return copy | index(d) << 10; }
    Direction parent_side() const noexcept { return news[bits >> 10 & 3u]; }
    bool is_copy() const noexcept { return (bits & copy) != 0; }
    /// Is it a copy that has all answers, and has not answered itself?
    bool can_answer() const noexcept { return (bits & (copy | answered | waits_any)) == copy; }
};
static_assert(sizeof(Entry) == 68 && std::is_trivially_copyable_v<Entry>, "a splat and three words");
struct Entries : Buffer<Entry> {
    static constexpr char const* name = "splats of a view";
    static constexpr auto slots = &MapSizes::entries;
};
/// The sums of the entries: those of worker w begin at w times the number of entries. `AddUp` adds them to the first.
struct EntrySums : Buffer<SplatSums> {
    static constexpr char const* name = "sums of splats";
    static constexpr auto slots = &MapSizes::sums;
};
/// The entries that touch the tile's pixels, in the order of depth.
struct EntryKeys : Buffer<SortKey> {
    static constexpr char const* name = "sort keys";
    static constexpr auto slots = &MapSizes::entries;
};
/// The tile's part of the picture that the camera saw, row by row of its own rectangle. The host writes it.
struct TargetPixels : Buffer<TargetPixel> {
    static constexpr char const* name = "target";
    static constexpr auto slots = &MapSizes::tile_pixels;
};
/// The loss of each block of the tile, row by row; 0 for a block outside of the frame.
struct BlockLosses : Buffer<BlockLoss> {
    static constexpr char const* name = "losses of blocks";
    static constexpr auto slots = &MapSizes::tile_blocks;
};
/// The memory of a worker that walks, and what its alignment may need.
struct WalkSpace {
    using Memory = WalkMemory<1, 16>;
    std::uint32_t word[(sizeof(Memory) + (alignof(Memory) > 4 ? alignof(Memory) : 0)) / 4];

    Memory& memory() noexcept
    {
        using Address = decltype(sizeof 0); // as wide as a pointer: 32 bits on a tile
        auto const at = reinterpret_cast<Address>(this), aligned = (at + alignof(Memory) - 1) / alignof(Memory) * alignof(Memory);
        return *reinterpret_cast<Memory*>(aligned);
    }
};
struct WalkSpaces : Buffer<WalkSpace> {
    static constexpr char const* name = "walk workspaces";
    static constexpr auto slots = &MapSizes::walkers;
};
/// Where a tile is in the trees of its entries.
struct TreeState {
    static constexpr char const* name = "state of the trees";
    std::uint32_t own;         ///< entries of own records; they stand first
    std::uint32_t first_owing; ///< no entry before this one owes a copy
    std::uint32_t ready;       ///< copies that can answer, and have not
};
/// The counters of a tile in a step.
struct MapCounts {
    static constexpr char const* name = "counters";
    std::uint32_t visible;     ///< own records with something on screen
    std::uint32_t no_entry;    ///< own records that found no slot: the view lacks them
    std::uint32_t copies;      ///< copies that are kept, also those that only pass
    std::uint32_t copies_full; ///< copies that found no slot: the tile, and what lies behind it in the tree, lacks them
    std::uint32_t cast_held;   ///< refusals of a full channel, a copy that waits three passes counts three times
    std::uint32_t return_held; ///< the same, for sums
};
/// Splats blended into blocks by each worker.
struct WalkWork {
    static constexpr char const* name = "block counters";
    std::uint32_t blended[most_walkers];

    /// Of the worker with the most.
    std::uint32_t most(std::uint32_t walkers) const noexcept
    {
        std::uint32_t most = 0;
        for (std::uint32_t w = 0; w < walkers; ++w) most = blended[w] > most ? blended[w] : most;
        return most;
    }
};
/// What a pass of casting or returning did.
struct Passed {
    static constexpr char const* name = "counters of a pass";
    static constexpr bool per_pass = true;
    std::uint32_t looked, moved;
};

/// A projected copy on its way, 64 bytes, with its slot on the sender's tile.
struct CopyMessage {
    Splat splat;
    GaussianId id;
    std::uint32_t slot;
};
/// The answer to a copy: the sums of the receiver and of all behind it, for the sender's slot. They are 0 if the receiver had no room.
struct AnswerMessage {
    std::uint32_t slot;
    SplatSums sums;
};
static_assert(sizeof(CopyMessage) == 64 && sizeof(AnswerMessage) == 44, "messages are whole words");
struct Copies : Channel<CopyMessage> {
    static constexpr char const* name = "copies";
    static constexpr auto slots = &MapSizes::copies;
};
struct Answers : Channel<AnswerMessage> {
    static constexpr char const* name = "answers";
    static constexpr auto slots = &MapSizes::answers;
};

/// Does the rectangle touch the pixels of tile t?
TILEMESH_KERNEL bool touches(PixelRect const& r, TileSize const& tile, TileId t) noexcept
{
    std::uint32_t const x0 = t.x() * tile.tile_width, y0 = t.y() * tile.tile_height;
    return r.x0 < x0 + tile.tile_width && r.x1 > x0 && r.y0 < y0 + tile.tile_height && r.y1 > y0;
}
/// The sides on which a splat's tree goes on from tile t, as `Entry::owes`: along the root's row in both directions, and from each tile of
/// that row in the rectangle's columns along the column. `came` is 4 on the root, else the index of the side on which the parent lies.
TILEMESH_KERNEL std::uint32_t child_sides_of(PixelRect const& r, TileSize const& tile, TileId t, std::uint32_t came) noexcept
{
    std::uint32_t const x0 = t.x() * tile.tile_width, x1 = x0 + tile.tile_width, y0 = t.y() * tile.tile_height, y1 = y0 + tile.tile_height;
    bool const on_row = came != index(Direction::north) && came != index(Direction::south), in_columns = r.x0 < x1 && r.x1 > x0;
    std::uint32_t sides = 0;
    if (on_row && r.x1 > x1 && came != index(Direction::east)) sides |= Entry::owes(Direction::east);
    if (on_row && r.x0 < x0 && came != index(Direction::west)) sides |= Entry::owes(Direction::west);
    if (in_columns && r.y1 > y1 && came != index(Direction::south)) sides |= Entry::owes(Direction::south);
    if (in_columns && r.y0 < y0 && came != index(Direction::north)) sides |= Entry::owes(Direction::north);
    return sides;
}
inline constexpr std::uint32_t at_root = 4;

}}} // namespace tilemesh::splat::map
