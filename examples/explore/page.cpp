#include "page.hpp"
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <tilemesh/model/explore.hpp>
#include <tilemesh/model/trace_section.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/html.hpp>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/report/table.hpp>
#include <utility>

namespace explore {

namespace {

namespace report = tilemesh::report;
using report::decimals;
using report::thousands;

std::vector<tilemesh::StudyPoint> plain(std::vector<Point> const& points)
{
    return {points.begin(), points.end()};
}
std::string psnr_text(double db)
{
    return std::isinf(db) ? "equal" : decimals(db, 3);
}
/// A field of a CSV.
std::string quoted(std::string const& text)
{
    if (text.find_first_of(",\"\n") == text.npos) return text;
    std::string out = "\"";
    for (char const c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
    return out + '"';
}

/// An axis of a diagram. It is logarithmic if its values span more than a factor of 20.
struct Axis {
    std::string label;
    std::function<double(Point const&)> of;
};
class Scale {
public:
    Scale(std::vector<Point> const& points, std::string const& map, Axis const& axis, double from_px, double to_px) : from_(from_px), to_(to_px)
    {
        bool first = true;
        for (auto const& p : points) {
            if (!p.refused.empty() || p.map != map) continue;
            auto const v = axis.of(p);
            low_ = first ? v : std::min(low_, v);
            high_ = first ? v : std::max(high_, v);
            first = false;
        }
        log_ = low_ > 0 && high_ > 20 * low_;
        double const margin = log_ ? 0 : high_ > low_ ? 0.04 * (high_ - low_) : std::max(1.0, std::fabs(high_)) * 0.04;
        low_ = log_ ? low_ / 1.15 : low_ - margin;
        high_ = log_ ? high_ * 1.15 : high_ + margin;
    }
    double px(double v) const
    {
        auto const place = log_ ? std::log(v / low_) / std::log(high_ / low_) : (v - low_) / (high_ - low_);
        return from_ + place * (to_ - from_);
    }
    std::vector<double> ticks() const
    {
        std::vector<double> out;
        if (log_) {
            for (double power = std::pow(10.0, std::floor(std::log10(low_))); power <= high_; power *= 10)
                for (double const m : {1.0, 2.0, 5.0})
                    if (m * power >= low_ && m * power <= high_) out.push_back(m * power);
            return out;
        }
        double step = std::pow(10.0, std::floor(std::log10((high_ - low_) / 4)));
        while ((high_ - low_) / step > 8) step *= step * 2 > 0 && (high_ - low_) / (step * 2) > 5 ? 2 : 2.5;
        for (double at = std::ceil(low_ / step) * step; at <= high_; at += step) out.push_back(std::fabs(at) < step / 1e6 ? 0 : at);
        return out;
    }

private:
    double from_, to_, low_ = 0, high_ = 1;
    bool log_ = false;
};

std::vector<std::size_t> knees_of(std::vector<tilemesh::StudyPoint> const& points)
{
    std::vector<std::size_t> out;
    for (auto const& front : fronts_of(points))
        if (auto const knee = knee_of(points, front.points)) out.push_back(*knee);
    return out;
}
std::string all_measures(Point const& p)
{
    auto const mark = mark_of(p);
    return p.name + ": " + psnr_text(p.psnr_db) + " dB, " + decimals(p.modelled_ms, 4) + " ms modelled, " + thousands(p.sram_bytes) + " bytes of SRAM a tile, " +
           thousands(p.exchanged_bytes) + " bytes exchanged" + (p.whole_channels ? " by whole channels" : " as messages") + (mark.empty() ? "" : "; " + mark);
}

/// A diagram of two measures of one map's points. A point that loses something is a red cross, one whose time leaves something out a ring.
std::string diagram(std::vector<Point> const& points, std::string const& map, std::vector<std::size_t> const& front, std::optional<std::size_t> knee, Axis const& x_axis,
                    Axis const& y_axis)
{
    constexpr double width = 860, height = 420, left = 80, right = 20, top = 14, bottom = 52;
    constexpr std::size_t most_dots = 5000; // of points off the front; more cannot be told apart
    Scale const x(points, map, x_axis, left, width - right), y(points, map, y_axis, height - bottom, top);
    auto const px = [](double v) { return decimals(v, 1); };
    std::string text = "<svg role=\"img\" viewBox=\"0 0 860 420\" width=\"860\" height=\"420\" font-family=\"sans-serif\" font-size=\"12\" style=\"max-width:100%;height:auto;background:#fff\">\n";
    for (double const at : x.ticks())
        text += "<line x1=\"" + px(x.px(at)) + "\" x2=\"" + px(x.px(at)) + "\" y1=\"14\" y2=\"368\" stroke=\"#ddd\"/><text x=\"" + px(x.px(at)) +
                "\" y=\"384\" text-anchor=\"middle\" fill=\"#333\">" + report::short_number(at) + "</text>\n";
    for (double const at : y.ticks())
        text += "<line x1=\"80\" x2=\"840\" y1=\"" + px(y.px(at)) + "\" y2=\"" + px(y.px(at)) + "\" stroke=\"#ddd\"/><text x=\"74\" y=\"" + px(y.px(at) + 4) +
                "\" text-anchor=\"end\" fill=\"#333\">" + report::short_number(at) + "</text>\n";
    text += "<text x=\"460\" y=\"408\" text-anchor=\"middle\" fill=\"#333\">" + report::html_text(x_axis.label) + "</text><text transform=\"translate(16 190) rotate(-90)\" "
            "text-anchor=\"middle\" fill=\"#333\">" + report::html_text(y_axis.label) + "</text>\n";
    auto const dot = [&](std::size_t i, bool on_front) {
        auto const& p = points[i];
        auto const cx = x.px(x_axis.of(p)), cy = y.px(y_axis.of(p));
        std::string shape;
        if (p.lost != 0)
            shape = "<path d=\"M" + px(cx - 4) + " " + px(cy - 4) + "L" + px(cx + 4) + " " + px(cy + 4) + "M" + px(cx - 4) + " " + px(cy + 4) + "L" + px(cx + 4) + " " +
                    px(cy - 4) + "\" stroke=\"#d55e00\" stroke-width=\"" + (on_front ? "3" : "1.5") + "\" fill=\"none\">";
        else
            shape = "<circle cx=\"" + px(cx) + "\" cy=\"" + px(cy) + "\" r=\"" + (on_front ? (knee == i ? "7" : "5") : "3") + "\" fill=\"" +
                    (!p.left_out.empty() ? "#fff\" stroke=\"#888" : on_front ? "#0072b2" : "#bbb") + "\">";
        shape += "<title>" + report::html_text(all_measures(p) + (knee == i ? " (the knee)" : on_front ? " (on the front)" : "")) + "</title>" +
                 (p.lost != 0 ? "</path>" : "</circle>");
        text += on_front && !p.picture.empty() ? "<a href=\"" + report::html_text(p.picture) + "\">" + shape + "</a>\n" : shape + "\n";
    };
    auto const every = std::max<std::size_t>((points.size() + most_dots - 1) / most_dots, 1);
    for (std::size_t i = 0; i < points.size(); i += every)
        if (points[i].refused.empty() && points[i].map == map && std::find(front.begin(), front.end(), i) == front.end()) dot(i, false);
    for (auto const i : front) dot(i, true);
    return text + "</svg>\n";
}

} // namespace

std::string weakest_text(Point const& p)
{
    return report::share_text(p.weakest_share, 1) + " " + p.weakest.substr(0, p.weakest.find(':'));
}
std::uint64_t free_bytes(Setting const& s, Point const& p)
{
    auto const sram = s.machine->need("sram");
    return sram - std::min(sram, p.sram_bytes);
}

std::string csv_of(Study const& study, std::vector<Point> const& points)
{
    auto const values = plain(points);
    auto const front = front_of(values);
    auto const knees = knees_of(values);
    std::string text = "name,map,machine,program,preset,quality,capacities,costs,psnr_db,modelled_ms,cycles,sram_bytes,exchanged_bytes,lost,left_out,exchanges,"
                       "passes,pairs,slowest_to_mean,storage,channel,waiting,on_front,knee,first_ms,later_ms,free_bytes,bytes_of,weakest,beam,view,picture,refused\n";
    for (std::size_t i = 0; i < points.size(); ++i) {
        auto const& p = points[i];
        auto const& s = study.settings[i];
        auto const add = [&](std::string const& field) { text += quoted(field) + ","; };
        auto const count = [&](std::uint64_t n) { add(p.refused.empty() ? std::to_string(n) : ""); };
        for (auto const& field : {p.name, s.subject->name, s.machine->name, std::string(s.homes ? "homes" : "anchored"), s.preset,
                                  std::string(s.quality ? tilemesh::splat::name(*s.quality) : "default"), s.capacities.name,
                                  s.prices->name.empty() ? std::string("machine") : s.prices->name})
            add(field);
        add(p.refused.empty() ? tilemesh::number_text(p.psnr_db) : "");
        add(p.refused.empty() ? tilemesh::number_text(p.modelled_ms) : "");
        for (auto const n : {p.cycles, p.sram_bytes, p.exchanged_bytes, p.lost}) count(n);
        add(p.left_out);
        for (auto const n : {p.exchanges, p.passes, p.pairs}) count(n);
        add(p.refused.empty() ? tilemesh::number_text(p.slowest_to_mean) : "");
        for (auto const n : {p.storage, p.channel, p.waiting}) count(n);
        add(std::find(front.begin(), front.end(), i) != front.end() ? "1" : "0");
        add(std::find(knees.begin(), knees.end(), i) != knees.end() ? "1" : "0");
        add(p.refused.empty() ? tilemesh::number_text(p.first_ms) : "");
        add(p.refused.empty() && p.later_ms ? tilemesh::number_text(*p.later_ms) : "");
        count(free_bytes(s, p));
        add(!p.refused.empty() ? "" : p.whole_channels ? "channels" : "messages");
        add(p.refused.empty() ? p.weakest : "");
        count(p.beam);
        add(s.subject->view);
        add(p.picture);
        text += quoted(p.refused) + "\n";
    }
    return text;
}

std::string page_of(Study const& study, std::vector<Point> const& points, std::string const& how)
{
    constexpr std::size_t most_rows = 1000;
    auto const values = plain(points);
    auto const fronts = fronts_of(values);
    auto const knees = knees_of(values);
    std::size_t on_front = 0;
    for (auto const& front : fronts) on_front += front.points.size();
    auto const is_knee = [&](std::size_t i) { return std::find(knees.begin(), knees.end(), i) != knees.end(); };
    std::size_t refused = 0, lossy = 0, left_out = 0;
    for (auto const& p : points) {
        refused += p.refused.empty() ? 0u : 1u;
        lossy += p.lost != 0 ? 1u : 0u;
        left_out += p.left_out.empty() ? 0u : 1u;
    }
    report::HtmlReport html("Study " + study.name);
    for (auto const& front : fronts) html.lead((fronts.size() > 1 ? "Map " + front.map + ": " : "") + knee_text(values, front.points));
    std::vector<std::pair<std::string, std::string>> figures = {{"points", thousands(points.size())}, {"on the front", thousands(on_front)},
                                                               {"lose something", thousands(lossy)}, {"do not run", thousands(refused)}};
    html.figures(figures);
    html.paragraph(how);
    std::vector<std::vector<std::string>> views;
    for (auto const& s : study.settings)
        if (views.size() < most_rows && std::none_of(views.begin(), views.end(), [&](auto const& row) { return row[0] == s.subject->name; }))
            views.push_back({s.subject->name, thousands(s.subject->map.gaussians.size()), s.subject->view});
    html.table({"map", "Gaussians", "seen by"}, views);
    html.paragraph("The front has the points that no other one beats by error, modelled time, SRAM of a tile and bytes exchanged. " + std::string(tilemesh::knee_meaning) +
                   " Blue: on the front, a click opens its picture; the large dot is the knee. A red cross loses records, copies or tiles, so that its time is not that of a whole picture: it is on no front. A ring is a time "
                   "\"at least\": a number of its machine is unknown, and it is on no front (" + thousands(left_out) + " points). Grey: another point is better. Modelled time is the mean of all frames; the columns \"first\" and \"later\" have the first frame, "
                   "in which the records find their tiles, and the mean of the others. The weakest prices are the worst known ones that the time rests on. SRAM is what the sizes use, not what the machine has; a tile "
                   "without room for one more slot of storage counts as full. Bytes exchanged are those of whole channels on a machine that is priced by capacity, and of messages on the others, both with "
                   "their heads: the front compares only bytes of one kind.");
    Axis const ms{"modelled ms a frame", [](Point const& p) { return p.modelled_ms; }};
    Axis const psnr{"PSNR of the worst frame, dB", [](Point const& p) { return std::min(p.psnr_db, 150.0); }};
    Axis const sram{"SRAM that a tile uses, bytes", [](Point const& p) { return static_cast<double>(p.sram_bytes); }};
    Axis const bytes{"bytes exchanged", [](Point const& p) { return static_cast<double>(p.exchanged_bytes); }};
    auto const row_of = [&](std::size_t i) -> std::vector<std::string> {
        auto const& p = points[i];
        if (!p.refused.empty()) return {p.name, "", "", "", "", "", "", "", "", "", "", "", "", p.refused};
        return {p.name, psnr_text(p.psnr_db), decimals(p.modelled_ms, 4), decimals(p.first_ms, 4), p.later_ms ? decimals(*p.later_ms, 4) : "", weakest_text(p) + p.weakest.substr(std::min(p.weakest.find(':'), p.weakest.size())),
                thousands(p.sram_bytes), thousands(free_bytes(study.settings[i], p)), thousands(p.exchanged_bytes) + (p.whole_channels ? " (channels)" : " (messages)"), thousands(p.lost),
                thousands(p.exchanges), decimals(p.slowest_to_mean, 2),
                thousands(p.storage) + " / " + thousands(p.channel) + (p.beam != p.channel && p.beam != 0 ? " and " + thousands(p.beam) : "") + " / " + thousands(p.waiting), (is_knee(i) ? "knee" : "") + std::string(is_knee(i) && !mark_of(p).empty() ? "; " : "") + mark_of(p)};
    };
    std::vector<std::string> const headers = {"point", "PSNR, dB", "modelled ms", "first, ms", "later, ms", "weakest prices, of the cycles", "SRAM, bytes", "free, bytes", "bytes exchanged", "lost", "exchanges", "slowest / mean tile",
                                              "slots: storage / channel / waiting", "mark"};
    std::vector<std::vector<std::string>> rows;
    std::vector<std::string> diagrams;
    for (auto const& front : fronts) {
        std::string const of = fronts.size() > 1 ? " of " + front.map : "";
        if (std::any_of(points.begin(), points.end(), [&](Point const& p) { return p.map == front.map && p.refused.empty(); }))
            for (auto const& [heading, y] : {std::pair("Error against time", &psnr), std::pair("Time against SRAM", &sram), std::pair("Time against bytes exchanged", &bytes)}) {
                diagrams.push_back(diagram(points, front.map, front.points, knee_of(values, front.points), ms, *y));
                html.section(heading + of).paragraph("@diagram " + std::to_string(diagrams.size()) + "@");
            }
        rows.clear();
        for (auto const i : front.points)
            if (rows.size() < most_rows) rows.push_back(row_of(i));
        html.section("The front" + of).table(headers, rows);
    }
    rows.clear();
    for (std::size_t i = 0; i < points.size() && rows.size() < most_rows; ++i) rows.push_back(row_of(i));
    html.folded_section(rows.size() < points.size() ? "The first " + thousands(rows.size()) + " of " + thousands(points.size()) + " points" : "All points",
                        report::HtmlFold::closed, [&] { html.table(headers, rows); });
    std::vector<std::vector<std::string>> machines;
    for (auto const& s : study.settings)
        if (std::none_of(machines.begin(), machines.end(), [&](auto const& row) { return row[0] == s.machine->name; }) && machines.size() < most_rows)
            machines.push_back({s.machine->name, machine_text(*s.machine)});
    html.folded_section("What is known of the machines", report::HtmlFold::closed, [&] { html.table({"machine", "its numbers"}, machines); });
    html.paragraph(tilemesh::modelled_text);
    auto text = html.str();
    for (std::size_t k = 0; k < diagrams.size(); ++k) {
        std::string const place = "<p>@diagram " + std::to_string(k + 1) + "@</p>";
        if (auto const at = text.find(place); at != text.npos) text.replace(at, place.size(), diagrams[k]);
    }
    return text;
}

} // namespace explore
