#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <istream>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
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
TILEMESH_HOST void refuse_distortion(Distortion const& distortion, std::string const& whose);

/// The keys that nobody reads: at most `most` by name, each with the number of cameras that have it.
class UnreadKeys {
public:
    static constexpr std::size_t most = 8, longest = 40;

    /// `camera`: the number of the camera that has the key.
    TILEMESH_HOST void see(std::string const& key, std::size_t camera);
    /// One line for each key.
    TILEMESH_HOST void add_to(std::vector<std::string>& notes) const;
    /// The same for keys of the whole file.
    TILEMESH_HOST void add_to_as_of_file(std::vector<std::string>& notes) const;

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

    [[noreturn]] TILEMESH_HOST void refuse(std::string const& why) const;

    TILEMESH_HOST void refuse_distortion(CameraFields const& fields) const;
    /// The lens that these values describe, if lenses are kept.
    TILEMESH_HOST splat::Lens lens(LensValues const& values) const;

    template <class T>
    T const& value(CameraField<T> const& field, char const* key) const
    {
        if (!field.there) refuse(std::string("it has no \"") + key + "\"");
        if (field.fault != nullptr) refuse(in_quotes_is(key) + field.fault);
        return field.value;
    }

    TILEMESH_HOST std::string name(CameraField<std::string> const& field, char const* key) const;

    TILEMESH_HOST std::uint32_t pixels(CameraField<double> const& field, char const* key) const;

    TILEMESH_HOST splat::Camera camera(Pose const& pose, Intrinsics const& lens) const;

private:
    static std::string in_quotes_is(char const* key) { return std::string("\"") + key + "\" is "; }

    std::string const& file_;
    std::string name_;
    DistortedLens distorted_;
};

/// Makes a camera from this library's form. The centre is -R^-1 t, so that R (p - c) = R p + t for this R.
TILEMESH_HOST NamedCamera own_camera(CameraFields const& fields, CameraEntry& entry);

/// Makes a camera from the form that 3DGS training writes: `rotation` is camera to world, row-major; `position` is the centre. The file has
/// no principal point, because the training puts it into the middle of the picture.
TILEMESH_HOST splat::Camera training_camera(CameraFields const& fields, CameraEntry const& entry);

/// Reads a JSON camera file part by part. It keeps the cameras before the first unusable one, and the fields of that one. It
/// reports the unusable camera only after the whole text is known to be JSON.
class CameraJson {
public:
    CameraJson(std::istream& stream, std::string const& name, DistortedLens distorted = DistortedLens::kept, PictureSizeOf size_of = {})
        : json_(stream, name), file_(name), distorted_(distorted), transforms_(name), size_of_(std::move(size_of))
    {}

    /// `notes` gets a line for each key that is not read; null: no notes.
    TILEMESH_HOST std::vector<NamedCamera> read(std::vector<std::string>* notes);

private:
    struct TrainingName {
        std::string name;
        CameraField<std::string> id;
    };

    /// Reads a list after its opening bracket. The list replaces one that was read before.
    TILEMESH_HOST void read_list();

    /// Converts the entry after the last camera that is kept.
    TILEMESH_HOST NamedCamera convert(CameraFields const& fields) const;

    /// Names the cameras that 3DGS training wrote: img_name, or img_name#id for cameras that share an img_name. The training leaves out the
    /// folder, so pictures of several folders often share an img_name.
    TILEMESH_HOST void finish_names();

    /// Reads a value of a lens of transforms.json, if the key that was read names one. `whole` gets what the key means for cameras[].
    TILEMESH_HOST bool read_lens(TransformsLens& lens, Distortion* whole = nullptr);

    /// Reads a list of names of frames. Another value counts as not read.
    TILEMESH_HOST void read_split(std::string const& key, Split split);

    /// Reads the list "frames" of a transforms.json after its opening bracket.
    TILEMESH_HOST void read_frames();

    TILEMESH_HOST void read_fields(CameraFields& fields, std::size_t number);

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

}}} // namespace tilemesh::scene::detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/camera_list_code.hpp>
#endif
