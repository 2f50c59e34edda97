#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <tilemesh/track/pose_solver.hpp>

namespace track_camera {

/// What the command line says.
struct Options {
    std::optional<std::filesystem::path> map; ///< none: the built-in map
    std::optional<std::filesystem::path> cameras, trajectory, photos, save_photos;
    std::optional<tilemesh::scene::TrajectoryFormat> trajectory_format; ///< empty: the file tells it
    std::string camera;
    bool relative = false, quiet = false, depth = true;
    std::optional<tilemesh::scene::Size> size; ///< none: that of the pictures, or 640 x 480
    std::optional<float> near_depth;           ///< none: the camera file's, or `scene::near_for`
    tilemesh::scene::Size tile{0, 0};          ///< 0: follows from the size
    std::uint32_t frames = 60, every = 1, one_in = 1, threads = 1;
    double noise = 0.02, shutter = 0.5, depth_levels = 5000.0;
    tilemesh::track::Method method = tilemesh::track::Method::hybrid;
    std::optional<std::filesystem::path> report;
    std::filesystem::path out = ".";
};

/// Reads the command line. Empty after `--help`, which it prints. Throws `tilemesh::Error` for an unknown option or a bad value.
std::optional<Options> options_of(int argc, char** argv);

} // namespace track_camera
