#pragma once
#include <cstdint>
#include <ostream>
#include <string>
#include <string_view>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

TILEMESH_HOST std::string numbers_of(FrameReport const& r, std::string_view line)
{
    std::string out;
    for (auto const& field : report_fields)
        if (field.exact() && field.line == line)
            out += (out.empty() ? "" : ", ") + thousands(field.count(r)) + " " + std::string(field.phrase);
    return out;
}

TILEMESH_HOST std::ostream& operator<<(std::ostream& out, FrameReport const& r)
{
    auto const ms = [](double v) {
        auto const hundredths = static_cast<std::uint64_t>(v * 100 + 0.5);
        auto const fraction = hundredths % 100;
        return std::to_string(hundredths / 100) + (fraction < 10 ? ".0" : ".") + std::to_string(fraction);
    };
    Table stages{{"stage", "supersteps", "host ms"}};
    for (auto const& time : report_fields) {
        if (time.group() != "host_ms") continue;
        bool const all = time.leaf() == "total";
        std::uint64_t supersteps = 0; // making the picture has none
        for (auto const& field : report_fields)
            if (field.group() == "supersteps" && (all || field.leaf() == time.leaf())) supersteps += field.count(r);
        stages.add_row({all ? "frame" : std::string(time.leaf()), thousands(supersteps), ms(time.milliseconds(r))});
    }
    out << stages;
    for (auto const line : text_lines) out << line << ": " << numbers_of(r, line) << '\n';
    return out;
}

}}} // namespace tilemesh::report
