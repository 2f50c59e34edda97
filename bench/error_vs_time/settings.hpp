#pragma once
#include "rows.hpp"
#include <tilemesh/report/reference_double.hpp>
#include <vector>

namespace error_vs_time {

/// "No alpha cut" leaves out only terms below this alpha, here and in the reference without cut-offs: a box of 7.4 standard deviations.
inline constexpr float no_alpha_cut = 1e-12f;

/// All settings of a single view; `default` first.
std::vector<Setting> settings();
/// The settings that are worth measuring over a sequence of frames.
std::vector<Setting> settings_of_sequences();

/// The cut-offs of a setting, for the reference in double.
report::CutOffs cut_offs_of(Setting const&);

} // namespace error_vs_time
