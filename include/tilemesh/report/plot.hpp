#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/whole_file.hpp>
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

namespace detail {

/// The palette of Okabe and Ito (2008), black first.
inline constexpr std::array<char const*, 8> plot_colours = {"#000000", "#e69f00", "#56b4e9", "#009e73",
                                                            "#0072b2", "#d55e00", "#cc79a7", "#999999"};

/// A number as plain decimals, without a locale.
TILEMESH_HOST std::string plot_number(double value, int decimals);
TILEMESH_HOST std::string plot_text(std::string_view text);

struct PlotTick {
    double at;
    std::string text;
};

/// Maps a range of values to a range of pixels.
class PlotRange {
public:
    TILEMESH_HOST PlotRange(PlotAxis const& axis, char const* which, double least, double most, double from_px,
                            double to_px);
    TILEMESH_HOST double px(double value) const;
    bool has(double value) const { return !log_ || value > 0; }
    std::vector<PlotTick> const& ticks() const { return ticks_; }

private:
    [[noreturn]] TILEMESH_HOST static void refuse(char const* which, char const* why);
    /// About five ticks, at steps of 1, 2 or 5 times a power of ten.
    TILEMESH_HOST void linear_ticks(bool widen_low, bool widen_high);
    /// A tick at every power of ten. If these are few, also at 2 and 5 times each power, or at all whole multiples, or at linear steps.
    TILEMESH_HOST void log_ticks();

    bool log_;
    double from_px_, to_px_, low_ = 0, high_ = 0;
    std::vector<PlotTick> ticks_;
};

/// A place in tenths of a pixel: places that look the same are equal.
using PlotPlace = std::array<long, 2>;
TILEMESH_HOST std::string place_text(PlotPlace const& at);

/// For each piece of line and each dot of a plot: the series that draw it, in order.
struct PlotShares {
    using Piece = std::array<PlotPlace, 2>;
    using Owners = std::vector<std::size_t>; ///< indices of series, in order
    std::map<Piece, Owners> lines;
    std::map<PlotPlace, Owners> dots;
    /// Adds a series to the owners of a piece or dot. A piece that a series draws twice counts once.
    template <class Key>
    static void own(std::map<Key, Owners>& of, Key const& key, std::size_t series)
    {
        auto& owners = of[key];
        if (owners.empty() || owners.back() != series) owners.push_back(series);
    }
    /// The number of owners of a piece or dot, and the number of owners before this series.
    template <class Key>
    static std::array<std::size_t, 2> share(std::map<Key, Owners> const& of, Key const& key, std::size_t series)
    {
        auto const found = of.find(key);
        if (found == of.end()) return {1, 0};
        auto const& owners = found->second;
        return {owners.size(), static_cast<std::size_t>(std::find(owners.begin(), owners.end(), series) - owners.begin())};
    }
};

} // namespace detail

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
