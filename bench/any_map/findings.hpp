#pragma once
#include "rows.hpp"
#include <filesystem>
#include <string>
#include <vector>

namespace any_map {

/// A Markdown table of the rows that are not of a sweep, a line for each view and program.
std::string view_table(std::vector<Row> const& rows);
/// A Markdown table of the modelled milliseconds of each step of the program of homes.
std::string step_table(std::vector<Row> const& rows);
/// A Markdown table of the sweeps of a map.
std::string sweep_table(std::vector<Row> const& rows);
/// The conclusions from the rows, one sentence or two each.
std::vector<std::string> findings(std::vector<Row> const& rows);
/// Writes README.md and slots.svg into an existing folder. `complete`: all checks hold.
void write_readme(std::filesystem::path const& folder, std::vector<Row> const& rows, bool complete);

} // namespace any_map
