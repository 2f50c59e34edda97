#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/report/plot.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// A part that every bar has: its name and its colour.
struct BarPart {
    std::string name;
    std::uint32_t colour = 0; ///< as in PlotSeries
};

/// One bar: a value a part, stacked from the beginning of the axis.
struct Bar {
    std::string name;
    std::vector<double> values; ///< finite, 0 or above
    double width = 1;           ///< finite, 0 or above, on the x axis; only where bars lie along it
    std::string note{};         ///< stands behind the end of the bar; only of rows
};

/// A part of the x axis with a name, which stands above it: from where the part before it ends.
struct BarSpan {
    std::string name;           ///< empty: none
    double width = 1;           ///< finite, 0 or above, on the x axis
};

/// Where the bars are. `rows`: one below the other, each to the right of its name; values lie along the x axis. `along_x`: one after
/// the other along an x axis that begins at 0, each as wide as its `width`; values lie along the y axis.
enum class BarLayout { rows, along_x };

/// A diagram of stacked bars for a report, with a legend on the right.
struct StackedBars {
    std::string title;
    std::string x_label, y_label; ///< what and in which unit; rows have no label on the y axis
    std::vector<BarPart> parts;
    std::vector<Bar> bars;
    BarLayout layout = BarLayout::rows;
    std::optional<double> y_high{};          ///< above 0: where the axis of the values ends; longer bars are cut off there
    std::vector<BarSpan> spans{};            ///< of the x axis of `along_x`, from 0; their names make the picture higher
    std::uint32_t width = 800, height = 320; ///< of the whole picture, in pixels; 320 x 200 or more. Rows take the height that they need
};

namespace detail {
/// The text, or its beginning and its end with "..." between them, so that at most `most` bytes are left; cuts no UTF-8 character.
TILEMESH_HOST std::string shortened(std::string_view text, std::size_t most);

/// A name above the axis: where its part's middle is, and in which row above it the name stands.
struct SpanFlag {
    std::string name;
    double at_px, width_px; ///< of the part
    std::size_t row = 0;
};
/// Gives each name a row, so that none overlaps another or is crossed by the line from another to its part: a name begins at its
/// line, and is higher than all names whose lines it covers. Where that takes more than `most_rows`, the name of the thinnest part is
/// left out.
TILEMESH_HOST void stack_flags(std::vector<SpanFlag>& flags, std::size_t most_rows);
} // namespace detail

/// The bars as an SVG document of its own, as `svg` of a Plot gives it; the axis of the values begins at 0. Parts that are 0 are not
/// drawn. Throws `Error` for a picture under 320 x 200, an end of the axis that is not finite and above 0, and a bar with
/// another number of values than there are parts, or with a value or a width that is negative or not finite. Costs some 80
/// bytes a part of a bar.
TILEMESH_HOST std::string svg(StackedBars const& chart);

}}} // namespace tilemesh::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/stacked_bars_code.hpp>
#endif
