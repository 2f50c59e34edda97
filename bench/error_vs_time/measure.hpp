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
    bool spoil = false;         ///< one setting's mesh clamps alpha where its references do not
    std::function<void(std::string const&)> progress;
};

/// Every setting in the view 2 degrees after the scene's own, where the first view's records stand; times in rounds, as many settings
/// at once as memory is no matter for, each round in the same order, the default among them twice.
std::vector<Row> measure_view(bench::Scene const& scene, std::vector<Setting> const& settings, MeasureOptions const& options, Noise& noise);

/// Some settings over the views of a motion, the last `frames` of which are measured.
std::vector<Row> measure_sequence(bench::Scene const& scene, std::string const& motion, std::uint32_t frames,
                                  std::filesystem::path const& data, std::vector<Setting> const& settings,
                                  MeasureOptions const& options);

} // namespace error_vs_time
