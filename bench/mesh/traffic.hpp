#pragma once
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/machine/spec.hpp>

/// The machine without splatting: records travel to their tiles, along the row first, then along the column.
namespace traffic {
using namespace tilemesh;

/// 60 bytes, the size of a Gaussian. The payload follows from the id, so that every arrival can be checked.
struct Record {
    std::uint32_t id;
    TileId to;
    std::uint32_t payload[13];
};
static_assert(sizeof(Record) == 60);

/// Word i of record id's payload (the finaliser of MurmurHash3: any two records differ in every word).
constexpr std::uint32_t payload_word(std::uint32_t id, std::uint32_t i) noexcept
{
    std::uint32_t h = id * 13 + i + 1;
    h = (h ^ (h >> 16)) * 0x85ebca6bu;
    h = (h ^ (h >> 13)) * 0xc2b2ae35u;
    return h ^ (h >> 16);
}

/// Slots of a channel end, of a tile's storage and of a FIFO on the first leg.
struct Sizes {
    std::uint32_t slots, storage, waiting;
};

struct Road : Channel<Record> {
    static constexpr auto slots = &Sizes::slots;
};
/// The records that have not left their first tile.
struct Leaving : Buffer<Record> {
    static constexpr auto slots = &Sizes::storage;
};
struct Arrived : Buffer<Record> {
    static constexpr auto slots = &Sizes::storage;
};
/// The records that came from the east (0) or the west (1) and found no room ahead.
template <std::uint32_t Side>
struct Waiting : Buffer<Record> {
    static constexpr auto slots = &Sizes::waiting;
};
struct Traffic {
    std::uint32_t sent[2]; ///< records sent to the east and to the west in the previous superstep
    std::uint32_t refused; ///< arrivals that found the storage full and are lost; the bench refuses such a job beforehand
};

/// Moves every record that can move by one hop.
///
/// No record waits on the second leg. At most a channel's slots arrive on a side. Each of these records either has arrived, or goes
/// straight on into a channel that is empty when compute begins. On the first leg, a record that finds no room waits in the FIFO of its
/// side. The tile tells the neighbour on that side the fill of the FIFO, as the note of the channel back. The neighbour sends only as many
/// records as the FIFO has room for, minus the records that may be on their way. So no record is lost. A row's FIFOs wait only for columns
/// and for the edge, so no record waits for ever.
struct Move {
    static constexpr char const* name = "move";

    Vote operator()(Here here, Leaving& leaving, Arrived& arrived, Waiting<0>& from_east, Waiting<1>& from_west, Traffic& traffic,
                    In<Road> in, Out<Road> out) const noexcept
    {
        auto const x = here.tile.x();
        auto const y = here.tile.y();
        auto& east = out[Direction::east];
        auto& west = out[Direction::west];
        auto& north = out[Direction::north];
        auto& south = out[Direction::south];
        auto const credit = [&](Direction side, std::uint32_t sent) noexcept {
            auto const used = in[side].note() + sent;
            auto const fifo = from_east.capacity(), slots = east.capacity(); // all tiles have the same
            auto const free = used < fifo ? fifo - used : 0;
            return free < slots ? free : slots;
        };
        auto const east_limit = credit(Direction::east, traffic.sent[0]);
        auto const west_limit = credit(Direction::west, traffic.sent[1]);

        auto const arrive = [&](Record const& r) noexcept {
            if (!arrived.try_push(r)) ++traffic.refused;
        };
        auto const turn = [&](Record const& r) noexcept { // into the column of its tile
            if (r.to.y() == y) {
                arrive(r);
                return true;
            }
            return r.to.y() < y ? north.try_push(r) : south.try_push(r);
        };
        auto const go = [&](Record const& r, auto& ahead, std::uint32_t limit) noexcept { // along the row, or out of it
            if (r.to.x() == x) return turn(r);
            if (ahead.size() >= limit) return false;
            ahead.unchecked_push(r);
            return true;
        };

        for (Record const& r : in[Direction::north])
            if (r.to.y() == y) arrive(r);
            else south.unchecked_push(r);
        for (Record const& r : in[Direction::south])
            if (r.to.y() == y) arrive(r);
            else north.unchecked_push(r);

        auto const along = [&](auto& waiting, auto const& arrivals, auto& ahead, std::uint32_t limit) noexcept {
            std::uint32_t kept = 0;
            for (Record const& r : waiting)
                if (!go(r, ahead, limit)) waiting[kept++] = r;
            waiting.truncate(kept);
            for (Record const& r : arrivals)
                if (!go(r, ahead, limit)) waiting.push(r); // the credit guarantees room
        };
        along(from_east, in[Direction::east], west, west_limit);
        along(from_west, in[Direction::west], east, east_limit);

        for (std::uint32_t i = leaving.size(); i-- > 0;) {
            Record const& r = leaving[i];
            if (r.to.x() > x ? go(r, east, east_limit) : go(r, west, west_limit)) leaving.swap_remove(i);
        }

        if (!from_east.empty()) east.set_note(from_east.size());
        if (!from_west.empty()) west.set_note(from_west.size());
        traffic.sent[0] = east.size();
        traffic.sent[1] = west.size();
        bool const quiet =
            leaving.empty() && from_east.empty() && from_west.empty() && traffic.sent[0] == 0 && traffic.sent[1] == 0;
        return quiet ? Vote::quiet : Vote::busy;
    }
};

/// The kernel once on every tile, then until no record is on the road.
using Program = Sequence<Superstep<Move>, UntilQuiet<Move>>;

} // namespace traffic
