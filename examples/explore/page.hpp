#pragma once
#include "runs.hpp"
#include "study.hpp"
#include <string>
#include <vector>

namespace explore {

/// A line a point, with the front and the knee. `points` are in the order of the study's settings.
std::string csv_of(Study const& study, std::vector<Point> const& points);
/// The page: the front in two diagrams whose dots name their points, and tables. It needs no other file, but links to the pictures.
std::string page_of(Study const& study, std::vector<Point> const& points, std::string const& how);

} // namespace explore
