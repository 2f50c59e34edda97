#pragma once
#include <cmath>
#include <cstddef>
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
/// The line of a summary that compares a path with the truth, and a note if that is the truth of less than half of the pictures. `scale`: the
/// median depth in world units.
inline std::string error_lines(tilemesh::track::TrajectoryErrors const& e, double scale, std::size_t pictures)
{
    auto const of = std::to_string(e.poses) + " of " + std::to_string(pictures) + " pictures";
    return "ATE " + rounded(e.ate.rmse) + " world units (" + of + "; aligned " + rounded(e.ate_aligned.rmse) + "; " + rounded(e.ate.rmse / scale) +
           " of the median depth), " + rounded(e.rotation_deg.rmse) + " degrees; RPE " + rounded(e.rpe.rmse) + " world units and " +
           rounded(e.rpe_deg.rmse) + " degrees a frame (" + std::to_string(e.poses - 1) + " steps)\n" +
           (2 * e.poses < pictures ? "note: these errors are of " + of + ": the others are lost, or the trajectory has no pose for them\n" : "");
}
/// The members of a summary that compare a path with the truth.
inline void add_errors(tilemesh::report::JsonText& json, tilemesh::track::TrajectoryErrors const& e)
{
    json.member("poses_compared", e.poses);
    json.member("ate_rmse", e.ate.rmse);
    json.member("ate_aligned_rmse", e.ate_aligned.rmse);
    json.member("rpe_rmse", e.rpe.rmse);
    json.member("rpe_deg_rmse", e.rpe_deg.rmse);
    json.member("rotation_rmse_deg", e.rotation_deg.rmse);
}

} // namespace shared
