#pragma once
#include <ostream>
#include <string>
#include <tilemesh/report/run_report.hpp>

namespace render_map {

/// What a terminal shows of a run with at least one frame: the map, of several frames one line each and the totals, then
/// the last frame in full.
void print_summary(std::ostream& out, tilemesh::report::RunReport const& run);

/// Which pictures lack records or copies, of the worst how many and why, and what to do about it: "<problem> (<why>); <what to
/// do>". Empty where no picture lacks anything.
std::string missing_text(tilemesh::report::RunReport const& run);

} // namespace render_map
