#pragma once
#include "plain_cameras.hpp"

namespace plain {

struct Pose {
    double seconds;
    std::array<double, 3> position;
    std::array<std::array<double, 3>, 3> rotation; ///< world to camera, rows
};

inline std::optional<std::vector<Pose>> tum(std::string const& text, std::size_t most)
{
    std::vector<Pose> poses;
    for (auto const& line : lines(without_mark(text))) {
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

} // namespace plain
