#pragma once
#include <common/options.hpp>
#include <cstdint>
#include <string>
#include <tilemesh/splat/setup.hpp>
#include <vector>

namespace frame {

struct Options : bench::Options {
    std::vector<std::string> scenes, motions; ///< all where none is named
    std::vector<std::uint32_t> threads;       ///< those measured beside each other
    std::uint32_t rounds = 0;                 ///< measured ones of each motion; 0: as --quick says
    tilemesh::splat::Arithmetic arithmetic = tilemesh::splat::Lossless::arithmetic;
    bool wide = false;        ///< also on a grid of which the frame occupies a small part
    bool arithmetics = false; ///< time and error of ways to blend instead
};

/// Throws tilemesh::Error for what is no option, or no value of one.
Options parse(std::vector<std::string> const& words);
std::string help();

inline char const* to_string(tilemesh::splat::Arithmetic a) noexcept
{
    return a == tilemesh::splat::Arithmetic::precise ? "precise" : "fast";
}

} // namespace frame
