#include "scenes.hpp"
#include "statistics.hpp"
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/scene/ply.hpp>
#include <tilemesh/scene/records.hpp>
#include <tilemesh/scene/trajectory.hpp>

namespace bench {

namespace {

namespace fs = std::filesystem;
namespace scene = tilemesh::scene;

fs::path map_file(std::string const& name, fs::path const& data)
{
    return data / "maps" / (name + ".ply");
}
fs::path trajectory_file(std::string const& name, fs::path const& data)
{
    return data / "trajectories" / (name + ".tum");
}
bool is_authors(std::string const& name)
{
    return name == "sloth" || name == "salad";
}
/// The millions of Gaussians of a densified built-in map; 0 for another name.
std::uint32_t millions(std::string const& name)
{
    return name == "built_in_1m" ? 1 : name == "built_in_5m" ? 5 : 0;
}

} // namespace

bool has_scene(std::string const& name, fs::path const& data)
{
    if (name == "built_in" || millions(name) != 0) return true;
    return !data.empty() && fs::exists(map_file(name, data)) && (!is_authors(name) || fs::exists(data / "cameras.json"));
}

bool has_motion(std::string const& motion, fs::path const& data)
{
    return (motion != "fr1_xyz" && motion != "fr2_desk") || (!data.empty() && fs::exists(trajectory_file(motion, data)));
}

Scene load_scene(std::string const& name, fs::path const& data, scene::Size size)
{
    if (name == "built_in") return {scene::built_in_map(), scene::built_in_camera(size)};
    if (auto const n = millions(name); n != 0) {
        auto map = densified(scene::built_in_map(), n * 1'000'000);
        map.name = name;
        return {std::move(map), scene::built_in_camera(size)};
    }
    if (!is_authors(name)) return load_file(map_file(name, data), size);
    auto map = scene::load_ply(map_file(name, data));
    auto const chosen = scene::select_cameras(scene::load_cameras(data / "cameras.json"), name + "/benchmark", name);
    return {std::move(map), scene::resized(chosen.front().camera, size.width, size.height)};
}

Scene load_file(fs::path const& file, scene::Size size)
{
    auto map = scene::at_degree(scene::load_ply(file), 0);
    auto const camera = scene::frame_whole(map, size);
    return {std::move(map), camera};
}

std::vector<tilemesh::splat::Camera> cameras_of(std::string const& motion, Scene const& scene_, std::uint32_t frames, fs::path const& data)
{
    auto const& start = scene_.camera;
    std::vector<tilemesh::splat::Camera> cameras{start};
    if (motion == "static") {
        cameras.resize(frames + 1, start);
    } else if (motion.rfind("orbit", 0) == 0) {
        auto const degrees = tilemesh::number_of<double>(std::string_view(motion).substr(5)).value_or(NAN);
        cameras = scene::orbit(start, scene::robust_centre(scene_.map), degrees, frames + 1);
    } else if (auto const jumps = trajectory_file(scene_.map.name + "_teleport", data);
               motion == "teleport" && is_authors(scene_.map.name) && fs::exists(jumps)) {
        auto const poses = scene::load_tum(jumps);
        for (std::uint32_t i = 0; i < frames; ++i)
            cameras.push_back(scene::make_camera(poses[i % poses.size()].pose, scene::lens_of(start)));
    } else if (motion == "teleport") {
        // Multiples of the golden angle: for any number of frames, no two frames are close to each other.
        for (std::uint32_t i = 0; i < frames; ++i)
            cameras.push_back(scene::orbit(start, scene::robust_centre(scene_.map), 137.50776405 * (i + 1), 2).back());
    } else {
        auto poses = scene::load_tum(trajectory_file(motion, data));
        poses.resize(std::min<std::size_t>(poses.size(), frames + 1));
        poses = scene::relative_to_first(std::move(poses), scene::pose_of(start));
        for (std::size_t i = 1; i < poses.size(); ++i) cameras.push_back(scene::make_camera(poses[i].pose, scene::lens_of(start)));
    }
    return cameras;
}

scene::Map densified(scene::Map const& map, std::uint32_t n)
{
    scene::Map out;
    out.name = map.name;
    out.gaussians.reserve(n);
    std::uint64_t const rows = map.gaussians.size();
    auto const floats = map.harmonics.size() / rows; // of a record
    out.sh_degree = map.sh_degree;
    out.harmonics.reserve(floats * n);
    for (std::uint64_t row = 0; row < rows; ++row) {
        auto const& from = map.gaussians[row];
        auto const first = static_cast<std::uint32_t>(row * n / rows), last = static_cast<std::uint32_t>((row + 1) * n / rows);
        auto const turn = scene::rotation_matrix(from.rotation[0], from.rotation[1], from.rotation[2], from.rotation[3]);
        auto const smaller = static_cast<float>(0.5 * std::log(static_cast<double>(last - first)));
        for (auto i = first; i < last; ++i) {
            auto g = from;
            g.id = tilemesh::splat::GaussianId{i + 1};
            std::uint32_t which = 0;
            for (int axis = 0; axis < 3; ++axis) {
                // The sum of three uniform numbers in [-1, 1) has a standard deviation of 1.
                double sum = 0;
                for (int k = 0; k < 3; ++k) sum += 2 * even(i, which++) - 1;
                double const length = last - first > 1 ? sum * std::exp(static_cast<double>(from.log_scale[axis])) : 0;
                for (int xyz = 0; xyz < 3; ++xyz)
                    g.mean_world[xyz] += static_cast<float>(turn[axis][xyz] * length);
                g.log_scale[axis] -= smaller;
            }
            out.gaussians.push_back(g);
            auto const harmonics = map.harmonics.begin() + static_cast<std::ptrdiff_t>(row * floats);
            out.harmonics.insert(out.harmonics.end(), harmonics, harmonics + static_cast<std::ptrdiff_t>(floats));
        }
    }
    return out;
}

} // namespace bench
