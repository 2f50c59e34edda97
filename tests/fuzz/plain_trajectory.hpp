#pragma once
#include "plain_cameras.hpp"

namespace plain {

struct Pose {
    double seconds;
    std::array<double, 3> position;
    Matrix rotation; ///< world to camera
};

/// A field of a trajectory: a number from -1e37 to 1e37, or NaN or infinite, which is no fault of the line.
inline std::optional<double> pose_number(std::string const& word)
{
    if (auto const value = moderate(word)) return value;
    auto const found = number(word);
    if (found && !found->lost && found->value - found->value != 0.0) return found->value;
    return {};
}
inline bool all_finite(double const* values, std::size_t n)
{
    return std::all_of(values, values + n, [](double v) { return v - v == 0.0; });
}

/// The first eight words as numbers.
inline std::optional<std::array<double, 8>> word_fields(std::vector<std::string> const& w)
{
    std::array<double, 8> v{};
    for (std::size_t i = 0; i < 8; ++i) {
        auto const value = i < w.size() ? pose_number(w[i]) : std::nullopt;
        if (!value) return {};
        v[i] = *value;
    }
    return v;
}
inline bool is_zero_quaternion(std::array<double, 8> const& v)
{
    return v[4] == 0.0 && v[5] == 0.0 && v[6] == 0.0 && v[7] == 0.0;
}

/// The eight numbers of a line with commas, which may have more fields.
inline std::optional<std::array<double, 8>> comma_fields(std::string const& line)
{
    std::array<double, 8> v{};
    std::size_t begin = 0;
    for (double& value : v) {
        if (begin > line.size()) return {};
        std::size_t const end = std::min(line.find(',', begin), line.size());
        auto const w = words(line.substr(begin, end - begin));
        if (w.size() != 1 || !pose_number(w[0])) return {};
        value = *pose_number(w[0]);
        begin = end + 1;
    }
    return v;
}

/// A line that is the first rows of a matrix, camera to world; `close` as for `usable`. Sets `left_out` for a row that is not finite.
inline std::optional<Pose> matrix_pose(std::vector<std::string> const& w, bool& close, bool& left_out)
{
    std::array<double, 16> m{};
    for (std::size_t i = 0; i < w.size(); ++i) {
        if (!pose_number(w[i])) return {};
        m[i] = *pose_number(w[i]);
    }
    left_out = !all_finite(m.data(), w.size());
    if (left_out) return {};
    Camera c{"", "", "", 1, 1, 1, 1, 0, 0, 1, {}, {}};
    Pose pose{};
    for (unsigned row = 0; row < 3; ++row) {
        pose.position[row] = m[4 * row + 3];
        for (unsigned column = 0; column < 3; ++column) c.rotation[column][row] = pose.rotation[column][row] = m[4 * row + column];
    }
    double const off = std::fabs(m[12]) + std::fabs(m[13]) + std::fabs(m[14]) + std::fabs(m[15] - 1);
    close = close || (w.size() == 16 && std::fabs(off - 1e-6) < 1e-12);
    if ((w.size() == 16 && off > 1e-6) || !usable(c, close)) return {};
    return pose;
}

inline std::optional<std::vector<Pose>> tum(std::string const& text, std::size_t most)
{
    std::vector<Pose> poses;
    for (auto const& line : lines(without_mark(text))) {
        std::string const before = line.substr(0, line.find('#'));
        auto const w = words(before);
        if (w.empty()) continue;
        auto const v = word_fields(w);
        if (before.find(',') != before.npos || w.size() != 8 || !v || is_zero_quaternion(*v)) return {};
        if (!all_finite(v->data(), 8)) continue;
        if (poses.size() == most) return {};
        auto const& [seconds, px, py, pz, qx, qy, qz, qw] = *v;
        auto const rotation = rotation_of(qw, -qx, -qy, -qz); // the conjugate: world to camera
        if (!rotation) return {};
        poses.push_back({seconds, {px, py, pz}, *rotation});
    }
    if (poses.empty()) return {};
    return poses;
}

/// What a line of names says about the columns.
struct PlainHeader {
    bool there = false, w_first = false;
    double seconds_per_unit = 0.0; ///< 0: not said
    std::size_t names = 0, first_q = 0;
};
inline PlainHeader plain_header(std::string const& line)
{
    std::vector<std::string> names;
    PlainHeader out;
    std::string word;
    bool in_unit = false;
    for (char c : line + " ") {
        if (std::string("[](),#; \t\r\v\f").find(c) == std::string::npos) {
            if (word.size() < 40) word += c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
            continue;
        }
        if (!word.empty() && !in_unit) names.push_back(word);
        std::string const end = word.size() > 3 && !in_unit ? word.substr(word.size() - 3) : "";
        using Unit = std::pair<char const*, double>;
        for (auto const& [unit, seconds] : {Unit{"ms", 1e-3}, Unit{"us", 1e-6}, Unit{"ns", 1e-9}, Unit{"s", 1.0}, Unit{"sec", 1.0}})
            if (names.size() <= 1 && (in_unit ? word == unit : end == std::string("_") + unit)) out.seconds_per_unit = seconds;
        word.clear();
        if (c == '[' || c == '(') in_unit = true;
        if (c == ']' || c == ')') in_unit = false;
    }
    std::size_t first_w = 0, first_x = 0;
    for (std::size_t i = names.size(); i-- > 0;) {
        auto const& name = names[i];
        if (name[0] != 'q') continue;
        if (std::string("wxyz").find(name[name.size() - 1]) != std::string::npos) out.first_q = i + 1;
        if (name[name.size() - 1] == 'w') first_w = i + 1;
        if (name[name.size() - 1] == 'x') first_x = i + 1;
    }
    out.names = names.size();
    out.there = first_w != 0 && first_x != 0;
    out.w_first = first_w < first_x;
    return out;
}

/// The seconds of a unit of stamps: what makes a date of this century, else what makes a step of less than a second, else by size.
inline double plain_unit(std::vector<std::array<double, 8>> const& rows)
{
    std::vector<double> stamps, steps;
    for (auto const& row : rows) stamps.push_back(row[0]);
    std::sort(stamps.begin(), stamps.end());
    double const largest = std::max(std::fabs(stamps.front()), std::fabs(stamps.back()));
    bool const whole = std::all_of(stamps.begin(), stamps.end(), [](double s) { return std::fmod(s, 1.0) == 0.0; });
    for (std::size_t i = 1; i < stamps.size(); ++i)
        if (stamps[i] != stamps[i - 1]) steps.push_back(stamps[i] - stamps[i - 1]);
    std::sort(steps.begin(), steps.end());
    double const step = steps.empty() ? 0.0 : steps[(steps.size() - 1) / 2];
    for (double const unit : {1.0, 1e-3, 1e-6, 1e-9})
        if (largest * unit >= 946684800.0 && largest * unit <= 4102444800.0 && step * unit < 1000.0) return unit;
    if (whole && !steps.empty()) return step >= 1e6 ? 1e-9 : step >= 1e3 ? 1e-6 : 1.0;
    return largest >= 1e17 ? 1e-9 : largest >= 1e14 ? 1e-6 : largest >= 1e11 ? 1e-3 : 1.0;
}

/// A trajectory in the form that its header, columns and stamps say: "tum", "euroc", "kitti" or "replica". Sets `close` if a value is so near
/// to a limit that rounding decides, and for a file whose form only its motion can tell.
struct Trajectory {
    std::string form;
    std::vector<Pose> poses;
};
inline std::optional<Trajectory> any_trajectory(std::string const& text, std::size_t most, bool& close)
{
    Trajectory all;
    PlainHeader header;
    std::vector<std::array<double, 8>> rows;
    bool commas = false, more = false, whole = true;
    std::size_t number = 0;
    for (auto const& line : lines(without_mark(text))) {
        std::string const before = line.substr(0, line.find('#'));
        auto const w = words(before);
        if (all.form.empty()) {
            auto const found = plain_header(w.empty() ? line : before);
            if (found.there) {
                header = found;
                continue;
            }
        }
        if (w.empty()) continue;
        if (all.form.empty()) {
            auto const count = std::count(before.begin(), before.end(), ',');
            commas = count >= 7;
            more = commas ? count >= 8 && before[before.size() - 1] != ',' : w.size() == 17;
            all.form = commas || more ? "stamped" : w.size() == 12 ? "kitti" : w.size() == 16 ? "replica" : "stamped";
        }
        ++number;
        if (all.form != "stamped") {
            if (w.size() != (all.form == "kitti" ? 12u : 16u)) return {};
            bool left_out = false;
            auto pose = matrix_pose(w, close, left_out);
            if (left_out) continue;
            if (!pose || all.poses.size() == most) return {};
            pose->seconds = static_cast<double>(number - 1);
            all.poses.push_back(*pose);
            continue;
        }
        std::optional<std::array<double, 8>> v;
        if (commas) v = comma_fields(before);
        else if (more || (w.size() == 8 && before.find(',') == before.npos)) v = word_fields(w);
        if (!v || is_zero_quaternion(*v)) return {};
        if (!all_finite(v->data(), 8)) continue;
        if (rows.size() == most) return {};
        rows.push_back(*v);
        std::string const stamp = w[0].substr(0, w[0].find(','));
        whole = whole && stamp.find_first_of(".eE") == stamp.npos;
    }
    if (all.form != "stamped") return all.poses.empty() ? std::nullopt : std::optional(all);
    if (rows.empty()) return {};
    double const found = plain_unit(rows);
    bool const huge = found == 1e-9;
    if (header.there && header.names >= 8 && header.first_q != 5) return {};
    if (header.there) all.form = header.w_first ? "euroc" : "tum";
    else if (more || (commas && whole && huge)) all.form = "euroc";
    else if (!commas && !(whole && huge)) all.form = "tum";
    else {
        close = close || rows.size() >= 10;
        return {};
    }
    double const unit = header.seconds_per_unit != 0.0 ? header.seconds_per_unit : found;
    for (auto const& v : rows) {
        bool const first = all.form == "euroc";
        auto const rotation = first ? rotation_of(v[4], -v[5], -v[6], -v[7]) : rotation_of(v[7], -v[4], -v[5], -v[6]);
        if (!rotation) return {};
        all.poses.push_back({v[0] * unit, {v[1], v[2], v[3]}, *rotation});
    }
    return all;
}

} // namespace plain
