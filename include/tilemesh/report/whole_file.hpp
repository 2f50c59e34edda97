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
#include <utility>

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
    WholeFile(std::filesystem::path const& path, std::string const& room, Outlasts outlasts = Outlasts::process)
        : what_(path.string()), remedy_("name a writable place with room for " + room)
    {
        namespace fs = std::filesystem;
        std::error_code ignored;
        auto const type = fs::status(path, ignored).type();
        bool const straight = type == fs::file_type::character || type == fs::file_type::block || type == fs::file_type::fifo ||
                              type == fs::file_type::socket;
        if (type == fs::file_type::directory) fail(std::make_error_code(std::errc::is_a_directory));
        errno = 0;
        if (straight) {
            file_ = std::fopen(path.c_str(), "wb");
        } else {
            name_ = link_target(path);
            synced_ = outlasts == Outlasts::power_loss;
            for (unsigned number = 1; !file_; ++number) {
                part_ = name_;
                if (number > 1) part_.concat(".").concat(std::to_string(number));
                part_ += ".part";
                errno = 0;
                file_ = std::fopen(part_.c_str(), "wbx"); // x: the part did not exist before, so no other writer has it
                if (!file_ && errno != EEXIST) break;
            }
        }
        if (!file_) fail(system_error());
    }
    /// An open stream, which the caller closes. `what` and `remedy` begin and end an error: "cannot write `what` (why); `remedy`".
    WholeFile(std::FILE* stream, std::string what, std::string remedy)
        : what_(std::move(what)), remedy_(std::move(remedy)), file_(stream), owned_(false)
    {
    }
    ~WholeFile()
    {
        if (file_ && owned_) std::fclose(file_);
        std::error_code ignored;
        if (!part_.empty()) std::filesystem::remove(part_, ignored);
    }
    WholeFile(WholeFile const&) = delete;
    WholeFile& operator=(WholeFile const&) = delete;

    void put(std::string_view bytes)
    {
        errno = 0;
        if (!bytes.empty() && std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) fail(system_error());
    }
    /// Hands all bytes to the system, so that the reader of a pipe gets them.
    void flush()
    {
        errno = 0;
        if (std::fflush(file_) != 0) fail(system_error());
    }
    /// Call it once, after the last piece.
    void finish()
    {
        flush();
        if (!owned_) return;
        std::error_code why;
        if (synced_) why = detail::sync_to_disk(fileno(file_));
        if (std::fclose(std::exchange(file_, nullptr)) != 0 && !why) why = system_error();
        if (!why && !part_.empty()) std::filesystem::rename(part_, name_, why);
        if (why) fail(why);
        part_.clear();
        if (synced_ && (why = detail::sync_folder(name_.parent_path()))) fail(why);
    }

private:
    static std::error_code system_error() { return {errno != 0 ? errno : EIO, std::generic_category()}; }
    [[noreturn]] void fail(std::error_code why) const
    {
        if (why == std::errc::not_enough_memory) throw std::bad_alloc();
        throw Error("cannot write " + what_ + " (" + why.message() + "); " + remedy_);
    }

    std::string what_, remedy_;
    std::filesystem::path name_, part_; ///< empty if there is no part to rename: a device, a pipe, a stream
    std::FILE* file_ = nullptr;
    bool owned_ = true, synced_ = false;
};

/// Writes `header`, then `body`, as a `WholeFile`, with its errors and its cost.
inline void write_whole(std::filesystem::path const& path, std::string_view header, std::span<std::byte const> body = {},
                        Outlasts outlasts = Outlasts::process)
{
    WholeFile file(path, std::to_string(header.size() + body.size()) + " bytes", outlasts);
    file.put(header);
    file.put({reinterpret_cast<char const*>(body.data()), body.size()});
    file.finish();
}

}}} // namespace tilemesh::report
