#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <istream>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/bytes.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
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
TILEMESH_HOST bool take_number(std::string_view& text, double& value);

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

    TILEMESH_HOST void add_lens(std::string const& place, std::uint32_t id, ColmapModel const& model, Size size,
                                double const* parameters);

    /// `turn_and_shift`: QW QX QY QZ TX TY TZ, world to camera. `image_id`: IMAGE_ID.
    TILEMESH_HOST void add_image(std::string const& place, std::uint32_t image_id, std::array<double, 7> const& turn_and_shift,
                                 std::uint32_t lens_id, std::string name);

    TILEMESH_HOST std::vector<NamedCamera> take(std::vector<std::string>* notes);
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
TILEMESH_HOST void read_colmap_lenses(std::istream& stream, std::string const& name, ColmapCameras& cameras);

/// Skips the line of 2-D points that follows an image: triples of two numbers and an integer, of any length; at the end of the file the
/// line may be missing. Returns false for any other line, such as the next image.
TILEMESH_HOST bool skip_colmap_points(LineReader& lines);

/// Reads the entries of a binary file of a model: a count, then as many entries.
class ColmapBytes {
public:
    /// `entry` names an entry in errors: "camera".
    TILEMESH_HOST ColmapBytes(std::istream& stream, std::string const& name, std::string entry);

    /// Goes to the next entry; false after the last. Throws `Error` if bytes follow the last.
    TILEMESH_HOST bool next();

    template <class T>
    T number()
    {
        return number_at<T>(take(sizeof(T)));
    }
    /// False if the number is not finite, or too large.
    TILEMESH_HOST bool take_double(double& value);
    /// A text that a byte 0 ends, at most 64 KiB.
    TILEMESH_HOST std::string text();
    TILEMESH_HOST void skip(std::uint64_t items, std::uint64_t bytes_of_item);

    /// "cameras.bin camera 3"
    std::string place() const { return name_ + " " + entry_ + " " + std::to_string(number_); }
    [[noreturn]] TILEMESH_HOST void refuse(std::string const& why) const;

private:
    [[noreturn]] TILEMESH_HOST void refuse_end() const;
    TILEMESH_HOST unsigned char const* take(std::size_t bytes);

    ByteSource source_;
    std::string name_, entry_;
    std::uint64_t number_ = 0, count_;
};

} // namespace detail

/// Reads the text model of COLMAP: the lenses of cameras.txt and the poses of images.txt. An image takes two lines in images.txt. The first
/// is `IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME`, world to camera. The second lists the image's 2-D points; it is skipped; it may be
/// empty but must exist, except at the end of the file. NAME is the rest of its line, including blanks. COLMAP's pixel (0, 0) has its
/// centre at (0.5, 0.5), as in this library. The cameras have no scene; near is 0.2. A lens whose coefficients are all 0 is a pinhole,
/// except for a fisheye projection. With `DistortedLens::ignored`, every lens is taken for a pinhole, and a note counts the cameras. Images of one
/// IMAGE_ID are all read, because NAME tells them apart here; a note counts them, because other programs keep one of them.
///
/// Throws `Error`, one line that names file and line, for a lens with distortion if it is refused, for one that there is not (thin prisms) or that
/// folds within the picture if it is kept, for a CAMERA_ID that cameras.txt does not have, a NAME that
/// occurs twice or is not UTF-8, and numbers that are missing, not finite or not valid for a camera. `cameras_name` and `images_name` are
/// the files' names in errors. Cost: one pass over each file; memory for the cameras only.
TILEMESH_HOST std::vector<NamedCamera> read_colmap(std::istream& cameras_txt, std::istream& images_txt,
                                                   std::string const& cameras_name = "cameras.txt",
                                                   std::string const& images_name = "images.txt",
                                                   DistortedLens distorted = DistortedLens::kept,
                                                   std::vector<std::string>* notes = nullptr);

/// Reads the binary model of COLMAP (little endian), as `read_colmap` reads the text model:
/// - cameras.bin: a 64-bit count; for each camera CAMERA_ID and MODEL_ID (32 bits), WIDTH and HEIGHT (64 bits), the parameters (doubles);
/// - images.bin: a 64-bit count; for each image IMAGE_ID (32 bits), QW QX QY QZ TX TY TZ (doubles), CAMERA_ID (32 bits), NAME and a byte 0,
///   a 64-bit count of 2-D points, and 24 bytes for each of them, which are skipped.
///
/// Throws `Error` as `read_colmap` does, but names the camera or image by its number in the file; also for a file that ends early or has
/// bytes after its last entry. The streams must be seekable. Cost: one pass over each file; memory for the cameras, and 1 MiB.
TILEMESH_HOST std::vector<NamedCamera> read_colmap_binary(std::istream& cameras_bin, std::istream& images_bin,
                                                          std::string const& cameras_name = "cameras.bin",
                                                          std::string const& images_name = "images.bin",
                                                          DistortedLens distorted = DistortedLens::kept,
                                                          std::vector<std::string>* notes = nullptr);

/// Is this path a COLMAP model: a directory, or a file with the name of one of a model's files?
TILEMESH_HOST bool names_colmap(std::filesystem::path const& path);

/// The two files of a COLMAP model that are read.
struct ColmapFiles {
    std::filesystem::path cameras, images;
};
/// The files of the model that `path` names: a model's folder, or one of its files. A folder with both forms stands for its text model.
TILEMESH_HOST ColmapFiles colmap_files(std::filesystem::path const& path);

/// Reads a COLMAP model, text or binary, as `read_colmap` and `read_colmap_binary` do. `path` is the model's folder, or one of its files; of
/// a folder with both forms it reads the text model. Throws `Error` if one of the two files is missing. images.txt and images.bin may have
/// any length, because their 2-D points are long. `notes`, which may be null, gets a line if the folder has both forms, and if
/// its name is a number and models with other numbers lie beside it.
TILEMESH_HOST std::vector<NamedCamera> load_colmap(std::filesystem::path const& path,
                                                   DistortedLens distorted = DistortedLens::kept,
                                                   std::vector<std::string>* notes = nullptr);

}}} // namespace tilemesh::scene

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/colmap_code.hpp>
#endif
