#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/camera.hpp>
#include <vector>

namespace tilemesh::scene {

/// A camera of a camera file: "scene/name" names it; `file` is the map it was made for, and may be
/// empty.
struct NamedCamera {
    std::string scene, file, name;
    splat::Camera camera;
};

namespace detail {

/// One entry of `cameras[]`, with the words that name it in an error.
class CameraEntry {
public:
    CameraEntry(nlohmann::json const& entry, std::string name)
        : entry_(entry), name_(std::move(name))
    {
        if (!entry_.is_object()) refuse("it is not an object");
    }

    void rename(std::string name) { name_ = std::move(name); }

    [[noreturn]] void refuse(std::string const& why) const
    {
        throw Error(name_ + " is not usable (" + why + "); correct the camera file");
    }

    std::string text(char const* key) const
    {
        auto const found = entry_.find(key);
        if (found == entry_.end()) refuse(std::string("it has no \"") + key + "\"");
        if (!found->is_string()) refuse(std::string("\"") + key + "\" is not a string");
        return found->get<std::string>();
    }

    bool has(char const* key) const { return entry_.contains(key); }

    double number(char const* key) const
    {
        auto const found = entry_.find(key);
        if (found == entry_.end()) refuse(std::string("it has no \"") + key + "\"");
        return finite(*found, key);
    }

    double positive(char const* key) const
    {
        double const value = number(key);
        if (!(static_cast<float>(value) > 0.0f))
            refuse(std::string("\"") + key + "\" is not positive");
        return value;
    }

    std::uint32_t pixels(char const* key) const
    {
        double const value = number(key);
        if (!(value >= 1.0 && value <= 65535.0) || value != std::floor(value))
            refuse(std::string("\"") + key + "\" is not a whole number from 1 to 65535");
        return static_cast<std::uint32_t>(value);
    }

    /// World to camera, four rows: the camera centre is -R^-1 t, so that R (p - c) = R p + t for
    /// this very R.
    Pose pose(char const* key) const
    {
        auto const found = entry_.find(key);
        if (found == entry_.end()) refuse(std::string("it has no \"") + key + "\"");
        if (!found->is_array() || found->size() != 4)
            refuse(std::string("\"") + key + "\" is not a 4x4 matrix");
        double m[4][4];
        for (std::size_t row = 0; row < 4; ++row) {
            auto const& line = (*found)[row];
            if (!line.is_array() || line.size() != 4)
                refuse(std::string("\"") + key + "\" is not a 4x4 matrix");
            for (std::size_t column = 0; column < 4; ++column)
                m[row][column] = finite(line[column], key);
        }
        if (std::fabs(m[3][0]) + std::fabs(m[3][1]) + std::fabs(m[3][2]) +
                std::fabs(m[3][3] - 1.0) >
            1e-6)
            refuse(std::string("the last row of \"") + key + "\" is not 0 0 0 1");

        Pose pose;
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column) pose.rotation[column][row] = m[row][column];
        glm::dmat3 const square = glm::transpose(pose.rotation) * pose.rotation;
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column)
                if (!(std::fabs(square[column][row] - (row == column ? 1.0 : 0.0)) <= 1e-3))
                    refuse(std::string("the rotation in \"") + key +
                           "\" is not orthonormal within 1e-3");
        if (glm::determinant(pose.rotation) < 0.0)
            refuse(std::string("the rotation in \"") + key +
                   "\" is mirrored, its determinant is -1");
        pose.position = -(glm::inverse(pose.rotation) * glm::dvec3{m[0][3], m[1][3], m[2][3]});
        return pose;
    }

private:
    // A tenth of the largest float: R^-1 t stays finite when rounded.
    double finite(nlohmann::json const& value, char const* key) const
    {
        if (!value.is_number() || !(std::fabs(value.get<double>()) <= 1e37))
            refuse(std::string("\"") + key + "\" is not a finite number");
        return value.get<double>();
    }

    nlohmann::json const& entry_;
    std::string name_;
};

inline std::string join(std::vector<std::string> const& words)
{
    std::string text;
    for (auto const& word : words) text += (text.empty() ? "" : ", ") + word;
    return text;
}

} // namespace detail

/// Reads a camera file: JSON, `cameras[]` with scene, name, width, height, fx, fy, cx, cy,
/// `world_to_camera` (4x4, rows first), and optionally file and near (0.2). OpenCV convention,
/// pixel (i, j) centred at (i + 0.5, j + 0.5).
///
/// Throws `Error`, one line that names file and camera, for what cannot be read: a number that is
/// missing or not finite, a side outside 1..65535, a focal length or near plane that is not
/// positive, a rotation that is not orthonormal within 1e-3 or is mirrored, two cameras of one
/// name. An empty list is fine and gives no camera.
inline std::vector<NamedCamera> load_cameras(std::filesystem::path const& path)
{
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored))
        throw Error(path.string() + " cannot be read (it is a directory); name a camera file");
    std::ifstream stream(path, std::ios::binary);
    if (!stream)
        throw Error(path.string() +
                    " cannot be opened (no such file, or no permission); check the path");

    nlohmann::json file;
    try {
        file = nlohmann::json::parse(stream);
    } catch (nlohmann::json::exception const& broken) {
        throw Error(path.string() + " is not JSON (" + broken.what() + "); name a camera file");
    }
    if (!file.is_object() || !file.contains("cameras") || !file["cameras"].is_array())
        throw Error(path.string() +
                    " is not a camera file (there is no list \"cameras\" in it); name a "
                    "JSON file with cameras[]");

    std::vector<NamedCamera> cameras;
    for (auto const& json : file["cameras"]) {
        std::string const where = path.string() + " camera ";
        detail::CameraEntry entry(json, where + std::to_string(cameras.size() + 1));
        NamedCamera named{entry.text("scene"),
                          entry.has("file") ? entry.text("file") : "",
                          entry.text("name"),
                          {}};
        entry.rename(where + named.scene + "/" + named.name);
        if (std::any_of(cameras.begin(), cameras.end(), [&](NamedCamera const& other) {
                return other.scene == named.scene && other.name == named.name;
            }))
            entry.refuse("another camera has the same scene and name");
        named.camera = make_camera(
            entry.pose("world_to_camera"),
            {entry.positive("fx"), entry.positive("fy"), entry.number("cx"), entry.number("cy"),
             entry.has("near") ? static_cast<float>(entry.positive("near")) : 0.2f,
             entry.pixels("width"), entry.pixels("height")});
        cameras.push_back(std::move(named));
    }
    return cameras;
}

/// The cameras that `selector` means: "SCENE/NAME", or "NAME" where only one camera of the file, or
/// only one of the map's own scene, has it. An empty selector means every camera whose scene is `map_name` or whose file is `map_name`,
/// with its extension or without. Never empty: throws `Error` that lists the choices where nothing
/// fits or a name is ambiguous.
inline std::vector<NamedCamera> select_cameras(std::vector<NamedCamera> const& cameras,
                                               std::string const& selector,
                                               std::string const& map_name)
{
    std::vector<NamedCamera> chosen, of_this_map;
    std::vector<std::string> all;
    for (auto const& camera : cameras) {
        all.push_back(camera.scene + "/" + camera.name);
        if (selector == all.back()) return {camera};
        bool const of_map = camera.scene == map_name ||
                            (!camera.file.empty() &&
                             (camera.file == map_name ||
                              std::filesystem::path(camera.file).stem().string() == map_name));
        if (selector.empty() ? of_map : camera.name == selector) {
            chosen.push_back(camera);
            if (of_map) of_this_map.push_back(camera);
        }
    }
    if (of_this_map.size() == 1) return of_this_map;

    std::string const choices =
        all.empty() ? "the camera file is empty" : "there are " + detail::join(all);
    if (chosen.empty() && selector.empty())
        throw Error("no camera belongs to map \"" + map_name + "\" (" + choices +
                    "); choose one by SCENE/NAME");
    if (chosen.empty())
        throw Error("there is no camera \"" + selector + "\" (" + choices +
                    "); choose one of these");
    if (!selector.empty() && chosen.size() > 1) {
        std::vector<std::string> same;
        for (auto const& camera : chosen) same.push_back(camera.scene + "/" + camera.name);
        throw Error("camera \"" + selector + "\" is ambiguous (" + detail::join(same) +
                    "); write SCENE/NAME");
    }
    return chosen;
}

} // namespace tilemesh::scene
