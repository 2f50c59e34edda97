#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <istream>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/json_reader.hpp>
#include <tilemesh/scene/detail/json_values.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/detail/transforms_json.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/camera.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// The keys that are read from a camera of our own form, and of that which 3DGS training writes.
inline constexpr std::string_view own_keys[] = {"scene", "file", "name", "id", "width", "height", "fx", "fy", "cx", "cy", "near", "world_to_camera"};
inline constexpr std::string_view training_keys[] = {"id", "img_name", "width", "height", "position", "rotation", "fx", "fy"};

/// The keys of a frame of transforms.json that say nothing about its camera.
inline constexpr std::string_view beside_camera_keys[] = {"colmap_im_id", "sharpness"};

/// The keys beside frames[] that say nothing about the cameras, their lens or their world.
inline constexpr std::string_view beside_frames_keys[] = {"aabb_scale", "ply_file_path", "sharpness"};

/// The lists beside frames[] that say what frames are for.
inline constexpr std::string_view split_keys[] = {"train_filenames", "val_filenames", "test_filenames"};

/// Where a key is in a list of keys; the list's size if it is not there.
template <std::size_t N>
std::size_t place_of(std::string_view key, std::string_view const (&keys)[N])
{
    return static_cast<std::size_t>(std::find(keys, keys + N, key) - keys);
}

/// Which distortion keys have a value that no pinhole camera has. If a key comes twice, the last value counts.
using Distortion = std::array<bool, std::size(distortion_keys)>;

/// Throws `Error` for a lens with distortion. `whose`: how the error names the camera or the file.
inline void refuse_distortion(Distortion const& distortion, std::string const& whose)
{
    auto const at = static_cast<std::size_t>(std::find(distortion.begin(), distortion.end(), true) - distortion.begin());
    if (at < distortion.size())
        throw Error(whose + " has a lens with distortion (its \"" + std::string(distortion_keys[at]) + "\" is " +
                    (distortion_keys[at] == "camera_model" ? "no pinhole"
                     : distortion_keys[at] == "is_fisheye" ? "true"
                                                           : "not 0") +
                    "; a pinhole camera has none); undistort the pictures, for example with colmap image_undistorter, and name the "
                    "cameras that it writes");
}

/// The keys that nobody reads: at most `most` by name, each with the number of cameras that have it.
class UnreadKeys {
public:
    static constexpr std::size_t most = 8, longest = 40;

    /// `camera`: the number of the camera that has the key.
    void see(std::string const& key, std::size_t camera)
    {
        auto const name = shown(key, longest);
        auto found = std::find_if(keys_.begin(), keys_.end(), [&](Key const& k) { return k.name == name; });
        if (found == keys_.end()) {
            more_ = more_ || keys_.size() == most;
            if (keys_.size() == most) return;
            found = keys_.insert(keys_.end(), {name, 0, camera + 1});
        }
        if (found->last == camera) return;
        ++found->cameras;
        found->last = camera;
    }
    /// One line for each key.
    void add_to(std::vector<std::string>& notes) const
    {
        for (auto const& key : keys_)
            notes.push_back(std::to_string(key.cameras) + (key.cameras == 1 ? " camera has" : " cameras have") + " \"" + key.name +
                            "\", which is not read");
        if (more_) notes.push_back("cameras have more keys that are not read");
    }
    /// The same for keys of the whole file.
    void add_to_as_of_file(std::vector<std::string>& notes) const
    {
        for (auto const& key : keys_) notes.push_back("the file has \"" + key.name + "\", which is not read");
        if (more_) notes.push_back("the file has more keys that are not read");
    }

private:
    struct Key {
        std::string name;
        std::size_t cameras, last; ///< cameras that have it, and the last of them
    };
    std::vector<Key> keys_;
    bool more_ = false;
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
    Distortion distortion{};
    LensValues values{};
    std::string model{}; ///< a camera model that is no perspective; empty: there is none
};

/// One entry, and its name in errors.
class CameraEntry {
public:
    CameraEntry(std::string const& file, std::size_t number, DistortedLens distorted = DistortedLens::kept)
        : file_(file), name_(std::to_string(number)), distorted_(distorted)
    {}

    /// From here on, errors call the camera `name` instead of its number.
    void rename(std::string const& name) { name_ = shown(name); }

    [[noreturn]] void refuse(std::string const& why) const
    {
        throw Error(file_ + " camera " + name_ + " is not usable (" + why + "); correct the camera file");
    }

    void refuse_distortion(CameraFields const& fields) const
    {
        if (!fields.model.empty()) throw Error(file_ + " camera " + name_ + " " + fault_of_projection(fields.model));
        if (distorted_ == DistortedLens::refused) detail::refuse_distortion(fields.distortion, file_ + " camera " + name_);
    }
    /// The lens that these values describe, if lenses are kept.
    splat::Lens lens(LensValues const& values) const
    {
        std::string fault;
        if (distorted_ != DistortedLens::kept) return {};
        auto const lens = lens_of_values(values, fault);
        if (!fault.empty()) refuse(fault);
        return lens;
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
        if (!(side >= 1.0 && side <= 65535.0) || side != std::floor(side)) refuse(in_quotes_is(key) + "not a whole number from 1 to 65535");
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
    DistortedLens distorted_;
};

/// Makes a camera from this library's form. The centre is -R^-1 t, so that R (p - c) = R p + t for this R.
inline NamedCamera own_camera(CameraFields const& fields, CameraEntry& entry)
{
    auto const text = [&](auto const& field, char const* key) { return field.there ? entry.value(field, key) : std::string(); };
    NamedCamera named{text(fields.scene, "scene"), text(fields.file, "file"), entry.name(fields.name, "name"), {}, {}, fields.near.there};
    entry.rename(label(named));
    entry.refuse_distortion(fields);
    auto const& m = entry.value(fields.world_to_camera, "world_to_camera");
    if (!ends_in_0_0_0_1(m)) entry.refuse("the last row of \"world_to_camera\" is not 0 0 0 1");
    Pose pose;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) pose.rotation[column][row] = m[static_cast<std::size_t>(4 * row + column)];
    pose.position = -(glm::inverse(pose.rotation) * glm::dvec3{m[3], m[7], m[11]});
    named.position = pose.position;
    named.camera =
        entry.camera(pose, {entry.value(fields.fx, "fx"), entry.value(fields.fy, "fy"), entry.value(fields.cx, "cx"), entry.value(fields.cy, "cy"),
                            fields.near.there ? static_cast<float>(entry.value(fields.near, "near")) : default_near,
                            entry.pixels(fields.width, "width"), entry.pixels(fields.height, "height"), entry.lens(fields.values)});
    return named;
}

/// Makes a camera from the form that 3DGS training writes: `rotation` is camera to world, row-major; `position` is the centre. The file has
/// no principal point, because the training puts it into the middle of the picture.
inline splat::Camera training_camera(CameraFields const& fields, CameraEntry const& entry)
{
    entry.refuse_distortion(fields);
    auto const& m = entry.value(fields.rotation, "rotation");
    auto const& centre = entry.value(fields.position, "position");
    Pose pose{glm::dmat3{1.0}, {centre[0], centre[1], centre[2]}};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) pose.rotation[row][column] = m[static_cast<std::size_t>(3 * row + column)];
    std::uint32_t const width = entry.pixels(fields.width, "width"), height = entry.pixels(fields.height, "height");
    return entry.camera(pose, {entry.value(fields.fx, "fx"), entry.value(fields.fy, "fy"), 0.5 * width, 0.5 * height, default_near, width, height,
                               entry.lens(fields.values)});
}

/// Reads a JSON camera file part by part. It keeps the cameras before the first unusable one, and the fields of that one. It
/// reports the unusable camera only after the whole text is known to be JSON.
class CameraJson {
public:
    CameraJson(std::istream& stream, std::string const& name, DistortedLens distorted = DistortedLens::kept, PictureSizeOf size_of = {})
        : json_(stream, name), file_(name), distorted_(distorted), transforms_(name), size_of_(std::move(size_of))
    {}

    /// `notes` gets a line for each key that is not read; null: no notes.
    std::vector<NamedCamera> read(std::vector<std::string>* notes)
    {
        Distortion distortion{}; // beside cameras[]: of all of them
        bool list = false, cameras_key = false;
        JsonPart const root = json_.next();
        if (root == JsonPart::begin_list) {
            list = training_ = true;
            read_list();
        }
        while (root == JsonPart::begin_object && json_.next() == JsonPart::key) {
            bool const cameras = json_.text() == "cameras";
            cameras_key = cameras_key || cameras;
            if (json_.text() == "frames") {
                JsonPart const value = json_.next();
                transforms_.clear();
                if (value == JsonPart::begin_list) read_frames();
                else json_.skip(value), transforms_.add_no_object();
                continue;
            }
            if (read_lens(transforms_.common, &distortion)) continue;
            if (auto const key = place_of(json_.text(), split_keys); key < std::size(split_keys)) {
                read_split(std::string(split_keys[key]), key == 0 ? Split::training : Split::held_out);
                continue;
            }
            if (!cameras && place_of(json_.text(), beside_frames_keys) == std::size(beside_frames_keys)) unread_beside_frames_.see(json_.text(), 0);
            JsonPart const value = json_.next();
            if (cameras) list = value == JsonPart::begin_list;
            if (cameras && list) read_list();
            else json_.skip(value);
        }
        json_.next(); // the end

        if (!cameras_key && transforms_.there()) {
            auto cameras = transforms_.take(distorted_, notes, size_of_);
            if (notes != nullptr) {
                unread_of_frames_.add_to(*notes);
                unread_beside_frames_.add_to_as_of_file(*notes);
            }
            return cameras;
        }
        if (!list)
            throw Error(file_ + " is not a camera file (it has no list \"cameras\" or \"frames\", and is no list itself); name a JSON file with "
                                "cameras[], a transforms.json, the cameras.json of a 3DGS training, or a COLMAP model");
        bool const all_bent = std::find(distortion.begin(), distortion.end(), true) != distortion.end();
        if (!transforms_.common.model.empty()) throw Error(file_ + " " + fault_of_projection(transforms_.common.model));
        if (distorted_ == DistortedLens::refused) refuse_distortion(distortion, file_);
        if (distorted_ == DistortedLens::kept && all_bent)
            throw Error(file_ + " has a lens with distortion beside its list of cameras (its \"" +
                        std::string(distortion_keys[std::find(distortion.begin(), distortion.end(), true) - distortion.begin()]) +
                        "\"); write the coefficients into each camera");
        if (training_) finish_names();
        std::set<std::string> labels;
        for (std::size_t i = 0; i < cameras_.size(); ++i) {
            if (labels.insert(label(cameras_[i])).second) continue;
            CameraEntry entry(file_, i + 1);
            entry.rename(label(cameras_[i]));
            entry.refuse("another camera has the same scene and name");
        }
        if (unusable_) convert(*unusable_); // throws
        if (distorted_ == DistortedLens::ignored) note_ignored_distortion(all_bent ? cameras_.size() : bent_, notes);
        if (notes != nullptr) unread_.add_to(*notes);
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
        bent_ = 0;
        unusable_.reset();
        unread_ = {};
        std::size_t number = 0;
        for (JsonPart part; (part = json_.next()) != JsonPart::end_list;) {
            if (++number > most_cameras) throw Error(file_ + " has too many cameras (more than " + std::to_string(most_cameras) + "); split it");
            // In the 3DGS form, later names still matter: cameras that share a name are named by their ids.
            if (nameless_ || (unusable_ && !training_)) {
                json_.skip(part);
                continue;
            }
            CameraFields fields;
            fields.object = part == JsonPart::begin_object;
            if (fields.object) read_fields(fields, number);
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
                if (std::find(fields.distortion.begin(), fields.distortion.end(), true) != fields.distortion.end()) ++bent_;
            } catch (Error const&) {
                unusable_ = std::move(fields);
            }
        }
    }

    /// Converts the entry after the last camera that is kept.
    NamedCamera convert(CameraFields const& fields) const
    {
        CameraEntry entry(file_, cameras_.size() + 1, distorted_);
        if (!fields.object) entry.refuse("it is not an object");
        if (!training_) return own_camera(fields, entry);
        entry.rename(names_[cameras_.size()].name);
        auto const camera = training_camera(fields, entry); // checks the fields
        auto const& centre = fields.position.value;
        return {"", "", "", camera, glm::dvec3{centre[0], centre[1], centre[2]}};
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

    /// Reads a value of a lens of transforms.json, if the key that was read names one. `whole` gets what the key means for cameras[].
    bool read_lens(TransformsLens& lens, Distortion* whole = nullptr)
    {
        auto const key = json_.text();
        if (auto* const field = lens.field(key)) {
            json_.read(*field);
            return true;
        }
        if (key == "equirectangular" || key == "latlong" || key == "orthographic") { // instant-ngp: true or false
            auto const part = json_.next();
            if (part == JsonPart::other && json_.text() == "true") lens.model = key;
            json_.skip(part);
            return true;
        }
        auto const at = place_of(key, distortion_keys);
        if (at == std::size(distortion_keys)) return false;
        bool named = false;
        bool const bends = json_.read_distortion(lens.model, lens.values, at, &named);
        lens.set_distortion(at, named);
        if (whole != nullptr && at < whole->size()) (*whole)[at] = bends;
        return true;
    }

    /// Reads a list of names of frames. Another value counts as not read.
    void read_split(std::string const& key, Split split)
    {
        JsonPart const list = json_.next();
        bool names = list == JsonPart::begin_list;
        if (!names) json_.skip(list);
        for (JsonPart part; list == JsonPart::begin_list && (part = json_.next()) != JsonPart::end_list;) {
            names = names && part == JsonPart::text;
            if (part == JsonPart::text) transforms_.assign(json_.text(), split);
            else json_.skip(part);
        }
        if (!names) unread_beside_frames_.see(key, 0);
    }

    /// Reads the list "frames" of a transforms.json after its opening bracket.
    void read_frames()
    {
        unread_of_frames_ = {};
        std::size_t number = 0;
        for (JsonPart part; (part = json_.next()) != JsonPart::end_list;) {
            if (number++ == most_cameras) throw Error(file_ + " has too many frames (more than " + std::to_string(most_cameras) + "); split it");
            if (transforms_.ended() || part != JsonPart::begin_object) {
                if (!transforms_.ended()) transforms_.add_no_object();
                json_.skip(part);
                continue;
            }
            CameraField<std::string> path, mask;
            CameraField<std::array<double, 16>> matrix;
            TransformsLens lens;
            while (json_.next() == JsonPart::key) {
                auto const key = json_.text();
                if (key == "file_path") json_.read(path);
                else if (key == "mask_path") {
                    if (json_.read(mask) == JsonPart::other && json_.text() == "null") mask = {}; // no mask
                } else if (key == "transform_matrix") json_.read_matrix<4>(matrix, "not a 4x4 matrix");
                else if (!read_lens(lens)) {
                    if (place_of(key, beside_camera_keys) == std::size(beside_camera_keys)) unread_of_frames_.see(key, number);
                    json_.skip(json_.next());
                }
            }
            transforms_.add(path, mask, matrix, std::move(lens));
        }
    }

    void read_fields(CameraFields& fields, std::size_t number)
    {
        while (json_.next() == JsonPart::key) {
            std::string_view const key = json_.text();
            if (auto const bent = place_of(key, distortion_keys); bent < fields.distortion.size()) {
                fields.distortion[bent] = json_.read_distortion(fields.model, fields.values, bent);
                continue;
            }
            if (training_ ? place_of(key, training_keys) == std::size(training_keys) : place_of(key, own_keys) == std::size(own_keys))
                unread_.see(json_.text(), number);
            if (key == "fx") json_.read(fields.fx);
            else if (key == "fy") json_.read(fields.fy);
            else if (key == "cx") json_.read(fields.cx);
            else if (key == "cy") json_.read(fields.cy);
            else if (key == "near") json_.read(fields.near);
            else if (key == "width") json_.read(fields.width);
            else if (key == "height") json_.read(fields.height);
            else if (key == "scene") json_.read(fields.scene);
            else if (key == "file") json_.read(fields.file);
            else if (key == (training_ ? "img_name" : "name")) json_.read(fields.name);
            else if (key == "id") json_.read_id(fields.id);
            else if (key == "position") json_.read_vector(fields.position, "not 3 numbers");
            else if (key == "rotation") json_.read_matrix<3>(fields.rotation, "not a 3x3 matrix");
            else if (key == "world_to_camera") json_.read_matrix<4>(fields.world_to_camera, "not a 4x4 matrix");
            else json_.skip(json_.next());
        }
    }

    JsonValues json_;
    std::string const& file_;
    bool training_ = false;
    DistortedLens distorted_;
    TransformsFrames transforms_;
    PictureSizeOf size_of_;
    std::vector<NamedCamera> cameras_;
    std::size_t bent_ = 0; ///< of `cameras_`
    std::vector<TrainingName> names_;
    UnreadKeys unread_, unread_of_frames_, unread_beside_frames_;
    std::optional<CameraFields> unusable_, nameless_;
};

}}} // namespace tilemesh::v0_2::scene::detail
