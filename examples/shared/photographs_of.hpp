#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/pose.hpp>
#include <vector>

namespace shared {

/// "640 x 360"
inline std::string by(tilemesh::scene::Size size)
{
    return std::to_string(size.width) + " x " + std::to_string(size.height);
}
inline bool same(tilemesh::scene::Size a, tilemesh::scene::Size b)
{
    return a.width == b.width && a.height == b.height;
}

/// The photograph of a camera. An empty path: there is none. `others` are cameras to which the file belongs as well or better. Without
/// others, it is this camera's photograph. With one, it is that camera's. With more, nothing says whose it is.
struct PhotographOf {
    std::filesystem::path path;
    std::vector<std::string> others;

    bool found() const { return !path.empty() && others.empty(); }
    /// Why it is not this camera's: "it is the photograph of "left/1.png"".
    std::string why() const;
};

/// The photographs of `names` below a folder, in this order. A photograph has the camera's name, or this name with the extension of a picture
/// behind it or in place of its own; folders at the beginning of a name may be missing. The camera with the longest common path, then the one
/// with the nearest extension, owns a file. `all` are the names of the whole camera file: a camera that is not chosen owns files too.
/// With `listed`, no other file is looked at.
///
/// Throws `tilemesh::Error` if the folder is no directory, and for a camera with two files that are equally near. Cost: a few system calls for
/// each name and folder in it.
std::vector<PhotographOf> photographs_of(std::filesystem::path const& folder, std::vector<std::string> const& names,
                                         std::vector<std::string> const& all, std::vector<std::filesystem::path> const& listed = {});

/// The camera of each picture by `photographs_of` in the folder of the first one: a place in `names`, or their number for none. Requires a picture.
std::vector<std::size_t> cameras_of(std::vector<std::filesystem::path> const& pictures, std::vector<std::string> const& names);

/// Has a photograph the size of its camera divided by `scale`, rounded up or down? False: it has the camera's own size. Throws
/// `tilemesh::Error` for another size; `what` says what that means: " is not compared".
bool is_reduced(std::filesystem::path const& photograph, tilemesh::scene::Size own, tilemesh::scene::Size camera, std::uint32_t scale,
                std::string const& what);

/// Throws `tilemesh::Error` for a mask that cannot be read, or has neither the size of its photograph nor that of the camera.
void require_mask(std::filesystem::path const& mask, tilemesh::scene::Size photograph, tilemesh::scene::Size camera);

/// "8 of 8 pictures have masks: only what is white in a mask counts"
std::string mask_note(std::size_t masks, std::size_t pictures);

/// Notes how many pictures have an alpha channel, and what that means. Notes how many have an Exif orientation. Cost: 64 KiB of each file are
/// read.
void add_picture_notes(std::vector<std::filesystem::path> const& pictures, char const* meaning, std::vector<std::string>& notes);
inline constexpr char const* shows_background = "transparent pixels show the background: black, or that of --background";

/// Sets each pixel to NaN that a mask does not leave white: it does not count. In another size, a pixel counts if all around it is white. A
/// mask without a path changes nothing. Throws `tilemesh::Error` as `read_picture` does, and for a mask without a white pixel.
void apply_mask(tilemesh::report::Image& picture, std::filesystem::path const& mask);

} // namespace shared
