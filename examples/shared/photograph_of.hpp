#pragma once
#include <filesystem>

namespace shared {

/// The photograph of a camera of this name below a folder: the name itself, the name with another extension of a picture, or one of these
/// without the name's folders. Empty if there is none. Cost: a few system calls.
std::filesystem::path photograph_of(std::filesystem::path const& folder, std::filesystem::path const& name);

} // namespace shared
