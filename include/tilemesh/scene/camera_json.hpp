#pragma once
#include <filesystem>
#include <functional>
#include <istream>
#include <optional>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/scene/colmap.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// The size of the picture of a frame of a transforms.json, from its `file_path`; nothing if it is not known.
using PictureSizeOf = std::function<std::optional<Size>(std::string const&)>;

/// Where the cameras of a project's folder are: in the folder, or in sparse/0, sparse, colmap/sparse/0 or transforms.json below it. Any
/// other path is returned as it is.
TILEMESH_HOST std::filesystem::path found_cameras(std::filesystem::path const& path);

/// Reads cameras in JSON. They follow the OpenCV convention; pixel (i, j) has its centre at (i + 0.5, j + 0.5). The content tells which of
/// three forms a file has:
/// - the form of this library: `cameras[]` with name, width, height, fx, fy, cx, cy, `world_to_camera` (4x4, row-major), and optionally scene,
///   file and near (default 0.2);
/// - the cameras.json that 3DGS training writes: a list of img_name, width, height, fx, fy, `position`, `rotation` (3x3, camera to world) and
///   id. The principal point is the middle of the picture, there is no scene, and near is 0.2. The camera's name is img_name, or
///   "img_name#id" if several cameras share an img_name;
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
TILEMESH_HOST std::vector<NamedCamera> read_cameras_json(std::istream& stream, std::string const& name, std::vector<std::string>* notes = nullptr,
                                                         DistortedLens distorted = DistortedLens::kept, PictureSizeOf const& size_of = {});

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
TILEMESH_HOST std::vector<NamedCamera> load_cameras(std::filesystem::path const& path, std::vector<std::string>* notes = nullptr,
                                                    DistortedLens distorted = DistortedLens::kept, std::optional<Size> size = {},
                                                    std::vector<std::filesystem::path>* pictures = nullptr);

}}} // namespace tilemesh::v0_2::scene

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/camera_json_code.hpp>
#endif
