#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/rgbd_list.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <tilemesh/splat/rules.hpp>
#include <vector>

/// What programs read, in groups: maps, cameras, the motion of a camera, recordings with depth, photographs. A program takes a group as a
/// whole; an option that makes no sense in it stands in its table with the reason (`OptionTable::without`).
namespace shared {

// --- maps

struct MapInput {
    std::optional<tilemesh::scene::Turn> turn; ///< of the map, about the origin
    std::uint32_t sh_degree = 3;               ///< the highest degree
    bool antialias = false;
    tilemesh::splat::Coverage coverage() const { return antialias ? tilemesh::splat::Coverage::preserved : tilemesh::splat::Coverage::of_record; }
};

/// Loads the maps, joined and turned; without a path, the built-in one. Far means are moved (`scene::FarMeans::moved`). With `antialias`,
/// no note advises it.
tilemesh::scene::Map load_maps(std::vector<std::filesystem::path> const& paths, MapInput const& in);
tilemesh::scene::Map turned(tilemesh::scene::Map map, MapInput const& in);
/// Drops the degrees above --sh-degree. A note says so.
tilemesh::scene::Map at_degree(tilemesh::scene::Map map, MapInput const& in, std::vector<std::string>& notes);
/// All of that for a program that follows slopes, with the notes of the map.
tilemesh::scene::Map load_map(std::optional<std::filesystem::path> const& path, MapInput const& in, std::vector<std::string>& notes);

// --- cameras

struct CameraInput {
    std::optional<std::filesystem::path> cameras;
    std::string camera; ///< SCENE/NAME, or NAME if it is unique; empty: all of the map's scene
    bool list = false;  ///< print the names of the camera file, and do nothing else
    /// A camera without a file. Empty: the middle of the map, guessed positions, y down, 60 degrees.
    std::optional<std::array<double, 3>> from, look, up;
    std::optional<double> fov;
    std::optional<tilemesh::scene::Size> size;
    std::uint32_t scale = 1;         ///< divides the sides of the camera file's pictures
    std::optional<float> near_depth; ///< of all cameras
    bool ignores_distortion = false;
    std::string bend{};   ///< of all cameras, as scene::lens_of_text reads it; empty: their own
    bool bends = false; ///< the program renders through any lens; otherwise a lens that bends is refused
    tilemesh::scene::DistortedLens lens() const
    {
        using tilemesh::scene::DistortedLens;
        return ignores_distortion || !bend.empty() ? DistortedLens::ignored : bends ? DistortedLens::kept : DistortedLens::refused;
    }
};

/// The middle of a map, and the camera that shows all of it (scene/frame_whole.hpp).
struct MapShape {
    std::string name;
    std::function<glm::dvec3()> centre;
    std::function<tilemesh::splat::Camera(tilemesh::scene::Size, glm::dvec3 up, double degrees)> whole;
    std::function<float(tilemesh::splat::Camera const&)> near_plane; ///< for a camera whose file names none (scene/near_plane.hpp)
    std::array<double, 3> origin{}; ///< the reader of the map has subtracted it
};
/// The shape of a map in this process. The map must outlive it.
MapShape shape_of(tilemesh::scene::Map const& map);

/// The names of the camera file, one per line, in its order. Throws `tilemesh::Error` for a file that cannot be used.
std::string camera_names(CameraInput const& in);

/// The cameras of --cameras and --camera, in the coordinates of the map, with their near planes, in their own sizes; at least one. Notes of
/// the reader go to `notes`; the pictures from which it took sizes, and the masks, go to `sized_by`. `size`: of cameras whose file says none.
/// `all`, if it is not null, gets the names of all cameras of the same scenes.
std::vector<tilemesh::scene::NamedCamera> load_cameras(CameraInput const& in, MapShape const& map, std::optional<tilemesh::scene::Size> size,
                                                       std::vector<std::string>& notes, std::vector<std::filesystem::path>& sized_by,
                                                       std::vector<std::string>* all = nullptr);

/// What each of these cameras, in the order of their names, is for: its file says so, or else one in `every` is held out, from the first. A
/// note says that the file decides; `given`: --every is on the command line, and does nothing then.
std::vector<tilemesh::scene::Split> splits_of(std::vector<tilemesh::scene::NamedCamera> const& cameras, std::uint32_t every, bool given,
                                              std::vector<std::string>& notes);

/// The camera without a file: of --from, --look, --up and --fov, or one that shows all of the map. `built_in`: the map has a camera of its
/// own.
tilemesh::splat::Camera placed_camera(CameraInput const& in, MapShape const& map, tilemesh::scene::Size size, bool built_in);
glm::dvec3 up_of(CameraInput const& in);

/// Every file that a run reads: `inputs`, the files of maps and of a COLMAP model, and `more`. A folder stands for its files. Call it after
/// the readers: it throws `tilemesh::Error` as they do.
std::vector<std::filesystem::path> files_read(std::vector<std::filesystem::path> const& inputs, CameraInput const& in,
                                              std::vector<std::filesystem::path> const& maps, std::vector<std::filesystem::path> more);

/// The file's name before each note.
void add_notes(std::vector<std::string>& to, std::filesystem::path const& file, std::vector<std::string> const& notes);

// --- the motion of a camera

/// The most frames of a run. With more frames, the list of cameras alone takes more memory than a large map.
inline constexpr std::uint32_t most_frames = 1'000'000;

struct MotionInput {
    std::optional<double> orbit_degrees; ///< per frame
    std::uint32_t frames = 0;            ///< 0: all
    std::optional<std::filesystem::path> trajectory;
    std::optional<tilemesh::scene::TrajectoryFormat> trajectory_format; ///< empty: the file tells it
    std::optional<std::uint32_t> every; ///< every so many-th pose, picture or camera by name, from the first; empty: all
    bool relative = false;
    std::optional<double> rolling_shutter; ///< seconds in which the rows are read; empty: all at once
    std::uint32_t step() const noexcept { return every.value_or(1); }
};

// --- recordings with depth, and pictures that are spoilt as such a camera would

/// The lists that a folder of pictures with depth may have.
inline constexpr char const* rgbd_lists[] = {"associations.txt", "rgb.txt", "depth.txt"};
/// How depth pictures are read.
struct DepthInput {
    double depth_levels = 5000.0;                              ///< a world unit
    double depth_within = tilemesh::scene::most_seconds_apart; ///< the furthest that a depth of a depth.txt is from its picture, in seconds
};
struct RecordingInput : DepthInput {
    std::optional<std::filesystem::path> photos; ///< none: pictures are rendered
    double noise = 0.02, shutter = 0.5, gain_drift = 0.1;
    bool depth = true;
};

// --- photographs of the cameras

struct PhotographInput {
    std::optional<std::filesystem::path> photos; ///< the folder
    std::optional<std::array<float, 3>> background;
};

// --- the host

/// More threads than any host has. A typing error should not start a million threads.
inline constexpr std::uint32_t most_threads = 1024;

struct HostInput {
    std::uint32_t threads = 1;
    bool quiet = false, help = false;
    std::vector<std::filesystem::path> inputs; ///< every path of a file that is read, as the user gave it
};

} // namespace shared
