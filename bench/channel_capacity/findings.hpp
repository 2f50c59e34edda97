#pragma once
#include "latency.hpp"
#include "sweep.hpp"
#include <common/statistics.hpp>
#include <string>
#include <vector>

namespace channel_capacity {

/// The knees of one motion under one policy. A setting is `good` if its picture lacks at most 5 % more than the best setting of the sweep.
/// If a setting lacks nothing, only the settings that lack nothing are good.
///
/// channel: under `drop`, the smallest good capacity. Under `hold`, which loses nothing to full channels, the smallest good capacity whose
/// exchanges are within 5 % of the fewest of all good ones. Larger channels do not help. storage: the smallest capacity above all good
/// ones: from there on storage is too small. 0: none in the sweep.
struct Knee {
    std::string motion;
    std::uint32_t channel = 0, channel_storage = 0;
    std::uint32_t storage = 0, storage_slots = 0;
    std::uint64_t fewest_exchanges = 0; ///< per frame: mean over the motion's frames, rounded
    bool complete = false;               ///< the best setting lacks nothing
    double least_missing = 0;            ///< share of all pairs
};

/// The rows of one scene, motion and policy, by capacity.
std::vector<Row> select(std::vector<Row> const& rows, std::string const& scene, std::string const& motion, Saturation saturation);
Knee knee_of(std::vector<Row> const& of_one_motion);

/// For each of a scene's rows of one motion: is it Pareto-optimal in its program? It is if no other split, of either policy, has a worst frame with a
/// higher PSNR that is not slower, or a faster worst frame that is not worse (by the modelled time of the slowest frame).
std::vector<bool> pareto_front(std::vector<Row> const& of_one_motion);
/// The rows of the anchored program of one scene and motion, of both policies, by modelled time.
std::vector<Row> by_time(std::vector<Row> const& rows, std::string const& scene, std::string const& motion);
/// Modelled milliseconds, with `decimals` digits after the point.
std::string milliseconds(std::uint64_t cycles, int decimals);
using bench::fixed; // "inf" where pictures are equal

/// Sentences with the knees of a scene, one per policy.
std::vector<std::string> knee_sentences(std::vector<Row> const& rows, std::string const& scene);
/// Sentences about the paper's findings: where losses lie, and that continuous motion loses far less than a teleport.
std::vector<std::string> paper_sentences(std::vector<Row> const& rows, std::string const& scene);
/// Sentences about the program of homes: what few slots cost, and how many are enough.
std::vector<std::string> homes_sentences(std::vector<Row> const& rows, std::string const& scene);
std::vector<std::string> latency_sentences(std::vector<LatencyRow> const& rows);

std::string csv(std::vector<Row> const& rows);
std::string csv(std::vector<LatencyRow> const& rows);

} // namespace channel_capacity
