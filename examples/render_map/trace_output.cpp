#include "trace_output.hpp"
#include "../shared/model_input.hpp"
#include "../shared/png.hpp"
#include "../shared/text.hpp"
#include "outputs.hpp"
#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/model/bottleneck.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/confidence.hpp>
#include <tilemesh/model/cost_table.hpp>
#include <tilemesh/model/machine_file.hpp>
#include <tilemesh/model/step_costs.hpp>
#include <tilemesh/model/trace_files.hpp>
#include <tilemesh/model/trace_maps.hpp>
#include <tilemesh/model/trace_page.hpp>
#include <tilemesh/report/frame_csv.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/report/plot.hpp>
#include <tilemesh/report/string_stream.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <tilemesh/splat/operations.hpp>

namespace render_map {

namespace {

namespace report = tilemesh::report;
using report::thousands;
using tilemesh::TileMap;
using Pairs = std::vector<std::pair<std::string, std::string>>;
using Rows = std::vector<std::vector<std::string>>;

/// What the page says of splat::Operation, in the order of its names.
constexpr char const* operation_meanings[] = {"A slot of a list or of a channel end that a kernel looks at.", "A record that is projected.",
                                              "A record on its way that is taken from a channel or given to one.",
                                              "A copy that is taken from a channel or given to one.", "Two keys that are compared and put in order.",
                                              "A Gaussian-pixel pair that is evaluated.", "A pixel that is begun and written."};
static_assert(std::size(operation_meanings) == std::size(tilemesh::splat::Operation::names), "each operation needs its meaning");

/// The counters in the table of all frames.
struct CounterColumn {
    char const* header;
    std::uint64_t (*count)(report::FrameReport const&);
};
constexpr CounterColumn counter_columns[] = {{"moved", report::report_field("gaussians.moved").count},
                                             {"copies", report::report_field("copies").count},
                                             {"missing", report::report_field("lost").count},
                                             {"rounds", report::report_field("homes.rounds").count},
                                             {"messages", report::report_field("messages").count},
                                             {"most on a tile", report::report_field("peak.storage").count},
                                             {"most in a channel", report::report_field("peak.channel").count}};

std::vector<TileMap> heat_maps(tilemesh::Trace const& trace, tilemesh::CostModel const& model, tilemesh::Grid grid,
                               std::vector<TileState> const& tiles)
{
    auto const of_state = [&](auto const& value) {
        std::vector<double> out(grid.size(), 0);
        for (std::size_t t = 0; t < tiles.size(); ++t) out[t] = static_cast<double>(value(tiles[t]));
        return out;
    };
    auto of_trace = tilemesh::trace_maps(trace, model, grid); // channel fill, busy and idle cycles
    std::vector<TileMap> maps;
    auto const add = [&](char const* name, char const* title, char const* meaning, bool sums, char const* unit, auto const& value) {
        maps.push_back({name, title, meaning, sums, of_state(value), unit});
    };
    add("load", "Load", "records stored when the frame is over, copies among them", true, "records", [](TileState const& t) { return t.records; });
    add("copies", "Copies", "records stored whose anchor is another tile", true, "copies", [](TileState const& t) { return t.copies; });
    maps.push_back(std::move(of_trace[0]));
    add("refusals", "Refusals", "sends that waited for a full channel or for credit; three waits count three", true, "sends",
        [](TileState const& t) { return t.refusals; });
    add("drops", "Drops", "records and copies that found no storage, and copies given up at a full channel", true, "records",
        [](TileState const& t) { return t.drops; });
    maps.push_back(std::move(of_trace[1]));
    maps.push_back(std::move(of_trace[2]));
    add("pairs", "Pairs", "Gaussian-pixel pairs evaluated", true, "pairs", [](TileState const& t) { return t.pairs; });
    if (std::any_of(tiles.begin(), tiles.end(), [](TileState const& t) { return t.rounds != 0; })) {
        add("rounds", "Rounds", "rounds in which the tile was not done", true, "rounds", [](TileState const& t) { return t.rounds; });
        add("entries", "Entries", "splats that the tile received from homes in all rounds", true, "splats",
            [](TileState const& t) { return t.entries; });
        add("frontier", "Frontier",
            "depth up to which the tile's pixels are exact after its last round; of a tile with every splat, that of the farthest one", false,
            "world units", [](TileState const& t) { return t.frontier; });
    }
    return maps;
}

std::string plural(std::uint64_t n, char const* what)
{
    return thousands(n) + " " + what + (n == 1 ? "" : "s");
}
/// Why the tile takes its time, for the first sentence of the page; empty if it stores nothing.
std::string reason(std::vector<TileState> const& tiles, std::uint32_t tile)
{
    if (tile >= tiles.size() || (tiles[tile].records == 0 && tiles[tile].rounds == 0)) return {};
    auto const& t = tiles[tile];
    if (t.rounds != 0)
        return "it received " + plural(t.entries, "splat") + " in " + plural(t.rounds, "round") + ", and is the home of " + plural(t.records, "record");
    double all = 0;
    for (auto const& other : tiles) all += other.records;
    return "it stores " + plural(t.records, "record") + ", " + thousands(t.copies) + " of them copies (mean of all tiles: " +
           report::decimals(all / static_cast<double>(tiles.size()), 0) + ")";
}
/// Every round of every tile, a line each.
std::string rounds_csv(std::vector<TileRound> const& rounds, tilemesh::Grid grid)
{
    std::string text = "round,chapter,tile_x,tile_y,held,refused,frontier,done\n";
    for (auto const& r : rounds) {
        auto const tile = grid.tile(r.tile);
        text += std::to_string(r.round) + "," + std::to_string(r.chapter) + "," + std::to_string(tile.x()) + "," + std::to_string(tile.y()) + "," +
                std::to_string(r.held) + "," + std::to_string(r.refused) + "," + report::plain_number(static_cast<double>(r.frontier)) +
                (r.done ? ",1\n" : ",0\n");
    }
    return text;
}
/// A row for each round of a frame. `cost` is that of `trace`.
Rows round_rows(std::vector<TileRound> const& rounds, tilemesh::Trace const& trace, tilemesh::CostModel const& model, tilemesh::RunCost const& cost)
{
    std::vector<std::uint64_t> cycles; // of each round; the program has one Loop
    for (auto const& round : loop_rounds(trace)) {
        cycles.push_back(0);
        for (auto i = round.first; i <= round.last; ++i) cycles.back() += cost.supersteps[i].total();
    }
    Rows out;
    for (auto first = rounds.begin(); first != rounds.end();) {
        auto const last = std::find_if(first, rounds.end(), [&](TileRound const& r) { return r.round != first->round; });
        std::uint64_t held = 0, refused = 0, done = 0;
        for (auto r = first; r != last; ++r) held += r->held, refused += r->refused, done += r->done ? 1 : 0;
        auto const [nearest, farthest] = std::minmax_element(first, last, [](TileRound const& a, TileRound const& b) { return a.frontier < b.frontier; });
        out.push_back({thousands(first->round), thousands(first->chapter), thousands(static_cast<std::uint64_t>(last - first)), thousands(done),
                       thousands(held), thousands(refused), report::short_number(static_cast<double>(nearest->frontier)),
                       report::short_number(static_cast<double>(farthest->frontier)),
                       first->round <= cycles.size() ? milliseconds_text(model, cycles[first->round - 1]) : ""});
        first = last;
    }
    return out;
}
std::string tile_text(tilemesh::TileId tile)
{
    return "(" + std::to_string(tile.x()) + ", " + std::to_string(tile.y()) + ")";
}
} // namespace

TraceOutput::TraceOutput(Options const& options)
    : options_(options), folder_(options.trace.value()), followed_(options.follow.value_or(0)),
      model_(options.cost_model     ? shared::load_model(*options.cost_model, tilemesh::read_cost_model, "cost model",
                                                         "name a file as --trace writes it (model.txt)")
             : options.machine_file ? cost_model_of(*options.machine_file)
                                    : tilemesh::mk2())
{
    if (options.energy)
        energy_model_ = shared::load_model(*options.energy, tilemesh::read_energy_model, "energy model",
                                   "name a file of a line \"energy NAME\" and a line \"EVENT FEMTOJOULES fJ SOURCE\" an event");
    if (followed_ != 0) follow_csv_ = "frame,superstep,kernel,tile_x,tile_y,what,side,refusal\n";
}

void TraceOutput::write(std::string const& name, std::string const& text) const
{
    if (!is_of_trace(name, options_, std::numeric_limits<std::size_t>::max()))
        throw std::logic_error(name + " is not in the list of a trace's files"); // so nobody checked which file it would replace
    report::write_whole(folder_ / name, text, {}, outlasts(options_));
}

void TraceOutput::remove_old(std::string const& name) const
{
    std::error_code refused;
    std::filesystem::remove(folder_ / name, refused);
    if (refused)
        throw tilemesh::Error("cannot remove " + (folder_ / name).string() + " (it is of an earlier run, and " + refused.message() +
                              "); name another directory with --trace");
}

std::string TraceOutput::write_no_progress(std::string const& text) const
{
    write(no_progress_file, text + "\n");
    return (folder_ / no_progress_file).string();
}

report::Modelled TraceOutput::add_frame(std::size_t index, report::RunFrame const& frame, report::Image const& picture,
                                        Instruments& instruments)
{
    tilemesh::Grid const grid{frame.grid[0], frame.grid[1]};
    auto const& trace = instruments.trace();
    auto const cost = model_cost(model_, trace, grid);
    report::Modelled modelled{model_.name, cost.cycles, tilemesh::milliseconds(model_, cost.cycles)};
    std::optional<tilemesh::Energy> energy; // before a file is written: the energy of an event may not be set
    if (energy_model_) energy = energy_of(*energy_model_, model_, trace, grid);
    auto const& r = frame.report;
    if (index == 0) {
        report::StringStream text;
        write_cost_model(text, model_);
        write(model_file, text.str());
        remove_old(no_progress_file);
    }

    std::size_t lines = 0;
    for (auto const& superstep : trace.supersteps) lines += superstep.tiles.size();
    if (lines <= most_tile_lines || options_.trace_tiles) {
        report::StringStream tiles;
        write_trace_csv(tiles, trace, model_, grid);
        write(frame_file(index, ".tiles.csv"), tiles.str());
    } else {
        remove_old(frame_file(index, ".tiles.csv"));
    }
    report::StringStream supersteps;
    write_step_csv(supersteps, trace, model_, grid);
    write(frame_file(index, ".supersteps.csv"), supersteps.str());
    std::string note;
    auto const timeline_file = frame_file(index, ".trace.json");
    if (auto const text = tilemesh::timeline_below(most_timeline_bytes, trace, model_, grid, note); !text.empty()) write(timeline_file, text);
    else remove_old(timeline_file);

    auto const& states = instruments.tiles();
    auto maps = heat_maps(trace, model_, grid, states);
    write(frame_file(index, ".heat.csv"), maps_csv(maps, grid));
    auto const& rounds = instruments.rounds();
    if (rounds.empty()) remove_old(frame_file(index, rounds_end));
    else write(frame_file(index, rounds_end), rounds_csv(rounds, grid));
    if (energy) {
        write(frame_file(index, ".energy.csv"), energy_csv(*energy, grid));
        maps.push_back(energy_map(*energy));
    }
    std::array<std::uint32_t, 2> const tile_px = {frame.tile_px[0], frame.tile_px[1]};
    for (auto const& map : maps) write(frame_file(index, ".heat_" + map.name + ".png"), shared::png_bytes(map_image(map, grid, tile_px)));
    auto const busy_map = std::find_if(maps.begin(), maps.end(), [](TileMap const& map) { return map.name == "busy_cycles"; });
    double const busy = std::accumulate(busy_map->values.begin(), busy_map->values.end(), 0.0);

    auto const ms = milliseconds_text(model_, cost.cycles);
    auto const utilisation = report::share_text(busy, static_cast<double>(cost.cycles) * grid.size());
    milliseconds_.emplace_back(static_cast<double>(index), tilemesh::milliseconds(model_, cost.cycles));
    auto const because = [&](tilemesh::Bottleneck const& bottleneck) { return reason(states, bottleneck.tile); };
    if (auto const worst = find_bottleneck(model_, trace, cost, grid); frames_ == 0 || cost.cycles > slowest_cycles_) {
        slowest_ = index;
        slowest_cycles_ = cost.cycles;
        slowest_lead_ = bottleneck_text(worst, model_, trace, cost, grid, "frame", worst ? because(*worst) : std::string());
    }
    if (lines_.size() < most_lines) {
        std::uint64_t exchanges = 0;
        for (auto const& step : step_costs(trace)) exchanges += step.exchanges;
        lines_.push_back({std::to_string(index) + ": " + r.camera, thousands(cost.supersteps.size()), thousands(exchanges),
                          thousands(cost.cycles), ms, utilisation});
        for (auto const& column : counter_columns) lines_.back().push_back(thousands(column.count(r)));
        if (energy) lines_.back().push_back(report::significant(energy->joules, 6));
    }
    ++frames_;
    report::StringStream table;
    table << cost_table(model_, trace, cost);
    cost_text_ = "modelled by " + shared::one_line(model_.name, 60) + " (" +
                 (model_.exchange_cost == tilemesh::ExchangeCost::capacity ? "capacity" : "live") + " exchange), busy " +
                 utilisation + " of all tile time:\n" + table.str() + confidence_text(model_, trace, cost) + "\n";
    if (energy)
        cost_text_ += "energy by " + shared::one_line(energy_model_->name, 60) + " in frame " + std::to_string(index) + ": " +
                      report::significant(energy->joules, 6) + " J\n";
    if (followed_ != 0) add_life(index, instruments.life());

    add_counted(counted_, trace);
    if (sections_.size() == most_full_frames || bytes_ > most_report_bytes) return modelled;
    Section section;
    section.frame = index;
    section.heading = "Frame " + std::to_string(index) + ": " + r.camera;
    section.facts = {{"a tile's part of the picture", std::to_string(tile_px[0]) + " x " + std::to_string(tile_px[1]) + " pixels"},
                     {frame_file(index, ".trace.json"), note}};
    if (lines > most_tile_lines && !options_.trace_tiles)
        section.facts.emplace_back(frame_file(index, ".tiles.csv"),
                                   "left out: " + report::thousands(lines) + " lines are more than " + report::thousands(most_tile_lines) +
                                       "; --trace-tiles writes it");
    for (auto const line : report::text_lines)
        if (report::has_line(r, line)) section.facts.emplace_back(line, report::numbers_of(r, line));
    tilemesh::TracePage page;
    page.energy = energy_model_ ? &*energy_model_ : nullptr;
    page.png = [](report::Image const& image) { return shared::png_bytes(image); };
    page.run = "frame";
    page.because = because;
    page.picture = &picture;
    page.tile_px = tile_px;
    section.run = trace_section(trace, model_, cost, grid, page, maps, energy ? &*energy : nullptr);
    section.run.figures.emplace_back("copies", thousands(r.copies));
    section.run.figures.emplace_back("missing", thousands(r.lost.size()));
    if (r.program == report::Program::homes) section.run.figures.emplace_back("rounds", thousands(r.homes.rounds));
    section.run.figures.emplace_back("pairs", thousands(r.pairs));
    section.rounds = round_rows(rounds, trace, model_, cost);
    bytes_ += section.run.bytes();
    sections_.push_back(std::move(section));
    return modelled;
}

void TraceOutput::add_life(std::size_t index, Life const& life)
{
    auto const frame = std::to_string(index);
    for (auto const& s : life.sightings) {
        std::string const side = s.side ? name_of(*s.side) : "";
        follow_csv_ += frame + "," + std::to_string(s.superstep) + "," + s.kernel + "," + std::to_string(s.tile.x()) + "," +
                       std::to_string(s.tile.y()) + "," + name_of(s.what) + "," + side + "," + (s.refusal ? "1" : "0") +
                       "\n";
        ++sights_;
        if (seen_.size() < most_lines)
            seen_.push_back({name_of(s.what), frame, std::to_string(s.superstep), s.kernel, tile_text(s.tile), side,
                             s.refusal ? "refused" : ""});
    }
    auto const where = life.anchor    ? tile_text(*life.anchor)
                       : life.dropped ? "dropped on tile " + tile_text(*life.dropped)
                                      : std::string("on no tile");
    if (lives_.size() < most_lines)
        lives_.push_back({frame, where, thousands(life.copies), thousands(life.hops), thousands(life.sent_copies),
                          thousands(life.refusals)});
    life_text_ = "Gaussian " + std::to_string(followed_) + " in frame " + frame + ": " + (life.anchor ? "on tile " : "") +
                 where + ", " + thousands(life.copies) + (life.copies == 1 ? " copy, " : " copies, ") +
                 plural(life.hops, "hop") + ", " + plural(life.refusals, "refusal") +
                 (life.dropped_copies == 0 ? "" : " (" + thousands(life.dropped_copies) +
                                                      (life.dropped_copies == 1 ? " copy" : " copies") + " met a full storage)") +
                 "\n";
}

std::string TraceOutput::summary() const
{
    return cost_text_ + life_text_;
}

void TraceOutput::add_frames(report::HtmlReport& html) const
{
    auto const head = std::string("Slowest: ");
    if (frames_ > 1 && slowest_lead_.starts_with(head))
        html.lead(head + "frame " + std::to_string(slowest_) + " of " + thousands(frames_) + " frames, and in it " + slowest_lead_.substr(head.size()));
    else if (frames_ > 0) html.lead(slowest_lead_);
    if (frames_ > 1) {
        html.section("Frames");
        std::vector<std::string> headers = {"frame", "passes", "exchanges", "cycles", "ms", "tiles busy"};
        for (auto const& column : counter_columns) headers.emplace_back(column.header);
        if (energy_model_) headers.emplace_back("joules");
        html.table(headers, lines_);
        if (lines_.size() < frames_)
            html.paragraph("The first " + thousands(lines_.size()) + " of " + thousands(frames_) + " frames.");
        report::Plot plot;
        plot.title = "Modelled time of each frame";
        plot.x.label = "frame";
        plot.y.label = "milliseconds";
        plot.y.low = 0.0;
        plot.width = 1200;
        // A dot a pixel is as many as can be seen: of more frames every n-th.
        auto const every = (milliseconds_.size() + most_lines - 1) / most_lines;
        plot.series = {{model_.name, {}}};
        for (std::size_t i = 0; i < milliseconds_.size(); i += every) plot.series[0].points.push_back(milliseconds_[i]);
        html.svg(svg(plot));
    }
    auto const add = [&](Section const& section, tilemesh::TraceSection const& run) {
        tilemesh::add_section(html, run, section.facts);
        if (section.rounds.empty()) return;
        auto const shown = std::min(section.rounds.size(), most_lines);
        html.folded_subsection("Rounds", section.rounds.size() <= 20 ? report::HtmlFold::open : report::HtmlFold::closed, [&] {
            html.table({"round", "chapter", "tiles", "done after it", "splats held", "refused", "nearest frontier", "farthest frontier", "ms"},
                       {section.rounds.begin(), section.rounds.begin() + static_cast<std::ptrdiff_t>(shown)});
            html.paragraph((shown < section.rounds.size() ? "The first " + thousands(shown) + " of " + thousands(section.rounds.size()) + " rounds. " : "") +
                           "Tiles: those that were not done when the round began. A tile's frontier is the depth, in world units, up to which its "
                           "pixels are exact after the round; of a tile with every splat, it is the depth of the farthest one. " +
                           frame_file(section.frame, rounds_end) + " has a line for each of these tiles.");
        });
    };
    for (auto const& section : sections_) {
        auto run = section.run;
        if (frames_ == 1) {
            run.lead.clear(); // the page begins with it
            html.section(section.heading);
            add(section, run);
        } else {
            html.folded_section(section.heading, section.frame == slowest_ ? report::HtmlFold::open : report::HtmlFold::closed,
                                [&] { add(section, run); });
        }
    }
    if (sections_.size() < frames_)
        html.paragraph("The first " + thousands(sections_.size()) + " of " + thousands(frames_) +
                       " frames are shown in full, so that a browser can open this page; the others' files are beside it.");
}

void TraceOutput::add_run(report::HtmlReport& html, report::RunReport const& run) const
{
    Pairs facts = {{"map", run.map.name + ", " + plural(run.map.gaussians, "Gaussian")},
                   {"machine", run.machine.name + ", " + thousands(run.machine.sram_bytes) + " bytes of SRAM a tile, " +
                                   thousands(run.machine.storage_slots) + " slots of storage and " +
                                   thousands(run.machine.channel_slots) + " of a bloom channel"},
                   {"preset", run.preset},
                   {"program", report::to_string(run.program)},
                   {"policies", "routing " + run.policies.routing + ", addressing " + run.policies.addressing +
                                    ", saturation " + run.policies.saturation + ", footprint " + run.policies.footprint +
                                    ", copies " + run.policies.copies + ", pixels " + run.policies.pixels +
                                    ", arithmetic " + run.policies.arithmetic + ", hops " +
                                    (run.policies.hops == 0 ? "until quiet" : std::to_string(run.policies.hops))},
                   {"cut-offs", "quality " + run.quality + ": alpha_min " + report::significant(run.cut_offs.alpha_min, 3) +
                                    ", transmittance_min " + report::significant(run.cut_offs.transmittance_min, 3) +
                                    ", alpha_max " + report::significant(run.cut_offs.alpha_max, 3)},
                   {"cost model", model_.name + ", " + thousands(model_.clock_khz) + " kHz (model.txt)"},
                   {"frames", thousands(frames_)}};
    if (energy_model_) facts.emplace_back("energy model", energy_model_->name);
    for (auto const* notes : {&run.map.notes, &run.notes})
        for (auto const& note : *notes) facts.emplace_back("note", note);
    html.section("The run").key_values(facts);
    html.paragraph(tilemesh::modelled_text);
}

void TraceOutput::finish(report::RunReport const& run) const
{
    if (followed_ != 0) write(follow_file(followed_), follow_csv_);
    auto counters = report::csv_header() + "\n";
    for (auto const& frame : run.frames) counters += report::csv_row(frame.report) + "\n";
    write(counters_file, counters);
    report::HtmlReport html("Map " + run.map.name + " on " + run.machine.name);
    add_frames(html);
    if (followed_ != 0) {
        html.section("The life of Gaussian " + std::to_string(followed_));
        html.table({"frame", "anchor tile", "copies", "hops", "copies sent", "refusals"}, lives_);
        html.table({"seen", "frame", "superstep", "kernel", "tile", "side", ""}, seen_);
        html.paragraph(
            (seen_.size() < sights_ ? "The first " + thousands(seen_.size()) + " of " : std::string("All ")) +
            thousands(sights_) + " lines of " + follow_file(followed_) +
            ": what is new on a tile after a superstep, and every "
            "refusal. anchored, copy and leaving: stored on the tile; waiting: in a FIFO; road and beam: sent to the tile, "
            "from that side; owed: a copy that could not be sent to that side; refused: one that was given up; dropped: it came to the tile, from that side, and storage was "
            "full (a record that is handed back to the host comes again with the next view); left: no longer on the tile.");
    }
    add_run(html, run);
    tilemesh::add_ledger(html, run.machine.ledger, run.machine.sram_bytes);
    add_parameters(html, model_, counted_);
    if (energy_model_) {
        add_parameters(html, *energy_model_);
        html.paragraph("Joules are the counts of the trace and of the cost model's cycles times these numbers. A pair counts as if "
                       "each worker of a tile had as many as its slowest; the map of pairs has those evaluated. What no event "
                       "stands for is not in the joules, and what these numbers are worth is for their sources to say.");
    }
    Rows rows;
    for (std::size_t i = 0; i < std::size(operation_meanings); ++i) rows.push_back({tilemesh::splat::Operation::names[i], operation_meanings[i]});
    html.folded_section("What the operations mean", report::HtmlFold::closed, [&] { html.table({"operation", "meaning"}, rows); });
    rows.clear();
    for (auto const& field : report::report_fields)
        rows.push_back({std::string(field.name), std::string(field.unit), std::string(field.meaning)});
    html.folded_section("What the counters mean", report::HtmlFold::closed, [&] { html.table({"name in report.json", "unit", "meaning"}, rows); });
    write(page_file, html.str());
}

} // namespace render_map
