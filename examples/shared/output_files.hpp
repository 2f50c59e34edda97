#pragma once
#include <filesystem>
#include <ostream>
#include <string>

namespace shared {

/// Checks that a file can get the name `path`; it opens nothing. `what` names the file: "the report". `remedy` ends the error: "name another
/// file with --report". Throws `tilemesh::Error` if the path is a directory, if its directory is not there, or if it cannot be written.
void check_file(std::filesystem::path const& path, std::string const& what, std::string const& remedy);

/// Makes a folder, and the folders above it. `option` names it: "--out". Throws `tilemesh::Error` if the folder cannot be made or written,
/// or if a link in its path leads nowhere: that is often an unmounted disk.
void make_folder(std::filesystem::path const& folder, std::string const& option);

/// Prints to a standard stream. If the text cannot be written, it throws `tilemesh::Error`, which ends with `remedy`.
void print(std::string const& text, char const* remedy, std::ostream& to);

} // namespace shared
