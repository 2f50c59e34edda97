#pragma once
#include <filesystem>
#include <tilemesh/report/distinct_files.hpp>
#include <unistd.h>
#include <vector>

namespace shared {

/// For programs whose outputs have fixed names in the current folder: no output may be a file that the program reads, also by a link.
/// Throws `tilemesh::Error`, before anything is written, for the first output that is one.
inline void keep_inputs(std::vector<std::filesystem::path> const& read, std::vector<std::filesystem::path> const& written)
{
    constexpr char const* remedy = "run the program in another folder";
    tilemesh::report::DistinctFiles files;
    for (auto const& file : read) files.read(file);
    files.write_stream(STDOUT_FILENO, "standard output", "send it to another file");
    for (auto const& file : written) files.write(file, "a picture", remedy);
}

} // namespace shared
