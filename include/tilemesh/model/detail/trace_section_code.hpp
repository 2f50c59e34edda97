#pragma once
#include <algorithm>
#include <numeric>
#include <optional>
#include <tilemesh/model/any_to_any.hpp>
#include <tilemesh/model/confidence.hpp>
#include <tilemesh/model/detail/trace_reading.hpp>
#include <tilemesh/model/exchange.hpp>
#include <tilemesh/model/network_lines.hpp>
#include <tilemesh/model/trace_section.hpp>
#include <tilemesh/report/heat_image.hpp>
#include <tilemesh/report/image_file.hpp>

namespace tilemesh { inline namespace v0_2 {

TILEMESH_HOST std::size_t TraceSection::bytes() const noexcept
{
    std::size_t pictures = 0;
    for (auto const& card : cards) pictures += card.image.size();
    return pictures / 3 * 4 + steps_svg.size() + supersteps_svg.size();
}

namespace model_detail {

/// Adds the picture, if there is one, and the maps, each in the picture's frame.
inline void add_cards(TraceSection& section, std::vector<TileMap> const& maps, Grid grid, TracePage const& page)
{
    auto const encoded = [&](report::Image const& image) { return page.png ? page.png(image) : report::bmp(image); };
    auto& frame = section.frame;
    frame.map_width = std::max(1.0 * page.tile_px[0] * grid.width, 1.0);
    frame.map_height = std::max(1.0 * page.tile_px[1] * grid.height, 1.0);
    frame.width = page.picture != nullptr ? page.picture->width : frame.map_width;
    frame.height = page.picture != nullptr ? page.picture->height : frame.map_height;
    if (page.picture != nullptr) {
        auto const size = std::to_string(page.picture->width) + " x " + std::to_string(page.picture->height) + " pixels";
        section.cards.push_back({"The picture", size + ", on " + std::to_string(grid.width) + " x " + std::to_string(grid.height) + " tiles",
                                 encoded(*page.picture), "the picture, " + size});
    }
    for (auto const& map : maps) {
        auto const [least, most] = report::finite_range(map.values);
        auto const shown = [&](double value) { return map.unit == "J" ? report::significant(value, 6) : report::short_number(value); };
        auto const unit = map.unit.empty() ? "" : " " + map.unit;
        if (least == most) {
            section.flat_maps.push_back(map.title + ": " + map.what + ". It is " + shown(most) + unit + " on every tile.");
            continue;
        }
        auto const at = static_cast<std::uint32_t>(std::max_element(map.values.begin(), map.values.end()) - map.values.begin());
        auto text = map.what + ". Most: " + shown(most) + unit + " on tile " + tile_text(grid, at) + ".";
        if (map.in_total) text += " Sum: " + shown(std::accumulate(map.values.begin(), map.values.end(), 0.0)) + ".";
        section.cards.push_back({map.title, text, encoded(report::heat_image(map.values, grid.width, grid.height, {0, most})),
                                 "a map of the grid: " + map.what, {"0" + unit, shown(most / 2), shown(most) + unit}});
    }
}
/// A step's slowest tile and what its kernel counted there, a line each: "(6, 21) in 6 of 73 passes:", "458,914 slot (76.6 %)".
inline std::string slowest_text(std::optional<SlowestTile> const& slowest, StepCost const& s, std::vector<std::uint64_t> const& busy, Grid grid)
{
    if (!slowest) return {};
    bool const all_alike = *std::min_element(busy.begin(), busy.end()) == s.compute; // every tile computes as long as the slowest, in each pass
    auto text = all_alike && busy.size() > 1 ? "all alike, such as " + tile_text(grid, slowest->tile) : tile_text(grid, slowest->tile);
    if (s.passes != 1) text += " in " + report::thousands(slowest->passes) + " of " + passes_text(s.passes);
    for (auto const& counted : slowest->operations)
        text += (&counted == slowest->operations.data() ? ":\n" : "\n") + report::thousands(counted.count) + " " + counted.operation + " (" +
                report::share_text(counted.cycles, static_cast<double>(slowest->cycles)) + ")";
    return text + (slowest->operations.empty() ? ": nothing counted" : "");
}
/// What bounds the passes of a step, the most frequent first: "compute 70, port in 5".
inline std::string bounds_text(RunCost const& cost, std::uint32_t step)
{
    std::vector<std::pair<std::string, std::uint64_t>> kinds;
    for (auto const& c : cost.supersteps) {
        if (c.step != step || c.total() == 0) continue;
        auto const at = std::find_if(kinds.begin(), kinds.end(), [&](auto const& known) { return known.first == bound_kind(c); });
        if (at == kinds.end()) kinds.emplace_back(bound_kind(c), 1);
        else ++at->second;
    }
    std::stable_sort(kinds.begin(), kinds.end(), [](auto const& a, auto const& b) { return a.second > b.second; });
    std::string text;
    for (auto const& [kind, passes] : kinds) text += (text.empty() ? "" : ", ") + kind + " " + report::thousands(passes);
    return text;
}
inline void add_step_counts(std::vector<std::string>& row, StepCost const& s)
{
    for (auto const& text : {s.name, report::thousands(s.passes), report::thousands(s.exchanges), report::thousands(s.tile_runs),
                             report::thousands(s.sent_bytes)})
        row.push_back(text);
}

} // namespace model_detail

TILEMESH_HOST TraceSection trace_section(Trace const& trace, CostModel const& model, RunCost const& cost, Grid grid,
                                         TracePage const& page, std::vector<TileMap> const& maps, Energy const* energy)
{
    using report::share_text;
    using report::thousands;
    TraceSection section;
    section.modelled = true;
    auto const worst = find_bottleneck(model, trace, cost, grid);
    section.lead = bottleneck_text(worst, model, trace, cost, grid, page.run, worst && page.because ? page.because(*worst) : std::string());
    section.rests_on = confidence_text(model, trace, cost);
    auto const steps = step_costs(trace, cost);
    std::uint64_t exchanges = 0;
    double busy = 0;
    std::string uncounted;
    for (std::size_t i = 0; i < steps.size(); ++i) {
        exchanges += steps[i].exchanges;
        busy = std::accumulate(cost.busy[i].begin(), cost.busy[i].end(), busy);
        if (steps[i].tile_runs != 0 && model_detail::operations_of_step(trace, i).empty())
            uncounted += (uncounted.empty() ? "" : ", ") + steps[i].name;
    }
    if (!uncounted.empty())
        section.notes = "The kernels of these steps count no operations, so that their compute costs no more than to start them: " + uncounted + ".";
    section.figures = {{"modelled time", milliseconds_text(model, cost.cycles) + " ms"}, {"cycles", thousands(cost.cycles)},
                       {"passes", thousands(cost.supersteps.size())}, {"exchanges", thousands(exchanges)},
                       {"tiles", std::to_string(grid.width) + " x " + std::to_string(grid.height)},
                       {"tile time busy", share_text(busy, static_cast<double>(cost.cycles) * grid.size())}};
    if (energy != nullptr) section.figures.emplace_back("energy", report::significant(energy->joules, 6) + " J");
    model_detail::add_cards(section, maps, grid, page);
    if (worst && worst->phase == Bottleneck::Phase::compute) {
        auto const tile = grid.tile(worst->tile);
        section.frame.mark = {1.0 * tile.x() * page.tile_px[0], 1.0 * tile.y() * page.tile_px[1], 1.0 * page.tile_px[0], 1.0 * page.tile_px[1]};
    }
    section.steps_svg = steps_svg(model, steps);
    section.supersteps_svg = supersteps_svg(trace, model, cost, grid);
    for (std::uint32_t i = 0; i < steps.size(); ++i) {
        auto const& s = steps[i];
        auto& row = section.steps.emplace_back();
        model_detail::add_step_counts(row, s);
        for (auto const cycles : {s.compute, s.exchange, s.sync, s.vote, s.total()}) row.push_back(thousands(cycles));
        row.push_back(milliseconds_text(model, s.total()));
        row.push_back(share_text(static_cast<double>(s.total()), static_cast<double>(cost.cycles)));
        row.push_back(model_detail::bounds_text(cost, i));
        row.push_back(model_detail::slowest_text(slowest_tile(model, trace, cost, grid, i), s, cost.busy[i], grid));
    }
    auto const ideal = any_to_any(model, trace, grid);
    if (std::any_of(ideal.steps.begin(), ideal.steps.end(), [](AnyToAnyStep const& s) { return s.settled_bytes != 0; })) {
        for (auto const& s : ideal.steps)
            section.ideal.push_back({s.first == s.last ? steps[s.first].name : steps[s.first].name + " to " + steps[s.last].name,
                                     thousands(s.news_cycles), thousands(s.bound_cycles), thousands(s.replaced ? s.supersteps : 0)});
        section.ideal.push_back({"all", thousands(ideal.news_cycles), thousands(ideal.bound_cycles), thousands(ideal.supersteps_replaced)});
    }
    if (energy != nullptr && page.energy != nullptr) {
        for (auto const& event : energy->events)
            if (event.count != 0) // every event with a count has an energy
                section.energy_kinds.push_back({event.name, thousands(event.count),
                                                thousands(model_detail::find_energy(*page.energy, event.name)->value),
                                                report::significant(event.joules, 6), share_text(event.joules, energy->joules)});
        for (std::size_t s = 0; s < steps.size(); ++s)
            section.energy_steps.push_back({steps[s].name, report::significant(energy->joules_of_step[s], 6),
                                            share_text(energy->joules_of_step[s], energy->joules)});
    }
    return section;
}

TILEMESH_HOST TraceSection trace_section(Trace const& trace, Grid grid, TracePage const& page, std::vector<TileMap> const& maps)
{
    using report::thousands;
    TraceSection section;
    section.lead = load_text(trace, grid, page.run);
    section.notes = "No cost model is given, so there are no times.";
    StepCost all;
    for (auto const& s : step_costs(trace)) {
        model_detail::add_step_counts(section.steps.emplace_back(), s);
        all.exchanges += s.exchanges;
        all.tile_runs += s.tile_runs;
        all.sent_bytes += s.sent_bytes;
    }
    section.figures = {{"passes", thousands(trace.supersteps.size())}, {"exchanges", thousands(all.exchanges)},
                       {"tiles", std::to_string(grid.width) + " x " + std::to_string(grid.height)}, {"kernel runs", thousands(all.tile_runs)},
                       {"bytes sent, with heads", thousands(all.sent_bytes)}};
    model_detail::add_cards(section, maps, grid, page);
    return section;
}

TILEMESH_HOST void add_section(report::HtmlReport& html, TraceSection const& section, std::vector<std::pair<std::string, std::string>> const& facts)
{
    if (!section.lead.empty()) html.lead(section.lead);
    if (!section.notes.empty()) html.paragraph(section.notes);
    html.figures(section.figures);
    if (!section.rests_on.empty()) html.paragraph(section.rests_on);
    if (!section.cards.empty()) {
        html.gallery(section.frame, section.cards);
        if (section.frame.mark) html.paragraph("The outlined tile is the slowest one, which the first sentence names.");
    }
    if (!section.flat_maps.empty())
        html.folded_subsection(std::to_string(section.flat_maps.size()) + (section.flat_maps.size() == 1 ? " map is" : " maps are") +
                                   " the same on every tile",
                               report::HtmlFold::closed, [&] {
                                   for (auto const& sentence : section.flat_maps) html.paragraph(sentence);
                               });
    html.subsection(section.modelled ? "Where the time goes" : "What ran");
    std::vector<std::string> headers = {"step", "passes", "exchanges", "kernel runs", "bytes sent, with heads"};
    if (section.modelled) {
        html.svg(section.supersteps_svg).svg(section.steps_svg);
        for (auto const* header : {"compute", "exchange", "sync", "vote", "cycles", "ms", "share", "bounded by, in passes",
                                   "slowest tile and its operations"})
            headers.emplace_back(header);
    }
    html.table(headers, section.steps);
    if (section.modelled)
        html.paragraph("Compute, exchange, sync and vote are modelled cycles: of the slowest tile of each pass, and of what follows the pass. A "
                       "pass is one run of a kernel on the tiles that must run. Exchanges are those that carried something. What bounds a pass "
                       "is the largest of the four; of an exchange, its busiest resource. The file of supersteps names it for each pass.")
            .paragraph("The slowest tile of a step is the one that the other tiles wait for longest. The counts are of the passes in which it is "
                       "the slowest, and each share is of its compute in them; starting the kernel takes the rest. An operation is a unit of "
                       "work that a kernel counts; the cost model, further down, has its price and the source of the price.");
    if (!facts.empty()) html.key_values(facts);
    if (!section.ideal.empty())
        html.folded_subsection("Ideal routing", report::HtmlFold::closed, [&] {
            html.table({"step", "cycles hop by hop", "bound", "passes replaced"}, section.ideal);
            html.paragraph("Exchange, sync and vote of each step, hop by hop as modelled above, and if every message went from any tile "
                           "straight to where it stays, in one exchange. This is a bound and no machine: a tile would have to know where "
                           "each record is, and the busiest receiver would never wait. Steps of one kernel that follow each other are one "
                           "line. Compute is in neither column.");
        });
    if (!section.energy_kinds.empty()) {
        html.subsection("Energy");
        html.table({"event", "count", "fJ each", "joules", "share"}, section.energy_kinds);
        html.table({"step", "joules", "share"}, section.energy_steps);
    }
}

TILEMESH_HOST void add_ledger(report::HtmlReport& html, std::span<machine::Region const> ledger, std::uint64_t sram_bytes)
{
    using report::thousands;
    std::vector<std::vector<std::string>> rows;
    std::uint64_t sum = 0;
    for (auto const& region : ledger) {
        rows.push_back({std::string(region.name.text, region.name.size), region.what, thousands(region.bytes),
                        region.budgeted ? "" : "outside the budget"});
        sum += region.budgeted ? region.bytes : 0;
    }
    rows.push_back(
        {"in the budget", "", thousands(sum),
         sram_bytes == 0 ? "" : report::share_text(static_cast<double>(sum), static_cast<double>(sram_bytes)) + " of " + thousands(sram_bytes)});
    html.folded_section("Ledger of a tile's SRAM", report::HtmlFold::closed, [&] { html.table({"region", "what", "bytes", ""}, rows); });
}

TILEMESH_HOST void add_parameters(report::HtmlReport& html, CostModel const& model)
{
    std::vector<std::vector<std::string>> rows;
    for (auto const& p : model.parameters) {
        auto const& kinds = model_detail::exchange_cost_names; // the value of the kind of exchange is shown as a word
        bool const word = p.unit == "kind" && p.value < kinds.size();
        rows.push_back({p.name, word ? std::string(kinds[static_cast<std::size_t>(p.value)]) : report::thousands(p.value), word ? "" : p.unit,
                        std::string(price_kind_names[static_cast<std::size_t>(p.kind)]), p.source});
    }
    if (model.network)
        for (auto& row : model_detail::network_rows(*model.network)) {
            row.insert(row.begin() + 3, std::string(price_kind_names[static_cast<std::size_t>(kind_of_source(row[3]))]));
            rows.push_back(std::move(row));
        }
    html.folded_section("Cost model " + model.name, report::HtmlFold::closed,
                        [&] { html.table({"parameter", "value", "unit", "known as", "source"}, rows); });
}

TILEMESH_HOST void add_counted(std::vector<std::string>& counted, Trace const& trace)
{
    for (auto const& s : trace.supersteps)
        for (auto const& tile : s.tiles) {
            if (s.step >= trace.operations.size()) continue; // a trace put together by hand may name none
            auto const& names = trace.operations[s.step];
            for (std::size_t kind = 0; kind < names.size(); ++kind)
                if (tile.operations.count[kind] != 0 && std::find(counted.begin(), counted.end(), names[kind]) == counted.end())
                    counted.emplace_back(names[kind]);
        }
}

TILEMESH_HOST void add_parameters(report::HtmlReport& html, CostModel const& model, std::vector<std::string> const& counted)
{
    auto shown = model;
    std::erase_if(shown.parameters, [&](ModelParameter const& p) {
        auto const priced = std::any_of(model.prices.begin(), model.prices.end(), [&](auto const& price) { return price.operation == p.name; });
        return priced && std::find(counted.begin(), counted.end(), p.name) == counted.end();
    });
    add_parameters(html, shown);
    if (auto const left_out = model.parameters.size() - shown.parameters.size(); left_out != 0)
        html.paragraph("The model has " + report::thousands(left_out) +
                       " more, prices of operations that this run did not count. The file of the model beside this page has all of them.");
}

TILEMESH_HOST void add_parameters(report::HtmlReport& html, EnergyModel const& model)
{
    std::vector<std::vector<std::string>> rows;
    for (auto const& p : model.events) rows.push_back({p.name, report::thousands(p.value), p.unit, p.source});
    html.folded_section("Energy model " + model.name, report::HtmlFold::closed, [&] { html.table({"event", "value", "unit", "source"}, rows); });
}

}} // namespace tilemesh
