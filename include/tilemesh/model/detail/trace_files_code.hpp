#pragma once
#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <tilemesh/model/detail/trace_reading.hpp>
#include <tilemesh/model/exchange.hpp>
#include <tilemesh/model/trace_files.hpp>
#include <tilemesh/report/json_text.hpp>

namespace tilemesh { inline namespace v0_2 {
namespace model_detail {

/// Writes text to a stream in pieces of 64 KiB, which needs few calls and little memory. Numbers are plain decimals.
class TextStream {
public:
    explicit TextStream(std::ostream& out) : out_(out) {}
    TextStream& operator<<(std::string_view text)
    {
        text_ += text;
        if (text_.size() >= 65'536) flush();
        return *this;
    }
    TextStream& operator<<(std::uint64_t number)
    {
        std::array<char, 20> digits{}; // 2^64 has 20 digits
        auto const end = std::to_chars(digits.data(), digits.data() + digits.size(), number);
        return *this << std::string_view(digits.data(), static_cast<std::size_t>(end.ptr - digits.data()));
    }
    void flush()
    {
        out_.write(text_.data(), static_cast<std::streamsize>(text_.size()));
        text_.clear();
    }

private:
    std::ostream& out_;
    std::string text_;
};

template <class Quote>
std::vector<std::string> quoted_kernels(Trace const& trace, Quote quote)
{
    std::vector<std::string> out;
    for (auto const& kernel : trace.kernels) out.push_back(quote(kernel));
    return out;
}

TILEMESH_HOST std::string csv_field(std::string_view text)
{
    if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
    std::string out = "\"";
    for (char const c : text) out += c == '"' ? "\"\"" : std::string(1, c);
    return out + '"';
}

TILEMESH_HOST void write_tile_lines(std::ostream& out, Trace const& trace, StepPrices const* prices, Grid grid)
{
    check_trace(trace, grid);
    auto const kernels = quoted_kernels(trace, csv_field);
    OperationColumns const columns(trace);
    std::vector<std::uint32_t> counts(columns.names.size());
    TextStream text(out);
    text << "superstep,step,kernel,tile_x,tile_y";
    for (auto const& name : columns.names) text << "," << csv_field(name);
    text << ",north_bytes,east_bytes,west_bytes,south_bytes,settled_bytes" << (prices != nullptr ? ",compute_cycles\n" : "\n"); // as `news`
    for (std::size_t i = 0; i < trace.supersteps.size(); ++i) {
        auto const& s = trace.supersteps[i];
        for (auto const& t : s.tiles) {
            auto const at = grid.tile(t.tile);
            text << i << "," << s.step << "," << kernels[s.step] << "," << at.x() << "," << at.y();
            std::fill(counts.begin(), counts.end(), 0u);
            for (std::size_t kind = 0; kind < operations_of_step(trace, s.step).size(); ++kind)
                counts[columns.of_step[s.step][kind]] = t.operations.count[kind];
            for (auto const count : counts) text << "," << count;
            for (auto const bytes : t.sent_bytes) text << "," << bytes;
            text << "," << t.operations.settled_bytes;
            if (prices != nullptr) text << "," << prices->compute_cycles(i, t.operations);
            text << "\n";
        }
    }
    text.flush();
}

} // namespace model_detail

TILEMESH_HOST void write_trace_csv(std::ostream& out, Trace const& trace, CostModel const& model, Grid grid)
{
    model_detail::expect_sums_fit(model);
    model_detail::check_trace(trace, grid);
    model_detail::StepPrices const prices(model, trace);
    model_detail::write_tile_lines(out, trace, &prices, grid);
}

TILEMESH_HOST void write_trace_csv(std::ostream& out, Trace const& trace, Grid grid)
{
    model_detail::write_tile_lines(out, trace, nullptr, grid);
}

TILEMESH_HOST void write_step_csv(std::ostream& out, Trace const& trace, CostModel const& model, Grid grid)
{
    using namespace model_detail;
    check_trace(trace, grid);
    auto const kernels = quoted_kernels(trace, csv_field);
    auto const cost = model_cost(model, trace, grid);
    TextStream text(out);
    text << "superstep,step,kernel,tiles_run,compute_cycles,exchange_cycles,sync_cycles,vote_cycles,slowest_x,slowest_y";
    bool const chips = model.chips.columns != 0;
    text << (chips ? ",crossing_bytes,crossing_cycles,bound_by\n" : ",bound_by\n");
    for (std::size_t i = 0; i < cost.supersteps.size(); ++i) {
        auto const& c = cost.supersteps[i];
        text << i << "," << c.step << "," << kernels[c.step] << "," << trace.supersteps[i].tiles.size() << "," << c.compute << ","
             << c.exchange << "," << c.sync << "," << c.vote << ",";
        if (c.compute != 0) text << grid.tile(c.slowest).x() << "," << grid.tile(c.slowest).y();
        else text << ",";
        if (chips) text << "," << c.crossing_bytes << "," << c.crossing;
        text << "," << bound_text(c, grid) << "\n";
    }
    text.flush();
}

TILEMESH_HOST void write_chrome_trace(std::ostream& out, Trace const& trace, CostModel const& model, Grid grid, std::uint32_t busiest)
{
    using namespace model_detail;
    check_trace(trace, grid);
    if (model.clock_khz == 0 || model.clock_khz > most_clock_khz)
        throw Error("cannot lay the trace over time (the clock of model \"" + model.name + "\" is " +
                    std::to_string(model.clock_khz) + " kHz); give it one from 1 to " + std::to_string(most_clock_khz) + " kHz");
    auto const cost = model_cost(model, trace, grid);

    // The busiest tiles, and the track of each tile: 0 if it has none.
    std::vector<std::uint64_t> busy(grid.size(), 0);
    for (auto const& step : cost.busy)
        for (std::uint32_t tile = 0; tile < grid.size(); ++tile) busy[tile] += step[tile];
    std::vector<std::uint32_t> shown;
    for (std::uint32_t tile = 0; tile < grid.size(); ++tile)
        if (busy[tile] != 0) shown.push_back(tile);
    std::sort(shown.begin(), shown.end(), [&](std::uint32_t a, std::uint32_t b) { return busy[a] != busy[b] ? busy[a] > busy[b] : a < b; });
    shown.resize(std::min<std::size_t>(shown.size(), busiest));
    constexpr std::uint32_t process = 1, steps = 1, machine = 2; // for Perfetto, 0 is the idle process
    auto const rounds = loop_rounds(trace);
    std::vector<std::uint32_t> round_track(trace.loops.size(), 0);
    std::uint32_t last_track = machine;
    for (auto const& round : rounds)
        if (round_track[round.loop] == 0) round_track[round.loop] = ++last_track;
    auto const loops_shown = last_track - machine;
    std::vector<std::uint32_t> track(grid.size(), 0);
    for (auto const tile : shown) track[tile] = ++last_track;

    TextStream text(out);
    bool first = true;
    auto const begin_event = [&](char const* phase, std::uint32_t tid) -> TextStream& {
        text << (first ? "\n" : ",\n") << "{\"ph\":\"" << phase << "\",\"pid\":" << process << ",\"tid\":" << tid;
        first = false;
        return text;
    };
    auto const nanoseconds = [khz = model.clock_khz](std::uint64_t cycles) { // a sum of two parts, neither of which overflows
        return cycles / khz * 1'000'000 + cycles % khz * 1'000'000 / khz;
    };
    auto const microseconds = [](std::uint64_t ns) {
        auto const part = std::to_string(1000 + ns % 1000);
        return std::to_string(ns / 1000) + "." + part.substr(1);
    };
    // Writes an event up to the first members of its `args`: the superstep and the cycles.
    auto const begin_span = [&](std::uint32_t tid, std::string_view name, std::size_t superstep, std::uint64_t from, std::uint64_t cycles) {
        auto const begin = nanoseconds(from), end = nanoseconds(from + cycles);
        begin_event("X", tid) << ",\"ts\":" << microseconds(begin) << "25,\"dur\":" << microseconds(end - begin)
                              << ",\"name\":" << name << ",\"args\":{\"superstep\":" << superstep << ",\"cycles\":" << cycles;
    };
    auto const tile_name = [grid](std::uint32_t tile) {
        return "\"tile " + std::to_string(grid.tile(tile).x()) + ", " + std::to_string(grid.tile(tile).y()) + "\"";
    };

    text << "{\"displayTimeUnit\":\"ns\",\"traceEvents\":[";
    begin_event("M", steps) << ",\"name\":\"process_name\",\"args\":{\"name\":" << report::json_string(model.name) << "}}";
    auto const name_track = [&](std::uint32_t tid, std::string_view name) {
        begin_event("M", tid) << ",\"name\":\"thread_name\",\"args\":{\"name\":" << name << "}}";
        begin_event("M", tid) << ",\"name\":\"thread_sort_index\",\"args\":{\"sort_index\":" << tid << "}}";
    };
    name_track(steps, "\"steps\"");
    name_track(machine, "\"machine\"");
    for (std::size_t l = 0; l < round_track.size(); ++l) {
        if (round_track[l] == 0) continue;
        auto const of_step = [&](std::uint32_t step) { return step_names(trace)[step]; };
        name_track(round_track[l], loops_shown == 1 ? "\"rounds\""
                                                    : report::json_string("rounds of " + of_step(trace.loops[l].first) +
                                                                          " to " + of_step(trace.loops[l].last)));
    }
    for (auto const tile : shown) name_track(track[tile], tile_name(tile));

    auto const kernels = quoted_kernels(trace, report::json_string);
    std::vector<std::string> names;
    for (auto const& name : step_names(trace)) names.push_back(report::json_string(name));
    std::vector<std::uint64_t> begins{0}; // of each superstep
    for (auto const& c : cost.supersteps) begins.push_back(begins.back() + c.total());
    for (auto const& round : rounds) {
        auto const cycles = begins[round.last + 1] - begins[round.first];
        if (cycles == 0) continue;
        begin_span(round_track[round.loop],
                   "\"round " + std::to_string(round.number) + " of " + std::to_string(trace.loops[round.loop].rounds) + "\"", round.first,
                   begins[round.first], cycles);
        text << ",\"passes\":" << round.last - round.first + 1 << "}}";
    }
    StepPrices const prices(model, trace);
    std::uint64_t now = 0, cycles_of_step = 0;
    std::size_t passes_of_step = 0;
    for (std::size_t i = 0; i < cost.supersteps.size(); ++i) {
        auto const& s = trace.supersteps[i];
        auto const& c = cost.supersteps[i];
        cycles_of_step += c.total(), ++passes_of_step;
        if (i + 1 == cost.supersteps.size() || cost.supersteps[i + 1].step != c.step) {
            if (cycles_of_step != 0) {
                begin_span(steps, names[c.step], i + 1 - passes_of_step, now + c.total() - cycles_of_step, cycles_of_step);
                text << ",\"step\":" << c.step << ",\"passes\":" << passes_of_step << "}}";
            }
            cycles_of_step = 0, passes_of_step = 0;
        }
        for (auto const& t : s.tiles) {
            auto const cycles = prices.compute_cycles(i, t.operations);
            if (track[t.tile] == 0 || cycles == 0) continue;
            begin_span(track[t.tile], names[c.step], i, now, cycles);
            auto const& operations = operations_of_step(trace, s.step);
            for (std::size_t kind = 0; kind < operations.size(); ++kind)
                if (auto const count = t.operations.count[kind]; count != 0) text << "," << report::json_string(operations[kind]) << ":" << count;
            if (auto const bytes = all_sent(t); bytes != 0) text << ",\"sent_bytes\":" << bytes;
            text << "}}";
        }
        auto const phase = [&](std::string_view name, std::uint64_t cycles) {
            if (cycles == 0) return;
            begin_span(machine, name, i, now, cycles);
            text << ",\"step\":" << c.step << ",\"kernel\":" << kernels[c.step] << ",\"tiles_run\":" << s.tiles.size();
            if (c.compute != 0) text << ",\"slowest\":" << tile_name(c.slowest);
            if (c.crossing_bytes != 0 && name == "\"exchange\"")
                text << ",\"crossing_bytes\":" << c.crossing_bytes << ",\"crossing_cycles\":" << c.crossing;
            text << "}}";
            now += cycles;
        };
        phase("\"compute\"", c.compute);
        phase("\"exchange\"", c.exchange);
        phase("\"sync\"", c.sync);
        phase("\"vote\"", c.vote);
    }
    text << "\n]}\n";
    text.flush();
}

TILEMESH_HOST std::vector<double> heat_map(Trace const& trace, CostModel const& model, Grid grid, TileSum what)
{
    model_detail::check_trace(trace, grid);
    if (what == TileSum::channel_fill) {
        std::vector<double> most(grid.size(), 0);
        for (auto const& s : trace.supersteps) {
            if (s.capacity_bytes == 0) continue;
            for (auto const& t : s.tiles)
                for (Direction d : news)
                    if (auto const bytes = t.sent_bytes[index(d)]; bytes != 0)
                        most[t.tile] = std::max(most[t.tile], static_cast<double>(bytes) / static_cast<double>(s.capacity_towards(d)));
        }
        return most;
    }
    std::vector<std::uint64_t> sums(grid.size(), 0);
    if (what == TileSum::busy_cycles || what == TileSum::idle_cycles) {
        auto const cost = model_cost(model, trace, grid);
        std::uint64_t compute = 0;
        for (auto const& c : cost.supersteps) compute += c.compute;
        for (std::uint32_t tile = 0; tile < grid.size(); ++tile) {
            for (auto const& step : cost.busy) sums[tile] += step[tile];
            if (what == TileSum::idle_cycles) sums[tile] = compute - sums[tile];
        }
    } else {
        for (auto const& s : trace.supersteps)
            for (auto const& t : s.tiles)
                sums[t.tile] += what == TileSum::sent_bytes      ? model_detail::all_sent(t)
                                : what == TileSum::settled_bytes ? t.operations.settled_bytes
                                                                 : 1;
    }
    return {sums.begin(), sums.end()};
}

TILEMESH_HOST std::vector<double> heat_map(Trace const& trace, Grid grid, std::string_view operation)
{
    model_detail::check_trace(trace, grid);
    model_detail::OperationColumns const columns(trace);
    auto const column = static_cast<std::size_t>(std::find(columns.names.begin(), columns.names.end(), operation) - columns.names.begin());
    if (column == columns.names.size()) {
        std::string all;
        for (auto const& name : columns.names) all += (all.empty() ? "" : ", ") + name;
        throw Error("no heat map of operation " + std::string(operation) + " (the program's kernels count " +
                    (all.empty() ? "none" : all) + "); name one of these");
    }
    std::vector<double> out(grid.size(), 0);
    for (auto const& s : trace.supersteps)
        for (std::size_t kind = 0; kind < model_detail::operations_of_step(trace, s.step).size(); ++kind)
            if (columns.of_step[s.step][kind] == column)
                for (auto const& t : s.tiles) out[t.tile] += t.operations.count[kind];
    return out;
}

}} // namespace tilemesh
