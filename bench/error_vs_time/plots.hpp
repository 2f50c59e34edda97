#pragma once
#include "rows.hpp"
#include <filesystem>
#include <string>
#include <vector>

namespace error_vs_time {

/// Plots RMSE over a cost, both logarithmic, for each scene's first single view: SCENE_pairs.svg, SCENE_modelled.svg and SCENE_host.svg
/// (median host time; only if times were taken). All settings are faded dots by knob, the front is a line, the named settings are dots.
/// Host times have a few percent of noise, so they have no front of their own; that plot marks the settings on the front by pairs. Call
/// `mark_fronts(rows)` first; the folder must exist.
///
/// Returns one sentence for each view with settings that a logarithmic axis cannot show: they failed, or have an RMSE or a cost of 0. The
/// plots state the number of such settings.
std::vector<std::string> write_plots(std::filesystem::path const& folder, std::vector<Row> const& rows);

} // namespace error_vs_time
