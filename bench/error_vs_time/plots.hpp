#pragma once
#include "rows.hpp"
#include <filesystem>
#include <string>
#include <vector>

namespace error_vs_time {

/// RMSE over a cost, both logarithmic, of each scene's first single view: SCENE_pairs.svg, SCENE_modelled.svg and SCENE_host.svg
/// (median host time; only where times were taken). All settings as faded dots by knob, the front as a line, the named settings as
/// dots. Host times are noise to a few percent, so they have no front of their own: there the settings on the front by pairs are
/// marked. `rows` after `mark_fronts`; the folder exists.
///
/// Returns a sentence for each view with settings that no logarithmic axis shows: failed, or with an RMSE or a cost of 0. The pictures
/// say their number.
std::vector<std::string> write_plots(std::filesystem::path const& folder, std::vector<Row> const& rows);

} // namespace error_vs_time
