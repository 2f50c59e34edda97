#pragma once
#include <algorithm>
#include <cmath>
#include <tilemesh/model/explore.hpp>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/report/table.hpp>

namespace tilemesh { inline namespace v0_2 {

namespace model_detail {

TILEMESH_HOST bool counts(StudyPoint const& p) noexcept
{
    return p.refused.empty() && p.left_out.empty() && p.lost == 0;
}

/// What a knee weighs against time, the more the better.
enum class Gain { psnr, sram, bytes };
TILEMESH_HOST double gain_of(StudyPoint const& p, Gain gain) noexcept
{
    constexpr double equal_pictures_db = 150; // float32 has about so many
    switch (gain) {
    case Gain::psnr:
        return std::min(p.psnr_db, equal_pictures_db);
    case Gain::sram:
        return -static_cast<double>(p.sram_bytes);
    default:
        return -static_cast<double>(p.exchanged_bytes);
    }
}
/// The first gain in which the points of a front differ.
TILEMESH_HOST Gain gain_of(std::span<StudyPoint const> points, std::span<std::size_t const> front) noexcept
{
    for (auto const gain : {Gain::psnr, Gain::sram})
        if (std::any_of(front.begin(), front.end(), [&](std::size_t i) { return gain_of(points[i], gain) != gain_of(points[front[0]], gain); }))
            return gain;
    return Gain::bytes;
}

} // namespace model_detail

TILEMESH_HOST bool beats(StudyPoint const& a, StudyPoint const& b) noexcept
{
    if (!model_detail::counts(a) || a.map != b.map) return false;
    bool const one_kind = a.whole_channels == b.whole_channels, more = one_kind && a.exchanged_bytes > b.exchanged_bytes;
    bool const fewer = one_kind && a.exchanged_bytes < b.exchanged_bytes;
    bool const no_worse = a.psnr_db >= b.psnr_db && a.modelled_ms <= b.modelled_ms && a.sram_bytes <= b.sram_bytes && !more;
    bool const better = a.psnr_db > b.psnr_db || a.modelled_ms < b.modelled_ms || a.sram_bytes < b.sram_bytes || fewer;
    return no_worse && better;
}

TILEMESH_HOST std::vector<std::size_t> front_of(std::span<StudyPoint const> points)
{
    std::vector<std::size_t> front;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (model_detail::counts(points[i]) &&
            std::none_of(points.begin(), points.end(), [&](StudyPoint const& other) { return beats(other, points[i]); }))
            front.push_back(i);
    std::stable_sort(front.begin(), front.end(), [&](std::size_t a, std::size_t b) { return points[a].modelled_ms < points[b].modelled_ms; });
    return front;
}

TILEMESH_HOST std::vector<MapFront> fronts_of(std::span<StudyPoint const> points)
{
    std::vector<MapFront> out;
    auto const of = [&](std::string const& map) -> MapFront& {
        auto const at = std::find_if(out.begin(), out.end(), [&](MapFront const& front) { return front.map == map; });
        return at != out.end() ? *at : out.emplace_back(MapFront{map, {}});
    };
    for (auto const& point : points) of(point.map);
    for (auto const i : front_of(points)) of(points[i].map).points.push_back(i);
    return out;
}

TILEMESH_HOST std::optional<std::size_t> knee_of(std::span<StudyPoint const> points, std::span<std::size_t const> front)
{
    if (front.empty()) return {};
    auto const gain = model_detail::gain_of(points, front);
    auto const gain_at = [&](std::size_t i) { return model_detail::gain_of(points[i], gain); };
    std::vector<std::size_t> stairs; // each slower than the one before, and with more gain
    for (auto const i : front) {
        if (!stairs.empty() && points[stairs.back()].modelled_ms == points[i].modelled_ms && gain_at(i) > gain_at(stairs.back())) stairs.back() = i;
        else if (stairs.empty() || gain_at(i) > gain_at(stairs.back())) stairs.push_back(i);
    }
    if (stairs.size() < 3) return {};
    auto const &fastest = stairs.front(), &slowest = stairs.back();
    double const times = points[slowest].modelled_ms - points[fastest].modelled_ms, gains = gain_at(slowest) - gain_at(fastest);
    std::size_t best = stairs[1];
    double most = -2;
    for (std::size_t k = 1; k + 1 < stairs.size(); ++k) {
        auto const i = stairs[k];
        double const above = (gain_at(i) - gain_at(fastest)) / gains - (points[i].modelled_ms - points[fastest].modelled_ms) / times;
        if (above > most) {
            most = above;
            best = i;
        }
    }
    return best;
}

TILEMESH_HOST std::string mark_of(StudyPoint const& p)
{
    if (!p.refused.empty()) return "does not run";
    std::string text = p.lost == 0 ? "" : "loses " + report::thousands(p.lost);
    if (!p.left_out.empty()) text += (text.empty() ? "" : "; ") + std::string("at least: without ") + p.left_out;
    return text;
}

TILEMESH_HOST std::string knee_text(std::span<StudyPoint const> points, std::span<std::size_t const> front)
{
    auto const measures = [&](std::size_t i) {
        auto const& p = points[i];
        return p.name + " (" + (std::isinf(p.psnr_db) ? "equal pictures" : report::decimals(p.psnr_db, 2) + " dB") + ", " +
               report::decimals(p.modelled_ms, 4) + " ms modelled, " + report::thousands(p.sram_bytes) + " bytes of SRAM a tile)";
    };
    if (front.empty()) return "No point has a front: none shows whole pictures on a machine whose numbers are all known.";
    if (front.size() == 1) return "The front has one point, and no knee: " + measures(front.front()) + ".";
    auto const gain = model_detail::gain_of(points, front);
    char const* const bought = gain == model_detail::Gain::psnr   ? "more PSNR"
                               : gain == model_detail::Gain::sram ? "less SRAM"
                                                                  : "fewer bytes exchanged";
    auto const knee = knee_of(points, front);
    if (!knee)
        return "The front has no knee: fewer than three of its " + report::thousands(front.size()) + " points buy " + bought +
               " with more time. The fastest is " + measures(front.front()) + ".";
    char const* const with_most = gain == model_detail::Gain::psnr   ? "most PSNR"
                                  : gain == model_detail::Gain::sram ? "least SRAM"
                                                                     : "fewest bytes exchanged";
    auto const best = *std::max_element(front.begin(), front.end(), [&](std::size_t a, std::size_t b) { // the first of equal ones is the fastest
        return model_detail::gain_of(points[a], gain) < model_detail::gain_of(points[b], gain);
    });
    return std::string("The knee, where more time buys ") + bought + ", is " + measures(*knee) + ": the point with the " + with_most + ", " +
           points[best].name + ", takes " + report::decimals(points[best].modelled_ms / points[*knee].modelled_ms, 2) + " times as long.";
}

}} // namespace tilemesh
