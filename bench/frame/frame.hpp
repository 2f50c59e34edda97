#pragma once
#include <common/direct.hpp>
#include <common/options.hpp>
#include <common/scenes.hpp>
#include <cstdint>
#include <string>
#include <tilemesh/splat/setup_types.hpp>
#include <vector>

namespace frame {

struct Options : bench::Options {
    std::vector<std::string> scenes, motions; ///< empty: all; no scene if there are maps
    std::vector<std::filesystem::path> maps;  ///< files, besides the scenes
    std::vector<std::uint32_t> threads;       ///< measured side by side
    std::uint32_t rounds = 0;                 ///< measured rounds per motion; 0: as --quick and the size of the map say
    tilemesh::splat::Arithmetic arithmetic = tilemesh::splat::Lossless::arithmetic;
    bool homes = false;       ///< also the program of homes
    bool wide = false;        ///< also on a grid of which the frame occupies a small part
    bool arithmetics = false; ///< only time and error of the ways to blend

    void finish(shared::OptionTable const& given);
};

constexpr char const* to_string(tilemesh::splat::Arithmetic a) noexcept
{
    return a == tilemesh::splat::Arithmetic::precise ? "precise" : "fast";
}

/// A way to blend. The machine has two of these, `precise` and `fast`. The others show the gain and the cost of a polynomial of lower
/// degree, or of a stop by blocks instead of pixels.
struct BlendWay {
    char const* exponential;
    char const* stop;
    bench::BlendTile blend_tile;
};
/// Returns all ways; the first one is `precise`.
std::vector<BlendWay> blend_ways();

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
