#pragma once
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/named_camera.hpp>

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

TILEMESH_HOST splat::Lens lens_of_values(LensValues const& values, std::string& fault)
{
    auto const is = [&](auto const*... names) { return ((values.model == names) || ...); };
    auto const some = [](auto const& numbers) { return std::any_of(numbers.begin(), numbers.end(), [](double v) { return v != 0.0; }); };
    bool const fisheye =
        values.fisheye || is("opencv_fisheye", "fisheye", "equidistant", "kannala_brandt", "simple_radial_fisheye", "radial_fisheye");
    bool const straight = is("pinhole", "simple_pinhole"), fov = is("fov"), panorama = is("equirectangular");
    bool const plain = straight || is("", "none", "perspective", "simple_radial", "radial", "opencv", "full_opencv", "brown");
    splat::Lens lens{};
    auto const refuse = [&](std::string why) {
        fault = std::move(why);
        return splat::Lens{};
    };
    if (values.odd != 0) return refuse("its lens is told in a form that is not read (coefficients are numbers, or one list of numbers)");
    if (!fisheye && !plain && !fov && !panorama) return refuse("no lens here is its camera model " + shown(values.model, 40));
    std::array<double, 8> k = values.coefficients; // k1 to k6, p1, p2
    bool given = some(k);
    for (std::size_t key = 0; key < values.lists.size(); ++key) {
        auto const& list = values.lists[key];
        if (!some(list)) continue;
        if (given) return refuse("its coefficients are told twice, by k1 to p2 or lists that are not 0");
        given = true;
        constexpr std::size_t opencv[8] = {0, 1, 6, 7, 2, 3, 4, 5}, nerfstudio[6] = {0, 1, 2, 3, 6, 7};
        bool const of_nerfstudio = key == 2;
        if (list.size() > (of_nerfstudio ? 6u : 8u)) return refuse("its list of coefficients has more numbers than are read, and they are not 0");
        for (std::size_t i = 0; i < list.size(); ++i) k[of_nerfstudio ? nerfstudio[i] : fisheye ? i : opencv[i]] = list[i];
    }
    auto const only = [&](std::size_t n) { // the first n may be other than 0
        for (std::size_t i = n; i < k.size(); ++i)
            if (k[i] != 0.0) return false;
        return true;
    };
    if ((straight || panorama) && given && !fisheye)
        return refuse("its camera model is a " + std::string(panorama ? "panorama" : "pinhole") + "'s, and its coefficients are not 0");
    if (fov && (fisheye || !only(1))) return refuse("its lens is FOV, and has more than omega (k1)");
    if (fisheye && !only(4)) return refuse("its lens is a fisheye, and has coefficients that a fisheye has not (k1 to k4)");
    // Some programs mean r^8 by the k4 of a perspective, OpenCV means its denominator.
    if (!fisheye && k[3] != 0.0 && k[4] == 0.0 && k[5] == 0.0 && values.model != "full_opencv")
        return refuse("the k4 of a perspective means two things; write \"camera_model\": \"FULL_OPENCV\" if it is that of OpenCV's denominator");
    using splat::LensKind;
    lens.kind = panorama ? LensKind::equirectangular
                : fov    ? LensKind::fov
                : fisheye ? LensKind::fisheye
                          : given ? LensKind::opencv : LensKind::pinhole;
    for (std::size_t i = 0; i < 6; ++i) lens.k[i] = static_cast<float>(k[i]);
    for (std::size_t i = 0; i < 2; ++i) lens.p[i] = static_cast<float>(k[6 + i]);
    // Coefficients that float rounds to 0 bend nothing.
    auto const none = [](float v) { return v == 0.0f; };
    if (lens.kind == LensKind::opencv && std::all_of(lens.k, lens.k + 6, none) && std::all_of(lens.p, lens.p + 2, none)) return {};
    return lens;
}

TILEMESH_HOST LensValues merged(LensValues own, LensValues const& common)
{
    constexpr std::uint32_t coefficients = 0xfff, model = 1u << 12, fisheye = 1u << 13;
    bool const other = (own.given & (model | fisheye)) != 0 && (own.model != common.model || own.fisheye != common.fisheye);
    if (other) own.given |= coefficients; // those of another model say nothing about this one
    for (std::size_t i = 0; i < own.coefficients.size(); ++i)
        if ((own.given >> i & 1u) == 0) own.coefficients[i] = common.coefficients[i];
    for (std::size_t i = 0; i < own.lists.size(); ++i)
        if ((own.given >> (8 + i) & 1u) == 0) own.lists[i] = common.lists[i];
    if ((own.given & model) == 0) own.model = common.model;
    if ((own.given & fisheye) == 0) own.fisheye = common.fisheye;
    own.odd |= common.odd & ~own.given;
    own.given |= common.given;
    return own;
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
                            (!camera.file.empty() && (camera.file == map_name || std::filesystem::path(camera.file).stem().string() == map_name));
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
    if (chosen.empty()) throw Error("there is no camera \"" + detail::shown(selector) + "\" (" + choices + "); choose one of these");
    if (!selector.empty() && chosen.size() > 1) {
        std::vector<std::string> same;
        for (auto const& camera : chosen) same.push_back(label(camera));
        throw Error("camera \"" + detail::shown(selector) + "\" is ambiguous (" + detail::list_of(same) + "); write SCENE/NAME");
    }
    return chosen;
}

}}} // namespace tilemesh::scene
