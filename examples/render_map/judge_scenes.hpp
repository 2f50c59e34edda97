#pragma once
#include "options.hpp"
#include <string>

namespace render_map {

/// Writes the maps, cameras and bounding pictures of --judge-scenes, and scenes.json (examples/judge_scenes.md). The rules are those of the
/// options. Returns what it wrote, for standard output.
std::string write_judge_scenes(Options const& options);

} // namespace render_map
