#pragma once
#include <algorithm>
#include <common/options.hpp>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <thread>
#include <vector>

namespace paper {

struct Options : bench::Options {
    std::filesystem::path out;       ///< a folder for pictures; empty: none
    std::vector<std::string> tables; ///< empty: all
    std::uint32_t threads = std::max(1u, std::thread::hardware_concurrency());
};

/// The options by their names. `own` and the words, one for each table, must outlive them.
shared::OptionTable table_of(Options& own, std::span<shared::Word const> words);

} // namespace paper
