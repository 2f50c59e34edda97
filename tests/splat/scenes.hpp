#pragma once
#include "stand_ins.hpp"
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/scene/ply.hpp>

// The real maps; the built-in map if they are missing; or a made map if the environment names one.
namespace support {
using splat::Camera;
using splat::Rules;

struct Scene {
    scene::Map map;
    std::vector<std::pair<std::string, Camera>> cameras;
    /// Does it look like a SLAM map? Only then may a test use a limit that was measured on such maps and does not follow from arithmetic.
    bool like_slam = true;
};
/// Returns Sloth and Salad with every camera of cameras.json, or the built-in map with three cameras of its own. If the environment
/// variable TILEMESH_STAND_IN names a map of stand_ins.hpp, only that map, with three cameras. `Width` is the picture's width for maps that
/// stand in. A test that works at any size renders a quarter of the pixels.
template <std::uint32_t Width = 1280>
std::vector<Scene> const& scenes()
{
    static std::vector<Scene> const all = [] {
        constexpr scene::Size size{Width, Width * 9 / 16};
        std::vector<Scene> out;
        auto const add = [&](scene::Map map, Camera const& first, bool like_slam) {
            auto const orbit = scene::orbit(first, scene::robust_centre(map), 20, 3);
            out.push_back({std::move(map), {}, like_slam});
            for (std::size_t i = 0; i < orbit.size(); ++i) out[0].cameras.emplace_back("orbit" + std::to_string(i), orbit[i]);
        };
        if (char const* const name = std::getenv("TILEMESH_STAND_IN"); name != nullptr && *name != '\0') {
            auto map = stand_in(name);
            auto const camera = scene::frame_whole(map, size);
            add(std::move(map), camera, false);
            return out;
        }
        auto const folder = data();
        if (folder.empty()) {
            MESSAGE("skipped: no real maps (TILEMESH_DATA); the built-in map stands in");
            add(scene::built_in_map(), scene::built_in_camera(size), true);
            return out;
        }
        auto const cameras = scene::load_cameras(folder / "cameras.json");
        for (char const* name : {"sloth", "salad"}) {
            Scene s{scene::load_ply(folder / "maps" / (std::string(name) + ".ply")), {}, true};
            for (auto const& c : scene::select_cameras(cameras, "", name)) s.cameras.emplace_back(c.name, c.camera);
            out.push_back(std::move(s));
        }
        return out;
    }();
    return all;
}

/// The naive picture of a view, computed once.
inline report::Image const& naive(Scene const& s, Camera const& camera)
{
    static std::map<std::pair<void const*, std::string>, report::Image> cache;
    std::string const key(reinterpret_cast<char const*>(&camera), sizeof camera);
    auto const found = cache.find({&s, key});
    if (found != cache.end()) return found->second;
    if (cache.size() > 40) cache.clear();
    return cache[{&s, key}] = report::render_naive(s.map.gaussians, camera, Rules{});
}

/// Calls look(name, gaussians, camera) with the built-in map, and with the front views of Sloth and Salad where they are; 160 x 90 pixels.
template <class Look>
void with_front_views(Look const& look)
{
    look("built-in", scene::built_in_map().gaussians, scene::built_in_camera({160, 90}));
    auto const folder = data();
    if (folder.empty() || !std::filesystem::exists(folder / "cameras.json")) {
        MESSAGE("skipped: Sloth and Salad (TILEMESH_DATA)");
        return;
    }
    for (std::string const name : {"sloth", "salad"}) {
        auto const cameras = scene::select_cameras(scene::load_cameras(folder / "cameras.json"), name + "/front", name);
        look(name, scene::load_ply(folder / "maps" / (name + ".ply")).gaussians, scene::resized(cameras.front().camera, 160, 90));
    }
}

} // namespace support
