#pragma once
#include "runs.hpp"
#include "study.hpp"
#include <string>
#include <vector>

namespace explore {

/// "9.6 % guessed": the share of the weakest kind of prices in a point's cycles.
std::string weakest_text(Point const& point);
/// Bytes of a tile's SRAM that a point leaves free.
std::uint64_t free_bytes(Setting const& setting, Point const& point);

/// A line a point, with the front and the knee. `points` are in the order of the study's settings.
std::string csv_of(Study const& study, std::vector<Point> const& points);
/// The page: the front in two diagrams whose dots name their points, and tables. It needs no other file, but links to the pictures.
std::string page_of(Study const& study, std::vector<Point> const& points, std::string const& how);

} // namespace explore
