#include "outputs.hpp"
#include "../shared/output_files.hpp"
#include "../shared/text.hpp"
#include "journal.hpp"
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <iterator>
#include <stdexcept>
#include <sys/stat.h>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/distinct_files.hpp>
#include <tilemesh/scene/colmap.hpp>
#include <unistd.h>

namespace render_map {

namespace {

namespace fs = std::filesystem;
using tilemesh::Error;

fs::path out_folder(Options const& options)
{
    return options.out.value_or("tilemesh_out");
}

constexpr char const *report_remedy = "name another file with --report", *video_remedy = "name another file with --video";

/// Is the video to go to standard output?
bool is_to_stream(std::optional<fs::path> const& video)
{
    return video && *video == "-";
}

/// A picture of a frame: the end of its file name, and whether the options ask for it.
struct Picture {
    std::string_view extension;
    bool (*is_wanted)(Options const&);
};
constexpr Picture pictures[] = {{".png", [](Options const&) { return true; }},
                                {".pfm", [](Options const& o) { return o.pfm; }},
                                {".depth.pfm", [](Options const& o) { return o.choice.depth; }},
                                {".alpha.pfm", [](Options const& o) { return o.choice.alpha; }},
                                {".lower.pfm", [](Options const& o) { return o.certify && o.pfm; }},
                                {".upper.pfm", [](Options const& o) { return o.certify && o.pfm; }},
                                {".depth.lower.pfm", [](Options const& o) { return o.certify && o.pfm && o.choice.depth; }},
                                {".depth.upper.pfm", [](Options const& o) { return o.certify && o.pfm && o.choice.depth; }},
                                {".alpha.lower.pfm", [](Options const& o) { return o.certify && o.pfm && o.choice.alpha; }},
                                {".alpha.upper.pfm", [](Options const& o) { return o.certify && o.pfm && o.choice.alpha; }},
                                {".bound.pfm", [](Options const& o) { return o.bound; }},
                                {".error.png", [](Options const& o) { return o.error_picture; }}};

/// The part of `name` after the number, if `name` is a `frame_file` of one of the first `frames` frames; otherwise empty.
std::string_view after_number(std::string_view name, std::size_t frames)
{
    constexpr std::string_view begin = "frame_";
    if (!name.starts_with(begin)) return {};
    std::size_t frame = 0;
    auto const [end, error] = tilemesh::read_number(name.data() + begin.size(), name.data() + name.size(), frame);
    if (error != std::errc{} || frame >= frames) return {};
    std::string_view const rest(end, static_cast<std::size_t>(name.data() + name.size() - end));
    return name == frame_file(frame, std::string(rest)) ? rest : std::string_view{};
}

bool is_picture(std::string_view name, Options const& options, std::size_t frames)
{
    auto const rest = after_number(name, frames);
    return std::any_of(std::begin(pictures), std::end(pictures),
                       [&](Picture const& p) { return rest == p.extension && p.is_wanted(options); });
}

/// Refuses a video to a terminal, and to a place where the text of standard error goes too.
void check_video_stream()
{
    struct stat out {}, text {};
    auto const refuse = [](char const* why) {
        throw Error(std::string("cannot write the video to standard output (") + why + "); send it to a program or a file, or name a file with --video");
    };
    if (isatty(STDOUT_FILENO) == 1) refuse("it is a terminal");
    bool const known = fstat(STDOUT_FILENO, &out) == 0 && fstat(STDERR_FILENO, &text) == 0;
    if (known && !S_ISCHR(out.st_mode) && out.st_dev == text.st_dev && out.st_ino == text.st_ino) refuse("standard error goes there too");
}

/// Refuses a run that would overwrite a file that it reads, or write two files with one name. The folders must exist.
void check_distinct(Options const& options, fs::path const& out, std::size_t frames, std::vector<fs::path> const& read)
{
    tilemesh::report::DistinctFiles files;
    for (auto const& file : read) files.read(file);
    if (options.photos) { // also the photographs of cameras that this run leaves out
        std::error_code refused;
        fs::recursive_directory_iterator photo(*options.photos, fs::directory_options::skip_permission_denied, refused);
        for (; photo != fs::recursive_directory_iterator(); photo.increment(refused)) files.read(photo->path());
    }
    bool const streams = is_to_stream(options.video);
    if (streams) files.write_stream(STDOUT_FILENO, "standard output", "send it to another file");
    else if (!options.quiet || options.explain) files.write_stream(STDOUT_FILENO, "standard output", "send it to another file, or use --quiet");
    files.write_stream(STDERR_FILENO, "standard error", "send it to another file");
    using Devices = tilemesh::report::DistinctFiles::Devices;
    files.write_into(
        out, [&](std::string const& name) { return is_picture(name, options, frames); }, "a picture", "name another directory with --out",
        options.resume ? Devices::refused : Devices::allowed);
    if (options.trace)
        files.write_into(
            *options.trace, [&](std::string const& name) { return is_of_trace(name, options, frames); }, "a file of the trace",
            "name another directory with --trace");
    if (options.resume) files.write(out / journal_file, "the list of finished frames", "name another directory with --out");
    if (options.report) files.write(*options.report, "the report", report_remedy);
    if (options.video && !streams) files.write(*options.video, "the video", video_remedy);
}

} // namespace

bool is_of_trace(std::string_view name, Options const& options, std::size_t frames)
{
    if (name == page_file || name == model_file || name == no_progress_file || name == counters_file) return true;
    if (options.follow && name == follow_file(*options.follow)) return true;
    auto const rest = after_number(name, frames);
    for (auto const* extension : {".tiles.csv", ".supersteps.csv", ".heat.csv", ".trace.json", rounds_end})
        if (rest == extension) return true;
    if (rest == ".energy.csv" || rest == ".heat_energy.png") return options.energy.has_value();
    return rest.starts_with(".heat_") && rest.ends_with(".png");
}

std::string frame_file(std::size_t frame, std::string const& extension)
{
    auto digits = std::to_string(frame);
    if (digits.size() < 4) digits.insert(0, 4 - digits.size(), '0');
    return "frame_" + digits + extension;
}

std::vector<std::string> picture_extensions(Options const& options)
{
    std::vector<std::string> out;
    for (auto const& picture : pictures)
        if (picture.is_wanted(options)) out.emplace_back(picture.extension);
    return out;
}

std::vector<std::string> picture_files(Options const& options, std::size_t frame)
{
    std::vector<std::string> names;
    for (auto const& extension : picture_extensions(options)) names.push_back(frame_file(frame, extension));
    return names;
}

std::string follow_file(std::uint32_t id)
{
    return "follow_" + std::to_string(id) + ".csv";
}

fs::path prepare_outputs(Options const& options, std::vector<Shot> const& shots, std::vector<fs::path> const& read)
{
    auto const out = out_folder(options);
    shared::make_folder(out, "--out");
    if (std::error_code none; options.photos && fs::equivalent(out, *options.photos, none))
        throw Error("cannot write pictures to " + out.string() + " (it is the folder of the photographs); name another directory with --out");
    if (options.trace) shared::make_folder(*options.trace, "--trace");
    if (options.report) shared::check_file(*options.report, "the report", report_remedy);
    if (is_to_stream(options.video)) check_video_stream();
    else if (options.video) shared::check_file(*options.video, "the video", video_remedy);
    check_distinct(options, out, shots.size(), read);
    return out;
}

std::vector<fs::path> files_read(Options const& options, std::vector<Shot> const& shots, std::vector<fs::path> const& sized_by)
{
    auto more = sized_by;
    for (auto const& shot : shots)
        if (shot.photograph && shot.photograph->found) more.push_back(shot.photograph->path);
    auto files = shared::files_read(options.inputs, options, options.maps, std::move(more));
    // A file that a model may lack need not be there. A file that cannot be examined stays in the list.
    std::erase_if(files, [](fs::path const& file) {
        std::error_code refused;
        return fs::status(file, refused).type() == fs::file_type::not_found;
    });
    return files;
}

tilemesh::report::Outlasts outlasts(Options const& options)
{
    return options.report ? tilemesh::report::Outlasts::power_loss : tilemesh::report::Outlasts::process;
}

fs::path frame_path(Options const& options, std::size_t frame, std::string const& extension)
{
    auto const name = frame_file(frame, extension);
    if (!is_picture(name, options, frame + 1)) throw std::logic_error(name + " is not in the list of pictures");
    return out_folder(options) / name;
}

std::unique_ptr<tilemesh::report::Y4mVideo> open_video(Options const& options, std::vector<Shot> const& shots)
{
    using tilemesh::report::Y4mVideo;
    if (!options.video) return {};
    auto const& camera = shots.front().camera;
    if (is_to_stream(options.video))
        return std::make_unique<Y4mVideo>(stdout, "the video to standard output", camera.width, camera.height, options.fps);
    return std::make_unique<Y4mVideo>(*options.video, camera.width, camera.height, options.fps, outlasts(options));
}

std::string video_text(Options const& options, std::size_t frames)
{
    auto const& [count, seconds] = options.fps;
    return (is_to_stream(options.video) ? "the video to standard output" : shared::one_line(options.video.value().string())) + ", " +
           std::to_string(frames) + (frames == 1 ? " frame" : " frames") + " at " + std::to_string(count) +
           (seconds == 1 ? "" : "/" + std::to_string(seconds)) + " per second";
}

std::ostream& text_stream(Options const& options)
{
    return is_to_stream(options.video) ? std::cerr : std::cout;
}

} // namespace render_map
