#pragma once
#include <common/options.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace paper {

struct Options : bench::Options {
    std::filesystem::path out;       ///< a folder for pictures; empty: none
    std::vector<std::string> tables; ///< empty: all
    std::uint32_t threads = 1;
};

/// Throws tilemesh::Error for an unknown option or an invalid value. `names`: the names of the tables.
Options parse(std::vector<std::string> const& words, std::vector<std::string> const& names);
std::string help(std::vector<std::string> const& names);

} // namespace paper
