#pragma once
#include <common/options.hpp>
#include <cstdint>
#include <string>
#include <vector>

namespace track_bench {

inline char const* const scene_names[] = {"built_in", "sloth", "salad"};
inline char const* const table_names[] = {"basin", "subsets", "spoilt", "times", "model"};
inline char const* const method_names[] = {"hybrid", "forward", "gradient", "esm"};

struct Options : bench::Options {
    std::vector<std::string> scenes, tables, methods; ///< empty: all
    std::uint32_t trials = 20;
    std::uint32_t rounds = 9;
};
Options parse(std::vector<std::string> const& words);
std::string help();

} // namespace track_bench
