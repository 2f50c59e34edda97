#pragma once
#include <algorithm>
#include <cmath>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <tilemesh/number_text.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace scene {
namespace detail {

/// Reads a field. Returns what is wrong with it; NaN and infinite numbers are not wrong, but clear `finite`.
inline std::string read_field(std::string_view word, double& value, std::size_t number, bool& finite)
{
    if (parse_number(word, value)) {
        if (std::fabs(value) <= largest_number) return "";
        if (!std::isfinite(value)) {
            finite = false;
            return "";
        }
    }
    return "field " + std::to_string(number) + " is not a number, or above 1e37";
}

/// The pose of a row that is a matrix of 3 or 4 rows.
inline StampedPose matrix_pose(std::array<double, 16> const& fields, std::uint64_t number)
{
    StampedPose out{static_cast<double>(number), {glm::dmat3{1.0}, {}}};
    Pose& pose = out.pose;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) pose.rotation[row][column] = fields[static_cast<std::size_t>(4 * row + column)];
        pose.position[row] = fields[static_cast<std::size_t>(4 * row + 3)];
    }
    return out;
}

/// The numbers of a line. `why` says what is wrong with the line, and is empty for a valid line. `advice` says what to do.
struct PoseLine {
    std::array<double, 16> fields{};
    bool finite = true; ///< no number is NaN or infinite; if not, the row is left out
    std::string why, advice;
};

/// A line of TUM that blanks separate.
inline PoseLine parse_tum_line(std::string_view text)
{
    PoseLine line;
    line.advice = "write timestamp tx ty tz qx qy qz qw, or # before a comment";
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
        if (count++ >= 8) continue;
        line.why = read_field(word, line.fields[count - 1], count, line.finite);
        if (!line.why.empty()) return line;
    }
    if (count == 12) {
        line.why = "12 fields where 8 are needed; this looks like the poses of KITTI";
        line.advice = "convert it: rows of a 3x4 camera-to-world matrix to timestamp tx ty tz qx qy qz qw";
    } else if (count != 8) {
        line.why = std::to_string(count) + " fields where 8 are needed";
    } else if (line.fields[4] == 0.0 && line.fields[5] == 0.0 && line.fields[6] == 0.0 && line.fields[7] == 0.0) {
        line.why = "its quaternion is zero";
    }
    return line;
}

/// A line of another form, or of TUM with commas.
inline PoseLine parse_pose_line(std::string_view text, TrajectoryFormat format, bool commas)
{
    PoseLine line;
    bool const stamped = format == TrajectoryFormat::tum || format == TrajectoryFormat::euroc;
    std::size_t const needed = stamped ? 8 : format == TrajectoryFormat::kitti ? 12 : 16;
    line.advice = stamped         ? "write timestamp,px,py,pz and the quaternion, as in the first line, or # before a comment"
                  : needed == 12 ? "write the 12 numbers of a 3x4 camera-to-world matrix, or # before a comment"
                                 : "write the 16 numbers of a 4x4 camera-to-world matrix, or # before a comment";
    std::size_t count = 0;
    for (bool more = true; more && count < (stamped ? needed : needed + 1); ++count) {
        std::string_view word;
        if (commas) { // a comma ends each field
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
        line.why = read_field(word, line.fields[count], count + 1, line.finite);
        if (!line.why.empty()) return line;
    }
    auto const& f = line.fields;
    if (count != needed)
        line.why = (count > needed ? "more than " + std::to_string(needed) : std::to_string(count)) + " fields where " + std::to_string(needed) +
                   " are needed, as in the first line";
    else if (stamped && f[4] == 0.0 && f[5] == 0.0 && f[6] == 0.0 && f[7] == 0.0) line.why = "its quaternion is zero";
    else if (needed == 16 && line.finite && !ends_in_0_0_0_1(f)) line.why = "its last four numbers are not 0 0 0 1";
    else if (!stamped && line.finite) line.why = fault_of_rotation(matrix_pose(f, 0).pose.rotation);
    return line;
}

/// The number of words in a line.
inline std::size_t number_of_words(std::string_view text)
{
    std::size_t count = 0;
    while (!take_word(text).empty()) ++count;
    return count;
}

/// What the words of a header say about the columns: "# timestamp tx ty tz qx qy qz qw", or "#timestamp [ns], ..., q_RS_w [], ...".
struct TrajectoryHeader {
    bool there = false;         ///< the line names qw and qx
    bool w_first = false;       ///< qw stands before qx
    std::size_t names = 0, first_q = 0; ///< number of names; the first of the quaternion
    std::optional<double> seconds_per_unit; ///< of the stamps
};
inline TrajectoryHeader header_of(std::string_view line)
{
    TrajectoryHeader header;
    bool x = false, w = false;
    std::string name;
    bool unit = false; // between brackets
    auto const says_unit = [&](char letter) {
        if (letter == 'm' || letter == 'u' || letter == 'n') header.seconds_per_unit = letter == 'm' ? 1e-3 : letter == 'u' ? 1e-6 : 1e-9;
    };
    auto const end_name = [&] {
        if (name.empty()) return;
        bool const first = header.names <= 1;
        if (unit) {
            if (first && (name == "s" || name == "sec")) header.seconds_per_unit = 1.0;
            if (first && name.size() == 2 && name[1] == 's') says_unit(name[0]);
        } else {
            ++header.names;
            if (header.names == 1 && name.size() > 3 && name[name.size() - 3] == '_' && name.back() == 's') says_unit(name[name.size() - 2]);
            if (name.front() == 'q' && (name.back() == 'w' || name.back() == 'x' || name.back() == 'y' || name.back() == 'z') && header.first_q == 0)
                header.first_q = header.names;
            if (name.front() == 'q' && name.back() == 'w') {
                if (!w) header.w_first = !x;
                w = true;
            }
            if (name.front() == 'q' && name.back() == 'x') x = true;
        }
        name.clear();
    };
    for (char const c : line) {
        bool const opens = c == '[' || c == '(', closes = c == ']' || c == ')';
        if (opens || closes || c == ',' || c == '#' || c == ';' || blanks.find(c) != std::string_view::npos) {
            end_name();
            unit = opens || (unit && !closes);
        } else if (name.size() < 40) {
            name += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
        }
    }
    end_name();
    header.there = x && w;
    return header;
}

/// The pose of a row `timestamp px py pz` and a quaternion, x first or w first. `far_from_unit` counts.
inline StampedPose stamped_pose(std::array<double, 8> const& row, bool w_first, double seconds_per_unit, std::uint64_t& far_from_unit)
{
    auto const [stamp, px, py, pz, q0, q1, q2, q3] = row;
    double const qx = w_first ? q1 : q0, qy = w_first ? q2 : q1, qz = w_first ? q3 : q2, qw = w_first ? q0 : q3;
    StampedPose out{stamp * seconds_per_unit, {glm::dmat3{1.0}, {px, py, pz}}};
    out.pose.rotation = glm::transpose(rotation_matrix(qw, qx, qy, qz));
    if (!(std::fabs(std::hypot(std::hypot(qx, qy), std::hypot(qz, qw)) - 1.0) <= 1e-2)) ++far_from_unit;
    return out;
}

/// How far the steps of the path are from their mean in the camera's own axes, from 0 (always the same step) to 1 (steps in all directions),
/// if the quaternions have this order. The angles between the poses say nothing, because they are the same with both orders. But with the wrong
/// order, a camera that goes ahead and turns seems to go in another direction of its own at every step.
inline double restlessness(std::vector<std::array<double, 8>> const& rows, bool w_first)
{
    double squares = 0.0;
    std::uint64_t ignored = 0;
    glm::dvec3 sum{0.0};
    for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
        Pose const here = stamped_pose(rows[i], w_first, 1.0, ignored).pose;
        glm::dvec3 const step{rows[i + 1][1] - rows[i][1], rows[i + 1][2] - rows[i][2], rows[i + 1][3] - rows[i][3]};
        glm::dvec3 const own = here.rotation * step;
        sum += own;
        squares += own.x * own.x + own.y * own.y + own.z * own.z;
    }
    if (!(squares > 0.0)) return 1.0;
    return 1.0 - (sum.x * sum.x + sum.y * sum.y + sum.z * sum.z) / (static_cast<double>(rows.size() - 1) * squares);
}

/// Reads the lines of a trajectory. `only_tum`: a file of TUM that blanks separate, in seconds. `format` empty: the file tells it.
inline Trajectory read_poses(std::istream& stream, std::string const& name, std::size_t most, bool only_tum, std::optional<TrajectoryFormat> format)
{
    Trajectory trajectory;
    std::vector<std::array<double, 8>> rows; // of TUM or EuRoC, until the whole file tells which
    TrajectoryHeader header;
    bool known = false, commas = false, more = false, whole = true; // of the first row; whole: all stamps
    std::uint64_t number = 0;
    std::string named;
    LineReader lines(stream, name);
    while (lines.next()) {
        std::string_view const all = lines.text(), text = all.substr(0, all.find('#'));
        bool const blank = text.find_first_not_of(blanks) == std::string_view::npos;
        if (!only_tum && !known) {
            // A header is a comment, or a line of names without a number.
            if (auto const found = header_of(blank ? all : text); found.there) {
                header = found;
                continue;
            }
        }
        if (blank) continue;
        if (!known) {
            known = true;
            auto const commas_there = std::count(text.begin(), text.end(), ',');
            std::size_t const words = number_of_words(text);
            commas = !only_tum && commas_there >= 7;
            more = commas ? std::count(text.begin(), text.end(), ',') >= 8 && !text.substr(text.rfind(',') + 1).empty() : words == 17;
            if (only_tum) trajectory.format = TrajectoryFormat::tum;
            else if (format) trajectory.format = *format;
            else if (commas || more) trajectory.format = TrajectoryFormat::euroc;
            else trajectory.format = words == 12 ? TrajectoryFormat::kitti : words == 16 ? TrajectoryFormat::replica : TrajectoryFormat::tum;
        }
        bool const plain_tum = trajectory.format == TrajectoryFormat::tum && !commas;
        PoseLine const line = plain_tum ? parse_tum_line(text) : parse_pose_line(text, trajectory.format, commas);
        if (!line.why.empty()) throw Error(lines.place() + " is not a pose (" + line.why + "); " + line.advice);
        ++number;
        if (!line.finite) {
            if (++trajectory.left_out <= 5) named.append(named.empty() ? "" : ", ").append(lines.place().substr(name.size() + 1));
            continue;
        }
        if (trajectory.size() + rows.size() == most) throw Error(name + " is too long (more than " + std::to_string(most) + " poses); split it");
        if (!trajectory.has_stamps()) {
            trajectory.push_back(matrix_pose(line.fields, number - 1));
            continue;
        }
        rows.emplace_back();
        std::copy_n(line.fields.begin(), 8, rows.back().begin());
        std::string_view rest = text;
        std::string_view const stamp = take_word(rest);
        whole = whole && stamp.substr(0, stamp.find(',')).find_first_of(".eE") == std::string_view::npos;
    }
    if (trajectory.left_out != 0)
        trajectory.reader_notes.push_back("rows left out because a number is not finite: " + std::to_string(trajectory.left_out) + " (" + named +
                                          (trajectory.left_out > 5 ? " and more)" : ")"));
    if (trajectory.empty() && rows.empty())
        throw Error(name + " holds no pose (every line is blank, a comment, or has a number that is not finite); name a " +
                    (only_tum ? "TUM " : "") + "trajectory file");
    if (rows.empty()) return trajectory;

    std::vector<double> stamps;
    for (auto const& row : rows) stamps.push_back(row[0]);
    double const found = seconds_per_unit(std::move(stamps));
    bool const huge = found == 1e-9;
    std::string reason = "as was asked for";
    if (!only_tum && !format) {
        if (header.there && header.names >= 8 && header.first_q != 5)
            throw Error(name + " has other columns than a stamp, a position and a quaternion (its header has the quaternion from column " +
                        std::to_string(header.first_q) + ", not 5); bring the columns into the order timestamp tx ty tz qx qy qz qw");
        bool w_first = false, decided = true;
        if (header.there) {
            w_first = header.w_first;
            reason = "as its header says";
        } else if (more || (commas && whole && huge)) {
            w_first = true;
            reason = more ? "because it has more than eight columns" : "because its stamps are whole nanoseconds";
        } else if (!commas && !(whole && huge)) {
            reason = "because blanks separate it and its stamps are not whole nanoseconds";
        } else {
            double const last = rows.size() >= 10 ? restlessness(rows, false) : 1.0, first = rows.size() >= 10 ? restlessness(rows, true) : 1.0;
            w_first = first < last;
            // A steady camera differs from its mean velocity by less than a third of it; a factor of 4 is more than ten steps make by chance.
            decided = std::fmin(first, last) <= 0.1 && std::fmax(first, last) >= 4.0 * std::fmin(first, last);
            reason = "because the camera moves steadily only so";
        }
        if (!decided)
            throw Error(name + " does not say whether the w of its quaternions is last, as in TUM, or first, as in EuRoC (it has no header, "
                        "and stamps "
                               "and motion fit both); add a header, or name the form with --trajectory-format tum or euroc");
        trajectory.format = w_first ? TrajectoryFormat::euroc : TrajectoryFormat::tum;
    }
    bool const euroc = trajectory.format == TrajectoryFormat::euroc;
    double const unit = only_tum ? 1.0 : header.seconds_per_unit.value_or(euroc && format && whole ? 1e-9 : found);
    if (!only_tum && (euroc ? !commas || unit != 1e-9 : commas || unit != 1.0))
        trajectory.reader_notes.push_back(std::string("read as timestamp, position, ") + (euroc ? "qw qx qy qz" : "qx qy qz qw") + ", " +
                                          reason + ", in " + unit_name(unit));
    trajectory.reserve(rows.size());
    for (auto const& row : rows) trajectory.push_back(stamped_pose(row, euroc, unit, trajectory.far_from_unit));
    return trajectory;
}

TILEMESH_HOST double seconds_per_unit(std::vector<double> stamps)
{
    std::sort(stamps.begin(), stamps.end());
    double largest = 0.0, step = 0.0;
    bool whole = true;
    std::vector<double> steps;
    for (std::size_t i = 0; i < stamps.size(); ++i) {
        largest = std::fmax(largest, std::fabs(stamps[i]));
        whole = whole && stamps[i] == std::floor(stamps[i]);
        if (i > 0 && stamps[i] > stamps[i - 1]) steps.push_back(stamps[i] - stamps[i - 1]);
    }
    if (!steps.empty()) {
        auto const middle = steps.begin() + static_cast<std::ptrdiff_t>((steps.size() - 1) / 2);
        std::nth_element(steps.begin(), middle, steps.end());
        step = *middle;
    }
    constexpr double year_2000 = 946684800.0, year_2100 = 4102444800.0; // seconds since 1970
    for (double const unit : {1.0, 1e-3, 1e-6, 1e-9})
        if (largest * unit >= year_2000 && largest * unit <= year_2100 && step * unit < 1e3) return unit;
    if (whole && step > 0.0) return step < 1e3 ? 1.0 : step < 1e6 ? 1e-6 : 1e-9;
    return largest < 1e11 ? 1.0 : largest < 1e14 ? 1e-3 : largest < 1e17 ? 1e-6 : 1e-9;
}

TILEMESH_HOST std::string unit_name(double seconds_per_unit)
{
    return seconds_per_unit == 1.0    ? "seconds"
           : seconds_per_unit == 1e-3 ? "milliseconds"
           : seconds_per_unit == 1e-6 ? "microseconds"
                                      : "nanoseconds";
}

} // namespace detail

TILEMESH_HOST Trajectory read_tum(std::istream& stream, std::string const& name, std::size_t most)
{
    return detail::read_poses(stream, name, most, true, {});
}

TILEMESH_HOST Trajectory load_tum(std::filesystem::path const& path, std::size_t most)
{
    // The number of poses is bounded, but the number of comments is not.
    auto stream = detail::open_file(path, std::numeric_limits<std::uint64_t>::max(), "a TUM trajectory file");
    return read_tum(stream, detail::shown_path(path), most);
}

TILEMESH_HOST Trajectory read_trajectory(std::istream& stream, std::string const& name, std::size_t most, std::optional<TrajectoryFormat> format)
{
    return detail::read_poses(stream, name, most, false, format);
}

TILEMESH_HOST Trajectory load_trajectory(std::filesystem::path const& path, std::size_t most, std::optional<TrajectoryFormat> format)
{
    auto stream = detail::open_file(path, std::numeric_limits<std::uint64_t>::max(), "a trajectory file");
    return read_trajectory(stream, detail::shown_path(path), most, format);
}

TILEMESH_HOST Trajectory relative_to_origin(Trajectory trajectory, std::array<double, 3> const& origin)
{
    for (auto& [seconds, pose] : trajectory) pose.position -= glm::dvec3{origin[0], origin[1], origin[2]};
    return trajectory;
}

TILEMESH_HOST std::optional<TrajectoryFormat> trajectory_format(std::string_view name)
{
    if (name == "tum") return TrajectoryFormat::tum;
    if (name == "euroc") return TrajectoryFormat::euroc;
    if (name == "kitti") return TrajectoryFormat::kitti;
    if (name == "replica") return TrajectoryFormat::replica;
    return {};
}

TILEMESH_HOST std::string tum_text(std::vector<StampedPose> const& poses, std::vector<bool> const& lost)
{
    if (poses.empty()) throw Error("an empty trajectory cannot be written (no reader accepts it); write at least one pose");
    std::string text = "# timestamp tx ty tz qx qy qz qw\n";
    for (std::size_t i = 0; i < poses.size(); ++i) {
        auto const& [seconds, pose] = poses[i];
        if (i < lost.size() && lost[i]) {
            text += "# " + number_text(seconds) + " lost\n";
            continue;
        }
        auto const q = quaternion_of(glm::transpose(pose.rotation));
        for (double const value : {seconds, pose.position.x, pose.position.y, pose.position.z, q[1], q[2], q[3], q[0]}) {
            if (!(std::fabs(value) <= detail::largest_number))
                throw Error("a trajectory cannot be written (the pose at " + number_text(seconds) +
                            " s has a number that is not finite, or above 1e37); write finite poses");
            text += number_text(value);
            text += ' ';
        }
        text.back() = '\n';
    }
    return text;
}

TILEMESH_HOST std::vector<std::string> trajectory_notes(Trajectory const& trajectory)
{
    std::vector<std::string> notes = trajectory.reader_notes;
    if (trajectory.format == TrajectoryFormat::euroc)
        notes.push_back("poses of EuRoC are taken as a camera's; the data set's own ground truth has the poses of the IMU");
    auto const seconds = [&](std::size_t i) { return trajectory[i].seconds; };
    auto const at = [&](std::size_t i) { return "pose " + std::to_string(i + 1) + " at " + number_text(seconds(i)); };

    std::size_t back = 0, first_back = 0;
    std::vector<double> steps;
    for (std::size_t i = 1; i < trajectory.size(); ++i) {
        double const step = seconds(i) - seconds(i - 1);
        if (step < 0.0 && back++ == 0) first_back = i;
        if (step > 0.0) steps.push_back(step);
    }
    if (back > 0)
        notes.push_back("stamps that go back in time: " + std::to_string(back) + ", the first is " + at(first_back) +
                        " after " + number_text(seconds(first_back - 1)));

    std::vector<double> sorted;
    for (auto const& stamped : trajectory) sorted.push_back(stamped.seconds);
    std::sort(sorted.begin(), sorted.end());
    auto const distinct = std::unique(sorted.begin(), sorted.end());
    if (distinct != sorted.end()) notes.push_back("stamps that an earlier pose has too: " + std::to_string(sorted.end() - distinct));

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
            notes.push_back("gaps above 5 times the median step of " + number_text(median) + " s: " + std::to_string(gaps) + ", the longest lasts " +
                            number_text(seconds(longest) - seconds(longest - 1)) + " s, before " + at(longest));
    }
    if (trajectory.far_from_unit > 0)
        notes.push_back("quaternions normalised whose length was off 1 by more than 0.01: " + std::to_string(trajectory.far_from_unit));
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
