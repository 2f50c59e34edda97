#include "any_map.hpp"
#include <algorithm>
#include <cmath>
#include <common/statistics.hpp>
#include <tilemesh/report/plot.hpp>
#include <tilemesh/report/table.hpp>
#include <utility>

namespace any_map {

namespace {

using bench::fixed;
using tilemesh::report::thousands;

std::string ms(double value)
{
    return fixed(value, value < 10 ? 2 : 1);
}
bool is_homes(Row const& r)
{
    return r.program == Program::homes || r.program == Program::unfolded || r.program == Program::one_cut;
}
std::vector<Row const*> where(std::vector<Row> const& rows, auto const& wanted)
{
    std::vector<Row const*> out;
    for (auto const& r : rows)
        if (wanted(r)) out.push_back(&r);
    return out;
}
Row const* find(std::vector<Row> const& rows, std::string const& map, std::string const& view, Program program)
{
    for (auto const& r : rows)
        if (!r.sweep && r.map == map && r.view == view && r.program == program) return &r;
    return nullptr;
}
std::vector<std::string> maps_of(std::vector<Row> const& rows)
{
    std::vector<std::string> maps;
    for (auto const& r : rows)
        if (std::find(maps.begin(), maps.end(), r.map) == maps.end()) maps.push_back(r.map);
    return maps;
}
/// The rows of a sweep of a map, in order. The setup's own value of the other kind of slot is that of the map's other rows.
std::vector<Row const*> sweep_of(std::vector<Row> const& rows, std::string const& map, bool of_held)
{
    auto const own = where(rows, [&](Row const& r) { return !r.sweep && r.map == map && r.program == Program::homes; });
    if (own.empty()) return {};
    auto out = where(rows, [&](Row const& r) {
        return r.sweep && r.map == map && (of_held ? r.slots == own.front()->slots : r.held == own.front()->held);
    });
    // The setup's own slots are in both sweeps.
    auto const slots = [&](Row const* r) { return of_held ? r->held : r->slots; };
    std::stable_sort(out.begin(), out.end(), [&](auto const* a, auto const* b) { return slots(a) < slots(b); });
    out.erase(std::unique(out.begin(), out.end(), [&](auto const* a, auto const* b) { return slots(a) == slots(b); }), out.end());
    return out;
}
std::string markdown(std::vector<std::vector<std::string>> const& lines, std::size_t left)
{
    std::string out;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        for (auto const& cell : lines[i]) out += "| " + cell + " ";
        out += "|\n";
        if (i != 0) continue;
        for (std::size_t c = 0; c < lines[i].size(); ++c) out += c < left ? "|---" : "|--:";
        out += "|\n";
    }
    return out;
}
std::string rounds(Row const& r)
{
    return thousands(r.rounds) + (r.rounds == 1 ? " round" : " rounds");
}
/// What the fewest slots of a sweep cost, and how many are enough.
std::string knee(std::vector<Row const*> const& all, bool of_held)
{
    auto const least = *std::min_element(all.begin(), all.end(), [](auto const* a, auto const* b) { return a->all_cycles() < b->all_cycles(); });
    auto const slots = [&](Row const* r) { return of_held ? r->held : r->slots; };
    auto const* near = *std::find_if(all.begin(), all.end(), [&](auto const* r) { return 20 * r->all_cycles() <= 21 * least->all_cycles(); });
    auto const* first = all.front();
    std::string const what = of_held ? "slots for splats" : "slots a channel";
    return "**" + first->map + "**, " + first->view + ": with " + std::to_string(slots(first)) + " " + what + " the frame takes " + rounds(*first) + ", " +
           thousands(first->exchanges) + " exchanges and " + ms(modelled_ms(*first)) +
           " ms, and nothing is missing. The least is " + ms(modelled_ms(*least)) + " ms at " + thousands(slots(least)) +
           "; the smallest setting within 5 % of it has " + thousands(slots(near)) + ".";
}

} // namespace

std::string csv(std::vector<Row> const& rows)
{
    std::string out = "map,view,program,held,channel_slots,rounds,supersteps,hops,entries,refused,missing,modelled_ms,host_ms,sram_bytes,fits,"
                      "sweep,gaussians,chapters,streamed_bytes,psnr_db";
    for (std::string part : part_names) {
        std::replace(part.begin(), part.end(), ' ', '_');
        out += "," + part + "_ms";
    }
    out += "\n";
    for (auto const& r : rows) {
        auto view = r.view;
        std::replace(view.begin(), view.end(), ',', ';');
        out += r.map + "," + view + "," + to_string(r.program);
        for (std::uint64_t const n : {std::uint64_t{r.held}, std::uint64_t{r.slots}, r.rounds, r.exchanges, r.hops, r.entries, r.refused, r.missing})
            out += "," + std::to_string(n);
        out += "," + fixed(modelled_ms(r), 4) + "," + fixed(r.host_ms, 2) + "," + std::to_string(r.sram_bytes) + "," + (r.fits ? "1" : "0") + "," +
               (r.sweep ? "1" : "0") + "," + std::to_string(r.gaussians) + "," + std::to_string(r.chapters) + "," +
               std::to_string(r.streamed_bytes) + "," + fixed(r.psnr_db, 2);
        for (auto const c : r.cycles) out += "," + fixed(milliseconds(c), 4);
        out += "\n";
    }
    return out;
}

std::string view_table(std::vector<Row> const& rows)
{
    std::vector<std::vector<std::string>> lines{{"map", "view", "rounds", "exchanges", "hops", "entries", "refused", "homes, ms", "homes unfolded, ms",
                                                 "one cut, rounds", "one cut, ms", "anchored, ms", "anchored misses", "paper, ms", "paper misses", "paper, PSNR, dB"}};
    for (auto const& r : rows) {
        if (r.sweep || r.program != Program::homes) continue;
        auto const *flat = find(rows, r.map, r.view, Program::unfolded), *anchored = find(rows, r.map, r.view, Program::anchored);
        auto const *paper = find(rows, r.map, r.view, Program::paper), *sliced = find(rows, r.map, r.view, Program::one_cut);
        auto const time = [](Row const* other) { return other == nullptr ? "-" : ms(modelled_ms(*other)); };
        auto const missing = [](Row const* other) { return other == nullptr ? "-" : thousands(other->missing); };
        lines.push_back({r.map, r.view, thousands(r.rounds), thousands(r.exchanges), thousands(r.hops), thousands(r.entries), thousands(r.refused),
                         time(&r), time(flat), sliced == nullptr ? "-" : thousands(sliced->rounds), time(sliced), time(anchored), missing(anchored), time(paper), missing(paper),
                         paper == nullptr ? "-" : fixed(paper->psnr_db, 1)});
    }
    return markdown(lines, 2);
}

std::string step_table(std::vector<Row> const& rows)
{
    std::vector<std::vector<std::string>> lines{{"map", "view"}};
    for (auto const* part : part_names) lines[0].push_back(part);
    lines[0].push_back("sum");
    for (auto const& r : rows) {
        if (r.sweep || r.program != Program::homes) continue;
        lines.push_back({r.map, r.view});
        for (auto const c : r.cycles) lines.back().push_back(fixed(milliseconds(c), 2));
        lines.back().push_back(fixed(modelled_ms(r), 2));
    }
    return markdown(lines, 2);
}

std::string sweep_table(std::vector<Row> const& rows)
{
    std::vector<std::vector<std::string>> lines{{"map", "K", "slots a channel", "SRAM a tile, bytes", "rounds", "exchanges", "hops", "refused",
                                                 "missing", "modelled ms"}};
    for (auto const& map : maps_of(rows))
        for (bool const of_held : {true, false})
            for (auto const* r : sweep_of(rows, map, of_held))
                lines.push_back({r->map, thousands(r->held), thousands(r->slots), thousands(r->sram_bytes) + (r->fits ? "" : " (too many)"),
                                 thousands(r->rounds), thousands(r->exchanges), thousands(r->hops), thousands(r->refused), thousands(r->missing),
                                 ms(modelled_ms(*r))});
    return markdown(lines, 1);
}

std::vector<std::string> findings(std::vector<Row> const& rows)
{
    std::vector<std::string> out;
    auto const homes = where(rows, is_homes);
    auto const complete = std::count_if(homes.begin(), homes.end(), [](auto const* r) { return r->missing == 0 && std::isinf(r->psnr_db); });
    out.push_back("**Every picture is complete.** The program of homes rendered " + thousands(homes.size()) + " pictures, of all maps, views and slots. " +
                  thousands(static_cast<std::uint64_t>(complete)) + " of them have the bits of the naive whole-frame loop.");
    for (auto const program : {Program::anchored, Program::paper}) {
        auto const all = where(rows, [&](Row const& r) { return r.program == program; });
        auto const lossy = where(rows, [&](Row const& r) { return r.program == program && r.missing != 0; });
        if (lossy.empty()) continue;
        auto const* worst = *std::max_element(lossy.begin(), lossy.end(), [](auto const* a, auto const* b) { return a->missing < b->missing; });
        out.push_back(std::string(program == Program::anchored ? "The anchored program" : "The paper's setup") + " shows " +
                      std::to_string(all.size() - lossy.size()) + " of these " + std::to_string(all.size()) +
                      " views completely. It lacks the most in " + worst->map + ", " + worst->view + ": " + thousands(worst->missing) +
                      " records and copies.");
    }
    auto const range = [&](auto const& of, std::string const& before, std::string const& after) {
        std::vector<double> values;
        for (auto const* r : where(rows, [](Row const& row) { return !row.sweep && row.program == Program::homes; }))
            if (double const value = of(*r); value > 0) values.push_back(value);
        if (values.empty()) return;
        std::sort(values.begin(), values.end());
        out.push_back(before + fixed(values.front(), 2) + " to " + fixed(values.back(), 2) + after + " (median " +
                      fixed(bench::median(values), 2) + ").");
    };
    auto const beside = [&](Row const& r, Program program, bool complete_too) {
        auto const* other = find(rows, r.map, r.view, program);
        return other == nullptr || (complete_too && other->missing != 0) ? 0.0 : modelled_ms(*other) / modelled_ms(r);
    };
    range([&](Row const& r) { return beside(r, Program::anchored, true); },
          "Where the anchored program is complete too, its frame takes ", " times the modelled time of the program of homes");
    range([&](Row const& r) { return beside(r, Program::unfolded, false); }, "Without the fold, a frame takes ", " times as long");
    range([&](Row const& r) { return beside(r, Program::one_cut, false); }, "Slices with one cut for all tiles take ", " times as long");
    for (auto const part : {Part::deliver, Part::sort, Part::blend})
        range([&](Row const& r) { return 100 * static_cast<double>(r.cycles[static_cast<std::uint32_t>(part)]) / static_cast<double>(r.all_cycles()); },
              std::string("The step ") + part_names[static_cast<std::uint32_t>(part)] + " takes ", " % of the modelled time");
    for (auto const* r : where(rows, [](Row const& row) { return row.chapters != 0 && !row.sweep; }))
        out.push_back("**" + r->map + "**, " + r->view + ": " + thousands(r->gaussians) + " Gaussians are more than the tiles have homes for. They come in " +
                      thousands(r->chapters) + " chapters, " + thousands(r->streamed_bytes) + " bytes a frame, and the picture has the naive loop's bits: " +
                      ms(modelled_ms(*r)) + " modelled ms, of which " + ms(milliseconds(r->cycles[static_cast<std::uint32_t>(Part::host_link)])) +
                      " are the host link's.");
    for (auto const& map : maps_of(rows)) {
        for (bool const of_held : {true, false})
            if (auto const all = sweep_of(rows, map, of_held); !all.empty()) out.push_back(knee(all, of_held));
    }
    return out;
}

void write_plot(std::filesystem::path const& folder, std::vector<Row> const& rows)
{
    using tilemesh::report::PlotScale;
    tilemesh::report::Plot plot;
    plot.title = "Homes: a slot costs rounds instead of losses (Mk2, 40 x 36 tiles)";
    plot.x = {.label = "slots", .scale = PlotScale::logarithmic};
    plot.y = {.label = "modelled ms a frame; nothing is missing", .scale = PlotScale::logarithmic};
    std::uint32_t colour = 1;
    for (auto const& map : maps_of(rows)) {
        for (bool const of_held : {true, false}) {
            auto const all = sweep_of(rows, map, of_held);
            if (all.empty()) continue;
            tilemesh::report::PlotSeries series{.name = map + (of_held ? ", held (K)" : ", a channel"), .points = {}, .colour = colour};
            series.dashed = !of_held;
            for (auto const* r : all) series.points.emplace_back(of_held ? r->held : r->slots, modelled_ms(*r));
            plot.series.push_back(series);
        }
        ++colour;
    }
    tilemesh::report::write_svg(folder / "slots.svg", plot);
}

} // namespace any_map
