#pragma once
#include <common/options.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <tilemesh/scene/pose.hpp>
#include <vector>

namespace error_vs_time {

struct Options : bench::Options {
    std::vector<std::string> scenes;
    std::vector<std::string> settings;      ///< measured in addition to the default; empty: all
    tilemesh::scene::Size size{0, 0};       ///< 0: the size of the quick or the full run
    std::uint32_t threads = 1, rounds = 0;  ///< rounds 0: as in the quick or the full run
    std::filesystem::path out, pfm;
    bool sequences = true;
    bool list = false;                      ///< print the names of the settings, and measure nothing
};

Options parse(std::vector<std::string> const& words);
std::string help();

} // namespace error_vs_time
