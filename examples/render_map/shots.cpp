#include "shots.hpp"
#include "../shared/text.hpp"
#include <algorithm>
#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <optional>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/near_plane.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <utility>

namespace render_map {

namespace {

namespace scene = tilemesh::scene;

tilemesh::splat::Camera with_near(Options const& options, tilemesh::splat::Camera camera)
{
    camera.near_depth = options.near_depth.value_or(camera.near_depth);
    return camera;
}

/// The cameras before an option moves them.
std::vector<Shot> still_shots(Options const& options, MapShape const& map, std::vector<std::string>& notes,
                              std::vector<std::filesystem::path>& sized_by)
{
    if (!options.cameras) {
        auto const size = options.size.value_or(scene::Size{1280, 720});
        auto const vector = [](std::array<double, 3> const& v) { return glm::dvec3{v[0], v[1], v[2]}; };
        auto const in_map = [&](std::array<double, 3> const& v) { return vector(v) - vector(map.origin); };
        auto const up = vector(options.up.value_or(std::array{0.0, -1.0, 0.0}));
        auto const fov = options.fov.value_or(60.0);
        if (options.from) {
            scene::upright(up); // refuses a direction of length 0
            auto const target = options.look ? in_map(*options.look) : map.centre();
            auto camera = scene::make_camera(scene::look_at(in_map(*options.from), target, -up), scene::lens_from_field_of_view(fov, size));
            camera.near_depth = options.near_depth ? *options.near_depth : map.near_plane(camera);
            return {{"from", camera}};
        }
        if (options.maps.empty() && !options.up && !options.fov) return {{"built_in", with_near(options, scene::built_in_camera(size))}};
        if (!options.trajectory)
            notes.push_back("no camera is named: this one is a guess, along +z at the middle of the map; look around with --orbit 90 "
                            "--frames 4, add --up 0,1,0 if the map is upside down, or name yours with --cameras");
        return {{"frame_whole", with_near(options, map.whole(size, up, fov))}};
    }
    std::vector<Shot> shots;
    std::vector<std::string> of_file;
    auto const cameras = scene::load_cameras(*options.cameras, &of_file, options.distorted, options.size, &sized_by);
    for (auto const& note : of_file) notes.push_back(options.cameras->filename().string().append(": ").append(note));
    auto chosen = scene::relative_to_origin(scene::select_cameras(cameras, options.camera.value_or(""), map.name), map.origin);
    if (options.every && !options.trajectory) {
        auto const all = chosen.size();
        std::stable_sort(chosen.begin(), chosen.end(), [](auto const& a, auto const& b) { return a.name < b.name; });
        std::size_t kept = 0;
        for (std::size_t i = 0; i < all; i += *options.every) std::swap(chosen[kept++], chosen[i]);
        chosen.resize(kept);
        notes.push_back(std::to_string(kept) + " of " + std::to_string(all) + " cameras: one in " + std::to_string(*options.every) +
                        " of the sorted names, from the first (--every)");
    }
    for (auto& each : chosen) {
        if (!each.names_near && !options.near_depth) each.camera.near_depth = map.near_plane(each.camera);
        each.camera = with_near(options, each.camera);
        auto const camera = options.size ? scene::resized(each.camera, options.size->width, options.size->height)
                                         : scene::stretched(each.camera, scene::reduced({each.camera.width, each.camera.height}, options.scale));
        shots.push_back({scene::label(each), camera, {}, each.name, each.camera});
    }
    return shots;
}

} // namespace

std::string camera_names(Options const& options)
{
    std::string text;
    scene::Size const any{640, 480}; // for a camera without a size: its name does not depend on it
    for (auto const& camera : scene::load_cameras(*options.cameras, nullptr, options.distorted, options.size.value_or(any))) text += shared::one_line(scene::label(camera)) + "\n";
    return text;
}

MapShape shape_of(scene::Map const& map)
{
    return {map.name, [&map] { return scene::robust_centre(map); },
            [&map](scene::Size size, glm::dvec3 up, double degrees) { return scene::frame_whole(map, size, up, degrees); },
            [&map](tilemesh::splat::Camera const& camera) { return scene::near_for(map, camera); }, map.origin};
}

std::vector<Shot> make_shots(Options const& options, MapShape const& map, std::vector<std::string>& notes,
                             std::vector<std::filesystem::path>& sized_by)
{
    auto const still = still_shots(options, map, notes, sized_by);
    if (!options.orbit_degrees && !options.trajectory) return still;

    auto const& start = still.front();
    if (still.size() > 1)
        throw tilemesh::Error("the camera that moves is not said (" + options.cameras->string() +
                              " has " + std::to_string(still.size()) + " for map " + map.name +
                              "); name one with --camera");
    std::vector<Shot> shots;
    auto const add = [&](std::string const& motion, tilemesh::splat::Camera const& camera, std::optional<double> timestamp_s = {}) {
        shots.push_back({motion + "[" + std::to_string(shots.size()) + "]", camera, timestamp_s});
    };
    if (options.orbit_degrees) {
        auto const [x, y, z] = options.up.value_or(std::array{0.0, -1.0, 0.0});
        glm::dvec3 const up{x, y, z};
        for (auto const& camera : scene::orbit(start.camera, map.centre(),
                                               *options.orbit_degrees, options.frames, up))
            add(start.name + " orbit", camera);
        return shots;
    }
    auto trajectory = scene::load_trajectory(*options.trajectory, most_frames, options.trajectory_format);
    for (auto const& note : scene::trajectory_notes(trajectory))
        notes.push_back(options.trajectory->filename().string().append(": ").append(note));
    if (!options.cameras)
        notes.push_back("the lens is a guess (a trajectory says none): name yours with --cameras FILE --camera NAME");
    std::size_t kept = 0;
    for (std::size_t i = 0; i < trajectory.size(); i += options.every.value_or(1)) trajectory[kept++] = trajectory[i];
    trajectory.resize(kept);
    if (options.frames != 0 && options.frames < trajectory.size()) trajectory.resize(options.frames);
    trajectory = options.relative ? scene::relative_to_first(std::move(trajectory), scene::pose_of(start.camera))
                                  : scene::relative_to_origin(std::move(trajectory), map.origin);
    for (auto const& [seconds, pose] : trajectory)
        add(options.trajectory->stem().string(), scene::make_camera(pose, scene::lens_of(start.camera)),
            trajectory.has_stamps() ? std::optional(seconds) : std::nullopt);
    return shots;
}

} // namespace render_map
