#pragma once
#include "graph_data.hpp"
#include "layout.hpp"
#include "memory.hpp"
#include "reports.hpp"
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

/// Vertices and exchanges with places in tile memory.
namespace standin::detail {

/// A piece that an exchange moves.
struct Segment {
    unsigned char* to;
    unsigned char* from;
    std::size_t bytes;
};

/// Sixteen bytes beside an edge. The bytes under `mask` may not change while the edge's vertex computes.
struct Guard {
    std::array<std::uint64_t, 2> mask{}, saved{};
    void save(unsigned char const* at) { saved = {raw_load(at), raw_load(at + 8)}; }
    bool holds(unsigned char const* at) const
    {
        return ((raw_load(at) ^ saved[0]) & mask[0]) == 0 && ((raw_load(at + 8) ^ saved[1]) & mask[1]) == 0;
    }
};

/// An edge of a vertex, in one piece of its tile's memory.
struct BoundEdge {
    unsigned field;
    std::size_t index, elements;
    Run run;
    unsigned char* data = nullptr;
    Guard before{}, after{};
    std::uint64_t digest = 0;
};

struct BoundVertex {
    VertexType const* type;
    unsigned tile;
    std::vector<BoundEdge> edges; ///< ascending by field and index
    std::vector<Value> values;    ///< ascending by field and index
    std::vector<Edge> bound{};    ///< the memory of the vertex's fields: first the edges, then the values
    std::unique_ptr<void, void (*)(void*)> object{nullptr, nullptr};

    std::string name() const { return "Vertex " + type->name + " on tile " + std::to_string(tile); }
    std::string edge_name(BoundEdge const& edge) const { return field_name(type->fields[edge.field], edge.index); }
    Access access(BoundEdge const& edge) const { return type->fields[edge.field].access; }
};

struct BoundSet {
    std::string name;
    std::vector<BoundVertex> vertices;
    std::vector<std::pair<Run, Run>> gather_runs{}, scatter_runs{}; ///< from, to
    std::vector<Segment> gathers{}, scatters{};
    std::vector<unsigned> order{};
};

/// The address of a run.
inline unsigned char* address(Run const& run, Layout const& layout, TileMemory const& memory)
{
    return memory.at(layout.place(run));
}

/// Pairs of runs (from, to) as addresses. Neighbouring pairs become one segment.
inline std::vector<Segment> segments(std::vector<std::pair<Run, Run>> const& runs, Layout const& layout,
                                     TileMemory const& memory)
{
    std::vector<Segment> result;
    for (auto const& [from, to] : runs) {
        unsigned char* const source = address(from, layout, memory);
        unsigned char* const destination = address(to, layout, memory);
        if (!result.empty() && result.back().from + result.back().bytes == source &&
            result.back().to + result.back().bytes == destination)
            result.back().bytes += from.bytes;
        else result.push_back({destination, source, from.bytes});
    }
    return result;
}

/// The sum of words for each pair of tiles.
inline std::vector<Move> moves(std::vector<std::pair<Run, Run>> const& runs)
{
    std::map<std::pair<unsigned, unsigned>, std::size_t> bytes;
    for (auto const& [from, to] : runs) bytes[{from.tile, to.tile}] += from.bytes;
    std::vector<Move> result;
    for (auto const& [tiles, n] : bytes) result.push_back({tiles.first, tiles.second, round_up(n, 4) / 4});
    return result;
}

} // namespace standin::detail
