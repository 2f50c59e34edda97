#include "sequence_options.hpp"
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/colmap.hpp>
#include <tilemesh/scene/map_file.hpp>

namespace shared {

namespace fs = std::filesystem;
using tilemesh::Error;

tilemesh::scene::Size size_value(OptionValues const& values, std::string_view option, std::string_view text)
{
    auto const x = text.find('x');
    if (x == std::string_view::npos) values.refuse(option, text, "it takes a width and a height, as in 640x480");
    return {values.whole(option, text.substr(0, x), 1, 65535), values.whole(option, text.substr(x + 1), 1, 65535)};
}

bool read_option(SequenceOptions& o, OptionValues const& values, int argc, char** argv, int& i)
{
    std::string_view const name = argv[i];
    auto const value = [&] { return values.next(argc, argv, i); };
    if (name == "--relative") o.relative = true;
    else if (name == "--quiet") o.quiet = true;
    else if (name == "--photos") o.photos = value();
    else if (name == "--cameras") o.cameras = value();
    else if (name == "--camera") o.camera = value();
    else if (name == "--trajectory") o.trajectory = value();
    else if (name == "--trajectory-format") {
        auto const text = value();
        o.trajectory_format = tilemesh::scene::trajectory_format(text);
        if (!o.trajectory_format) values.refuse(name, text, "it takes tum, euroc, kitti or replica");
    }
    else if (name == "--report") o.report = value();
    else if (name == "--out") o.out = value();
    else if (name == "--frames") o.frames = values.whole(name, value(), 1, 1'000'000);
    else if (name == "--every") o.every = values.whole(name, value(), 1, 1'000'000);
    else if (name == "--threads") o.threads = values.whole(name, value(), 1, 1024);
    else if (name == "--size") o.size = size_value(values, name, value());
    else if (name == "--near") o.near_depth = static_cast<float>(values.number(name, value(), 1e-30, 1e30, "above 0"));
    else if (name == "--noise") o.noise = values.number(name, value(), 0.0, 1.0, "from 0 to 1");
    else if (name == "--shutter") o.shutter = values.number(name, value(), 0.0, 1.0, "from 0 to 1");
    else if (name == "--depth-scale") o.depth_levels = values.number(name, value(), 1e-6, 1e9, "from 1e-6 to 1e9");
    else return false;
    return true;
}

void check_options(SequenceOptions const& o)
{
    if (!o.camera.empty() && !o.cameras) throw Error("--camera needs a file (no --cameras is given); add --cameras FILE");
    if (o.relative && !o.trajectory) throw Error("--relative needs a trajectory (no --trajectory is given); add --trajectory FILE");
    if (o.trajectory_format && !o.trajectory)
        throw Error("--trajectory-format needs a trajectory (no --trajectory is given); add --trajectory FILE");
}

std::vector<fs::path> files_read(SequenceOptions const& o, std::vector<std::optional<fs::path>> const& maps,
                                 std::vector<tilemesh::scene::RgbdFrame> const& photos, std::vector<fs::path> const& sized_by)
{
    std::vector<fs::path> files = sized_by;
    for (auto const& map : maps)
        if (map)
            for (auto const& file : tilemesh::scene::map_files(*map)) files.push_back(file);
    if (o.cameras) {
        files.push_back(*o.cameras);
        if (tilemesh::scene::names_colmap(*o.cameras)) {
            auto const [cameras, images] = tilemesh::scene::colmap_files(*o.cameras);
            files.insert(files.end(), {cameras, images});
        }
    }
    if (o.trajectory) files.push_back(*o.trajectory);
    if (o.photos) {
        files.push_back(*o.photos);
        for (char const* const list : {"associations.txt", "rgb.txt", "depth.txt"}) files.push_back(*o.photos / list);
    }
    for (auto const& frame : photos) {
        files.push_back(frame.colour.file);
        if (!frame.depth.file.empty()) files.push_back(frame.depth.file);
    }
    std::erase_if(files, [](fs::path const& file) {
        std::error_code refused;
        return fs::is_directory(file, refused);
    });
    return files;
}

} // namespace shared
