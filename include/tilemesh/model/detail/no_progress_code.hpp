#pragma once
#include <algorithm>
#include <iterator>
#include <tilemesh/engine/not_quiet.hpp>
#include <tilemesh/model/detail/trace_reading.hpp>
#include <tilemesh/model/no_progress.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 {

namespace model_detail {
inline std::uint64_t sample_hash(SuperstepSample const& s) noexcept
{
    std::uint64_t h = 14695981039346656037u; // FNV-1a, a word at a time
    auto const mix = [&](std::uint64_t word) { h = (h ^ word) * 1099511628211u; };
    mix(s.step);
    for (auto const& t : s.tiles) {
        mix(t.tile);
        for (auto const n : t.operations.count) mix(n);
        mix(t.operations.settled_bytes);
        for (auto const n : t.sent_bytes) mix(n);
    }
    return h;
}

/// Returns the smallest period with which the last supersteps repeat: at least twice, and at least `at_least` supersteps; 0: none. Sets
/// `repeating` to their number.
inline std::uint32_t find_period(SuperstepSample const* begin, SuperstepSample const* end, std::uint64_t at_least, std::uint64_t& repeating)
{
    auto const n = static_cast<std::size_t>(end - begin);
    std::vector<std::uint64_t> hashes;
    for (auto const* s = begin; s != end; ++s) hashes.push_back(sample_hash(*s));
    for (std::size_t p = 1; p <= most_period && 2 * p <= n; ++p) {
        std::size_t last = n; // from `last` on, each superstep equals the one a period before
        while (last > p && hashes[last - 1] == hashes[last - 1 - p]) --last;
        if (n - last < p || n - last + p < at_least) continue;
        if (!std::equal(begin + last, end, begin + (last - p))) continue; // different supersteps may have equal hashes
        repeating = n - last + p;
        return static_cast<std::uint32_t>(p);
    }
    return 0;
}

/// The sides to which a tile sent messages, as bits: more than a head, which is a channel's size and note.
inline std::uint8_t message_sides(TileSample const& t) noexcept
{
    constexpr std::uint32_t head_bytes = 8;
    unsigned sides = 0;
    for (Direction d : news) sides |= t.sent_bytes[index(d)] > head_bytes ? 1u << index(d) : 0u;
    return static_cast<std::uint8_t>(sides);
}

/// A closed walk along links; empty: there is none. `live`: for each tile the sides on which it sends, as bits.
inline std::vector<TileSide> find_cycle(Grid grid, std::vector<std::uint8_t> live, Edge edge)
{
    auto const to = [=](std::uint32_t tile, Direction d) { return grid.index_of(grid.neighbour(grid.tile(tile), d, edge)); };
    // Takes away links that lead nowhere, until each that is left leads to a tile that sends.
    std::vector<std::uint32_t> ends;
    for (std::uint32_t tile = 0; tile < live.size(); ++tile)
        if (live[tile] == 0) ends.push_back(tile);
    while (!ends.empty()) {
        auto const end = ends.back();
        ends.pop_back();
        for (Direction d : news) { // the tiles that may send to this tile
            auto const from = to(end, d);
            for (Direction side : news) {
                auto const bit = static_cast<std::uint8_t>(1u << index(side));
                if ((live[from] & bit) == 0 || to(from, side) != end) continue;
                live[from] = static_cast<std::uint8_t>(live[from] & ~bit);
                if (live[from] == 0) ends.push_back(from);
            }
        }
    }
    std::vector<TileSide> walk;
    auto const start = std::find_if(live.begin(), live.end(), [](std::uint8_t sides) { return sides != 0; });
    if (start == live.end()) return walk;
    constexpr std::uint32_t unseen = 0xffffffffu;
    std::vector<std::uint32_t> seen(live.size(), unseen);
    auto tile = static_cast<std::uint32_t>(start - live.begin());
    while (seen[tile] == unseen) {
        seen[tile] = static_cast<std::uint32_t>(walk.size());
        auto const side = *std::find_if(std::begin(news), std::end(news), [&](Direction d) { return (live[tile] >> index(d) & 1u) != 0; });
        walk.push_back({tile, side});
        tile = to(tile, side);
    }
    walk.erase(walk.begin(), walk.begin() + static_cast<std::ptrdiff_t>(seen[tile]));
    auto const lowest = std::min_element(walk.begin(), walk.end(), [](TileSide a, TileSide b) { return a.tile < b.tile; });
    std::rotate(walk.begin(), lowest, walk.end());
    return walk;
}
} // namespace model_detail

TILEMESH_HOST NoProgress no_progress(Trace const& trace, Grid grid, std::uint32_t at_least)
{
    model_detail::check_trace(trace, grid);
    NoProgress out;
    out.grid = grid;
    auto const& all = trace.supersteps;
    if (all.empty()) return out;
    auto const* const end = all.data() + all.size();
    auto const last_step = all.back().step;
    std::uint64_t repeating = 0;
    auto const find_in = [&](auto const& belongs) { // among the last supersteps that belong together
        out.supersteps = 0;
        while (out.supersteps < all.size() && belongs(*(end - 1 - out.supersteps))) ++out.supersteps;
        out.step = last_step;
        out.kernel = trace.kernels[last_step];
        out.period = model_detail::find_period(end - out.supersteps, end, std::max(at_least, 2u), repeating);
    };
    if (all.back().votes) find_in([&](SuperstepSample const& s) { return s.step == last_step && s.votes; });
    for (auto loop = trace.loops.rbegin(); out.period == 0 && loop != trace.loops.rend(); ++loop) {
        if (last_step < loop->first || last_step > loop->last) continue;
        out.loop = *loop;
        find_in([&](SuperstepSample const& s) { return s.step >= loop->first && s.step <= loop->last; });
    }
    if (out.period == 0) return out;
    out.first = all.size() - repeating;

    using model_detail::message_sides;
    struct Use {
        std::uint32_t supersteps = 0;
        std::uint64_t bytes = 0;
        bool notes_only = true, full = true;
    };
    std::vector<std::uint32_t> runs(grid.size(), 0);
    std::vector<std::uint8_t> live(grid.size(), 0);
    std::vector<Use> uses; // four for each listed tile
    std::vector<std::uint32_t> place(grid.size(), 0); // in `uses`, from 1
    for (auto const* s = end - out.period; s != end; ++s)
        for (auto const& t : s->tiles) {
            ++runs[t.tile];
            out.settled_bytes += t.operations.settled_bytes;
            if (model_detail::all_sent(t) == 0) continue;
            if (place[t.tile] == 0) {
                uses.resize(uses.size() + 4);
                place[t.tile] = static_cast<std::uint32_t>(uses.size() / 4);
            }
            for (Direction d : news) {
                auto const bytes = t.sent_bytes[index(d)];
                if (bytes == 0) continue;
                auto& use = uses[4 * std::size_t{place[t.tile] - 1} + index(d)];
                ++use.supersteps;
                use.bytes += bytes;
                use.full = use.full && bytes == s->capacity_towards(d);
                use.notes_only = use.notes_only && (message_sides(t) >> index(d) & 1u) == 0;
            }
            live[t.tile] = static_cast<std::uint8_t>(live[t.tile] | message_sides(t));
        }
    for (std::uint32_t tile = 0; tile < grid.size(); ++tile) {
        if (runs[tile] == out.period) {
            out.tiles.push_back(tile);
            if (live[tile] == 0) out.waiting.push_back(tile);
        }
        if (place[tile] == 0) continue;
        for (Direction d : news)
            if (auto const& use = uses[4 * std::size_t{place[tile] - 1} + index(d)]; use.supersteps != 0)
                out.links.push_back({{tile, d}, use.supersteps, use.bytes, use.notes_only, use.full});
    }
    out.cycle = model_detail::find_cycle(grid, live, all.back().edge);

    // Backwards to the last messages of the waiting tiles.
    std::vector<std::uint8_t> last(grid.size(), 0), asked(grid.size(), 0);
    for (auto const tile : out.waiting) asked[tile] = 1;
    for (auto left = out.waiting.size(), i = all.size(); left > 0 && i-- > 0;)
        for (auto const& t : all[i].tiles)
            if (asked[t.tile] != 0 && message_sides(t) != 0) {
                asked[t.tile] = 0;
                last[t.tile] = message_sides(t);
                --left;
            }
    for (auto const tile : out.waiting)
        for (Direction d : news)
            if ((last[tile] >> index(d) & 1u) != 0) out.sent_last.push_back({tile, d});
    out.wait_cycle = model_detail::find_cycle(grid, std::move(last), all.back().edge);
    return out;
}

TILEMESH_HOST std::string text_of(NoProgress const& report, std::size_t most)
{
    auto const number = [](std::uint64_t n, char const* one, char const* many) { return std::to_string(n) + " " + (n == 1 ? one : many); };
    if (report.supersteps == 0) return "the trace does not end with a step that runs until quiet\n";
    auto const step = report.loop ? tilemesh::text_of(*report.loop) : "step " + std::to_string(report.step) + " (" + report.kernel + ")";
    if (report.empty())
        return step + " repeats nothing in its last " + number(report.supersteps, "superstep", "supersteps") +
               ": it goes on, or its period is longer\n";

    auto const tile = [&](std::uint32_t i) {
        auto const t = report.grid.tile(i);
        std::string name = "("; // piece by piece, here and below: GCC 12 warns of a sum that begins with a literal (its bug 105651)
        name.append(std::to_string(t.x())).append(", ").append(std::to_string(t.y())).append(")");
        return name;
    };
    constexpr char const* sides[] = {" north", " east", " west", " south"};
    auto const link = [&](TileSide const& l) { return tile(l.tile) + sides[index(l.side)]; };
    auto const list = [&](auto const& items, auto const& name) {
        std::string out;
        for (std::size_t i = 0; i < items.size() && i < most; ++i) out.append(i == 0 ? "" : ", ").append(name(items[i]));
        return items.size() > most ? out + " and " + std::to_string(items.size() - most) + " more" : out;
    };
    std::vector<TileSide> messages, notes, full;
    for (auto const& use : report.links) {
        (use.notes_only ? notes : messages).push_back(use.link);
        if (use.full && !use.notes_only) full.push_back(use.link);
    }
    std::string out = step + " does the same every " + (report.period == 1 ? "superstep" : std::to_string(report.period) + " supersteps") +
                      " from superstep " + std::to_string(report.first) + " of the run on\n";
    if (!report.cycle.empty())
        out += "messages can go round " + number(report.cycle.size(), "tile", "tiles") + ": " + list(report.cycle, link) + "\n";
    if (messages.empty()) out += "no message moves\n";
    else out += number(messages.size(), "link carries", "links carry") + " messages: " + list(messages, link) + "\n";
    if (!full.empty()) out += number(full.size(), "of them is", "of them are") + " full each time: " + list(full, link) + "\n";
    if (!notes.empty()) out += number(notes.size(), "link carries", "links carry") + " notes alone: " + list(notes, link) + "\n";
    if (report.settled_bytes != 0) out += number(report.settled_bytes, "byte", "bytes") + " a period settle: this may be a steady stream\n";
    if (!report.waiting.empty())
        out += number(report.waiting.size(), "tile runs", "tiles run") + " in every superstep and send" + (report.waiting.size() == 1 ? "s" : "") +
               " no message (busy, or woken by mail; for whom they wait is not in a trace): " + list(report.waiting, tile) + "\n";
    if (!report.sent_last.empty())
        out += "the last messages of these tiles went over " + number(report.sent_last.size(), "link", "links") + ": " +
               list(report.sent_last, link) + "\n";
    if (!report.wait_cycle.empty())
        out += "a guess: if a tile waits for the tile to which it sent last, " +
               number(report.wait_cycle.size(), "tile waits for itself", "tiles wait for each other in a circle") + ": " +
               list(report.wait_cycle, link) + "\n";
    if (report.tiles.size() > report.waiting.size())
        out += number(report.tiles.size(), "tile runs", "tiles run") + " in every superstep: " + list(report.tiles, tile) + "\n";
    return out;
}

TILEMESH_HOST std::string explain_no_progress(Trace const& trace, Grid grid, std::uint32_t most_passes)
{
    return text_of(no_progress(trace, grid, std::min(most_passes, model_detail::repeated_at_least)));
}

}} // namespace tilemesh
