#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <istream>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

namespace detail {

/// A limit for cameras and images that no reconstruction reaches. It bounds the memory: about 500 MB, plus long names.
inline constexpr std::size_t most_colmap_entries = 1u << 20;

/// Takes the next word off `text` as a number within `largest_number`; false if it is not such a number.
inline bool take_number(std::string_view& text, double& value)
{
    return parse_number(take_word(text), value) && std::fabs(value) <= largest_number;
}

/// Reads the lenses of cameras.txt by CAMERA_ID. A line is `CAMERA_ID MODEL WIDTH HEIGHT PARAMS...`; `#` begins a comment.
inline std::map<std::uint32_t, Intrinsics> read_colmap_lenses(std::istream& stream, std::string const& name)
{
    static constexpr std::array<std::string_view, 9> distorted{
        "SIMPLE_RADIAL",         "RADIAL",         "OPENCV",
        "OPENCV_FISHEYE",        "FULL_OPENCV",    "FOV",
        "SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE", "THIN_PRISM_FISHEYE"};
    std::map<std::uint32_t, Intrinsics> lenses;
    LineReader lines(stream, name);
    auto const refuse = [&](std::string const& why) {
        throw Error(lines.place() + " is no camera (" + why + "); correct it or export the model again");
    };
    while (lines.next()) {
        std::string_view text = lines.text();
        std::string_view const id_word = take_word(text);
        if (id_word.empty() || id_word.front() == '#') continue;
        std::uint32_t id = 0;
        if (!parse_number(id_word, id)) refuse("CAMERA_ID is not a whole number");

        std::string_view const model = take_word(text);
        if (std::find(distorted.begin(), distorted.end(), model) != distorted.end())
            throw Error(lines.place() + " has a lens with distortion (" + std::string(model) +
                        "; a pinhole camera has none); run colmap image_undistorter, and name the model that it writes");
        bool const simple = model == "SIMPLE_PINHOLE";
        if (!simple && model != "PINHOLE")
            throw Error(
                lines.place() + " has a camera model that is not known (\"" + shown(model, 40) +
                "\"; PINHOLE and SIMPLE_PINHOLE are); run colmap image_undistorter, and name the model that it writes");

        Intrinsics lens{};
        lens.near_depth = default_near;
        for (auto* side : {&lens.width, &lens.height})
            if (!parse_number(take_word(text), *side) || *side < 1 || *side > 65535)
                refuse(std::string(side == &lens.width ? "WIDTH" : "HEIGHT") + " is not a whole number from 1 to 65535");
        bool complete = take_number(text, lens.fx);
        if (simple) lens.fy = lens.fx;
        else complete = complete && take_number(text, lens.fy);
        complete = complete && take_number(text, lens.cx) && take_number(text, lens.cy);
        if (!complete || !take_word(text).empty())
            refuse(std::string(model) + " takes " + (simple ? "f cx cy" : "fx fy cx cy") + ", finite numbers");
        if (auto const why = fault_of({}, lens); !why.empty()) refuse(why);
        if (!lenses.emplace(id, lens).second) refuse("another camera has CAMERA_ID " + std::to_string(id));
        if (lenses.size() > most_colmap_entries) refuse("it is one camera more than 1048576");
    }
    return lenses;
}

/// Skips the line of 2-D points that follows an image: triples of two numbers and an integer, of any length; at the end of the file the
/// line may be missing. Returns false for any other line, such as the next image.
inline bool skip_colmap_points(LineReader& lines)
{
    std::uint64_t words = 0;
    bool in_word = false;
    while (lines.next_part()) {
        for (char const c : lines.text()) {
            bool const blank = blanks.find(c) != std::string_view::npos;
            // The letters are those of nan and inf.
            if (!blank && std::string_view("0123456789+-.eEnaif").find(c) == std::string_view::npos) return false;
            if (!blank && !in_word) ++words;
            if (!blank && words % 3 == 0 && std::string_view("0123456789+-").find(c) == std::string_view::npos) return false;
            in_word = !blank;
        }
        if (lines.whole()) break;
    }
    return words % 3 == 0;
}

} // namespace detail

/// Reads the text model of COLMAP: the lenses of cameras.txt (SIMPLE_PINHOLE and PINHOLE) and the poses of images.txt. An image takes two
/// lines in images.txt. The first is `IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME`, world to camera. The second lists the image's 2-D
/// points; it is skipped; it may be empty but must exist, except at the end of the file. NAME is the rest of its line, including blanks. COLMAP's pixel (0, 0) has its
/// centre at (0.5, 0.5), as in this library. The cameras have no scene; near is 0.2.
///
/// Throws `Error`, one line that names file and line, for a lens with distortion, a CAMERA_ID that cameras.txt does not have, a NAME that
/// occurs twice or is not UTF-8, and numbers that are missing, not finite or not valid for a camera. `cameras_name` and `images_name` are
/// the files' names in errors. Cost: one pass over each file; memory for the cameras only.
inline std::vector<NamedCamera> read_colmap(std::istream& cameras_txt, std::istream& images_txt,
                                            std::string const& cameras_name = "cameras.txt",
                                            std::string const& images_name = "images.txt")
{
    auto const lenses = detail::read_colmap_lenses(cameras_txt, cameras_name);
    std::vector<NamedCamera> cameras;
    std::set<std::string> names; // not a hash table: an attacker could choose names that collide
    detail::LineReader lines(images_txt, images_name);
    auto const refuse = [&](std::string const& why) {
        throw Error(lines.place() + " is no image (" + why + "); correct it or export the model again");
    };
    while (lines.next()) {
        std::string_view text = lines.text();
        std::string_view const id_word = detail::take_word(text);
        if (id_word.empty() || id_word.front() == '#') continue;
        std::uint32_t id = 0;
        if (!detail::parse_number(id_word, id)) refuse("IMAGE_ID is not a whole number");
        std::array<double, 7> field{};
        for (std::size_t i = 0; i < field.size(); ++i)
            if (!detail::take_number(text, field[i])) {
                static constexpr std::array<char const*, 7> called{"QW", "QX", "QY", "QZ", "TX", "TY", "TZ"};
                refuse(std::string(called[i]) + " is not a finite number");
            }
        auto const [qw, qx, qy, qz, tx, ty, tz] = field;
        if (qw == 0.0 && qx == 0.0 && qy == 0.0 && qz == 0.0) refuse("its quaternion is zero");
        if (!detail::parse_number(detail::take_word(text), id)) refuse("CAMERA_ID is not a whole number");
        auto const lens = lenses.find(id);
        if (lens == lenses.end()) refuse("there is no camera " + std::to_string(id) + " in " + cameras_name);

        text.remove_prefix(std::min(text.find_first_not_of(detail::blanks), text.size()));
        std::string name(text.substr(0, text.find_last_not_of(detail::blanks) + 1));
        if (name.empty()) refuse("it has no NAME");
        if (!detail::is_plain(name)) refuse("NAME is not UTF-8 text");
        if (!names.insert(name).second) refuse("another image is called \"" + detail::shown(name) + "\"");
        if (names.size() > detail::most_colmap_entries) refuse("it is one image more than 1048576");

        Pose pose{rotation_matrix(qw, qx, qy, qz), {}};
        pose.position = -(glm::transpose(pose.rotation) * glm::dvec3{tx, ty, tz});
        cameras.push_back({"", "", std::move(name), make_camera(pose, lens->second)});
        if (!detail::skip_colmap_points(lines))
            throw Error(lines.place() + " does not list the 2-D points of image \"" + detail::shown(cameras.back().name) +
                        "\" (X Y POINT3D_ID, or nothing); put an empty line after each image");
    }
    return cameras;
}

/// Is this path a COLMAP model: a directory, or a file with the name of one of a model's files?
inline bool names_colmap(std::filesystem::path const& path)
{
    static constexpr std::array<std::string_view, 5> files{"cameras.txt", "images.txt", "cameras.bin", "images.bin",
                                                           "points3D.bin"};
    std::error_code ignored;
    return std::filesystem::is_directory(path, ignored) ||
           std::find(files.begin(), files.end(), path.filename().string()) != files.end();
}

/// The files of a COLMAP text model.
struct ColmapFiles {
    std::filesystem::path cameras, images;
};
/// The files of the model that `path` names. `path` is the model's directory or one of the files.
inline ColmapFiles colmap_files(std::filesystem::path const& path)
{
    std::error_code ignored;
    auto const folder = std::filesystem::is_directory(path, ignored) ? path : path.parent_path();
    return {folder / "cameras.txt", folder / "images.txt"};
}

/// Reads a COLMAP model as `read_colmap` does. `path` is the directory that holds cameras.txt and images.txt, or one of these files. Throws
/// `Error` if one of the two is missing, and for a binary model. images.txt may have any length, because its 2-D points are long.
inline std::vector<NamedCamera> load_colmap(std::filesystem::path const& path)
{
    namespace fs = std::filesystem;
    std::error_code ignored;
    auto const [cameras_path, images_path] = colmap_files(path);
    auto const folder = cameras_path.parent_path();
    bool const cameras_there = fs::exists(cameras_path, ignored), images_there = fs::exists(images_path, ignored);
    bool const binary_there = fs::exists(folder / "cameras.bin", ignored) || fs::exists(folder / "images.bin", ignored);
    if (path.extension() == ".bin" || (binary_there && !(cameras_there && images_there)))
        throw Error(detail::shown_path(path) +
                    " is a binary COLMAP model (only text models are read); run colmap model_converter "
                    "--output_type TXT, and name the folder that it writes");
    if (!cameras_there && !images_there)
        throw Error(detail::shown_path(path) +
                    " cannot be read (it is a directory without cameras.txt and images.txt); name a camera file, or the "
                    "folder of a COLMAP text model");
    constexpr std::uint64_t most_bytes = std::uint64_t{256} << 20; // a camera takes about a hundred bytes in cameras.txt
    std::string const wanted = "a COLMAP model with cameras.txt and images.txt";
    auto cameras_txt = detail::open_file(cameras_path, most_bytes, wanted);
    auto images_txt = detail::open_file(images_path, std::numeric_limits<std::uint64_t>::max(), wanted);
    return read_colmap(cameras_txt, images_txt, detail::shown_path(cameras_path), detail::shown_path(images_path));
}

}}} // namespace tilemesh::scene
