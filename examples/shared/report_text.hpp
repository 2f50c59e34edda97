#pragma once
#include <cmath>
#include <string>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/json_text.hpp>
#include <tilemesh/track/trajectory_error.hpp>

namespace shared {

/// A number for readers: three significant digits. No printed measure is known better, and each has a unit behind it.
inline std::string rounded(double value)
{
    if (!std::isfinite(value)) return "unknown";
    return value >= 999.5 && value < 1e15 ? tilemesh::decimals(value, 0) : tilemesh::significant(value, 3); // not 1.02e+03
}
/// The members of a summary that compare a path with the truth.
inline void add_errors(tilemesh::report::JsonText& json, tilemesh::track::TrajectoryErrors const& e)
{
    json.member("ate_rmse", e.ate.rmse);
    json.member("ate_aligned_rmse", e.ate_aligned.rmse);
    json.member("rpe_rmse", e.rpe.rmse);
    json.member("rpe_deg_rmse", e.rpe_deg.rmse);
    json.member("rotation_rmse_deg", e.rotation_deg.rmse);
}

} // namespace shared
