#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <istream>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// The form of a trajectory's file; each line is a pose, camera to world.
enum class TrajectoryFormat {
    tum,    ///< of the TUM RGB-D benchmark: `timestamp tx ty tz qx qy qz qw`, in seconds
    euroc,  ///< of the EuRoC MAV data set: `timestamp, px, py, pz, qw, qx, qy, qz` and further fields, in nanoseconds
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
};

/// 2^24 poses: four days at 48 poses a second, and 2 GB.
inline constexpr std::size_t most_poses = std::size_t{1} << 24;

namespace detail {

/// The eight numbers of a TUM line. `why` says what is wrong with the line, and is empty for a valid line. `advice` says what to do.
struct TumLine {
    std::array<double, 8> fields{};
    std::string why;
    std::string advice = "write timestamp tx ty tz qx qy qz qw, or # before a comment";
};

TILEMESH_HOST TumLine parse_tum_line(std::string_view text);

/// The pose of a line, and what is wrong with the line; `why` is empty for a valid line.
struct PoseLine {
    StampedPose pose{};
    bool far_from_unit = false;
    std::string why, advice;
};

TILEMESH_HOST void set_quaternion(PoseLine& line, double qx, double qy, double qz, double qw);

/// The number of words in a line.
TILEMESH_HOST std::size_t number_of_words(std::string_view text);

/// The form of a line. A line of none of these forms is refused as a TUM line.
TILEMESH_HOST TrajectoryFormat format_of(std::string_view line);

TILEMESH_HOST PoseLine parse_pose(std::string_view text, TrajectoryFormat format, std::size_t number);

/// Reads the lines of a trajectory. Without a format, the first pose tells it.
TILEMESH_HOST Trajectory read_poses(std::istream& stream, std::string const& name, std::size_t most,
                                    TrajectoryFormat const* format);

} // namespace detail

/// Reads a trajectory in the format of the TUM RGB-D benchmark. A line is a pose: `timestamp tx ty tz qx qy qz qw`, in seconds and world
/// units, camera to world, separated by blanks. `#` starts a comment, on its own line or after a pose. Blank lines are skipped. Quaternions
/// of any length except 0 are normalised. Time stamps may be in any order, and the poses keep the file's order; `trajectory_notes` reports
/// unusual time stamps.
///
/// Throws `Error` for any other line and names the line, for a file without a pose, and for more than `most` poses. `name` is the file's
/// name in errors. Cost: 104 bytes a pose, up to three times that while the list grows.
TILEMESH_HOST Trajectory read_tum(std::istream& stream, std::string const& name, std::size_t most = most_poses);

/// Reads a TUM trajectory from a file, as `read_tum` does. Throws `Error` also if the file cannot be read or is not a regular file.
TILEMESH_HOST Trajectory load_tum(std::filesystem::path const& path, std::size_t most = most_poses);

/// Reads a trajectory in any `TrajectoryFormat`; its first pose tells which. A line with seven commas or more is of EuRoC, 12 words are of
/// KITTI, 16 of Replica, all others of TUM; all poses of a file have the form of the first. `#` starts a comment, and blank lines are
/// skipped. All poses take a camera as OpenCV's (x right, y down, z forward) to the world; the poses of EuRoC's own ground truth are those of
/// the IMU, and nothing in the file says how the camera stands on it (`trajectory_notes` says so). A rotation matrix must be orthonormal
/// within 1e-3, and is kept as it is. Throws `Error` and costs as `read_tum`.
TILEMESH_HOST Trajectory read_trajectory(std::istream& stream, std::string const& name, std::size_t most = most_poses);

/// Reads a trajectory from a file, as `read_trajectory` does. Throws `Error` also if the file cannot be read or is not a regular file.
TILEMESH_HOST Trajectory load_trajectory(std::filesystem::path const& path, std::size_t most = most_poses);

/// The poses as the text of a TUM file, camera to world; `read_tum` gives the same poses within a few roundings of double. Throws `Error` if
/// a number is not finite or above 1e37, and for no pose at all, because `read_tum` would refuse them.
TILEMESH_HOST std::string tum_text(std::vector<StampedPose> const& poses);

/// Notes on a trajectory, at most five lines: poses that are not a camera's (EuRoC); stamps that go back in time; stamps that occur twice; gaps
/// above 5 times the median of the forward steps; quaternions far from unit length. Empty if nothing is unusual. Poses are numbered from 1
/// in the file's order. Cost: one sort of the stamps.
TILEMESH_HOST std::vector<std::string> trajectory_notes(Trajectory const& trajectory);

/// Applies the motion since the first pose to `start`: pose k is start o (first^-1 o pose_k), composed as camera to world, so a step to the
/// camera's right stays a step to its right. Pose 0 is `start`, bit for bit. No error accumulates over k.
TILEMESH_HOST Trajectory relative_to_first(Trajectory trajectory, Pose const& start);

}}} // namespace tilemesh::scene

#if !defined(TILEMESH_COMPILED)
#    include <tilemesh/scene/detail/trajectory_code.hpp>
#endif
