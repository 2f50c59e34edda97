#include "outputs.hpp"
#include "../shared/output_files.hpp"
#include <algorithm>
#include <array>
#include <cstdio>
#include <iterator>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/report/distinct_files.hpp>
#include <unistd.h>

namespace track_camera {

namespace fs = std::filesystem;

namespace {

template <std::size_t N>
bool is_one_of(char const* const (&names)[N], std::string const& name)
{
    return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

/// Is it the `photo_file` of one of the first `frames` frames? A number has six digits or more.
bool is_photo(std::string const& name, std::size_t frames)
{
    std::size_t frame = 0;
    for (auto const c : name.substr(0, name.find('.'))) {
        if (c < '0' || c > '9' || frame >= frames) return false;
        frame = 10 * frame + static_cast<std::size_t>(c - '0');
    }
    return frame < frames && name == photo_file(frame);
}

constexpr char const *out_remedy = "name another directory with --out", *report_remedy = "name another file with --report",
                     *photos_remedy = "name another directory with --save-photos";

} // namespace

std::string photo_file(std::size_t frame)
{
    std::array<char, 64> name{};
    std::snprintf(name.data(), name.size(), "%06zu.png", frame);
    return name.data();
}

void prepare_outputs(Options const& options, std::vector<fs::path> const& read, std::size_t frames)
{
    shared::make_folder(options.out, "--out");
    for (char const* const name : out_files) shared::check_file(options.out / name, "a result", out_remedy);
    if (options.report) shared::check_file(*options.report, "the report", report_remedy);
    if (options.save_photos) {
        for (auto const& folder : {*options.save_photos, *options.save_photos / "rgb", *options.save_photos / "depth"}) shared::make_folder(folder, "--save-photos");
        for (char const* const name : photo_lists) shared::check_file(*options.save_photos / name, "a list", photos_remedy);
        for (char const* const part : {"rgb", "depth"}) shared::check_file(*options.save_photos / part / photo_file(0), "a picture", photos_remedy);
    }

    tilemesh::report::DistinctFiles files;
    for (auto const& file : read) files.read(file);
    if (!options.quiet) files.write_stream(STDOUT_FILENO, "standard output", "send it to another file, or use --quiet");
    files.write_stream(STDERR_FILENO, "standard error", "send it to another file");
    files.write_into(
        options.out, [](std::string const& name) { return is_one_of(out_files, name); }, "a result", out_remedy);
    if (options.save_photos) {
        files.write_into(
            *options.save_photos, [](std::string const& name) { return is_one_of(photo_lists, name); }, "a list", photos_remedy);
        if (std::error_code none; fs::equivalent(*options.save_photos / "rgb", *options.save_photos / "depth", none))
            throw tilemesh::Error("cannot write pictures to " + options.save_photos->string() + " (its folders rgb and depth are one); " + photos_remedy);
        for (char const* const part : {"rgb", "depth"})
            files.write_into(
                *options.save_photos / part, [frames](std::string const& name) { return is_photo(name, frames); }, "a picture", photos_remedy);
    }
    if (options.report) files.write(*options.report, "the report", report_remedy);
}

} // namespace track_camera
