#pragma once
#include <cstdlib>
#include <string_view>

namespace tests {
/// TILEMESH_FAST=1 makes heavy cases smaller, for sanitizer runs.
inline bool fast()
{
    char const* const value = std::getenv("TILEMESH_FAST");
    return value != nullptr && std::string_view(value) == "1";
}
} // namespace tests
