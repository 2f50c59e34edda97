#pragma once
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <istream>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <tilemesh/scene/colmap.hpp>
#include <tilemesh/scene/detail/camera_list.hpp>
#include <tilemesh/scene/detail/picture_size.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/detail/transforms_json.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// The size of the picture of a frame of a transforms.json, from its `file_path`; nothing if it is not known.
using detail::PictureSizeOf;

namespace detail {

/// The picture of a frame beside its file: `file_path` as it is, or without its extension, as Blender writes it; else `otherwise`.
/// `pictures`, which may be null, gets the files whose sizes are used.
inline PictureSizeOf sizes_beside(std::filesystem::path const& file, std::optional<Size> otherwise, std::vector<std::filesystem::path>* pictures)
{
    return [folder = file.parent_path(), otherwise, pictures](std::string const& name) {
        for (char const* extension : {"", ".png", ".jpg", ".jpeg", ".PNG", ".JPG", ".JPEG"}) {
            auto picture = folder / (name + extension);
            auto const size = size_of_picture_file(picture);
            if (!size) continue;
            if (pictures != nullptr) pictures->push_back(std::move(picture));
            return std::optional(*size);
        }
        return otherwise;
    };
}

/// Is the first character after a byte order mark and blanks an opening bracket?
inline bool begins_as_json(std::istream& stream)
{
    for (char c = '\0'; stream.get(c);)
        if (std::string_view(" \t\r\n\xef\xbb\xbf").find(c) == std::string_view::npos) return c == '{' || c == '[';
    return false;
}

/// The cameras of a COLMAP model, with the masks of its project. `notes`, which may be null, gets a line if there is a folder of masks and none
/// is a camera's.
inline std::vector<NamedCamera> with_masks(std::vector<NamedCamera> cameras, std::filesystem::path const& model, std::vector<std::string>* notes)
{
    std::error_code ignored;
    auto folder = std::filesystem::absolute(model, ignored).lexically_normal();
    if (!folder.has_filename() || !std::filesystem::is_directory(folder, ignored)) folder = folder.parent_path(); // a slash at the end, or a file
    for (int up = 0; up < 3 && !std::filesystem::is_directory(folder / "masks", ignored); ++up) folder = folder.parent_path();
    auto const masks = folder / "masks";
    if (!std::filesystem::is_directory(masks, ignored)) return cameras;
    for (auto& camera : cameras) {
        auto const name = std::filesystem::path(camera.name).lexically_normal();
        if (name.empty() || name.is_absolute() || *name.begin() == "..") continue; // no file below masks/
        for (auto const* const extension : {".png", ".PNG"})
            for (auto const& file : {masks / (camera.name + extension), (masks / camera.name).replace_extension(extension)})
                if (camera.mask.empty() && std::filesystem::is_regular_file(file, ignored)) camera.mask = file.string();
    }
    if (notes != nullptr && !cameras.empty() && std::all_of(cameras.begin(), cameras.end(), [](auto const& camera) { return camera.mask.empty(); }))
        notes->push_back("no file of the folder " + shown_path(masks) + " is the mask of a camera (a mask is NAME.png, as " +
                         cameras.front().name + ".png)");
    return cameras;
}

} // namespace detail

/// Where the cameras of a project's folder are: in the folder, or in sparse/0, sparse, colmap/sparse/0 or transforms.json below it. Any
/// other path is returned as it is.
inline std::filesystem::path found_cameras(std::filesystem::path const& path)
{
    std::error_code ignored;
    if (!std::filesystem::is_directory(path, ignored)) return path;
    for (char const* const below : {"", "sparse/0", "sparse", "colmap/sparse/0"}) {
        auto const model = *below == '\0' ? path : path / below;
        if (std::filesystem::exists(colmap_files(model).cameras, ignored)) return model;
    }
    return std::filesystem::exists(path / "transforms.json", ignored) ? path / "transforms.json" : path;
}

/// Reads cameras in JSON. They follow the OpenCV convention; pixel (i, j) has its centre at (i + 0.5, j + 0.5). The content tells which of
/// three forms a file has:
/// - the form of this library: `cameras[]` with name, width, height, fx, fy, cx, cy, `world_to_camera` (4x4, row-major), and optionally
///   scene,
/// file and near (default 0.2);
/// - the cameras.json that 3DGS training writes: a list of img_name, width, height, fx, fy, `position`, `rotation` (3x3, camera to world)
///   and
/// id. The principal point is the middle of the picture, there is no scene, and near is 0.2. The camera's name is img_name, or
/// "img_name#id" if several cameras share an img_name;
/// - the transforms.json of nerfstudio, instant-ngp and Blender's NeRF scenes: `frames[]`, each with file_path and `transform_matrix` (4x4,
///   row-major, camera to world; the camera looks along -z, with y up). The lens stands in the frame or beside `frames`: w, h, fl_x, fl_y
///   (default fl_x), cx, cy (default the middle), or the fields of view camera_angle_x and camera_angle_y, in radians. Blender's files have
///   no w and h: `size_of(file_path)`, if it is given, says the size of the picture. `mask` is mask_path (null: none), and `split`
///   follows from the lists train_filenames, test_filenames and val_filenames. The camera's name is
///   file_path without a leading "./" and with "/" for "\\", there is no scene, and near is 0.2. The world is that of the file; `applied_transform`
///   is not undone.
///
/// If `notes` is not null, it gets one line for each key that the reader does not read, with the number of cameras that have the key. If
/// there are more than eight such keys, it gets the first eight. Keys beside frames[] of a transforms.json are named too, except those
/// that say nothing about the cameras.
///
/// Throws `Error`, one line that names file and camera, for a lens that is kept and there is not, whose coefficients are told twice or whose k4 may
/// mean two things, or that folds within the picture; if lenses are refused, for a lens with distortion (k1 to k6, p1, p2, `distortion` or a list of
/// coefficients that is not 0; a `camera_model` other than a pinhole; in transforms.json, OPENCV with coefficients of 0 is a pinhole) and
/// for a camera that cannot be used: a number that is missing or not finite, a side outside 1..65535, a focal length below a thousandth of the side
/// or above 2^24 pixels, focal lengths and a principal point that are all below 2 pixels (normalised), a near plane that is not positive, a
/// rotation that is mirrored or not orthonormal within 1e-3, two cameras with one label,
/// more than 2^20 cameras. An empty list is valid and gives no camera.
///
/// Cost: one pass over the text, and n log n in the number of cameras. It builds no JSON document. Memory: 64 KiB, and at most 24 bytes per
/// byte of the text.
inline std::vector<NamedCamera> read_cameras_json(std::istream& stream, std::string const& name, std::vector<std::string>* notes = nullptr,
                                                  DistortedLens distorted = DistortedLens::kept,
                                                  PictureSizeOf const& size_of = {})
{
    return detail::CameraJson(stream, name, distorted, size_of).read(notes);
}

/// Reads a camera file. The content tells its kind: JSON as for `read_cameras_json`, or a COLMAP model, text or binary, as for
/// `load_colmap`. For a COLMAP model, `path` is its folder, or one of its files. Throws `Error` as these functions do, and also for a path
/// that is not a regular file and for JSON of more than 256 MiB. `notes`: as for `read_cameras_json`.
///
/// A folder without a model stands for what is below it: sparse/0, sparse, colmap/sparse/0 or transforms.json (`found_cameras`); a note
/// says so. The masks of a transforms.json begin at its folder. Those of a COLMAP model are the files NAME.png, or NAME with the extension
/// .png, in the folder `masks` beside or above the model, up to three folders up.
///
/// A camera of a transforms.json without w and h has the size that the header of its picture says: the PNG or JPEG `file_path`, or
/// `file_path` with .png, .jpg or .jpeg, in the folder of the file. Without such a picture it has `size`. Without both, it is refused.
/// `pictures`, if it is not null, gets these pictures: a program that writes files must not write over them.
///
/// A lens with distortion is kept (`splat::Camera::lens`); with `DistortedLens::ignored` it is taken for a pinhole, and a note counts such
/// cameras; with `refused` it is an error.
inline std::vector<NamedCamera> load_cameras(std::filesystem::path const& path, std::vector<std::string>* notes = nullptr,
                                             DistortedLens distorted = DistortedLens::kept, std::optional<Size> size = {},
                                             std::vector<std::filesystem::path>* pictures = nullptr)
{
    std::error_code ignored;
    if (auto const found = found_cameras(path); found != path) {
        if (notes != nullptr) notes->push_back("the cameras are those of " + detail::shown_path(found));
        return load_cameras(found, notes, distorted, size, pictures);
    }
    bool const binary = names_colmap(path) && path.extension() == ".bin"; // its first byte may be any, also a bracket
    if (binary || std::filesystem::is_directory(path, ignored)) return detail::with_masks(load_colmap(path, distorted, notes), path, notes);

    if (names_colmap(path)) {
        auto stream = detail::open_file(path, std::numeric_limits<std::uint64_t>::max(), "a camera file");
        if (!detail::begins_as_json(stream)) return detail::with_masks(load_colmap(path, distorted, notes), path, notes);
    }
    // 256 MiB: a camera takes about 500 bytes, so this is half a million cameras.
    auto stream = detail::open_file(path, std::uint64_t{256} << 20, "a camera file");
    auto cameras = read_cameras_json(stream, detail::shown_path(path), notes, distorted, detail::sizes_beside(path, size, pictures));
    for (auto& camera : cameras)
        if (!camera.mask.empty()) camera.mask = (path.parent_path() / camera.mask).string();
    return cameras;
}

}}} // namespace tilemesh::scene
