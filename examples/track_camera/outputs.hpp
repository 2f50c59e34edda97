#pragma once
#include "options.hpp"
#include "pictures.hpp"
#include <optional>
#include <tilemesh/report/whole_file.hpp>
#include <tilemesh/scene/rgbd_list.hpp>
#include <vector>

namespace track_camera {

/// What the program will write. The constructor makes the folders, and opens everything before the first frame, so that a wrong name costs
/// no frame. Before it opens a file it refuses a run that would overwrite a file that it reads, or write two files with one name. Throws
/// `tilemesh::Error`.
struct Outputs {
    /// `pictures`: the real pictures that the run reads; empty if it renders its own.
    Outputs(Options const& options, std::vector<tilemesh::scene::RgbdFrame> const& pictures);
    std::optional<tilemesh::report::WholeFile> report_file;
    std::optional<PhotoWriter> photos;
};

} // namespace track_camera
