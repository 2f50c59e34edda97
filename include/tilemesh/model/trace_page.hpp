#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <numeric>
#include <string>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/trace_section.hpp>
#include <tilemesh/report/heat_image.hpp>
#include <tilemesh/report/html.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/image_file.hpp>
#include <tilemesh/report/string_stream.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// The contents of a trace page besides the trace and the cost model. Every part is optional.
struct TracePage {
    std::string title = "A run";
    std::vector<std::pair<std::string, std::string>> facts{}; ///< lines below the title: a name and a text
    std::vector<Region> ledger{};                             ///< of a tile's SRAM, as Layout::ledger() gives it
    std::vector<TileMap> maps{};                              ///< shown before the maps that every trace has
    EnergyModel const* energy = nullptr;                      ///< if given, the page also shows the run's energy
    /// Encodes a picture as a PNG file: the page shows the maps. Without it they are PPM files beside the page.
    std::function<std::string(report::Image const&)> png{};
    std::uint64_t most_tile_lines = 4'000'000;     ///< a longer table by tile is left out; a line has some 50 bytes
    std::size_t most_timeline_bytes = 20'000'000;  ///< the timeline shows as many of the busiest tiles as fit
};

/// The timeline of write_chrome_trace with as many of the 64 busiest tiles as fit into `most_bytes`; `note` says how many. Empty if even
/// the machine's own track does not fit.
inline std::string timeline_below(std::size_t most_bytes, Trace const& trace, CostModel const& model, Grid grid, std::string& note)
{
    for (std::uint32_t busiest = 64;; busiest /= 2) { // 64: the default of write_chrome_trace
        report::StringStream out;
        write_chrome_trace(out, trace, model, grid, busiest);
        auto text = out.str();
        if (text.size() < most_bytes) {
            note = "timeline of the machine and its " + std::to_string(std::min(busiest, grid.size())) + " busiest tiles";
            return text;
        }
        if (busiest == 0) break;
    }
    note = "no timeline: " + report::thousands(trace.supersteps.size()) + " supersteps take more than " +
           report::thousands(most_bytes) + " bytes";
    return {};
}

/// Writes a run of any program as files into `folder`, and makes the folder if it does not exist. All file names begin with `name`:
///   .html            a page for a browser: cycles by step and over time, ideal routing, energy, maps, the models
///   .tiles.csv       the trace by superstep and tile; .supersteps.csv: by superstep
///   .trace.json      a timeline for ui.perfetto.dev
///   .model.txt       the cost model; .maps.csv: the maps' numbers; .energy.csv: joules of each tile
///   .NAME.ppm        each map, if the page cannot show it
/// Returns the page's path. The same bytes on every run. The cost model must have a source for every number (set_parameter,
/// set_price).
///
/// Throws `Error` for a folder or file that cannot be written, for a map without a number for every tile, and as write_cost_model,
/// model_cost and energy_of do. Cost: the texts in memory, twice.
inline std::filesystem::path write_trace_page(std::filesystem::path const& folder, std::string const& name, Trace const& trace,
                                              CostModel const& model, Grid grid, TracePage const& page = {})
{
    using report::thousands;
    std::error_code refused;
    std::filesystem::create_directories(folder, refused);
    if (refused) throw Error("cannot make the folder " + folder.string() + " (" + refused.message() + "); name another folder");
    for (auto const& map : page.maps)
        if (map.values.size() != grid.size())
            throw Error("map " + map.name + " cannot be shown (it has " + std::to_string(map.values.size()) + " numbers, and the grid " +
                        std::to_string(grid.size()) + " tiles); give it a number for every tile");
    std::vector<std::pair<std::string, std::string>> beside;
    auto const path = [&](std::string const& what) { return folder / (name + what); };
    auto const write = [&](std::string const& what, std::string const& text, std::string const& note) {
        report::write_whole(path(what), text);
        beside.emplace_back(name + what, note);
    };
    auto const produce = [&](std::string const& what, std::string const& note, auto const& into) {
        report::StringStream text;
        into(text);
        write(what, text.str(), note);
    };
    produce(".model.txt", "the cost model", [&](std::ostream& out) { write_cost_model(out, model); });
    auto const cost = model_cost(model, trace, grid);
    Energy energy;
    if (page.energy != nullptr) energy = energy_of(*page.energy, model, trace, grid);

    std::uint64_t lines = 0;
    for (auto const& s : trace.supersteps) lines += s.tiles.size();
    if (lines <= page.most_tile_lines)
        produce(".tiles.csv", "the trace by superstep and tile", [&](std::ostream& out) { write_trace_csv(out, trace, model, grid); });
    else beside.emplace_back(name + ".tiles.csv", "left out: " + thousands(lines) + " lines are more than " + thousands(page.most_tile_lines));
    produce(".supersteps.csv", "the trace by superstep", [&](std::ostream& out) { write_step_csv(out, trace, model, grid); });
    std::string note;
    auto const timeline = timeline_below(page.most_timeline_bytes, trace, model, grid, note);
    if (!timeline.empty()) write(".trace.json", timeline, note + ", for ui.perfetto.dev");
    else beside.emplace_back(name + ".trace.json", note);

    auto section = trace_section(trace, model, cost, grid, page.energy, page.energy != nullptr ? &energy : nullptr);
    auto maps = page.maps;
    for (auto& map : trace_maps(trace, model, grid)) maps.push_back(std::move(map));
    write(".maps.csv", maps_csv(maps, grid), "the numbers of all maps");
    double busy = 0;
    auto const add_map = [&](TileMap const& map, std::string (*shown)(double)) {
        auto const image = map_image(map, grid);
        if (page.png) return section.maps.emplace_back(map_caption(map, shown), page.png(image)), void();
        report::write_ppm(path("." + map.name + ".ppm"), image);
        beside.emplace_back(name + "." + map.name + ".ppm", map_caption(map, shown) + " Dark blue is 0, yellow the most.");
    };
    for (auto const& map : maps) {
        add_map(map, report::short_number);
        if (map.name == "busy_cycles") busy = std::accumulate(map.values.begin(), map.values.end(), 0.0);
    }
    if (page.energy != nullptr) {
        write(".energy.csv", energy_csv(energy, grid), "joules of each tile");
        add_map({"energy", "Energy", "joules of all that is counted", true, energy.joules_of_tile}, report::joules_text);
    }

    report::HtmlReport html(page.title);
    auto facts = page.facts;
    facts.insert(facts.begin(), {{"modelled", milliseconds_text(model, cost.cycles) + " ms, " + thousands(cost.cycles) + " cycles, " +
                                                  thousands(cost.supersteps.size()) + " supersteps"},
                                 {"tiles", std::to_string(grid.width) + " x " + std::to_string(grid.height) + ", busy " +
                                               report::share_text(busy, static_cast<double>(cost.cycles) * grid.size()) + " of the time"},
                                 {"cost model", model.name + ", " + thousands(model.clock_khz) + " kHz"}});
    if (page.energy != nullptr) facts.emplace_back("energy", report::joules_text(energy.joules) + " J by " + page.energy->name);
    html.key_values(facts);
    html.paragraph("Cycles and milliseconds are modelled, from what the tiles did and the numbers of the cost model: a superstep is the "
                   "slowest tile's compute, then the exchange, a sync, and a vote where the step runs until quiet. Nothing that was "
                   "measured on the host is in them.");
    html.section("Where the cycles go");
    add_section(html, section, page.png ? page.png(report::heat_legend(256, 12)) : std::string());
    if (!page.ledger.empty()) {
        html.section("Ledger of a tile's SRAM");
        std::vector<std::vector<std::string>> rows;
        std::uint64_t sum = 0;
        for (auto const& region : page.ledger) {
            rows.push_back({std::string(region.name.text, region.name.size), region.what, thousands(region.bytes),
                            region.budgeted ? "" : "outside the budget"});
            sum += region.budgeted ? region.bytes : 0;
        }
        rows.push_back({"in the budget", "", thousands(sum), ""});
        html.table({"region", "what", "bytes", ""}, rows);
    }
    add_parameters(html, model);
    if (page.energy != nullptr) add_parameters(html, *page.energy);
    html.section("Beside this page").key_values(beside);
    report::write_whole(path(".html"), html.str());
    return path(".html");
}

}} // namespace tilemesh
