#pragma once
#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <tilemesh/report/json_text.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/lens.hpp>
#include <vector>

namespace shared {

/// A camera whose pose a program found.
struct FoundCamera {
    std::string name; ///< of its picture, as a list or a folder of pictures has it
    tilemesh::scene::Pose pose;
};

/// A file of cameras in the library's own form (scene/camera_json.hpp), a camera a line. Every program reads it as --cameras. The second camera
/// of a picture has "#2" behind its name.
inline std::string camera_file_text(std::vector<FoundCamera> const& cameras, tilemesh::scene::Intrinsics const& lens)
{
    using tilemesh::splat::LensKind;
    std::string text = "{\"cameras\": [";
    std::map<std::string, std::size_t> seen;
    for (auto const& camera : cameras) {
        auto const times = ++seen[camera.name];
        auto const& rotation = camera.pose.rotation;
        auto const moved = -(rotation * camera.pose.position);
        std::array<double, 16> to_camera{};
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 4; ++column)
                to_camera[static_cast<std::size_t>(4 * row + column)] = column == 3 ? moved[row] : rotation[column][row];
        to_camera[15] = 1;
        text += (text.ends_with('[') ? "\n " : ",\n ") + tilemesh::report::json_line([&](auto& json) {
                    json.member("name", times == 1 ? camera.name : camera.name + "#" + std::to_string(times));
                    json.member("width", lens.width);
                    json.member("height", lens.height);
                    json.member("fx", lens.fx);
                    json.member("fy", lens.fy);
                    json.member("cx", lens.cx);
                    json.member("cy", lens.cy);
                    json.member("near", double{lens.near_depth});
                    if (auto const& bend = lens.bend; bend.kind != LensKind::pinhole) {
                        json.member("camera_model", bend.kind == LensKind::opencv ? "FULL_OPENCV" : bend.kind == LensKind::fov ? "FOV" : "OPENCV_FISHEYE");
                        for (std::size_t i = 0; i < (bend.kind == LensKind::opencv ? 6u : bend.kind == LensKind::fov ? 1u : 4u); ++i)
                            json.member("k" + std::to_string(i + 1), double{bend.k[i]});
                        for (std::size_t i = 0; i < 2 && bend.kind == LensKind::opencv; ++i) json.member("p" + std::to_string(i + 1), double{bend.p[i]});
                    }
                    json.member_as_is("world_to_camera", tilemesh::report::matrix_text(to_camera));
                });
    }
    return text + "\n]}\n";
}

} // namespace shared
