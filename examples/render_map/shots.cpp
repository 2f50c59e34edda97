#include "shots.hpp"
#include <algorithm>
#include <cstddef>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <utility>

namespace render_map {

namespace {

namespace scene = tilemesh::scene;

/// The cameras before an option moves them.
std::vector<Shot> still_shots(Options const& options, MapShape const& map, std::vector<std::string>& notes,
                              std::vector<std::filesystem::path>& sized_by, std::vector<std::string>& names)
{
    if (!options.cameras) {
        bool const built_in = options.maps.empty();
        auto const camera = shared::placed_camera(options, map, options.size.value_or(scene::Size{1280, 720}), built_in);
        if (options.from) return {{"from", camera}};
        if (built_in && !options.up && !options.fov) return {{"built_in", camera}};
        if (!options.trajectory)
            notes.push_back("no camera is named: this one is a guess, along +z at the middle of the map; look around with --orbit 90 "
                            "--frames 4, add --up 0,1,0 if the map is upside down, or name yours with --cameras");
        return {{"frame_whole", camera}};
    }
    std::vector<Shot> shots;
    auto chosen = shared::load_cameras(options, map, options.size, notes, sized_by, &names);
    if (options.every && !options.trajectory) {
        auto const all = chosen.size();
        std::stable_sort(chosen.begin(), chosen.end(), [](auto const& a, auto const& b) { return a.name < b.name; });
        auto const before = notes.size();
        auto const splits = shared::splits_of(chosen, *options.every, true, notes);
        std::size_t kept = 0;
        for (std::size_t i = 0; i < all; ++i)
            if (splits[i] == scene::Split::held_out) std::swap(chosen[kept++], chosen[i]);
        if (kept == 0)
            throw tilemesh::Error(
                "no camera is held out (the lists of names in the camera file hold out none that --camera chose); leave --every out");
        chosen.resize(kept);
        if (notes.size() == before)
            notes.push_back(std::to_string(kept) + " of " + std::to_string(all) + " cameras: one in " + std::to_string(*options.every) +
                            " of the sorted names, from the first (--every)");
    }
    for (auto const& each : chosen)
        if ((options.certify || options.bound) && each.camera.lens.kind != tilemesh::splat::LensKind::pinhole)
            throw tilemesh::Error(std::string(options.certify ? "--certify" : "--bound") + " and the lens of camera " + scene::label(each) +
                                  " (nobody encloses the projection of a lens that bends the picture); leave that out, or name a pinhole camera");
    for (auto& each : chosen) {
        auto const camera = options.size ? scene::resized(each.camera, options.size->width, options.size->height)
                                         : scene::stretched(each.camera, scene::reduced({each.camera.width, each.camera.height}, options.scale));
        shots.push_back({scene::label(each), camera, {}, each.name, each.camera, each.mask});
    }
    return shots;
}

} // namespace

std::vector<Shot> make_shots(Options const& options, MapShape const& map, std::vector<std::string>& notes,
                             std::vector<std::filesystem::path>& sized_by, std::vector<std::string>& names)
{
    auto const still = still_shots(options, map, notes, sized_by, names);
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
        for (auto const& camera : scene::orbit(start.camera, map.centre(), *options.orbit_degrees, options.frames, shared::up_of(options)))
            add(start.name + " orbit", camera);
        return shots;
    }
    auto trajectory = scene::load_trajectory(*options.trajectory, shared::most_frames, options.trajectory_format);
    shared::add_notes(notes, *options.trajectory, scene::trajectory_notes(trajectory));
    if (!options.cameras)
        notes.push_back("the lens is a guess (a trajectory says none): name yours with --cameras FILE --camera NAME");
    auto const lens = scene::lens_of(start.camera);
    std::vector<tilemesh::splat::Shutter> shutters(trajectory.size());
    if (options.rolling_shutter) {
        if (!trajectory.has_stamps())
            throw tilemesh::Error("--rolling-shutter with " + options.trajectory->string() +
                                  " (it has no time stamps, so nobody knows how fast the camera moves); give poses of TUM or EuRoC");
        for (std::size_t i = 0; i < trajectory.size(); ++i) shutters[i] = scene::shutter_at(trajectory, i, *options.rolling_shutter, lens);
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < trajectory.size(); i += options.step()) shutters[kept] = shutters[i], trajectory[kept++] = trajectory[i];
    trajectory.resize(kept);
    if (options.frames != 0 && options.frames < trajectory.size()) trajectory.resize(options.frames);
    trajectory = options.relative ? scene::relative_to_first(std::move(trajectory), scene::pose_of(start.camera))
                                  : scene::relative_to_origin(std::move(trajectory), map.origin);
    for (auto const& [seconds, pose] : trajectory) {
        auto camera = scene::make_camera(pose, lens);
        camera.shutter = shutters[shots.size()];
        add(options.trajectory->stem().string(), camera, trajectory.has_stamps() ? std::optional(seconds) : std::nullopt);
    }
    return shots;
}

} // namespace render_map
