#pragma once
#include "choice.hpp"
#include "options.hpp"
#include <ostream>
#include <tilemesh/report/run_report.hpp>
#include <tilemesh/scene/demand.hpp>
#include <vector>

namespace render_map {

/// What a run keeps of the machine: `seen` is what map and cameras need, `used` what the renderer was made for.
struct Needs {
    tilemesh::scene::Demand seen, used;
    std::string kept_because; ///< why all is kept although the scene does not need it; empty: nothing asks for it
};

/// Scans map and cameras. Options that explore the machine (capacities, hops, policies, other presets) keep all of it.
Needs needs_of(Options const& options, tilemesh::scene::Map const& map, std::vector<tilemesh::splat::Camera> const& path);

/// Feature by feature what runs, what does not, and why. `file_degree` is that of the harmonics before --sh-degree.
std::vector<tilemesh::report::RunReport::Feature> features(Options const& options, Needs const& needs,
                                                           tilemesh::scene::Map const& map, std::uint32_t file_degree,
                                                           AnyRenderer const& renderer);

/// The features as --explain prints them.
void explain(std::ostream& out, tilemesh::report::RunReport const& run);

} // namespace render_map
