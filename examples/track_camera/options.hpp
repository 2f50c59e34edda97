#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/track/pose_solver.hpp>

namespace track_camera {

/// What the command line says.
struct Options {
    std::optional<std::filesystem::path> map; ///< none: the built-in map
    std::optional<std::filesystem::path> cameras, trajectory;
    std::string camera;
    bool relative = false, quiet = false, depth = true;
    tilemesh::scene::Size size{1280, 720};
    std::uint32_t frames = 60, threads = 1;
    double noise = 0.02;
    tilemesh::track::Method method = tilemesh::track::Method::hybrid;
    std::optional<std::filesystem::path> report;
    std::filesystem::path out = ".";
};

/// Reads the command line. Empty after `--help`, which it prints. Throws `tilemesh::Error` for an unknown option or a bad value.
std::optional<Options> options_of(int argc, char** argv);

} // namespace track_camera
