#pragma once
#include "options.hpp"
#include <cstddef>
#include <filesystem>
#include <string>
#include <tilemesh/report/image.hpp>
#include <vector>

namespace track_camera {

/// The files in the folder of --out, in the order in which they are written.
inline constexpr char const* out_files[] = {"estimated.tum", "truth.tum", "cameras.json", "paths.svg", "residual.png"};

/// The lists in the folder of --save-photos.
inline constexpr char const* photo_lists[] = {"associations.txt", "groundtruth.txt"};

/// "000012.png": the picture of a frame in the folders rgb and depth of --save-photos.
std::string photo_file(std::size_t frame);

/// Makes the folders of --out and --save-photos, and checks that every file of `frames` frames can be written. Throws `tilemesh::Error` if a
/// file cannot be written, or would replace another file of the run or a file in `read` (`report::DistinctFiles`). It writes nothing except
/// the folders.
void prepare_outputs(Options const& options, std::vector<std::filesystem::path> const& read, std::size_t frames);

/// Depths as a grey PNG of 16 bits, with `levels` levels a world unit, rounded. A depth beyond the last level, and one that is not positive,
/// becomes 0. The file is not compressed: two bytes a pixel.
std::string depth_png(tilemesh::report::Plane const& depth, double levels);

/// Writes frames as the TUM RGB-D benchmark has them: rgb/000000.png, depth/000000.png, and after `finish` associations.txt and
/// groundtruth.txt. The folders must exist (`prepare_outputs`). Throws `tilemesh::Error` if a file cannot be written.
class PhotoWriter {
public:
    PhotoWriter(std::filesystem::path folder, double levels);
    void write(double seconds, tilemesh::report::Image const& colour, tilemesh::report::Plane const& depth);
    void finish(std::string const& truth_tum) const;

private:
    std::filesystem::path folder_;
    double levels_;
    std::size_t written_ = 0;
    std::string list_ = "# timestamp colour timestamp depth\n";
};

} // namespace track_camera
