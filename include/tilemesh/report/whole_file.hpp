#pragma once
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <fcntl.h>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <unistd.h>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// The file that `path` names after its symbolic links are followed. The file need not exist. Throws `Error` for a cycle of links.
TILEMESH_HOST std::filesystem::path link_target(std::filesystem::path path);

/// The event that a finished file survives. `process`: the end of the process, also by a kill; but after a power loss the new name may have
/// no bytes. `power_loss`: also a power loss; the bytes are synced to the disk before the rename, and the folder after it.
enum class Outlasts { process, power_loss };

namespace detail {
/// Waits until the disk has the bytes of an open file or folder. It is not an error if a file system cannot sync.
TILEMESH_HOST std::error_code sync_to_disk(int descriptor);
/// Waits until the disk has the names in a folder. A folder without read permission cannot be opened; it is synced later.
TILEMESH_HOST std::error_code sync_folder(std::filesystem::path const& folder);
} // namespace detail

/// A file that is written piece by piece: whole or not at all.
///
/// It writes the bytes to a new file beside `path`, "<name>.part", or if that exists "<name>.2.part" and so on. `finish` checks the close,
/// then renames the file to `path`. So a file at `path` is always whole. Of two writers at the same time, the one that ends last wins. An
/// object that is destroyed without `finish` removes the part, and the old file is unchanged; a process that is killed leaves its part. A
/// replaced file gets the permissions of a new file. A symbolic link is followed. Bytes for a device or a pipe are written directly; the
/// constructor waits until somebody reads the pipe. With `Outlasts::power_loss`, the file and its name are on the disk when `finish` returns.
///
/// Each call throws `tilemesh::Error` with the system's reason if the bytes cannot be written, and `std::bad_alloc` if it is out of memory.
/// Cost: the bytes on disk, in addition to the old file until the rename; no copy in memory. With `Outlasts::power_loss`, `finish` waits for
/// the disk twice.
class WholeFile {
public:
    /// `room` is the disk space that an error asks for, in words.
    TILEMESH_HOST WholeFile(std::filesystem::path const& path, std::string const& room, Outlasts outlasts = Outlasts::process);
    /// An open stream, which the caller closes. `what` and `remedy` begin and end an error: "cannot write `what` (why); `remedy`".
    TILEMESH_HOST WholeFile(std::FILE* stream, std::string what, std::string remedy);
    TILEMESH_HOST ~WholeFile();
    WholeFile(WholeFile const&) = delete;
    WholeFile& operator=(WholeFile const&) = delete;

    TILEMESH_HOST void put(std::string_view bytes);
    /// Hands all bytes to the system, so that the reader of a pipe gets them.
    TILEMESH_HOST void flush();
    /// Call it once, after the last piece.
    TILEMESH_HOST void finish();

private:
    static std::error_code system_error() { return {errno != 0 ? errno : EIO, std::generic_category()}; }
    [[noreturn]] TILEMESH_HOST void fail(std::error_code why) const;

    std::string what_, remedy_;
    std::filesystem::path name_, part_; ///< empty if there is no part to rename: a device, a pipe, a stream
    std::FILE* file_ = nullptr;
    bool owned_ = true, synced_ = false;
};

/// Writes `header`, then `body`, as a `WholeFile`, with its errors and its cost.
TILEMESH_HOST void write_whole(std::filesystem::path const& path, std::string_view header,
                               std::span<std::byte const> body = {}, Outlasts outlasts = Outlasts::process);

}}} // namespace tilemesh::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/whole_file_code.hpp>
#endif
