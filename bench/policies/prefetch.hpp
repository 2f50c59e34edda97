#pragma once
#include "measure.hpp"
#include <common/scenes.hpp>
#include <cstdint>
#include <string>
#include <vector>

namespace policies {

/// The frames of one motion, with or without records that move early. All numbers are means over the frames whose motion is known (all but
/// the first two), unless they say otherwise.
struct Motion {
    std::string map, motion;
    bool early = false;            ///< prefetch by motion: between two frames, records move to where constant velocity leads
    std::uint32_t frames = 0;
    double psnr_db = 0;            ///< of the last picture against the exact one; infinite for equal bits
    std::uint64_t missing = 0;     ///< records and copies that the pictures lack, in all frames
    std::uint32_t other_bits = 0;  ///< pictures that differ from those without prefetch, although neither lacks a record
    double exchanges = 0, modelled_ms = 0, exchanged_mb = 0, host_ms = 0; ///< of a frame
    double slowest_over_mean = 0;
    std::uint64_t sram_bytes = 0;
    double early_exchanges = 0, early_ms = 0, early_mb = 0, early_host_ms = 0; ///< of a prefetch, before a frame
};

/// Measures frames of the anchored program along motions, with and without prefetch. Adds a sentence to `broken` for each check that fails.
void measure_prefetch(bench::Scene const& scene, Options const& options, std::vector<Motion>& rows, std::vector<std::string>& broken);

/// The section of README.md: what the policy is, a sentence for each motion, and the table.
std::string section(std::vector<Motion> const& rows);

} // namespace policies
