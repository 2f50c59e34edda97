#pragma once
#include "../poplar/exceptions.hpp"
#include "bound.hpp"
#include "layout.hpp"
#include "memory.hpp"
#include "settings.hpp"
#include "workers.hpp"
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace standin::detail {

/// Executes compute sets in tile memory, with the checks that the settings ask for.
class Computing {
public:
    Computing(Layout const& layout, TileMemory& memory) : layout_(layout), memory_(memory) {}

    /// Restarts the permutations of orders.
    void seed(unsigned seed) { random_.seed(seed); }

    /// Turns places into addresses. The memory must be mapped before.
    void resolve(BoundSet& set)
    {
        for (BoundVertex& vertex : set.vertices) {
            for (BoundEdge& edge : vertex.edges) edge.data = address(edge.run, layout_, memory_);
            for (BoundEdge& edge : vertex.edges) {
                edge.before.mask = guard_mask(vertex, edge.data - red_zone);
                edge.after.mask = guard_mask(vertex, edge.data + edge.run.bytes);
                vertex.bound.push_back({edge.data, edge.elements});
            }
            for (Value& value : vertex.values) vertex.bound.push_back({value.bytes.data(), value.elements});
        }
        set.gathers = segments(set.gather_runs, layout_, memory_);
        set.scatters = segments(set.scatter_runs, layout_, memory_);
        set.order.resize(set.vertices.size());
    }

    /// Makes a new vertex object and points its fields at its edges.
    void make(BoundVertex& vertex)
    {
        for (BoundEdge const& edge : vertex.edges) guard(edge);
        vertex.object = {vertex.type->make(), vertex.type->destroy};
        std::size_t edge = 0, value = vertex.edges.size();
        for (unsigned f = 0; f < vertex.type->fields.size(); ++f) {
            Field const& field = vertex.type->fields[f];
            std::size_t n = 0, first = 0;
            if (field.access == Access::value) {
                first = value;
                while (value < vertex.bound.size() && vertex.values[value - vertex.edges.size()].field == f) ++value, ++n;
            } else {
                first = edge;
                while (edge < vertex.edges.size() && vertex.edges[edge].field == f) ++edge, ++n;
            }
            try {
                field.bind(vertex.object.get(), vertex.bound.data() + first, n);
            } catch (std::invalid_argument const& error) {
                throw poplar::graph_connection_error(vertex.name() + ", field " + field.name +
                                                     " cannot hold what it is given (" + error.what() +
                                                     "); connect something that fits");
            }
        }
    }

    /// Gathers edges, computes each vertex, scatters edges.
    void execute(BoundSet& set)
    {
        for (Segment const& s : set.gathers) raw_copy(s.to, s.from, s.bytes);
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
        for (Segment const& s : set.scatters) raw_copy(s.to, s.from, s.bytes);
    }

private:
    /// A mask of the bytes among the sixteen at `at` that no edge of the vertex may write.
    static std::array<std::uint64_t, 2> guard_mask(BoundVertex const& vertex, unsigned char const* at)
    {
        std::array<std::uint64_t, 2> mask{~std::uint64_t{0}, ~std::uint64_t{0}};
        for (BoundEdge const& other : vertex.edges) {
            if (vertex.access(other) == Access::input || other.data >= at + red_zone || other.data + other.run.bytes <= at)
                continue;
            auto* const bytes = reinterpret_cast<unsigned char*>(mask.data());
            for (std::size_t i = 0; i < red_zone; ++i)
                if (at + i >= other.data && at + i < other.data + other.run.bytes) bytes[i] = 0;
        }
        return mask;
    }

    /// Writes the canaries beside an edge, but only to bytes of a red zone.
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

    template <class List>
    void arrange(List& list, Order order)
    {
        std::iota(list.begin(), list.end(), 0u);
        if (order == Order::descending) std::reverse(list.begin(), list.end());
        if (order == Order::permuted)
            for (std::size_t i = list.size(); i > 1; --i) std::swap(list[i - 1], list[random_() % i]);
    }

    /// During its lifetime, the pages of all tiles are closed, except those that open() opens.
    class Closed {
    public:
        Closed(TileMemory& memory, Layout const& layout, bool active) : memory_(memory), layout_(layout), active_(active)
        {
            if (active_) memory_.protect_all(false);
        }
        Closed(Closed const&) = delete;
        Closed& operator=(Closed const&) = delete;
        ~Closed()
        {
            if (active_) memory_.protect_all(true);
        }
        void open(unsigned tile, bool open)
        {
            if (active_) memory_.protect(layout_.arena(tile), layout_.arena_bytes(tile), open);
        }

    private:
        TileMemory& memory_;
        Layout const& layout_;
        bool active_;
    };

    /// During its lifetime, AddressSanitizer lets a vertex touch its edges.
    class Open {
    public:
        explicit Open(BoundVertex const& vertex) : vertex_(vertex)
        {
            for (BoundEdge const& edge : vertex_.edges) open_to_asan(edge.data, edge.run.bytes);
        }
        Open(Open const&) = delete;
        Open& operator=(Open const&) = delete;
        ~Open()
        {
            // Closes whole granules of eight bytes. Bytes that share a granule with the edge were opened with it.
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
            if (vertex.access(edge) == Access::output) fill_poison(edge.data, edge.run.bytes);
        }
        for (BoundEdge& edge : vertex.edges) {
            edge.before.save(edge.data - red_zone);
            edge.after.save(edge.data + edge.run.bytes);
            if (check_inputs && vertex.access(edge) == Access::input) edge.digest = digest(edge.data, edge.run.bytes);
        }
        {
            Open const open(vertex);
            run_workers(vertex, in_net);
        }
        for (BoundEdge const& edge : vertex.edges) {
            if (!edge.before.holds(edge.data - red_zone))
                throw poplar::application_runtime_error(vertex.name() + " wrote before the start of its field " +
                                                        vertex.edge_name(edge) + " of " + std::to_string(edge.elements) +
                                                        " elements (the bytes there changed); write within the field");
            if (!edge.after.holds(edge.data + edge.run.bytes))
                throw poplar::application_runtime_error(vertex.name() + " wrote past the end of its field " +
                                                        vertex.edge_name(edge) + " of " + std::to_string(edge.elements) +
                                                        " elements (the bytes there changed); write within the field");
            if (check_inputs && vertex.access(edge) == Access::input && edge.digest != digest(edge.data, edge.run.bytes))
                throw poplar::application_runtime_error(vertex.name() + " changed its Input " + vertex.edge_name(edge) +
                                                        " (an Input is read only); make it an InOut");
        }
    }

    void run_workers(BoundVertex const& vertex, bool in_net)
    {
        auto const call = [&](unsigned worker) {
            void* address = nullptr;
            if (!in_net) vertex.type->compute(vertex.object.get(), worker);
            else if (!compute_in_net(*vertex.type, vertex.object.get(), worker, address))
                throw poplar::application_runtime_error(
                    vertex.name() + " touched memory " + whose(address) +
                    " (a vertex reaches the tensors connected to it alone); connect what it needs");
        };
        if (vertex.type->kind != Kind::multi) {
            call(0);
            return;
        }
        std::array<unsigned, workers_per_tile> order;
        arrange(order, settings().workers);
        if (!settings().threads) {
            for (unsigned const worker : order) call(worker);
            return;
        }
        if (!threads_) threads_ = std::make_unique<WorkerThreads>();
        threads_->run(call, order);
    }

    std::string whose(void const* address) const
    {
        return memory_.holds(address) ? "of tile " + std::to_string(layout_.tile_at(memory_.offset(address)))
                                      : std::string("of no tile");
    }

    Layout const& layout_;
    TileMemory& memory_;
    std::mt19937 random_;
    std::unique_ptr<WorkerThreads> threads_;
};

} // namespace standin::detail
