#pragma once
#include "csv.hpp"
#include "front.hpp"
#include "rows.hpp"
#include <iosfwd>
#include <string>
#include <vector>

namespace error_vs_time {

// Fronts, claims about host time and what must hold are in front.hpp (mark_fronts, claim_of, verdict_of), the file of all rows in csv.hpp.

/// For each scene and camera: the front by pairs and the named settings with their errors and costs, and the noise of host times. Then the
/// section "Omissions and failures": what failed and why, which pictures lack what, what was `skipped` (scenes, a sentence each) and what
/// is left out by design (`standing`, a sentence each). `rows` after `mark_fronts`.
void print_tables(std::ostream& out, std::vector<Row> const& rows, std::vector<Noise> const& noise,
                  std::vector<std::string> const& skipped = {}, std::vector<std::string> const& standing = {});

} // namespace error_vs_time
