#pragma once
#include "rows.hpp"
#include <common/scenes.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace error_vs_time {

struct MeasureOptions {
    std::uint32_t threads = 1;  ///< number of threads that measure errors, one setting each; times are always of one thread alone
    std::uint32_t rounds = 15;
    std::filesystem::path pfm;  ///< folder for the pictures of three settings; empty: none
    bool spoil = false;         ///< meshes clamp alpha where their references do not, except the default's
    std::function<void(std::string const&)> progress;
};

/// Measures every setting in the view 2 degrees after the scene's own, on the way between the two views. Times are taken in rounds: some
/// settings in turn, the default twice among them, each round in another order.
std::vector<Row> measure_view(bench::Scene const& scene, std::vector<Setting> const& settings, MeasureOptions const& options, Noise& noise);

/// Measures some settings over the views of a motion, of which the last `frames` count.
std::vector<Row> measure_sequence(bench::Scene const& scene, std::string const& motion, std::uint32_t frames,
                                  std::filesystem::path const& data, std::vector<Setting> const& settings,
                                  MeasureOptions const& options);

} // namespace error_vs_time
