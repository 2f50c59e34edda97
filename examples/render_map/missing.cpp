#include "missing.hpp"
#include <algorithm>
#include <cstdint>
#include <map>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/report/table.hpp>
#include <utility>

namespace render_map {

namespace report = tilemesh::report;
using report::thousands;

namespace {

/// "frame_0000.png lacks ", or of `frames` of several pictures the worst: "2 of 5 pictures lack something, most of all frame_0003.png: ".
std::string beginning(report::RunReport const& run, std::ptrdiff_t frames, report::RunFrame const& worst)
{
    if (run.frames.size() == 1) return worst.image + " lacks ";
    return thousands(static_cast<std::uint64_t>(frames)) + " of " + thousands(run.frames.size()) +
           (frames == 1 ? " pictures lacks something, " : " pictures lack something, most of all ") + worst.image + ": ";
}

/// The pictures that a bound on rounds cut short, and of these the one that is cut at the most tiles.
std::string unfinished_text(report::RunReport const& run)
{
    auto const cut = [](report::RunFrame const& frame) { return frame.report.unfinished.size(); };
    auto const frames = std::count_if(run.frames.begin(), run.frames.end(), [&](auto const& frame) { return cut(frame) != 0; });
    if (frames == 0) return {};
    auto const& worst = *std::max_element(run.frames.begin(), run.frames.end(), [&](auto const& a, auto const& b) { return cut(a) < cut(b); });
    auto const& nearest = report::nearest_cut(worst.report);
    auto const tiles = cut(worst);
    return beginning(run, frames, worst) + "what is far on " + thousands(tiles) + (tiles == 1 ? " tile" : " tiles") + " (" + thousands(tiles) +
           " unfinished, cut at depth " + report::decimals(double{nearest.depth}, 3) + " or behind, the nearest on tile " + std::to_string(nearest.tile) + ")";
}

} // namespace

std::string missing_text(report::RunReport const& run)
{
    if (auto const text = unfinished_text(run); !text.empty()) return text; // homes lose nothing else
    auto const lacks = [](report::RunFrame const& frame) { return frame.report.lost.size(); };
    auto const frames = std::count_if(run.frames.begin(), run.frames.end(), [&](auto const& frame) { return lacks(frame) != 0; });
    if (frames == 0) return {};
    // A whole Gaussian counts more than any number of copies.
    auto const whole = [](report::RunFrame const& frame) {
        return std::count_if(frame.report.lost.begin(), frame.report.lost.end(), [](auto const& loss) { return loss.tile == report::Loss::whole; });
    };
    auto const& worst = *std::max_element(run.frames.begin(), run.frames.end(), [&](auto const& a, auto const& b) {
        return std::pair(whole(a), lacks(a)) < std::pair(whole(b), lacks(b));
    });
    std::map<report::Cause, std::uint64_t> causes;
    for (auto const& loss : worst.report.lost) ++causes[loss.cause];
    auto const records = static_cast<std::uint64_t>(whole(worst));
    auto const copies = lacks(worst) - records;
    auto text = beginning(run, frames, worst);
    if (records != 0) text += thousands(records) + " of the map's " + thousands(run.map.gaussians) + " Gaussians";
    if (copies != 0) text += (records != 0 ? " and " : "") + thousands(copies) + (copies == 1 ? " copy" : " copies") + (records != 0 ? " of others" : "");
    std::string separator = " (";
    for (auto const& [cause, count] : causes) {
        text += separator + thousands(count) + " " + report::to_string(cause);
        separator = ", ";
    }
    return text + ")";
}

} // namespace render_map
