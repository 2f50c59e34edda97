#pragma once
#include "support.hpp"
#include <doctest/doctest.h>
#include <map>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/scene/ply.hpp>

// The real maps, and the built-in one where they are absent.
namespace support {
using splat::Camera;
using splat::Model;

struct Scene {
    scene::Map map;
    std::vector<std::pair<std::string, Camera>> cameras;
};
/// Sloth and Salad with every camera of cameras.json, or the built-in map with three cameras of its own.
inline std::vector<Scene> const& scenes()
{
    static std::vector<Scene> const all = [] {
        std::vector<Scene> out;
        auto const folder = data();
        if (folder.empty()) {
            MESSAGE("skipped: no real maps (TILEMESH_DATA); the built-in map stands in");
            out.push_back({scene::built_in_map(), {}});
            auto const camera = scene::built_in_camera({1280, 720});
            auto const orbit = scene::orbit(camera, scene::robust_centre(out[0].map), 20, 3);
            for (std::size_t i = 0; i < orbit.size(); ++i) out[0].cameras.emplace_back("orbit" + std::to_string(i), orbit[i]);
            return out;
        }
        auto const cameras = scene::load_cameras(folder / "cameras.json");
        for (char const* name : {"sloth", "salad"}) {
            Scene s{scene::load_ply(folder / "maps" / (std::string(name) + ".ply")), {}};
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
    return cache[{&s, key}] = report::render_naive(s.map.gaussians, camera, Model{});
}

} // namespace support
