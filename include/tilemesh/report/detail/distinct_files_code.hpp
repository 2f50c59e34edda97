#pragma once
#include <new>
#include <system_error>
#include <tilemesh/report/distinct_files.hpp>
#include <tilemesh/report/whole_file.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

TILEMESH_HOST void DistinctFiles::read(std::filesystem::path const& path)
{
    if (auto const file = find(path)) read_.emplace(id_of(*file), path.string());
}

TILEMESH_HOST void DistinctFiles::write_stream(int descriptor, std::string const& what, std::string const& remedy)
{
    struct stat file {};
    if (fstat(descriptor, &file) != 0 || !S_ISREG(file.st_mode)) return;
    if (auto const clash = read_.find(id_of(file)); clash != read_.end())
        throw Error(what + " cannot go to " + clash->second + " (this run reads that file); " + remedy);
    streams_.emplace(id_of(file), what);
}

TILEMESH_HOST void DistinctFiles::write(std::filesystem::path const& path, std::string const& what, std::string const& remedy)
{
    Target const target{path, what, remedy};
    check_content(target);
    auto const place = place_of(target);
    for (auto const& folder : folders_)
        if (folder.id == place.folder && folder.is_written(place.name)) refuse(target, folder.what + " of this run has that name");
    add(target, place);
}

TILEMESH_HOST void DistinctFiles::write_into(std::filesystem::path const& folder, std::function<bool(std::string const&)> is_written,
                                             std::string const& what, std::string const& remedy, Devices devices)
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

TILEMESH_HOST auto DistinctFiles::find(std::filesystem::path const& path) -> Found
{
    Found found;
    found.there = ::stat(path.c_str(), &found.file) == 0;
    return found;
}

TILEMESH_HOST std::string DistinctFiles::folded(std::string name)
{
    for (char& c : name)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return name;
}

TILEMESH_HOST bool DistinctFiles::is_device(std::filesystem::path const& path)
{
    auto const file = find(path);
    return file && !S_ISREG((*file).st_mode) && !S_ISDIR((*file).st_mode);
}

TILEMESH_HOST void DistinctFiles::refuse(Target const& target, std::string const& why)
{
    throw Error("cannot write " + target.what + " to " + target.path.string() + " (" + why + "); " + target.remedy);
}

TILEMESH_HOST std::set<std::string> DistinctFiles::written_names(std::filesystem::path const& folder,
                                                                 std::function<bool(std::string const&)> const& is_written, std::string const& remedy)
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

TILEMESH_HOST void DistinctFiles::check_content(Target const& target) const
{
    auto const file = find(target.path);
    if (!file || !S_ISREG((*file).st_mode)) return;
    if (auto const clash = read_.find(id_of(*file)); clash != read_.end())
        refuse(target, "this run reads that file" + (clash->second == target.path.string() ? "" : ": it is " + clash->second));
    if (auto const clash = streams_.find(id_of(*file)); clash != streams_.end()) refuse(target, clash->second + " goes to that file");
}

TILEMESH_HOST auto DistinctFiles::place_of(Target const& target) -> Place
{
    auto const end = link_target(target.path);
    auto const parent = end.parent_path();
    auto const folder = find(parent.empty() ? "." : parent);
    if (!folder || !S_ISDIR((*folder).st_mode)) refuse(target, "there is no directory " + parent.string());
    return {id_of(*folder), folded(end.filename().string())};
}

TILEMESH_HOST void DistinctFiles::add(Target const& target, Place const& place)
{
    if (is_device(target.path)) return; // a device may be written several times
    auto const [other, is_new] = written_.emplace(place, target);
    if (!is_new) refuse(target, "that is the file of " + other->second.what + " of this run, " + other->second.path.string());
}

}}} // namespace tilemesh::report
