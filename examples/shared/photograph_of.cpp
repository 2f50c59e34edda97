#include "photograph_of.hpp"
#include <array>
#include <system_error>

namespace shared {

namespace fs = std::filesystem;

fs::path photograph_of(fs::path const& folder, fs::path const& name)
{
    static constexpr std::array<char const*, 6> extensions{".png", ".jpg", ".jpeg", ".PNG", ".JPG", ".JPEG"};
    std::error_code ignored;
    auto const is_file = [&](fs::path const& path) { return fs::exists(path, ignored) && !fs::is_directory(path, ignored); };
    auto const beside = name.relative_path().lexically_normal(); // "./train/r_0" is "train/r_0"
    for (auto const& each : {beside, beside.filename()}) {
        if (each.empty() || *each.begin() == "..") continue;
        if (auto const path = folder / each; is_file(path)) return path;
        for (auto const* extension : extensions)
            if (auto const path = folder / fs::path(each).concat(extension); is_file(path)) return path;
        for (auto const* extension : extensions)
            if (auto const path = folder / fs::path(each).replace_extension(extension); is_file(path)) return path;
    }
    return {};
}

} // namespace shared
