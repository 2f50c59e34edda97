#pragma once
#include <filesystem>
#include <istream>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

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
                                                   std::string const& cameras_name = "cameras.txt", std::string const& images_name = "images.txt",
                                                   DistortedLens distorted = DistortedLens::kept, std::vector<std::string>* notes = nullptr);

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
                                                          DistortedLens distorted = DistortedLens::kept, std::vector<std::string>* notes = nullptr);

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
TILEMESH_HOST std::vector<NamedCamera> load_colmap(std::filesystem::path const& path, DistortedLens distorted = DistortedLens::kept,
                                                   std::vector<std::string>* notes = nullptr);

}}} // namespace tilemesh::scene

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/colmap_code.hpp>
#endif
