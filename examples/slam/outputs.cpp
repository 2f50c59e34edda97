#include "outputs.hpp"
#include "../shared/output_files.hpp"
#include "checkpoint.hpp"
#include <algorithm>
#include <iterator>
#include <string>
#include <system_error>
#include <tilemesh/report/distinct_files.hpp>
#include <tilemesh/scene/colmap.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <unistd.h>

namespace slam_program {

namespace fs = std::filesystem;

std::vector<fs::path> files_read(Options const& options, std::vector<tilemesh::scene::RgbdFrame> const& photos,
                                 std::vector<fs::path> const& sized_by)
{
    std::vector<fs::path> files = sized_by;
    for (auto const& map : {options.render, options.map})
        if (map)
            for (auto const& file : tilemesh::scene::map_files(*map)) files.push_back(file);
    if (options.cameras) {
        files.push_back(*options.cameras);
        if (tilemesh::scene::names_colmap(*options.cameras)) {
            auto const [cameras, images] = tilemesh::scene::colmap_files(*options.cameras);
            files.insert(files.end(), {cameras, images});
        }
    }
    if (options.trajectory) files.push_back(*options.trajectory);
    if (options.photos) {
        files.push_back(*options.photos);
        for (char const* const list : {"associations.txt", "rgb.txt", "depth.txt"}) files.push_back(*options.photos / list);
    }
    for (auto const& frame : photos) {
        files.push_back(frame.colour.file);
        if (!frame.depth.file.empty()) files.push_back(frame.depth.file);
    }
    std::erase_if(files, [](fs::path const& file) { // a folder stands for the files in it
        std::error_code refused;
        return fs::is_directory(file, refused);
    });
    return files;
}

void prepare_outputs(Options const& options, std::vector<fs::path> const& read)
{
    constexpr char const *out_remedy = "name another directory with --out", *report_remedy = "name another file with --report",
                         *page_remedy = "name another file with --page";
    shared::make_folder(options.out, "--out");
    for (char const* const name : out_files) shared::check_file(options.out / name, "a result", out_remedy);
    if (options.resume)
        for (char const* const name : {checkpoint_file, set_aside_file})
            shared::check_file(options.out / name, "the checkpoint", out_remedy);
    if (options.report) shared::check_file(*options.report, "the report", report_remedy);
    if (options.page) shared::check_file(*options.page, "the page", page_remedy);
    tilemesh::report::DistinctFiles files;
    for (auto const& file : read) files.read(file);
    if (!options.quiet) files.write_stream(STDOUT_FILENO, "standard output", "send it to another file, or use --quiet");
    files.write_stream(STDERR_FILENO, "standard error", "send it to another file");
    auto const is_result = [&](std::string const& name) {
        if (options.resume && (name == checkpoint_file || name == set_aside_file)) return true;
        return std::find(std::begin(out_files), std::end(out_files), name) != std::end(out_files);
    };
    files.write_into(options.out, is_result, "a result", out_remedy);
    if (options.report) files.write(*options.report, "the report", report_remedy);
    if (options.page) files.write(*options.page, "the page", page_remedy);
}

} // namespace slam_program
