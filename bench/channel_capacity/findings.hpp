#pragma once
#include "latency.hpp"
#include "sweep.hpp"
#include <common/statistics.hpp>
#include <string>
#include <vector>

namespace channel_capacity {

/// The knees of one motion under one policy. `good` are the settings that lack at most 5 % more than the best of the sweep: where
/// one setting lacks nothing, those that lack nothing.
///
/// channel: the smallest good capacity (`drop`), or under `hold`, which loses nothing for want of a channel, the smallest good one
/// whose exchanges are within 5 % of the fewest of all good ones. Larger channels do not help.
/// storage: the smallest capacity above all good ones: from there on storage is what is missing. 0: none in the sweep.
struct Knee {
    std::string motion;
    std::uint32_t channel = 0, channel_storage = 0;
    std::uint32_t storage = 0, storage_slots = 0;
    std::uint64_t fewest_exchanges = 0; ///< of a frame, mean over the motion's, rounded
    bool complete = false;               ///< the best setting lacks nothing
    double least_missing = 0;            ///< share of all pairs
};

/// The rows of one scene and motion and policy, in order of capacity.
std::vector<Row> select(std::vector<Row> const& rows, std::string const& scene, std::string const& motion, Saturation saturation);
Knee knee_of(std::vector<Row> const& of_one_motion);

/// Which of a scene's rows of one motion are on the Pareto front: no other split, of either policy, has a worst frame of higher PSNR that
/// is not slower, or a faster one that is not worse (modelled time of the slowest frame).
std::vector<bool> pareto_front(std::vector<Row> const& of_one_motion);
/// The rows of one scene and motion, both policies, by modelled time.
std::vector<Row> by_time(std::vector<Row> const& rows, std::string const& scene, std::string const& motion);
/// Modelled, with `decimals`.
std::string milliseconds(std::uint64_t cycles, int decimals);
using bench::fixed; // "inf" where pictures are equal

/// Sentences with the knees of a scene, one a policy.
std::vector<std::string> knee_sentences(std::vector<Row> const& rows, std::string const& scene);
/// Sentences about what the paper found: where losses lie, and that continuous motion loses far less than a teleport.
std::vector<std::string> paper_sentences(std::vector<Row> const& rows, std::string const& scene);
std::vector<std::string> latency_sentences(std::vector<LatencyRow> const& rows);

std::string csv(std::vector<Row> const& rows);
std::string csv(std::vector<LatencyRow> const& rows);

} // namespace channel_capacity
