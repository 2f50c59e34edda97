#pragma once
#include <common/options.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <tilemesh/model/hosts.hpp>
#include <vector>

namespace scaling {

inline constexpr char const* axis_names[] = {"gaussians", "pixels", "tiles", "idle_tiles"};

struct Options : bench::Options {
    std::vector<std::string> axes; ///< empty: all
    std::string motion = "orbit0.5";
    std::vector<std::uint32_t> threads; ///< measured side by side
    bool ranks = false, frames = false, predict = false, chips = false;
    std::optional<tilemesh::HostNetwork> network; ///< one more network for the prediction

    void finish(shared::OptionTable const& given);
};

/// The options by their names. `own` must outlive them.
shared::OptionTable table_of(Options& own);

} // namespace scaling
