#pragma once
#include "option_values.hpp"
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/rgbd_list.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <vector>

namespace shared {

/// What the command line of a program that tracks says about its pictures and its outputs.
struct SequenceOptions {
    std::optional<std::filesystem::path> photos; ///< none: pictures are rendered
    std::optional<std::filesystem::path> cameras, trajectory;
    std::string camera;
    std::optional<tilemesh::scene::TrajectoryFormat> trajectory_format; ///< empty: the file tells it
    std::optional<tilemesh::scene::Size> size;                          ///< none: that of the pictures, or the program's
    std::optional<float> near_depth;                                    ///< none: the camera file's, or one that fits the scene
    bool relative = false, depth = true, quiet = false;
    std::uint32_t frames = 60, every = 1, threads = 1;
    double noise = 0.02, shutter = 0.5, gain_drift = 0.1, depth_levels = 5000.0;
    std::string without_depth; ///< how a picture goes without a depth: ", or use --no-depth"
    std::optional<std::filesystem::path> report;
    std::filesystem::path out = ".";
};

/// Two whole numbers, as in "640x480".
tilemesh::scene::Size size_value(OptionValues const& values, std::string_view option, std::string_view text);

/// Reads option argv[i] and its value, if it is one of those that all programs that track have; moves i to the value. False: it is another.
bool read_option(SequenceOptions& o, OptionValues const& values, int argc, char** argv, int& i);

/// Throws Error for an option that needs another one.
void check_options(SequenceOptions const& o);

/// Every file that such a run reads: maps, cameras, trajectory, the lists of --photos and all pictures in them. A folder stands for its files.
/// Call it after the readers: it throws `tilemesh::Error` as they do. `sized_by`: the pictures from which `scene::load_cameras` took sizes.
std::vector<std::filesystem::path> files_read(SequenceOptions const& o, std::vector<std::optional<std::filesystem::path>> const& maps,
                                              std::vector<tilemesh::scene::RgbdFrame> const& photos,
                                              std::vector<std::filesystem::path> const& sized_by);

} // namespace shared
