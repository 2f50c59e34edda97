#pragma once
#include "../standard.hpp"

namespace tests {

/// A new folder; it is gone with all that is in it at the end of its scope.
struct Folder {
    std::filesystem::path path;
    Folder()
    {
        std::random_device random;
        do path = std::filesystem::temp_directory_path() / ("tilemesh_" + std::to_string(random()));
        while (!std::filesystem::create_directory(path));
    }
    ~Folder()
    {
        std::error_code ignored;
        std::filesystem::remove_all(path, ignored);
    }
    Folder(Folder const&) = delete;
    Folder& operator=(Folder const&) = delete;

    /// The names of what is in it, in order.
    std::vector<std::string> names() const
    {
        std::vector<std::string> out;
        for (auto const& file : std::filesystem::directory_iterator(path)) out.push_back(file.path().filename().string());
        std::sort(out.begin(), out.end());
        return out;
    }
    std::size_t files() const { return names().size(); }
};

inline std::string contents(std::filesystem::path const& path)
{
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}
inline void put(std::filesystem::path const& path, std::string const& bytes)
{
    std::ofstream(path, std::ios::binary) << bytes;
}

/// An open stream that closes itself.
struct Stream {
    std::FILE* file;
    ~Stream() { std::fclose(file); }
};

/// How often a text has a part.
inline std::size_t count(std::string const& text, std::string const& part)
{
    std::size_t n = 0;
    for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++n;
    return n;
}

} // namespace tests
