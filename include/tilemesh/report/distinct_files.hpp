#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <new>
#include <set>
#include <string>
#include <sys/stat.h>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/report/whole_file.hpp>
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
    void read(std::filesystem::path const& path)
    {
        if (auto const file = find(path)) read_.emplace(id_of(*file), path.string());
    }

    /// A stream of the process, by its descriptor. `what` names it: "standard output". Several streams may go to one file.
    void write_stream(int descriptor, std::string const& what, std::string const& remedy)
    {
        struct stat file {};
        if (fstat(descriptor, &file) != 0 || !S_ISREG(file.st_mode)) return;
        if (auto const clash = read_.find(id_of(file)); clash != read_.end())
            throw Error(what + " cannot go to " + clash->second + " (this run reads that file); " + remedy);
        streams_.emplace(id_of(file), what);
    }

    /// A file that `write_whole` will write. It may be a device or a pipe. `what` names it: "the report". `remedy` ends the error: "name
    /// another file with --report".
    void write(std::filesystem::path const& path, std::string const& what, std::string const& remedy)
    {
        Target const target{path, what, remedy};
        check_content(target);
        auto const place = place_of(target);
        for (auto const& folder : folders_)
            if (folder.id == place.folder && folder.is_written(place.name)) refuse(target, folder.what + " of this run has that name");
        add(target, place);
    }

    /// All files that the program will write into an existing folder. They may replace regular files, but no pipe and no socket, and
    /// a device only if `devices` allows it.
    /// `is_written(name)` says whether the program writes a file of that name, given in lower-case ASCII. `what` names one file: "a
    /// picture". `remedy` ends the error: "name another directory with --out".
    void write_into(std::filesystem::path const& folder, std::function<bool(std::string const&)> is_written, std::string const& what,
                    std::string const& remedy, Devices devices = Devices::allowed)
    {
        namespace fs = std::filesystem;
        auto const status = find(folder);
        auto const names = written_names(folder, is_written, remedy);
        if (!status) throw Error("cannot look into " + folder.string() + " (it is gone); " + remedy);
        folders_.push_back({id_of(*status), std::move(is_written), what});
        auto const& own = folders_.back();
        for (auto const& [place, other] : written_)
            if (place.folder == own.id && own.is_written(place.name)) refuse(other, what + " of this run has that name");
        for (auto const& name : names) {
            Target const target{folder / name, what, remedy};
            struct stat self {};
            if (lstat(target.path.c_str(), &self) != 0) continue; // the existing name differs in capital letters
            check_content(target);
            std::error_code ignored; // a link to a missing file is not a pipe
            if (auto const type = fs::status(target.path, ignored).type(); type == fs::file_type::fifo || type == fs::file_type::socket)
                refuse(target, "it is a pipe or a socket, and a write would wait for its reader");
            if (devices == Devices::refused && is_device(target.path)) refuse(target, "it is a device, and this run reads its files again");
            if (!S_ISLNK(self.st_mode)) continue;
            auto const place = place_of(target);
            if (!is_device(target.path))
                for (auto const& each : folders_)
                    if (each.id == place.folder && each.is_written(place.name))
                        refuse(target, "it is a link to " + each.what + " of this run, " + link_target(target.path).string());
            add(target, place);
        }
    }

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
    static Found find(std::filesystem::path const& path)
    {
        Found found;
        found.there = ::stat(path.c_str(), &found.file) == 0;
        return found;
    }
    static Id id_of(struct stat const& file) { return {file.st_dev, file.st_ino}; }
    static std::string folded(std::string name)
    {
        for (char& c : name)
            if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
        return name;
    }
    static bool is_device(std::filesystem::path const& path)
    {
        auto const file = find(path);
        return file && !S_ISREG((*file).st_mode) && !S_ISDIR((*file).st_mode);
    }
    [[noreturn]] static void refuse(Target const& target, std::string const& why)
    {
        throw Error("cannot write " + target.what + " to " + target.path.string() + " (" + why + "); " + target.remedy);
    }

    /// The names in `folder` that `is_written` accepts, in lower-case ASCII. Names that differ in capital letters only are one name.
    static std::set<std::string> written_names(std::filesystem::path const& folder, std::function<bool(std::string const&)> const& is_written,
                                               std::string const& remedy)
    {
        std::error_code refused;
        auto const check = [&] {
            if (refused == std::errc::not_enough_memory) throw std::bad_alloc();
            if (refused) throw Error("cannot look into " + folder.string() + " (" + refused.message() + "); " + remedy);
        };
        std::set<std::string> names;
        std::filesystem::directory_iterator entry(folder, refused);
        check();
        while (entry != std::filesystem::directory_iterator()) {
            if (auto name = folded(entry->path().filename().string()); is_written(name)) names.insert(std::move(name));
            entry.increment(refused); // an error also makes it the end
            check();
        }
        return names;
    }

    void check_content(Target const& target) const
    {
        auto const file = find(target.path);
        if (!file || !S_ISREG((*file).st_mode)) return;
        if (auto const clash = read_.find(id_of(*file)); clash != read_.end())
            refuse(target, "this run reads that file" + (clash->second == target.path.string() ? "" : ": it is " + clash->second));
        if (auto const clash = streams_.find(id_of(*file)); clash != streams_.end()) refuse(target, clash->second + " goes to that file");
    }
    /// The place to which `write_whole` writes the file.
    static Place place_of(Target const& target)
    {
        auto const end = link_target(target.path);
        auto const parent = end.parent_path();
        auto const folder = find(parent.empty() ? "." : parent);
        if (!folder || !S_ISDIR((*folder).st_mode)) refuse(target, "there is no directory " + parent.string());
        return {id_of(*folder), folded(end.filename().string())};
    }
    void add(Target const& target, Place const& place)
    {
        if (is_device(target.path)) return; // a device may be written several times
        auto const [other, is_new] = written_.emplace(place, target);
        if (!is_new) refuse(target, "that is the file of " + other->second.what + " of this run, " + other->second.path.string());
    }

    std::map<Id, std::string> read_, streams_;
    std::map<Place, Target> written_; ///< single files, and the targets of links in the folders
    std::vector<Folder> folders_;
};

}}} // namespace tilemesh::report
