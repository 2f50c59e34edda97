#pragma once
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <istream>
#include <new>
#include <string>
#include <system_error>
#include <tilemesh/error.hpp>

namespace shared {

/// What `read` makes of a regular file. Opens no pipe and no device: they wait, or never end. `what` and `remedy` are parts of the error.
template <class Model>
Model load_model(std::filesystem::path const& file, Model (*read)(std::istream&, std::string const&), char const* what, char const* remedy)
{
    namespace fs = std::filesystem;
    auto const refuse = [&](std::string const& why) {
        throw tilemesh::Error("cannot read the " + std::string(what) + " " + file.string() + " (" + why + "); " + remedy);
    };
    std::error_code refused;
    auto const status = fs::status(file, refused);
    if (refused == std::errc::not_enough_memory) throw std::bad_alloc();
    if (refused) refuse(refused.message());
    if (fs::is_directory(status)) refuse("it is a directory");
    if (!fs::is_regular_file(status)) refuse("it is a pipe or a device");
    errno = 0;
    std::ifstream in(file, std::ios::binary);
    if (!in && errno == ENOMEM) throw std::bad_alloc();
    if (!in) refuse(std::generic_category().message(errno));
    return read(in, file.string());
}

} // namespace shared
