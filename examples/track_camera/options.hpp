#pragma once
#include "../shared/sequence_options.hpp"
#include <cstdint>
#include <filesystem>
#include <optional>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/track/pose_solver.hpp>

namespace track_camera {

/// What the command line says.
struct Options : shared::SequenceOptions {
    std::optional<std::filesystem::path> map; ///< none: the built-in map
    std::optional<std::filesystem::path> save_photos;
    tilemesh::scene::Size tile{0, 0}; ///< 0: follows from the size
    std::uint32_t one_in = 1;
    tilemesh::track::Method method = tilemesh::track::Method::hybrid;
};

/// Reads the command line. Empty after `--help`, which it prints. Throws `tilemesh::Error` for an unknown option or a bad value.
std::optional<Options> options_of(int argc, char** argv);

} // namespace track_camera
