#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/model/bottleneck.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/cost_table.hpp>
#include <tilemesh/model/energy.hpp>
#include <tilemesh/model/step_costs.hpp>
#include <tilemesh/model/trace_diagrams.hpp>
#include <tilemesh/model/trace_maps.hpp>
#include <tilemesh/report/html.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/number_text.hpp>
#include <utility>
#include <vector>

/// The parts of a page about a run, from a trace of any program. trace_page.hpp makes the page.
namespace tilemesh { inline namespace v0_2 {

/// The parts of a page besides the trace and the cost model. Every part is optional.
struct TracePage {
    std::string title = "A run";
    std::vector<std::pair<std::string, std::string>> facts{}; ///< pairs of a name and a text, one line each
    std::vector<machine::Region> ledger{};                    ///< the ledger of a tile's SRAM, from Layout::ledger()
    std::vector<TileMap> maps{};                              ///< shown before the maps that every trace has
    EnergyModel const* energy = nullptr;                      ///< if given, the page also shows the run's energy
    /// Encodes a picture as a PNG file. Without it the pictures in the page are BMP files, which are larger.
    std::function<std::string(report::Image const&)> png{};
    std::uint64_t most_tile_lines = 200'000;       ///< a longer table by tile is left out; a line has about 50 bytes
    std::size_t most_timeline_bytes = 20'000'000;  ///< the timeline shows as many of the busiest tiles as fit
    std::string run = "run";                       ///< the name of the run in the first sentence
    /// The program's reason for the compute time of the slowest tile, for the first sentence: "it holds 1,198 copies". Empty: no reason.
    std::function<std::string(Bottleneck const&)> because{};
    report::Image const* picture = nullptr;        ///< the result of the run; it is beside the maps, which line up with it
    std::array<std::uint32_t, 2> tile_px = {1, 1}; ///< width and height of a tile in the picture: the shape of tiles in maps; above 0
    std::uint64_t sram_bytes = 0;                  ///< of a tile: the ledger says how full it is; 0: not said
};

/// The contents of a page about a run: sentences, diagrams as SVG, tables as rows of text, pictures. Cost: about 100 KB plus the pictures.
struct TraceSection {
    std::string lead;  ///< the sentence that names the bottleneck
    std::string notes; ///< notes about the numbers for the reader; may be empty
    std::string rests_on; ///< the sentence that names the weakest prices behind the time (confidence_text)
    std::vector<std::pair<std::string, std::string>> figures;
    report::HtmlFrame frame;
    std::vector<report::HtmlCard> cards; ///< the picture and the maps
    std::vector<std::string> flat_maps; ///< one sentence for each map with one value on all tiles, which is most often 0
    std::string steps_svg, supersteps_svg; ///< empty without a cost model
    /// The tables after the first may be empty. `ideal` is empty if no message settled: without settled bytes every bound would be 0.
    std::vector<std::vector<std::string>> steps, ideal, energy_kinds, energy_steps;
    bool modelled = false;
    TILEMESH_HOST std::size_t bytes() const noexcept;
};

/// The contents of a page about this run, with the maps of `page` before the maps of the trace. `maps` gets all maps. `cost` is the result
/// of model_cost for this trace. `energy` is the result of energy_of with `page.energy`, or null. Throws `Error` in the cases in which
/// step_costs and any_to_any throw it, and for a map without a number for every tile.
TILEMESH_HOST TraceSection trace_section(Trace const& trace, CostModel const& model, RunCost const& cost, Grid grid, TracePage const& page,
                                         std::vector<TileMap> const& maps, Energy const* energy = nullptr);

/// The contents of a page about this run without a cost model: tile runs and sent messages, but no times.
TILEMESH_HOST TraceSection trace_section(Trace const& trace, Grid grid, TracePage const& page, std::vector<TileMap> const& maps);

/// The text of a page about its times.
inline constexpr char const* modelled_text =
    "Cycles and milliseconds are modelled from what the tiles did and from the numbers of the cost model. A pass takes as long as its slowest "
    "tile computes; then come the exchange, a sync, and a vote where the step runs until all tiles are quiet. No time that was measured on "
    "the host is in them.";

/// Adds the run to a page: the sentence that names its bottleneck, a few numbers, the picture and the maps, cycles by step and over time,
/// the slowest tile of each step, ideal routing, energy. `facts` are below the table by step, one per line.
TILEMESH_HOST void add_section(report::HtmlReport& html, TraceSection const& section,
                               std::vector<std::pair<std::string, std::string>> const& facts = {});

/// Adds the ledger of a tile's SRAM, folded away. `sram_bytes`: the SRAM of a tile, for the last line; 0: the line does not name it.
TILEMESH_HOST void add_ledger(report::HtmlReport& html, std::span<machine::Region const> ledger, std::uint64_t sram_bytes = 0);
/// Adds the numbers of a cost model, each with its kind and its source, folded away.
TILEMESH_HOST void add_parameters(report::HtmlReport& html, CostModel const& model);
/// Adds the operations that a trace counted to the names that are there, each once.
TILEMESH_HOST void add_counted(std::vector<std::string>& counted, Trace const& trace);
/// The same without the prices of operations that are not in `counted`.
TILEMESH_HOST void add_parameters(report::HtmlReport& html, CostModel const& model, std::vector<std::string> const& counted);
/// Adds the numbers of an energy model, each with its source, folded away.
TILEMESH_HOST void add_parameters(report::HtmlReport& html, EnergyModel const& model);

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/trace_section_code.hpp>
#endif
