#include "tables.hpp"
#include "views.hpp"
#include <algorithm>
#include <common/scenes.hpp>
#include <map>
#include <tilemesh/error.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/report/plot.hpp>
#include <unordered_map>

namespace paper {

namespace {

/// The frames by which Gaussians are late whose anchor moved by `distance` tiles. A frame is late if the record is not on its anchor tile at
/// the end of the frame. 0: it was there in the frame that saw the new view.
struct Delay {
    std::uint32_t distance = 0;
    std::uint64_t gaussians = 0;
    std::uint32_t least = 0, median = 0, most = 0;
};
struct Found {
    std::vector<Delay> delays;
    std::uint32_t frames_until_complete = 0;
    std::uint64_t refused = 0; ///< by a full channel; above 0 there is no expectation
    std::string broken;        ///< the first expectation that does not hold
};

/// Settles a machine on the scene's camera, jumps to the first camera of `teleport`, and follows every Gaussian until all are on their tiles.
///
/// The expectation, if no channel is full: a record at distance d leaves in the first of its supersteps and is stored in superstep d + 1,
/// and a frame has `hops` supersteps. So it is floor(d / hops) frames late; with one hop per frame, exactly d. Bloom begins in the frame in
/// which the record arrives, with the same number of supersteps. So its copy on a tile that is b steps away on the tree is at most floor(b
/// / hops) frames later, and earlier if the tile had a copy already.
Found follow(bench::Scene const& scene, std::uint32_t hops, Context const& context)
{
    auto const cameras = bench::cameras_of("teleport", scene, 1, context.data);
    auto const& camera = cameras.back();
    auto setup = splat::setup_of<splat::Lossless>();
    setup.machine = tilemesh::size_of_machine<splat::RoomyMachine>();
    setup.sizes.storage = 20'000;
    setup.sizes.road = setup.sizes.beam = setup.sizes.waiting = 8'192; // nothing is known to fill so many
    auto const machine = bench::make_traced_machine(scene.map, setup, {.grid = {grid_columns, grid_rows}, .hops = hops});
    machine->render(cameras.front()); // makes the mesh
    machine->limit_hops(0);
    machine->render(cameras.front());
    machine->limit_hops(hops);

    // The destination of each record, and the tiles on which its copies must be.
    struct Journey {
        std::uint32_t home, distance; ///< index of the new anchor tile
    };
    auto const key = [](splat::GaussianId id, std::uint32_t tile) { return std::uint64_t{static_cast<std::uint32_t>(id)} << 32 | tile; };
    std::unordered_map<splat::GaussianId, std::uint32_t> from;
    for (auto const& stored : machine->stored())
        if (stored.home) from.emplace(stored.id, stored.tile);
    auto const view = splat::make_view(camera, machine->rules());
    auto const tiling = tiling_of(camera);
    std::unordered_map<splat::GaussianId, Journey> journeys;
    std::unordered_map<std::uint64_t, std::uint32_t> copies; // by id and tile: the frame after which it is expected
    for (auto const& g : scene.map.gaussians) {
        auto const s = splat::project(g, view, tiling);
        if (!s.visible()) continue;
        auto const home = index_of(s.anchor), distance = hops_between(from.at(g.id), home);
        journeys.emplace(g.id, Journey{home, distance});
        for_each_tile(s, tiling, [&](std::uint32_t tile) {
            if (tile != home) copies.emplace(key(g.id, tile), distance / hops + hops_between(tile, home) / hops);
        });
    }

    Found found;
    auto const breaks = [&](std::string const& what) {
        if (found.refused == 0 && found.broken.empty()) found.broken = std::to_string(hops) + " hops a frame: " + what;
    };
    std::map<std::uint32_t, std::vector<std::uint32_t>> late_at; // distance -> frames late, one a record
    std::uint64_t late_copies = 0;
    std::uint32_t const most_frames = 4 * (grid_columns + grid_rows) + 4;
    for (std::uint32_t frame = 0; !journeys.empty() || !copies.empty(); ++frame) {
        if (frame == most_frames)
            throw tilemesh::Error("records of " + scene.map.name + " that do not arrive (" + std::to_string(journeys.size()) + " records and " +
                                  std::to_string(copies.size()) + " copies after " + std::to_string(frame) + " frames); report this");
        machine->render(camera);
        auto const& report = machine->report();
        found.refused += report.refused.by_channels() + report.refused.by_storage();
        for (auto const& stored : machine->stored()) {
            if (stored.home) {
                auto const at = journeys.find(stored.id);
                if (at == journeys.end() || at->second.home != stored.tile) continue;
                late_at[at->second.distance].push_back(frame);
                journeys.erase(at);
            } else if (auto const copy = copies.find(key(stored.id, stored.tile)); copy != copies.end()) {
                late_copies += copy->second < frame ? 1 : 0;
                copies.erase(copy);
            }
        }
        found.frames_until_complete = frame;
    }
    for (auto& [distance, late] : late_at) {
        std::sort(late.begin(), late.end());
        found.delays.push_back({distance, late.size(), late.front(), late[(late.size() - 1) / 2], late.back()});
        if (late.front() != distance / hops || late.back() != distance / hops)
            breaks("a Gaussian that moves " + std::to_string(distance) + " tiles is late " + std::to_string(late.front()) + " to " +
                   std::to_string(late.back()) + " frames, not " + std::to_string(distance / hops));
    }
    if (late_copies != 0) breaks(std::to_string(late_copies) + " copies are later than their distance says");
    return found;
}

} // namespace

void latency(Context const& context, Rows& rows)
{
    report::Plot plot;
    plot.title = "Frames until a Gaussian is on its new anchor tile";
    plot.x = {.label = "tiles that its anchor moved"};
    plot.y = {.label = "frames", .low = 0};
    for (std::string const name : {"sloth", "salad", "built_in"}) {
        bool const is_there = bench::has_scene(name, context.data);
        if (!is_there || (context.quick && (name == "salad" || (name == "built_in" && !context.data.empty())))) {
            rows.push_back(skipped("latency", name, "frames late, farthest", {}, "counted", is_there ? "--quick" : "its map is not there"));
            continue;
        }
        // Distances are in tiles, so any size of picture gives the same.
        auto const scene = bench::load_scene(name, context.data, {320, 180});
        for (std::uint32_t const hops : {1u, 2u, 4u, 8u}) {
            if (context.quick && hops != 1 && hops != 4) continue;
            auto const found = follow(scene, hops, context);
            std::uint64_t all = 0, exact = 0;
            for (auto const& d : found.delays) {
                all += d.gaussians;
                exact += d.least == d.distance / hops && d.most == d.distance / hops ? d.gaussians : 0;
            }
            auto const add = [&](Delay const& d) {
                rows.push_back(
                    {"latency", name, "frames until it is there, " + std::to_string(d.distance) + " tiles off", static_cast<double>(d.distance),
                     static_cast<double>(d.most), "counted",
                     "Gaussians: " + std::to_string(d.gaussians) + ", the fastest after " + std::to_string(d.least) + "; one hop a frame"});
            };
            std::uint32_t next = 1;
            for (auto const& d : found.delays) {
                if (hops != 1 || d.distance < next || &d == &found.delays.back()) continue;
                add(d);
                next = d.distance < 10 ? 10 : d.distance + 15;
            }
            if (hops == 1 && !found.delays.empty()) add(found.delays.back());
            std::optional<double> paper;
            if (hops == 1) paper = 100.0;
            rows.push_back({"latency", name,
                            hops == 1 ? "Gaussians that take d frames for d tiles (%)"
                                      : "Gaussians that take floor d over " + std::to_string(hops) + " frames for d tiles (%)",
                            paper, all == 0 ? 0 : 100.0 * static_cast<double>(exact) / static_cast<double>(all), "counted",
                            std::to_string(all) + " Gaussians after a teleport; " + std::to_string(found.refused) +
                                " refusals; complete with all copies after " + std::to_string(found.frames_until_complete) + " frames",
                            !found.broken.empty()});
            if (!found.broken.empty()) rows.back().note = found.broken;
            if (hops != 1) continue;
            plot.series.push_back({.name = name, .points = {}, .colour = static_cast<std::uint32_t>(plot.series.size()) + 2});
            for (auto const& d : found.delays) plot.series.back().points.emplace_back(d.distance, d.median);
        }
    }
    if (!context.out.empty() && !plot.series.empty()) report::write_svg(context.out / "latency.svg", plot);
}

} // namespace paper
