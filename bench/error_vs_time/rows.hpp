#pragma once
#include "knobs.hpp"
#include <cstdint>
#include <string>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/model.hpp>
#include <vector>

namespace error_vs_time {

namespace report = tilemesh::report;
namespace scene = tilemesh::scene;

/// What a machine is limited to. Channels and hops are limited when the first view stands; storage from the start.
struct Limits {
    bool drop = false;               ///< what finds a channel full: held back, or gone
    std::uint32_t channel_slots = 200;
    std::uint32_t hops = 0;          ///< of routing, and of bloom, a frame; 0: until quiet
    std::uint32_t storage_slots = 0; ///< a tile; 0: room for all
    friend bool operator==(Limits const&, Limits const&) = default;
};

/// One way to render.
struct Setting {
    std::string name;                ///< unique; `default`, `evaluation`, `viewing` and `on_sensor` are the library's
    std::string knob;                ///< what it differs in: "named", "alpha and stop", "sigma", "clamp", "crossing", "arithmetic",
                                     ///< "shape", "sort key", "channels", "hops", "storage"
    splat::Model model;              ///< alpha_min, alpha_max, transmittance_min, footprint, arithmetic
    Knobs knobs;
    Limits limits;
};

/// One setting in one view, or over a sequence of views.
struct Row {
    std::string scene, camera;       ///< camera: "orbit2" is the view 2 degrees after the scene's own; "orbit2 x 6" a sequence
    std::uint64_t gaussians = 0;     ///< in the map
    scene::Size size{};              ///< of a frame, in pixels
    std::uint32_t frames = 1;
    Setting setting;
    std::string failed;              ///< why there is no result; then nothing below means anything

    // Errors. `total`: the mesh's picture against R0, double without cut-offs. `cut`: R1, double with the setting's cut-offs, against
    // R0. `round`: R2, float32 of the whole frame, against R1. `mesh`: the mesh's picture against R2. References are rounded to
    // float32 before they are compared. Of a sequence: of its worst frame, by `total.rmse`. Splats that 24-bit floats order as double
    // does not are in `round`, and so are fewer key bits, shapes and polynomials.
    report::ErrorMeasures total{}, cut{}, round{}, mesh{};
    double twice_products = 0;       ///< 2 * mean(cut round + cut mesh + round mesh): what total^2 has beside the three squares
    double split_off = 0;            ///< |total^2 - cut^2 - round^2 - mesh^2 - twice_products| / total^2
    double popping = 0;              ///< of a sequence: RMSE of (this frame - the last one) - (R0 - the last R0), worst step

    // Counters, of the last frame.
    report::FrameReport counters;
    std::uint64_t lost = 0, late = 0, unplaced = 0; ///< whole records and copies that a picture lacks, by what became of them; the most
    bool mesh_wrong = false;                        ///< a picture that lacks nothing is not R2's, bit for bit
    std::uint64_t projected_bytes = 56;             ///< of a projected record, as its shape is stored
    bool complete() const noexcept { return lost + late + unplaced == 0; }

    // Costs beside them.
    double modelled_ms = 0;          ///< of the last frame: `mk2()` applied to its trace
    std::vector<double> host_ms;     ///< of the frame's steps and the picture, round by round; empty for a sequence. Not of the list
                                     ///< of what a picture lacks, which is made beside it
    std::vector<double> over_default; ///< each round's time over the default's in the same round

    // Against the other rows of the scene and camera; see front.hpp.
    bool on_front = false, on_front_modelled = false;
    double front_pairs = 1;          ///< the fewest pairs of a setting whose error is no larger, over this one's: 1 on the front
};

/// Time of the default against itself, measured as one more setting: over_default of the second copy, round by round.
struct Noise {
    std::string scene;
    std::vector<double> ratios;
};

} // namespace error_vs_time
