#pragma once
#include "../poplar/Program.hpp"
#include "graph_data.hpp"
#include "layout.hpp"
#include "memory.hpp"
#include "reports.hpp"
#include "settings.hpp"
#include "workers.hpp"
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

/// What an Engine is inside: a graph and its programs, laid out and resolved to addresses, and their execution.
namespace standin::detail {

/// A piece that an exchange moves.
struct Segment {
    unsigned char* to;
    unsigned char* from;
    std::size_t bytes;
};

/// Sixteen bytes beside an edge: those under `mask` may not change while its vertex computes.
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
    std::vector<Value> values;    ///< the same
    std::vector<Edge> bound{};    ///< what the vertex's fields point at: the edges, the values
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

/// A program, with its operands as addresses.
struct Operation {
    poplar::program::Program::Kind kind;
    std::string name;
    std::vector<std::size_t> children{};
    std::size_t compute_set = 0, count = 0;
    std::string stream{};
    std::vector<Segment> segments{};
    std::vector<Move> moves{};
    unsigned char const* predicate = nullptr;
};

class Executable {
public:
    using Program = poplar::program::Program;

    Executable(std::shared_ptr<GraphData const> graph, std::vector<Program> programs)
        : graph_(std::move(graph)), programs_(std::move(programs)), layout_(*graph_), state_bytes_(graph_->tiles), code_bytes_(settings().code_bytes)
    {
        for (ComputeSet const& set : graph_->compute_sets)
            sets_.push_back(bind_set(set));
        require_fit();
        memory_.map(layout_.finish());
        for (BoundSet& set : sets_)
            resolve(set);
        for (Program const& program : programs_)
            roots_.push_back(compile(program));
        for (std::string const& handle : graph_->streams)
            streams_[handle];
        reset();
    }

    /// As a device is after loading: constants written, vertices made, everything else undefined.
    void reset()
    {
        memory_.forget();
        for (unsigned v = 0; v < layout_.variables(); ++v)
            if (v < graph_->variables.size() && graph_->variables[v].constant)
                write_constant(v);
        for (BoundSet& set : sets_)
            for (BoundVertex& vertex : set.vertices)
                make(vertex);
    }

    void connect(std::string const& handle, void* begin, void* end)
    {
        auto const stream = streams_.find(handle);
        if (stream == streams_.end())
            throw poplar::stream_connection_error("There is no stream " + handle + " (the graph added none of that name); name one that it has");
        stream->second = {static_cast<unsigned char*>(begin), static_cast<unsigned char*>(end), static_cast<unsigned char*>(begin), true};
    }

    void run(unsigned program)
    {
        if (program >= roots_.size())
            throw poplar::control_program_error("There is no program " + std::to_string(program) + " (the engine has " +
                                                std::to_string(roots_.size()) + "); run one that it has");
        counts_ = {};
        random_.seed(settings().seed);
        run_operation(roots_[program]);
    }

    std::size_t programs() const { return roots_.size(); }
    Counts const& counts() const { return counts_; }

    TileBytes tile_bytes(unsigned tile) const
    {
        TileBytes bytes;
        for (unsigned v = 0; v < layout_.variables(); ++v)
            if (std::size_t const n = layout_.variable_bytes(tile, v))
                bytes.variables[graph_->variables[v].name] += n;
        bytes.temporaries = layout_.temporary_bytes(tile);
        bytes.vertex_state = state_bytes_[tile];
        bytes.code = code_bytes_;
        return bytes;
    }

    std::vector<Exchange> exchanges() const
    {
        std::vector<Exchange> all;
        for (Operation const& operation : operations_)
            if (operation.kind == Program::Kind::copy)
                all.push_back({Exchange::Kind::copy, operation.name, operation.moves});
        for (BoundSet const& set : sets_) {
            if (!set.gather_runs.empty())
                all.push_back({Exchange::Kind::gather, set.name, moves(set.gather_runs)});
            if (!set.scatter_runs.empty())
                all.push_back({Exchange::Kind::scatter, set.name, moves(set.scatter_runs)});
        }
        return all;
    }

    std::vector<Move> moves_of(Program const& copy) const
    {
        auto const found = compiled_.find(&copy.node());
        if (found == compiled_.end() || copy.node().kind != Program::Kind::copy)
            throw poplar::control_program_error("A program has no moves (it is no Copy between tensors of this engine); ask for such a Copy");
        return operations_[found->second].moves;
    }

private:
    // Building.

    BoundSet bind_set(ComputeSet const& set)
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
        if (auto const both = conflict(uses))
            refuse(set, both->first, both->second);
        return bound;
    }

    BoundVertex bind_vertex(Vertex const& vertex, BoundSet& set, std::vector<Use>& uses)
    {
        BoundVertex bound{vertex.type, vertex.tile, {}, {}};
        std::vector<Connection const*> connections;
        for (Connection const& c : vertex.connections)
            connections.push_back(&c);
        std::stable_sort(connections.begin(), connections.end(), [](Connection const* a, Connection const* b) {
            return a->field != b->field ? a->field < b->field : a->index < b->index;
        });
        bound.edges.reserve(connections.size());
        auto next = connections.begin();
        for (unsigned f = 0; f < vertex.type->fields.size(); ++f) {
            Field const& field = vertex.type->fields[f];
            std::size_t const list = vertex.list_sizes[f], wanted = field.rank == 2 ? list : 1;
            if (field.rank == 2 && list == no_size)
                throw poplar::no_size_specified(vertex_name(vertex) + ", field " + field.name + " has no size (it is a list); call setFieldSize");
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
                    throw poplar::graph_connection_error(vertex_name(vertex) + ", field " + field_name(field, (*next)->index) +
                                                         " is connected twice (or beyond its list's size); connect one tensor to each place");
            }
            state_bytes_[vertex.tile] += round_up(field.state_bytes + (field.rank == 2 ? list * field.inner_state_bytes : 0), 4);
        }
        return bound;
    }

    static void bind_values(Vertex const& vertex, unsigned field, std::size_t wanted, std::vector<Value>& into)
    {
        for (std::size_t i = 0; i < wanted; ++i) {
            auto const value = std::find_if(vertex.values.begin(), vertex.values.end(),
                [&](Value const& v) { return v.field == field && v.index == i; });
            if (value == vertex.values.end())
                throw poplar::graph_connection_error(vertex_name(vertex) + ", field " + field_name(vertex.type->fields[field], i) +
                                                     " has no value (it is a plain member); call setInitialValue for it");
            into.push_back(*value);
        }
    }

    /// An edge is used where it lies when that is one aligned piece of the vertex's own tile; else a temporary there takes its place.
    void bind_edge(Vertex const& vertex, Connection const& connection, BoundVertex& bound, BoundSet& set, std::vector<Use>& uses)
    {
        Field const& field = vertex.type->fields[connection.field];
        bool const writes = field.access != Access::input;
        for (Interval const& part : connection.parts) {
            if (writes && graph_->variables[part.variable].constant)
                throw poplar::graph_connection_error(vertex_name(vertex) + ", field " + field_name(field, connection.index) +
                                                     " is connected to the constant " + graph_->variables[part.variable].name +
                                                     " (the vertex may write it); connect a variable or make it an Input");
            uses.push_back({part, writes, set.vertices.size() | static_cast<std::size_t>(connection.field) << 32});
        }
        std::vector<Run> const runs = layout_.runs(connection.parts);
        std::size_t bytes = 0;
        for (Run const& run : runs)
            bytes += run.bytes;
        BoundEdge edge{connection.field, connection.index, bytes / field.element_bytes, {vertex.tile, empty_edge_at, 0, empty_edge_at, empty_edge_at}};
        if (runs.size() == 1 && runs[0].tile == vertex.tile && runs[0].offset % std::max(field.align, 1u) == 0) {
            edge.run = runs[0];
        } else if (!runs.empty()) {
            edge.run = layout_.temporary(vertex.tile, bytes);
            Run part = edge.run;
            for (Run const& run : runs) {
                part.bytes = run.bytes;
                if (field.access != Access::output)
                    set.gather_runs.emplace_back(run, part);
                if (writes)
                    set.scatter_runs.emplace_back(part, run);
                part.offset += run.bytes;
            }
        }
        bound.edges.push_back(edge);
    }

    [[noreturn]] void refuse(ComputeSet const& set, Use const& a, Use const& b) const
    {
        auto const describe = [&](Use const& use) {
            Vertex const& vertex = set.vertices[use.who & 0xffffffffu];
            return "field " + vertex.type->fields[use.who >> 32].name + " of " + vertex_name(vertex) + (use.writes ? " writes" : " reads");
        };
        throw poplar::graph_program_compilation_error("Compute set " + set.name + " touches element " +
            std::to_string(std::max(a.part.begin, b.part.begin)) + " of variable " + graph_->variables[a.part.variable].name + " twice (" +
            describe(a) + " it, " + describe(b) + " it, at once); give one of them a compute set or a tensor of its own");
    }

    void require_fit() const
    {
        for (unsigned tile = 0; tile < graph_->tiles; ++tile) {
            std::size_t const variables = layout_.variable_bytes(tile), temporaries = layout_.temporary_bytes(tile);
            std::size_t const sum = variables + temporaries + state_bytes_[tile] + code_bytes_;
            if (sum > graph_->tile_bytes)
                throw poplar::graph_memory_allocation_error("Tile " + std::to_string(tile) + " holds " + std::to_string(sum) + " bytes, " +
                    std::to_string(sum - graph_->tile_bytes) + " more than its " + std::to_string(graph_->tile_bytes) + " (variables " +
                    std::to_string(variables) + ", temporaries " + std::to_string(temporaries) + ", vertices " +
                    std::to_string(state_bytes_[tile]) + ", code " + std::to_string(code_bytes_) + "); make its variables smaller");
        }
    }

    void resolve(BoundSet& set)
    {
        for (BoundVertex& vertex : set.vertices) {
            for (BoundEdge& edge : vertex.edges)
                edge.data = address(edge.run);
            for (BoundEdge& edge : vertex.edges) {
                edge.before.mask = guard_mask(vertex, edge.data - red_zone);
                edge.after.mask = guard_mask(vertex, edge.data + edge.run.bytes);
                vertex.bound.push_back({edge.data, edge.elements});
            }
            for (Value& value : vertex.values)
                vertex.bound.push_back({value.bytes.data(), value.elements});
        }
        set.gathers = segments(set.gather_runs);
        set.scatters = segments(set.scatter_runs);
        set.order.resize(set.vertices.size());
    }

    /// Which of the sixteen bytes at `at` no edge of the vertex may write.
    static std::array<std::uint64_t, 2> guard_mask(BoundVertex const& vertex, unsigned char const* at)
    {
        std::array<std::uint64_t, 2> mask{~std::uint64_t{0}, ~std::uint64_t{0}};
        for (BoundEdge const& other : vertex.edges) {
            if (vertex.access(other) == Access::input || other.data >= at + red_zone || other.data + other.run.bytes <= at)
                continue;
            auto* const bytes = reinterpret_cast<unsigned char*>(mask.data());
            for (std::size_t i = 0; i < red_zone; ++i)
                if (at + i >= other.data && at + i < other.data + other.run.bytes)
                    bytes[i] = 0;
        }
        return mask;
    }

    unsigned char* address(Run const& run) const { return memory_.at(layout_.place(run)); }

    std::vector<Segment> segments(std::vector<std::pair<Run, Run>> const& runs) const
    {
        std::vector<Segment> result;
        for (auto const& [from, to] : runs) {
            unsigned char* const source = address(from);
            unsigned char* const destination = address(to);
            if (!result.empty() && result.back().from + result.back().bytes == source && result.back().to + result.back().bytes == destination)
                result.back().bytes += from.bytes;
            else
                result.push_back({destination, source, from.bytes});
        }
        return result;
    }

    /// Sums what goes from tile to tile.
    static std::vector<Move> moves(std::vector<std::pair<Run, Run>> const& runs)
    {
        std::map<std::pair<unsigned, unsigned>, std::size_t> bytes;
        for (auto const& [from, to] : runs)
            bytes[{from.tile, to.tile}] += from.bytes;
        std::vector<Move> result;
        for (auto const& [tiles, n] : bytes)
            result.push_back({tiles.first, tiles.second, round_up(n, 4) / 4});
        return result;
    }

    std::size_t compile(Program const& program)
    {
        Program::Node const& node = program.node();
        if (auto const found = compiled_.find(&node); found != compiled_.end())
            return found->second;
        Operation operation{node.kind, node.name};
        operation.count = node.count;
        for (Program const& child : node.children)
            operation.children.push_back(compile(child));
        for (poplar::Tensor const* tensor : {&node.source, &node.destination})
            if (tensor->valid() && tensor->graph() != graph_.get())
                throw poplar::control_program_error("A program uses a tensor of another graph (an engine knows one); use tensors of its graph");
        switch (node.kind) {
        case Program::Kind::sequence:
        case Program::Kind::repeat: break;
        case Program::Kind::execute:
            operation.compute_set = node.compute_set.getId();
            if (operation.compute_set >= sets_.size())
                throw poplar::control_program_error("An Execute has no compute set (the graph made none such); give one that addComputeSet returned");
            break;
        case Program::Kind::while_true: operation.predicate = address(layout_.runs(node.source.parts())[0]); break;
        case Program::Kind::copy: compile_copy(node, operation); break;
        case Program::Kind::to_device:
        case Program::Kind::from_device: compile_stream(node, operation); break;
        }
        operations_.push_back(std::move(operation));
        compiled_.emplace(&node, operations_.size() - 1);
        return operations_.size() - 1;
    }

    std::string variable_of(poplar::Tensor const& tensor) const
    {
        return tensor.parts().empty() ? "nothing" : graph_->variables[tensor.parts()[0].variable].name;
    }

    void require_writable(poplar::Tensor const& tensor, std::string const& copy) const
    {
        for (Interval const& part : tensor.parts())
            if (graph_->variables[part.variable].constant)
                throw poplar::control_program_error("Copy " + copy + " writes constant " + graph_->variables[part.variable].name +
                                                    " (constants keep their value); copy to a variable");
    }

    void compile_copy(Program::Node const& node, Operation& operation) const
    {
        poplar::Tensor const& source = node.source;
        poplar::Tensor const& destination = node.destination;
        if (operation.name.empty())
            operation.name = variable_of(source) + " -> " + variable_of(destination);
        require_writable(destination, operation.name);
        if (source.parts() == destination.parts())
            return;
        std::vector<Use> uses;
        for (Interval const& part : source.parts())
            uses.push_back({part, false, 0});
        for (Interval const& part : destination.parts())
            uses.push_back({part, true, 1});
        if (auto const both = conflict(uses))
            throw poplar::control_program_error("Copy " + operation.name + " touches element " +
                std::to_string(std::max(both->first.part.begin, both->second.part.begin)) + " of variable " +
                graph_->variables[both->first.part.variable].name + " twice (" +
                (both->first.writes && both->second.writes ? "its destination has it twice" : "it is in its source and destination") +
                "); copy by way of another variable");
        std::vector<Run> const from = layout_.runs(source.parts()), to = layout_.runs(destination.parts());
        std::vector<std::pair<Run, Run>> pairs;
        std::size_t f = 0, t = 0, from_used = 0, to_used = 0;
        while (f < from.size() && t < to.size()) {
            std::size_t const n = std::min(from[f].bytes - from_used, to[t].bytes - to_used);
            Run a = from[f], b = to[t];
            a.offset += from_used;
            b.offset += to_used;
            a.bytes = b.bytes = n;
            pairs.emplace_back(a, b);
            if ((from_used += n) == from[f].bytes)
                ++f, from_used = 0;
            if ((to_used += n) == to[t].bytes)
                ++t, to_used = 0;
        }
        operation.segments = segments(pairs);
        operation.moves = moves(pairs);
    }

    void compile_stream(Program::Node const& node, Operation& operation) const
    {
        bool const to_device = node.kind == Program::Kind::to_device;
        poplar::Tensor const& tensor = to_device ? node.destination : node.source;
        operation.stream = node.stream[0].handle();
        if (operation.name.empty())
            operation.name = to_device ? operation.stream + " -> " + variable_of(tensor) : variable_of(tensor) + " -> " + operation.stream;
        if (streamless(operation.stream))
            throw poplar::stream_connection_error("There is no stream " + operation.stream + " (another graph added it); add it to this one");
        if (to_device) {
            require_writable(tensor, operation.name);
            std::vector<Use> uses;
            for (Interval const& part : tensor.parts())
                uses.push_back({part, true, 0});
            if (conflict(uses))
                throw poplar::control_program_error("Copy " + operation.name + " writes an element twice (its destination repeats it); " +
                                                    "copy to a tensor without repetition");
        }
        for (Run const& run : layout_.runs(tensor.parts()))
            operation.segments.push_back({address(run), address(run), run.bytes});
    }
    bool streamless(std::string const& handle) const
    {
        return std::find(graph_->streams.begin(), graph_->streams.end(), handle) == graph_->streams.end();
    }

    // Loading.

    void write_constant(unsigned variable)
    {
        Variable const& constant = graph_->variables[variable];
        std::size_t done = 0;
        for (Run const& run : layout_.runs({{variable, 0, constant.elements}})) {
            raw_copy(address(run), constant.contents.data() + done, run.bytes);
            done += run.bytes;
        }
    }

    /// Writes the canaries beside an edge, where these bytes are red zone.
    void guard(BoundEdge const& edge)
    {
        std::size_t const arena = layout_.arena(edge.run.tile), begin = edge.run.offset, end = begin + edge.run.bytes;
        write_canaries(arena + begin - red_zone, arena + std::min(begin, edge.run.piece_begin));
        write_canaries(arena + std::max(end, edge.run.piece_end), arena + end + red_zone);
    }
    void write_canaries(std::size_t begin, std::size_t end)
    {
        for (std::size_t at = begin; at < end; ++at) {
            unsigned char const byte = canary(at);
            raw_copy(memory_.at(at), &byte, 1);
        }
    }

    void make(BoundVertex& vertex)
    {
        for (BoundEdge const& edge : vertex.edges)
            guard(edge);
        vertex.object = {vertex.type->make(), vertex.type->destroy};
        std::size_t edge = 0, value = vertex.edges.size();
        for (unsigned f = 0; f < vertex.type->fields.size(); ++f) {
            Field const& field = vertex.type->fields[f];
            std::size_t n = 0, first = 0;
            if (field.access == Access::value) {
                first = value;
                while (value < vertex.bound.size() && vertex.values[value - vertex.edges.size()].field == f)
                    ++value, ++n;
            } else {
                first = edge;
                while (edge < vertex.edges.size() && vertex.edges[edge].field == f)
                    ++edge, ++n;
            }
            try {
                field.bind(vertex.object.get(), vertex.bound.data() + first, n);
            } catch (std::invalid_argument const& error) {
                throw poplar::graph_connection_error(vertex.name() + ", field " + field.name + " cannot hold what it is given (" + error.what() +
                                                     "); connect something that fits");
            }
        }
    }

    // Running.

    void run_operation(std::size_t index)
    {
        Operation const& operation = operations_[index];
        switch (operation.kind) {
        case Program::Kind::sequence:
            for (std::size_t const child : operation.children)
                run_operation(child);
            break;
        case Program::Kind::repeat:
            for (std::size_t i = 0; i < operation.count; ++i)
                run_operation(operation.children[0]);
            break;
        case Program::Kind::while_true:
            for (std::uint64_t pass = 0; test(operation, pass); ++pass)
                run_operation(operation.children[1]);
            break;
        case Program::Kind::execute: execute(sets_[operation.compute_set]); break;
        case Program::Kind::copy:
            for (Segment const& s : operation.segments)
                raw_copy(s.to, s.from, s.bytes);
            ++counts_.copies;
            ++counts_.by_name[operation.name];
            break;
        case Program::Kind::to_device:
        case Program::Kind::from_device: transfer(operation); break;
        }
    }

    bool test(Operation const& operation, std::uint64_t pass)
    {
        run_operation(operation.children[0]);
        unsigned char value;
        raw_copy(&value, operation.predicate, 1);
        if (value > 1)
            throw poplar::application_runtime_error("A RepeatWhileTrue has a predicate that is no bool (its byte is " + std::to_string(value) +
                                                    ", as where nobody wrote it); write it in the condition");
        if (value == 1 && pass >= settings().while_limit)
            throw poplar::application_runtime_error("A RepeatWhileTrue did not end (its predicate is still true after " +
                                                    std::to_string(pass) + " passes); let the condition become false, or raise while_limit");
        return value == 1;
    }

    struct Stream {
        unsigned char* begin = nullptr;
        unsigned char* end = nullptr; ///< nullptr: the same place each time
        unsigned char* next = nullptr;
        bool connected = false; ///< also to nullptr, where nothing is transferred
    };

    void transfer(Operation const& operation)
    {
        Stream& stream = streams_[operation.stream];
        if (!stream.connected)
            throw poplar::stream_connection_error("Stream " + operation.stream + " goes nowhere (no memory was connected); call connectStream");
        unsigned char* at = stream.next;
        for (Segment const& s : operation.segments) {
            if (operation.kind == Program::Kind::to_device)
                raw_copy(s.to, at, s.bytes);
            else
                raw_copy(at, s.from, s.bytes);
            at += s.bytes;
        }
        if (stream.end != nullptr)
            stream.next = at >= stream.end ? stream.begin : at;
        ++counts_.host_copies;
        ++counts_.by_name[operation.name];
    }

    template <class List>
    void arrange(List& list, Order order)
    {
        std::iota(list.begin(), list.end(), 0u);
        if (order == Order::descending)
            std::reverse(list.begin(), list.end());
        if (order == Order::permuted)
            for (std::size_t i = list.size(); i > 1; --i)
                std::swap(list[i - 1], list[random_() % i]);
    }

    /// While it lives, pages of no tile can be touched but of one.
    class Closed {
    public:
        Closed(TileMemory& memory, Layout const& layout, bool active) : memory_(memory), layout_(layout), active_(active)
        {
            if (active_)
                memory_.protect_all(false);
        }
        Closed(Closed const&) = delete;
        Closed& operator=(Closed const&) = delete;
        ~Closed()
        {
            if (active_)
                memory_.protect_all(true);
        }
        void open(unsigned tile, bool open)
        {
            if (active_)
                memory_.protect(layout_.arena(tile), layout_.arena_bytes(tile), open);
        }

    private:
        TileMemory& memory_;
        Layout const& layout_;
        bool active_;
    };

    void execute(BoundSet& set)
    {
        for (Segment const& s : set.gathers)
            raw_copy(s.to, s.from, s.bytes);
        arrange(set.order, settings().vertices);
        bool const pages = settings().isolation == Isolation::pages;
        {
            std::unique_ptr<FaultNet> const net = pages ? std::make_unique<FaultNet>() : nullptr;
            std::unique_ptr<HandlerStack> const stack = pages ? std::make_unique<HandlerStack>() : nullptr;
            Closed closed(memory_, layout_, pages);
            for (unsigned const v : set.order) {
                closed.open(set.vertices[v].tile, true);
                compute(set.vertices[v], pages);
                closed.open(set.vertices[v].tile, false);
            }
        }
        for (Segment const& s : set.scatters)
            raw_copy(s.to, s.from, s.bytes);
        ++counts_.executes;
        ++counts_.by_name[set.name];
        counts_.vertices += set.vertices.size();
    }

    /// While it lives, AddressSanitizer lets a vertex touch its edges.
    class Open {
    public:
        explicit Open(BoundVertex const& vertex) : vertex_(vertex)
        {
            for (BoundEdge const& edge : vertex_.edges)
                open_to_asan(edge.data, edge.run.bytes);
        }
        Open(Open const&) = delete;
        Open& operator=(Open const&) = delete;
        ~Open()
        {
            // To whole granules of eight bytes: what an edge shares one with was opened with it.
            for (BoundEdge const& edge : vertex_.edges) {
                std::size_t const lead = reinterpret_cast<std::uintptr_t>(edge.data) % 8;
                close_to_asan(edge.data - lead, round_up(lead + edge.run.bytes, 8));
            }
        }

    private:
        BoundVertex const& vertex_;
    };

    void compute(BoundVertex& vertex, bool in_net)
    {
        bool const check_inputs = settings().check_inputs;
        for (BoundEdge& edge : vertex.edges) {
            if (vertex.access(edge) == Access::output)
                fill_poison(edge.data, edge.run.bytes);
        }
        for (BoundEdge& edge : vertex.edges) {
            edge.before.save(edge.data - red_zone);
            edge.after.save(edge.data + edge.run.bytes);
            if (check_inputs && vertex.access(edge) == Access::input)
                edge.digest = digest(edge.data, edge.run.bytes);
        }
        {
            Open const open(vertex);
            run_workers(vertex, in_net);
        }
        for (BoundEdge const& edge : vertex.edges) {
            if (!edge.before.holds(edge.data - red_zone))
                throw poplar::application_runtime_error(vertex.name() + " wrote before the start of its field " + vertex.edge_name(edge) + " of " +
                    std::to_string(edge.elements) + " elements (the bytes there changed); write within the field");
            if (!edge.after.holds(edge.data + edge.run.bytes))
                throw poplar::application_runtime_error(vertex.name() + " wrote past the end of its field " + vertex.edge_name(edge) + " of " +
                    std::to_string(edge.elements) + " elements (the bytes there changed); write within the field");
            if (check_inputs && vertex.access(edge) == Access::input && edge.digest != digest(edge.data, edge.run.bytes))
                throw poplar::application_runtime_error(vertex.name() + " changed its Input " + vertex.edge_name(edge) +
                                                        " (an Input is read only); make it an InOut");
        }
    }

    void run_workers(BoundVertex const& vertex, bool in_net)
    {
        auto const call = [&](unsigned worker) {
            void* address = nullptr;
            if (!in_net)
                vertex.type->compute(vertex.object.get(), worker);
            else if (!compute_in_net(*vertex.type, vertex.object.get(), worker, address))
                throw poplar::application_runtime_error(vertex.name() + " touched memory " + whose(address) +
                                                        " (a vertex reaches the tensors connected to it alone); connect what it needs");
        };
        if (vertex.type->kind != Kind::multi) {
            call(0);
            return;
        }
        std::array<unsigned, workers_per_tile> order;
        arrange(order, settings().workers);
        if (!settings().threads) {
            for (unsigned const worker : order)
                call(worker);
            return;
        }
        if (!threads_)
            threads_ = std::make_unique<WorkerThreads>();
        threads_->run(call, order);
    }

    std::string whose(void const* address) const
    {
        return memory_.holds(address) ? "of tile " + std::to_string(layout_.tile_at(memory_.offset(address))) : std::string("of no tile");
    }

    std::shared_ptr<GraphData const> graph_;
    std::vector<Program> programs_;
    Layout layout_;
    std::vector<std::size_t> state_bytes_;
    std::size_t code_bytes_;
    std::vector<BoundSet> sets_;
    TileMemory memory_;
    std::vector<Operation> operations_; ///< children before parents
    std::unordered_map<Program::Node const*, std::size_t> compiled_;
    std::vector<std::size_t> roots_;
    std::map<std::string, Stream> streams_;
    Counts counts_;
    std::mt19937 random_;
    std::unique_ptr<WorkerThreads> threads_;
};

} // namespace standin::detail
