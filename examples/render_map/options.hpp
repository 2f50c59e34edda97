#pragma once
#include "choice.hpp"
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tilemesh/model/machine_file.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/report/y4m.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <vector>

namespace render_map {

/// The largest number of frames in a run. With more frames, the list of cameras alone takes more memory than a large map.
inline constexpr std::uint32_t most_frames = 1'000'000;

/// The command line, checked as far as possible without looking at a file.
struct Options {
    std::vector<std::filesystem::path> maps;          ///< joined in this order; empty: the built-in map
    std::optional<tilemesh::scene::Turn> turn;        ///< of the map, about the origin
    std::optional<std::filesystem::path> cameras;
    std::optional<std::string> camera;                ///< SCENE/NAME, or NAME if it is unique
    std::optional<double> orbit_degrees;              ///< per frame
    std::uint32_t frames = 0;                          ///< frames of the orbit, or at most these of the trajectory; 0: all
    std::optional<std::filesystem::path> trajectory;
    std::optional<tilemesh::scene::TrajectoryFormat> trajectory_format; ///< empty: the file tells it
    std::optional<std::uint32_t> every;               ///< every so many-th pose of the trajectory, or camera by name, from the first; empty: all
    tilemesh::scene::DistortedLens distorted = tilemesh::scene::DistortedLens::refused;
    std::uint32_t scale = 1;                           ///< divides the sides of the camera file's pictures
    std::optional<std::filesystem::path> photos;      ///< the folder of the photographs
    std::optional<std::filesystem::path> compare;     ///< another renderer's picture
    bool error_picture = false;
    bool relative = false;
    /// A camera without a file. Empty: the middle of the map, guessed positions, y down, 60 degrees.
    std::optional<std::array<double, 3>> from, look, up;
    std::optional<double> fov;
    bool list = false;                                ///< print the names of the camera file, and render nothing
    std::optional<tilemesh::scene::Size> size;
    std::optional<float> near_depth;                  ///< of all cameras
    bool machine_named = false;
    std::optional<std::filesystem::path> machine;     ///< a file; empty: the machine is in `choice`
    std::shared_ptr<tilemesh::MachineFile const> machine_file; ///< its content, once it is read (load_machine)
    Choice choice;
    tilemesh::RendererOptions renderer;
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
    std::uint32_t sh_degree = 3;                      ///< the highest degree
    bool explain = false;
    bool pfm = false; ///< planes are in `choice`
    bool reference = false;
    bool quiet = false;
    bool strict = false;                              ///< exit status 1 if a picture lacks records or copies
    bool resume = false;
    std::vector<std::string> shaping;                 ///< "--size=64x48": every given option that may change a frame; without its value if that is an input
    std::vector<std::filesystem::path> inputs;        ///< every input path above, as the user gave it
    bool help = false;
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
