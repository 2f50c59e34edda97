#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <istream>
#include <limits>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {
namespace detail {

TILEMESH_HOST TumLine parse_tum_line(std::string_view text)
{
    TumLine line;
    // EuRoC's ground truth has at least eight fields, so at least seven commas.
    auto const commas = std::count(text.begin(), text.end(), ',');
    if (commas >= 7) {
        line.why = "TUM files are separated by blanks; this looks like the CSV of EuRoC";
        line.advice = "convert it: nanoseconds to seconds, and px py pz qw qx qy qz to tx ty tz qx qy qz qw";
        return line;
    }
    if (commas > 0) {
        line.why = "it has a comma; TUM files are separated by blanks, and their decimals by a point";
        return line;
    }

    std::size_t count = 0;
    for (std::string_view word = take_word(text); !word.empty(); word = take_word(text)) {
        // Further fields are counted, not read.
        if (count++ >= line.fields.size()) continue;
        double& value = line.fields[count - 1];
        if (!parse_number(word, value) || !(std::fabs(value) <= largest_number)) {
            line.why = "field " + std::to_string(count) + " is not a finite number, or above 1e37";
            return line;
        }
    }
    if (count == 12) {
        line.why = "12 fields where 8 are needed; this looks like the poses of KITTI";
        line.advice = "convert it: rows of a 3x4 camera-to-world matrix to timestamp tx ty tz qx qy qz qw";
    } else if (count != line.fields.size()) {
        line.why = std::to_string(count) + " fields where 8 are needed";
    } else if (line.fields[4] == 0.0 && line.fields[5] == 0.0 && line.fields[6] == 0.0 && line.fields[7] == 0.0) {
        line.why = "its quaternion is zero";
    }
    return line;
}

TILEMESH_HOST void set_quaternion(PoseLine& line, double qx, double qy, double qz, double qw)
{
    line.pose.pose.rotation = glm::transpose(rotation_matrix(qw, qx, qy, qz));
    line.far_from_unit = !(std::fabs(std::hypot(std::hypot(qx, qy), std::hypot(qz, qw)) - 1.0) <= 1e-2);
}

TILEMESH_HOST std::size_t number_of_words(std::string_view text)
{
    std::size_t count = 0;
    while (!take_word(text).empty()) ++count;
    return count;
}

TILEMESH_HOST TrajectoryFormat format_of(std::string_view line)
{
    if (std::count(line.begin(), line.end(), ',') >= 7) return TrajectoryFormat::euroc;
    std::size_t const words = number_of_words(line);
    return words == 12 ? TrajectoryFormat::kitti : words == 16 ? TrajectoryFormat::replica : TrajectoryFormat::tum;
}

TILEMESH_HOST PoseLine parse_pose(std::string_view text, TrajectoryFormat format, std::size_t number)
{
    PoseLine line;
    if (format == TrajectoryFormat::tum) {
        TumLine const tum = parse_tum_line(text);
        line.why = tum.why;
        line.advice = tum.advice;
        auto const [seconds, tx, ty, tz, qx, qy, qz, qw] = tum.fields;
        line.pose = {seconds, {glm::dmat3{1.0}, {tx, ty, tz}}};
        if (line.why.empty()) set_quaternion(line, qx, qy, qz, qw);
        return line;
    }
    bool const euroc = format == TrajectoryFormat::euroc;
    std::size_t const needed = euroc ? 8 : format == TrajectoryFormat::kitti ? 12 : 16;
    line.advice = euroc   ? "write timestamp,px,py,pz,qw,qx,qy,qz, nanoseconds first, or # before a comment"
                  : needed == 12 ? "write the 12 numbers of a 3x4 camera-to-world matrix, or # before a comment"
                          : "write the 16 numbers of a 4x4 camera-to-world matrix, or # before a comment";
    std::array<double, 16> fields{};
    std::size_t count = 0;
    for (bool more = true; more && count < (euroc ? needed : needed + 1); ++count) {
        std::string_view word;
        if (euroc) { // a comma ends each field
            std::size_t const end = std::min(text.find(','), text.size());
            std::string_view field = text.substr(0, end);
            word = take_word(field);
            if (!take_word(field).empty()) word = {};
            text.remove_prefix(std::min(end + 1, text.size()));
            more = !text.empty();
        } else if (word = take_word(text); word.empty()) {
            break;
        }
        if (count == needed) continue; // one too many
        if (!parse_number(word, fields[count]) || !(std::fabs(fields[count]) <= largest_number)) {
            line.why = "field " + std::to_string(count + 1) + " is not a finite number, or above 1e37";
            return line;
        }
    }
    if (count != needed) {
        line.why = (count > needed ? "more than " + std::to_string(needed) : std::to_string(count)) + " fields where " + std::to_string(needed) +
                   " are needed, as in the first line";
        return line;
    }
    if (euroc) {
        auto const* const f = fields.data();
        line.pose = {f[0] * 1e-9, {glm::dmat3{1.0}, {f[1], f[2], f[3]}}};
        if (f[4] == 0.0 && f[5] == 0.0 && f[6] == 0.0 && f[7] == 0.0) line.why = "its quaternion is zero";
        set_quaternion(line, f[5], f[6], f[7], f[4]);
        return line;
    }
    if (needed == 16 && !ends_in_0_0_0_1(fields))
        line.why = "its last four numbers are not 0 0 0 1";
    Pose& pose = line.pose.pose;
    line.pose.seconds = static_cast<double>(number);
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) pose.rotation[row][column] = fields[static_cast<std::size_t>(4 * row + column)];
        pose.position[row] = fields[static_cast<std::size_t>(4 * row + 3)];
    }
    if (line.why.empty()) line.why = fault_of_rotation(pose.rotation);
    return line;
}

TILEMESH_HOST Trajectory read_poses(std::istream& stream, std::string const& name, std::size_t most, TrajectoryFormat const* format)
{
    Trajectory trajectory;
    LineReader lines(stream, name);
    while (lines.next()) {
        std::string_view const text = lines.text().substr(0, lines.text().find('#'));
        if (text.find_first_not_of(blanks) == std::string_view::npos) continue;
        if (trajectory.empty()) trajectory.format = format != nullptr ? *format : format_of(text);
        PoseLine const line = parse_pose(text, trajectory.format, trajectory.size());
        if (!line.why.empty()) throw Error(lines.place() + " is not a pose (" + line.why + "); " + line.advice);
        if (trajectory.size() == most)
            throw Error(name + " is too long (more than " + std::to_string(most) + " poses); split it");
        trajectory.push_back(line.pose);
        if (line.far_from_unit) ++trajectory.far_from_unit;
    }
    if (trajectory.empty())
        throw Error(name + " holds no pose (every line is blank or a comment); name a " + (format != nullptr ? "TUM " : "") + "trajectory file");
    return trajectory;
}

} // namespace detail

TILEMESH_HOST Trajectory read_tum(std::istream& stream, std::string const& name, std::size_t most)
{
    constexpr auto tum = TrajectoryFormat::tum;
    return detail::read_poses(stream, name, most, &tum);
}

TILEMESH_HOST Trajectory load_tum(std::filesystem::path const& path, std::size_t most)
{
    // The number of poses is bounded, but the number of comments is not.
    auto stream = detail::open_file(path, std::numeric_limits<std::uint64_t>::max(), "a TUM trajectory file");
    return read_tum(stream, detail::shown_path(path), most);
}

TILEMESH_HOST Trajectory read_trajectory(std::istream& stream, std::string const& name, std::size_t most)
{
    return detail::read_poses(stream, name, most, nullptr);
}

TILEMESH_HOST Trajectory load_trajectory(std::filesystem::path const& path, std::size_t most)
{
    auto stream = detail::open_file(path, std::numeric_limits<std::uint64_t>::max(), "a trajectory file");
    return read_trajectory(stream, detail::shown_path(path), most);
}

TILEMESH_HOST std::string tum_text(std::vector<StampedPose> const& poses)
{
    if (poses.empty()) throw Error("an empty trajectory cannot be written (no reader accepts it); write at least one pose");
    std::string text = "# timestamp tx ty tz qx qy qz qw\n";
    for (auto const& [seconds, pose] : poses) {
        auto const q = quaternion_of(glm::transpose(pose.rotation));
        for (double const value : {seconds, pose.position.x, pose.position.y, pose.position.z, q[1], q[2], q[3], q[0]}) {
            if (!(std::fabs(value) <= detail::largest_number))
                throw Error("a trajectory cannot be written (the pose at " + detail::text_of(seconds) + " s has a number that is not finite, or above 1e37); write finite poses");
            text += detail::text_of(value);
            text += ' ';
        }
        text.back() = '\n';
    }
    return text;
}

TILEMESH_HOST std::vector<std::string> trajectory_notes(Trajectory const& trajectory)
{
    std::vector<std::string> notes;
    if (trajectory.format == TrajectoryFormat::euroc)
        notes.push_back("poses of EuRoC are taken as a camera's; the data set's own ground truth has the poses of the IMU");
    auto const seconds = [&](std::size_t i) { return trajectory[i].seconds; };
    auto const at = [&](std::size_t i) { return "pose " + std::to_string(i + 1) + " at " + detail::text_of(seconds(i)); };

    std::size_t back = 0, first_back = 0;
    std::vector<double> steps;
    for (std::size_t i = 1; i < trajectory.size(); ++i) {
        double const step = seconds(i) - seconds(i - 1);
        if (step < 0.0 && back++ == 0) first_back = i;
        if (step > 0.0) steps.push_back(step);
    }
    if (back > 0)
        notes.push_back("stamps that go back in time: " + std::to_string(back) + ", the first is " + at(first_back) +
                        " after " + detail::text_of(seconds(first_back - 1)));

    std::vector<double> sorted;
    for (auto const& stamped : trajectory) sorted.push_back(stamped.seconds);
    std::sort(sorted.begin(), sorted.end());
    auto const distinct = std::unique(sorted.begin(), sorted.end());
    if (distinct != sorted.end())
        notes.push_back("stamps that an earlier pose has too: " + std::to_string(sorted.end() - distinct));

    if (!steps.empty()) {
        auto const middle = steps.begin() + static_cast<std::ptrdiff_t>((steps.size() - 1) / 2);
        std::nth_element(steps.begin(), middle, steps.end());
        double const median = *middle;
        std::size_t gaps = 0, longest = 0;
        for (std::size_t i = 1; i < trajectory.size(); ++i) {
            double const step = seconds(i) - seconds(i - 1);
            if (!(step > 5.0 * median)) continue;
            if (gaps++ == 0 || step > seconds(longest) - seconds(longest - 1)) longest = i;
        }
        if (gaps > 0)
            notes.push_back("gaps above 5 times the median step of " + detail::text_of(median) +
                            " s: " + std::to_string(gaps) + ", the longest lasts " +
                            detail::text_of(seconds(longest) - seconds(longest - 1)) + " s, before " + at(longest));
    }
    if (trajectory.far_from_unit > 0)
        notes.push_back("quaternions normalised whose length was off 1 by more than 0.01: " +
                        std::to_string(trajectory.far_from_unit));
    return notes;
}

TILEMESH_HOST Trajectory relative_to_first(Trajectory trajectory, Pose const& start)
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

}}} // namespace tilemesh::scene
