#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <map>
#include <set>
#include <string_view>
#include <system_error>
#include <tilemesh/scene/colmap.hpp>
#include <tilemesh/scene/detail/bytes.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace scene {
namespace detail {

/// A limit for cameras and images that no reconstruction reaches. It bounds the memory: about 500 MB, plus long names.
inline constexpr std::size_t most_colmap_entries = 1u << 20;

/// Takes the next word off `text` as a number within `largest_number`; false if it is not such a number.
inline bool take_number(std::string_view& text, double& value)
{
    return parse_number(take_word(text), value) && std::fabs(value) <= largest_number;
}

/// A camera model of COLMAP. Its parameters are one or two focal lengths, cx, cy, and `coefficients` numbers that bend the picture. If all
/// of these are 0, the lens is a pinhole, except for a fisheye projection.
struct ColmapModel {
    std::string_view name;
    std::size_t focals, coefficients;
    bool fisheye;

    std::size_t parameters() const { return focals + 2 + coefficients; }
};
/// The models by MODEL_ID (COLMAP, "Camera Models").
inline constexpr std::array<ColmapModel, 12> colmap_models{{{"SIMPLE_PINHOLE", 1, 0, false},
                                                            {"PINHOLE", 2, 0, false},
                                                            {"SIMPLE_RADIAL", 1, 1, false},
                                                            {"RADIAL", 1, 2, false},
                                                            {"OPENCV", 2, 4, false},
                                                            {"OPENCV_FISHEYE", 2, 4, true},
                                                            {"FULL_OPENCV", 2, 8, false},
                                                            {"FOV", 2, 1, false},
                                                            {"SIMPLE_RADIAL_FISHEYE", 1, 1, true},
                                                            {"RADIAL_FISHEYE", 1, 2, true},
                                                            {"THIN_PRISM_FISHEYE", 2, 8, true},
                                                            {"RAD_TAN_THIN_PRISM_FISHEYE", 2, 12, true}}};
inline constexpr std::size_t most_colmap_parameters = 16;

/// The lenses of a model by CAMERA_ID, and the images that were read. Both forms of a model, text and binary, fill it. `place` says in
/// errors where the entry is.
class ColmapCameras {
public:
    ColmapCameras(std::string cameras_name, DistortedLens distorted) : cameras_name_(std::move(cameras_name)), distorted_(distorted) {}

    void add_lens(std::string const& place, std::uint32_t id, ColmapModel const& model, Size size, double const* parameters)
    {
        auto const refuse = [&](std::string const& why) { throw Error(place + " is no camera (" + why + "); correct it or export the model again"); };
        double const* const centre = parameters + model.focals;
        Intrinsics lens{parameters[0], parameters[model.focals - 1], centre[0], centre[1], default_near, size.width, size.height};
        bool const bent = model.fisheye || std::any_of(centre + 2, centre + 2 + model.coefficients, [](double c) { return c != 0.0; });
        if (bent && distorted_ == DistortedLens::refused)
            throw Error(place + " has a lens with distortion (" + std::string(model.name) +
                        (model.fisheye ? ", a fisheye projection" : ", with a coefficient that is not 0") +
                        "; a pinhole camera has none); run colmap image_undistorter, and name the model that it writes");
        if (bent && distorted_ == DistortedLens::kept) {
            double const* const c = centre + 2;
            LensValues values;
            std::string fault;
            values.fisheye = model.fisheye;
            if (model.name == "FOV") values.model = "fov";
            if (model.name.find("THIN_PRISM") != std::string_view::npos) values.fisheye = false, values.model = model.name; // no lens here
            else if (model.coefficients > 2) values.lists[0].assign(c, c + model.coefficients);
            else std::copy(c, c + model.coefficients, values.coefficients.begin());
            lens.bend = lens_of_values(values, fault);
            if (!fault.empty())
                throw Error(place + " has a lens that is not rendered (" + fault +
                            "); run colmap image_undistorter, and name the model that it writes");
        }
        if (auto const why = fault_of({}, lens); !why.empty()) refuse(why);
        if (!lenses_.emplace(id, Lens{lens, bent}).second) refuse("another camera has CAMERA_ID " + std::to_string(id));
        if (lenses_.size() > most_colmap_entries) refuse("it is one camera more than 1048576");
    }

    /// `turn_and_shift`: QW QX QY QZ TX TY TZ, world to camera. `image_id`: IMAGE_ID.
    void add_image(std::string const& place, std::uint32_t image_id, std::array<double, 7> const& turn_and_shift,
                                     std::uint32_t lens_id, std::string name)
    {
        auto const refuse = [&](std::string const& why) { throw Error(place + " is no image (" + why + "); correct it or export the model again"); };
        auto const [qw, qx, qy, qz, tx, ty, tz] = turn_and_shift;
        if (qw == 0.0 && qx == 0.0 && qy == 0.0 && qz == 0.0) refuse("its quaternion is zero");
        auto const lens = lenses_.find(lens_id);
        if (lens == lenses_.end()) refuse("there is no camera " + std::to_string(lens_id) + " in " + cameras_name_);
        if (name.empty()) refuse("it has no NAME");
        if (!is_plain(name)) refuse("NAME is not UTF-8 text");
        name = with_slashes(name);
        if (!names_.insert(name).second) refuse("another image is called \"" + shown(name) + "\"");
        if (names_.size() > most_colmap_entries) refuse("it is one image more than 1048576");
        if (!image_ids_.insert(image_id).second && ++repeated_ids_ == 1)
            repeated_ = "IMAGE_ID " + std::to_string(image_id) + " of \"" + shown(name) + "\"";
        Pose pose{rotation_matrix(qw, qx, qy, qz), {}};
        pose.position = -(glm::transpose(pose.rotation) * glm::dvec3{tx, ty, tz});
        cameras_.push_back({"", "", std::move(name), make_camera(pose, lens->second.lens), pose.position});
        if (lens->second.bent) ++bent_;
    }

    std::vector<NamedCamera> take(std::vector<std::string>* notes)
    {
        if (distorted_ == DistortedLens::ignored) note_ignored_distortion(bent_, notes);
        if (repeated_ids_ != 0 && notes != nullptr)
            notes->push_back(std::to_string(repeated_ids_) + (repeated_ids_ == 1 ? " image has" : " images have") +
                             " an IMAGE_ID that an earlier image has (" +
                             (repeated_ids_ == 1 ? "" : "the first is ") + repeated_ + "): all are read, by their NAME");
        return std::move(cameras_);
    }
    std::string const& last_name() const { return cameras_.back().name; }

private:
    struct Lens {
        Intrinsics lens;
        bool bent;
    };
    std::string cameras_name_;
    DistortedLens distorted_;
    std::map<std::uint32_t, Lens> lenses_;
    std::vector<NamedCamera> cameras_;
    std::set<std::string> names_; // not a hash table: an attacker could choose names that collide
    std::set<std::uint32_t> image_ids_;
    std::size_t bent_ = 0, repeated_ids_ = 0;
    std::string repeated_; ///< the first image whose IMAGE_ID an earlier one has
};

/// Reads cameras.txt. A line is `CAMERA_ID MODEL WIDTH HEIGHT PARAMS...`; `#` begins a comment.
inline void read_colmap_lenses(std::istream& stream, std::string const& name, ColmapCameras& cameras)
{
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

        std::string_view const word = take_word(text);
        auto const* const model = std::find_if(colmap_models.begin(), colmap_models.end(), [&](auto const& each) { return each.name == word; });
        if (auto const fault = fault_of_projection(std::string(word)); !fault.empty()) throw Error(lines.place() + " " + fault);
        if (model == colmap_models.end())
            throw Error(lines.place() + " has a camera model that is not known (\"" + shown(word, 40) +
                        "\"; PINHOLE and SIMPLE_PINHOLE are); run colmap image_undistorter, and name the model that it writes");

        Size size{};
        for (auto* side : {&size.width, &size.height})
            if (!parse_number(take_word(text), *side) || *side < 1 || *side > 65535)
                refuse(std::string(side == &size.width ? "WIDTH" : "HEIGHT") + " is not a whole number from 1 to 65535");
        std::array<double, most_colmap_parameters> parameters{};
        bool complete = true;
        for (std::size_t i = 0; i < model->parameters(); ++i) complete = complete && take_number(text, parameters[i]);
        if (!complete || !take_word(text).empty())
            refuse(std::string(word) + " takes " + (model->focals == 1 ? "f cx cy" : "fx fy cx cy") +
                   (model->coefficients == 0   ? std::string()
                    : model->coefficients == 1 ? std::string(" and a coefficient")
                                               : " and " + std::to_string(model->coefficients) + " coefficients") +
                   ", finite numbers");
        cameras.add_lens(lines.place(), id, *model, size, parameters.data());
    }
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

/// Reads the entries of a binary file of a model: a count, then as many entries.
class ColmapBytes {
public:
    /// `entry` names an entry in errors: "camera".
    ColmapBytes(std::istream& stream, std::string const& name, std::string entry)
        : source_(stream, name), name_(name), entry_(std::move(entry)), count_(number<std::uint64_t>())
    {
        if (count_ > most_colmap_entries)
            throw Error(name_ + " is not read (it says that it has " + std::to_string(count_) + " " + entry_ +
                        "s, and 1048576 are the most); name a binary file of a COLMAP model");
    }

    /// Goes to the next entry; false after the last. Throws `Error` if bytes follow the last.
    bool next()
    {
        if (number_ < count_) {
            ++number_;
            return true;
        }
        if (source_.left() != 0)
            throw Error(name_ + " is damaged (" + std::to_string(source_.left()) + " bytes follow the last of its " + std::to_string(count_) +
                        " " + entry_ + "s); export the model again");
        return false;
    }

    template <class T>
    T number()
    {
        return number_at<T>(take(sizeof(T)));
    }
    /// False if the number is not finite, or too large.
    bool take_double(double& value)
    {
        value = number<double>();
        return std::fabs(value) <= largest_number;
    }
    /// A text that a byte 0 ends, at most 64 KiB.
    std::string text()
    {
        std::string text;
        for (char c; (c = static_cast<char>(*take(1))) != '\0'; text += c)
            if (text.size() == LineReader::most_bytes) refuse("its name is too long");
        return text;
    }
    void skip(std::uint64_t items, std::uint64_t bytes_of_item)
    {
        if (items > source_.left() / bytes_of_item || !source_.skip(items * bytes_of_item)) refuse_end();
    }

    /// "cameras.bin camera 3"
    std::string place() const { return name_ + " " + entry_ + " " + std::to_string(number_); }
    [[noreturn]] void refuse(std::string const& why) const
    {
        throw Error(place() + " is not usable (" + why + "); correct it or export the model again");
    }

private:
    [[noreturn]] void refuse_end() const
    {
        throw Error(name_ + " ends too early (in " +
                    (number_ == 0 ? "its count" : entry_ + " " + std::to_string(number_) + " of " + std::to_string(count_)) +
                    "); copy it again, or export the model again");
    }
    unsigned char const* take(std::size_t bytes)
    {
        auto const* const there = source_.take(bytes);
        if (!there) refuse_end();
        return there;
    }

    ByteSource source_;
    std::string name_, entry_;
    std::uint64_t number_ = 0, count_;
};

} // namespace detail

TILEMESH_HOST std::vector<NamedCamera> read_colmap(std::istream& cameras_txt, std::istream& images_txt, std::string const& cameras_name,
                                                   std::string const& images_name, DistortedLens distorted, std::vector<std::string>* notes)
{
    detail::ColmapCameras cameras(cameras_name, distorted);
    detail::read_colmap_lenses(cameras_txt, cameras_name, cameras);
    detail::LineReader lines(images_txt, images_name);
    auto const refuse = [&](std::string const& why) {
        throw Error(lines.place() + " is no image (" + why + "); correct it or export the model again");
    };
    while (lines.next()) {
        std::string_view text = lines.text();
        std::string_view const id_word = detail::take_word(text);
        if (id_word.empty() || id_word.front() == '#') continue;
        std::uint32_t id = 0, image_id = 0;
        if (!detail::parse_number(id_word, image_id)) refuse("IMAGE_ID is not a whole number");
        std::array<double, 7> field{};
        for (std::size_t i = 0; i < field.size(); ++i)
            if (!detail::take_number(text, field[i])) {
                static constexpr std::array<char const*, 7> called{"QW", "QX", "QY", "QZ", "TX", "TY", "TZ"};
                refuse(std::string(called[i]) + " is not a finite number");
            }
        if (!detail::parse_number(detail::take_word(text), id)) refuse("CAMERA_ID is not a whole number");
        text.remove_prefix(std::min(text.find_first_not_of(detail::blanks), text.size()));
        cameras.add_image(lines.place(), image_id, field, id, std::string(text.substr(0, text.find_last_not_of(detail::blanks) + 1)));
        if (!detail::skip_colmap_points(lines))
            throw Error(lines.place() + " does not list the 2-D points of image \"" + detail::shown(cameras.last_name()) +
                        "\" (X Y POINT3D_ID, or nothing); put an empty line after each image");
    }
    return cameras.take(notes);
}

TILEMESH_HOST std::vector<NamedCamera> read_colmap_binary(std::istream& cameras_bin, std::istream& images_bin, std::string const& cameras_name,
                                                          std::string const& images_name, DistortedLens distorted, std::vector<std::string>* notes)
{
    detail::ColmapCameras cameras(cameras_name, distorted);
    detail::ColmapBytes lenses(cameras_bin, cameras_name, "camera");
    while (lenses.next()) {
        auto const id = lenses.number<std::uint32_t>();
        auto const model = lenses.number<std::uint32_t>();
        if (model >= detail::colmap_models.size())
            throw Error(lenses.place() + " has a camera model that is not known (MODEL_ID " + std::to_string(model) +
                        "; 0 to 11 are); run colmap image_undistorter, and name the model that it writes");
        Size size{};
        for (auto* side : {&size.width, &size.height}) {
            auto const pixels = lenses.number<std::uint64_t>();
            if (pixels < 1 || pixels > 65535) lenses.refuse(std::string(side == &size.width ? "WIDTH" : "HEIGHT") + " is not from 1 to 65535");
            *side = static_cast<std::uint32_t>(pixels);
        }
        std::array<double, detail::most_colmap_parameters> parameters{};
        for (std::size_t i = 0; i < detail::colmap_models[model].parameters(); ++i)
            if (!lenses.take_double(parameters[i])) lenses.refuse("a parameter is not a finite number");
        cameras.add_lens(lenses.place(), id, detail::colmap_models[model], size, parameters.data());
    }
    detail::ColmapBytes images(images_bin, images_name, "image");
    while (images.next()) {
        auto const image_id = images.number<std::uint32_t>();
        std::array<double, 7> field{};
        for (auto& value : field)
            if (!images.take_double(value)) images.refuse("its pose is not of finite numbers");
        auto const lens = images.number<std::uint32_t>();
        cameras.add_image(images.place(), image_id, field, lens, images.text());
        images.skip(images.number<std::uint64_t>(), 24);
    }
    return cameras.take(notes);
}

TILEMESH_HOST bool names_colmap(std::filesystem::path const& path)
{
    static constexpr std::array<std::string_view, 5> files{"cameras.txt", "images.txt", "cameras.bin", "images.bin", "points3D.bin"};
    std::error_code ignored;
    return std::filesystem::is_directory(path, ignored) || std::find(files.begin(), files.end(), path.filename().string()) != files.end();
}

TILEMESH_HOST ColmapFiles colmap_files(std::filesystem::path const& path)
{
    std::error_code ignored;
    bool const is_folder = std::filesystem::is_directory(path, ignored);
    auto const folder = is_folder ? path : path.parent_path();
    auto const there = [&](char const* name) { return std::filesystem::exists(folder / name, ignored); };
    bool const binary_there = there("cameras.bin") || there("images.bin");
    if (is_folder ? binary_there && !(there("cameras.txt") && there("images.txt")) : path.extension() == ".bin")
        return {folder / "cameras.bin", folder / "images.bin"};
    return {folder / "cameras.txt", folder / "images.txt"};
}

namespace detail {
/// What lies beside the model that is read: the other form of it in a folder, and other models of the project.
TILEMESH_HOST void add_colmap_notes(std::filesystem::path const& path, std::filesystem::path const& cameras_path, std::vector<std::string>& notes)
{
    namespace fs = std::filesystem;
    std::error_code ignored;
    auto const model = cameras_path.parent_path();
    if (fs::is_directory(path, ignored) && cameras_path.extension() == ".txt" && fs::exists(model / "cameras.bin", ignored))
        notes.push_back("the folder has a text model and a binary one: the text is read; name cameras.bin for the other");
    // COLMAP numbers the models of a project: sparse/0, sparse/1, ...
    auto const is_number = [](fs::path const& of) { return !of.empty() && of.string().find_first_not_of("0123456789") == std::string::npos; };
    if (!is_number(model.filename())) return;
    std::vector<std::string> others;
    for (fs::directory_iterator at(model / "..", ignored), end; !ignored && at != end; at.increment(ignored))
        if (auto const name = at->path().filename();
            is_number(name) && name != model.filename() && fs::exists(colmap_files(at->path()).cameras, ignored))
            others.push_back(name.string());
    std::sort(others.begin(), others.end());
    if (!others.empty())
        notes.push_back("the project has " + std::to_string(others.size()) + (others.size() == 1 ? " other model" : " other models") +
                        " beside this one (" + others.front() + (others.size() == 1 ? "" : " and more") + "): their cameras are not read");
}
} // namespace detail

TILEMESH_HOST std::vector<NamedCamera> load_colmap(std::filesystem::path const& path, DistortedLens distorted, std::vector<std::string>* notes)
{
    namespace fs = std::filesystem;
    std::error_code ignored;
    auto const [cameras_path, images_path] = colmap_files(path);
    bool const binary = cameras_path.extension() == ".bin";
    if (!fs::exists(cameras_path, ignored) && !fs::exists(images_path, ignored))
        throw Error(detail::shown_path(path) +
                    " cannot be read (it is a directory without cameras.txt and images.txt, or cameras.bin and images.bin, and no sparse/0 "
                    "or transforms.json is below it); name a camera file, "
                    "or the folder of a COLMAP model");
    constexpr std::uint64_t most_bytes = std::uint64_t{256} << 20; // a camera takes about a hundred bytes
    std::string const wanted = binary ? "a COLMAP model with cameras.bin and images.bin" : "a COLMAP model with cameras.txt and images.txt";
    auto cameras = detail::open_file(cameras_path, most_bytes, wanted);
    auto images = detail::open_file(images_path, std::numeric_limits<std::uint64_t>::max(), wanted);
    if (notes != nullptr) detail::add_colmap_notes(path, cameras_path, *notes);
    auto const read = binary ? read_colmap_binary : read_colmap;
    return read(cameras, images, detail::shown_path(cameras_path), detail::shown_path(images_path), distorted, notes);
}

}}} // namespace tilemesh::scene
