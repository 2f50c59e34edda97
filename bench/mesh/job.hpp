#pragma once
#include "traffic.hpp"
#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <tilemesh/engine/contract.hpp>
#include <tilemesh/engine/mesh.hpp>
#include <unistd.h>
#include <vector>

namespace traffic {

/// Records with random starts and destinations in `area`, the corner of a grid.
struct Load {
    Grid grid, area;
    std::uint32_t records;
};
/// The results of one run.
struct Run {
    double seconds = 0;
    std::uint64_t hops = 0, exchanges = 0;
};

inline std::int64_t resident_bytes()
{
    std::ifstream file("/proc/self/statm");
    std::int64_t all = 0, resident = 0;
    return file >> all >> resident ? resident * ::sysconf(_SC_PAGESIZE) : 0;
}

/// SplitMix64. It gives the same numbers with every compiler and library.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    std::uint32_t below(std::uint32_t n)
    {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return static_cast<std::uint32_t>(((z ^ (z >> 31)) >> 32) * n >> 32);
    }

private:
    std::uint64_t state_;
};

/// A load on a mesh. It is measured repeatedly, and checked each time.
class Job {
public:
    Job(Load const& load, Sizes sizes, std::uint32_t threads) : load_(load), sizes_(sizes), threads_(threads)
    {
        auto const before = resident_bytes();
        Random random{20240607};
        std::vector<std::uint32_t> to(load.area.size()), from(load.area.size());
        for (std::uint32_t id = 0; id < load.records; ++id) {
            auto const a = load.area.tile(random.below(load.area.size()));
            auto const b = load.area.tile(random.below(load.area.size()));
            starts_.push_back(a);
            ends_.push_back(b);
            distance_ += (a.x() > b.x() ? a.x() - b.x() : b.x() - a.x()) + (a.y() > b.y() ? a.y() - b.y() : b.y() - a.y());
            if (++from[load.area.index_of(a)] > sizes_.storage || ++to[load.area.index_of(b)] > sizes_.storage)
                throw Error("a tile with more than " + std::to_string(sizes_.storage) +
                            " records (its storage); use fewer records or more storage");
        }
        auto const machine = size_of_machine<TestMachine<64u << 20>>(); // room for any of the sizes, and any number of tiles
        mesh_ = std::make_unique<Mesh<Program, AnyMachine>>(Program{}, load.grid, mesh_sizes<Program>(machine, sizes),
                                                            MeshOptions{threads, false});
        run(); // touches all memory once
        rss_ = resident_bytes() - before;
    }

    Load const& load() const { return load_; }
    std::uint32_t capacity() const { return sizes_.slots; }
    std::uint32_t threads() const { return threads_; }
    std::int64_t rss_bytes() const { return rss_; }

    /// Places all records, moves them, and checks every one: it is on its tile, once, with its payload, and the machine counted the
    /// distances of all records. Throws Error if a check fails.
    Run run()
    {
        for (std::uint32_t id = 0; id < load_.records; ++id) place(id, starts_[id], ends_[id]);
        auto const begin = std::chrono::steady_clock::now();
        auto const counters = mesh_->run();
        Run run;
        run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        run.hops = counters.messages();
        run.exchanges = counters.exchanges();
        check(run.hops);
        return run;
    }
    /// The seconds of a superstep with one record under way, from corner to corner of the area.
    double idle_seconds()
    {
        double ms = 0;
        std::uint64_t passes = 0;
        for (int i = 0; i < 20; ++i) {
            auto const last = TileId::at(load_.area.width - 1, load_.area.height - 1);
            place(0, TileId::at(0, 0), last);
            auto const counters = mesh_->run();
            ms += counters.steps[1].milliseconds;
            passes += counters.steps[1].passes;
            auto arrived = mesh_->state<Arrived>(last);
            if (counters.messages() != load_.area.width + load_.area.height - 2 || arrived.size() != 1)
                throw Error("a single record that did not arrive (a bug of this program or the mesh); report this");
            arrived.truncate(0);
        }
        return ms / 1000 / static_cast<double>(passes);
    }

private:
    void place(std::uint32_t id, TileId from, TileId to)
    {
        Record r{id, to, {}};
        for (std::uint32_t i = 0; i < 13; ++i) r.payload[i] = payload_word(id, i);
        mesh_->state<Leaving>(from).push(r);
    }
    /// Checks all arrivals and empties the mesh.
    void check(std::uint64_t hops)
    {
        auto const require = [](bool holds, char const* what) {
            if (!holds) throw Error(std::string("a wrong result: ") + what + " (a bug of this program or the mesh); report this");
        };
        std::vector<std::uint8_t> seen(load_.records, 0);
        std::uint64_t found = 0;
        for (std::uint32_t t = 0; t < load_.area.size(); ++t) {
            auto const tile = load_.area.tile(t);
            auto arrived = mesh_->state<Arrived>(tile);
            for (Record const& r : arrived) {
                require(r.to == tile, "a record on another tile");
                require(r.id < load_.records && ends_[r.id] == tile && seen[r.id]++ == 0, "a record twice, or one that never was");
                for (std::uint32_t i = 0; i < 13; ++i) require(r.payload[i] == payload_word(r.id, i), "a changed payload");
                ++found;
            }
            arrived.truncate(0);
            require(mesh_->state<Leaving>(tile).empty() &&
                        mesh_->state<Waiting<0>>(tile).empty() &&
                        mesh_->state<Waiting<1>>(tile).empty(),
                    "a record left behind");
            require(mesh_->state<Traffic>(tile).refused == 0, "a full storage");
        }
        require(found == load_.records, "records lost");
        require(hops == distance_, "hops that are not the distances");
    }

    Load load_;
    Sizes sizes_;
    std::uint32_t threads_;
    std::int64_t rss_ = 0;
    std::vector<TileId> starts_, ends_;
    std::uint64_t distance_ = 0;
    std::unique_ptr<Mesh<Program, AnyMachine>> mesh_;
};

} // namespace traffic
