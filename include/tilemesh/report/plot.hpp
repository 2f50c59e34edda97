#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

enum class PlotScale { linear, logarithmic };

/// One axis of a plot. Without bounds it spans the finite values of all series, and a linear axis is widened to whole ticks.
struct PlotAxis {
    std::string label; ///< quantity and unit
    PlotScale scale = PlotScale::linear;
    std::optional<double> low{}, high{}; ///< finite, low < high, and above 0 on a logarithmic scale
};

/// The line between two neighbouring points: straight, a step at the value of the first point until the second point, or none
/// (dots only).
enum class PlotLine { straight, step, none };

/// Points that belong together, in the order in which lines join them. A point with y = +infinity (the PSNR of equal pictures) is on a
/// separate line above the others. A NaN, or -infinity, is a gap.
struct PlotSeries {
    std::string name;
    std::vector<std::pair<double, double>> points; ///< x and y; x must be finite
    PlotLine line = PlotLine::straight;
    std::uint32_t colour = 0; ///< one of eight colours that colour-blind readers can tell apart; 8 is the colour of 0
    bool dashed = false;      ///< its dots are rings
    bool faded = false;       ///< drawn at 60 % of its strength: a background for the other series
    double dot_px = 2.5;      ///< radius of its dots
};

/// A diagram for a report: title, axes with ticks, lines with dots, a legend on the right. If the lines of several series coincide from one
/// point to the next, dashes of their colours alternate. If dots coincide, the dot of the earlier series is larger.
struct Plot {
    std::string title;
    PlotAxis x, y;
    std::vector<PlotSeries> series;
    std::string infinity = "inf";            ///< the name of the line with infinite values
    std::uint32_t width = 800, height = 420; ///< size of the whole picture in pixels; at least 320 x 200
    bool equal_units = false;                ///< a unit is as long on both axes, which are linear; their limits follow from the points
};

/// The plot as a complete SVG document on white: no script, no style sheet, and only the reader's sans-serif font. Equal plots give equal
/// text. Throws `Error` for a picture under 320 x 200, bounds that are not finite or not in order, an x that is not finite, and a value of
/// 0 or below on a logarithmic scale. Cost: about 60 bytes per point.
TILEMESH_HOST std::string svg(Plot const& plot);

/// Writes `svg(plot)` to a file, whole or not at all (`write_whole`). Throws `Error` in the cases in which svg and write_whole throw it.
TILEMESH_HOST void write_svg(std::filesystem::path const& path, Plot const& plot);

}}} // namespace tilemesh::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/plot_code.hpp>
#endif
