#pragma once
#include "../shared/sequence_options.hpp"
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <tilemesh/slam/mapper.hpp>
#include <tilemesh/track/pose_solver.hpp>

namespace slam_program {

/// What the command line says.
struct Options : shared::SequenceOptions {
    std::optional<std::filesystem::path> render; ///< neither it nor `photos`: the built-in map is rendered
    std::optional<std::filesystem::path> map;    ///< to start from; none: an empty one
    bool resume = false;
    std::uint32_t keyframe_every = 5, steps = 30, finish = 5, cell = 2;
    double most_open = 0.08;
    tilemesh::slam::Optimiser optimiser = tilemesh::slam::Optimiser::adam;
    std::optional<tilemesh::track::Method> method; ///< none: hybrid, or forward for pictures of less than 320 pixels across
    std::optional<std::filesystem::path> page;
    std::vector<std::string> shaping; ///< "cell=3", sorted: every given option that may change the state of a run after a frame
};

/// Reads the command line. Empty after `--help`, which it prints. Throws `tilemesh::Error` for an unknown option or a bad value.
std::optional<Options> options_of(int argc, char** argv);

} // namespace slam_program
