#pragma once
#include "explain.hpp"
#include "missing.hpp"
#include "options.hpp"
#include <ostream>
#include <string>
#include <tilemesh/report/run_report.hpp>

namespace render_map {

/// Prints the summary of a run with at least one frame for a terminal: the map; for several frames one line each and the totals; then the
/// last frame in full.
void print_summary(std::ostream& out, tilemesh::report::RunReport const& run);

/// Advice if pictures lack something: options that give room, hold, wait or bloom. The fullest tile is that of all pictures, and the
/// text names its picture. Empty if no picture lacks anything.
std::string advice(Options const& options, Needs const& needs, tilemesh::report::RunReport const& run);

} // namespace render_map
