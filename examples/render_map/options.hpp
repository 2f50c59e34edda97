#pragma once
#include "../shared/inputs.hpp"
#include "choice.hpp"
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tilemesh/model/machine_file.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/report/y4m.hpp>
#include <vector>

namespace render_map {

/// The command line, checked as far as possible without looking at a file.
struct Options : shared::MapInput, shared::CameraInput, shared::MotionInput, shared::PhotographInput, shared::HostInput {
    std::vector<std::filesystem::path> maps;          ///< joined in this order; empty: the built-in map
    std::optional<std::filesystem::path> compare;     ///< another renderer's picture
    bool error_picture = false;
    bool machine_named = false;
    std::optional<std::filesystem::path> machine;     ///< a file; empty: the machine is in `choice`
    std::shared_ptr<tilemesh::MachineFile const> machine_file; ///< its content, once it is read (load_machine)
    Choice choice;
    tilemesh::RendererOptions renderer{.program = tilemesh::report::Program::automatic};
    std::optional<std::uint32_t> channel_slots, storage_slots; ///< as given, also 0; `renderer` has them too
    std::optional<std::filesystem::path> out;         ///< empty: ./tilemesh_out
    std::optional<std::filesystem::path> video;       ///< "-": standard output
    tilemesh::report::FrameRate fps;                  ///< of the video
    std::optional<std::filesystem::path> report;
    std::optional<std::filesystem::path> trace;       ///< the folder; with it `choice.trace`
    bool trace_tiles = false;                         ///< also tables by superstep and tile of more than most_tile_lines
    std::optional<std::filesystem::path> cost_model;  ///< empty: that of the machine's file, or mk2()
    std::optional<std::filesystem::path> energy;      ///< an energy model; empty: no joules
    std::optional<std::uint32_t> follow;              ///< the id of a Gaussian
    bool explain = false;
    bool pfm = false; ///< planes are in `choice`
    bool reference = false;
    std::optional<std::filesystem::path> judge_scenes; ///< the folder for scenes with bounding pictures, in place of a run
    bool bound = false;                               ///< the bound of each pixel, as the tiles know it
    bool certify = false;                             ///< with `pfm` also pictures of the bounds
    bool strict = false;                              ///< exit status 1 if a picture lacks records or copies
    bool resume = false;
    std::vector<std::string> shaping;                 ///< "--size=64x48": every given option that may change a frame; without its value if that is an input
    bool version = false;
};

/// Throws `tilemesh::Error` for an unknown, repeated, malformed or contradictory option. After "--" every word is a map. With --help or
/// --version, no other option is looked at.
Options parse_options(std::span<char const* const> words);

/// The text of --help.
std::string help_text();

/// The text of --version.
std::string version_text();

} // namespace render_map
