// The time of the machine's frame, compared with a bare rasteriser and with the processor's peak.
#include "measure.hpp"
#include <algorithm>
#include <common/fma_peak.hpp>
#include <common/program.hpp>
#include <common/statistics.hpp>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <vector>

namespace {

using namespace frame;
using bench::fixed;
using bench::median;

/// The scenes that the options name and whose files exist, and the maps that the options name.
std::vector<bench::Scene> scenes_of(Options const& options, tilemesh::scene::Size size)
{
    std::vector<bench::Scene> scenes;
    for (std::string const name : scene_names) {
        if (!bench::chosen(options.scenes, name) || (options.scenes.empty() && !options.maps.empty())) continue;
        if (options.scenes.empty() && options.quick && name != "built_in") continue;
        if (options.scenes.empty() && options.arithmetics && !options.quick && name != "sloth" && name != "salad") continue;
        if (!bench::has_scene(name, options.data)) {
            std::cout << "skipped: " << name << " (its map is not there; name its folder with --data)\n";
            continue;
        }
        scenes.push_back(bench::load_scene(name, options.data, size));
    }
    for (auto const& map : options.maps) scenes.push_back(bench::load_file(map, size));
    return scenes;
}

std::string number(Samples const& samples, int places)
{
    return samples.empty() ? "-" : fixed(median(samples), places);
}
/// The median and the band.
std::string band(Samples const& samples, int places)
{
    if (samples.empty()) return "-";
    return fixed(median(samples), places) + " (" + fixed(bench::quantile(samples, 0.2), places) + ".." +
           fixed(bench::quantile(samples, 0.8), places) + ")";
}

int run_arithmetics(Options const& options, tilemesh::scene::Size size)
{
    std::vector<ErrorRow> rows;
    for (auto const& scene : scenes_of(options, size))
        for (auto& row : measure_arithmetics(scene, options)) rows.push_back(std::move(row));
    tilemesh::report::Table table{{"scene", "exponential", "stop", "threads", "direct ms", "over precise", "rms", "PSNR dB",
                                   "differing bytes", "largest"}};
    for (auto const& r : rows) {
        auto const rms = bench::scientific(r.rms, 1);
        table.add_row({r.scene, r.exponential, r.stop, std::to_string(r.threads), band(r.direct, 2),
                       number(r.over_first, 3), rms, fixed(r.psnr_db, 1), tilemesh::report::thousands(r.differing_bytes),
                       std::to_string(r.largest_byte)});
    }
    std::cout << table;
    if (!options.csv.empty()) tilemesh::report::write_whole(options.csv, csv(rows));
    return 0;
}

int run(Options const& options)
{
    bench::expect_folder_of(options.csv);
    tilemesh::scene::Size const size = options.quick ? tilemesh::scene::Size{320, 180} : tilemesh::scene::Size{1280, 720};
    if (options.arithmetics) return run_arithmetics(options, size);

    std::cout << "peak: " << bench::FmaPeak::instructions << "; arithmetic: " << to_string(options.arithmetic) << "\n";
    std::vector<Row> rows;
    std::vector<std::string> broken;
    for (auto const& scene : scenes_of(options, size))
        for (std::string const motion : bench::motion_names) {
            if (!bench::chosen(options.motions, motion)) continue;
            if (options.quick && options.motions.empty() && motion != "static" && motion != "orbit2" &&
                motion != "teleport")
                continue;
            if (!bench::has_motion(motion, options.data)) {
                std::cout << "skipped: " << scene.map.name << " with " << motion
                          << " (its trajectory is not there; name its folder with --data)\n";
                continue;
            }
            for (auto& row : measure(scene, motion, options, broken)) rows.push_back(std::move(row));
            std::cerr << scene.map.name << " " << motion << "\n";
        }

    tilemesh::report::Table times{{"scene", "motion", "grid", "threads", "GFLOP/s", "direct ms", "mesh ms", "kept ms", "mesh / direct", "homes / direct",
                                   "direct / roofline", "cycles a block-splat", "evaluated / contributing", "direct speedup", "mesh speedup"}};
    tilemesh::report::Table stages{{"scene", "motion", "grid", "threads", "direct: project", "sort", "bin", "blend",
                                    "mesh: project", "route", "bloom", "composite", "picture", "messages", "exchanges"}};
    for (auto const& r : rows) {
        auto const threads = std::to_string(r.threads);
        times.add_row({r.scene, r.motion, r.grid, threads, number(r.gflops, 0), band(r.direct, 2), band(r.mesh, 2), band(r.kept, 2),
                       band(r.mesh_over_direct, 2), band(r.homes_over_direct, 2), number(r.direct_over_roofline, 3), number(r.cycles_per_block_splat, 1),
                       fixed(median(r.pairs) / std::max(median(r.contributing), 1.0), 2), number(r.direct_speedup, 2),
                       number(r.mesh_speedup, 2)});
        stages.add_row({r.scene, r.motion, r.grid, threads, number(r.direct_project, 3), number(r.direct_sort, 3),
                        number(r.direct_bin, 3), number(r.direct_blend, 3), number(r.mesh_project, 3),
                        number(r.mesh_route, 3), number(r.mesh_bloom, 3), number(r.mesh_composite, 3), number(r.picture, 3),
                        number(r.messages, 0), number(r.exchanges, 0)});
    }
    std::cout << times << "\n" << stages;
    for (auto const& r : rows)
        if (r.grid != rows.front().grid)
            std::cout << r.scene << " " << r.motion << ", " << r.threads << (r.threads == 1 ? " thread" : " threads")
                      << ": the mesh of " << r.grid << " tiles takes " << band(r.over_narrow, 2)
                      << " times as long as that of " << rows.front().grid << "\n";
    if (!options.csv.empty()) tilemesh::report::write_whole(options.csv, csv(rows, options.arithmetic));
    for (auto const& what : broken) std::cout << "BROKEN: " << what << "\n";
    std::cout << (broken.empty() ? "All pictures are the same, bit for bit.\n" : "");
    return broken.empty() ? 0 : 1;
}

} // namespace

int main(int argc, char** argv)
{
    return bench::program(argc, argv, table_of, run,
                          "not enough memory (each number of threads has a mesh of its own); try one --threads or --quick");
}
