#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/camera.hpp>
#include <vector>

namespace bench {

/// A map and the camera that its motions begin at.
struct Scene {
    tilemesh::scene::Map map;
    tilemesh::splat::Camera camera;
};

inline char const* const scene_names[] = {"sloth", "salad", "playbot_250k", "built_in"};
inline char const* const motion_names[] = {"static", "orbit0.1", "orbit0.5", "orbit2", "teleport", "fr1_xyz", "fr2_desk"};

/// The scene of that name at this size: the authors' benchmark camera for their two maps, `frame_whole` for another file. `data`
/// holds maps/ and cameras.json. Throws Error where a file is bad.
Scene load_scene(std::string const& name, std::filesystem::path const& data, tilemesh::scene::Size size);

/// Is there what this scene, or this motion of a scene, needs? The built-in map and the orbits need no file.
bool has_scene(std::string const& name, std::filesystem::path const& data);
bool has_motion(std::string const& motion, std::filesystem::path const& data);

/// `frames` cameras after the scene's own, which comes first: 1 + frames. `static` has the same camera again; `orbitX` turns X
/// degrees a frame about the middle of the map; `teleport` takes the recorded jumps of the scene where there are some, else
/// multiples of the golden angle on the orbit; `fr1_xyz` and `fr2_desk` are the first poses of a hand-held camera at 31 a second, carried
/// out from the scene's camera.
std::vector<tilemesh::splat::Camera> cameras_of(std::string const& motion, Scene const& scene, std::uint32_t frames,
                                                std::filesystem::path const& data);

} // namespace bench
