#pragma once
#include "camera_path.hpp"
#include "photographs_of.hpp"
#include "rgbd_photo.hpp"
#include "sequence_options.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/json_text.hpp>
#include <tilemesh/report/plot.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/lens.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/rgbd_list.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/track/depth_misfit.hpp>
#include <tilemesh/track/pose_update.hpp>
#include <tilemesh/track/spoil.hpp>
#include <tilemesh/track/trajectory_error.hpp>
#include <tuple>
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

/// The camera of pictures of this size. Throws Error unless both sides have the same scale within the rounding of a size to whole pixels.
inline tilemesh::splat::Camera lens_of_pictures(scene::NamedCamera const& camera, scene::Size size, std::string const& file,
                                                std::vector<std::string>& notes)
{
    scene::Size const own{camera.camera.width, camera.camera.height};
    auto const product = [](std::uint32_t a, std::uint32_t b) { return std::int64_t{a} * std::int64_t{b}; };
    auto const scale = [](std::uint32_t to, std::uint32_t from) { return tilemesh::significant(static_cast<double>(to) / from, 4); };
    auto const across = scale(size.width, own.width), down = scale(size.height, own.height);
    // A side that is rounded is off by less than a pixel, so the product of the sides crosswise is off by less than the sum of the other size.
    auto const most = std::max(std::int64_t{own.width} + own.height, std::int64_t{size.width} + size.height);
    if (std::llabs(product(size.width, own.height) - product(size.height, own.width)) >= most)
        throw tilemesh::Error("camera " + scene::label(camera) + " of " + file + " is not the camera of these pictures (" + by(own) +
                              " pixels become " + by(size) + " with a scale of " + across + " across and " + down + " down); name a camera of the "
                              "pictures' shape");
    if (!same(own, size))
        notes.push_back(file + ": camera " + scene::label(camera) + " is scaled by " + across +
                        (across == down ? "" : " across and " + down + " down") + " (" + by(own) + " pixels to " + by(size) + ")");
    return scene::stretched(camera.camera, size);
}

/// What a program says of depths whose median is less than half of the map's, or more than twice; empty for other depths.
inline std::string depth_note(report::Plane const& measured, double of_map)
{
    auto const misfit = track::depth_misfit(measured, of_map, 2.0);
    return misfit.empty() ? misfit : "note: the depths of the first picture do not fit the map (" + misfit + "): check --depth-scale\n";
}

/// A number for readers: three significant digits. No printed measure is known better, and each has a unit behind it.
inline std::string rounded(double value)
{
    if (!std::isfinite(value)) return "unknown";
    return value >= 999.5 && value < 1e15 ? tilemesh::decimals(value, 0) : tilemesh::significant(value, 3); // not 1.02e+03
}
/// The line of a summary that compares a path with the truth, and a note if that is the truth of less than half of the pictures. `scale`: the
/// median depth in world units.
inline std::string error_lines(track::TrajectoryErrors const& e, double scale, std::size_t pictures)
{
    auto const of = std::to_string(e.poses) + " of " + std::to_string(pictures) + " pictures";
    return "ATE " + rounded(e.ate.rmse) + " world units (" + of + "; aligned " + rounded(e.ate_aligned.rmse) + "; " + rounded(e.ate.rmse / scale) +
           " of the median depth), " + rounded(e.rotation_deg.rmse) + " degrees; RPE " + rounded(e.rpe.rmse) + " world units and " +
           rounded(e.rpe_deg.rmse) + " degrees a frame (" + std::to_string(e.poses - 1) + " steps)\n" +
           (2 * e.poses < pictures ? "note: these errors are of " + of + ": the others are lost, or the trajectory has no pose for them\n" : "");
}
/// The members of a summary that compare a path with the truth.
inline void add_errors(report::JsonText& json, track::TrajectoryErrors const& e)
{
    json.member("poses_compared", e.poses);
    json.member("ate_rmse", e.ate.rmse);
    json.member("ate_aligned_rmse", e.ate_aligned.rmse);
    json.member("rpe_rmse", e.rpe.rmse);
    json.member("rpe_deg_rmse", e.rpe_deg.rmse);
    json.member("rotation_rmse_deg", e.rotation_deg.rmse);
}

/// What a program says of the lens that it uses.
inline std::string lens_line(scene::Intrinsics const& lens)
{
    auto const px = [](double value) { return tilemesh::significant(value, 6); };
    return "lens: " + std::to_string(lens.width) + " x " + std::to_string(lens.height) + " pixels, fx " + px(lens.fx) + ", fy " + px(lens.fy) +
           ", cx " + px(lens.cx) + ", cy " + px(lens.cy) + ", near plane " + px(double{lens.near_depth}) +
           (lens.bend.kind == tilemesh::splat::LensKind::pinhole ? "" : ", " + scene::text_of(lens.bend)) + "\n";
}

/// The camera of --camera in the pictures' size, and what its file says. Of several, that of the first picture of `list` by its name, or else the
/// first; a note says which, if others have another lens. Without --cameras, the one that the options place.
struct FirstCamera {
    tilemesh::splat::Camera camera;
    bool names_near = true;                        ///< the near plane is the file's; or there is no file
    bool of_first_picture = false;                 ///< by its name
    std::vector<std::filesystem::path> sized_by{}; ///< pictures from which `scene::load_cameras` took sizes
};
inline FirstCamera first_camera(SequenceOptions const& o, std::vector<scene::RgbdFrame> const& list, MapShape const& map, scene::Size size,
                                bool built_in, std::vector<std::string>& notes)
{
    if (!o.cameras) {
        FirstCamera placed{placed_camera(o, map, size, built_in)};
        scene::check_no_panorama(placed.camera, "a pose's derivative");
        return placed;
    }
    FirstCamera out{};
    auto const cameras = load_cameras(o, map, size, notes, out.sized_by);
    std::vector<std::string> names;
    for (auto const& camera : cameras) names.push_back(camera.name);
    auto const owners = list.empty() ? std::vector<std::size_t>{0} : cameras_of(pictures_of(list), names);
    auto const of_picture = owners.front();
    out.of_first_picture = !list.empty() && of_picture != cameras.size();
    auto const& chosen = cameras[of_picture < cameras.size() ? of_picture : 0];
    auto const shape_of_lens = [](scene::NamedCamera const& camera) {
        auto const& c = camera.camera;
        return std::tuple{c.width, c.height, c.fx, c.fy, c.cx, c.cy, scene::text_of(c.lens)};
    };
    auto const others = std::count_if(cameras.begin(), cameras.end(), [&](auto const& each) { return shape_of_lens(each) != shape_of_lens(chosen); });
    auto const later = std::find_if(owners.begin(), owners.end(), [&](std::size_t owner) { return owner != cameras.size(); });
    if (of_picture == cameras.size() && cameras.size() == 1 && later != owners.end()) // a lens file has the name of no picture
        add_notes(notes, *o.cameras,
                  {"its camera has the name of picture " + std::to_string(later - owners.begin() + 1) + " of " + std::to_string(owners.size()) +
                   ", and gives lens and pose of the first one"});
    if (of_picture == cameras.size() && cameras.size() != 1)
        add_notes(notes, *o.cameras,
                  {"none of its " + std::to_string(cameras.size()) + " cameras has the name of the first picture: the first one, " +
                   scene::label(chosen) + ", gives lens and pose"});
    if (others != 0)
        add_notes(notes, *o.cameras,
                  {std::to_string(others) + " of " + std::to_string(cameras.size()) + " cameras have another lens than " + scene::label(chosen) +
                   ", whose lens all pictures get"});
    out.camera = o.photos ? lens_of_pictures(chosen, size, o.cameras->filename().string(), notes)
                          : scene::resized(chosen.camera, size.width, size.height);
    scene::check_no_panorama(out.camera, "a pose's derivative");
    out.names_near = chosen.names_near;
    return out;
}

/// The pictures of --photos, without their depths if the options say so; empty without the option.
inline std::vector<scene::RgbdFrame> recording_of(SequenceOptions const& o, std::vector<std::string>& notes)
{
    if (!o.photos) return {};
    std::vector<std::string> of_list;
    auto list = scene::load_rgbd(*o.photos, o.depth ? std::optional(o.depth_within) : std::nullopt, &of_list);
    add_notes(notes, *o.photos, of_list);
    add_picture_notes(pictures_of(list), "a pixel that is not opaque is not known", notes);
    return list;
}

/// The poses of --trajectory for a map from which its reader subtracted `origin`; empty without the option. Throws Error for poses without time
/// stamps that are not as many as the pictures of `list`.
inline scene::Trajectory poses_of(SequenceOptions const& o, FirstCamera const& camera, std::array<double, 3> const& origin,
                                  std::vector<scene::RgbdFrame> const& list, std::vector<std::string>& notes)
{
    if (!o.trajectory) return {};
    auto const first = scene::pose_of(camera.camera);
    std::size_t of_first = 0; // the pose of the first picture
    auto poses = scene::load_trajectory(*o.trajectory, scene::most_poses, o.trajectory_format);
    add_notes(notes, *o.trajectory, scene::trajectory_notes(poses));
    if (o.rolling_shutter && !poses.has_stamps())
        throw tilemesh::Error("--rolling-shutter with " + o.trajectory->string() +
                              " (it has no time stamps, so nobody knows how fast the camera moves); give poses of TUM or EuRoC");
    if (o.photos && !poses.has_stamps()) {
        if (auto const rows = poses.size() + poses.left_out; rows != list.size())
            throw tilemesh::Error(o.trajectory->string() + " does not say which picture a pose belongs to (it has no time stamps, and " +
                                  std::to_string(rows) + " poses for " + std::to_string(list.size()) +
                                  " pictures); give a pose for each picture, or poses with time stamps");
        add_notes(notes, *o.trajectory, {"it has no time stamps: pose i is taken for that of picture i, in the order of time"});
    } else if (o.photos) {
        std::vector<double> times;
        for (auto const& frame : list) times.push_back(frame.colour.seconds);
        auto const pose_of = nearest_poses(times, poses, scene::most_seconds_apart).of_picture; // ascends, as the times do
        of_first = pose_of.front().value_or(poses.size());
        std::size_t shared = 0;
        for (std::size_t k = 1; k < times.size(); ++k)
            shared += pose_of[k] && pose_of[k - 1] && poses[*pose_of[k]].seconds == poses[*pose_of[k - 1]].seconds ? 1u : 0u;
        if (shared != 0)
            add_notes(notes, *o.trajectory,
                      {std::to_string(shared) + " of " + std::to_string(list.size()) +
                       " pictures have no pose of their own, but the one of the picture before: errors include the motion between them"});
    }
    if (o.relative) return scene::relative_to_first(std::move(poses), first);
    poses = scene::relative_to_origin(std::move(poses), origin);
    if (camera.of_first_picture && of_first < poses.size()) { // two poses of one picture
        auto const& given = poses[of_first].pose;
        double extent = 0;
        for (auto const& pose : poses) extent = std::max(extent, glm::distance(pose.pose.position, given.position));
        auto const apart = glm::distance(given.position, first.position), degrees = track::detail::degrees_of(glm::transpose(given.rotation) * first.rotation);
        if (apart > 0.05 * extent + 1e-6 * (1 + glm::length(given.position)) || degrees > 2)
            add_notes(notes, *o.trajectory,
                      {"its pose of the first picture is " + tilemesh::significant(apart, 3) + " world units and " + tilemesh::significant(degrees, 3) +
                       " degrees from that of " + o.cameras->filename().string() + ", and counts; --relative takes its motion alone"});
    }
    return poses;
}

/// Poses of a map with an origin, in the coordinates of its file.
inline std::vector<scene::StampedPose> in_file_coordinates(std::vector<scene::StampedPose> poses, std::array<double, 3> const& origin)
{
    if (origin == std::array<double, 3>{}) return poses;
    for (auto& each : poses) each.pose.position += glm::dvec3{origin[0], origin[1], origin[2]};
    return poses;
}

/// Real pictures, with the poses of a trajectory as the truth: those that are at most 20 ms away, or, without time stamps, those of the same
/// number. Throws Error for a trajectory that has none.
class Photos {
public:
    Photos(SequenceOptions const& o, std::vector<scene::RgbdFrame> list, scene::Trajectory poses, scene::Size size)
        : options_(o), list_(std::move(list)), poses_(std::move(poses)), size_(size)
    {
        std::vector<double> times; // of the poses' clock: seconds, or numbers of pictures
        for (std::size_t k = 0; k < list_.size(); k += options_.step())
            times.push_back(poses_.has_stamps() ? list_[k].colour.seconds : static_cast<double>(k));
        nearest_ = nearest_poses(times, poses_, poses_.has_stamps() ? scene::most_seconds_apart : 0.0).of_picture;
        auto const is_known = [](auto const& pose) { return pose.has_value(); };
        if (poses_.empty() || std::any_of(nearest_.begin(), nearest_.end(), is_known)) return;
        double away = std::numeric_limits<double>::infinity();
        auto const any = nearest_poses(times, poses_, away).of_picture;
        for (std::size_t k = 0; k < times.size(); ++k) away = std::min(away, std::fabs(times[k] - poses_[*any[k]].seconds));
        throw tilemesh::Error(o.trajectory->string() + " is not the path of these pictures (no pose is within 20 ms of a picture, the nearest is " +
                              tilemesh::significant(away, 3) + " s away); name another trajectory, or none");
    }
    std::size_t count() const { return nearest_.size(); }
    std::optional<scene::Pose> truth(std::size_t k) const
    {
        return nearest_[k] ? std::optional(poses_[*nearest_[k]].pose) : std::nullopt;
    }
    /// The file of picture k, from the folder of the pictures.
    std::string name(std::size_t k) const
    {
        auto const& photos = *options_.photos;
        auto const file =
            list_[k * options_.step()].colour.file.lexically_relative(std::filesystem::is_directory(photos) ? photos : photos.parent_path());
        return file.empty() ? list_[k * options_.step()].colour.file.generic_string() : file.generic_string();
    }
    SeenFrame take(std::size_t k) const
    {
        auto const& frame = list_[k * options_.step()];
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

/// Both paths as SVG, seen from above: x to the right, z forward. Lost frames are left out of the estimate.
inline std::string path_plot(std::vector<scene::StampedPose> const& estimated, std::vector<bool> const& lost,
                             std::vector<scene::StampedPose> const& truth)
{
    report::Plot plot{"camera path, seen from above", {"x (world units)"}, {"z (world units)"}, {}};
    plot.equal_units = true;
    for (auto const& [name, poses] : {std::pair{"truth", &truth}, std::pair{"estimated", &estimated}}) {
        report::PlotSeries series{name, {}};
        series.colour = static_cast<std::uint32_t>(plot.series.size());
        for (std::size_t i = 0; i < poses->size(); ++i)
            if (poses == &truth || !lost[i]) series.points.emplace_back((*poses)[i].pose.position.x, (*poses)[i].pose.position.z);
        if (!series.points.empty()) plot.series.push_back(std::move(series));
    }
    return report::svg(plot);
}

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
    /// The number of frame k on the path.
    std::string name(std::size_t k) const { return std::to_string(std::uint64_t{k} * options_.step()); }
    std::size_t count() const { return static_cast<std::size_t>((path_.size() + options_.step() - 1) / options_.step()); }
    scene::Pose truth(std::size_t k) const
    {
        return scene::pose_of(scene::make_camera(path_[std::uint64_t{k} * options_.step()].pose, lens_));
    }
    /// The picture as it is before it is spoilt.
    RgbdPhoto clean(std::size_t k) const
    {
        auto const at = std::uint64_t{k} * options_.step();
        return render_(scene::make_camera(path_[at].pose, lens_at(at)));
    }
    SeenFrame take(std::size_t k) const
    {
        auto const at = std::uint64_t{k} * options_.step();
        auto const [seconds, pose] = path_[at];
        auto const lens = lens_at(at);
        auto target = render_(scene::make_camera(pose, lens));
        if (spoiling_.shutter > 0.0) {
            auto const step = velocity(at);
            auto const three = track::shutter_poses(track::moved(pose, {-step.rho, -step.phi}), pose, track::moved(pose, step),
                                                    spoiling_.shutter);
            std::vector<report::Image> pictures{render_(scene::make_camera(three[0], lens)).colour, std::move(target.colour),
                                                render_(scene::make_camera(three[2], lens)).colour};
            target.colour = track::mean_of(pictures);
        }
        track::spoil(target.colour, target.depth, k, spoiling_, options_.threads);
        return {seconds, std::move(target.colour), std::move(target.depth), truth(k)};
    }

private:
    scene::Intrinsics lens_at(std::uint64_t i) const
    {
        auto lens = lens_;
        if (options_.rolling_shutter) lens.shutter = scene::shutter_at(path_, static_cast<std::size_t>(i), *options_.rolling_shutter, lens);
        return lens;
    }
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
