#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <tilemesh/number_text.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// What float32 cuts off the means of a map, mean - float32(mean), one for each Gaussian; empty if the file's numbers are float32 themselves.
using CutOff = std::vector<std::array<float, 3>>;

/// The origin that a map with far means should have: the medians of the means along each axis, as whole numbers. Nothing for any other map.
///
/// Means are far if a median is at least 10,000 away from 0, and at least 1,000 times the widest spread, which is the distance of the 5th and
/// the 95th percentile along an axis. At a thousand times the spread, a step of float32 is a 16,000th of the map, the pixel of a picture that
/// shows all of it; maps below 10,000 have steps of a thousandth at most, and stay bit for bit what they are in the file.
inline std::optional<std::array<double, 3>> far_origin(Map const& map)
{
    constexpr float least_away = 10'000.0f;
    constexpr double least_share = 1'000.0;
    std::size_t const n = map.gaussians.size();
    // A median is far only if half of the means are.
    auto const is_far = [](splat::Gaussian const& g) {
        return std::any_of(g.mean_world, g.mean_world + 3, [](float m) { return std::fabs(m) >= least_away; });
    };
    if (n == 0 || 2 * static_cast<std::size_t>(std::count_if(map.gaussians.begin(), map.gaussians.end(), is_far)) < n) return {};
    std::array<double, 3> origin{};
    double spread = 0.0, away = 0.0;
    std::vector<float> values(n);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        std::transform(map.gaussians.begin(), map.gaussians.end(), values.begin(), [&](splat::Gaussian const& g) { return g.mean_world[axis]; });
        std::sort(values.begin(), values.end());
        double const median = static_cast<double>(values[n / 2]);
        spread = std::fmax(spread, static_cast<double>(values[n - 1 - n / 20]) - static_cast<double>(values[n / 20]));
        away = std::fmax(away, std::fabs(median));
        origin[axis] = std::round(median);
    }
    if (!(away >= static_cast<double>(least_away) && away >= least_share * spread)) return {};
    return origin;
}

/// Moves far means, or notes them. Cost: one comparison a mean; for far means, a sort of three numbers a Gaussian.
inline void settle_far_means(Map& map, FarMeans far, CutOff const& cut_off = {})
{
    auto const origin = far_origin(map);
    if (!origin) return;
    std::string where;
    double away = 0.0;
    for (double const each : *origin) {
        // A whole number in full: 5000000, not 5e+06. Above 2^53 there are no such places.
        where.append(where.empty() ? "" : ", ").append(std::fabs(each) < 9e15 ? std::to_string(static_cast<std::int64_t>(each)) : number_text(each));
        away = std::fmax(away, std::fabs(each));
    }
    float const there = static_cast<float>(away);
    double const step = static_cast<double>(std::nextafter(there, std::numeric_limits<float>::infinity())) - static_cast<double>(there);
    std::string const steps = "float32 has steps of " + number_text(step) + " there";
    if (far == FarMeans::kept) {
        map.notes.push_back("the means are around " + where + ", far from 0 against their spread, and " + steps +
                            ": read the map with its origin moved, or export it with an origin subtracted");
        return;
    }
    map.origin = *origin;
    for (std::size_t i = 0; i < map.gaussians.size(); ++i)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            float& mean = map.gaussians[i].mean_world[axis];
            double const rest = cut_off.empty() ? 0.0 : static_cast<double>(cut_off[i][axis]);
            mean = static_cast<float>(static_cast<double>(mean) - (*origin)[axis] + rest);
        }
    map.notes.push_back(
        "the means are far from 0 against their spread: the origin " + where + " is subtracted from the map, and from cameras and trajectories" +
        (cut_off.empty()
             ? "; the file has float32, and " + steps + ": export the map as PLY with double columns x, y, z, or with an origin subtracted"
             : ""));
}

}}} // namespace tilemesh::v0_2::scene::detail
