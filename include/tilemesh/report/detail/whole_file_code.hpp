#pragma once
#include <new>
#include <tilemesh/report/whole_file.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace report {

TILEMESH_HOST std::filesystem::path link_target(std::filesystem::path path)
{
    std::error_code ignored;
    for (int links = 0; std::filesystem::is_symlink(std::filesystem::symlink_status(path, ignored)); ++links) {
        if (links == 40) // the limit of Linux
            throw Error("cannot write " + path.string() + " (its symbolic links lead in a ring); name another file");
        path = path.parent_path() / std::filesystem::read_symlink(path, ignored);
    }
    return path;
}

namespace detail {

TILEMESH_HOST std::error_code sync_to_disk(int descriptor)
{
    if (fsync(descriptor) == 0 || errno == EINVAL || errno == EROFS || errno == ENOTSUP) return {};
    return {errno, std::generic_category()};
}

TILEMESH_HOST std::error_code sync_folder(std::filesystem::path const& folder)
{
    int const descriptor = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) return {};
    auto const why = sync_to_disk(descriptor);
    close(descriptor);
    return why;
}

} // namespace detail

TILEMESH_HOST WholeFile::WholeFile(std::filesystem::path const& path, std::string const& room, Outlasts outlasts)
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

TILEMESH_HOST WholeFile::WholeFile(std::FILE* stream, std::string what, std::string remedy)
    : what_(std::move(what)), remedy_(std::move(remedy)), file_(stream), owned_(false)
{}

TILEMESH_HOST WholeFile::~WholeFile()
{
    if (file_ && owned_) std::fclose(file_);
    std::error_code ignored;
    if (!part_.empty()) std::filesystem::remove(part_, ignored);
}

TILEMESH_HOST void WholeFile::put(std::string_view bytes)
{
    errno = 0;
    if (!bytes.empty() && std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) fail(system_error());
}

TILEMESH_HOST void WholeFile::flush()
{
    errno = 0;
    if (std::fflush(file_) != 0) fail(system_error());
}

TILEMESH_HOST void WholeFile::finish()
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

TILEMESH_HOST void WholeFile::fail(std::error_code why) const
{
    if (why == std::errc::not_enough_memory) throw std::bad_alloc();
    throw Error("cannot write " + what_ + " (" + why.message() + "); " + remedy_);
}

TILEMESH_HOST void write_whole(std::filesystem::path const& path, std::string_view header, std::span<std::byte const> body, Outlasts outlasts)
{
    WholeFile file(path, std::to_string(header.size() + body.size()) + " bytes", outlasts);
    file.put(header);
    file.put({reinterpret_cast<char const*>(body.data()), body.size()});
    file.finish();
}

}}} // namespace tilemesh::report
