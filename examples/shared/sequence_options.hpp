#pragma once
#include "inputs.hpp"
#include <filesystem>
#include <optional>
#include <string>
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

inline constexpr Option<SequenceOptions> result_rows[] = {option<&SequenceOptions::out>("out", "DIR", "folder for the results [.]"),
                                                         option<&SequenceOptions::report>("report", "FILE", "a report as JSON")};

/// Adds the groups that all programs that track have. `size`: the help's default for rendered pictures.
void add_sequence(OptionTable& table, SequenceOptions& o, std::string_view size);

/// Every file that such a run reads: `files_read`, with the lists of --photos, the pictures in them, and `sized_by`.
std::vector<std::filesystem::path> files_read(SequenceOptions const& o, std::vector<std::optional<std::filesystem::path>> const& maps,
                                              std::vector<tilemesh::scene::RgbdFrame> const& photos,
                                              std::vector<std::filesystem::path> sized_by);

} // namespace shared
