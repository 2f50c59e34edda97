#pragma once
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <fcntl.h>
#include <filesystem>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <unistd.h>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// The file that `path` names after its symbolic links are followed. The file need not exist. Throws `Error` for a cycle of links.
inline std::filesystem::path link_target(std::filesystem::path path)
{
    std::error_code ignored;
    for (int links = 0; std::filesystem::is_symlink(std::filesystem::symlink_status(path, ignored)); ++links) {
        if (links == 40) // the limit of Linux
            throw Error("cannot write " + path.string() + " (its symbolic links lead in a ring); name another file");
        path = path.parent_path() / std::filesystem::read_symlink(path, ignored);
    }
    return path;
}

/// The event that a finished file survives. `process`: the end of the process, also by a kill; but after a power loss the new name may have
/// no bytes. `power_loss`: also a power loss; the bytes are synced to the disk before the rename, and the folder after it.
enum class Outlasts { process, power_loss };

namespace detail {
/// Waits until the disk has the bytes of an open file or folder. It is not an error if a file system cannot sync.
inline std::error_code sync_to_disk(int descriptor)
{
    if (fsync(descriptor) == 0 || errno == EINVAL || errno == EROFS || errno == ENOTSUP) return {};
    return {errno, std::generic_category()};
}
/// Waits until the disk has the names in a folder. A folder without read permission cannot be opened; it is synced later.
inline std::error_code sync_folder(std::filesystem::path const& folder)
{
    int const descriptor = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) return {};
    auto const why = sync_to_disk(descriptor);
    close(descriptor);
    return why;
}

/// `write_whole` for bytes that are made piece by piece. It calls `produce(put)`, which calls `put(text)` for each piece.
/// `room` is the disk space that the error asks for, in words.
template <class Produce>
void write_in_pieces(std::filesystem::path const& path, std::string const& room, Outlasts outlasts, Produce produce)
{
    namespace fs = std::filesystem;
    std::error_code ignored;
    auto const type = fs::status(path, ignored).type();
    bool const straight = type == fs::file_type::character || type == fs::file_type::block || type == fs::file_type::fifo ||
                          type == fs::file_type::socket;
    auto const fail = [&](std::error_code why) {
        if (why == std::errc::not_enough_memory) throw std::bad_alloc();
        throw Error("cannot write " + path.string() + " (" + why.message() + "); name a writable place with room for " + room);
    };
    auto const system_error = [] { return std::error_code(errno != 0 ? errno : EIO, std::generic_category()); };
    if (type == fs::file_type::directory) fail(std::make_error_code(std::errc::is_a_directory));

    // Mode x: the part did not exist before, so no other writer has it.
    auto const name = straight ? path : link_target(path);
    auto part = name;
    std::FILE* file = nullptr;
    errno = 0;
    if (straight) file = std::fopen(name.string().c_str(), "wb");
    for (unsigned number = 1; !straight && !file; ++number) {
        part = name;
        if (number > 1) part.concat(".").concat(std::to_string(number));
        part += ".part";
        errno = 0;
        file = std::fopen(part.string().c_str(), "wbx");
        if (!file && errno != EEXIST) break;
    }
    if (!file) fail(system_error());

    std::error_code why;
    errno = 0;
    auto const put = [&](std::string_view bytes) {
        if (!why && !bytes.empty() && std::fwrite(bytes.data(), 1, bytes.size(), file) != bytes.size()) why = system_error();
    };
    try {
        produce(put);
    } catch (...) {
        std::fclose(file);
        if (!straight) fs::remove(part, ignored);
        throw;
    }
    if (!why && std::fflush(file) != 0) why = system_error();
    bool const synced = outlasts == Outlasts::power_loss && !straight;
    if (!why && synced) why = sync_to_disk(fileno(file));
    if (std::fclose(file) != 0 && !why) why = system_error();
    if (!why && !straight) fs::rename(part, name, why);
    if (why && !straight) fs::remove(part, ignored);
    if (!why && synced) why = sync_folder(name.parent_path());
    if (why) fail(why);
}
} // namespace detail

/// Writes `header`, then `body`, as the file `path`: whole or not at all.
///
/// It writes the bytes to a new file beside `path`, "<name>.part", or if that exists "<name>.2.part" and so on. It checks every write and
/// the close, then renames the file to `path`. So a file at `path` is always whole. Of two writers at the same time, the one that ends last
/// wins. On failure it removes the part, and the old file is unchanged; a process that is killed leaves its part. A replaced file gets the
/// permissions of a new file. A symbolic link is followed. Bytes for a device or a pipe are written directly; the call waits until somebody
/// reads the pipe. With `Outlasts::power_loss`, the file and its name are on the disk when the call returns.
///
/// Throws `tilemesh::Error` with the system's reason if the bytes cannot be written, and `std::bad_alloc` if it is out of memory. Cost: the
/// bytes on disk, in addition to the old file until the rename; no copy in memory. With `Outlasts::power_loss` the call waits for the disk
/// twice.
inline void write_whole(std::filesystem::path const& path, std::string_view header, std::span<std::byte const> body = {},
                        Outlasts outlasts = Outlasts::process)
{
    detail::write_in_pieces(path, std::to_string(header.size() + body.size()) + " bytes", outlasts, [&](auto const& put) {
        put(header);
        put({reinterpret_cast<char const*>(body.data()), body.size()});
    });
}

}}} // namespace tilemesh::report
