#pragma once
#include "options.hpp"
#include <filesystem>
#include <optional>
#include <string>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/camera.hpp>
#include <vector>

namespace render_map {

/// The photograph of a camera.
struct Photograph {
    std::filesystem::path path;
    std::filesystem::path mask; ///< empty: all of it counts
    std::string problem; ///< why no frame can be compared with it; empty: a frame can
    tilemesh::scene::Size size{};
    bool found = false;  ///< there is such a file
};

/// A camera and its name in reports.
struct Shot {
    std::string name;
    tilemesh::splat::Camera camera;
    std::optional<double> timestamp_s{}; ///< of its pose; empty if no trajectory moves the camera
    std::string picture{};               ///< the camera's name in its file, which names its photograph; empty if it has no file
    tilemesh::splat::Camera full{};      ///< the camera before --scale, if it is from a file
    std::string mask{};                  ///< of its photograph
    std::optional<Photograph> photograph{};
};

/// The means and the sizes of a map's Gaussians, as far as a camera without a file depends on them.
struct Outline {
    struct Point {
        float mean_world[3];
        float log_scale[3];
    };
    std::vector<Point> gaussians;
};
using shared::MapShape;

/// The cameras that the options select, in rendering order; at least one. A reader's notes about its file are added to `notes`, one line
/// each; the pictures from which the reader took the sizes of cameras, and masks, are added to `sized_by`, and the names of all cameras of the
/// file to `names`. Throws `tilemesh::Error` for a file that
/// cannot be used, and for a selection without a camera.
std::vector<Shot> make_shots(Options const& options, MapShape const& map, std::vector<std::string>& notes,
                             std::vector<std::filesystem::path>& sized_by, std::vector<std::string>& names);

} // namespace render_map
