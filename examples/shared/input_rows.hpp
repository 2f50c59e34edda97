#pragma once
#include "inputs.hpp"
#include "option_table.hpp"

/// The rows of the groups of inputs.hpp, and the pairs of options that need or exclude each other.
namespace shared {

// --- maps

inline constexpr auto turns = [] {
    using tilemesh::scene::Turn;
    return std::array<Word, 9>{{{"x90", Turn::x90}, {"x180", Turn::x180}, {"x270", Turn::x270}, {"y90", Turn::y90}, {"y180", Turn::y180},
                                {"y270", Turn::y270}, {"z90", Turn::z90}, {"z180", Turn::z180}, {"z270", Turn::z270}}};
}();
inline constexpr Option<MapInput> map_rows[] = {
    words<&MapInput::turn>("turn", "NAME", "turn the map about an axis by 90, 180 or 270 degrees: x90, x180 ... z270", turns),
    option<&MapInput::sh_degree>("sh-degree", "N", "highest degree of view-dependent colour, {} [the map's]", {0, 3}),
    option<&MapInput::antialias>("antialias", "", "dim each splat as much as the 0.3 pixels enlarge it (maps trained so)")};

// --- cameras

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
    option<&CameraInput::fov>("fov", "DEGREES", "field of view from the left to the right border, {} [60]", {1, 360}, {}, "60",
                              "a field of view is 1 to 179 degrees, through a fisheye to 350"),
    option<&CameraInput::size>("size", "WxH", "size in pixels [the camera's own, or 1280x720]", {1, 65535}, {}, "1280x720"),
    option<&CameraInput::scale>("scale", "N", "divide the sides of the cameras' pictures by N, as trainers do [1]", {1, 1024}),
    option<&CameraInput::near_depth>("near", "D", "the near plane, in world units [the file's; 0.2, or less near the scene]", {1e-30, 1e30}, {}, "0.01",
                                     "a near plane is a distance above 0, in world units"),
    option<&CameraInput::bend>("lens", "KIND[,N...]", "the lens of all cameras: opencv,k1,k2,p1,p2,..., fisheye,k1,..., fov,omega, equirectangular", {0, 255}, {},
                               "opencv,0.26,-0.95", "it takes a kind and coefficients with commas, as opencv,0.26,-0.95 or fisheye"),
    option<&CameraInput::ignores_distortion>("ignore-distortion", "", "take a lens with distortion for a pinhole, although its pictures are bent")};
inline constexpr Pairing camera_pairings[] = {
    {Pairing::needs, "camera", "cameras", "a camera is looked up in a camera file"},
    {Pairing::needs, "list", "cameras", "it prints the names of a camera file"},
    {Pairing::needs, "look", "from", "a camera looks from a point"},
    {Pairing::excludes, "from", "cameras", "each places the camera"},
    {Pairing::excludes, "up", "cameras", "each places the camera"},
    {Pairing::excludes, "fov", "cameras", "each places the camera"},
    {Pairing::excludes, "lens", "ignore-distortion", "each says what the lens is"},
    {Pairing::needs, "ignore-distortion", "cameras", "a camera file says how a lens bends the picture"},
    {Pairing::needs, "scale", "cameras", "it divides the sizes that a camera file has"},
    {Pairing::excludes, "scale", "size", "--size says the size, and --scale divides that of the camera"}};

// --- the motion of a camera

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
    option<&MotionInput::relative>("relative", "", "move the camera as the trajectory moves from its first pose"),
    option<&MotionInput::rolling_shutter>("rolling-shutter", "SECONDS",
                                          "the camera reads the rows of a picture in so many seconds, and moves meanwhile (see below)", {1e-9, 10}, {}, "0.03")};
inline constexpr Pairing motion_pairings[] = {{Pairing::needs, "relative", "trajectory", "it says how to read a trajectory"},
                                              {Pairing::needs, "trajectory-format", "trajectory", "it says how to read a trajectory"},
                                              {Pairing::excludes, "orbit", "trajectory", "each moves the camera"}};

// --- recordings with depth, and pictures that are spoilt as such a camera would

inline constexpr Option<DepthInput> depth_rows[] = {
    option<&DepthInput::depth_levels>("depth-scale", "LEVELS", "levels of the depth pictures a world unit [5000]", {1e-6, 1e9}),
    option<&DepthInput::depth_within>("depth-within", "SECONDS", "a depth of depth.txt is at most so far from its picture [0.02]", {0, 1e9})};
inline constexpr Option<RecordingInput> recording_rows[] = {
    input<&RecordingInput::photos>("photos", "DIR", "real pictures: a folder of the TUM RGB-D benchmark, or an association file"),
    {{"no-depth", "", "colour alone"}, [](RecordingInput& o, OptionValue const&) { o.depth = false; }},
    option<&RecordingInput::noise>("noise", "SIGMA", "{}: noise; above 0 also 8 bits, depth errors, gain drift, motion blur [0.02]", {0, 1}),
    option<&RecordingInput::shutter>("shutter", "SHARE", "{}: the share of a frame's time in which the shutter is open [0.5]", {0, 1}),
    option<&RecordingInput::gain_drift>("gain-drift", "SHARE", "{}: how far the gain drifts [0.1]", {0, 0.9})};

// --- photographs of the cameras

inline constexpr Option<PhotographInput> photograph_rows[] = {
    input<&PhotographInput::photos>("photos", "DIR", "compare with the cameras' photographs: PSNR, SSIM, L1 (see below)"),
    option<&PhotographInput::background>("background", "R,G,B", "the colour behind the Gaussians, {} [0,0,0: black]", {0, 1}, {}, "1,1,1")};
inline constexpr Pairing photograph_pairings[] = {
    {Pairing::needs, "photos", "cameras", "a camera file names the photographs"}};

// --- the host

inline constexpr Option<HostInput> host_rows[] = {
    option<&HostInput::threads>("threads", "N", "number of host threads [1]", {1, most_threads}),
    option<&HostInput::quiet>("quiet", "", "print errors only"),
    option<&HostInput::help>("help", "", "print this text")};

/// Reads a command line. False: there is nothing to run, because the help, or the names of cameras, are printed.
bool read_command_line(OptionTable& table, HostInput& host, CameraInput const* cameras, int argc, char** argv);

} // namespace shared
