#pragma once
#include "../poplar/exceptions.hpp"
#include "bound.hpp"
#include "graph_data.hpp"
#include "layout.hpp"
#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace standin::detail {

/// Gives the edges of vertices their places. Where Poplar would add an exchange of its own, it adds temporaries to the layout.
class Binder {
public:
    Binder(GraphData const& graph, Layout& layout) : graph_(graph), layout_(layout), state_bytes_(graph.tiles) {}

    /// A compute set with its edges placed. Throws if something is missing, or if two uses are in conflict.
    BoundSet bind(ComputeSet const& set)
    {
        BoundSet bound{set.name, {}};
        bound.vertices.reserve(set.vertices.size());
        std::vector<Use> uses;
        for (Vertex const& vertex : set.vertices) {
            if (vertex.tile == no_tile)
                throw poplar::invalid_tile_mapping("Vertex " + vertex.type->name + " of compute set " + set.name +
                                                   " is on no tile (it was never mapped); call setTileMapping for it");
            bound.vertices.push_back(bind_vertex(vertex, bound, uses));
        }
        if (auto const both = conflict(uses)) refuse(set, both->first, both->second);
        require_whole_words(bound);
        return bound;
    }

    /// Bytes of vertex state, by tile.
    std::vector<std::size_t> const& state_bytes() const { return state_bytes_; }

private:
    /// Refuses two vertices that write parts of one word. The machine stores a part of a word by reading and writing the whole
    /// word, so workers that do this at once lose each other's bytes.
    void require_whole_words(BoundSet const& set) const
    {
        std::vector<Use> words;
        for (std::size_t v = 0; v < set.vertices.size(); ++v) {
            BoundVertex const& vertex = set.vertices[v];
            std::vector<Interval> own;
            for (BoundEdge const& edge : vertex.edges)
                if (vertex.access(edge) != Access::input && vertex.type->fields[edge.field].element_bytes < 4 &&
                    edge.run.bytes != 0)
                    own.push_back({vertex.tile, edge.run.offset / 4, round_up(edge.run.offset + edge.run.bytes, 4) / 4});
            std::sort(own.begin(), own.end(), [](Interval const& a, Interval const& b) { return a.begin < b.begin; });
            std::size_t end = 0;
            for (Interval part : own) {
                part.begin = std::max(part.begin, end);
                end = std::max(part.end, end);
                if (part.begin < part.end) words.push_back({part, true, v});
            }
        }
        if (auto const both = conflict(words))
            throw poplar::graph_program_compilation_error(
                "Compute set " + set.name + " writes parts of one word by two vertices (" +
                set.vertices[both->first.who].name() + " and another " + set.vertices[both->second.who].type->name +
                " there; stores are of whole words); give each a variable of its own, or one vertex both");
    }

    BoundVertex bind_vertex(Vertex const& vertex, BoundSet& set, std::vector<Use>& uses)
    {
        BoundVertex bound{vertex.type, vertex.tile, {}, {}};
        std::vector<Connection const*> connections;
        for (Connection const& c : vertex.connections) connections.push_back(&c);
        std::stable_sort(connections.begin(), connections.end(), [](Connection const* a, Connection const* b) {
            return a->field != b->field ? a->field < b->field : a->index < b->index;
        });
        bound.edges.reserve(connections.size());
        auto next = connections.begin();
        for (unsigned f = 0; f < vertex.type->fields.size(); ++f) {
            Field const& field = vertex.type->fields[f];
            std::size_t const list = vertex.list_sizes[f], wanted = field.rank == 2 ? list : 1;
            if (field.rank == 2 && list == no_size)
                throw poplar::no_size_specified(vertex_name(vertex) + ", field " + field.name +
                                                " has no size (it is a list); call setFieldSize");
            if (field.access == Access::value) {
                bind_values(vertex, f, wanted, bound.values);
            } else {
                for (std::size_t i = 0; i < wanted; ++i, ++next) {
                    if (next == connections.end() || (*next)->field != f || (*next)->index != i)
                        throw poplar::graph_connection_error(vertex_name(vertex) + ", field " + field_name(field, i) +
                                                             " is unconnected (no tensor was given); call connect for it");
                    bind_edge(vertex, **next, bound, set, uses);
                }
                if (next != connections.end() && (*next)->field == f)
                    throw poplar::graph_connection_error(
                        vertex_name(vertex) + ", field " + field_name(field, (*next)->index) +
                        " is connected twice (or beyond its list's size); connect one tensor to each place");
            }
            state_bytes_[vertex.tile] +=
                round_up(field.state_bytes + (field.rank == 2 ? list * field.inner_state_bytes : 0), 4);
        }
        return bound;
    }

    static void bind_values(Vertex const& vertex, unsigned field, std::size_t wanted, std::vector<Value>& into)
    {
        for (std::size_t i = 0; i < wanted; ++i) {
            auto const value = std::find_if(vertex.values.begin(), vertex.values.end(),
                                            [&](Value const& v) { return v.field == field && v.index == i; });
            if (value == vertex.values.end())
                throw poplar::graph_connection_error(vertex_name(vertex) + ", field " +
                                                     field_name(vertex.type->fields[field], i) +
                                                     " has no value (it is a plain member); call setInitialValue for it");
            into.push_back(*value);
        }
    }

    /// Uses an edge in place if it is one aligned piece on its vertex's tile. Otherwise a temporary on that tile replaces it.
    void bind_edge(Vertex const& vertex, Connection const& connection, BoundVertex& bound, BoundSet& set,
                   std::vector<Use>& uses)
    {
        Field const& field = vertex.type->fields[connection.field];
        bool const writes = field.access != Access::input;
        for (Interval const& part : connection.parts) {
            if (writes && graph_.variables[part.variable].constant)
                throw poplar::graph_connection_error(
                    vertex_name(vertex) + ", field " + field_name(field, connection.index) +
                    " is connected to the constant " + graph_.variables[part.variable].name +
                    " (the vertex may write it); connect a variable or make it an Input");
            uses.push_back({part, writes, set.vertices.size() | static_cast<std::size_t>(connection.field) << 32});
        }
        std::vector<Run> const runs = layout_.runs(connection.parts);
        std::size_t bytes = 0;
        for (Run const& run : runs) bytes += run.bytes;
        BoundEdge edge{connection.field,
                       connection.index,
                       bytes / field.element_bytes,
                       {vertex.tile, empty_edge_at, 0, empty_edge_at, empty_edge_at}};
        if (runs.size() == 1 && runs[0].tile == vertex.tile && runs[0].offset % std::max(field.align, 1u) == 0) {
            edge.run = runs[0];
        } else if (!runs.empty()) {
            edge.run = layout_.temporary(vertex.tile, bytes);
            Run part = edge.run;
            for (Run const& run : runs) {
                part.bytes = run.bytes;
                if (field.access != Access::output) set.gather_runs.emplace_back(run, part);
                if (writes) set.scatter_runs.emplace_back(part, run);
                part.offset += run.bytes;
            }
        }
        bound.edges.push_back(edge);
    }

    [[noreturn]] void refuse(ComputeSet const& set, Use const& a, Use const& b) const
    {
        auto const describe = [&](Use const& use) {
            Vertex const& vertex = set.vertices[use.who & 0xffffffffu];
            return "field " + vertex.type->fields[use.who >> 32].name + " of " + vertex_name(vertex) +
                   (use.writes ? " writes" : " reads");
        };
        throw poplar::graph_program_compilation_error(
            "Compute set " + set.name + " touches element " + std::to_string(std::max(a.part.begin, b.part.begin)) +
            " of variable " + graph_.variables[a.part.variable].name + " twice (" + describe(a) + " it, " + describe(b) +
            " it, at once); give one of them a compute set or a tensor of its own");
    }

    GraphData const& graph_;
    Layout& layout_;
    std::vector<std::size_t> state_bytes_;
};

} // namespace standin::detail
