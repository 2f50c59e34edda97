#pragma once
#include <common/options.hpp>
#include <cstdint>
#include <string>
#include <vector>

namespace track_bench {

inline constexpr char const* scene_names[] = {"built_in", "sloth", "salad"};
inline constexpr char const* table_names[] = {"basin", "subsets", "spoilt", "times", "model"};
inline constexpr char const* method_names[] = {"hybrid", "forward", "gradient", "esm"};

struct Options : bench::Options {
    std::vector<std::string> scenes, tables, methods; ///< empty: all
    std::uint32_t trials = 20;
    std::uint32_t rounds = 9;

    void finish(shared::OptionTable const& given);
};
/// The options by their names. `own` must outlive them.
shared::OptionTable table_of(Options& own);

} // namespace track_bench
