#pragma once
#include <algorithm>
#include <common/options.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <thread>
#include <tilemesh/scene/pose.hpp>
#include <vector>

namespace error_vs_time {

struct Options : bench::Options {
    std::vector<std::string> scenes;
    std::vector<std::string> settings;      ///< measured in addition to the default; empty: all
    tilemesh::scene::Size size{0, 0};       ///< 0: the size of the quick or the full run
    std::uint32_t threads = std::max(1u, std::thread::hardware_concurrency());
    std::uint32_t rounds = 0; ///< 0: as in the quick or the full run
    std::filesystem::path out, pfm;
    bool single_views = false;
    bool list = false;                      ///< print the names of the settings, and measure nothing

    void finish(shared::OptionTable const& given);
};

/// The options by their names. `own` must outlive them.
shared::OptionTable table_of(Options& own);

} // namespace error_vs_time
