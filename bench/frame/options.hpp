#pragma once
#include <common/options.hpp>
#include <cstdint>
#include <string>
#include <tilemesh/splat/setup_types.hpp>
#include <vector>

namespace frame {

/// The scenes that are measured by default: two SLAM maps, an object capture, the built-in map, and that map with a million Gaussians.
inline constexpr char const* scene_names[] = {"sloth", "salad", "playbot_250k", "built_in", "built_in_1m"};

struct Options : bench::Options {
    std::vector<std::string> scenes, motions; ///< empty: all; no scene if there are maps
    std::vector<std::filesystem::path> maps;  ///< files, besides the scenes
    std::vector<std::uint32_t> threads;       ///< measured side by side
    std::uint32_t rounds = 0;                 ///< measured rounds per motion; 0: as --quick and the size of the map say
    tilemesh::splat::Arithmetic arithmetic = tilemesh::splat::Lossless::arithmetic;
    bool homes = false;       ///< also the program of homes
    bool wide = false;        ///< also on a grid of which the frame occupies a small part
    bool arithmetics = false; ///< only time and error of the ways to blend

    void finish(shared::OptionTable const& given);
};

/// The options by their names. `own` must outlive them.
shared::OptionTable table_of(Options& own);

constexpr char const* to_string(tilemesh::splat::Arithmetic a) noexcept
{
    return a == tilemesh::splat::Arithmetic::precise ? "precise" : "fast";
}

} // namespace frame
