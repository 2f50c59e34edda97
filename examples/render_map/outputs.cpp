#include "outputs.hpp"
#include <cerrno>
#include <iostream>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <unistd.h>

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

void check_report(Options const& options, fs::path const& out, std::size_t frames)
{
    auto const& report = *options.report;
    auto const refuse = [&](std::string const& why) {
        throw Error("cannot write the report to " + report.string() + " (" + why + "); name another file with --report");
    };
    std::error_code refused;
    auto const status = fs::status(report, refused);
    auto const folder = fs::absolute(fs::is_other(status) ? report : tilemesh::report::behind_links(report)).parent_path();
    if (fs::is_directory(status)) refuse("it is a directory");
    if (refused && fs::exists(status)) refuse(refused.message());
    if (!fs::is_directory(folder, refused)) refuse("there is no directory " + folder.string());
    // A report takes the place of a regular file, which needs the right to write into the folder alone.
    auto const& written = fs::is_other(status) ? report : folder;
    if (access(written.c_str(), W_OK) != 0) refuse(last_error());
    if (is_frame(report, out, frames)) refuse("a picture of this run has that name");
    for (auto const* read :
         {&options.map, options.cameras ? &*options.cameras : nullptr, options.trajectory ? &*options.trajectory : nullptr})
        if (read && !read->empty() && fs::equivalent(*read, report, refused)) refuse("this run reads that file");
}

} // namespace

std::string frame_file(std::size_t frame, std::string const& extension)
{
    auto digits = std::to_string(frame);
    if (digits.size() < 4) digits.insert(0, 4 - digits.size(), '0');
    return "frame_" + digits + extension;
}

fs::path prepare_outputs(Options const& options, std::size_t frames)
{
    auto const out = options.out.value_or("tilemesh_out");
    auto const refuse = [&](std::string const& why) {
        throw Error("cannot write to " + out.string() + " (" + why + "); name a writable directory with --out");
    };
    std::error_code refused;
    fs::create_directories(out, refused);
    if (refused) refuse(refused.message());
    if (!fs::is_directory(out, refused)) refuse("it is no directory");
    if (access(out.c_str(), W_OK | X_OK) != 0) refuse(last_error());
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
