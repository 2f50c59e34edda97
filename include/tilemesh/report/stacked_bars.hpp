#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/report/plot.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// A part that every bar has: its name and its colour.
struct BarPart {
    std::string name;
    std::uint32_t colour = 0; ///< as in PlotSeries
};

/// One bar: a value a part, stacked from the bottom.
struct Bar {
    std::string name;
    std::vector<double> values; ///< finite, 0 or above
    double width = 1;           ///< finite, 0 or above, on the x axis; only where bars lie along it
};

/// Where the bars are. `named`: side by side, each over its name. `along_x`: one after the other along an x axis that begins
/// at 0, each as wide as its `width`.
enum class BarLayout { named, along_x };

/// A diagram of stacked bars for a report, with a legend on the right.
struct StackedBars {
    std::string title;
    std::string x_label, y_label; ///< what and in which unit
    std::vector<BarPart> parts;
    std::vector<Bar> bars;
    BarLayout layout = BarLayout::named;
    std::optional<double> y_high{};          ///< above 0: where the y axis ends; higher bars are cut off there
    std::uint32_t width = 800, height = 320; ///< of the whole picture, in pixels; 320 x 200 or more
};

/// The bars as an SVG document of its own, as `svg` of a Plot gives it; the y axis begins at 0. Parts that are 0 are not
/// drawn. Throws `Error` for a picture under 320 x 200, an end of the axis that is not finite and above 0, and a bar with
/// another number of values than there are parts, or with a value or a width that is negative or not finite. Costs some 80
/// bytes a part of a bar.
inline std::string svg(StackedBars const& chart)
{
    using detail::plot_number;
    using detail::plot_text;
    if (chart.width < 320 || chart.height < 200)
        throw Error("bars on " + std::to_string(chart.width) + " x " + std::to_string(chart.height) +
                    " pixels (axes and legend take 320 x 200); choose a larger picture");
    double highest = 0, along = 0;
    for (auto const& bar : chart.bars) {
        double sum = 0;
        bool good = bar.values.size() == chart.parts.size() && std::isfinite(bar.width) && bar.width >= 0;
        for (double const v : bar.values) {
            good = good && std::isfinite(v) && v >= 0;
            sum += v;
        }
        if (!good || !std::isfinite(sum) || !std::isfinite(along + bar.width))
            throw Error("bar \"" + bar.name + "\" cannot be drawn (it has another number of values than " +
                        std::to_string(chart.parts.size()) +
                        ", or one or a width that is negative or not finite); correct it");
        highest = std::max(highest, sum);
        along += bar.width;
    }

    // Room for the legend and the labels, as in a Plot.
    std::size_t longest = 0;
    for (auto const& part : chart.parts) longest = std::max(longest, part.name.size());
    double const legend = std::min(40 + 6.5 * static_cast<double>(longest), 0.45 * chart.width);
    double const left = 84, right = chart.width - legend - 8, bottom = chart.height - 52.0, top = 36;
    bool const named = chart.layout == BarLayout::named;
    PlotAxis y_axis{chart.y_label, PlotScale::linear, 0.0, chart.y_high},
        x_axis{chart.x_label, PlotScale::linear, 0.0, along > 0 ? along : 1};
    detail::PlotRange const y(y_axis, "y", 0, highest > 0 ? highest : 1, bottom, top);
    detail::PlotRange const x(x_axis, "x", 0, along, left, right);

    std::string out;
    auto const number = [](double v) { return plot_number(v, 2); };
    auto const line = [&](double x0, double y0, double x1, double y1, char const* stroke) {
        out += "<line x1=\"" + number(x0) + "\" y1=\"" + number(y0) + "\" x2=\"" + number(x1) + "\" y2=\"" + number(y1) +
               "\" stroke=\"" + stroke + "\"/>\n";
    };
    auto const text = [&](double at_x, double at_y, std::string const& more, std::string const& what) {
        out += "<text x=\"" + number(at_x) + "\" y=\"" + number(at_y) + "\"" + more + ">" + plot_text(what) + "</text>\n";
    };
    std::string const middle = " text-anchor=\"middle\"";
    auto const size = "width=\"" + std::to_string(chart.width) + "\" height=\"" + std::to_string(chart.height) + "\"";
    out += "<svg xmlns=\"http://www.w3.org/2000/svg\" " + size + " viewBox=\"0 0 " + std::to_string(chart.width) + " " +
           std::to_string(chart.height) + "\" font-family=\"sans-serif\" font-size=\"12\">\n<rect " + size +
           " fill=\"#ffffff\"/>\n";
    text((left + right) / 2, 20, middle + " font-size=\"15\"", chart.title);
    for (auto const& tick : y.ticks()) {
        line(left, y.px(tick.at), right, y.px(tick.at), "#dddddd");
        text(left - 6, y.px(tick.at) + 4, " text-anchor=\"end\"", tick.text);
    }
    if (!named)
        for (auto const& tick : x.ticks()) text(x.px(tick.at), bottom + 16, middle, tick.text);

    double from = 0;
    double const end_of_y = chart.y_high.value_or(std::numeric_limits<double>::infinity());
    double const slot = (right - left) / static_cast<double>(std::max<std::size_t>(chart.bars.size(), 1));
    for (std::size_t i = 0; i < chart.bars.size(); ++i) {
        auto const& bar = chart.bars[i];
        double const begin = named ? left + slot * (static_cast<double>(i) + 0.15) : x.px(from);
        double const end = named ? begin + 0.7 * slot : x.px(from + bar.width);
        from += bar.width;
        double base = 0;
        for (std::size_t p = 0; p < bar.values.size(); ++p) {
            if (bar.values[p] == 0) continue;
            double const begins = base;
            base += bar.values[p];
            if (begins >= end_of_y) break;
            double const low = y.px(begins), high = y.px(std::min(base, end_of_y));
            out += "<rect x=\"" + number(begin) + "\" y=\"" + number(high) + "\" width=\"" + number(end - begin) +
                   "\" height=\"" + number(low - high) + "\" fill=\"" +
                   detail::plot_colours[chart.parts[p].colour % detail::plot_colours.size()] + "\"/>\n";
        }
        if (named) text((begin + end) / 2, bottom + 16, middle, bar.name);
    }
    line(left, bottom, right, bottom, "#000000");
    line(left, top, left, bottom, "#000000");
    text((left + right) / 2, bottom + 38, middle, chart.x_label);
    text(16, (top + bottom) / 2, middle + " transform=\"rotate(-90 16 " + number((top + bottom) / 2) + ")\"",
         chart.y_label);
    for (std::size_t p = 0; p < chart.parts.size(); ++p) {
        double const row = top + 18 * static_cast<double>(p);
        out += "<rect x=\"" + number(right + 12) + "\" y=\"" + number(row) + "\" width=\"12\" height=\"12\" fill=\"" +
               detail::plot_colours[chart.parts[p].colour % detail::plot_colours.size()] + "\"/>\n";
        text(right + 30, row + 10, "", chart.parts[p].name);
    }
    return out + "</svg>\n";
}

}}} // namespace tilemesh::report
