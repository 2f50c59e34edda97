#pragma once
#include "graph_data.hpp"
#include "memory.hpp"
#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// The places of elements in tile memory.
namespace standin::detail {

/// Contiguous bytes of one tile. Offsets count from the start of its arena. [piece_begin, piece_end) is the allocation around the bytes.
struct Run {
    unsigned tile;
    std::size_t offset, bytes, piece_begin, piece_end;
};

/// Gives each contiguous piece of a variable on a tile, and each temporary, its own place with a red zone around it.
class Layout {
public:
    /// Places all variables. Throws if an element of a variable is on no tile.
    explicit Layout(GraphData const& graph)
        : graph_(graph), next_(graph.tiles, first_piece_at), variable_bytes_(graph.tiles), temporary_bytes_(graph.tiles),
          on_tile_(graph.tiles)
    {
        for (Variable const& variable : graph.variables) {
            std::size_t const element = element_bytes(variable.type);
            std::vector<Piece> pieces;
            std::size_t at = 0;
            for (Mapped const& m : variable.mapping) {
                if (m.begin != at) break;
                pieces.push_back({m.begin, m.end, m.tile, take(m.tile, (m.end - m.begin) * element)});
                std::size_t const stored = round_up((m.end - m.begin) * element, 4);
                variable_bytes_[m.tile] += stored;
                on_tile_[m.tile].emplace_back(static_cast<unsigned>(pieces_.size()), stored);
                at = m.end;
            }
            if (at != variable.elements)
                throw poplar::invalid_tile_mapping(
                    "Element " + std::to_string(at) + " of variable " + variable.name +
                    " is on no tile (its mapping leaves it out); call setTileMapping for all of it");
            pieces_.push_back(std::move(pieces));
        }
    }

    /// A place on a tile for a copy of an edge.
    Run temporary(unsigned tile, std::size_t bytes)
    {
        temporary_bytes_[tile] += round_up(bytes, 4);
        std::size_t const offset = take(tile, bytes);
        return {tile, offset, bytes, offset, offset + bytes};
    }

    /// Puts the arenas one after the other, each on its own pages. No place can be added afterwards. Returns the bytes of all arenas.
    std::size_t finish()
    {
        std::size_t const page = TileMemory::page();
        arenas_.assign(1, 0);
        for (std::size_t const end : next_) arenas_.push_back(arenas_.back() + round_up(end + red_zone, page));
        return arenas_.back();
    }
    std::size_t arena(unsigned tile) const { return arenas_[tile]; }
    std::size_t arena_bytes(unsigned tile) const { return arenas_[tile + 1] - arenas_[tile]; }
    /// The tile whose arena holds an offset.
    unsigned tile_at(std::size_t offset) const
    {
        return static_cast<unsigned>(std::upper_bound(arenas_.begin(), arenas_.end(), offset) - arenas_.begin()) - 1;
    }
    std::size_t place(Run const& run) const { return arenas_[run.tile] + run.offset; }

    /// The places of elements, in the order of the elements. Neighbours in one piece are one run.
    std::vector<Run> runs(std::vector<Interval> const& parts) const
    {
        std::vector<Run> result;
        for (Interval const& part : parts) {
            auto const& pieces = pieces_[part.variable];
            std::size_t const element = element_bytes(graph_.variables[part.variable].type);
            auto piece = std::upper_bound(pieces.begin(), pieces.end(), part.begin,
                                          [](std::size_t b, Piece const& p) { return b < p.begin; });
            --piece;
            for (std::size_t at = part.begin; at < part.end; ++piece) {
                std::size_t const end = std::min(part.end, piece->end),
                                  offset = piece->offset + (at - piece->begin) * element;
                std::size_t const bytes = (end - at) * element;
                if (!result.empty() && result.back().tile == piece->tile &&
                    result.back().offset + result.back().bytes == offset)
                    result.back().bytes += bytes;
                else
                    result.push_back(
                        {piece->tile, offset, bytes, piece->offset, piece->offset + (piece->end - piece->begin) * element});
                at = end;
            }
        }
        return result;
    }

    std::size_t variable_bytes(unsigned tile) const { return variable_bytes_[tile]; }
    /// The pieces of variables on a tile, with their stored bytes.
    std::vector<std::pair<unsigned, std::size_t>> const& pieces_on(unsigned tile) const { return on_tile_[tile]; }
    std::size_t temporary_bytes(unsigned tile) const { return temporary_bytes_[tile]; }
    std::size_t variables() const { return pieces_.size(); }

private:
    struct Piece {
        std::size_t begin, end;
        unsigned tile;
        std::size_t offset;
    };
    std::size_t take(unsigned tile, std::size_t bytes)
    {
        return std::exchange(next_[tile], round_up(next_[tile] + bytes + red_zone, piece_align));
    }

    GraphData const& graph_;
    std::vector<std::size_t> next_, variable_bytes_, temporary_bytes_;
    std::vector<std::vector<std::pair<unsigned, std::size_t>>> on_tile_; ///< variable, bytes
    std::vector<std::vector<Piece>> pieces_;                             ///< by variable, ascending
    std::vector<std::size_t> arenas_;
};

/// Elements that a vertex reads or writes. `who` is the caller's own number for the use.
struct Use {
    Interval part;
    bool writes;
    std::size_t who;
};

/// Two uses of one element, of which at least one writes; empty if there are none. Reorders `uses`.
inline std::optional<std::pair<Use, Use>> conflict(std::vector<Use>& uses)
{
    std::sort(uses.begin(), uses.end(), [](Use const& a, Use const& b) {
        return a.part.variable != b.part.variable ? a.part.variable < b.part.variable : a.part.begin < b.part.begin;
    });
    // `any` is the earlier use with the largest end, `writer` the earlier write with the largest end. A use that overlaps an earlier one
    // overlaps these too.
    Use const* any = nullptr;
    Use const* writer = nullptr;
    for (Use const& use : uses) {
        if (any != nullptr && any->part.variable != use.part.variable) any = writer = nullptr;
        if (use.writes && any != nullptr && any->part.end > use.part.begin) return std::pair{*any, use};
        if (writer != nullptr && writer->part.end > use.part.begin) return std::pair{*writer, use};
        if (any == nullptr || use.part.end > any->part.end) any = &use;
        if (use.writes && (writer == nullptr || use.part.end > writer->part.end)) writer = &use;
    }
    return std::nullopt;
}

} // namespace standin::detail
