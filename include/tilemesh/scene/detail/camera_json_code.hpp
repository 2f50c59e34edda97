#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>
#include <string_view>
#include <system_error>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/detail/camera_list.hpp>
#include <tilemesh/scene/detail/picture_size.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace scene {

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
        notes->push_back("no file of the folder " + shown_path(masks) + " is the mask of a camera (a mask is NAME.png, as " + cameras.front().name +
                         ".png)");
    return cameras;
}

} // namespace detail

TILEMESH_HOST std::filesystem::path found_cameras(std::filesystem::path const& path)
{
    std::error_code ignored;
    if (!std::filesystem::is_directory(path, ignored)) return path;
    for (char const* const below : {"", "sparse/0", "sparse", "colmap/sparse/0"}) {
        auto const model = *below == '\0' ? path : path / below;
        if (std::filesystem::exists(colmap_files(model).cameras, ignored)) return model;
    }
    return std::filesystem::exists(path / "transforms.json", ignored) ? path / "transforms.json" : path;
}

TILEMESH_HOST std::vector<NamedCamera> read_cameras_json(std::istream& stream, std::string const& name, std::vector<std::string>* notes,
                                                         DistortedLens distorted, PictureSizeOf const& size_of)
{
    return detail::CameraJson(stream, name, distorted, size_of).read(notes);
}

TILEMESH_HOST std::vector<NamedCamera> load_cameras(std::filesystem::path const& path, std::vector<std::string>* notes, DistortedLens distorted,
                                                    std::optional<Size> size, std::vector<std::filesystem::path>* pictures)
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

}}} // namespace tilemesh::v0_2::scene
