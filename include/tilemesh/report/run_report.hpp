#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/report/certificate.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/splat/camera.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// The modelled time of a frame on a machine (tilemesh/model/cost_model.hpp).
struct Modelled {
    std::string cost_model;                        ///< its name
    std::uint64_t cycles = 0;
    double ms = 0;                                 ///< the cycles at the model's clock
};

/// Another picture of a frame's view, a photograph or another renderer's picture, and how far the frame is from it.
struct Comparison {
    std::string file;                              ///< of the other picture, as it was looked for
    std::string problem;                           ///< why the frame was not compared, "<problem> (<why>); <what to do>"; empty: it was
    PictureMeasures measures{};                    ///< if it was
    std::string error;                             ///< the file of the error picture; empty: none
};

/// A camera as report.json has it, and as the library's own camera files have it.
struct ViewOf {
    std::array<double, 4> intrinsics_px{};    ///< fx, fy, cx, cy
    std::array<double, 16> world_to_camera{}; ///< 4 x 4, row by row; x right, y down, z forward
    splat::Lens lens{};
    splat::Shutter shutter{};

    ViewOf() = default;
    /// `origin`: what the reader of the map subtracted (`scene::Map::origin`); the view is in the coordinates of the file.
    explicit ViewOf(splat::Camera const& c, std::array<double, 3> const& origin = {})
        : intrinsics_px{c.fx, c.fy, c.cx, c.cy}, lens(c.lens), shutter(c.shutter)
    {
        world_to_camera[15] = 1;
        for (std::size_t row = 0; row < 3; ++row)
            for (std::size_t k = 0; k < 3; ++k) {
                world_to_camera[4 * row + k] = c.rotation[row][k];
                world_to_camera[4 * row + 3] -= double{c.rotation[row][k]} * (c.position[k] + origin[k]);
            }
    }
};

/// One frame of a run: its report, its tiling and, if a reference was rendered, its error.
struct RunFrame {
    FrameReport report;
    std::optional<double> timestamp_s;             ///< of the pose, if the camera follows a trajectory
    std::optional<ViewOf> view;                    ///< from where the frame was seen
    std::string image;                             ///< the file of the picture; empty: none
    std::string depth, alpha;                      ///< the files of its planes; empty: none
    std::array<std::uint32_t, 2> grid{};           ///< tiles, width and height
    std::array<std::uint32_t, 2> tile_px{};        ///< pixels, width and height
    std::optional<Modelled> modelled;              ///< if the machine kept a trace
    std::optional<ErrorMeasures> error;            ///< against the double reference without cut-offs
    std::optional<ErrorMeasures> error_same_cuts;  ///< against the double reference with the model's cut-offs
    std::optional<Certificate> certified;          ///< if the exact formula was enclosed
    std::optional<Certificate> compared_certified; ///< of the picture in `compared`, if both were asked for
    std::optional<Comparison> photograph;          ///< if photographs were asked for
    std::optional<Comparison> compared;            ///< with the picture of another renderer, if one was named
};

/// The inputs that determine the frames of a run. Two runs with equal inputs have equal frames.
struct MadeFrom {
    struct File {
        std::string path;                          ///< as the user gave it
        std::uint64_t bytes = 0;
        std::string digest;                        ///< of the file's bytes
    };
    std::string version;                           ///< of the program; empty: not recorded
    std::vector<std::string> options;              ///< the options that change a frame, sorted; input files are in `files` only
    std::vector<File> files;                       ///< every input file
};

/// A whole run, as a program describes it: the content of report.json except the frames' own reports.
struct RunReport {
    struct {
        std::string name;                          ///< "sloth", "built_in"
        std::string path;                          ///< as the user gave it; empty for a map without a file
        std::uint64_t gaussians = 0, rejected = 0;
        std::vector<std::string> notes;
    } map;
    struct {
        std::string name;
        std::uint32_t sram_bytes = 0;              ///< of a tile
        std::uint32_t storage_slots = 0;           ///< of a tile, after the user's limit
        std::uint32_t channel_slots = 0;           ///< of a bloom channel (without bloom: of routing), after the user's limit
        std::vector<machine::Region> ledger;                ///< Tile<Machine, Program>::ledger()
    } machine;
    std::string preset, engine;
    Program program = Program::anchored;           ///< as the user chose it; each frame says which program rendered it
    std::uint32_t threads = 1;                     ///< of each process
    std::uint32_t ranks = 1;                       ///< processes
    struct {
        std::string routing, addressing, saturation, footprint, copies, pixels, arithmetic;
        std::uint32_t hops = 0;                    ///< limit for the exchanges of routing, and for those of bloom, per frame; 0: until quiet
        std::uint32_t rounds = 0;                  ///< limit for the rounds of the program of homes; 0: until the picture is complete
    } policies;
    std::string quality = "default";               ///< splat::name of the requested quality; "default": the preset's own cut-offs
    struct {
        float alpha_min = 0, transmittance_min = 0, alpha_max = 0;
    } cut_offs;                                    ///< of splat::Rules
    std::array<float, 3> background{};             ///< linear RGB, 0 to 1
    struct Field {
        std::string name, word;                    ///< without a word, the number counts
        double number = 0;
    };
    std::vector<Field> setup;                      ///< every field of the setup that ran (render/setup_fields.hpp)
    struct Feature {
        std::string name;                          ///< "routing"
        bool kept = true;                          ///< false: not compiled into the program that ran, or not loaded
        std::string why;
    };
    std::vector<Feature> features;                 ///< parts of the program, and whether the scene needs each of them
    MadeFrom made_from;
    std::vector<std::string> notes; ///< one line each, about the run; the map has its own notes
    std::string advice;             ///< what would help if pictures lack something; empty: no picture does
    std::vector<RunFrame> frames;
};

/// The frames of a run that have a photograph, and the means of their measures over the frames that were compared. The mean of no frame is
/// NaN, and a mean PSNR is infinite if a frame equals its photograph.
struct PhotographMeans {
    std::uint64_t compared = 0, not_compared = 0;
    double psnr_db = 0, ssim = 0, l1 = 0;
};
inline PhotographMeans photograph_means(RunReport const& run)
{
    PhotographMeans means;
    for (auto const& frame : run.frames) {
        if (!frame.photograph) continue;
        if (!frame.photograph->problem.empty()) {
            ++means.not_compared;
            continue;
        }
        ++means.compared;
        means.psnr_db += frame.photograph->measures.psnr_db;
        means.ssim += frame.photograph->measures.ssim;
        means.l1 += frame.photograph->measures.l1;
    }
    for (auto* const sum : {&means.psnr_db, &means.ssim, &means.l1}) *sum /= static_cast<double>(means.compared);
    return means;
}

}}} // namespace tilemesh::report
