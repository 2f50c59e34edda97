#pragma once
#include "options.hpp"
#include "shots.hpp"
#include <filesystem>
#include <optional>
#include <string>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/run_report.hpp>
#include <vector>

namespace render_map {

/// Finds the photograph of each shot below the folder of --photos (`shared::photographs_of`); `names` are all cameras of the
/// file. A photograph whose sides are the camera's divided by --scale, rounded up or down, sets the shot's size, as trainers do. A shot without a photograph that can be compared gets the reason. Throws `tilemesh::Error` if the folder has no
/// photograph of any shot, and for a mask that cannot be used. Cost: a few system calls for each shot, and the header of its photograph.
void find_photographs(Options const& options, std::vector<std::string> const& names, std::vector<Shot>& shots, std::vector<std::string>& notes);

/// The picture of --compare, and whether its values end at 0 and 1, as those of PNG and JPEG do.
struct OtherPicture {
    tilemesh::report::Image image;
    bool ends_at_1 = true;
};
/// Reads the picture of --compare: PFM, PNG or JPEG, which the content tells. Empty without the option. Throws `tilemesh::Error` if it cannot be
/// read or has not the size of the one shot, and if there are several shots.
std::optional<OtherPicture> read_other(Options const& options, std::vector<Shot> const& shots);

/// Compares a frame with its photograph, or with the other picture, and puts the measures or the reason why there are none into `frame`.
/// With --error-picture, also writes the error picture to `error_path`. Returns whether it wrote that.
bool compare_frame(Options const& options, Shot const& shot, std::optional<OtherPicture> const& other, tilemesh::report::Image const& rendered,
                   std::filesystem::path const& error_path, tilemesh::report::RunFrame& frame);

/// Why frames were not compared with their photographs, one line each.
std::vector<std::string> photograph_problems(tilemesh::report::RunReport const& run);

} // namespace render_map
