#include "shots.hpp"
#include <cstddef>
#include <optional>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <utility>

namespace render_map {

namespace {

namespace scene = tilemesh::scene;

/// The cameras before an option moves them.
std::vector<Shot> still_shots(Options const& options, scene::Map const& map, std::vector<std::string>& notes)
{
    if (!options.cameras) {
        auto const size = options.size.value_or(scene::Size{1280, 720});
        if (options.maps.empty()) return {{"built_in", scene::built_in_camera(size)}};
        if (!options.trajectory)
            notes.push_back("no camera is named: this one is a guess, along +z at the middle of the map; look around with --orbit 90 "
                            "--frames 4, or name yours with --cameras");
        return {{"frame_whole", scene::frame_whole(map, size)}};
    }
    std::vector<Shot> shots;
    std::vector<std::string> of_file;
    auto const cameras = scene::load_cameras(*options.cameras, &of_file);
    for (auto const& note : of_file) notes.push_back(options.cameras->filename().string().append(": ").append(note));
    for (auto const& chosen : scene::select_cameras(cameras, options.camera.value_or(""), map.name)) {
        auto const camera =
            options.size ? scene::resized(chosen.camera, options.size->width, options.size->height)
                         : chosen.camera;
        shots.push_back({scene::label(chosen), camera});
    }
    return shots;
}

} // namespace

std::vector<Shot> make_shots(Options const& options, scene::Map const& map, std::vector<std::string>& notes)
{
    auto const still = still_shots(options, map, notes);
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
        for (auto const& camera : scene::orbit(start.camera, scene::robust_centre(map),
                                               *options.orbit_degrees, options.frames))
            add(start.name + " orbit", camera);
        return shots;
    }
    auto trajectory = scene::load_tum(*options.trajectory, most_frames);
    for (auto const& note : scene::trajectory_notes(trajectory))
        notes.push_back(options.trajectory->filename().string().append(": ").append(note));
    if (!options.cameras)
        notes.push_back("the lens is a guess (a trajectory says none): name yours with --cameras FILE --camera NAME");
    std::size_t kept = 0;
    for (std::size_t i = 0; i < trajectory.size(); i += options.every) trajectory[kept++] = trajectory[i];
    trajectory.resize(kept);
    if (options.frames != 0 && options.frames < trajectory.size()) trajectory.resize(options.frames);
    if (options.relative)
        trajectory = scene::relative_to_first(std::move(trajectory), scene::pose_of(start.camera));
    for (auto const& [seconds, pose] : trajectory)
        add(options.trajectory->stem().string(),
            scene::make_camera(pose, scene::lens_of(start.camera)), seconds);
    return shots;
}

} // namespace render_map
