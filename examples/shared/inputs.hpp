#pragma once
#include "option_table.hpp"
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <vector>

/// What programs read, in groups: maps, cameras, the motion of a camera, recordings with depth, photographs. A program takes a group as a
/// whole; an option that makes no sense in it stands in its table with the reason (`OptionTable::without`).
namespace shared {

// --- maps

struct MapInput {
    std::optional<tilemesh::scene::Turn> turn; ///< of the map, about the origin
    std::uint32_t sh_degree = 3;               ///< the highest degree
    bool antialias = false;
};
inline constexpr auto turns = [] {
    using tilemesh::scene::Turn;
    return std::array<Word, 9>{{{"x90", Turn::x90}, {"x180", Turn::x180}, {"x270", Turn::x270}, {"y90", Turn::y90}, {"y180", Turn::y180},
                                {"y270", Turn::y270}, {"z90", Turn::z90}, {"z180", Turn::z180}, {"z270", Turn::z270}}};
}();
inline constexpr Option<MapInput> map_rows[] = {
    words<&MapInput::turn>("turn", "NAME", "turn the map about an axis by 90, 180 or 270 degrees: x90, x180 ... z270", turns),
    option<&MapInput::sh_degree>("sh-degree", "N", "highest degree of view-dependent colour, {} [the map's]", {0, 3}),
    option<&MapInput::antialias>("antialias", "", "dim each splat as much as the 0.3 pixels enlarge it (maps trained so)")};

/// Why programs that follow slopes do not take --antialias.
inline constexpr std::string_view no_slope = "opacities would depend on the sizes of splats in pixels, and no slope says how";

/// Loads the maps, joined and turned; without a path, the built-in one. Far means are moved (`scene::FarMeans::moved`).
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
    tilemesh::scene::DistortedLens lens() const
    {
        return ignores_distortion ? tilemesh::scene::DistortedLens::ignored : tilemesh::scene::DistortedLens::refused;
    }
};
inline constexpr Option<CameraInput> camera_rows[] = {
    input<&CameraInput::cameras>("cameras", "FILE", "a camera file, a COLMAP model, or its folder"),
    option<&CameraInput::camera>("camera", "SCENE/NAME", "one camera of that file; NAME alone is enough if it is unique", {0, 255}, {}, "front",
                                 "it takes SCENE/NAME, 1 to 255 bytes"),
    option<&CameraInput::list>("list", "", "print the names of that file's cameras, one per line, and nothing else"),
    option<&CameraInput::from>("from", "X,Y,Z", "stand at this point of the world, without a camera file", {-1e30, 1e30}, {}, "0,-1,0",
                               "it takes X,Y,Z, three numbers within 1e30 in world units"),
    option<&CameraInput::look>("look", "X,Y,Z", "look from there at this point [the map's middle]", {-1e30, 1e30}, {}, "0,-1,0",
                               "it takes X,Y,Z, three numbers within 1e30 in world units"),
    option<&CameraInput::up>("up", "X,Y,Z", "the direction that is up in the map, as 0,1,0 [0,-1,0: y points down]", {-1e30, 1e30}, {}, "0,-1,0",
                             "it takes X,Y,Z, three numbers within 1e30 in world units"),
    option<&CameraInput::fov>("fov", "DEGREES", "field of view from the left to the right border, {} [60]", {1, 179}, {}, "60",
                              "a field of view is 1 to 179 degrees"),
    option<&CameraInput::size>("size", "WxH", "size in pixels [the camera's own, or 1280x720]", {1, 65535}, {}, "1280x720"),
    option<&CameraInput::scale>("scale", "N", "divide the sides of the cameras' pictures by N, as trainers do [1]", {1, 1024}),
    option<&CameraInput::near_depth>("near", "D", "the near plane, in world units [the file's; 0.2, or less near the scene]", {1e-30, 1e30}, {}, "0.01",
                                     "a near plane is a distance above 0, in world units"),
    option<&CameraInput::ignores_distortion>("ignore-distortion", "", "take a lens with distortion for a pinhole, although its pictures are bent")};
inline constexpr Pairing camera_pairings[] = {
    {Pairing::needs, "camera", "cameras", "a camera is looked up in a camera file"},
    {Pairing::needs, "list", "cameras", "it prints the names of a camera file"},
    {Pairing::needs, "look", "from", "a camera looks from a point"},
    {Pairing::excludes, "from", "cameras", "each places the camera"},
    {Pairing::excludes, "up", "cameras", "each places the camera"},
    {Pairing::excludes, "fov", "cameras", "each places the camera"},
    {Pairing::needs, "ignore-distortion", "cameras", "a camera file says how a lens bends the picture"},
    {Pairing::needs, "scale", "cameras", "it divides the sizes that a camera file has"},
    {Pairing::excludes, "scale", "size", "--size says the size, and --scale divides that of the camera"}};

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
/// the reader go to `notes`, and the pictures from which it took sizes to `sized_by`. `size`: of cameras whose file says none.
std::vector<tilemesh::scene::NamedCamera> load_cameras(CameraInput const& in, MapShape const& map, std::optional<tilemesh::scene::Size> size,
                                                       std::vector<std::string>& notes, std::vector<std::filesystem::path>& sized_by);

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
    std::uint32_t step() const noexcept { return every.value_or(1); }
};
inline constexpr auto trajectory_formats = [] {
    using tilemesh::scene::TrajectoryFormat;
    return std::array<Word, 4>{{{"tum", TrajectoryFormat::tum}, {"euroc", TrajectoryFormat::euroc}, {"kitti", TrajectoryFormat::kitti},
                                {"replica", TrajectoryFormat::replica}}};
}();
inline constexpr Option<MotionInput> motion_rows[] = {
    option<&MotionInput::orbit_degrees>("orbit", "DEGREES", "turn the camera around the map's middle, by DEGREES per frame", {0, 0, "degrees"}, {}, "0.5"),
    option<&MotionInput::frames>("frames", "N", "render N frames of the orbit, or the first N poses (see --every)", {1, most_frames}),
    input<&MotionInput::trajectory>("trajectory", "FILE", "poses, camera to world (see below)"),
    words<&MotionInput::trajectory_format>("trajectory-format", "NAME", "the form of that file: {} [the file tells it]", trajectory_formats),
    option<&MotionInput::every>("every", "N", "every Nth pose or picture, from the first [1]", {1, any_number}),
    option<&MotionInput::relative>("relative", "", "move the camera as the trajectory moves from its first pose")};
inline constexpr Pairing motion_pairings[] = {{Pairing::needs, "relative", "trajectory", "it says how to read a trajectory"},
                                              {Pairing::needs, "trajectory-format", "trajectory", "it says how to read a trajectory"},
                                              {Pairing::excludes, "orbit", "trajectory", "each moves the camera"}};

// --- recordings with depth, and pictures that are spoilt as such a camera would

struct RecordingInput {
    std::optional<std::filesystem::path> photos; ///< none: pictures are rendered
    double depth_levels = 5000.0, noise = 0.02, shutter = 0.5, gain_drift = 0.1;
    bool depth = true;
};
inline constexpr Option<RecordingInput> recording_rows[] = {
    input<&RecordingInput::photos>("photos", "DIR", "real pictures: a folder of the TUM RGB-D benchmark, or an association file"),
    option<&RecordingInput::depth_levels>("depth-scale", "LEVELS", "levels of the depth pictures a world unit [5000]", {1e-6, 1e9}),
    {{"no-depth", "", "colour alone"}, [](RecordingInput& o, OptionValue const&) { o.depth = false; }},
    option<&RecordingInput::noise>("noise", "SIGMA", "{}: noise; above 0 also 8 bits, depth errors, gain drift, motion blur [0.02]", {0, 1}),
    option<&RecordingInput::shutter>("shutter", "SHARE", "{}: the share of a frame's time in which the shutter is open [0.5]", {0, 1}),
    option<&RecordingInput::gain_drift>("gain-drift", "SHARE", "{}: how far the gain drifts [0.1]", {0, 0.9})};

// --- photographs of the cameras

struct PhotographInput {
    std::optional<std::filesystem::path> photos; ///< the folder
    std::optional<std::array<float, 3>> background;
};
inline constexpr Option<PhotographInput> photograph_rows[] = {
    input<&PhotographInput::photos>("photos", "DIR", "compare with the cameras' photographs: PSNR, SSIM, L1 (see below)"),
    option<&PhotographInput::background>("background", "R,G,B", "the colour behind the Gaussians, {} [0,0,0: black]", {0, 1}, {}, "1,1,1")};
inline constexpr Pairing photograph_pairings[] = {
    {Pairing::needs, "photos", "cameras", "a camera file names the photographs"}};

// --- the host

/// More threads than any host has. A typing error should not start a million threads.
inline constexpr std::uint32_t most_threads = 1024;

struct HostInput {
    std::uint32_t threads = 1;
    bool quiet = false, help = false;
    std::vector<std::filesystem::path> inputs; ///< every path of a file that is read, as the user gave it
};
inline constexpr Option<HostInput> host_rows[] = {
    option<&HostInput::threads>("threads", "N", "number of host threads [1]", {1, most_threads}),
    option<&HostInput::quiet>("quiet", "", "print errors only"),
    option<&HostInput::help>("help", "", "print this text")};

/// Reads a command line. False: there is nothing to run, because the help, or the names of cameras, are printed.
bool read_command_line(OptionTable& table, HostInput& host, CameraInput const* cameras, int argc, char** argv);

} // namespace shared
