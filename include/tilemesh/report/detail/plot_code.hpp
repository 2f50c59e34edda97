#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <string_view>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/plot.hpp>
#include <tilemesh/report/whole_file.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {
namespace detail {

/// The palette of Okabe and Ito (2008), black first.
inline constexpr std::array<char const*, 8> plot_colours = {"#000000", "#e69f00", "#56b4e9", "#009e73", "#0072b2", "#d55e00", "#cc79a7", "#999999"};

/// A number as plain decimals, without a locale.
inline std::string plot_number(double value, int decimals)
{
    auto const out = tilemesh::decimals(value, decimals);
    return out.find_first_not_of("-0.") == std::string::npos && out[0] == '-' ? out.substr(1) : out; // no -0.0
}
inline std::string plot_text(std::string_view text)
{
    std::string out;
    for (char const c : text) switch (c) {
        case '<':
            out += "&lt;";
            break;
        case '>':
            out += "&gt;";
            break;
        case '&':
            out += "&amp;";
            break;
        case '"':
            out += "&quot;";
            break;
        default:
            out += static_cast<unsigned char>(c) < 32 ? ' ' : c; // XML has no control characters
        }
    return out;
}

struct PlotTick {
    double at;
    std::string text;
};

/// Maps a range of values to a range of pixels.
class PlotRange {
public:
    PlotRange(PlotAxis const& axis, char const* which, double least, double most, double from_px, double to_px)
        : log_(axis.scale == PlotScale::logarithmic), from_px_(from_px), to_px_(to_px)
    {
        for (auto const& bound : {axis.low, axis.high})
            if (bound && (!std::isfinite(*bound) || (log_ && !(*bound > 0))))
                refuse(which, "a bound of it is not finite, or not above 0 on a logarithmic scale");
        low_ = axis.low.value_or(least), high_ = axis.high.value_or(most);
        if (low_ > high_ && !(axis.low && axis.high)) // there is no value, or all values are beyond the one given bound
            low_ = axis.low.value_or(log_ ? high_ / 10 : high_ - 1), high_ = axis.high.value_or(log_ ? low_ * 10 : low_ + 1);
        if (!std::isfinite(low_) || !std::isfinite(high_)) low_ = 1, high_ = 10; // there is no value
        if (log_ && !(low_ > 0)) refuse(which, "a value of 0 or below has no place on a logarithmic scale");
        if (axis.low && axis.high && !(low_ < high_)) refuse(which, "its bounds are not in order");
        if (!(low_ < high_)) { // there is one value: add room on both sides
            double const room = low_ == 0 ? 1 : std::fabs(low_) / 2;
            if (!axis.low) low_ = log_ ? low_ / 2 : low_ - room;
            if (!axis.high) high_ = log_ ? high_ * 2 : high_ + room;
        }
        if (!std::isfinite(high_ - low_) || !(low_ < high_) || (log_ && !(low_ > 0))) refuse(which, "it spans more than a double holds");
        log_ ? log_ticks() : linear_ticks(!axis.low, !axis.high);
    }
    double px(double value) const
    {
        double const t = log_ ? std::log(value / low_) / std::log(high_ / low_) : (value - low_) / (high_ - low_);
        return from_px_ + t * (to_px_ - from_px_);
    }
    bool has(double value) const { return !log_ || value > 0; }
    std::vector<PlotTick> const& ticks() const { return ticks_; }

private:
    [[noreturn]] static void refuse(char const* which, char const* why)
    {
        throw Error(std::string("the ") + which + " axis cannot be drawn (" + why + "); choose other bounds or a linear scale");
    }
    /// About five ticks, at steps of 1, 2 or 5 times a power of ten.
    void linear_ticks(bool widen_low, bool widen_high)
    {
        double const raw = (high_ - low_) / 5;
        int const exponent = static_cast<int>(std::floor(std::log10(raw)));
        double const unit = std::pow(10.0, exponent);
        double const step = raw / unit > 5 ? 10 * unit : raw / unit > 2 ? 5 * unit : raw / unit > 1 ? 2 * unit : unit;
        if (widen_low) low_ = std::floor(low_ / step) * step;
        if (widen_high) high_ = std::ceil(high_ / step) * step;
        int const decimals = std::clamp(-static_cast<int>(std::floor(std::log10(step) + 1e-9)), 0, 300);
        double const first = std::ceil(low_ / step - 1e-9);
        for (int i = 0; i <= 20 && (first + i) * step <= high_ + 1e-9 * step; ++i)
            ticks_.push_back({(first + i) * step, plot_number((first + i) * step, decimals)});
    }
    /// A tick at every power of ten. If these are few, also at 2 and 5 times each power, or at all whole multiples, or at linear steps.
    void log_ticks()
    {
        int const begin = static_cast<int>(std::floor(std::log10(low_))), end = static_cast<int>(std::ceil(std::log10(high_)));
        int const skip = std::max(1, (end - begin) / 10);
        auto const add = [&](auto const& factors) {
            ticks_.clear();
            for (int e = begin; e <= end; e += skip)
                for (int const times : factors) {
                    double const at = times * std::pow(10.0, e);
                    if (at < low_ * (1 - 1e-9) || at > high_ * (1 + 1e-9)) continue;
                    bool const short_form = e < -3 || e > 5; // 0.000001 would overlap the axis' label
                    ticks_.push_back({at, short_form ? std::to_string(times) + "e" + std::to_string(e) : plot_number(at, std::clamp(-e, 0, 300))});
                }
            return ticks_.size() >= 3;
        };
        if (end - begin > 4) add(std::array{1});
        else if (!add(std::array{1, 2, 5}) && !add(std::array{1, 2, 3, 4, 5, 6, 7, 8, 9})) {
            ticks_.clear();
            linear_ticks(false, false);
        }
    }

    bool log_;
    double from_px_, to_px_, low_ = 0, high_ = 0;
    std::vector<PlotTick> ticks_;
};

/// A place in tenths of a pixel: places that look the same are equal.
using PlotPlace = std::array<long, 2>;
inline std::string place_text(PlotPlace const& at)
{
    return plot_number(static_cast<double>(at[0]) / 10, 1) + " " + plot_number(static_cast<double>(at[1]) / 10, 1);
}

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

TILEMESH_HOST std::string svg(Plot const& plot)
{
    using detail::plot_number;
    using detail::plot_text;
    if (plot.width < 320 || plot.height < 200)
        throw Error("a plot of " + std::to_string(plot.width) + " x " + std::to_string(plot.height) +
                    " pixels (axes and legend take 320 x 200); choose a larger one");
    double least[2], most[2];
    for (int i = 0; i < 2; ++i) least[i] = std::numeric_limits<double>::infinity(), most[i] = -least[i];
    bool infinite = false;
    std::size_t longest = 0;
    for (auto const& series : plot.series) {
        longest = std::max(longest, series.name.size());
        for (auto const& [x, y] : series.points) {
            if (!std::isfinite(x)) throw Error("series \"" + series.name + "\" cannot be drawn (an x of it is not finite); leave that point out");
            least[0] = std::min(least[0], x), most[0] = std::max(most[0], x);
            infinite = infinite || (std::isinf(y) && y > 0);
            if (std::isfinite(y)) least[1] = std::min(least[1], y), most[1] = std::max(most[1], y);
        }
    }

    // Room for the legend, the labels and the line of infinite values. A letter of 12 pixels height is 6.5 pixels wide.
    double const legend = std::min(60 + 6.5 * static_cast<double>(longest), 0.45 * plot.width);
    double const left = 64, right = plot.width - legend - 8, bottom = plot.height - 52.0, top = 36, infinity_px = top + 8;
    std::array<PlotAxis, 2> axes{plot.x, plot.y};
    if (plot.equal_units && least[0] <= most[0] && least[1] <= most[1]) {
        double const far = std::max({std::fabs(least[0]), std::fabs(most[0]), std::fabs(least[1]), std::fabs(most[1]), 1e-6});
        // One point has no extent; it gets a millionth of its distance from 0 a pixel.
        double const per_px = 1.05 * std::max({(most[0] - least[0]) / (right - left), (most[1] - least[1]) / (bottom - top), 1e-6 * far});
        for (std::size_t i = 0; i < 2; ++i) {
            double const middle = (least[i] + most[i]) / 2, half = per_px * (i == 0 ? right - left : bottom - top) / 2;
            axes[i].low = middle - half, axes[i].high = middle + half;
        }
    }
    detail::PlotRange const x(axes[0], "x", least[0], most[0], left, right);
    detail::PlotRange const y(axes[1], "y", least[1], most[1], bottom, infinite ? top + 28 : top);

    std::string out;
    auto const number = [](double v) { return plot_number(v, 1); };
    auto const line = [&](double x0, double y0, double x1, double y1, char const* stroke) {
        out += "<line x1=\"" + number(x0) + "\" y1=\"" + number(y0) + "\" x2=\"" + number(x1) + "\" y2=\"" + number(y1) + "\" stroke=\"" +
               stroke + "\"/>\n";
    };
    auto const text = [&](double at_x, double at_y, char const* more, std::string const& what) {
        out += "<text x=\"" + number(at_x) + "\" y=\"" + number(at_y) + "\"" + more + ">" + plot_text(what) + "</text>\n";
    };
    auto const size = "width=\"" + std::to_string(plot.width) + "\" height=\"" + std::to_string(plot.height) + "\"";
    out += "<svg xmlns=\"http://www.w3.org/2000/svg\" " + size + " viewBox=\"0 0 " + std::to_string(plot.width) + " " +
           std::to_string(plot.height) + "\" font-family=\"sans-serif\" font-size=\"12\">\n<rect " + size +
           " fill=\"#ffffff\"/>\n<clipPath id=\"area\"><rect x=\"" + number(left - 4) + "\" y=\"" + number(top - 4) + "\" width=\"" +
           number(right - left + 8) + "\" height=\"" + number(bottom - top + 8) + "\"/></clipPath>\n";
    text((left + right) / 2, 20, " text-anchor=\"middle\" font-size=\"15\"", plot.title);

    // Grid, ticks, labels.
    for (auto const& tick : x.ticks()) {
        line(x.px(tick.at), top, x.px(tick.at), bottom, "#dddddd");
        text(x.px(tick.at), bottom + 16, " text-anchor=\"middle\"", tick.text);
    }
    for (auto const& tick : y.ticks()) {
        line(left, y.px(tick.at), right, y.px(tick.at), "#dddddd");
        text(left - 6, y.px(tick.at) + 4, " text-anchor=\"end\"", tick.text);
    }
    if (infinite) {
        line(left, infinity_px, right, infinity_px, "#999999");
        text(left - 6, infinity_px + 4, " text-anchor=\"end\"", plot.infinity);
    }
    line(left, bottom, right, bottom, "#000000");
    line(left, top, left, bottom, "#000000");
    text((left + right) / 2, bottom + 38, " text-anchor=\"middle\"", plot.x.label);
    auto const turn = " text-anchor=\"middle\" transform=\"rotate(-90 16 " + number((top + bottom) / 2) + ")\"";
    text(16, (top + bottom) / 2, turn.c_str(), plot.y.label);

    // The points and the corners of lines in pixels, and the series that share a piece of line or a dot.
    using detail::PlotPlace;
    struct Drawn {
        std::vector<std::vector<PlotPlace>> lines; ///< one line from gap to gap
        std::vector<PlotPlace> dots;
    };
    std::vector<Drawn> drawn(plot.series.size());
    detail::PlotShares shares;
    for (std::size_t i = 0; i < plot.series.size(); ++i) {
        auto const& series = plot.series[i];
        bool joined = false;
        for (auto const& [at, value] : series.points) {
            if (!std::isfinite(value) && !(value > 0)) {
                joined = false;
                continue;
            }
            if (!x.has(at) || (std::isfinite(value) && !y.has(value)))
                throw Error("series \"" + series.name + "\" cannot be drawn (a value of 0 or below on a logarithmic scale); choose a linear scale");
            auto const tenths = [](double px) { return std::lround(10 * std::clamp(px, -1e6, 1e6)); }; // a value may be far outside
            PlotPlace const place = {tenths(x.px(at)), tenths(std::isfinite(value) ? y.px(value) : infinity_px)};
            drawn[i].dots.push_back(place);
            if (series.line == PlotLine::none) continue;
            if (!joined) drawn[i].lines.emplace_back();
            auto& line_of = drawn[i].lines.back();
            if (joined && series.line == PlotLine::step) line_of.push_back({place[0], line_of.back()[1]});
            line_of.push_back(place);
            joined = true;
            detail::PlotShares::own(shares.dots, place, i);
        }
        for (auto const& points : drawn[i].lines)
            for (std::size_t p = 1; p < points.size(); ++p)
                if (points[p - 1] != points[p]) detail::PlotShares::own(shares.lines, {points[p - 1], points[p]}, i);
    }

    // Lines and dots, clipped to the area, and the legend.
    for (std::size_t i = 0; i < plot.series.size(); ++i) {
        auto const& series = plot.series[i];
        std::string const colour = detail::plot_colours[series.colour % detail::plot_colours.size()];
        std::string const radius = "\" r=\"" + number(series.dot_px);
        std::string path, dots;
        std::map<std::array<std::size_t, 2>, std::string> shared; // paths, by the number of sharing series and this series' place
        for (auto const& points : drawn[i].lines) {
            bool on_path = false;
            for (std::size_t p = 0; p < points.size(); ++p) {
                auto const share = p == 0 ? std::array<std::size_t, 2>{1, 0} : detail::PlotShares::share(shares.lines, {points[p - 1], points[p]}, i);
                if (share[0] > 1) {
                    shared[share].append("M").append(detail::place_text(points[p - 1])).append("L").append(detail::place_text(points[p]));
                    on_path = false;
                } else {
                    if (p != 0 && !on_path) path.append("M").append(detail::place_text(points[p - 1]));
                    if (p != 0) path.append("L").append(detail::place_text(points[p]));
                    on_path = p != 0;
                }
            }
            if (points.size() == 1) path.append("M").append(detail::place_text(points[0]));
        }
        for (auto const& place : drawn[i].dots) {
            auto const share = detail::PlotShares::share(shares.dots, place, i);
            auto const above = series.line == PlotLine::none ? 0 : share[0] - 1 - share[1];
            dots += "<circle cx=\"" + number(static_cast<double>(place[0]) / 10) + "\" cy=\"" + number(static_cast<double>(place[1]) / 10) +
                    "\" r=\"" + number(series.dot_px + 1.5 * static_cast<double>(above)) + "\"/>";
        }
        std::string const line_style = " fill=\"none\" stroke=\"" + colour + "\" stroke-width=\"1.8\"";
        std::string const stroke = line_style + (series.dashed ? " stroke-dasharray=\"6 4\"" : "");
        std::string const strength = series.faded ? " opacity=\"0.6\"" : "";
        if (!dots.empty()) {
            out += "<g clip-path=\"url(#area)\"" + strength + ">";
            if (!path.empty()) out += "<path d=\"" + path + "\"" + stroke + "/>\n";
            for (auto const& [share, pieces] : shared) // the first series has no dashes, so a short piece also has a colour
                out += "<path d=\"" + pieces + "\"" + line_style +
                       (share[1] == 0 ? std::string()
                                      : " stroke-dasharray=\"7 " + std::to_string(7 * (share[0] - 1)) + "\" stroke-dashoffset=\"-" +
                                            std::to_string(7 * share[1]) + "\"") +
                       "/>\n";
            out += "<g fill=\"" + (series.dashed ? "#ffffff\" stroke=\"" + colour : colour) + "\">" + dots + "</g></g>\n";
        }
        double const row = top + 8 + 18 * static_cast<double>(i);
        if (series.line == PlotLine::none)
            out += "<circle cx=\"" + number(right + 27) + "\" cy=\"" + number(row) + radius + "\" fill=\"" + colour + "\"" + strength + "/>\n";
        else out += "<path d=\"M" + number(right + 12) + " " + number(row) + "h30\"" + stroke + strength + "/>\n";
        text(right + 48, row + 4, "", series.name);
    }
    return out + "</svg>\n";
}

TILEMESH_HOST void write_svg(std::filesystem::path const& path, Plot const& plot)
{
    write_whole(path, svg(plot));
}

}}} // namespace tilemesh::report
