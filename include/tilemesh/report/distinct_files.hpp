#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <sys/stat.h>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tuple>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// Checks, before a program writes anything, that it would overwrite neither a file that it reads nor another file that it writes. First
/// name the files that it reads, then the streams, then the files that it writes. Each call throws `Error` if its file clashes with a file
/// of an earlier call.
///
/// Existing files are compared by device and inode: links are followed, hard links are one file, and `a/../b` is `b`. A file that does not
/// exist yet is compared by its name and by the device and inode of its folder. In such a name, small and capital ASCII letters are equal,
/// because some file systems treat them as equal. The check does not know which other letters a file system treats as equal.
///
/// Cost: one or two system calls for each named file, and for each existing file in a folder whose name the program will write. The check
/// does not see later changes to the files.
class DistinctFiles {
public:
    /// May a device, such as /dev/null, have the name of a file that the program writes? Not if the program reads the file later.
    enum class Devices { allowed, refused };

    /// A file that the program reads. A path without a file is ignored.
    TILEMESH_HOST void read(std::filesystem::path const& path);

    /// A stream of the process, by its descriptor. `what` names it: "standard output". Several streams may go to one file.
    TILEMESH_HOST void write_stream(int descriptor, std::string const& what, std::string const& remedy);

    /// A file that `write_whole` will write. It may be a device or a pipe. `what` names it: "the report". `remedy` ends the error: "name
    /// another file with --report".
    TILEMESH_HOST void write(std::filesystem::path const& path, std::string const& what, std::string const& remedy);

    /// All files that the program will write into an existing folder. They may replace regular files, but no pipe and no socket, and
    /// a device only if `devices` allows it.
    /// `is_written(name)` says whether the program writes a file of that name, given in lower-case ASCII. `what` names one file: "a
    /// picture". `remedy` ends the error: "name another directory with --out".
    TILEMESH_HOST void write_into(std::filesystem::path const& folder, std::function<bool(std::string const&)> is_written,
                                  std::string const& what, std::string const& remedy, Devices devices = Devices::allowed);

private:
    using Id = std::pair<std::uintmax_t, std::uintmax_t>; ///< device, inode
    struct Place {
        Id folder;
        std::string name; ///< in lower-case ASCII
        bool operator<(Place const& other) const { return std::tie(folder, name) < std::tie(other.folder, other.name); }
    };
    struct Target {
        std::filesystem::path path;
        std::string what, remedy;
    };
    struct Folder {
        Id id;
        std::function<bool(std::string const&)> is_written;
        std::string what;
    };

    struct Found {
        struct stat file {};
        bool there = false;
        explicit operator bool() const { return there; }
        struct stat const& operator*() const { return file; }
    };
    TILEMESH_HOST static Found find(std::filesystem::path const& path);
    static Id id_of(struct stat const& file) { return {file.st_dev, file.st_ino}; }
    TILEMESH_HOST static std::string folded(std::string name);
    TILEMESH_HOST static bool is_device(std::filesystem::path const& path);
    [[noreturn]] TILEMESH_HOST static void refuse(Target const& target, std::string const& why);

    /// The names in `folder` that `is_written` accepts, in lower-case ASCII. Names that differ in capital letters only are one name.
    TILEMESH_HOST static std::set<std::string> written_names(std::filesystem::path const& folder,
                                                             std::function<bool(std::string const&)> const& is_written, std::string const& remedy);

    TILEMESH_HOST void check_content(Target const& target) const;
    /// The place to which `write_whole` writes the file.
    TILEMESH_HOST static Place place_of(Target const& target);
    TILEMESH_HOST void add(Target const& target, Place const& place);

    std::map<Id, std::string> read_, streams_;
    std::map<Place, Target> written_; ///< single files, and the targets of links in the folders
    std::vector<Folder> folders_;
};

}}} // namespace tilemesh::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/distinct_files_code.hpp>
#endif
