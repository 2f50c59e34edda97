#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <tilemesh/report/detail/plot_code.hpp>
#include <tilemesh/report/stacked_bars.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {
namespace detail {

TILEMESH_HOST std::string shortened(std::string_view text, std::size_t most)
{
    if (text.size() <= most || most < 8) return std::string(text);
    auto const inside = [&](std::size_t at) { return (static_cast<unsigned char>(text[at]) & 0xc0u) == 0x80; };
    std::size_t front = (most - 3) * 2 / 3, back = text.size() - (most - 3 - front);
    while (front > 0 && inside(front)) --front;
    while (back < text.size() && inside(back)) ++back;
    return std::string(text.substr(0, front)) + "..." + std::string(text.substr(back));
}

TILEMESH_HOST void stack_flags(std::vector<SpanFlag>& flags, std::size_t most_rows)
{
    for (std::size_t i = flags.size(); i-- > 0;) {
        flags[i].row = 0;
        double const end = flags[i].at_px + 6.5 * static_cast<double>(flags[i].name.size()) + 8;
        std::size_t j = i + 1;
        for (; j < flags.size() && flags[j].at_px < end; ++j) flags[i].row = std::max(flags[i].row, flags[j].row + 1);
        if (flags[i].row < most_rows) continue;
        auto const at = [&](std::size_t flag) { return flags.begin() + static_cast<std::ptrdiff_t>(flag); };
        flags.erase(std::min_element(at(i), at(j), [](SpanFlag const& a, SpanFlag const& b) { return a.width_px < b.width_px; }));
        i = flags.size(); // again from the last
    }
}

} // namespace detail

TILEMESH_HOST std::string svg(StackedBars const& chart)
{
    using detail::plot_number;
    using detail::plot_text;
    if (chart.width < 320 || chart.height < 200)
        throw Error("bars on " + std::to_string(chart.width) + " x " + std::to_string(chart.height) +
                    " pixels (axes and legend take 320 x 200); choose a larger picture");
    double highest = 0, along = 0;
    std::size_t longest_name = 0, longest_note = 0, longest_part = 0;
    for (auto const& bar : chart.bars) {
        double sum = 0;
        bool good = bar.values.size() == chart.parts.size() && std::isfinite(bar.width) && bar.width >= 0;
        for (double const v : bar.values) {
            good = good && std::isfinite(v) && v >= 0;
            sum += v;
        }
        if (!good || !std::isfinite(sum) || !std::isfinite(along + bar.width))
            throw Error("bar \"" + bar.name + "\" cannot be drawn (it has another number of values than " + std::to_string(chart.parts.size()) +
                        ", or one or a width that is negative or not finite); correct it");
        highest = std::max(highest, sum);
        along += bar.width;
        longest_name = std::max(longest_name, bar.name.size());
        longest_note = std::max(longest_note, bar.note.size());
    }
    double spanned = 0;
    for (auto const& span : chart.spans) {
        if (!std::isfinite(span.width) || span.width < 0 || !std::isfinite(spanned + span.width))
            throw Error("span \"" + span.name + "\" cannot be drawn (its width is negative or not finite); correct it");
        spanned += span.width;
    }

    // Room for the legend and the labels, as in a Plot; for the names of rows, at most 40 letters of them; a row is 26 pixels high.
    bool const rows = chart.layout == BarLayout::rows;
    constexpr double row_px = 26;
    std::size_t const most_letters = std::min<std::size_t>(40, chart.width / 20);
    for (auto const& part : chart.parts) longest_part = std::max(longest_part, part.name.size());
    double const legend = std::min(40 + 6.5 * static_cast<double>(longest_part), 0.45 * chart.width);
    double const left = rows ? 20 + 6.5 * static_cast<double>(std::min(longest_name, most_letters)) : 84;
    double const right = std::max(chart.width - legend - 8, left + 40);
    double const notes = rows && longest_note != 0 ? std::min(10 + 6.5 * static_cast<double>(longest_note), (right - left) / 2) : 0;
    PlotAxis const values{"", PlotScale::linear, 0.0, chart.y_high}, across{"", PlotScale::linear, 0.0, along > 0 ? along : 1};
    detail::PlotRange const x = rows ? detail::PlotRange(values, "x", 0, highest > 0 ? highest : 1, left, right - notes)
                                     : detail::PlotRange(across, "x", 0, along, left, right);

    // The names of spans stand above the area, the row next to it first.
    std::vector<detail::SpanFlag> flags;
    double from = 0;
    for (auto const& span : chart.spans) {
        if (!rows && !span.name.empty() && from < along) {
            auto const at = x.px(from + span.width / 2);
            // A name ends at the picture's edge; it has 8 letters at least.
            auto const letters = static_cast<std::size_t>(std::max((chart.width - 12 - at) / 6.5, 8.0));
            flags.push_back({detail::shortened(span.name, std::min<std::size_t>(letters, 40)), at, x.px(from + span.width) - x.px(from)});
        }
        from += span.width;
    }
    detail::stack_flags(flags, 8);
    double flag_px = chart.spans.empty() || rows ? 0 : 14;
    for (auto const& flag : flags) flag_px = std::max(flag_px, 16 * static_cast<double>(flag.row) + 30);
    double const top = 36 + flag_px;
    double const bottom = rows ? top + row_px * static_cast<double>(std::max<std::size_t>(chart.bars.size(), 1)) + 6 : chart.height - 52.0 + flag_px;
    detail::PlotRange const y(values, "y", 0, highest > 0 ? highest : 1, bottom, top);
    auto const height = static_cast<std::uint32_t>(std::ceil(std::max(bottom + 52, top + 18 * static_cast<double>(chart.parts.size()))));

    std::string out;
    auto const number = [](double v) { return plot_number(v, 2); };
    auto const line = [&](double x0, double y0, double x1, double y1, char const* stroke) {
        out += "<line x1=\"" + number(x0) + "\" y1=\"" + number(y0) + "\" x2=\"" + number(x1) + "\" y2=\"" + number(y1) +
               "\" stroke=\"" + stroke + "\"/>\n";
    };
    auto const text = [&](double at_x, double at_y, std::string const& more, std::string const& what) {
        out += "<text x=\"" + number(at_x) + "\" y=\"" + number(at_y) + "\"" + more + ">" + plot_text(what) + "</text>\n";
    };
    auto const box = [&](double at_x, double at_y, double w, double h, std::string const& colour) {
        out += "<rect x=\"" + number(at_x) + "\" y=\"" + number(at_y) + "\" width=\"" + number(w) + "\" height=\"" + number(h) +
               "\" fill=\"" + colour + "\"/>\n";
    };
    auto const colour_of = [&](std::size_t part) {
        return std::string(detail::plot_colours[chart.parts[part].colour % detail::plot_colours.size()]);
    };
    std::string const middle = " text-anchor=\"middle\"", end = " text-anchor=\"end\"";
    auto const size = "width=\"" + std::to_string(chart.width) + "\" height=\"" + std::to_string(height) + "\"";
    out += "<svg xmlns=\"http://www.w3.org/2000/svg\" " + size + " viewBox=\"0 0 " + std::to_string(chart.width) + " " +
           std::to_string(height) + "\" font-family=\"sans-serif\" font-size=\"12\">\n<rect " + size + " fill=\"#ffffff\"/>\n";
    text(8, 20, " font-size=\"15\"", chart.title); // on the left: in sight where a narrow window shows the left part
    for (auto const& tick : x.ticks()) {
        if (rows) line(x.px(tick.at), top, x.px(tick.at), bottom, "#dddddd");
        text(x.px(tick.at), bottom + 16, middle, tick.text);
    }
    if (!rows)
        for (auto const& tick : y.ticks()) {
            line(left, y.px(tick.at), right, y.px(tick.at), "#dddddd");
            text(left - 6, y.px(tick.at) + 4, end, tick.text);
        }

    // Bars, cut at the end of the axis.
    double const last = chart.y_high.value_or(std::numeric_limits<double>::infinity());
    from = 0;
    for (std::size_t i = 0; i < chart.bars.size(); ++i) {
        auto const& bar = chart.bars[i];
        double const row = top + 6 + row_px * static_cast<double>(i);
        double base = 0;
        for (std::size_t p = 0; p < bar.values.size() && base < last; ++p) {
            if (bar.values[p] == 0) continue;
            double const begins = base;
            base += bar.values[p];
            double const ends = std::min(base, last);
            if (rows) box(x.px(begins), row, x.px(ends) - x.px(begins), row_px - 8, colour_of(p));
            else box(x.px(from), y.px(ends), x.px(from + bar.width) - x.px(from), y.px(begins) - y.px(ends), colour_of(p));
        }
        if (rows) {
            text(left - 8, row + 13, end, detail::shortened(bar.name, most_letters));
            if (!bar.note.empty()) text(x.px(std::min(base, last)) + 6, row + 13, "", bar.note);
        }
        from += bar.width;
    }

    // Spans: bands of two greys, and a line from each name to its band.
    from = 0;
    for (std::size_t i = 0; i < chart.spans.size() && !rows; ++i) {
        double const begins = std::min(from, along), ends = std::min(from + chart.spans[i].width, along);
        if (begins < ends) box(x.px(begins), top - 10, x.px(ends) - x.px(begins), 6, i % 2 == 0 ? "#444444" : "#aaaaaa");
        from += chart.spans[i].width;
    }
    for (auto const& flag : flags) {
        double const base = top - 16 - 16 * static_cast<double>(flag.row);
        line(flag.at_px, base - 9, flag.at_px, top - 10, "#666666");
        text(flag.at_px + 4, base, "", flag.name);
    }

    line(left, bottom, right - notes, bottom, "#000000");
    line(left, top, left, bottom, "#000000");
    text((left + right - notes) / 2, bottom + 38, middle, chart.x_label);
    if (!rows) text(16, (top + bottom) / 2, middle + " transform=\"rotate(-90 16 " + number((top + bottom) / 2) + ")\"", chart.y_label);
    for (std::size_t p = 0; p < chart.parts.size(); ++p) {
        double const row = top + 18 * static_cast<double>(p);
        out += "<rect x=\"" + number(right + 12) + "\" y=\"" + number(row) + "\" width=\"12\" height=\"12\" fill=\"" + colour_of(p) + "\"/>\n";
        text(right + 30, row + 10, "", chart.parts[p].name);
    }
    return out + "</svg>\n";
}

}}} // namespace tilemesh::report
