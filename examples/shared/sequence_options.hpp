#pragma once
#include "inputs.hpp"
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/rgbd_list.hpp>
#include <vector>

namespace shared {

/// What the command line of a program that tracks says about its pictures and its outputs.
struct SequenceOptions : MapInput, CameraInput, MotionInput, RecordingInput, HostInput {
    SequenceOptions() { frames = 60; }
    std::string without_depth; ///< how a picture goes without a depth: ", or use --no-depth"
    std::optional<std::filesystem::path> report;
    std::filesystem::path out = ".";
};

class OptionTable;
/// Adds the groups that all programs that track have. `size`, `out`: the help of --size and --out.
void add_sequence(OptionTable& table, SequenceOptions& o, std::string_view size, std::string_view out);

/// Gives the pictures of --photos the masks that the file of --cameras names for them: of the camera that has the picture's name
/// (`photographs_of`). A note counts them. `size`: of cameras whose file says none.
void add_masks(SequenceOptions const& o, tilemesh::scene::Size size, std::vector<tilemesh::scene::RgbdFrame>& photos,
               std::vector<std::string>& notes);

/// Every file that such a run reads: `files_read`, with the lists of --photos, the pictures in them, and `sized_by`.
std::vector<std::filesystem::path> files_read(SequenceOptions const& o, std::vector<std::optional<std::filesystem::path>> const& maps,
                                              std::vector<tilemesh::scene::RgbdFrame> const& photos,
                                              std::vector<std::filesystem::path> sized_by);

} // namespace shared
