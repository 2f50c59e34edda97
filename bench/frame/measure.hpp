#pragma once
#include "machine.hpp"
#include "options.hpp"
#include <common/scenes.hpp>
#include <string>
#include <vector>

namespace frame {

/// The samples of one quantity, one per round.
using Samples = std::vector<double>;

/// The measurements of one scene and motion, with one number of threads, on one grid.
struct Row {
    std::string scene, motion, grid;
    std::uint32_t threads = 0;
    Samples gflops, clock_ghz, cycles_per_block_splat; ///< empty where they are not measured
    Samples direct, mesh, mesh_over_direct, direct_over_roofline;
    Samples direct_project, direct_sort, direct_bin, direct_blend;
    Samples mesh_project, mesh_route, mesh_bloom, mesh_composite, picture;
    Samples direct_speedup, mesh_speedup; ///< relative to one thread, in the same round; empty if one thread is not measured
    Samples homes, homes_over_direct;     ///< the program of homes; only with --homes and a moving view
    Samples kept;                         ///< the mesh whose tiles keep their pixels; only in a static view
    Samples over_narrow;                  ///< wide grid: time of its mesh over that of 40 x 36 tiles, in the same round
    Samples pairs, contributing, messages, exchanges, moved;
    std::uint32_t visible = 0;
    std::uint64_t entries = 0; ///< entries of the rasteriser's lists, in the last frame
};

/// Measures a scene and motion. In every round the FMA peak, the bare rasteriser and the meshes render the next camera, with each number of
/// threads in turn. `broken` gets a line for each picture or counter that differs; with precise arithmetic also if the last picture differs
/// from the naive one.
std::vector<Row> measure(bench::Scene const& scene, std::string const& motion, Options const& options,
                         std::vector<std::string>& broken);

/// Time and error of one way to blend, on a scene's own camera.
struct ErrorRow {
    std::string scene;
    char const* exponential = ""; ///< the way of computing alpha
    char const* stop = ""; ///< "pixel": each by its own transmittance; "block": all pixels go on until the last one has stopped
    std::uint32_t threads = 0;
    Samples direct, over_first; ///< over_first: over the first row, in the same round
    double rms = 0, psnr_db = 0;
    std::uint64_t differing_bytes = 0; ///< of the pictures with 8 bits a channel
    std::uint32_t largest_byte = 0;    ///< difference
};
std::vector<ErrorRow> measure_arithmetics(bench::Scene const& scene, Options const& options);

std::string csv(std::vector<Row> const& rows, tilemesh::splat::Arithmetic arithmetic);
std::string csv(std::vector<ErrorRow> const& rows);

} // namespace frame
