#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/camera.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

TILEMESH_HOST std::string label(NamedCamera const& camera)
{
    return camera.scene.empty() ? camera.name : camera.scene + "/" + camera.name;
}

TILEMESH_HOST std::vector<NamedCamera> relative_to_origin(std::vector<NamedCamera> cameras, std::array<double, 3> const& origin)
{
    if (origin == std::array<double, 3>{}) return cameras;
    for (auto& each : cameras) {
        glm::dvec3 moved{0.0};
        float(&position)[3] = each.camera.position;
        for (int axis = 0; axis < 3; ++axis) {
            moved[axis] = (each.position ? (*each.position)[axis] : static_cast<double>(position[axis])) - origin[static_cast<std::size_t>(axis)];
            position[axis] = static_cast<float>(moved[axis]);
        }
        each.position = moved;
    }
    return cameras;
}

namespace detail {

TILEMESH_HOST std::string fault_of_projection(std::string const& model)
{
    std::string word;
    for (char const c : model) word += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    auto const has = [&](auto const*... names) { return ((word.find(names) != word.npos) || ...); };
    auto const because = " (its camera model is " + shown(model, 40) + ", and only pinhole cameras are rendered); ";
    if (has("ortho")) return "has an orthographic camera" + because + "name cameras with a perspective";
    if (has("equirect", "spherical", "latlong", "panoram", "omnidirectional", "vr180"))
        return "has an equirectangular camera" + because + "cut its panoramas into pinhole pictures, and name their cameras";
    return "";
}

TILEMESH_HOST void note_ignored_distortion(std::size_t cameras, std::vector<std::string>* notes)
{
    if (cameras != 0 && notes != nullptr)
        notes->push_back(std::to_string(cameras) + (cameras == 1 ? " camera has" : " cameras have") +
                         " a lens with distortion, which is ignored: the picture is a pinhole's");
}

TILEMESH_HOST bool ends_in_0_0_0_1(std::array<double, 16> const& m)
{
    return std::fabs(m[12]) + std::fabs(m[13]) + std::fabs(m[14]) + std::fabs(m[15] - 1.0) <= 1e-6;
}

TILEMESH_HOST std::string list_of(std::vector<std::string> const& names)
{
    constexpr std::size_t most = 20;
    std::string text;
    for (std::size_t i = 0; i < names.size() && i < most; ++i) {
        if (i > 0) text += ", ";
        text += shown(names[i]);
    }
    if (names.size() > most) text.append(" and ").append(std::to_string(names.size() - most)).append(" more");
    return text;
}

} // namespace detail

TILEMESH_HOST std::vector<NamedCamera> select_cameras(std::vector<NamedCamera> const& cameras, std::string const& selector,
                                                      std::string const& map_name)
{
    std::vector<NamedCamera> chosen, of_this_map;
    std::vector<std::string> all;
    for (auto const& camera : cameras) {
        all.push_back(label(camera));
        if (selector == all.back()) return {camera};
        bool const of_map = camera.scene.empty() || camera.scene == map_name ||
                            (!camera.file.empty() &&
                             (camera.file == map_name || std::filesystem::path(camera.file).stem().string() == map_name));
        if (selector.empty() ? of_map : camera.name == selector) {
            chosen.push_back(camera);
            if (of_map) of_this_map.push_back(camera);
        }
    }
    if (of_this_map.size() == 1) return of_this_map;

    if (all.empty()) throw Error("there is no camera to choose (the camera file has none); name a camera file with at least one");
    std::string const choices = "there are " + detail::list_of(all);
    if (chosen.empty() && selector.empty())
        throw Error("no camera belongs to map \"" + detail::shown(map_name) + "\" (" + choices +
                    "); name cameras of this map, or choose one by SCENE/NAME");
    if (chosen.empty())
        throw Error("there is no camera \"" + detail::shown(selector) + "\" (" + choices + "); choose one of these");
    if (!selector.empty() && chosen.size() > 1) {
        std::vector<std::string> same;
        for (auto const& camera : chosen) same.push_back(label(camera));
        throw Error("camera \"" + detail::shown(selector) + "\" is ambiguous (" + detail::list_of(same) +
                    "); write SCENE/NAME");
    }
    return chosen;
}

}}} // namespace tilemesh::scene
