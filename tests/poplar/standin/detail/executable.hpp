#pragma once
#include "../poplar/Program.hpp"
#include "binder.hpp"
#include "bound.hpp"
#include "computing.hpp"
#include "graph_data.hpp"
#include "layout.hpp"
#include "memory.hpp"
#include "reports.hpp"
#include "settings.hpp"
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

/// The inside of an Engine: a graph and its programs, laid out and resolved to addresses, and their execution.
namespace standin::detail {

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
        : graph_(std::move(graph)), programs_(std::move(programs)), layout_(*graph_), binder_(*graph_, layout_),
          code_bytes_(settings().code_bytes)
    {
        for (ComputeSet const& set : graph_->compute_sets) sets_.push_back(binder_.bind(set));
        require_fit();
        memory_.map(layout_.finish());
        for (BoundSet& set : sets_) computing_.resolve(set);
        for (Program const& program : programs_) roots_.push_back(compile(program));
        for (std::string const& handle : graph_->streams) streams_[handle];
        reset();
    }

    /// The state of a device after loading: constants are written, vertices are made, everything else is undefined.
    void reset()
    {
        memory_.forget();
        for (unsigned v = 0; v < layout_.variables(); ++v)
            if (graph_->variables[v].constant) write_constant(v);
        for (BoundSet& set : sets_)
            for (BoundVertex& vertex : set.vertices) computing_.make(vertex);
    }

    void connect(std::string const& handle, void* begin, void* end)
    {
        find_stream(handle) = {static_cast<unsigned char*>(begin), static_cast<unsigned char*>(end),
                               static_cast<unsigned char*>(begin), true, {}, {}};
    }
    void connect(std::string const& handle, std::function<void(void*)> callback)
    {
        find_stream(handle) = {nullptr, nullptr, nullptr, true, std::move(callback), {}};
    }

    void run(unsigned program)
    {
        if (program >= roots_.size())
            throw poplar::control_program_error("There is no program " + std::to_string(program) + " (the engine has " +
                                                std::to_string(roots_.size()) + "); run one that it has");
        before_.add(counts_);
        counts_ = {};
        computing_.seed(settings().seed);
        run_operation(roots_[program]);
    }

    std::size_t programs() const { return roots_.size(); }
    Counts const& counts() const { return counts_; }
    Counts all_counts() const
    {
        Counts all = before_;
        all.add(counts_);
        return all;
    }

    TileBytes tile_bytes(unsigned tile) const
    {
        if (tile >= graph_->tiles)
            throw poplar::invalid_tile_mapping("There is no tile " + std::to_string(tile) + " (the target has " +
                                               std::to_string(graph_->tiles) + "); ask for one that it has");
        TileBytes bytes;
        for (auto const& [variable, stored] : layout_.pieces_on(tile))
            bytes.variables[graph_->variables[variable].name] += stored;
        bytes.temporaries = layout_.temporary_bytes(tile);
        bytes.vertex_state = binder_.state_bytes()[tile];
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
            if (!set.gather_runs.empty()) all.push_back({Exchange::Kind::gather, set.name, moves(set.gather_runs)});
            if (!set.scatter_runs.empty()) all.push_back({Exchange::Kind::scatter, set.name, moves(set.scatter_runs)});
        }
        return all;
    }

    std::vector<Move> moves_of(Program const& copy) const
    {
        auto const found = compiled_.find(&copy.node());
        if (found == compiled_.end() || copy.node().kind != Program::Kind::copy)
            throw poplar::control_program_error(
                "A program has no moves (it is no Copy between tensors of this engine); ask for such a Copy");
        return operations_[found->second].moves;
    }

private:
    void require_fit() const
    {
        for (unsigned tile = 0; tile < graph_->tiles; ++tile) {
            std::size_t const variables = layout_.variable_bytes(tile), temporaries = layout_.temporary_bytes(tile);
            std::size_t const sum = variables + temporaries + binder_.state_bytes()[tile] + code_bytes_;
            if (sum > graph_->tile_bytes)
                throw poplar::graph_memory_allocation_error(
                    "Tile " + std::to_string(tile) + " holds " + std::to_string(sum) + " bytes, " +
                    std::to_string(sum - graph_->tile_bytes) + " more than its " + std::to_string(graph_->tile_bytes) +
                    " (variables " + std::to_string(variables) + ", temporaries " + std::to_string(temporaries) +
                    ", vertices " + std::to_string(binder_.state_bytes()[tile]) + ", code " + std::to_string(code_bytes_) +
                    "); make its variables smaller");
        }
    }

    std::size_t compile(Program const& program)
    {
        Program::Node const& node = program.node();
        if (auto const found = compiled_.find(&node); found != compiled_.end()) return found->second;
        Operation operation{node.kind, node.name};
        operation.count = node.count;
        for (Program const& child : node.children) operation.children.push_back(compile(child));
        for (poplar::Tensor const* tensor : {&node.source, &node.destination})
            if (tensor->valid() && tensor->graph() != graph_.get())
                throw poplar::control_program_error(
                    "A program uses a tensor of another graph (an engine knows one); use tensors of its graph");
        switch (node.kind) {
        case Program::Kind::sequence:
        case Program::Kind::repeat:
            break;
        case Program::Kind::execute:
            operation.compute_set = node.compute_set.getId();
            if (operation.compute_set >= sets_.size())
                throw poplar::control_program_error(
                    "An Execute has no compute set (the graph made none such); give one that addComputeSet returned");
            break;
        case Program::Kind::while_true:
        case Program::Kind::condition:
            operation.predicate = address(layout_.runs(node.source.parts())[0], layout_, memory_);
            break;
        case Program::Kind::copy:
            compile_copy(node, operation);
            break;
        case Program::Kind::to_device:
        case Program::Kind::from_device:
            compile_stream(node, operation);
            break;
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
                throw poplar::control_program_error("Copy " + copy + " writes constant " +
                                                    graph_->variables[part.variable].name +
                                                    " (constants keep their value); copy to a variable");
    }

    void compile_copy(Program::Node const& node, Operation& operation) const
    {
        poplar::Tensor const& source = node.source;
        poplar::Tensor const& destination = node.destination;
        if (operation.name.empty()) operation.name = variable_of(source) + " -> " + variable_of(destination);
        require_writable(destination, operation.name);
        if (source.parts() == destination.parts()) return;
        std::vector<Use> uses;
        for (Interval const& part : source.parts()) uses.push_back({part, false, 0});
        for (Interval const& part : destination.parts()) uses.push_back({part, true, 1});
        if (auto const both = conflict(uses))
            throw poplar::control_program_error(
                "Copy " + operation.name + " touches element " +
                std::to_string(std::max(both->first.part.begin, both->second.part.begin)) + " of variable " +
                graph_->variables[both->first.part.variable].name + " twice (" +
                (both->first.writes && both->second.writes ? "its destination has it twice"
                                                           : "it is in its source and destination") +
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
            if ((from_used += n) == from[f].bytes) ++f, from_used = 0;
            if ((to_used += n) == to[t].bytes) ++t, to_used = 0;
        }
        operation.segments = segments(pairs, layout_, memory_);
        operation.moves = moves(pairs);
    }

    void compile_stream(Program::Node const& node, Operation& operation) const
    {
        bool const to_device = node.kind == Program::Kind::to_device;
        poplar::Tensor const& tensor = to_device ? node.destination : node.source;
        operation.stream = node.stream[0].handle();
        if (operation.name.empty())
            operation.name = to_device ? operation.stream + " -> " + variable_of(tensor)
                                       : variable_of(tensor) + " -> " + operation.stream;
        if (streamless(operation.stream))
            throw poplar::stream_connection_error("There is no stream " + operation.stream +
                                                  " (another graph added it); add it to this one");
        if (to_device) {
            require_writable(tensor, operation.name);
            std::vector<Use> uses;
            for (Interval const& part : tensor.parts()) uses.push_back({part, true, 0});
            if (conflict(uses))
                throw poplar::control_program_error("Copy " + operation.name +
                                                    " writes an element twice (its destination repeats it); " +
                                                    "copy to a tensor without repetition");
        }
        for (Run const& run : layout_.runs(tensor.parts()))
            operation.segments.push_back({address(run, layout_, memory_), address(run, layout_, memory_), run.bytes});
    }
    bool streamless(std::string const& handle) const
    {
        return std::find(graph_->streams.begin(), graph_->streams.end(), handle) == graph_->streams.end();
    }

    void write_constant(unsigned variable)
    {
        Variable const& constant = graph_->variables[variable];
        std::size_t done = 0;
        for (Run const& run : layout_.runs({{variable, 0, constant.elements}})) {
            raw_copy(address(run, layout_, memory_), constant.contents.data() + done, run.bytes);
            done += run.bytes;
        }
    }

    void run_operation(std::size_t index)
    {
        Operation const& operation = operations_[index];
        switch (operation.kind) {
        case Program::Kind::sequence:
            for (std::size_t const child : operation.children) run_operation(child);
            break;
        case Program::Kind::repeat:
            for (std::size_t i = 0; i < operation.count; ++i) run_operation(operation.children[0]);
            break;
        case Program::Kind::while_true:
            for (std::uint64_t pass = 0; test(operation, pass); ++pass) run_operation(operation.children[1]);
            break;
        case Program::Kind::condition:
            run_operation(operation.children[predicate(operation) ? 0 : 1]);
            break;
        case Program::Kind::execute: {
            BoundSet& set = sets_[operation.compute_set];
            computing_.execute(set);
            ++counts_.executes;
            ++counts_.by_name[set.name];
            counts_.vertices += set.vertices.size();
            break;
        }
        case Program::Kind::copy:
            for (Segment const& s : operation.segments) raw_copy(s.to, s.from, s.bytes);
            ++counts_.copies;
            ++counts_.by_name[operation.name];
            break;
        case Program::Kind::to_device:
        case Program::Kind::from_device:
            transfer(operation);
            break;
        }
    }

    bool test(Operation const& operation, std::uint64_t pass)
    {
        run_operation(operation.children[0]);
        bool const value = predicate(operation);
        if (value && pass >= settings().while_limit)
            throw poplar::application_runtime_error("A RepeatWhileTrue did not end (its predicate is still true after " +
                                                    std::to_string(pass) +
                                                    " passes); let the condition become false, or raise while_limit");
        return value;
    }
    bool predicate(Operation const& operation) const
    {
        unsigned char value;
        raw_copy(&value, operation.predicate, 1);
        if (value > 1)
            throw poplar::application_runtime_error(std::string(operation.kind == Program::Kind::condition ? "An If" : "A RepeatWhileTrue") +
                                                    " has a predicate that is no bool (its byte is " + std::to_string(value) +
                                                    ", as where nobody wrote it); write it in the condition");
        return value == 1;
    }

    struct Stream {
        unsigned char* begin = nullptr;
        unsigned char* end = nullptr; ///< nullptr: each transfer starts at `begin`
        unsigned char* next = nullptr;
        bool connected = false; ///< true also for memory at nullptr, if the stream moves no data
        std::function<void(void*)> callback; ///< gets the data that a transfer from the device wrote to `buffer`
        std::vector<unsigned char> buffer;
    };
    Stream& find_stream(std::string const& handle)
    {
        auto const stream = streams_.find(handle);
        if (stream == streams_.end())
            throw poplar::stream_connection_error("There is no stream " + handle +
                                                  " (the graph added none of that name); name one that it has");
        return stream->second;
    }

    void transfer(Operation const& operation)
    {
        Stream& stream = streams_[operation.stream];
        if (!stream.connected)
            throw poplar::stream_connection_error("Stream " + operation.stream +
                                                  " goes nowhere (no memory was connected); call connectStream");
        if (stream.callback) {
            std::size_t bytes = 0;
            for (Segment const& s : operation.segments)
                bytes += s.bytes;
            stream.buffer.resize(bytes);
            stream.next = stream.buffer.data();
        }
        unsigned char* at = stream.next;
        for (Segment const& s : operation.segments) {
            if (operation.kind == Program::Kind::to_device) raw_copy(s.to, at, s.bytes);
            else raw_copy(at, s.from, s.bytes);
            at += s.bytes;
        }
        if (stream.callback) stream.callback(stream.buffer.data());
        if (stream.end != nullptr) stream.next = at >= stream.end ? stream.begin : at;
        ++counts_.host_copies;
        ++counts_.by_name[operation.name];
    }

    std::shared_ptr<GraphData const> graph_;
    std::vector<Program> programs_;
    Layout layout_;
    Binder binder_;
    std::size_t code_bytes_;
    std::vector<BoundSet> sets_;
    TileMemory memory_;
    std::vector<Operation> operations_; ///< children before parents
    std::unordered_map<Program::Node const*, std::size_t> compiled_;
    std::vector<std::size_t> roots_;
    std::map<std::string, Stream> streams_;
    Counts counts_, before_; // counts of this run, counts of the runs before it
    Computing computing_{layout_, memory_};
};

} // namespace standin::detail
