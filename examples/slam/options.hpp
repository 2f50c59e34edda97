#pragma once
#include "../shared/sequence.hpp"
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/slam/mapper.hpp>
#include <tilemesh/track/pose_solver.hpp>

namespace slam_program {

/// What the command line says.
struct Options : shared::SequenceOptions {
    std::optional<std::filesystem::path> photos, render; ///< neither: the built-in map is rendered
    std::optional<std::filesystem::path> map;            ///< to start from; none: an empty one
    std::optional<std::filesystem::path> cameras;
    std::string camera;
    bool quiet = false, resume = false;
    std::optional<tilemesh::scene::Size> size; ///< none: that of the pictures, or 320 x 240
    std::optional<float> near_depth;           ///< none: the camera file's, or one that fits the scene
    std::uint32_t frames = 60, keyframe_every = 5, steps = 30, finish = 5, cell = 2;
    double most_open = 0.08;
    tilemesh::slam::Optimiser optimiser = tilemesh::slam::Optimiser::adam;
    std::optional<tilemesh::track::Method> method; ///< none: hybrid, or forward for pictures of less than 320 pixels across
    std::optional<std::filesystem::path> report, page;
    std::filesystem::path out = ".";
};

/// Reads the command line. Empty after `--help`, which it prints. Throws `tilemesh::Error` for an unknown option or a bad value.
std::optional<Options> options_of(int argc, char** argv);

} // namespace slam_program
