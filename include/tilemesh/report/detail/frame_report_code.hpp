#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <ostream>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/table.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

TILEMESH_HOST std::string numbers_of(FrameReport const& r, std::string_view line)
{
    std::string out;
    for (auto const& field : report_fields)
        if (field.exact() && field.line == line) out += (out.empty() ? "" : ", ") + thousands(field.count(r)) + " " + std::string(field.phrase);
    if (line != report_field("lost").line || r.lost.empty()) return out;
    std::string separator = " (";
    for (std::uint32_t cause = 0; cause < causes; ++cause) {
        auto const n = r.losses(Cause{cause});
        if (n == 0) continue;
        out.append(separator).append(thousands(n)).append(" ").append(to_string(Cause{cause}));
        separator = ", ";
    }
    return out + ")";
}

TILEMESH_HOST std::ostream& operator<<(std::ostream& out, FrameReport const& r)
{
    auto const hundredths_of = [](double v) { return static_cast<std::uint64_t>(v * 100 + 0.5); };
    auto const ms = [](std::uint64_t hundredths) {
        auto const fraction = hundredths % 100;
        return std::to_string(hundredths / 100) + (fraction < 10 ? ".0" : ".") + std::to_string(fraction);
    };
    Table stages{{"stage", "passes", "exchanges", "host ms"}};
    std::uint64_t listed = 0; // hundredths of a millisecond
    for (auto const& time : report_fields) {
        if (time.group() != "host_ms") continue;
        bool const all = time.leaf() == "total";
        auto const sum = [&](std::string const& group) { return thousands(total(r, all ? group : group + "." + std::string(time.leaf()))); };
        auto const spent = hundredths_of(time.milliseconds(r));
        if (all) stages.add_row({"other", "0", "0", ms(spent > listed ? spent - listed : 0)}); // checks, lists of losses, counts
        listed += spent;
        stages.add_row({all ? "frame" : std::string(time.leaf()), sum("passes"), sum("exchanges"), ms(spent)});
    }
    out << stages;
    for (auto const line : text_lines)
        if (has_line(r, line)) out << line << ": " << numbers_of(r, line) << '\n';
    if (!r.unfinished.empty()) {
        auto const& least = nearest_cut(r);
        out << "unfinished: " << thousands(r.unfinished.size()) << (r.unfinished.size() == 1 ? " tile" : " tiles")
            << ", the nearest cut on tile " << least.tile << ": it is exact up to depth " << least.depth << '\n';
    }
    if (auto const& full = r.full_tiles)
        out << "full tiles: " << thousands(full->count) << ", most of all tile " << full->fullest << ": it needs "
            << thousands(full->slots_needed) << " slots and has " << thousands(full->slots_available) << '\n';
    return out;
}

TILEMESH_HOST char const* to_string(Cause cause) noexcept
{
    static constexpr auto names = [] { // the leaves of "losses", which are in the order of the causes
        std::array<char const*, causes> words{};
        std::size_t n = 0;
        for (auto const& field : report_fields)
            if (field.group() == "losses") words[n++] = field.leaf().data();
        return words;
    }();
    return names[static_cast<std::uint32_t>(cause)];
}

TILEMESH_HOST std::uint64_t FrameReport::losses(Cause cause) const noexcept
{
    std::uint64_t n = 0;
    for (auto const& loss : lost) n += loss.cause == cause ? 1u : 0u;
    return n;
}

TILEMESH_HOST std::uint64_t total(FrameReport const& r, std::string_view path) noexcept
{
    std::uint64_t n = 0;
    for (auto const& field : report_fields)
        if (field.is_in(path) && field.exact()) n += field.count(r);
    return n;
}

TILEMESH_HOST bool has_line(FrameReport const& r, std::string_view line) noexcept
{
    return line != "homes" || r.program == Program::homes;
}

TILEMESH_HOST UnfinishedTile const& nearest_cut(FrameReport const& r) noexcept
{
    return *std::min_element(r.unfinished.begin(), r.unfinished.end(), [](auto const& a, auto const& b) { return a.depth < b.depth; });
}

}}} // namespace tilemesh::v0_2::report
