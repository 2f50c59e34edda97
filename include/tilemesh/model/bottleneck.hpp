#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/step_costs.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// The phase of a program's step that takes most of a run's modelled time.
struct Bottleneck {
    enum class Phase : std::uint32_t { compute, exchange, sync }; ///< the vote counts as sync
    Phase phase = Phase::compute;
    std::uint32_t step = 0;
    std::uint64_t cycles = 0;      ///< cycles of that phase in all passes of that step
    std::uint64_t passes = 0;      ///< passes of that step

    // For compute only. A pass takes as long as its slowest tile.
    std::uint32_t tile = 0;        ///< of all tiles, its passes as the slowest tile take the most cycles; of equal tiles the lowest index
    std::uint64_t tile_passes = 0, tile_cycles = 0; ///< passes in which it is the slowest, and their cycles
    double mean_cycles = 0;        ///< cycles that a tile of the grid computes in the step, on average
    std::string operation;         ///< operation that takes the most of `tile_cycles`; empty: starting the kernel takes more
    double operation_cycles = 0;   ///< cycles of that operation, or of starting the kernel
};

/// The tile of a step that the other tiles wait for longest, and what its kernel counted. A pass takes as long as its slowest tile.
struct SlowestTile {
    struct Counted {
        std::string operation;
        std::uint64_t count = 0;
        double cycles = 0;
    };
    std::uint32_t tile = 0;               ///< its passes as the slowest tile take the most cycles; of equal tiles the lowest index
    std::uint64_t passes = 0, cycles = 0; ///< passes in which it is the slowest, and their compute
    std::vector<Counted> operations;      ///< that occur in these passes, those with the most cycles first
};

/// The slowest tile of a step; empty if no compute of the step was modelled. `cost` must be the result of model_cost for this trace. Cost:
/// linear in the trace, and 8 bytes a tile.
TILEMESH_HOST std::optional<SlowestTile> slowest_tile(CostModel const& model, Trace const& trace, RunCost const& cost, Grid grid, std::uint32_t step);

/// The bottleneck of a run. Of equal candidates it is compute before exchange before sync, then the earlier step. Empty if no cycle was
/// modelled. `cost` must be the result of model_cost for this trace; throws `Error` as step_costs and model_cost do. Cost: linear in the
/// trace, and 8 bytes a tile.
TILEMESH_HOST std::optional<Bottleneck> find_bottleneck(CostModel const& model, Trace const& trace, RunCost const& cost, Grid grid);

namespace model_detail {
/// A tile as text: "(23, 18)".
TILEMESH_HOST std::string tile_text(Grid grid, std::uint32_t tile);
TILEMESH_HOST std::string passes_text(std::uint64_t passes);
TILEMESH_HOST std::string exchanges_text(std::uint64_t exchanges);
} // namespace model_detail

/// One sentence that names the bottleneck of a run and gives its numbers. `run`: the word for the run ("run", "frame"). `because`: if not
/// empty, the program's own reason for the time that the slowest tile computes ("it holds 1,198 copies").
TILEMESH_HOST std::string bottleneck_text(std::optional<Bottleneck> const& bottleneck, CostModel const& model, Trace const& trace,
                                          RunCost const& cost, Grid grid, std::string_view run = "run", std::string_view because = {});

/// The sentence for a run without a cost model: its passes, its exchanges, and the tile that sent the most bytes, or ran most often if
/// nothing was sent. Throws `Error` for a trace of another grid. Cost: linear in the trace, and 8 bytes a tile.
TILEMESH_HOST std::string load_text(Trace const& trace, Grid grid, std::string_view run = "run");

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/bottleneck_code.hpp>
#endif
