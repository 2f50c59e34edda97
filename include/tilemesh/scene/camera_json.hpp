#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <ios>
#include <istream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/colmap.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/camera.hpp>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

namespace tilemesh::scene {

namespace detail {

/// One entry of a list of cameras, with the words that name it in an error.
class CameraEntry {
public:
    CameraEntry(nlohmann::json const& entry, std::string const& file, std::size_t number)
        : entry_(entry), file_(file), name_(std::to_string(number))
    {
        if (!entry_.is_object()) refuse("it is not an object");
    }

    /// From here on, errors call the camera `name` instead of its number.
    void rename(std::string const& name) { name_ = shown(name); }

    [[noreturn]] void refuse(std::string const& why) const
    {
        throw Error(file_ + " camera " + name_ + " is not usable (" + why + "); correct the camera file");
    }

    bool has(char const* key) const { return entry_.contains(key); }

    nlohmann::json const& at(char const* key) const
    {
        auto const found = entry_.find(key);
        if (found == entry_.end()) refuse(std::string("it has no \"") + key + "\"");
        return *found;
    }

    std::string text(char const* key) const
    {
        auto const& value = at(key);
        if (!value.is_string()) refuse(in_quotes_is(key) + "not a string");
        auto text = value.get<std::string>();
        if (!is_plain(text)) refuse(in_quotes_is(key) + "not one line of text");
        return text;
    }

    std::string name(char const* key) const
    {
        std::string name = text(key);
        if (name.empty()) refuse(in_quotes_is(key) + "empty");
        return name;
    }

    double number(char const* key) const { return finite(at(key), key); }

    std::uint32_t pixels(char const* key) const
    {
        double const value = number(key);
        if (!(value >= 1.0 && value <= 65535.0) || value != std::floor(value))
            refuse(in_quotes_is(key) + "not a whole number from 1 to 65535");
        return static_cast<std::uint32_t>(value);
    }

    template <std::size_t N>
    std::array<double, N> vector(nlohmann::json const& value, char const* key, char const* shape) const
    {
        if (!value.is_array() || value.size() != N) refuse(in_quotes_is(key) + "not " + shape);
        std::array<double, N> numbers{};
        for (std::size_t i = 0; i < N; ++i) numbers[i] = finite(value[i], key);
        return numbers;
    }

    template <std::size_t N>
    std::array<std::array<double, N>, N> matrix(char const* key, char const* shape) const
    {
        auto const& value = at(key);
        if (!value.is_array() || value.size() != N) refuse(in_quotes_is(key) + "not " + shape);
        std::array<std::array<double, N>, N> rows{};
        for (std::size_t row = 0; row < N; ++row) rows[row] = vector<N>(value[row], key, shape);
        return rows;
    }

    splat::Camera camera(Pose const& pose, Intrinsics const& lens) const
    {
        if (auto const why = fault_of(pose, lens); !why.empty()) refuse(why);
        return make_camera(pose, lens);
    }

private:
    static std::string in_quotes_is(char const* key) { return std::string("\"") + key + "\" is "; }

    double finite(nlohmann::json const& value, char const* key) const
    {
        if (!value.is_number()) refuse(in_quotes_is(key) + "not a number");
        if (!(std::fabs(value.get<double>()) <= largest_number)) refuse(in_quotes_is(key) + "not a number within 1e37");
        return value.get<double>();
    }

    nlohmann::json const& entry_;
    std::string const& file_;
    std::string name_;
};

/// Whether the first character after a byte order mark and blanks is an opening bracket.
inline bool begins_as_json(std::istream& stream)
{
    for (char c = '\0'; stream.get(c);)
        if (std::string_view(" \t\r\n\xef\xbb\xbf").find(c) == std::string_view::npos) return c == '{' || c == '[';
    return false;
}

/// Parses JSON within bounds of memory and depth. Throws `Error` for a text that is no JSON or exceeds them.
inline nlohmann::json parse_json(std::istream& stream, std::string const& name)
{
    // A camera file is five deep and has some thirty values and keys a camera: this is 500,000 cameras and, with the
    // worst of values, about 1 GB.
    constexpr int deepest = 64;
    constexpr std::uint32_t most_values = 1u << 24;
    std::uint32_t values = 0;
    auto const bounded = [&](int depth, nlohmann::json::parse_event_t, nlohmann::json const&) {
        if (depth > deepest)
            throw Error(name + " is no camera file (it is nested deeper than " + std::to_string(deepest) +
                        " levels); name a camera file");
        if (++values > most_values)
            throw Error(name + " is no camera file (it has more than " + std::to_string(most_values) +
                        " values); name a camera file or split it");
        return true;
    };
    try {
        return nlohmann::json::parse(stream, bounded);
    } catch (nlohmann::json::exception const& broken) {
        // The text begins with the exception's name, in brackets.
        std::string const why = broken.what();
        std::size_t const begin = why.find("] ");
        throw Error(name + " is not JSON (" + shown(why.substr(begin == std::string::npos ? 0 : begin + 2)) +
                    "); name a JSON camera file or a COLMAP text model");
    } catch (std::ios_base::failure const&) {
        throw Error(name + " cannot be read to its end (the system reports a read error); check the disk or copy the file");
    }
}

/// One camera of our own form. The centre is -R^-1 t, so that R (p - c) = R p + t for this very R.
inline NamedCamera own_camera(CameraEntry& entry)
{
    NamedCamera named{
        entry.has("scene") ? entry.text("scene") : "", entry.has("file") ? entry.text("file") : "", entry.name("name"), {}};
    entry.rename(label(named));
    auto const m = entry.matrix<4>("world_to_camera", "a 4x4 matrix");
    if (std::fabs(m[3][0]) + std::fabs(m[3][1]) + std::fabs(m[3][2]) + std::fabs(m[3][3] - 1.0) > 1e-6)
        entry.refuse("the last row of \"world_to_camera\" is not 0 0 0 1");
    Pose pose;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            pose.rotation[column][row] = m[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
    pose.position = -(glm::inverse(pose.rotation) * glm::dvec3{m[0][3], m[1][3], m[2][3]});
    named.camera = entry.camera(pose, {entry.number("fx"), entry.number("fy"), entry.number("cx"), entry.number("cy"),
                                       entry.has("near") ? static_cast<float>(entry.number("near")) : default_near,
                                       entry.pixels("width"), entry.pixels("height")});
    return named;
}

/// One camera as 3DGS training writes it: `rotation` is camera to world, rows first, `position` the centre. The file holds no
/// principal point, since the training puts it in the middle.
inline NamedCamera training_camera(CameraEntry const& entry, std::string name)
{
    auto const m = entry.matrix<3>("rotation", "a 3x3 matrix");
    auto const centre = entry.vector<3>(entry.at("position"), "position", "3 numbers");
    Pose pose{glm::dmat3{1.0}, {centre[0], centre[1], centre[2]}};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            pose.rotation[row][column] = m[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
    std::uint32_t const width = entry.pixels("width"), height = entry.pixels("height");
    return {"", "", std::move(name),
            entry.camera(pose,
                         {entry.number("fx"), entry.number("fy"), 0.5 * width, 0.5 * height, default_near, width, height})};
}

/// The names of the cameras that 3DGS training wrote: img_name, or img_name#id for cameras that share an img_name. Pictures of
/// several folders often share one, because the training leaves the folder out.
inline std::vector<std::string> training_names(nlohmann::json const& list, std::string const& file)
{
    std::vector<std::string> names;
    std::unordered_map<std::string, std::size_t> uses;
    for (auto const& json : list) {
        names.push_back(CameraEntry(json, file, names.size() + 1).name("img_name"));
        ++uses[names.back()];
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (uses[names[i]] == 1) continue;
        CameraEntry entry(list[i], file, i + 1);
        entry.rename(names[i]);
        auto const& id = entry.at("id");
        if (!id.is_number_integer()) entry.refuse("others have this img_name, and its \"id\" is not a whole number");
        names[i].append("#").append(id.dump());
    }
    return names;
}

} // namespace detail

/// Reads cameras in JSON, OpenCV convention, pixel (i, j) centred at (i + 0.5, j + 0.5). Two forms are known by their content:
/// - our own: `cameras[]` with name, width, height, fx, fy, cx, cy, `world_to_camera` (4x4, rows first), and optionally scene,
///   file and near (0.2);
/// - the cameras.json that 3DGS training writes: a list of img_name, width, height, fx, fy, `position`, `rotation` (3x3, camera
///   to world), id. The principal point is the middle, there is no scene, near is 0.2; the name is img_name, or "img_name#id"
///   for all that share an img_name.
///
/// Throws `Error`, one line that names file and camera, for what cannot be read: a number that is missing or not finite, a side
/// outside 1..65535, a focal length below a thousandth of the side or above 2^24 pixels, a near plane that is not positive, a
/// rotation that is not orthonormal within 1e-3 or is mirrored, two cameras of one label. An empty list is fine and gives no
/// camera. Costs some seven times the file's bytes while it reads.
inline std::vector<NamedCamera> read_cameras_json(std::istream& stream, std::string const& name)
{
    nlohmann::json const file = detail::parse_json(stream, name);
    if (file.is_object() && !file.contains("cameras") && (file.contains("frames") || file.contains("camera_angle_x")))
        throw Error(name + " is a transforms.json of nerfstudio or Blender (its cameras look along -z, with y up); write "
                           "cameras[] with world_to_camera = inverse(transform_matrix * diag(1, -1, -1, 1)), or name the "
                           "COLMAP model it was made from");
    bool const own = file.is_object() && file.contains("cameras") && file["cameras"].is_array();
    if (!own && !file.is_array())
        throw Error(name +
                    " is not a camera file (it has no list \"cameras\", and is no list itself); name a JSON file with "
                    "cameras[], the cameras.json of a 3DGS training, or a COLMAP model");

    nlohmann::json const& list = own ? file["cameras"] : file;
    auto const training_names = own ? std::vector<std::string>{} : detail::training_names(list, name);
    std::vector<NamedCamera> cameras;
    std::unordered_set<std::string> labels;
    for (std::size_t i = 0; i < list.size(); ++i) {
        detail::CameraEntry entry(list[i], name, i + 1);
        if (!own) entry.rename(training_names[i]);
        cameras.push_back(own ? detail::own_camera(entry) : detail::training_camera(entry, training_names[i]));
        if (!labels.insert(label(cameras.back())).second) entry.refuse("another camera has the same scene and name");
    }
    return cameras;
}

/// Reads a camera file, which is known by its content: JSON as `read_cameras_json` takes it, or a COLMAP text model as
/// `load_colmap` does; for that, `path` is the folder of cameras.txt and images.txt, or one of them. Throws `Error` as these do,
/// for what is no regular file, and for JSON of more than 256 MiB.
inline std::vector<NamedCamera> load_cameras(std::filesystem::path const& path)
{
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) return load_colmap(path);

    if (names_colmap(path)) {
        auto stream = detail::open_file(path, std::numeric_limits<std::uint64_t>::max(), "a camera file");
        if (!detail::begins_as_json(stream)) return load_colmap(path);
    }
    // 256 MiB: a camera takes about 500 bytes, so this is half a million.
    auto stream = detail::open_file(path, std::uint64_t{256} << 20, "a camera file");
    return read_cameras_json(stream, detail::shown_path(path));
}

} // namespace tilemesh::scene
