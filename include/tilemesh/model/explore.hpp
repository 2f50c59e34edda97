#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <tilemesh/config.hpp>
#include <vector>

// Points of a study: which of them no other one beats, and where more time stops to buy much.
namespace tilemesh { inline namespace v0_2 {

/// What a setting on a machine costs, and how far its pictures are off.
struct StudyPoint {
    std::string name;
    double psnr_db = 0;                ///< of the worst frame, against double precision without cut-offs; infinite for equal pictures
    double modelled_ms = 0;            ///< mean of the frames
    std::uint64_t sram_bytes = 0;      ///< that a tile uses
    std::uint64_t exchanged_bytes = 0; ///< by all tiles in all frames
    bool whole_channels = false;       ///< the bytes are those of whole channels, not of messages: only bytes of one kind are compared
    std::uint64_t lost = 0;            ///< records, copies and unfinished tiles that the pictures lack
    std::string left_out{};            ///< numbers of the machine that are unknown, so that the time is one "at least"
    std::string refused{};             ///< why the setting cannot run; then no number counts
    std::string map{};                 ///< with its views: points of different maps are not compared
};

/// Does `a` beat `b`: of the same map, no number is worse, and one is better? Bytes count if both points have them of one kind. A point that cannot
/// run, loses something, or whose time leaves something out, beats none.
TILEMESH_HOST bool beats(StudyPoint const& a, StudyPoint const& b) noexcept;

/// The Pareto front by error, time, SRAM and bytes exchanged: indices of the points that no other one beats, by time. Points that cannot run,
/// that lose something, or whose time leaves something out, are not on it. Cost: n^2 comparisons.
TILEMESH_HOST std::vector<std::size_t> front_of(std::span<StudyPoint const> points);

/// The points of one map on the front, by time.
struct MapFront {
    std::string map;
    std::vector<std::size_t> points;
};
/// The front of each map, in the order in which maps occur; empty for a map without a point on it.
TILEMESH_HOST std::vector<MapFront> fronts_of(std::span<StudyPoint const> points);

/// What a knee is, for readers of a report.
inline constexpr char knee_meaning[] =
    "The knee is where more time stops to buy much: of the points of the front of which each slower one has more gain, the one farthest above the "
    "straight line from the fastest of them to the slowest of them, both axes from 0 to 1. The gain is PSNR; if the whole front has one PSNR, it is "
    "less SRAM of a tile; if that is equal too, fewer bytes exchanged.";
/// The knee of one map's front, as `knee_meaning` says. Nothing if there are fewer than three such points. An infinite PSNR counts as 150 dB.
TILEMESH_HOST std::optional<std::size_t> knee_of(std::span<StudyPoint const> points, std::span<std::size_t const> front);

/// One sentence about the knee and its gain, or why there is none.
TILEMESH_HOST std::string knee_text(std::span<StudyPoint const> points, std::span<std::size_t const> front);

/// "loses 12", "at least: without vote", "does not run"; empty for a point that lacks nothing.
TILEMESH_HOST std::string mark_of(StudyPoint const& point);

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/explore_code.hpp>
#endif
