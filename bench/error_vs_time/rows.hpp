#pragma once
#include "knobs.hpp"
#include <cstdint>
#include <string>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/rules.hpp>
#include <vector>

namespace error_vs_time {

namespace report = tilemesh::report;
namespace scene = tilemesh::scene;

/// The limits of a machine. Channels and hops are limited after the first view has settled; storage is limited from the start.
struct Limits {
    bool drop = false;               ///< false: a record that finds a channel full is held back; true: it is dropped
    std::uint32_t channel_slots = 200;
    std::uint32_t hops = 0;          ///< for routing, and for bloom, per frame; 0: until quiet
    std::uint32_t storage_slots = 0; ///< per tile; 0: room for all
    bool homes = false;              ///< the program of homes: storage is the splats that a tile holds, and full lists cost rounds and passes
    friend bool operator==(Limits const&, Limits const&) = default;
};

/// One way of rendering.
struct Setting {
    std::string name;                ///< unique; the library has `default`, `evaluation`, `viewing` and `on_sensor`
    std::string knob;                ///< the knob that differs: "named", "alpha and stop", "sigma", "clamp", "crossing", "arithmetic",
                                     ///< "shape", "sort key", "channels", "hops", "storage", "program"
    splat::Rules rules;              ///< alpha_min, alpha_max, transmittance_min, footprint, arithmetic
    Knobs knobs;
    Limits limits;
};

/// One setting in one view, or over a sequence of views.
struct Row {
    std::string scene, camera;       ///< camera: "orbit2" is the view 2 degrees after the scene's own; "orbit2 x 6" a sequence
    std::uint64_t gaussians = 0;     ///< in the map
    scene::Size size{};              ///< size of a frame, in pixels
    std::uint32_t frames = 1;
    Setting setting;
    std::string failed;              ///< why there is no result; then the members below have no meaning

    // Errors. `total`: the mesh's picture against R0, double without cut-offs. `cut`: R1, double with the setting's cut-offs, against R0.
    // `round`: R2, float32 of the whole frame, against R1. `mesh`: the mesh's picture against R2. References are rounded to float32 before
    // they are compared. For a sequence: the errors of its worst frame by `total.rmse`. `round` also contains the effect of depth order
    // (24-bit floats may order splats differently than doubles), of fewer key bits, of shapes and of polynomials.
    report::ErrorMeasures total{}, cut{}, round{}, mesh{};
    double twice_products = 0;       ///< 2 * mean(cut round + cut mesh + round mesh): the part of total^2 that is not in the three squares
    double split_off = 0;            ///< |total^2 - cut^2 - round^2 - mesh^2 - twice_products| / total^2
    double certified_levels = 0;     ///< of one view: a proved bound on `total.max_levels`, against the exact formula in place of R0
    double popping = 0;              ///< of a sequence: RMSE of (this frame - the last one) - (R0 - the last R0), for the worst step

    // Counters of the last frame.
    report::FrameReport counters;
    std::uint64_t lost = 0, late = 0, unplaced = 0; ///< whole records and copies that a picture lacks, by cause; the most in one frame
    bool mesh_wrong = false;                        ///< a picture that lacks nothing differs from R2
    std::uint64_t projected_bytes = 56;             ///< bytes of a projected record in its storage format
    bool complete() const noexcept { return lost + late + unplaced == 0; }

    // Costs.
    double modelled_ms = 0;          ///< of the last frame: `mk2()` applied to its trace
    std::vector<double> host_ms;     ///< of the frame's steps and the picture, round by round; empty for a sequence. Not of the list
                                     ///< of what a picture lacks, which is made beside it
    std::vector<double> over_default; ///< each round's time over the default's in the same round

    // Comparison with the other rows of the scene and camera; see front.hpp.
    bool on_front = false, on_front_modelled = false;
    double front_pairs = 1;          ///< the fewest pairs of a setting whose error is not larger, over this row's pairs: 1 on the front
};

/// The time of the default relative to itself, measured as one more setting: over_default of the second copy, round by round.
struct Noise {
    std::string scene;
    std::vector<double> ratios;
};

} // namespace error_vs_time
