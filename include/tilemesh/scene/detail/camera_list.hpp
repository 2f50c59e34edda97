#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <istream>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/json_reader.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/camera.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// A field of a camera: whether the file has it, its fault (null: no fault) and its value.
template <class T>
struct CameraField {
    bool there = false;
    char const* fault = nullptr;
    T value{};
};

/// A limit that no capture reaches. It bounds the memory: about 500 MB, plus long names.
inline constexpr std::size_t most_cameras = 1u << 20;

/// The fields of one entry in a list of cameras, for both forms of file; no field if the entry is no object. If a key comes twice,
/// the last value counts.
struct CameraFields {
    bool object = false;
    CameraField<std::string> scene, file, name, id;
    CameraField<double> fx, fy, cx, cy, near, width, height;
    CameraField<std::array<double, 16>> world_to_camera;
    CameraField<std::array<double, 9>> rotation;
    CameraField<std::array<double, 3>> position;
};

/// One entry, and its name in errors.
class CameraEntry {
public:
    CameraEntry(std::string const& file, std::size_t number) : file_(file), name_(std::to_string(number)) {}

    /// From here on, errors call the camera `name` instead of its number.
    void rename(std::string const& name) { name_ = shown(name); }

    [[noreturn]] void refuse(std::string const& why) const
    {
        throw Error(file_ + " camera " + name_ + " is not usable (" + why + "); correct the camera file");
    }

    template <class T>
    T const& value(CameraField<T> const& field, char const* key) const
    {
        if (!field.there) refuse(std::string("it has no \"") + key + "\"");
        if (field.fault != nullptr) refuse(in_quotes_is(key) + field.fault);
        return field.value;
    }

    std::string name(CameraField<std::string> const& field, char const* key) const
    {
        if (value(field, key).empty()) refuse(in_quotes_is(key) + "empty");
        return field.value;
    }

    std::uint32_t pixels(CameraField<double> const& field, char const* key) const
    {
        double const side = value(field, key);
        if (!(side >= 1.0 && side <= 65535.0) || side != std::floor(side))
            refuse(in_quotes_is(key) + "not a whole number from 1 to 65535");
        return static_cast<std::uint32_t>(side);
    }

    splat::Camera camera(Pose const& pose, Intrinsics const& lens) const
    {
        if (auto const why = fault_of(pose, lens); !why.empty()) refuse(why);
        return make_camera(pose, lens);
    }

private:
    static std::string in_quotes_is(char const* key) { return std::string("\"") + key + "\" is "; }

    std::string const& file_;
    std::string name_;
};

/// Makes a camera from this library's form. The centre is -R^-1 t, so that R (p - c) = R p + t for this R.
inline NamedCamera own_camera(CameraFields const& fields, CameraEntry& entry)
{
    auto const text = [&](auto const& field, char const* key) { return field.there ? entry.value(field, key) : std::string(); };
    NamedCamera named{text(fields.scene, "scene"), text(fields.file, "file"), entry.name(fields.name, "name"), {}};
    entry.rename(label(named));
    auto const& m = entry.value(fields.world_to_camera, "world_to_camera");
    if (std::fabs(m[12]) + std::fabs(m[13]) + std::fabs(m[14]) + std::fabs(m[15] - 1.0) > 1e-6)
        entry.refuse("the last row of \"world_to_camera\" is not 0 0 0 1");
    Pose pose;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            pose.rotation[column][row] = m[static_cast<std::size_t>(4 * row + column)];
    pose.position = -(glm::inverse(pose.rotation) * glm::dvec3{m[3], m[7], m[11]});
    named.camera = entry.camera(
        pose, {entry.value(fields.fx, "fx"), entry.value(fields.fy, "fy"), entry.value(fields.cx, "cx"),
               entry.value(fields.cy, "cy"),
               fields.near.there ? static_cast<float>(entry.value(fields.near, "near")) : default_near,
               entry.pixels(fields.width, "width"), entry.pixels(fields.height, "height")});
    return named;
}

/// Makes a camera from the form that 3DGS training writes: `rotation` is camera to world, row-major; `position` is the centre. The file has
/// no principal point, because the training puts it into the middle of the picture.
inline splat::Camera training_camera(CameraFields const& fields, CameraEntry const& entry)
{
    auto const& m = entry.value(fields.rotation, "rotation");
    auto const& centre = entry.value(fields.position, "position");
    Pose pose{glm::dmat3{1.0}, {centre[0], centre[1], centre[2]}};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            pose.rotation[row][column] = m[static_cast<std::size_t>(3 * row + column)];
    std::uint32_t const width = entry.pixels(fields.width, "width"), height = entry.pixels(fields.height, "height");
    return entry.camera(pose, {entry.value(fields.fx, "fx"), entry.value(fields.fy, "fy"), 0.5 * width, 0.5 * height,
                               default_near, width, height});
}

/// Reads a JSON camera file part by part. It keeps the cameras before the first unusable one, and the fields of that one. It
/// reports the unusable camera only after the whole text is known to be JSON.
class CameraJson {
public:
    CameraJson(std::istream& stream, std::string const& name) : json_(stream, name), file_(name) {}

    std::vector<NamedCamera> read()
    {
        bool list = false, cameras_key = false, transforms_key = false;
        JsonPart const root = json_.next();
        if (root == JsonPart::begin_list) {
            list = training_ = true;
            read_list();
        }
        while (root == JsonPart::begin_object && json_.next() == JsonPart::key) {
            bool const cameras = json_.text() == "cameras";
            cameras_key = cameras_key || cameras;
            transforms_key = transforms_key || json_.text() == "frames" || json_.text() == "camera_angle_x";
            JsonPart const value = json_.next();
            if (cameras) list = value == JsonPart::begin_list;
            if (cameras && list) read_list();
            else json_.skip(value);
        }
        json_.next(); // the end

        if (!cameras_key && transforms_key)
            throw Error(file_ + " is a transforms.json of nerfstudio or Blender (its cameras look along -z, with y up); write "
                                "cameras[] with world_to_camera = inverse(transform_matrix * diag(1, -1, -1, 1)), or name the "
                                "COLMAP model it was made from");
        if (!list)
            throw Error(file_ +
                        " is not a camera file (it has no list \"cameras\", and is no list itself); name a JSON file with "
                        "cameras[], the cameras.json of a 3DGS training, or a COLMAP model");
        if (training_) finish_names();
        std::set<std::string> labels;
        for (std::size_t i = 0; i < cameras_.size(); ++i) {
            if (labels.insert(label(cameras_[i])).second) continue;
            CameraEntry entry(file_, i + 1);
            entry.rename(label(cameras_[i]));
            entry.refuse("another camera has the same scene and name");
        }
        if (unusable_) convert(*unusable_); // throws
        return std::move(cameras_);
    }

private:
    struct TrainingName {
        std::string name;
        CameraField<std::string> id;
    };

    /// Reads a list after its opening bracket. The list replaces one that was read before.
    void read_list()
    {
        cameras_.clear();
        unusable_.reset();
        std::size_t number = 0;
        for (JsonPart part; (part = json_.next()) != JsonPart::end_list;) {
            if (++number > most_cameras)
                throw Error(file_ + " has too many cameras (more than " + std::to_string(most_cameras) + "); split it");
            // In the 3DGS form, later names still matter: cameras that share a name are named by their ids.
            if (nameless_ || (unusable_ && !training_)) {
                json_.skip(part);
                continue;
            }
            CameraFields fields;
            fields.object = part == JsonPart::begin_object;
            if (fields.object) read_fields(fields);
            else json_.skip(part);
            if (training_) {
                if (!fields.name.there || fields.name.fault != nullptr || fields.name.value.empty()) {
                    nameless_ = std::move(fields);
                    continue;
                }
                names_.push_back({std::move(fields.name.value), std::move(fields.id)});
            }
            if (unusable_) continue;
            try {
                cameras_.push_back(convert(fields));
            } catch (Error const&) {
                unusable_ = std::move(fields);
            }
        }
    }

    /// Converts the entry after the last camera that is kept.
    NamedCamera convert(CameraFields const& fields) const
    {
        CameraEntry entry(file_, cameras_.size() + 1);
        if (!fields.object) entry.refuse("it is not an object");
        if (!training_) return own_camera(fields, entry);
        entry.rename(names_[cameras_.size()].name);
        return {"", "", "", training_camera(fields, entry)};
    }

    /// Names the cameras that 3DGS training wrote: img_name, or img_name#id for cameras that share an img_name. The training leaves out the
    /// folder, so pictures of several folders often share an img_name.
    void finish_names()
    {
        if (nameless_) {
            CameraEntry const entry(file_, names_.size() + 1);
            if (!nameless_->object) entry.refuse("it is not an object");
            entry.name(nameless_->name, "img_name"); // throws
        }
        std::map<std::string, std::size_t> uses;
        for (auto const& camera : names_) ++uses[camera.name];
        for (std::size_t i = 0; i < names_.size(); ++i) {
            auto& [name, id] = names_[i];
            if (uses[name] > 1) {
                CameraEntry entry(file_, i + 1);
                entry.rename(name);
                if (id.fault != nullptr) entry.refuse(std::string("others have this img_name, and its \"id\" is ") + id.fault);
                name.append("#").append(entry.value(id, "id"));
            }
            if (i < cameras_.size()) cameras_[i].name = name;
        }
    }

    void read_fields(CameraFields& fields)
    {
        while (json_.next() == JsonPart::key) {
            std::string_view const key = json_.text();
            if (key == "fx") read(fields.fx);
            else if (key == "fy") read(fields.fy);
            else if (key == "cx") read(fields.cx);
            else if (key == "cy") read(fields.cy);
            else if (key == "near") read(fields.near);
            else if (key == "width") read(fields.width);
            else if (key == "height") read(fields.height);
            else if (key == "scene") read(fields.scene);
            else if (key == "file") read(fields.file);
            else if (key == (training_ ? "img_name" : "name")) read(fields.name);
            else if (key == "id") read_id(fields.id);
            else if (key == "position") read_vector(fields.position, "not 3 numbers");
            else if (key == "rotation") read_matrix<3>(fields.rotation, "not a 3x3 matrix");
            else if (key == "world_to_camera") read_matrix<4>(fields.world_to_camera, "not a 4x4 matrix");
            else json_.skip(json_.next());
        }
    }
    void read(CameraField<double>& field)
    {
        field.there = true;
        field.fault = read_number(json_.next(), field.value);
    }
    void read(CameraField<std::string>& field)
    {
        JsonPart const part = json_.next();
        field.there = true;
        field.fault = part != JsonPart::text ? "not a string" : !is_plain(json_.text()) ? "not one line of text" : nullptr;
        if (field.fault == nullptr) field.value = json_.text();
        else json_.skip(part);
    }
    /// Reads an id: an integer of 64 bits, with or without a sign. A name shows it as the file does.
    void read_id(CameraField<std::string>& id)
    {
        JsonPart const part = json_.next();
        id.there = true;
        id.fault = "not a whole number";
        std::uint64_t natural = 0;
        std::int64_t whole = 0;
        if (part != JsonPart::number) return json_.skip(part);
        if (!parse_number(json_.text(), natural) && !parse_number(json_.text(), whole)) return;
        id.fault = nullptr;
        id.value = json_.text() == "-0" ? "0" : json_.text();
    }
    template <std::size_t N>
    void read_vector(CameraField<std::array<double, N>>& field, char const* fault)
    {
        JsonPart const part = json_.next();
        field.there = true;
        field.fault = fault;
        if (part == JsonPart::begin_list) field.fault = read_numbers<N>(field.value.data(), fault);
        else json_.skip(part);
    }
    template <std::size_t N>
    void read_matrix(CameraField<std::array<double, N * N>>& field, char const* fault)
    {
        JsonPart const part = json_.next();
        field.there = true;
        field.fault = fault;
        if (part != JsonPart::begin_list) return json_.skip(part);
        char const* wrong = nullptr;
        std::array<double, N> none{};
        std::size_t rows = 0;
        for (JsonPart row; (row = json_.next()) != JsonPart::end_list; ++rows) {
            char const* why = fault;
            if (row == JsonPart::begin_list) why = read_numbers<N>(rows < N ? &field.value[N * rows] : none.data(), fault);
            else json_.skip(row);
            if (wrong == nullptr) wrong = why;
        }
        if (rows == N) field.fault = wrong;
    }
    /// Reads a list of `N` numbers after its opening bracket. Returns its fault: `fault` if it does not have `N` items.
    template <std::size_t N>
    char const* read_numbers(double* numbers, char const* fault)
    {
        char const* wrong = nullptr;
        std::size_t count = 0;
        for (JsonPart part; (part = json_.next()) != JsonPart::end_list; ++count) {
            double value = 0.0;
            char const* const why = read_number(part, value);
            if (wrong == nullptr) wrong = why;
            if (count < N) numbers[count] = value;
        }
        return count == N ? wrong : fault;
    }
    /// Reads the rest of a value that starts with `part`, as a number. Returns its fault; null: no fault.
    char const* read_number(JsonPart part, double& value)
    {
        json_.skip(part);
        if (part != JsonPart::number) return "not a number";
        value = json_.number();
        return std::fabs(value) <= largest_number ? nullptr : "not a number within 1e37";
    }

    JsonReader json_;
    std::string const& file_;
    bool training_ = false;
    std::vector<NamedCamera> cameras_;
    std::vector<TrainingName> names_;
    std::optional<CameraFields> unusable_, nameless_;
};

}}} // namespace tilemesh::scene::detail
