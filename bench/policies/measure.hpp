#pragma once
#include <common/options.hpp>
#include <common/scenes.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace policies {

struct Options : bench::Options {
    std::filesystem::path write;   ///< the folder of README.md; empty: not written
    std::vector<std::string> maps; ///< empty: all
    std::uint32_t threads = 1;     ///< of every machine
};

/// One frame under one policy.
struct Row {
    std::string map, view, policy;
    bool lossy = false;           ///< by its policy, or because records are missing
    double psnr_db = 0;           ///< against the exact picture; infinite for equal bits
    std::uint64_t missing = 0;    ///< records and copies that the picture lacks; a missing record counts once
    std::uint64_t exchanges = 0;
    double modelled_ms = 0;
    double slowest_over_mean = 0; ///< modelled compute cycles of the slowest tile over the mean of all tiles
    std::uint64_t sram_bytes = 0; ///< of a tile
    std::uint32_t storage = 0;    ///< records that a tile stores, or splats that it holds
    std::uint64_t exchanged_bytes = 0;
    double host_ms = 0;
};

/// Blending as matrix products: how much less time a frame of homes could take, and the error of half precision.
struct Products {
    std::string map;
    double blend_share = 0;     ///< of the modelled time of a frame of homes
    double bound = 0;           ///< times faster if blending took no time
    double bound_of_colours = 0;///< if only the 4 multiply-adds of a pair's colour and weight took time, at 64 a cycle
    double colours_db = 0;      ///< PSNR with colours rounded to half
    double both_db = 0;         ///< PSNR with colours and weights rounded to half, summed as floats
    double both_rmse = 0;
};

/// Measures all policies in all views of a scene. Adds a sentence to `broken` for each check that fails.
void measure(bench::Scene const& scene, Options const& options, std::vector<Row>& rows, std::vector<Products>& products,
             std::vector<std::string>& broken);

} // namespace policies
