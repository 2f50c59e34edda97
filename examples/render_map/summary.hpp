#pragma once
#include <ostream>
#include <tilemesh/report/run_report.hpp>

namespace render_map {

/// What a terminal shows of a run with at least one frame: the map, of several frames one line each and the totals, then
/// the last frame in full.
void print_summary(std::ostream& out, tilemesh::report::RunReport const& run);

} // namespace render_map
