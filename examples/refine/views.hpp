#pragma once
#include "options.hpp"
#include <filesystem>
#include <string>
#include <tilemesh/mapping/view_sums.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/camera.hpp>
#include <vector>

namespace refine {

/// A camera and its photograph. The photograph is kept with 8 bits a channel, as its file has it.
struct View {
    std::string name;
    tilemesh::splat::Camera camera;
    std::filesystem::path photograph, mask, depth; ///< no mask: all of the photograph counts; perhaps no depth
    tilemesh::scene::Size size; ///< of the photograph's file
    std::vector<unsigned char> levels;
    std::vector<bool> counts{}; ///< by pixels; empty: all count
    std::vector<float> depths{}; ///< by pixels, in world units; 0 or empty: not known

    tilemesh::mapping::Target target() const;
};
/// The views of a run, in the order of their names.
struct Views {
    std::vector<View> held_out, used;
    std::vector<std::filesystem::path> read; ///< the files of the cameras and the photographs
    std::vector<std::string> notes;
};

/// Finds the cameras and their photographs; it reads the headers of the photographs alone. A camera without a photograph is left out,
/// with a note. Throws `tilemesh::Error` for a photograph of another size than its camera's, whole or divided by --scale, for a mask of
/// another size than its photograph's, if no photograph would be held out or none be used, and if
/// --depths has no depth of any of them.
Views find_views(Options const& options, tilemesh::scene::Map const& map);

/// Reads the photograph of each view, its mask and its depths.
void read_photographs(Options const& options, std::vector<View>& views);

} // namespace refine
