#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <tilemesh/model/cost_model.hpp>
#include <vector>

namespace paper {

/// The stages of the prototype as in the paper's table. Each is a step of the program.
enum class Stage : std::uint32_t { route, projection, sort, blend };
inline constexpr std::uint32_t stages_timed = 4;
constexpr std::uint32_t index(Stage s) noexcept
{
    return static_cast<std::uint32_t>(s);
}

/// Minimum, mean and maximum over the tiles, averaged over frames.
struct OverTiles {
    double least = 0, mean = 0, most = 0;
};

/// The results of a run of the prototype, with its modelled cost.
struct PrototypeRun {
    std::uint32_t frames = 0, drawn = 0;              ///< number of frames, and of those that sorted and blended
    std::array<OverTiles, stages_timed> count{};      ///< arrivals, records, comparisons, pairs
    std::array<double, stages_timed> slots{};         ///< slots that each tile looked at: of channels, of storage
    std::array<OverTiles, 2> waiting{};               ///< records at which insertions looked: Route, Projection
    /// Of every tile in every frame: arrivals and waiting records of Route, records and waiting records of Projection.
    std::array<std::vector<float>, 2> counted_each{}, waiting_each{};
    std::uint32_t tiles = 0;
    std::array<OverTiles, stages_timed> milliseconds{};
    double exchange_ms = 0;
    std::uint64_t lost = 0;                           ///< records and copies that found no storage slot, counted once per frame and tile
    std::uint64_t refused = 0;                        ///< sends into a full channel
};

struct PrototypePlan {
    std::uint32_t frames = 720, draw_every = 20, threads = 2;
};

/// Runs the prototype along the authors' orbit of one of their maps. Records start in file order; the orbit repeats as often as needed.
PrototypeRun run_prototype(std::string const& scene, std::filesystem::path const& data, PrototypePlan, tilemesh::CostModel const&);

} // namespace paper
