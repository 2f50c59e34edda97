#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <tilemesh/track/pose_solver.hpp>
#include <utility>
#include <vector>

namespace shared {

/// The poses of the camera of rendered pictures: those of a trajectory, or a hand-held motion of about 1 degree and 1 cm a pose. The motion
/// is a formula, so a pose costs nothing until it is asked for, however many there are.
class CameraPath {
public:
    explicit CameraPath(tilemesh::scene::Trajectory poses) : size_(poses.size()), poses_(std::move(poses)) {}
    CameraPath(tilemesh::scene::Pose const& first, std::uint64_t size) : size_(size), first_(first) {}
    std::uint64_t size() const { return size_; }
    tilemesh::scene::StampedPose operator[](std::uint64_t k) const
    {
        if (!first_) return poses_[static_cast<std::size_t>(k)];
        double const t = static_cast<double>(k) / 31.0;
        return {t, tilemesh::track::moved(*first_, {{0.1 * std::sin(2.0 * t), 0.06 * std::sin(3.1 * t), 0.08 * (1.0 - std::cos(1.7 * t))},
                                                    {0.05 * std::sin(2.3 * t), 0.12 * std::sin(1.9 * t), 0.03 * std::sin(2.9 * t)}})};
    }

private:
    std::uint64_t size_;
    std::optional<tilemesh::scene::Pose> first_; ///< of the hand-held motion
    tilemesh::scene::Trajectory poses_;
};

/// The nearest pose of each picture.
struct NearestPoses {
    std::vector<std::optional<std::size_t>> of_picture; ///< the index of the pose; nothing if none is near enough
    std::uint64_t steps = 0;                            ///< pictures and poses that were looked at, after the sort
};

/// The nearest in time of `poses` for each of the ascending `times`, at most `most_seconds` away. Of two that are equally near, the first in
/// the list. Cost: n log n for n poses in any order, then one step for each pose and each picture.
inline NearestPoses nearest_poses(std::vector<double> const& times, tilemesh::scene::Trajectory const& poses, double most_seconds)
{
    std::vector<std::size_t> order(poses.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return poses[a].seconds != poses[b].seconds ? poses[a].seconds < poses[b].seconds : a < b; });
    NearestPoses out;
    out.of_picture.reserve(times.size());
    // `next`: the first pose that is not before the picture. `last`: the first of the poses with the latest time before the picture.
    std::size_t next = 0, last = order.size();
    for (double const t : times) {
        ++out.steps;
        for (; next < order.size() && poses[order[next]].seconds < t; ++next, ++out.steps)
            if (last == order.size() || poses[order[next]].seconds != poses[order[last]].seconds) last = next;
        auto const away = [&](std::size_t at) { return std::fabs(poses[order[at]].seconds - t); };
        auto nearest = last;
        if (next < order.size() && (last == order.size() || away(next) < away(last) || (away(next) == away(last) && order[next] < order[last]))) nearest = next;
        bool const near = nearest < order.size() && away(nearest) <= most_seconds;
        out.of_picture.push_back(near ? std::optional(order[nearest]) : std::nullopt);
    }
    return out;
}

} // namespace shared
