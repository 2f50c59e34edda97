#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/camera.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// A camera of a camera file. `file` is the map for which it was made; it may be empty. `scene` may be empty too; then the camera belongs
/// to every map.
struct NamedCamera {
    std::string scene, file, name;
    splat::Camera camera;
};

/// The near plane of cameras whose file names none, in world units. It is the near plane of the 3DGS rasteriser.
inline constexpr float default_near = 0.2f;

/// What a reader does with a camera whose lens bends the picture: it throws `Error`, or it takes the lens for a pinhole of the same focal
/// lengths and notes how many cameras it did that to.
enum class DistortedLens { refused, ignored };

/// The name by which a camera is shown and selected: "SCENE/NAME", or NAME if there is no scene.
inline std::string label(NamedCamera const& camera)
{
    return camera.scene.empty() ? camera.name : camera.scene + "/" + camera.name;
}

namespace detail {

/// Notes that the distortion of `cameras` lenses is ignored, if there are any. `notes` may be null.
inline void note_ignored_distortion(std::size_t cameras, std::vector<std::string>* notes)
{
    if (cameras != 0 && notes != nullptr)
        notes->push_back(std::to_string(cameras) + (cameras == 1 ? " camera has" : " cameras have") +
                         " a lens with distortion, which is ignored: the picture is a pinhole's");
}

/// Is the last row of a 4x4 pose, of which `m` has the 16 numbers row by row, 0 0 0 1? A millionth off in all: numbers in a text of six
/// decimals.
inline bool ends_in_0_0_0_1(std::array<double, 16> const& m)
{
    return std::fabs(m[12]) + std::fabs(m[13]) + std::fabs(m[14]) + std::fabs(m[15] - 1.0) <= 1e-6;
}

/// Says why a matrix of finite numbers is no rotation; empty if it is one.
inline std::string fault_of_rotation(glm::dmat3 const& rotation)
{
    glm::dmat3 const square = glm::transpose(rotation) * rotation;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            if (!(std::fabs(square[column][row] - (row == column ? 1.0 : 0.0)) <= 1e-3))
                return "its rotation is not orthonormal within 1e-3";
    if (!(glm::determinant(rotation) > 0.0)) return "its rotation is mirrored, the determinant is -1";
    return "";
}

/// Says why no camera with this pose and lens can be rendered; empty if it can be rendered. Requires finite numbers and sides from 1 to
/// 65535.
inline std::string fault_of(Pose const& pose, Intrinsics const& lens)
{
    if (auto why = fault_of_rotation(pose.rotation); !why.empty()) return why;
    // 2^24 pixels: there one step of a direction in float, 2^-24, is as wide as a pixel, and neighbouring pixel coordinates begin to
    // coincide. A thousandth of a side: the picture spans 179.8 degrees.
    constexpr double most_px = 16777216.0, least_share = 1e-3;
    struct Axis {
        char const *focal_name, *centre_name;
        double focal, centre, side;
    };
    for (auto const& [focal_name, centre_name, focal, centre, side] :
         {Axis{"fx", "cx", lens.fx, lens.cx, static_cast<double>(lens.width)},
          Axis{"fy", "cy", lens.fy, lens.cy, static_cast<double>(lens.height)}}) {
        std::string const f = focal_name;
        if (!(focal > 0.0)) return f + " is not positive";
        if (!(focal >= least_share * side)) return f + " is below a thousandth of the picture's side";
        if (!(focal <= most_px)) return f + " is above 2^24 pixels";
        if (!(std::fabs(centre) <= most_px)) return std::string(centre_name) + " is more than 2^24 pixels away";
    }
    if (!(lens.near_depth > 0.0f)) return "near is not positive";
    return "";
}

/// The names in one line, separated by commas. It shows at most the first twenty and counts the rest.
inline std::string list_of(std::vector<std::string> const& names)
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

/// Returns the cameras that `selector` selects. A selector is a label, or a NAME that only one camera of the file, or only one of the map's
/// own cameras, has. An empty selector selects every camera of the map: the cameras without a scene, those whose scene is `map_name`, and
/// those whose file is `map_name`, with or without its extension. The result is never empty: if no camera fits or a name is ambiguous, it
/// throws an `Error` that lists the choices.
inline std::vector<NamedCamera> select_cameras(std::vector<NamedCamera> const& cameras, std::string const& selector,
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

    std::string const choices = all.empty() ? "the camera file is empty" : "there are " + detail::list_of(all);
    if (chosen.empty() && selector.empty())
        throw Error("no camera belongs to map \"" + detail::shown(map_name) + "\" (" + choices +
                    "); choose one by SCENE/NAME");
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
