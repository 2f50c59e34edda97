#pragma once
#include "study.hpp"
#include <cstdint>
#include <optional>
#include <string>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/model/explore.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/report/image.hpp>
#include <vector>

namespace explore {

/// A point of the study, with the numbers that the front does not weigh.
struct Point : tilemesh::StudyPoint {
    std::string digest;             ///< of all that the point depends on
    std::string picture;            ///< the file of its first frame
    std::uint64_t cycles = 0;       ///< of all frames
    std::uint64_t exchanges = 0, passes = 0, pairs = 0, capacity_bytes = 0;
    double first_ms = 0;            ///< modelled, of the first frame, in which the records find their tiles
    std::optional<double> later_ms; ///< modelled, mean of the other frames; nothing if there are none
    double slowest_to_mean = 0;     ///< computed cycles of all frames: those of the busiest tile over those of the mean tile
    std::string weakest;            ///< "guessed: vote, sync": the weakest kind of the prices behind the time, and its prices
    double weakest_share = 0;       ///< of them in the cycles
    double host_ms = 0;             ///< of the run, which several points may share
    std::uint32_t storage = 0, channel = 0, beam = 0, waiting = 0; ///< slots; homes have no beam
};

/// The most tiles that a study gives to a point; a wafer comes in part.
inline constexpr std::uint64_t most_tiles = std::uint64_t{1} << 18;

/// The sizes of a setting on its machine, by either program.
struct Sized {
    tilemesh::render::Setup anchored{};
    tilemesh::render::Setup homes{};
    std::uint64_t sram_bytes = 0;   ///< all of the machine's, if one more slot of storage would not fit
    std::uint32_t storage = 0, channel = 0, beam = 0, waiting = 0;
    std::string refused;            ///< why it cannot run
};
/// Never throws for a setting that does not fit: it says so.
Sized sizes_of(Setting const& setting);

/// Why a renderer cannot run a setting, with an advice that a study can follow.
std::string refusal_of(tilemesh::Error const& error);

/// Settings with equal keys have equal counts, bit for bit: a run of one of them prices all.
std::string run_key(Setting const& setting, Sized const& sized);
/// All that a point depends on.
std::string point_digest(Setting const& setting, std::string const& run_key);

/// What a run gives: the counts of each frame.
struct Frames {
    struct Frame {
        tilemesh::Trace trace;
        tilemesh::Grid grid;
    };
    std::vector<Frame> frames;
    Point point;                    ///< without time, name and digest
    tilemesh::report::Image picture; ///< of the first frame
};
/// Thrown after an interrupt: by `run` at the end of a superstep, by `references_of` at the end of a view.
struct Interrupted {};
/// Renders every view. `references` are the pictures in double precision without cut-offs, one a view.
Frames run(Setting const& setting, Sized const& sized, std::vector<tilemesh::report::Image> const& references, std::uint32_t threads);
std::vector<tilemesh::report::Image> references_of(Subject const& subject, std::uint32_t threads);

/// The prices of a setting. Throws `tilemesh::Error` for a parameter that its model lacks.
tilemesh::CostModel model_of(Setting const& setting);
/// The point of a setting from the counts of its run.
Point priced(Setting const& setting, Frames const& frames, std::string digest);

} // namespace explore
