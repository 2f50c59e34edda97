#pragma once
#include <common/options.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace channel_capacity {

struct Options : bench::Options {
    std::filesystem::path latency;            ///< empty: not written
    std::filesystem::path plots;              ///< a folder; empty: none
    std::vector<std::string> scenes, motions; ///< empty: all
    std::uint32_t threads = 1;                ///< number of motions measured at a time
};

/// Throws tilemesh::Error for an unknown option or an invalid value.
Options parse(std::vector<std::string> const& words);
std::string help();

} // namespace channel_capacity
