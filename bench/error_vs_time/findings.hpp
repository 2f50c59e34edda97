#pragma once
#include "front.hpp"
#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

namespace error_vs_time {

// front.hpp has fronts, claims about host time and the conditions that must hold (mark_fronts, claim_of, verdict_of). csv.hpp writes all
// rows.

/// Prints for each scene and camera: the front by pairs and the named settings with their errors and costs, and the noise of host times.
/// Then it prints the section "Omissions and failures": the settings that failed and why, the pictures that lack records, the scenes that
/// were `skipped` (one sentence each), and the limits of the design (`standing`, one sentence each). Call `mark_fronts(rows)` first.
void print_tables(std::ostream& out, std::vector<Row> const& rows, std::vector<Noise> const& noise,
                  std::vector<std::string> const& skipped = {}, std::vector<std::string> const& standing = {});

/// Plots RMSE over a cost, both logarithmic, for each scene's first single view: SCENE_pairs.svg, SCENE_modelled.svg and SCENE_host.svg
/// (median host time; only if times were taken). All settings are faded dots by knob, the front is a line, the named settings are dots.
/// Host times have a few percent of noise, so they have no front of their own; that plot marks the settings on the front by pairs. Call
/// `mark_fronts(rows)` first; the folder must exist.
///
/// Returns one sentence for each view with settings that a logarithmic axis cannot show: they failed, or have an RMSE or a cost of 0. The
/// plots state the number of such settings.
std::vector<std::string> write_plots(std::filesystem::path const& folder, std::vector<Row> const& rows);

} // namespace error_vs_time
