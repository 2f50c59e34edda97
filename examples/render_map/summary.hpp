#pragma once
#include <ostream>
#include <string>
#include <tilemesh/report/run_report.hpp>

namespace render_map {

/// What a terminal shows of a run with at least one frame: the map, of several frames one line each and the totals, then
/// the last frame in full.
void print_summary(std::ostream& out, tilemesh::report::RunReport const& run);

/// Says how many pictures lack records or copies, and for the worst picture how many and why: "<problem> (<why>); <what to
/// do>". Empty if no picture lacks anything.
std::string missing_text(tilemesh::report::RunReport const& run);

} // namespace render_map
