#pragma once
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <glm/matrix.hpp>
#include <string>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/pose.hpp>
#include <vector>

namespace tilemesh::scene {

/// A pose and when it was held.
struct StampedPose {
    double seconds;
    Pose pose;
};

/// Poses in the order of their file; never empty when it comes from `load_tum`.
using Trajectory = std::vector<StampedPose>;

namespace detail {

/// The eight numbers of a TUM line; `why` says what is wrong with it and is empty where nothing is.
struct TumLine {
    std::array<double, 8> fields{};
    std::string why;
};

inline TumLine parse_tum_line(std::string_view text)
{
    constexpr std::string_view blanks = " \t\r\v\f";
    TumLine line;
    std::size_t count = 0;
    for (;;) {
        std::size_t const begin = text.find_first_not_of(blanks);
        if (begin == std::string_view::npos) break;
        text.remove_prefix(begin);
        std::string_view word = text.substr(0, text.find_first_of(blanks));
        text.remove_prefix(word.size());

        // A ninth field is counted, not read. `from_chars` takes no plus sign; some writers put
        // one.
        if (count++ >= line.fields.size()) continue;
        if (word.front() == '+') word.remove_prefix(1);
        double& value = line.fields[count - 1];
        auto const [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(value)) {
            line.why = "field " + std::to_string(count) + " is not a finite number";
            return line;
        }
    }
    if (count != line.fields.size())
        line.why = std::to_string(count) + " fields where 8 are needed";
    else if (line.fields[4] == 0.0 && line.fields[5] == 0.0 && line.fields[6] == 0.0 &&
             line.fields[7] == 0.0)
        line.why = "its quaternion is zero";
    return line;
}

} // namespace detail

/// Reads a trajectory in the format of the TUM RGB-D benchmark: a line a pose, `timestamp tx ty tz
/// qx qy qz qw`, seconds and world units, camera to world; `#` starts a comment line, blank lines
/// are skipped. Quaternions of any length but zero are normalised; timestamps may come in any order
/// and are kept.
///
/// Throws `Error` that names the first line that is none of these, and where no pose is found or
/// the file cannot be read.
inline Trajectory load_tum(std::filesystem::path const& path)
{
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored))
        throw Error(path.string() +
                    " cannot be read (it is a directory); name a TUM trajectory file");
    std::ifstream stream(path, std::ios::binary);
    if (!stream)
        throw Error(path.string() +
                    " cannot be opened (no such file, or no permission); check the path");

    Trajectory trajectory;
    std::string text;
    for (std::uint64_t number = 1; std::getline(stream, text); ++number) {
        std::size_t const begin = text.find_first_not_of(" \t\r\v\f");
        if (begin == std::string::npos || text[begin] == '#') continue;
        detail::TumLine const line = detail::parse_tum_line(text);
        if (!line.why.empty())
            throw Error(path.string() + " line " + std::to_string(number) + " is not a pose (" +
                        line.why +
                        "); write timestamp tx ty tz qx qy qz qw, or # before a comment");
        auto const& [seconds, tx, ty, tz, qx, qy, qz, qw] = line.fields;
        Pose const pose{glm::transpose(rotation_matrix(qw, qx, qy, qz)), {tx, ty, tz}};
        trajectory.push_back({seconds, pose});
    }
    if (stream.bad())
        throw Error(path.string() + " cannot be read to its end (the system reports a read error); "
                                    "check the disk or copy the file");
    if (trajectory.empty())
        throw Error(
            path.string() +
            " holds no pose (every line is blank or a comment); name a TUM trajectory file");
    return trajectory;
}

/// The motion since the first pose, carried out from `start`: pose k is start o (first^-1 o
/// pose_k), composed as camera to world, so a step to the camera's right stays one. Pose 0 is
/// `start` itself, bit for bit; nothing accumulates over k.
inline Trajectory relative_to_first(Trajectory trajectory, Pose const& start)
{
    if (trajectory.empty()) return trajectory;
    Pose const first = trajectory.front().pose;
    glm::dmat3 const first_to_world = glm::transpose(first.rotation);
    glm::dmat3 const start_to_world = glm::transpose(start.rotation);
    for (auto& [seconds, pose] : trajectory) {
        glm::dvec3 const step_camera = first.rotation * (pose.position - first.position);
        pose.position = start.position + start_to_world * step_camera;
        pose.rotation = pose.rotation * first_to_world * start.rotation;
    }
    trajectory.front().pose = start;
    return trajectory;
}

} // namespace tilemesh::scene
