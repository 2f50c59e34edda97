#pragma once
#include "camera_path.hpp"
#include "rgbd_photo.hpp"
#include "sequence_options.hpp"
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/rgbd_list.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/track/pose_update.hpp>
#include <tilemesh/track/spoil.hpp>
#include <utility>
#include <vector>

/// The pictures of a camera that moves: files, or views of a map. For the programs that track.
namespace shared {

namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
namespace track = tilemesh::track;

/// A picture, and the pose that it was taken from, if that is known.
struct SeenFrame {
    double seconds = 0.0;
    report::Image colour;
    report::Plane depth;
    std::optional<scene::Pose> truth;
};

/// The camera of --camera in the pictures' size, and what its file says. Without --cameras, the one that the options place.
struct FirstCamera {
    tilemesh::splat::Camera camera;
    bool names_near = true;                        ///< the near plane is the file's; or there is no file
    std::vector<std::filesystem::path> sized_by{}; ///< pictures from which `scene::load_cameras` took sizes
};
inline FirstCamera first_camera(SequenceOptions const& o, MapShape const& map, scene::Size size, bool built_in, std::vector<std::string>& notes)
{
    if (!o.cameras) return {placed_camera(o, map, size, built_in)};
    FirstCamera out{};
    auto const chosen = load_cameras(o, map, size, notes, out.sized_by).front();
    out.camera = scene::resized(chosen.camera, size.width, size.height);
    out.names_near = chosen.names_near;
    return out;
}

/// The poses of --trajectory for a map from which its reader subtracted `origin`; empty without the option.
inline scene::Trajectory poses_of(SequenceOptions const& o, scene::Pose const& first, std::array<double, 3> const& origin,
                                  std::vector<std::string>& notes)
{
    if (!o.trajectory) return {};
    auto poses = scene::load_trajectory(*o.trajectory, scene::most_poses, o.trajectory_format);
    add_notes(notes, *o.trajectory, scene::trajectory_notes(poses));
    return o.relative ? scene::relative_to_first(std::move(poses), first) : scene::relative_to_origin(std::move(poses), origin);
}

/// Poses of a map with an origin, in the coordinates of its file.
inline std::vector<scene::StampedPose> in_file_coordinates(std::vector<scene::StampedPose> poses, std::array<double, 3> const& origin)
{
    if (origin == std::array<double, 3>{}) return poses;
    for (auto& each : poses) each.pose.position += glm::dvec3{origin[0], origin[1], origin[2]};
    return poses;
}

/// Real pictures, with the poses of a trajectory that are at most 20 ms away as the truth. Throws Error for a trajectory that has none.
class Photos {
public:
    Photos(SequenceOptions const& o, std::vector<scene::RgbdFrame> list, scene::Trajectory poses, scene::Size size)
        : options_(o), list_(std::move(list)), poses_(std::move(poses)), size_(size)
    {
        std::vector<double> times;
        for (std::size_t k = 0; k < list_.size(); k += options_.step()) times.push_back(list_[k].colour.seconds);
        nearest_ = nearest_poses(times, poses_, scene::most_seconds_apart).of_picture;
        auto const is_known = [](auto const& pose) { return pose.has_value(); };
        if (!poses_.empty() && std::none_of(nearest_.begin(), nearest_.end(), is_known))
            throw tilemesh::Error(o.trajectory->string() +
                                  " is not the path of these pictures (no pose is within 20 ms of a picture); name another trajectory, or none");
    }
    std::size_t count() const { return nearest_.size(); }
    std::optional<scene::Pose> truth(std::size_t k) const
    {
        return nearest_[k] ? std::optional(poses_[*nearest_[k]].pose) : std::nullopt;
    }
    SeenFrame take(std::size_t k) const
    {
        auto frame = list_[k * options_.step()];
        if (!options_.depth) frame.depth.file.clear();
        auto photo = read_photo(frame, size_, options_.depth_levels, options_.without_depth);
        return {frame.colour.seconds, std::move(photo.colour), std::move(photo.depth), truth(k)};
    }

private:
    SequenceOptions const& options_;
    std::vector<scene::RgbdFrame> list_;
    scene::Trajectory poses_;
    scene::Size size_;
    std::vector<std::optional<std::size_t>> nearest_; ///< the pose of each picture
};

/// Pictures that are rendered from a map and spoilt. With an open shutter, a picture is the mean of three poses. `Render` gives the view of
/// a camera as a `RgbdPhoto`, with a depth of 0 where the map covers less than half of a pixel.
template <class Render>
class Renderings {
public:
    Renderings(SequenceOptions const& o, Render render, CameraPath path, scene::Intrinsics const& lens)
        : options_(o), render_(std::move(render)), path_(std::move(path)), lens_(lens)
    {
        spoiling_.noise = o.noise;
        spoiling_.shutter = o.shutter;
        spoiling_.gain_drift = o.gain_drift;
        if (!(o.noise > 0.0)) spoiling_ = {0.0, false, 0.0, 0.0, 0.0, 0.0, 1};
    }
    std::size_t count() const { return static_cast<std::size_t>((path_.size() + options_.step() - 1) / options_.step()); }
    scene::Pose truth(std::size_t k) const
    {
        return scene::pose_of(scene::make_camera(path_[std::uint64_t{k} * options_.step()].pose, lens_));
    }
    /// The picture as it is before it is spoilt.
    RgbdPhoto clean(std::size_t k) const { return render_(scene::make_camera(path_[std::uint64_t{k} * options_.step()].pose, lens_)); }
    SeenFrame take(std::size_t k) const
    {
        auto const at = std::uint64_t{k} * options_.step();
        auto const [seconds, pose] = path_[at];
        auto target = render_(scene::make_camera(pose, lens_));
        if (spoiling_.shutter > 0.0) {
            auto const step = velocity(at);
            auto const three = track::shutter_poses(track::moved(pose, {-step.rho, -step.phi}), pose, track::moved(pose, step),
                                                    spoiling_.shutter);
            std::vector<report::Image> pictures{render_(scene::make_camera(three[0], lens_)).colour, std::move(target.colour),
                                                render_(scene::make_camera(three[2], lens_)).colour};
            target.colour = track::mean_of(pictures);
        }
        track::spoil(target.colour, target.depth, k, spoiling_, options_.threads);
        return {seconds, std::move(target.colour), std::move(target.depth), truth(k)};
    }

private:
    /// The camera's motion in a frame's time: the mean of the steps to pose i and from it. So the middle of the exposure is the pose itself,
    /// also where the steps jitter.
    track::Twist velocity(std::uint64_t i) const
    {
        track::Twist sum;
        double steps = 0.0;
        auto const add = [&](scene::Pose const& to, double sign) {
            auto const way = track::twist_between(path_[i].pose, to);
            sum.rho += sign * way.rho;
            sum.phi += sign * way.phi;
            steps += 1.0;
        };
        if (i > 0) add(path_[i - 1].pose, -1.0);
        if (i + 1 < path_.size()) add(path_[i + 1].pose, 1.0);
        if (steps > 0.0) sum.rho /= steps, sum.phi /= steps;
        return sum;
    }

    SequenceOptions const& options_;
    Render render_;
    CameraPath path_;
    scene::Intrinsics lens_;
    track::Spoiling spoiling_;
};

} // namespace shared
