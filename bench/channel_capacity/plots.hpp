#pragma once
#include "latency.hpp"
#include "sweep.hpp"
#include <filesystem>
#include <vector>

namespace channel_capacity {

/// Writes SCENE_psnr.svg, SCENE_supersteps.svg and SCENE_pareto.svg for each scene of `rows`, and latency.svg if there are latency rows.
/// The folder must exist.
void write_plots(std::filesystem::path const& folder, std::vector<Row> const& rows, std::vector<LatencyRow> const& latency);

} // namespace channel_capacity
