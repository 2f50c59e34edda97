#pragma once
#include <common/options.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace any_map {

inline constexpr char const* map_names[] = {"sloth", "salad", "playbot_250k", "built_in", "built_in_1m", "built_in_5m"};

struct Options : bench::Options {
    std::filesystem::path write;   ///< the folder of README.md and its plot; empty: not written
    std::filesystem::path picture; ///< a PNG file; not empty: this picture is all that the bench makes
    std::vector<std::string> maps; ///< empty: all
    std::uint32_t threads = 1;     ///< of every machine
};

/// The options by their names. `own` must outlive them.
shared::OptionTable table_of(Options& own);

} // namespace any_map
