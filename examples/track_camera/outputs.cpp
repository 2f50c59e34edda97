#include "outputs.hpp"
#include <filesystem>
#include <string>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/report/distinct_files.hpp>
#include <tilemesh/scene/colmap.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <unistd.h>

namespace track_camera {

namespace {

namespace fs = std::filesystem;
namespace scene = tilemesh::scene;
using tilemesh::Error;

constexpr char const* in_out[] = {"estimated.tum", "truth.tum", "paths.svg", "residual.ppm"};

void make_folder(fs::path const& folder, char const* option)
{
    std::error_code refused;
    fs::create_directories(folder, refused);
    if (refused) throw Error(std::string(option) + " cannot be " + folder.string() + " (" + refused.message() + "); name a folder");
}

/// Every file below `folder`.
void read_folder(tilemesh::report::DistinctFiles& files, fs::path const& folder)
{
    std::error_code refused;
    fs::recursive_directory_iterator entry(folder, fs::directory_options::skip_permission_denied, refused);
    for (; entry != fs::recursive_directory_iterator(); entry.increment(refused))
        if (!entry->is_directory(refused)) files.read(entry->path());
}

/// Is this the name of one of the first pictures of `PhotoWriter`?
bool is_picture(std::string const& name)
{
    return name.size() >= 10 && name.ends_with(".png") && name.find_first_not_of("0123456789") == name.size() - 4;
}

void require_distinct(Options const& o, std::vector<scene::RgbdFrame> const& pictures)
{
    tilemesh::report::DistinctFiles files;
    if (o.map)
        for (auto const& file : scene::map_files(*o.map)) files.read(file);
    if (o.cameras && scene::names_colmap(*o.cameras)) {
        auto const [cameras, images] = scene::colmap_files(*o.cameras);
        files.read(cameras);
        files.read(images);
    } else if (o.cameras) {
        files.read(*o.cameras);
    }
    if (o.trajectory) files.read(*o.trajectory);
    if (o.photos) {
        std::error_code refused;
        if (fs::is_directory(*o.photos, refused)) read_folder(files, *o.photos); // also pictures that this run leaves out
        else files.read(*o.photos);
        for (auto const& frame : pictures) {
            files.read(frame.colour.file);
            if (!frame.depth.file.empty()) files.read(frame.depth.file);
        }
    }
    if (!o.quiet) files.write_stream(STDOUT_FILENO, "standard output", "send it to another file, or use --quiet");
    files.write_stream(STDERR_FILENO, "standard error", "send it to another file");
    for (char const* const name : in_out) files.write(o.out / name, "an output", "name another folder with --out");
    if (o.report) files.write(*o.report, "the report", "name another file with --report");
    if (o.save_photos) {
        constexpr char const* remedy = "name another folder with --save-photos";
        for (char const* const part : {"rgb", "depth"}) files.write_into(*o.save_photos / part, is_picture, "a picture", remedy);
        for (char const* const name : {"associations.txt", "groundtruth.txt"}) files.write(*o.save_photos / name, "a list of pictures", remedy);
    }
}

} // namespace

Outputs::Outputs(Options const& o, std::vector<scene::RgbdFrame> const& pictures)
{
    make_folder(o.out, "--out");
    if (o.save_photos)
        for (char const* const part : {"rgb", "depth"}) make_folder(*o.save_photos / part, "--save-photos");
    require_distinct(o, pictures);
    for (char const* const name : in_out) tilemesh::report::WholeFile{o.out / name, "trajectories and pictures"};
    if (o.report) report_file.emplace(*o.report, "a report");
    if (o.save_photos) photos.emplace(*o.save_photos, o.depth_levels);
}

} // namespace track_camera
