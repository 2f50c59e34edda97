#include "output_files.hpp"
#include <cerrno>
#include <iostream>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <unistd.h>

namespace shared {

namespace fs = std::filesystem;
using tilemesh::Error;

namespace {

std::string last_error()
{
    return std::generic_category().message(errno);
}

} // namespace

void check_file(fs::path const& path, std::string const& what, std::string const& remedy)
{
    auto const refuse = [&](std::string const& why) {
        throw Error("cannot write " + what + " to " + path.string() + " (" + why + "); " + remedy);
    };
    std::error_code refused;
    auto const status = fs::status(path, refused);
    auto const folder = fs::absolute(fs::is_other(status) ? path : tilemesh::report::link_target(path)).parent_path();
    if (fs::is_directory(status) || !path.has_filename()) refuse("it is a directory");
    if (refused && fs::exists(status)) refuse(refused.message());
    if (!fs::is_directory(folder, refused)) refuse("there is no directory " + folder.string());
    // A regular file is replaced; this needs only the right to write into the folder.
    auto const& written = fs::is_other(status) ? path : folder;
    if (access(written.c_str(), W_OK) != 0) refuse(last_error());
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

void print(std::string const& text, char const* remedy, std::ostream& to)
{
    errno = 0;
    to << text << std::flush;
    if (!to)
        throw Error(std::string("cannot write to standard ") + (&to == &std::cerr ? "error" : "output") + " (" +
                    (errno != 0 ? last_error() : std::string("the stream failed")) + "); " + remedy);
}

} // namespace shared
