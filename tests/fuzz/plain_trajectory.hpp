#pragma once
#include "plain_cameras.hpp"

namespace plain {

struct Pose {
    double seconds;
    std::array<double, 3> position;
    std::array<std::array<double, 3>, 3> rotation; ///< world to camera, rows
};

/// The eight numbers of a line of EuRoC, which may have more fields.
inline std::optional<std::array<double, 8>> euroc_fields(std::string const& line)
{
    std::array<double, 8> v{};
    std::size_t begin = 0;
    for (double& value : v) {
        if (begin > line.size()) return {};
        std::size_t const end = std::min(line.find(',', begin), line.size());
        auto const w = words(line.substr(begin, end - begin));
        if (w.size() != 1 || !moderate(w[0])) return {};
        value = *moderate(w[0]);
        begin = end + 1;
    }
    return v;
}

/// A line that is the first rows of a matrix, camera to world; `close` as for `usable`.
inline std::optional<Pose> matrix_pose(std::vector<std::string> const& w, bool& close)
{
    std::array<double, 16> m{};
    for (std::size_t i = 0; i < w.size(); ++i) {
        if (!moderate(w[i])) return {};
        m[i] = *moderate(w[i]);
    }
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

/// The poses of a text, in which a byte order mark is an error.
inline std::optional<std::vector<Pose>> tum_lines(std::string const& text, std::size_t most)
{
    std::vector<Pose> poses;
    for (auto const& line : lines(text)) {
        std::string const before = line.substr(0, line.find('#'));
        auto const w = words(before);
        if (w.empty()) continue;
        if (before.find(',') != before.npos || w.size() != 8 || poses.size() == most) return {};
        std::array<double, 8> v{};
        for (std::size_t i = 0; i < 8; ++i) {
            if (!moderate(w[i])) return {};
            v[i] = *moderate(w[i]);
        }
        auto const rotation = rotation_of(v[7], -v[4], -v[5], -v[6]); // the conjugate: world to camera
        if (!rotation) return {};
        poses.push_back({v[0], {v[1], v[2], v[3]}, *rotation});
    }
    if (poses.empty()) return {};
    return poses;
}
/// The poses of a file, which may begin with a mark.
inline std::optional<std::vector<Pose>> tum(std::string const& text, std::size_t most)
{
    return tum_lines(without_mark(text), most);
}

/// A trajectory in the form of its first pose: "tum", "euroc", "kitti" or "replica". Sets `close` if a value is so near to a limit that rounding
/// decides.
struct Trajectory {
    std::string form;
    std::vector<Pose> poses;
};
inline std::optional<Trajectory> any_trajectory(std::string const& text, std::size_t most, bool& close)
{
    Trajectory all;
    for (auto const& line : lines(without_mark(text))) {
        std::string const before = line.substr(0, line.find('#'));
        auto const w = words(before);
        if (w.empty()) continue;
        if (all.form.empty())
            all.form = std::count(before.begin(), before.end(), ',') >= 7 ? "euroc" : w.size() == 12 ? "kitti" : w.size() == 16 ? "replica" : "tum";
        std::optional<Pose> pose;
        if (all.form == "tum") {
            auto const found = tum_lines(before, 1);
            if (found) pose = found->front();
        } else if (all.form == "euroc") {
            auto const v = euroc_fields(before);
            auto const rotation = v ? rotation_of((*v)[4], -(*v)[5], -(*v)[6], -(*v)[7]) : std::nullopt;
            if (rotation) pose = {(*v)[0] * 1e-9, {(*v)[1], (*v)[2], (*v)[3]}, *rotation};
        } else if (w.size() == (all.form == "kitti" ? 12u : 16u)) {
            pose = matrix_pose(w, close);
            if (pose) pose->seconds = static_cast<double>(all.poses.size());
        }
        if (!pose || all.poses.size() == most) return {};
        all.poses.push_back(*pose);
    }
    if (all.poses.empty()) return {};
    return all;
}

} // namespace plain
