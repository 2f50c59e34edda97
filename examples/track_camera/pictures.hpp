#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <tilemesh/report/image.hpp>

namespace track_camera {

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
