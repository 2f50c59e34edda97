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
    std::uint32_t threads = 1;  ///< that measure errors, a setting each; times are always of one thread alone
    std::uint32_t rounds = 15;
    std::filesystem::path pfm;  ///< where the pictures of three settings go; empty: nowhere
    bool spoil = false;         ///< but for the default's, meshes clamp alpha where their references do not
    std::function<void(std::string const&)> progress;
};

/// Every setting in the view 2 degrees after the scene's own, on the way to and fro between the two; times in rounds of some settings in
/// turn, the default twice among them, each round in another order.
std::vector<Row> measure_view(bench::Scene const& scene, std::vector<Setting> const& settings, MeasureOptions const& options, Noise& noise);

/// Some settings over the views of a motion, the last `frames` of which are measured.
std::vector<Row> measure_sequence(bench::Scene const& scene, std::string const& motion, std::uint32_t frames,
                                  std::filesystem::path const& data, std::vector<Setting> const& settings,
                                  MeasureOptions const& options);

} // namespace error_vs_time
