#include "options.hpp"
#include <common/scenes.hpp>
#include <tilemesh/render/setup_fields.hpp>

namespace frame {

using shared::option;

namespace {
constexpr auto scenes = shared::words_of(scene_names);
constexpr auto motions = shared::words_of(bench::motion_names);
constexpr shared::Option<Options> rows[] = {
    shared::words<&Options::scenes>("scene", "NAME",
                                    "{}: the last two are the built-in map, and that map with a million Gaussians; may be repeated "
                                    "[all, unless there is a --map]",
                                    scenes),
    option<&Options::maps>("map", "FILE",
                           "any map, seen whole and without its harmonics; may be repeated. A map of more than 100,000 Gaussians runs on a test "
                           "machine with storage for it"),
    shared::words<&Options::motions>("motion", "NAME", "{}; may be repeated [all]", motions),
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
} // namespace

void Options::finish(shared::OptionTable const& given)
{
    bench::Options::finish(given);
    if (threads.empty()) threads = {1, 2};
}

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
                           own, rows);
}

} // namespace frame
