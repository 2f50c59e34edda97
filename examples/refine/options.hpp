#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>

namespace refine {

enum class Optimiser { by_kind, adam };

/// What the command line says.
struct Options {
    std::filesystem::path map, cameras, photos;
    std::filesystem::path out = "refined.ply";
    std::optional<std::filesystem::path> report;
    std::optional<std::uint32_t> steps; ///< none: 20 for each picture that is not held out
    std::uint32_t every = 8, scale = 1, threads = 1;
    std::optional<float> near_depth; ///< none: the camera file's, or `scene::near_for`
    double rate = 1;                 ///< times all rates
    std::array<float, 3> background{0, 0, 0};
    Optimiser optimiser = Optimiser::by_kind;
    bool quiet = false, ignores_distortion = false;
};

/// Reads the command line. Empty after `--help`, which it prints. Throws `tilemesh::Error` for an unknown option or a bad value.
std::optional<Options> options_of(int argc, char** argv);

} // namespace refine
