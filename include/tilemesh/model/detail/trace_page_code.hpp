#pragma once
#include <algorithm>
#include <cstdint>
#include <ostream>
#include <system_error>
#include <tilemesh/model/trace_page.hpp>
#include <tilemesh/report/html.hpp>
#include <tilemesh/report/string_stream.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

TILEMESH_HOST std::string timeline_below(std::size_t most_bytes, Trace const& trace, CostModel const& model, Grid grid, std::string& note)
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
    note = "no timeline: " + report::thousands(trace.supersteps.size()) + " passes take more than " + report::thousands(most_bytes) + " bytes";
    return {};
}

namespace model_detail {

/// The page of write_trace_page, and the files beside it.
class TracePageFiles {
public:
    TracePageFiles(std::filesystem::path folder, std::string name, Grid grid, TracePage const& page)
        : folder_(std::move(folder)), name_(std::move(name)), page_(page), html_(page.title)
    {
        std::error_code refused;
        std::filesystem::create_directories(folder_, refused);
        if (refused) throw Error("cannot make the folder " + folder_.string() + " (" + refused.message() + "); name another folder");
        for (auto const& map : page.maps)
            if (map.values.size() != grid.size())
                throw Error("map " + map.name + " cannot be shown (it has " + std::to_string(map.values.size()) + " numbers, and the grid " +
                            std::to_string(grid.size()) + " tiles); give it a number for every tile");
        if (page.tile_px[0] == 0 || page.tile_px[1] == 0)
            throw Error("maps cannot be shown (a tile has no pixels); give tile_px a width and a height");
    }
    report::HtmlReport& html() noexcept { return html_; }
    void write(std::string const& what, std::string const& text, std::string const& note)
    {
        report::write_whole(path(what), text);
        beside_.emplace_back(name_ + what, note);
    }
    template <class Into>
    void produce(std::string const& what, std::string const& note, Into const& into)
    {
        report::StringStream text;
        into(text);
        write(what, text.str(), note);
    }
    void leave_out(std::string const& what, std::string const& why) { beside_.emplace_back(name_ + what, why); }
    /// The trace by superstep and tile, unless the table is too long.
    template <class Into>
    void produce_tiles(Trace const& trace, Into const& into)
    {
        std::uint64_t lines = 0;
        for (auto const& s : trace.supersteps) lines += s.tiles.size();
        if (lines <= page_.most_tile_lines) return produce(".tiles.csv", "the trace by superstep and tile", into);
        leave_out(".tiles.csv", "left out: " + report::thousands(lines) + " lines are more than " + report::thousands(page_.most_tile_lines));
    }
    /// The page itself, with the list of the files beside it.
    std::filesystem::path finish()
    {
        html_.section("Beside this page").key_values(beside_);
        report::write_whole(path(".html"), html_.str());
        return path(".html");
    }

private:
    std::filesystem::path path(std::string const& what) const { return folder_ / (name_ + what); }

    std::filesystem::path folder_;
    std::string name_;
    TracePage const& page_;
    report::HtmlReport html_;
    std::vector<std::pair<std::string, std::string>> beside_;
};

} // namespace model_detail

TILEMESH_HOST std::filesystem::path write_trace_page(std::filesystem::path const& folder, std::string const& name, Trace const& trace,
                                                     CostModel const& model, Grid grid, TracePage const& page)
{
    model_detail::TracePageFiles files(folder, name, grid, page);
    files.produce(".model.txt", "the cost model", [&](std::ostream& out) { write_cost_model(out, model); });
    auto const cost = model_cost(model, trace, grid);
    Energy energy;
    if (page.energy != nullptr) energy = energy_of(*page.energy, model, trace, grid);
    files.produce_tiles(trace, [&](std::ostream& out) { write_trace_csv(out, trace, model, grid); });
    files.produce(".supersteps.csv", "the trace by superstep", [&](std::ostream& out) { write_step_csv(out, trace, model, grid); });
    std::string note;
    auto const timeline = timeline_below(page.most_timeline_bytes, trace, model, grid, note);
    if (!timeline.empty()) files.write(".trace.json", timeline, note + ", for ui.perfetto.dev");
    else files.leave_out(".trace.json", note);

    auto maps = page.maps;
    for (auto& map : trace_maps(trace, model, grid)) maps.push_back(std::move(map));
    files.write(".maps.csv", maps_csv(maps, grid), "the numbers of all maps");
    if (page.energy != nullptr) {
        files.write(".energy.csv", energy_csv(energy, grid), "joules of each tile");
        maps.push_back(energy_map(energy));
    }
    auto facts = page.facts;
    facts.emplace_back("cost model", model.name + ", " + report::thousands(model.clock_khz) + " kHz");
    if (page.energy != nullptr) facts.emplace_back("energy model", page.energy->name);
    auto& html = files.html();
    add_section(html, trace_section(trace, model, cost, grid, page, maps, page.energy != nullptr ? &energy : nullptr), facts);
    html.paragraph(modelled_text);
    if (!page.ledger.empty()) add_ledger(html, page.ledger, page.sram_bytes);
    std::vector<std::string> counted;
    add_counted(counted, trace);
    add_parameters(html, model, counted);
    if (page.energy != nullptr) add_parameters(html, *page.energy);
    return files.finish();
}

TILEMESH_HOST std::filesystem::path write_trace_page(std::filesystem::path const& folder, std::string const& name,
                                                     Trace const& trace, Grid grid, TracePage const& page)
{
    model_detail::TracePageFiles files(folder, name, grid, page);
    files.produce_tiles(trace, [&](std::ostream& out) { write_trace_csv(out, trace, grid); });
    auto maps = page.maps;
    for (auto& map : trace_maps(trace, grid)) maps.push_back(std::move(map));
    files.write(".maps.csv", maps_csv(maps, grid), "the numbers of all maps");
    auto& html = files.html();
    add_section(html, trace_section(trace, grid, page, maps), page.facts);
    if (!page.ledger.empty()) add_ledger(html, page.ledger, page.sram_bytes);
    return files.finish();
}

}} // namespace tilemesh
