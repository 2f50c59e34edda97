#pragma once
#include "options.hpp"
#include <optional>
#include <string>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <vector>

namespace render_map {

/// A camera and its name in reports.
struct Shot {
    std::string name;
    tilemesh::splat::Camera camera;
    std::optional<double> timestamp_s{}; ///< of its pose; empty if no trajectory moves the camera
};

/// The cameras that the options select, in rendering order; at least one. A reader's notes about its file are added to `notes`, one line
/// each. Throws `tilemesh::Error` for a file that cannot be used, and for a selection without a camera.
std::vector<Shot> make_shots(Options const& options, tilemesh::scene::Map const& map, std::vector<std::string>& notes);

} // namespace render_map
