#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/camera.hpp>
#include <vector>

namespace bench {

/// A map, and the camera at which its motions begin.
struct Scene {
    tilemesh::scene::Map map;
    tilemesh::splat::Camera camera;
};

inline constexpr char const* scene_names[] = {"sloth", "salad", "playbot_250k", "built_in"};
inline constexpr char const* motion_names[] = {"static", "orbit0.1", "orbit0.5", "orbit2", "teleport", "fr1_xyz", "fr2_desk"};

/// Loads the scene of that name at this size. The camera is the authors' benchmark camera for their two maps, and `frame_whole` for another
/// file. `data` holds maps/ and cameras.json. `built_in_1m` and `built_in_5m` are the built-in map, densified to one or five million
/// Gaussians. Throws Error for a bad file.
Scene load_scene(std::string const& name, std::filesystem::path const& data, tilemesh::scene::Size size);
/// Loads any map, without its harmonics, which the rasteriser does not draw. Its name is the file's, and its camera is `frame_whole`.
Scene load_file(std::filesystem::path const& map, tilemesh::scene::Size size);

/// Do the files of this scene exist? `has_motion`: the files of this motion. The built-in maps and the orbits need no file.
bool has_scene(std::string const& name, std::filesystem::path const& data);
bool has_motion(std::string const& motion, std::filesystem::path const& data);

/// Returns the scene's own camera, then `frames` more. `static` repeats the camera. `orbitX` turns it by X degrees per frame about the
/// middle of the map. `teleport` takes the recorded jumps of the scene if there are any, otherwise multiples of the golden angle on the
/// orbit. `fr1_xyz` and `fr2_desk` are the first poses of a hand-held camera at 31 frames per second, applied to the scene's camera.
std::vector<tilemesh::splat::Camera> cameras_of(std::string const& motion, Scene const& scene, std::uint32_t frames,
                                                std::filesystem::path const& data);

/// A map of `n` Gaussians that looks like `map`, but is denser. Each Gaussian is replaced by c = n / size copies of it (some have one more),
/// scattered over it like a normal distribution of its own axes, within three standard deviations. Each copy is 1 / sqrt(c) as large along
/// each axis, so that the copies of a disc cover its area once. A copy has the harmonics of its Gaussian. The same arguments give the same
/// map. Ids are 1 to n. Requires a map that is not empty.
tilemesh::scene::Map densified(tilemesh::scene::Map const& map, std::uint32_t n);

} // namespace bench
