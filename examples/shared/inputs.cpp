#include "inputs.hpp"
#include "codecs.hpp"
#include "input_rows.hpp"
#include "output_files.hpp"
#include "text.hpp"
#include <algorithm>
#include <iostream>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/colmap.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/lens.hpp>
#include <tilemesh/scene/near_plane.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/scene/records.hpp>
#include <utility>

namespace shared {

namespace fs = std::filesystem;
namespace scene = tilemesh::scene;

scene::Map turned(scene::Map map, MapInput const& in)
{
    return in.turn ? scene::turned(std::move(map), *in.turn) : map;
}

scene::Map load_maps(std::vector<fs::path> const& paths, MapInput const& in)
{
    if (paths.empty()) return turned(scene::built_in_map(), in);
    std::vector<scene::Map> maps;
    for (auto const& path : paths) maps.push_back(scene::load_map(path, codecs(), scene::FarMeans::moved));
    auto map = scene::join_maps(std::move(maps));
    if (in.antialias) std::erase_if(map.notes, [](auto const& note) { return note.ends_with(scene::antialiased_note); });
    return turned(std::move(map), in);
}

scene::Map at_degree(scene::Map map, MapInput const& in, std::vector<std::string>& notes)
{
    if (in.sh_degree >= map.sh_degree) return map;
    notes.push_back("view-dependent colour above degree " + std::to_string(in.sh_degree) + " left out (--sh-degree); the map has degree " +
                    std::to_string(map.sh_degree));
    return scene::at_degree(std::move(map), in.sh_degree);
}

scene::Map load_map(std::optional<fs::path> const& path, MapInput const& in, std::vector<std::string>& notes)
{
    auto map = load_maps(path ? std::vector{*path} : std::vector<fs::path>{}, in);
    notes.insert(notes.end(), map.notes.begin(), map.notes.end());
    return at_degree(std::move(map), in, notes);
}

MapShape shape_of(scene::Map const& map)
{
    return {map.name, [&map] { return scene::robust_centre(map); },
            [&map](scene::Size size, glm::dvec3 up, double degrees) { return scene::frame_whole(map, size, up, degrees); },
            [&map](tilemesh::splat::Camera const& camera) { return scene::near_for(map, camera); }, map.origin};
}

std::string camera_names(CameraInput const& in)
{
    std::string text;
    scene::Size const any{640, 480}; // for a camera without a size: its name does not depend on it
    for (auto const& camera : scene::load_cameras(*in.cameras, nullptr, in.lens(), in.size.value_or(any))) text += one_line(scene::label(camera)) + "\n";
    return text;
}

void add_notes(std::vector<std::string>& to, fs::path const& file, std::vector<std::string> const& notes)
{
    auto const name = (file.has_filename() ? file : file.parent_path()).filename().string(); // of "seen/", too
    for (auto const& note : notes) to.push_back(name + ": " + note);
}

std::vector<scene::NamedCamera> load_cameras(CameraInput const& in, MapShape const& map, std::optional<scene::Size> size,
                                             std::vector<std::string>& notes, std::vector<fs::path>& sized_by, std::vector<std::string>* names)
{
    std::vector<std::string> of_file;
    auto const all = scene::load_cameras(*in.cameras, &of_file, in.lens(), size, &sized_by);
    if (!in.bend.empty()) std::erase_if(of_file, [](std::string const& note) { return note.ends_with("the picture is a pinhole's"); });
    add_notes(notes, *in.cameras, of_file);
    auto chosen = scene::relative_to_origin(scene::select_cameras(all, in.camera, map.name), map.origin);
    for (auto& each : chosen) {
        if (!in.bend.empty()) each.camera.lens = scene::lens_of_text(in.bend), scene::check_camera(each.camera);
        if (in.near_depth) each.camera.near_depth = *in.near_depth;
        else if (!each.names_near) each.camera.near_depth = map.near_plane(each.camera);
        if (!each.mask.empty()) sized_by.emplace_back(each.mask);
    }
    for (auto const& each : all)
        if (names && std::any_of(chosen.begin(), chosen.end(), [&](auto const& c) { return c.scene == each.scene; })) names->push_back(each.name);
    return chosen;
}

std::vector<scene::Split> splits_of(std::vector<scene::NamedCamera> const& cameras, std::uint32_t every, bool given, std::vector<std::string>& notes)
{
    using scene::Split;
    std::vector<Split> out;
    std::size_t said = 0, held_out = 0, unused = 0, i = 0;
    for (auto const& camera : cameras) {
        auto const split = camera.split != Split::unsaid ? camera.split : i++ % every == 0 ? Split::held_out : Split::training;
        out.push_back(split);
        said += camera.split == Split::unsaid ? 0u : 1u;
        held_out += split == Split::held_out ? 1u : 0u;
        unused += split == Split::unused ? 1u : 0u;
    }
    if (said > unused)
        notes.push_back(std::to_string(held_out) + " of " + std::to_string(cameras.size()) +
                        " cameras are held out: train_filenames, test_filenames and val_filenames of the camera file say which" +
                        (given ? ", and --every does not choose" : ""));
    if (unused != 0) notes.push_back(std::to_string(unused) + " cameras are in none of the lists of the camera file, and are left out");
    return out;
}

namespace {
glm::dvec3 vector(std::array<double, 3> const& v)
{
    return {v[0], v[1], v[2]};
}
} // namespace

glm::dvec3 up_of(CameraInput const& in)
{
    return vector(in.up.value_or(std::array{0.0, -1.0, 0.0}));
}

tilemesh::splat::Camera placed_camera(CameraInput const& in, MapShape const& map, scene::Size size, bool built_in)
{
    auto const up = up_of(in);
    tilemesh::splat::Camera camera;
    auto const lens = in.bend.empty() ? tilemesh::splat::Lens{} : scene::lens_of_text(in.bend);
    bool const panorama = lens.kind == tilemesh::splat::LensKind::equirectangular;
    auto const fov = in.fov.value_or(panorama ? 360.0 : 60.0);
    bool const bends = lens.kind != tilemesh::splat::LensKind::pinhole;
    auto const with_lens = [&](tilemesh::splat::Camera made) {
        if (!bends && fov >= 180)
            throw tilemesh::Error("--fov " + tilemesh::significant(fov, 6) +
                                  " with a pinhole (it sees less than 180 degrees); add --lens fisheye, or choose at most 179");
        made.lens = lens;
        return made;
    };
    // A pinhole of a moderate angle says where to stand; the focal length is then that of the lens.
    auto const standing = bends ? std::min(fov, 100.0) : std::min(fov, 179.0);
    auto const span = [&](tilemesh::splat::Camera made) {
        made = with_lens(made);
        if (bends) made.fx = made.fy = static_cast<float>(scene::focal_of(lens, fov, size.width)), scene::check_camera(made);
        return made;
    };
    if (in.from) {
        auto const in_map = [&](std::array<double, 3> const& v) { return vector(v) - vector(map.origin); };
        scene::upright(up); // refuses a direction of length 0
        auto const target = in.look ? in_map(*in.look) : map.centre();
        camera = scene::make_camera(scene::look_at(in_map(*in.from), target, -up), scene::lens_from_field_of_view(standing, size));
        camera = span(camera);
        if (!in.near_depth) camera.near_depth = map.near_plane(camera);
    } else if (built_in && !in.up && !in.fov && !panorama) {
        camera = with_lens(scene::built_in_camera(size));
    } else {
        camera = span(map.whole(size, up, standing));
    }
    if (in.near_depth) camera.near_depth = *in.near_depth;
    return camera;
}

std::vector<fs::path> files_read(std::vector<fs::path> const& inputs, CameraInput const& in, std::vector<fs::path> const& maps, std::vector<fs::path> more)
{
    auto files = inputs;
    files.insert(files.end(), more.begin(), more.end());
    if (auto const found = in.cameras ? scene::found_cameras(*in.cameras) : fs::path(); scene::names_colmap(found)) {
        auto const [cameras, images] = scene::colmap_files(found);
        files.insert(files.end(), {cameras, images});
    } else if (in.cameras && found != *in.cameras) {
        files.push_back(found);
    }
    for (auto const& map : maps)
        for (auto const& file : scene::map_files(map))
            if (file != map) files.push_back(file); // of a folder of SOG
    std::erase_if(files, [](fs::path const& file) {
        std::error_code refused;
        return fs::is_directory(file, refused);
    });
    return files;
}

bool read_command_line(OptionTable& table, HostInput& host, CameraInput const* cameras, int argc, char** argv)
{
    constexpr char const* room = "send it to a file or a terminal with room";
    auto const count = static_cast<std::size_t>(std::max(argc - 1, 0));
    bool const reads = table.read({argv + (argc > 0 ? 1 : 0), count});
    for (auto const& path : table.inputs()) host.inputs.emplace_back(path);
    if (!reads) print(table.help(), room, std::cout);
    else if (cameras != nullptr && cameras->list) print(camera_names(*cameras), room, std::cout);
    else return true;
    return false;
}

} // namespace shared
