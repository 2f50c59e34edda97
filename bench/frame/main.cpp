// The time of the machine's frame, compared with a bare rasteriser and with the processor's peak.
#include "frame.hpp"
#include <algorithm>
#include <common/fma_peak.hpp>
#include <common/program.hpp>
#include <common/statistics.hpp>
#include <iostream>
#include <tilemesh/render/setup_fields.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/report/whole_file.hpp>

namespace {

using namespace frame;
using bench::fixed;
using bench::median;
using shared::option;

/// The scenes that are measured by default: two SLAM maps, an object capture, the built-in map, and that map with a million Gaussians.
constexpr char const* scene_names[] = {"sloth", "salad", "playbot_250k", "built_in", "built_in_1m"};

constexpr auto all_scenes = shared::words_of(scene_names);
constexpr auto all_motions = shared::words_of(bench::motion_names);
constexpr shared::Option<Options> rows_of_options[] = {
    shared::words<&Options::scenes>("scene", "NAME",
                                    "{}: the last two are the built-in map, and that map with a million Gaussians; may be repeated "
                                    "[all, unless there is a --map]",
                                    all_scenes),
    option<&Options::maps>("map", "FILE",
                           "any map, seen whole and without its harmonics; may be repeated. A map of more than 100,000 Gaussians runs on a test "
                           "machine with storage for it"),
    shared::words<&Options::motions>("motion", "NAME", "{}; may be repeated [all]", all_motions),
    option<&Options::threads>("threads", "N", "threads of rasteriser and mesh; may be repeated; all are measured in turn [1 and 2]", {1, 64}),
    option<&Options::rounds>("rounds", "N", "measured rounds per motion, after 3 warm-up rounds [25, and 7 for maps of half a million]", {1, 10'000}),
    shared::field<tilemesh::render::setup_field("arithmetic"), &Options::arithmetic>("NAME", to_string(tilemesh::splat::Lossless::arithmetic)),
    option<&Options::homes>(
        "homes", "", "also measure the program of homes on Mk2 (homes_ms), unless the view is static: it renders an unchanged view without running"),
    option<&Options::wide>("wide", "", "also measure each mesh on a grid of 400 x 250 tiles, of which the frame occupies 40 x 36"),
    option<&Options::arithmetics>("arithmetics", "",
                                  "print another table instead: time, and error against the double reference with the same cut-offs, of the "
                                  "rasteriser with precise and fast arithmetic, polynomials of lower degree, and a stop by blocks; for Sloth and "
                                  "Salad unless scenes are named; --csv then has these columns")};

shared::OptionTable table_of(Options& own)
{
    return bench::table_of({"frame",
                            "Measures the host time of the machine's frame (lossless on Mk2, 40 x 36 tiles, 1280 x 720) beside a bare\n"
                            "rasteriser with the same kernels and no mesh, and beside the FMA peak of the processor. All are measured\n"
                            "in turn, round by round, so a busy machine slows all of them. Prints the medians of the rounds and of\n"
                            "their ratios. In each round, mesh and rasteriser must have equal pictures, bit for bit.\n"
                            "\n"
                            "mesh_ms ends when the framebuffers are complete in the tiles. picture_ms is the time to assemble one\n"
                            "picture on the host. In mesh_ms every tile composites. mesh_kept_ms is the time of a static view in which\n"
                            "tiles keep their pixels. direct_over_roofline is the time of the evaluated pairs at FMA peak, 21\n"
                            "operations each, over direct_ms. cycles_per_block_splat is the rasteriser's blending, over all threads,\n"
                            "in cycles of the measured clock per 80 evaluated pairs. The columns _low and _high are the 20 % and 80 %\n"
                            "quantiles. Counters are means over the measured frames.\n",
                            "the built-in map unless scenes are named, 320 x 180, three motions, 3 rounds",
                            "write a row per scene, motion, grid and number of threads"},
                           own, rows_of_options);
}

/// The scenes that the options name and whose files exist, and the maps that the options name.
std::vector<bench::Scene> scenes_of(Options const& options, tilemesh::scene::Size size)
{
    std::vector<bench::Scene> scenes;
    for (std::string const name : scene_names) {
        if (!bench::chosen(options.scenes, name) || (options.scenes.empty() && !options.maps.empty())) continue;
        if (options.scenes.empty() && options.quick && name != "built_in") continue;
        if (options.scenes.empty() && options.arithmetics && !options.quick && name != "sloth" && name != "salad") continue;
        if (!bench::has_scene(name, options.data)) {
            bench::say_skipped(name);
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
    tilemesh::report::Table table{
        {"scene", "exponential", "stop", "threads", "direct ms", "over precise", "rms", "PSNR dB", "differing bytes", "largest"}};
    for (auto const& r : rows) {
        auto const rms = bench::scientific(r.rms, 1);
        table.add_row({r.scene, r.exponential, r.stop, std::to_string(r.threads), band(r.direct, 2), number(r.over_first, 3), rms,
                       fixed(r.psnr_db, 1), tilemesh::report::thousands(r.differing_bytes), std::to_string(r.largest_byte)});
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
            if (options.quick && options.motions.empty() && motion != "static" && motion != "orbit2" && motion != "teleport") continue;
            if (!bench::has_motion(motion, options.data)) {
                bench::say_skipped(scene.map.name + " with " + motion, "trajectory");
                continue;
            }
            for (auto& row : measure(scene, motion, options, broken)) rows.push_back(std::move(row));
            std::cerr << scene.map.name << " " << motion << "\n";
        }

    tilemesh::report::Table times{{"scene", "motion", "grid", "threads", "GFLOP/s", "direct ms", "mesh ms", "kept ms", "mesh / direct",
                                   "homes / direct", "direct / roofline", "cycles a block-splat", "evaluated / contributing", "direct speedup",
                                   "mesh speedup"}};
    tilemesh::report::Table stages{{"scene", "motion", "grid", "threads", "direct: project", "sort", "bin", "blend", "mesh: project", "route",
                                    "bloom", "composite", "picture", "messages", "exchanges"}};
    for (auto const& r : rows) {
        auto const threads = std::to_string(r.threads);
        times.add_row({r.scene, r.motion, r.grid, threads, number(r.gflops, 0), band(r.direct, 2), band(r.mesh, 2), band(r.kept, 2),
                       band(r.mesh_over_direct, 2), band(r.homes_over_direct, 2), number(r.direct_over_roofline, 3),
                       number(r.cycles_per_block_splat, 1), fixed(median(r.pairs) / std::max(median(r.contributing), 1.0), 2),
                       number(r.direct_speedup, 2), number(r.mesh_speedup, 2)});
        stages.add_row({r.scene, r.motion, r.grid, threads, number(r.direct_project, 3), number(r.direct_sort, 3), number(r.direct_bin, 3),
                        number(r.direct_blend, 3), number(r.mesh_project, 3), number(r.mesh_route, 3), number(r.mesh_bloom, 3),
                        number(r.mesh_composite, 3), number(r.picture, 3), number(r.messages, 0), number(r.exchanges, 0)});
    }
    std::cout << times << "\n" << stages;
    for (auto const& r : rows)
        if (r.grid != rows.front().grid)
            std::cout << r.scene << " " << r.motion << ", " << r.threads << (r.threads == 1 ? " thread" : " threads") << ": the mesh of " << r.grid
                      << " tiles takes " << band(r.over_narrow, 2) << " times as long as that of " << rows.front().grid << "\n";
    if (!options.csv.empty()) tilemesh::report::write_whole(options.csv, csv(rows, options.arithmetic));
    return bench::verdict(broken, "All pictures are the same, bit for bit.");
}

} // namespace

void frame::Options::finish(shared::OptionTable const& given)
{
    bench::Options::finish(given);
    if (threads.empty()) threads = {1, 2};
}

int main(int argc, char** argv)
{
    return bench::program(argc, argv, table_of, run,
                          "not enough memory (each number of threads has a mesh of its own); try one --threads or --quick");
}
