#pragma once
#include "csv.hpp"
#include "front.hpp"
#include "rows.hpp"
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

} // namespace error_vs_time
