#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <vector>

namespace render_map {

/// What a tile holds when a frame is over, and what it refused in that frame (`splat::Counts`).
struct TileState {
    std::uint32_t records = 0, copies = 0; ///< copies are among the records
    std::uint64_t pairs =
        0; ///< evaluated; `Operation::pair` of a trace counts as if all workers were as slow as the slowest
    std::uint32_t channel_full = 0, no_credit = 0;
    std::uint32_t storage_full = 0, copies_full = 0, copies_refused = 0;
};

/// What can be seen of a Gaussian on a tile after a superstep.
enum class Seen : std::uint32_t {
    anchored, ///< it is stored here, and this is its anchor tile
    copy,     ///< another tile's record, stored here because its footprint touches this tile
    leaving,  ///< stored here, and anchored elsewhere in this view
    waiting,  ///< on its way, in the FIFO of what arrived from `side`
    road,     ///< sent here from `side` by routing; it is read in the next superstep
    beam,     ///< a copy, sent here from `side` by bloom
    owed,     ///< a copy is due to the neighbour on `side`, and was not sent
    refused,  ///< a copy for the neighbour on `side` met a full channel and was given up
    dropped,  ///< it came from `side`, as record or copy, and met a full storage
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
    bool refusal; ///< it was to move in this superstep, and there was no room
};

/// One Gaussian's way through a frame.
struct Life {
    std::vector<Sighting> sightings; ///< what is new in a superstep, and every refusal
    std::optional<tilemesh::TileId>
        anchor;               ///< where it is anchored when the frame is over, or leaves from; empty: on no tile
    std::optional<tilemesh::TileId> dropped; ///< where the record met a full storage last
    std::uint64_t copies = 0; ///< tiles that then hold a copy
    std::uint64_t dropped_copies = 0;
    std::uint64_t hops = 0, sent_copies = 0, refusals = 0;
};

/// Makes a Life out of all that is seen, superstep by superstep.
class Follower {
public:
    struct Fact {
        tilemesh::TileId tile;
        Seen what;
        std::optional<tilemesh::Direction> side;
        bool refusal; ///< in this superstep; of `refused` what is new is one
    };
    /// The superstep after which facts were seen.
    struct Step {
        std::uint64_t number;
        std::string const& kernel;
        tilemesh::Grid grid;
        bool routes, blooms;
        std::vector<tilemesh::TileId> full; ///< tiles whose storage had no room for something in it
    };
    void begin_frame();
    void superstep(Step const& step, std::vector<Fact> facts);
    Life life() const { return life_; }

private:
    void see_what_is_dropped(Step const& step, std::vector<Fact> const& facts);

    Life life_;
    std::vector<Fact> before_; ///< of the superstep before, which may be the last frame's last
    std::vector<Fact> under_way_; ///< sent and not read yet; a bound on hops leaves some from frame to frame
    bool begins_ = true;
};

/// What --trace and --follow ask of a renderer whose machine keeps a trace.
class Instruments {
public:
    virtual ~Instruments() = default;
    /// A copy of that of the frame rendered last, with every run of the program that it took.
    virtual tilemesh::Trace take_trace() = 0;
    /// In the order of the grid's indices.
    virtual std::vector<TileState> tiles() = 0;
    /// From the next frame on; looks at every tile after every superstep.
    virtual void follow(tilemesh::splat::GaussianId id) = 0;
    virtual Life life() = 0;
};

} // namespace render_map
