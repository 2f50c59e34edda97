#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <istream>
#include <optional>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// The form of a trajectory's file; each line is a pose, camera to world.
enum class TrajectoryFormat {
    tum,    ///< of the TUM RGB-D benchmark: `timestamp tx ty tz qx qy qz qw`, in seconds
    euroc,  ///< of the EuRoC MAV data set: `timestamp, px, py, pz, qw, qx, qy, qz` and further fields, in nanoseconds or seconds
    kitti,  ///< of the KITTI odometry benchmark: the 12 numbers of a 3x4 matrix, row by row; no time stamp
    replica ///< traj.txt of the Replica renderings: the 16 numbers of a 4x4 matrix, row by row; no time stamp
};

/// A pose and its time stamp.
struct StampedPose {
    double seconds;
    Pose pose;
};

/// Poses in the order of their file. A trajectory from a file is never empty.
struct Trajectory : std::vector<StampedPose> {
    using std::vector<StampedPose>::vector;
    TrajectoryFormat format = TrajectoryFormat::tum; ///< of the file
    /// Does the file have time stamps? If not, `seconds` is the number of the pose, from 0.
    bool has_stamps() const noexcept { return format == TrajectoryFormat::tum || format == TrajectoryFormat::euroc; }
    /// The number of quaternions in the file whose length differs from 1 by more than 1e-2. Rounding to two decimals does not cause this.
    std::uint64_t far_from_unit = 0;
    /// The number of rows that were left out because a number in them is NaN or infinite.
    std::uint64_t left_out = 0;
    std::vector<std::string> reader_notes; ///< how the file was read, if that is not the usual form; the rows that were left out
};

/// 2^24 poses: four days at 48 poses a second, and 2 GB.
inline constexpr std::size_t most_poses = std::size_t{1} << 24;

namespace detail {
/// The seconds of one unit of time stamps: 1, 1e-3, 1e-6 or 1e-9. The unit is the one that makes the largest stamp a date from 2000 to 2100, if
/// the median step is then below 1,000 s. For other whole stamps the step decides: below 1,000 units they are seconds, below 1e6 microseconds,
/// else nanoseconds. Single stamps, and stamps that are not whole, are seconds below 1e11, milliseconds below 1e14, microseconds below 1e17.
/// Cost: one sort.
TILEMESH_HOST double seconds_per_unit(std::vector<double> stamps);
/// "milliseconds" for 1e-3.
TILEMESH_HOST std::string unit_name(double seconds_per_unit);
} // namespace detail

/// Reads a trajectory in the format of the TUM RGB-D benchmark. A line is a pose: `timestamp tx ty tz qx qy qz qw`, in seconds and world
/// units, camera to world, separated by blanks. `#` starts a comment, on its own line or after a pose. Blank lines are skipped. Quaternions
/// of any length except 0 are normalised. A row with NaN or an infinite number is left out, as by `read_trajectory`. Time stamps may be in any order,
/// and the poses keep the file's order; `trajectory_notes` reports unusual time stamps.
///
/// Throws `Error` for any other line and names the line, for a file without a pose, and for more than `most` poses. `name` is the file's
/// name in errors. Cost: 104 bytes a pose, up to three times that while the list grows.
TILEMESH_HOST Trajectory read_tum(std::istream& stream, std::string const& name, std::size_t most = most_poses);

/// Reads a TUM trajectory from a file, as `read_tum` does. Throws `Error` also if the file cannot be read or is not a regular file.
TILEMESH_HOST Trajectory load_tum(std::filesystem::path const& path, std::size_t most = most_poses);

/// Reads a trajectory in any `TrajectoryFormat`. Blanks or commas separate the numbers. `#` starts a comment, and blank lines are skipped; a
/// first line of names may have no `#`. All poses have the form of the first:
/// - 12 numbers are of KITTI and 16 of Replica, if blanks separate them;
/// - a line of a stamp, a position and a quaternion is of TUM or of EuRoC, which have the quaternion's w last and first. A header that names qx
///   and qw says which. Without one, more than eight numbers are of EuRoC; with commas, whole stamps of nanoseconds are of EuRoC; with blanks,
///   stamps that are no whole nanoseconds are of TUM. For any other file the motion decides, if with one order the velocity in the camera's
///   own axes is steady and with the other one it is not (`detail::restlessness`). A file that is still undecided is refused; `format` says
///   the form;
/// - stamps have the unit that the header says, or else the unit that `detail::seconds_per_unit` finds; whole stamps of a file of EuRoC whose form
///   was asked for are nanoseconds.
///
/// A row with NaN or an infinite number is left out, and a note names its line: a tracker writes such rows where it had lost its picture, and
/// the other poses are as good as they would be without. This is what the readers of maps do. Poses without stamps keep the number of their
/// row. Any other fault of a line is an error, because a number that is cut off or misplaced would be a wrong pose.
///
/// All poses take a camera as OpenCV's (x right, y down, z forward) to the world; the poses of EuRoC's own ground truth are those of
/// the IMU, and nothing in the file says how the camera stands on it (`trajectory_notes` says so). A rotation matrix must be orthonormal
/// within 1e-3, and is kept as it is. Throws `Error` as `read_tum`. Cost: 168 bytes a pose, up to twice that while the list grows.
TILEMESH_HOST Trajectory read_trajectory(std::istream& stream, std::string const& name, std::size_t most = most_poses,
                                         std::optional<TrajectoryFormat> format = {});

/// Reads a trajectory from a file, as `read_trajectory` does. Throws `Error` also if the file cannot be read or is not a regular file.
TILEMESH_HOST Trajectory load_trajectory(std::filesystem::path const& path, std::size_t most = most_poses,
                                         std::optional<TrajectoryFormat> format = {});

/// The trajectory for a map from which a reader subtracted this origin (`Map::origin`).
TILEMESH_HOST Trajectory relative_to_origin(Trajectory trajectory, std::array<double, 3> const& origin);

/// The form of this name: tum, euroc, kitti or replica. Nothing for any other name.
TILEMESH_HOST std::optional<TrajectoryFormat> trajectory_format(std::string_view name);

/// The poses as the text of a TUM file, camera to world; `read_tum` gives the same poses within a few roundings of double. Throws `Error` if
/// a number is not finite or above 1e37, and for no pose at all, because `read_tum` would refuse them. Where `lost[i]` is set, the comment line
/// "# <seconds> lost" stands in place of pose i.
TILEMESH_HOST std::string tum_text(std::vector<StampedPose> const& poses, std::vector<bool> const& lost = {});

/// Notes on a trajectory, at most eight lines: those of the reader; poses that are not a camera's (EuRoC); stamps that go back in time; stamps that
/// occur twice; gaps above 5 times the median of the forward steps; quaternions far from unit length. Empty if nothing is unusual. Poses are numbered
/// from 1 in the file's order. Cost: one sort of the stamps.
TILEMESH_HOST std::vector<std::string> trajectory_notes(Trajectory const& trajectory);

/// Applies the motion since the first pose to `start`: pose k is start o (first^-1 o pose_k), composed as camera to world, so a step to the
/// camera's right stays a step to its right. Pose 0 is `start`, bit for bit. No error accumulates over k.
TILEMESH_HOST Trajectory relative_to_first(Trajectory trajectory, Pose const& start);

/// The rolling shutter of the camera at pose i of a path: a `Trajectory`, or anything with its [] and size(). The camera moves as from the pose
/// before to the pose after it, and reads its rows in `readout` seconds. A time stamp is that of the row of the picture's centre. Throws
/// `Error` if these time stamps do not rise, or the path has one pose.
template <class Path>
splat::Shutter shutter_at(Path const& path, std::size_t i, double readout, Intrinsics const& lens)
{
    auto const from = path[i > 0 ? i - 1 : i], to = path[i + 1 < path.size() ? i + 1 : i];
    if (!(to.seconds > from.seconds))
        throw Error("the rolling shutter of pose " + std::to_string(i + 1) + " (the time stamps around it do not rise, so nobody knows how fast the "
                    "camera moves); give poses with time stamps, in their order");
    return rolling_shutter(from.pose, to.pose, (to.seconds - from.seconds) / readout, lens, path[i].pose);
}

}}} // namespace tilemesh::scene

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/trajectory_code.hpp>
#endif
