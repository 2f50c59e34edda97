#include "outputs.hpp"
#include "journal.hpp"
#include <algorithm>
#include <cerrno>
#include <charconv>
#include <iostream>
#include <iterator>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/report/distinct_files.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <tilemesh/scene/colmap.hpp>
#include <unistd.h>
#include <vector>

namespace render_map {

namespace {

namespace fs = std::filesystem;
using tilemesh::Error;

fs::path out_folder(Options const& options)
{
    return options.out.value_or("tilemesh_out");
}

constexpr char const* report_remedy = "name another file with --report";

std::string last_error()
{
    return std::generic_category().message(errno);
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
                                {".error.png", [](Options const& o) { return o.error_picture; }}};

/// The part of `name` after the number, if `name` is a `frame_file` of one of the first `frames` frames; otherwise empty.
std::string_view after_number(std::string_view name, std::size_t frames)
{
    constexpr std::string_view begin = "frame_";
    if (!name.starts_with(begin)) return {};
    std::size_t frame = 0;
    auto const [end, error] = std::from_chars(name.data() + begin.size(), name.data() + name.size(), frame);
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

void check_report(fs::path const& report)
{
    auto const refuse = [&](std::string const& why) {
        throw Error("cannot write the report to " + report.string() + " (" + why + "); " + report_remedy);
    };
    std::error_code refused;
    auto const status = fs::status(report, refused);
    auto const folder = fs::absolute(fs::is_other(status) ? report : tilemesh::report::link_target(report)).parent_path();
    if (fs::is_directory(status) || !report.has_filename()) refuse("it is a directory");
    if (refused && fs::exists(status)) refuse(refused.message());
    if (!fs::is_directory(folder, refused)) refuse("there is no directory " + folder.string());
    // A report replaces a regular file; this needs only the right to write into the folder.
    auto const& written = fs::is_other(status) ? report : folder;
    if (access(written.c_str(), W_OK) != 0) refuse(last_error());
}

/// Refuses a run that would overwrite a file that it reads, or write two files with one name. The folders must exist.
void check_distinct(Options const& options, fs::path const& out, std::vector<Shot> const& shots)
{
    auto const frames = shots.size();
    tilemesh::report::DistinctFiles files;
    for (auto const& file : files_read(options, shots)) files.read(file);
    if (!options.quiet || options.explain) files.write_stream(STDOUT_FILENO, "standard output", "send it to another file, or use --quiet");
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
}

void make_folder(fs::path const& folder, std::string const& option)
{
    auto const refuse = [&](std::string const& why) {
        throw Error("cannot write to " + folder.string() + " (" + why + "); name a writable directory with " + option);
    };
    std::error_code refused;
    fs::path above; // a link to a missing folder is often an unmounted disk: do not make a folder in its place
    for (auto const& part : folder) {
        above /= part;
        if (fs::is_symlink(fs::symlink_status(above, refused)) && !fs::exists(above, refused))
            refuse(above.string() + " is a link to " + fs::read_symlink(above, refused).string() + ", which does not exist");
    }
    fs::create_directories(folder, refused);
    if (refused) refuse(refused.message());
    if (!fs::is_directory(folder, refused)) refuse("it is no directory");
    if (access(folder.c_str(), R_OK | W_OK | X_OK) != 0) refuse(last_error());
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

std::vector<std::string> picture_files(Options const& options, std::size_t frame)
{
    std::vector<std::string> names;
    for (auto const& picture : pictures)
        if (picture.is_wanted(options)) names.push_back(frame_file(frame, std::string(picture.extension)));
    return names;
}

std::string follow_file(std::uint32_t id)
{
    return "follow_" + std::to_string(id) + ".csv";
}

fs::path prepare_outputs(Options const& options, std::vector<Shot> const& shots)
{
    auto const out = out_folder(options);
    make_folder(out, "--out");
    if (options.trace) make_folder(*options.trace, "--trace");
    if (options.report) check_report(*options.report);
    check_distinct(options, out, shots);
    return out;
}

std::vector<fs::path> files_read(Options const& options, std::vector<Shot> const& shots)
{
    auto files = options.inputs;
    for (auto const& shot : shots)
        if (shot.photograph && shot.photograph->found) files.push_back(shot.photograph->path);
    if (options.cameras && tilemesh::scene::names_colmap(*options.cameras)) {
        auto const [cameras, images] = tilemesh::scene::colmap_files(*options.cameras);
        files.insert(files.end(), {cameras, images});
    }
    // The pictures of an SOG map that is a folder are beside its meta.json.
    std::error_code none;
    for (auto const& map : options.maps) {
        bool const is_folder = fs::is_directory(map, none);
        if (!is_folder && map.extension() != ".json") continue;
        auto const folder = is_folder ? map : map.parent_path().empty() ? fs::path(".") : map.parent_path();
        auto const first = static_cast<std::ptrdiff_t>(files.size());
        for (auto const& entry : fs::directory_iterator(folder, none))
            if (entry.path().extension() == ".webp" || (is_folder && entry.path().filename() == "meta.json")) files.push_back(entry.path());
        std::sort(files.begin() + first, files.end());
    }
    // A folder stands for the files in it. A file that a model may lack need not be there. A file that cannot be examined stays in the
    // list.
    std::erase_if(files, [](fs::path const& file) {
        std::error_code refused;
        auto const type = fs::status(file, refused).type();
        return type == fs::file_type::directory || type == fs::file_type::not_found;
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

void print(std::string const& text, char const* remedy)
{
    errno = 0;
    std::cout << text << std::flush;
    if (!std::cout)
        throw Error("cannot write to standard output (" + (errno != 0 ? last_error() : std::string("the stream failed")) +
                    "); " + remedy);
}

} // namespace render_map
