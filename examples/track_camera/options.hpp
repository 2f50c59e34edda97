#pragma once
#include "../shared/sequence.hpp"
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/track/pose_solver.hpp>

namespace track_camera {

/// What the command line says.
struct Options : shared::SequenceOptions {
    std::optional<std::filesystem::path> map; ///< none: the built-in map
    std::optional<std::filesystem::path> cameras, photos, save_photos;
    std::string camera;
    bool quiet = false;
    std::optional<tilemesh::scene::Size> size; ///< none: that of the pictures, or 640 x 480
    std::optional<float> near_depth;           ///< none: the camera file's, or `scene::near_for`
    tilemesh::scene::Size tile{0, 0};          ///< 0: follows from the size
    std::uint32_t frames = 60, one_in = 1;
    tilemesh::track::Method method = tilemesh::track::Method::hybrid;
    std::optional<std::filesystem::path> report;
    std::filesystem::path out = ".";
};

/// Reads the command line. Empty after `--help`, which it prints. Throws `tilemesh::Error` for an unknown option or a bad value.
std::optional<Options> options_of(int argc, char** argv);

} // namespace track_camera
