#pragma once
#include "choice.hpp"
#include "options.hpp"
#include <ostream>
#include <tilemesh/report/run_report.hpp>
#include <tilemesh/scene/demand.hpp>
#include <vector>

namespace render_map {

/// The parts of the machine that a run keeps. `seen`: the demand of map and cameras; `used`: the demand for which the renderer was made.
struct Needs {
    tilemesh::scene::Demand seen, used;
    std::string kept_because; ///< why all parts are kept although the scene does not need them; empty: no reason
};

/// Scans map and cameras. With options that explore the machine (capacities, hops, policies, other presets), all of it is kept.
Needs needs_of(Options const& options, tilemesh::scene::Map const& map, std::vector<tilemesh::splat::Camera> const& path);

/// For each feature: whether it runs, and why. `file_degree`: the degree of the file's harmonics, before --sh-degree.
std::vector<tilemesh::report::RunReport::Feature> features(Options const& options, Needs const& needs,
                                                           tilemesh::scene::Map const& map, std::uint32_t file_degree,
                                                           tilemesh::Renderer const& renderer);

/// Prints the features, for --explain.
void explain(std::ostream& out, tilemesh::report::RunReport const& run);

} // namespace render_map
