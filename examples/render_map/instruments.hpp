#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <vector>

namespace render_map {

/// The records on a tile at the end of a frame, and the tile's refusals in that frame (`splat::Counts`).
struct TileState {
    std::uint32_t records = 0, copies = 0; ///< number of copies among the records
    std::uint64_t pairs =
        0; ///< evaluated pairs; a trace's `Operation::pair` counts as if all workers were as slow as the slowest
    std::uint64_t refusals = 0; ///< sends that waited for a full channel or for credit
    std::uint64_t drops = 0;    ///< records and copies that found no storage, and copies given up at a full channel
    std::uint32_t rounds = 0, entries = 0; ///< program of homes: rounds in which the tile was not done, and splats that it received
    float frontier = 0; ///< program of homes: TileRound::frontier of the tile's last round
};

/// A tile in one round of the program of homes. Only tiles that were not done when the round began have one.
struct TileRound {
    std::uint32_t round, chapter, tile; ///< round and chapter of the frame, from 1; index of the tile
    std::uint32_t held, refused;        ///< splats that it blended; splats that found no room
    float frontier; ///< the tile's pixels are exact for all splats nearer than this depth, in world units. With every splat: the farthest one's
    bool done;      ///< the tile takes no more rounds (of this chapter)
};

/// What a tile can have to do with a Gaussian after a superstep.
enum class Seen : std::uint32_t {
    anchored, ///< it is stored here, and this is its anchor tile
    copy,     ///< another tile's record, stored here because its footprint touches this tile
    leaving,  ///< stored here, and anchored elsewhere in this view
    waiting,  ///< on its way, in the FIFO of records that arrived from `side`
    road,     ///< sent here from `side` by routing; the next superstep reads it
    beam,     ///< a copy, sent here from `side` by bloom
    owed,     ///< a copy is due to the neighbour on `side`, and was not sent
    refused,  ///< a copy for the neighbour on `side` met a full channel and was lost
    dropped,  ///< a record or copy from `side` met a full storage and was lost
    left      ///< no longer stored here
};
char const* name_of(Seen what) noexcept;
char const* name_of(tilemesh::Direction side) noexcept;

struct Sighting {
    std::uint64_t superstep; ///< of the frame, from 0
    std::string kernel;
    tilemesh::TileId tile;
    Seen what;
    std::optional<tilemesh::Direction> side;
    bool refusal; ///< it should move in this superstep, but there was no room
};

/// The way of one Gaussian through a frame.
struct Life {
    std::vector<Sighting> sightings; ///< the changes in each superstep, and every refusal
    std::optional<tilemesh::TileId>
        anchor;               ///< where it is anchored at the end of the frame, or leaves from; empty: on no tile
    std::optional<tilemesh::TileId> dropped; ///< the tile where the record last met a full storage
    std::uint64_t copies = 0; ///< number of tiles that hold a copy at the end
    std::uint64_t dropped_copies = 0;
    std::uint64_t hops = 0, sent_copies = 0, refusals = 0;
};

/// Makes a Life from the facts of each superstep.
class Follower {
public:
    struct Fact {
        tilemesh::TileId tile;
        Seen what;
        std::optional<tilemesh::Direction> side;
        bool refusal; ///< in this superstep; a new fact `refused` is always a refusal
    };
    /// The superstep after which the facts were read.
    struct Step {
        std::uint64_t number;
        std::string const& kernel;
        tilemesh::Grid grid;
        bool routes, blooms;
        std::vector<tilemesh::TileId> full; ///< tiles whose storage had no room for something in this superstep
    };
    void begin_frame();
    void superstep(Step const& step, std::vector<Fact> facts);
    Life life() const { return life_; }

private:
    void see_what_is_dropped(Step const& step, std::vector<Fact> const& facts);

    Life life_;
    std::vector<Fact> before_; ///< facts of the superstep before, which may be the last frame's last
    std::vector<Fact> under_way_; ///< sent but not read; a bound on hops leaves some from frame to frame
    bool begins_ = true;
};

/// The instruments of a renderer whose machine keeps a trace, for --trace and --follow.
class Instruments {
public:
    virtual ~Instruments() = default;
    /// Returns a copy of the last frame's trace, with every run of the program in that frame.
    virtual tilemesh::Trace take_trace() = 0;
    /// The state of every tile, in the order of the grid's indices.
    virtual std::vector<TileState> tiles() = 0;
    /// Every round of every tile of the last frame, round by round. Empty for the anchored program, and for a view that did not change.
    virtual std::vector<TileRound> rounds() { return {}; }
    /// Follows a Gaussian from the next frame on. It reads every tile after every superstep.
    virtual void follow(tilemesh::splat::GaussianId id) = 0;
    virtual Life life() = 0;
};

} // namespace render_map
