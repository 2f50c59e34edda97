#pragma once
#include <array>
#include <optional>
#include <tilemesh/config.hpp>
#include <tilemesh/scene/map.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// What float32 cuts off the means of a map, mean - float32(mean), one for each Gaussian; empty if the file's numbers are float32 themselves.
using CutOff = std::vector<std::array<float, 3>>;

/// The origin that a map with far means should have: the medians of the means along each axis, as whole numbers. Nothing for any other map.
///
/// Means are far if a median is at least 10,000 away from 0, and at least 1,000 times the widest spread, which is the distance of the 5th and
/// the 95th percentile along an axis. At a thousand times the spread, a step of float32 is a 16,000th of the map, the pixel of a picture that
/// shows all of it; maps below 10,000 have steps of a thousandth at most, and stay bit for bit what they are in the file.
TILEMESH_HOST std::optional<std::array<double, 3>> far_origin(Map const& map);

/// Moves far means, or notes them. Cost: one comparison a mean; for far means, a sort of three numbers a Gaussian.
TILEMESH_HOST void settle_far_means(Map& map, FarMeans far, CutOff const& cut_off = {});

}}} // namespace tilemesh::scene::detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/far_means_code.hpp>
#endif
