#pragma once
#include "options.hpp"
#include "rows.hpp"
#include <common/scenes.hpp>
#include <string>
#include <vector>

namespace any_map {

/// The map of that name and its camera. Throws Error for a bad file.
bench::Scene load(std::string const& name, Options const& options);
bool has(std::string const& name, Options const& options);

/// Renders all views of a map with all programs, and adds a row for each. With `sweeps`, it also renders one view with other slots. `broken`
/// gets a line for every picture of the program of homes that is not complete, and for every complete picture without the bits of the naive
/// whole-frame loop.
void measure(bench::Scene const& scene, Options const& options, bool sweeps, std::vector<Row>& rows, std::vector<std::string>& broken);

} // namespace any_map
