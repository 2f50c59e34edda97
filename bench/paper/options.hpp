#pragma once
#include <common/options.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace paper {

struct Options : bench::Options {
    std::filesystem::path out;       ///< a folder for pictures; empty: none
    std::vector<std::string> tables; ///< all where none is named
    std::uint32_t threads = 1;
};

/// Throws tilemesh::Error for what is no option, or no value of one. `names`: of the tables.
Options parse(std::vector<std::string> const& words, std::vector<std::string> const& names);
std::string help(std::vector<std::string> const& names);

} // namespace paper
