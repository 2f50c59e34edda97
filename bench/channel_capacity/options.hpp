#pragma once
#include <algorithm>
#include <common/options.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

namespace channel_capacity {

struct Options : bench::Options {
    std::filesystem::path latency;            ///< empty: not written
    std::filesystem::path plots;              ///< a folder; empty: none
    std::vector<std::string> scenes, motions; ///< empty: all
    std::uint32_t threads = std::max(1u, std::thread::hardware_concurrency()); ///< number of motions measured at a time
};

/// The options by their names. `own` must outlive them.
shared::OptionTable table_of(Options& own);

} // namespace channel_capacity
