#pragma once
#include "options.hpp"
#include "shots.hpp"
#include <cstdint>
#include <string>
#include <tilemesh/report/run_report.hpp>
#include <vector>

namespace render_map {

/// Reads the file that --machine names, if it names one. Its grid becomes that of the run, unless --grid or --tile is given. Throws
/// `tilemesh::Error` for a file that is no machine, or that lacks a number that a run needs.
void load_machine(Options& options);

/// Tells the choice how many pixels a tile of the file's machine needs for the largest frame, and whether homes keep their sizes there with
/// `records` records of this degree. Notes what the file knows.
void fit_machine(Options& options, std::vector<Shot> const& shots, std::uint64_t records, std::uint32_t sh_degree, std::vector<std::string>& notes);

/// A note on the SRAM that the described run leaves free on the file's machine; empty if it is less than a tenth, or for another machine.
std::string free_sram(Options const& options, tilemesh::report::RunReport const& run);

} // namespace render_map
