#pragma once
#include "../poplar/Type.hpp"
#include "../standin_vertex.hpp"
#include <algorithm>
#include <cstddef>
#include <deque>
#include <string>
#include <utility>
#include <vector>

/// The data of a Graph, which its Tensors, VertexRefs and Engines read.
namespace standin::detail {

/// Elements [begin, end) of a variable.
struct Interval {
    unsigned variable;
    std::size_t begin, end;
    friend bool operator==(Interval const& a, Interval const& b)
    {
        return a.variable == b.variable && a.begin == b.begin && a.end == b.end;
    }
};

/// Adds an interval to a list. If it continues the last interval, it becomes part of that one.
inline void append(std::vector<Interval>& list, Interval more)
{
    if (more.begin == more.end) return;
    if (!list.empty() && list.back().variable == more.variable && list.back().end == more.begin) list.back().end = more.end;
    else list.push_back(more);
}

/// Elements [begin, end) of a variable lie on `tile`.
struct Mapped {
    std::size_t begin, end;
    unsigned tile;
};

struct Variable {
    std::string name;
    poplar::Type type;
    std::size_t elements;
    std::vector<Mapped> mapping; ///< ascending, disjoint, neighbours on one tile merged
    bool constant = false;
    std::vector<unsigned char> contents{}; ///< the bytes of a constant

    /// Maps [begin, end) to a tile and replaces any older mapping. Cost: constant if it comes after all mapped elements.
    void map(std::size_t begin, std::size_t end, unsigned tile)
    {
        if (begin == end) return;
        if (!mapping.empty() && begin < mapping.back().end) clear(begin, end);
        auto at = mapping.end();
        if (!mapping.empty() && begin < mapping.back().end)
            at = std::upper_bound(mapping.begin(), mapping.end(), begin,
                                  [](std::size_t b, Mapped const& m) { return b < m.begin; });
        bool const joins_left = at != mapping.begin() && std::prev(at)->end == begin && std::prev(at)->tile == tile;
        bool const joins_right = at != mapping.end() && at->begin == end && at->tile == tile;
        if (joins_left && joins_right) {
            std::prev(at)->end = at->end;
            mapping.erase(at);
        } else if (joins_left) {
            std::prev(at)->end = end;
        } else if (joins_right) {
            at->begin = begin;
        } else {
            mapping.insert(at, {begin, end, tile});
        }
    }

private:
    void clear(std::size_t begin, std::size_t end)
    {
        std::vector<Mapped> kept;
        for (Mapped const& m : mapping) {
            if (m.begin < std::min(m.end, begin)) kept.push_back({m.begin, std::min(m.end, begin), m.tile});
            if (std::max(m.begin, end) < m.end) kept.push_back({std::max(m.begin, end), m.end, m.tile});
        }
        mapping = std::move(kept);
    }
};

/// A tensor at a place of a field. `index` is 0 except for a list of vectors.
struct Connection {
    unsigned field;
    std::size_t index;
    std::vector<Interval> parts;
};

/// The bytes of a plain member, or of a table that the vertex keeps. `index` is 0 except for a list of tables.
struct Value {
    unsigned field;
    std::size_t index, elements;
    std::vector<unsigned char> bytes;
};

inline constexpr unsigned no_tile = ~0u;

struct Vertex {
    VertexType const* type;
    unsigned tile = no_tile;
    std::vector<std::size_t> list_sizes; ///< by field; `no_size` if it was never set
    std::vector<Connection> connections;
    std::vector<Value> values;
};
inline constexpr std::size_t no_size = ~std::size_t{0};

struct ComputeSet {
    std::string name;
    std::deque<Vertex> vertices;
};

struct GraphData {
    unsigned tiles = 0;
    std::size_t tile_bytes = 0;
    bool has_codelets = false;
    std::deque<Variable> variables;
    std::deque<ComputeSet> compute_sets;
    std::vector<std::string> streams; ///< handles of the streams
};

/// The name of a vertex in errors.
inline std::string vertex_name(Vertex const& vertex)
{
    return "Vertex " + vertex.type->name +
           (vertex.tile == no_tile ? std::string(" on no tile") : " on tile " + std::to_string(vertex.tile));
}

/// The name of a field, or of one vector of a list, in errors.
inline std::string field_name(Field const& field, std::size_t index)
{
    return field.rank == 2 ? field.name + "[" + std::to_string(index) + "]" : field.name;
}

} // namespace standin::detail
