#pragma once
#include <filesystem>
#include <istream>
#include <optional>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// A picture of a sequence: its time stamp and its file, as the list writes it.
struct StampedFile {
    double seconds = 0.0;
    std::filesystem::path file;
};

/// A frame of an RGB-D sequence. `depth.file` is empty if the frame has no depth. `mask`: a picture that is white where the frame counts; no list
/// has it, so it is empty unless a program sets it.
struct RgbdFrame {
    StampedFile colour, depth;
    std::filesystem::path mask{};
};

/// The furthest that the stamps of a picture and its depth are apart: 20 ms, the limit of the TUM benchmark's own tool.
inline constexpr double most_seconds_apart = 0.02;

/// Reads a list of pictures as the TUM RGB-D benchmark has them (rgb.txt, depth.txt): a line is `timestamp file`, and `#` starts a line of
/// comment. The result is in the order of time; pictures of one time keep their order. Stamps in milliseconds, microseconds or nanoseconds are
/// recognised as those of trajectories are, and `notes` says so; a backslash in a name is read as "/". Throws `Error` for any other line and
/// names the line, and for a list without a picture. `name` is the file's name in errors.
TILEMESH_HOST std::vector<StampedFile> read_file_list(std::istream& stream, std::string const& name, std::vector<std::string>* notes = nullptr);

/// Gives each picture the depth that is nearest in time and not further away than `most_seconds`. A depth that is nearest to several
/// pictures goes to the nearest of these (the first, if they are equally near), and the others have none. Both lists must be in the order
/// of time. Cost: a binary search a picture.
TILEMESH_HOST std::vector<RgbdFrame> associate(std::vector<StampedFile> const& colour, std::vector<StampedFile> const& depth,
                                               double most_seconds = most_seconds_apart);

/// Reads a list of frames: `timestamp rgb_file` for colour alone, or `timestamp rgb_file timestamp depth_file` (an association file of the
/// TUM RGB-D benchmark), all lines alike. The order is that of the colour's time. Throws `Error` as `read_file_list` does.
TILEMESH_HOST std::vector<RgbdFrame> read_rgbd_list(std::istream& stream, std::string const& name, std::vector<std::string>* notes = nullptr);

/// The frames of a sequence of the TUM RGB-D benchmark, with paths that can be opened. `path` is an association file, or a folder: then
/// its `associations.txt` counts if it has one, else its `rgb.txt` and, if it has one, `depth.txt`. Names in a list start at the list's folder.
/// Depths of `depth.txt` are at most `depth_within` seconds away from their picture. Without `depth_within`, no depth is read.
///
/// `notes`, which may be null, gets at most five lines: the unit of stamps that are not seconds, or that are whole and more than 1 s apart; how
/// many pictures have an earlier one's stamp; how many pictures have a depth, if not all have one; depths of an association file that are more
/// than `depth_within` away. These are kept, because the file says itself which depth belongs to which picture.
///
/// Throws `Error` as the readers do, for a folder without these files, for a list that is no regular file, and if no depth of `depth.txt` is near
/// enough to a picture; the error names the nearest distance.
TILEMESH_HOST std::vector<RgbdFrame> load_rgbd(std::filesystem::path const& path, std::optional<double> depth_within = most_seconds_apart,
                                               std::vector<std::string>* notes = nullptr);

}}} // namespace tilemesh::scene

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/rgbd_list_code.hpp>
#endif
