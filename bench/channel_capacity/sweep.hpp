#pragma once
#include "machine.hpp"
#include "modelled.hpp"
#include <common/scenes.hpp>
#include <string>
#include <tilemesh/report/error_measures.hpp>
#include <vector>

namespace channel_capacity {

using bench::motion_names;
using bench::Scene;
using bench::scene_names;

/// One setting: a scene, a motion, and a split of the SRAM. Sums and worst values are over the measured frames. With `static` these are the
/// cold start (records in the file's order, evenly over the tiles). With every other motion these are all frames except the first. The
/// first frame has channels without a limit, as if the host had placed records and copies, so that the motion's own work is measured.
struct Row {
    std::string scene, motion;
    std::uint32_t capacity = 0, storage = 0;
    Saturation saturation = Saturation::hold;
    tilemesh::report::ErrorMeasures worst{}; ///< of the frame with the lowest PSNR
    double psnr_last_db = 0;
    std::uint32_t frames = 0;
    std::uint64_t exchanges_most = 0, exchanges = 0; ///< of the slowest frame; of all frames
    std::uint64_t rounds = 0; ///< of the program of homes, in all frames
    std::uint64_t hops = 0, messages = 0, moved = 0, held = 0;
    std::uint64_t dropped = 0;    ///< records lost after the last frame
    std::uint64_t unplaced = 0;   ///< the most in one frame
    std::uint64_t not_loaded = 0; ///< records for which all tiles together had no slot before the first frame
    std::uint64_t lost_copies = 0, late = 0;
    std::uint64_t refused_channel = 0, refused_storage = 0;
    std::uint64_t wanted = 0, missing = 0; ///< pairs of a Gaussian and a tile that it touches, in all frames; pairs that the picture lacks
    std::uint64_t missing_first = 0;       ///< of the first frame of a motion that is not static
    std::uint64_t missing_dense = 0, wanted_dense = 0; ///< on the 5 % of tiles that want most in their frame
    std::uint32_t peak_channel = 0, peak_storage = 0;
    std::uint32_t storage_needed = 0; ///< the peak over all frames, including the first
    bool ran = true;                  ///< false: no limit binds, so the row is copied from a smaller capacity
    std::vector<Modelled> modelled;   ///< of each measured frame

    std::uint64_t cycles_most() const; ///< modelled cycles of the slowest frame
    std::uint64_t cycles_mean() const; ///< modelled cycles of a frame, mean, rounded
    std::uint64_t exchange_mean() const;
    bool complete() const noexcept { return missing == 0 && missing_first == 0; }
    double missing_share() const noexcept { return wanted == 0 ? 0 : static_cast<double>(missing) / static_cast<double>(wanted); }
};

struct SweepPlan {
    std::vector<std::uint32_t> channel_slots; ///< capacities that are given directly
    std::vector<std::uint32_t> storage_slots; ///< capacities that leave about this many storage slots
    std::uint32_t frames = 8;                 ///< number of measured frames of a motion
};

/// The capacities of a plan, in order. Each leaves storage for at least one record.
std::vector<std::uint32_t> capacities(SweepPlan const& plan, Saturation saturation);
/// Storage slots that channels of `capacity` slots leave on Mk2; 0: none.
std::uint32_t storage_left(Saturation saturation, std::uint32_t capacity);

/// Runs all capacities for one motion of one scene: both policies of the anchored program, and the program of homes. `broken` gets a line for every invariant that does not hold: a
/// picture that lacks nothing has the naive picture's bits; a static view moves nothing; `hold` loses records and copies only to full
/// storage, and none if storage was never full; homes lack nothing; every record is on a tile or in the list of losses; no peak is above its limit; a larger
/// capacity whose limits do not bind gives the same numbers.
std::vector<Row> sweep(Scene const& scene, std::string const& motion, SweepPlan const& plan, std::filesystem::path const& data,
                       std::vector<std::string>& broken);

/// A picture beside the complete one, cut to the part that lacks most: the effect of full channels under `drop`.
tilemesh::report::Image saturated_pair(Scene const& scene, std::string const& motion, std::uint32_t capacity, tilemesh::scene::Size cut,
                                       std::filesystem::path const& data);

} // namespace channel_capacity
