#pragma once
#include "options.hpp"
#include <array>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/camera.hpp>
#include <vector>

namespace render_map {

/// The photograph of a camera.
struct Photograph {
    std::filesystem::path path;
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
    std::optional<Photograph> photograph{};
};

/// The names of the camera file, one per line, in its order. Throws `tilemesh::Error` for a file that cannot be used.
std::string camera_names(Options const& options);

/// The means and the sizes of a map's Gaussians, as far as a camera without a file depends on them.
struct Outline {
    struct Point {
        float mean_world[3];
        float log_scale[3];
    };
    std::vector<Point> gaussians;
};
/// The middle of a map, and the camera that shows all of it (scene/frame_whole.hpp).
struct MapShape {
    std::string name;
    std::function<glm::dvec3()> centre;
    std::function<tilemesh::splat::Camera(tilemesh::scene::Size, glm::dvec3 up, double degrees)> whole;
    std::function<float(tilemesh::splat::Camera const&)> near_plane; ///< for a camera whose file names none (scene/near_plane.hpp)
    std::array<double, 3> origin{}; ///< the reader of the map has subtracted it
};
/// The shape of a map in this process. The map must outlive it.
MapShape shape_of(tilemesh::scene::Map const& map);

/// The cameras that the options select, in rendering order; at least one. A reader's notes about its file are added to `notes`, one line
/// each; the pictures from which the reader took the sizes of cameras are added to `sized_by`. Throws `tilemesh::Error` for a file that
/// cannot be used, and for a selection without a camera.
std::vector<Shot> make_shots(Options const& options, MapShape const& map, std::vector<std::string>& notes,
                             std::vector<std::filesystem::path>& sized_by);

} // namespace render_map
