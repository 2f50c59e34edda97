#pragma once
#include "../standard.hpp"
#include <atomic>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <sys/stat.h>
#include <system_error>
#include <tilemesh/splat/camera.hpp>

// Shared by the scene tests: files that remove themselves, the folder of real data, error texts.
namespace scene_test {

using tests::fast;
using Lines = std::vector<std::string>;

/// A file with these bytes in the temporary folder; gone at the end of its scope.
class TempFile {
public:
    TempFile(std::string const& bytes, std::string const& extension)
    {
        static std::atomic<unsigned> counter{0};
        static auto const run = static_cast<unsigned long long>(std::filesystem::file_time_type::clock::now().time_since_epoch().count());
        path_ = std::filesystem::temp_directory_path() /
                ("tilemesh_scene_" + std::to_string(run) + "_" + std::to_string(reinterpret_cast<std::uintptr_t>(&counter)) + "_" +
                 std::to_string(counter++) + extension);
        std::ofstream(path_, std::ios::binary) << bytes;
    }
    ~TempFile()
    {
        std::error_code ignored;
        std::filesystem::remove(path_, ignored);
    }
    TempFile(TempFile const&) = delete;
    TempFile& operator=(TempFile const&) = delete;

    std::filesystem::path const& path() const { return path_; }

private:
    std::filesystem::path path_;
};

/// A folder that removes itself, with all that lies in it.
class TempFolder {
public:
    explicit TempFolder(std::string const& extension = "_folder") : place_("", extension)
    {
        std::filesystem::remove(place_.path());
        std::filesystem::create_directory(place_.path());
    }
    ~TempFolder()
    {
        std::error_code ignored;
        std::filesystem::remove_all(place_.path(), ignored);
    }
    std::filesystem::path const& path() const { return place_.path(); }
    std::filesystem::path write(std::string const& name, std::string const& bytes) const
    {
        std::filesystem::create_directories((path() / name).parent_path());
        std::ofstream(path() / name, std::ios::binary) << bytes;
        return path() / name;
    }

private:
    TempFile place_;
};

/// A file of the real data set, from the folder that the environment variable TILEMESH_DATA or the build's option of that name gives. If it
/// is missing: an empty path and a message.
inline std::filesystem::path data_file(std::string const& name)
{
    char const* folder = std::getenv("TILEMESH_DATA");
#ifdef TILEMESH_TEST_DATA
    if (folder == nullptr) folder = TILEMESH_TEST_DATA;
#endif
    if (folder != nullptr && *folder != '\0')
        if (auto const path = std::filesystem::path(folder) / name; std::filesystem::exists(path)) return path;
    MESSAGE("skipped: ", name, " is absent (TILEMESH_DATA)");
    return {};
}

/// The text of the `tilemesh::Error` that `call` throws; "" if it throws none. The text must be one line of the form "<problem> (<why>);
/// <what to do>".
template <class Call>
std::string error_of(Call call)
{
    try {
        call();
    } catch (tilemesh::Error const& error) {
        std::string const text = error.what();
        CHECK(text.find('\n') == std::string::npos);
        CHECK(text.find(" (") != std::string::npos);
        CHECK(text.find("); ") != std::string::npos);
        return text;
    }
    return "";
}

inline bool has(std::string const& text, std::string const& part)
{
    bool const found = text.find(part) != std::string::npos;
    if (!found) MESSAGE("\"", text, "\" lacks \"", part, "\"");
    return found;
}

/// A text with another one in place of the first `part`.
inline std::string replaced(std::string text, std::string const& part, std::string const& other)
{
    auto const at = text.find(part);
    REQUIRE(at != text.npos);
    return text.replace(at, part.size(), other);
}

/// Has a map, or what else has notes, a note with this text?
template <class Noted>
bool notes_have(Noted const& noted, std::string const& part)
{
    return std::any_of(noted.notes.begin(), noted.notes.end(), [&](std::string const& note) { return note.find(part) != note.npos; });
}

/// What `load` says of a missing file, a folder, a device and a pipe: only regular files are opened, so that nothing blocks.
template <class Load>
void check_that_only_files_are_opened(Load const& load, char const* of_folder = "directory")
{
    TempFolder const folder;
    auto const refused = [&](std::filesystem::path const& path, char const* why) { return has(error_of([&] { load(path); }), why); };
    CHECK(refused(folder.path() / "none", "no such file"));
    CHECK(refused(folder.path(), of_folder));
    CHECK(refused("/dev/zero", "a pipe or a device"));
    REQUIRE(::mkfifo((folder.path() / "pipe").c_str(), 0600) == 0);
    CHECK(refused(folder.path() / "pipe", "a pipe or a device"));
}

/// Checks a lens number by number.
inline void check_lens(tilemesh::splat::Camera const& c, std::uint32_t width, std::uint32_t height, float fx, float fy, float cx, float cy,
                       float near = 0.2f)
{
    CHECK(c.width == width);
    CHECK(c.height == height);
    CHECK(c.fx == fx);
    CHECK(c.fy == fy);
    CHECK(c.cx == cx);
    CHECK(c.cy == cy);
    CHECK(c.near_depth == near);
}

/// R (p - c) in double precision.
inline glm::dvec3 to_view(tilemesh::splat::Camera const& camera, glm::dvec3 p)
{
    glm::dvec3 view{0.0};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            view[row] += static_cast<double>(camera.rotation[row][column]) * (p[column] - static_cast<double>(camera.position[column]));
    return view;
}

/// The pixel coordinates of a world point in front of the camera.
inline glm::dvec2 to_pixel(tilemesh::splat::Camera const& camera, glm::dvec3 p)
{
    auto const view = to_view(camera, p);
    return {static_cast<double>(camera.fx) * view.x / view.z + static_cast<double>(camera.cx),
            static_cast<double>(camera.fy) * view.y / view.z + static_cast<double>(camera.cy)};
}

} // namespace scene_test
