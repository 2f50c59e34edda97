#include "outputs.hpp"
#include <cerrno>
#include <iostream>
#include <optional>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <unistd.h>
#include <vector>

namespace render_map {

namespace {

namespace fs = std::filesystem;
using tilemesh::Error;

std::string last_error()
{
    return std::generic_category().message(errno);
}

/// Whether `file` will be one of the pictures in `out`.
bool is_frame(fs::path const& file, fs::path const& out, std::size_t frames)
{
    std::error_code ignored;
    auto const name = file.filename().string();
    if (!name.starts_with("frame_") || !fs::equivalent(fs::absolute(file).parent_path(), out, ignored)) return false;
    for (auto const* extension : {".png", ".pfm", ".depth.pfm", ".alpha.pfm"})
        for (std::size_t i = 0; i < frames; ++i)
            if (name == frame_file(i, extension)) return true;
    return false;
}

/// Whether `file` has a name that a trace writes in its folder.
bool is_of_trace(fs::path const& file, fs::path const& folder, std::optional<std::uint32_t> followed)
{
    std::error_code ignored;
    auto const name = file.filename().string();
    if (!fs::equivalent(fs::absolute(file).parent_path(), folder, ignored)) return false;
    if (name == "report.html" || name == "model.txt" || name == no_progress_file || name == counters_file) return true;
    if (followed && name == follow_file(*followed)) return true;
    auto const ends = [&](std::string_view end) { return name.ends_with(end); };
    return name.starts_with("frame_") && (ends(".tiles.csv") || ends(".supersteps.csv") || ends(".heat.csv") ||
                                          ends(".energy.csv") || ends(".trace.json") || (ends(".png") && name.find(".heat_") != std::string::npos));
}

/// Those of the files that the run reads.
std::vector<fs::path> files_read(Options const& options)
{
    std::vector<fs::path> files;
    if (!options.map.empty()) files.push_back(options.map);
    for (auto const* file : {&options.cameras, &options.trajectory, &options.cost_model, &options.energy})
        if (*file) files.push_back(**file);
    return files;
}

void check_report(Options const& options, fs::path const& out, std::size_t frames)
{
    auto const& report = *options.report;
    auto const refuse = [&](std::string const& why) {
        throw Error("cannot write the report to " + report.string() + " (" + why + "); name another file with --report");
    };
    std::error_code refused;
    auto const status = fs::status(report, refused);
    auto const folder = fs::absolute(fs::is_other(status) ? report : tilemesh::report::link_target(report)).parent_path();
    if (fs::is_directory(status)) refuse("it is a directory");
    if (refused && fs::exists(status)) refuse(refused.message());
    if (!fs::is_directory(folder, refused)) refuse("there is no directory " + folder.string());
    // A report takes the place of a regular file, which needs the right to write into the folder alone.
    auto const& written = fs::is_other(status) ? report : folder;
    if (access(written.c_str(), W_OK) != 0) refuse(last_error());
    if (is_frame(report, out, frames)) refuse("a picture of this run has that name");
    if (options.trace && is_of_trace(report, *options.trace, options.follow))
        refuse("the trace of this run has a file of that name");
    for (auto const& read : files_read(options))
        if (fs::equivalent(read, report, refused)) refuse("this run reads that file");
}

void make_folder(fs::path const& folder, std::string const& option)
{
    auto const refuse = [&](std::string const& why) {
        throw Error("cannot write to " + folder.string() + " (" + why + "); name a writable directory with " + option);
    };
    std::error_code refused;
    fs::create_directories(folder, refused);
    if (refused) refuse(refused.message());
    if (!fs::is_directory(folder, refused)) refuse("it is no directory");
    if (access(folder.c_str(), W_OK | X_OK) != 0) refuse(last_error());
}

} // namespace

std::string frame_file(std::size_t frame, std::string const& extension)
{
    auto digits = std::to_string(frame);
    if (digits.size() < 4) digits.insert(0, 4 - digits.size(), '0');
    return "frame_" + digits + extension;
}

std::string follow_file(std::uint32_t id)
{
    return "follow_" + std::to_string(id) + ".csv";
}

fs::path prepare_outputs(Options const& options, std::size_t frames)
{
    auto const out = options.out.value_or("tilemesh_out");
    make_folder(out, "--out");
    if (options.trace) {
        make_folder(*options.trace, "--trace");
        for (auto const& read : files_read(options))
            if (is_of_trace(read, *options.trace, options.follow))
                throw Error("cannot write the trace to " + options.trace->string() + " (it would overwrite " +
                            read.filename().string() + ", which this run reads); name another directory with --trace");
    }
    if (options.report) check_report(options, out, frames);
    return out;
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
