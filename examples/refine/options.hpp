#pragma once
#include "../shared/inputs.hpp"
#include <cstdint>
#include <filesystem>
#include <optional>

namespace refine {

enum class Optimiser { by_kind, adam };

/// What the command line says.
struct Options : shared::MapInput, shared::CameraInput, shared::PhotographInput, shared::DepthInput, shared::HostInput {
    std::filesystem::path map, out = "refined.ply";
    std::optional<std::filesystem::path> report;
    std::optional<std::filesystem::path> depths; ///< an RGB-D list with depths of the photographs
    std::optional<std::uint32_t> steps; ///< none: 20 for each picture that is not held out
    std::optional<std::uint32_t> every; ///< none: 8
    double rate = 1;                    ///< times all rates
    Optimiser optimiser = Optimiser::by_kind;
};

/// Reads the command line. Empty after `--help`, which it prints. Throws `tilemesh::Error` for an unknown option or a bad value.
std::optional<Options> options_of(int argc, char** argv);

} // namespace refine
