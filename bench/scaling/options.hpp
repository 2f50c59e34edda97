#pragma once
#include <common/options.hpp>
#include <cstdint>
#include <string>
#include <vector>

namespace scaling {

inline char const* const axis_names[] = {"gaussians", "pixels", "tiles", "idle_tiles"};

struct Options : bench::Options {
    std::vector<std::string> axes; ///< all where none is named
    std::string motion = "orbit0.5";
    std::vector<std::uint32_t> threads; ///< those measured beside each other
};

/// Throws tilemesh::Error for what is no option, or no value of one.
Options parse(std::vector<std::string> const& words);
std::string help();

} // namespace scaling
