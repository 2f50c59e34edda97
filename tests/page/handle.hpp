#pragma once
#include "../../examples/c/tilemesh.h"
#include "../standard.hpp"
#include <nlohmann/json.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/camera.hpp>

namespace page_test {

namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;
using Json = nlohmann::ordered_json;

/// A handle that frees itself.
struct Handle {
    tilemesh_handle* at = tilemesh_create();
    Handle() = default;
    explicit Handle(Json const& settings) { REQUIRE_MESSAGE(set(settings), error()); }
    Handle(Handle const&) = delete;
    Handle& operator=(Handle const&) = delete;
    ~Handle() { tilemesh_destroy(at); }

    std::string error() const { return tilemesh_error(at); }
    bool set(Json const& json) const { return tilemesh_set(at, json.dump().c_str()) != 0; }
    bool render(std::vector<double> const& camera) const { return tilemesh_render(at, camera.data()) != 0; }
    Json parsed(char const* text) const
    {
        REQUIRE_MESSAGE(text != nullptr, error());
        return Json::parse(text);
    }
    Json report(char const* what) const { return parsed(tilemesh_report(at, what)); }
    Json tile(std::uint32_t t) const { return parsed(tilemesh_tile(at, t)); }
    Json gaussian(std::uint32_t id) const { return parsed(tilemesh_gaussian(at, id)); }
    bool load(std::string const& name, std::string const& bytes) const { return tilemesh_load(at, name.c_str(), bytes.data(), bytes.size()) != 0; }
    std::vector<float> heat(char const* what, int superstep = -1) const
    {
        auto const frame = report("frame");
        auto const* const values = tilemesh_heat(at, what, superstep);
        REQUIRE_MESSAGE(values != nullptr, error());
        return {values, values + frame["columns"].get<std::size_t>() * frame["rows"].get<std::size_t>()};
    }
};

inline std::vector<double> numbers(splat::Camera const& c)
{
    std::vector<double> out;
    for (auto const& row : c.rotation) out.insert(out.end(), row, row + 3);
    out.insert(out.end(), c.position, c.position + 3);
    for (float const v : {c.fx, c.fy, c.cx, c.cy, c.near_depth}) out.push_back(double{v});
    return out;
}
inline std::vector<splat::Camera> turn(scene::Map const& map, std::uint32_t frames, scene::Size size = {320, 180})
{
    return scene::orbit(scene::built_in_camera(size), scene::robust_centre(map), 0.5, frames);
}
inline bool is_one_line(std::string const& text)
{
    return !text.empty() && text.find('\n') == text.npos && text.find("; ") != text.npos && text.find('(') != text.npos;
}

/// A PLY of doubles: Gaussians at these places, round and nearly opaque.
inline std::string ply(std::vector<std::array<double, 3>> const& means)
{
    std::ostringstream text;
    text.precision(17);
    text << "ply\nformat ascii 1.0\nelement vertex " << means.size() << "\n";
    for (char const* name :
         {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
        text << "property double " << name << "\n";
    text << "end_header\n";
    for (auto const& m : means) text << m[0] << " " << m[1] << " " << m[2] << " 1 0.5 0.2 3 -2 -2 -2 1 0 0 0\n";
    return text.str();
}
/// What a call gave back, 0 or nullptr, refuses it, and its error is one line.
template <class Result>
void refused(Handle const& handle, Result result)
{
    CHECK(!result);
    CHECK_MESSAGE(is_one_line(handle.error()), handle.error());
}

} // namespace page_test
