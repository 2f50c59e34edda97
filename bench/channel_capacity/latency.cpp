#include "latency.hpp"
#include "machine.hpp"
#include <algorithm>
#include <cstdlib>
#include <map>
#include <tilemesh/error.hpp>
#include <tilemesh/splat/projection.hpp>
#include <unordered_map>

namespace channel_capacity {

namespace {

struct Journey {
    std::uint32_t home = 0; ///< index of the new anchor tile
    std::uint32_t distance = 0;
};

std::uint32_t steps_between(std::uint32_t a, std::uint32_t b)
{
    auto const along = [](std::uint32_t p, std::uint32_t q) { return p > q ? p - q : q - p; };
    return along(a % grid_columns, b % grid_columns) + along(a / grid_columns, b / grid_columns);
}
std::uint64_t key(splat::GaussianId id, std::uint32_t tile)
{
    return std::uint64_t{static_cast<std::uint32_t>(id)} << 32 | tile;
}

} // namespace

Latency follow(Scene const& scene, std::string const& motion, std::uint32_t hops, std::filesystem::path const& data,
               std::vector<std::string>& broken)
{
    auto const cameras = cameras_of(motion, scene, 1, data);
    auto const& camera = cameras.back();
    auto const machine = make_machine(Saturation::hold, scene.map, {.hops = hops});
    machine->render(cameras.front()); // makes the mesh
    machine->limit_hops(0);
    machine->render(cameras.front());
    machine->limit_hops(hops);

    // The destination of each record, and the tiles on which its copies must be.
    std::unordered_map<splat::GaussianId, std::uint32_t> from;
    for (auto const& stored : machine->stored())
        if (stored.home) from.emplace(stored.id, stored.tile);
    auto const view = splat::make_view(camera, machine->rules());
    auto const tiling = splat::make_tiling(camera.width, camera.height, (camera.width + grid_columns - 1) / grid_columns,
                                           (camera.height + grid_rows - 1) / grid_rows);
    std::unordered_map<splat::GaussianId, Journey> journeys;
    std::unordered_map<std::uint64_t, std::uint32_t> copies; // by id and tile: the frame after which it is expected
    Latency result;
    for (auto const& g : scene.map.gaussians) {
        auto const s = splat::project(g, view, tiling);
        if (!s.visible()) continue;
        auto const home = s.anchor.y() * grid_columns + s.anchor.x();
        auto const distance = steps_between(from.at(g.id), home);
        journeys.emplace(g.id, Journey{home, distance});
        auto const r = s.rect();
        for (auto y = r.y0 / tiling.tile_height; y <= (r.y1 - 1) / tiling.tile_height; ++y)
            for (auto x = r.x0 / tiling.tile_width; x <= (r.x1 - 1) / tiling.tile_width; ++x) {
                auto const tile = y * grid_columns + x;
                if (tile != home) copies.emplace(key(g.id, tile), distance / hops + steps_between(tile, home) / hops);
            }
    }
    result.copies = copies.size();

    std::map<std::uint32_t, std::vector<std::uint32_t>> late_at; // distance -> frames late, one a record
    std::uint64_t late_copies = 0;
    std::uint32_t const most_frames = 4 * (grid_columns + grid_rows) + 4;
    for (std::uint32_t frame = 0; !journeys.empty() || !copies.empty(); ++frame) {
        if (frame == most_frames)
            throw tilemesh::Error("records of " + scene.map.name + " that do not arrive (" + std::to_string(journeys.size()) +
                                  " records and " + std::to_string(copies.size()) + " copies after " + std::to_string(frame) +
                                  " frames); report this");
        machine->render(camera);
        auto const& report = machine->report();
        result.refused += report.refused.by_channels() + report.refused.by_storage();
        for (auto const& stored : machine->stored()) {
            if (stored.home) {
                auto const at = journeys.find(stored.id);
                if (at == journeys.end() || at->second.home != stored.tile) continue;
                late_at[at->second.distance].push_back(frame);
                journeys.erase(at);
            } else if (auto const copy = copies.find(key(stored.id, stored.tile)); copy != copies.end()) {
                result.copies_on_time += copy->second == frame ? 1 : 0;
                late_copies += copy->second < frame ? 1 : 0;
                copies.erase(copy);
            }
        }
        result.frames_until_complete = frame;
    }

    auto const name = scene.map.name + ", " + std::to_string(hops) + " hops a frame";
    for (auto& [distance, late] : late_at) {
        std::sort(late.begin(), late.end());
        LatencyRow const row{scene.map.name, hops,           distance, late.size(), late.front(), late[(late.size() - 1) / 2],
                             late.back(),    distance / hops};
        result.rows.push_back(row);
        if (result.refused == 0 && (row.late_min != row.expected || row.late_max != row.expected))
            broken.push_back(name + ": a Gaussian that moves " + std::to_string(distance) + " tiles is late " +
                             std::to_string(row.late_min) + " to " + std::to_string(row.late_max) + " frames, not " +
                             std::to_string(row.expected));
    }
    if (result.refused == 0 && late_copies != 0)
        broken.push_back(name + ": " + std::to_string(late_copies) + " copies are later than their distance says");
    return result;
}

} // namespace channel_capacity
