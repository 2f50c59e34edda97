#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/track/normal_equations.hpp>
#include <tilemesh/track/pose_accuracy.hpp>
#include <tilemesh/track/pose_solver.hpp>
#include <tilemesh/track/pose_update.hpp>
#include <tilemesh/track/tracker.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace track {

TILEMESH_HOST char const* name_of(Verdict verdict) noexcept
{
    return verdict == Verdict::converged ? "converged" : verdict == Verdict::weak ? "weak" : "lost";
}

TILEMESH_HOST Tracker::Tracker(scene::Intrinsics const& lens, double scale, scene::Pose const& start, TrackerOptions const& options)
    : lens_(lens), options_(options), scale_(scale), last_(start), before_(start)
{
    scene::check_camera(scene::make_camera(start, lens));
    scene::check_no_panorama(scene::make_camera(start, lens), "a pose's derivative");
    scene::check_no_shutter(scene::make_camera(start, lens), "a tracker without `readout`");
    if (!std::isfinite(scale) || !(scale > 0.0))
        throw Error("a camera cannot be tracked from here (the median depth of the map is not finite, or not positive); start where the map "
                    "is seen");
    if (!std::isfinite(options.readout) || options.readout < 0.0)
        throw Error("a camera that reads its rows in no time that is a number (readout; 0: all at once); give the time from the first row to the "
                    "last");
    for (std::uint32_t const cell : {options.coarsest, options.coarsest_wide})
        if (cell == 0 || cell > 64 || (cell & (cell - 1)) != 0)
            throw Error("cells of " + std::to_string(cell) +
                        " pixels cannot be tracked with (a pyramid halves them down to 1); choose 1, 2, 4, 8, 16, 32 or 64");
}

TILEMESH_HOST Tracker::State Tracker::state() const
{
    return {last_, before_, exposure_, now_, time_, interval_, last_cost_, last_pixels_, tracked_, wide_ ? std::uint64_t{1} : 0};
}

TILEMESH_HOST void Tracker::restore(State const& state)
{
    last_ = state.last, before_ = state.before, exposure_ = state.exposure;
    now_ = state.now, time_ = state.time, interval_ = state.interval;
    last_cost_ = state.last_cost, last_pixels_ = state.last_pixels;
    tracked_ = state.tracked;
    wide_ = state.wide != 0;
}

TILEMESH_HOST bool Tracker::stands_out(TrackedFrame const& frame, double ratio) const
{
    return frame.mean_cost > options_.harmless_cost && frame.mean_cost > ratio * last_cost_;
}

TILEMESH_HOST std::array<scene::Pose, 4> Tracker::other_starts(double steps, bool moves) const
{
    auto const ahead = predicted(before_, last_, steps);
    double const along = 2.0 * steps * glm::length(twist_between(before_, last_).rho);
    return {predicted(before_, last_, 2.0 * steps), moved(ahead, {{0.0, 0.0, along}, {}}), moved(ahead, {{0.0, 0.0, -along}, {}}), 
            moves ? last_ : ahead};
}

TILEMESH_HOST void Tracker::judge(TrackedFrame& frame, double share) const
{
    auto const& s = frame.solution;
    if (s.ending == Ending::unusable) {
        frame.why = s.refusal.empty() ? "no pixel could be compared, or the sums are not finite" : s.refusal;
        return;
    }
    frame.mean_cost = detail::mean_cost(s.at);
    frame.accuracy = accuracy_of(s.at, std::max(lens_.fx, lens_.fy), options_.rows_per_pixel, options_.weak);
    if (tracked_ > 0 && s.at.pixels < share * options_.least_pixels * last_pixels_) frame.why = "most of the view has left the map";
    else if (s.at.unknowns == 8 && options_.exposure.reached(s.exposure)) frame.why = "only an exposure beyond its limits explains the picture";
    else if (frame.mean_cost > options_.most_cost) frame.why = "the picture does not match the map at any pose nearby";
    else if (tracked_ > 0 && stands_out(frame, options_.lost_cost_ratio))
        frame.why = "the picture does not match the map at any pose nearby";
    else if (s.ending == Ending::stalled) frame.why = "no step lowers the cost";
    // Along a motion that nothing determines, steps may never become short; all other motions are found.
    else if (s.ending == Ending::spent && s.last_step_px > options_.harmless_step_px && frame.accuracy.conditioning > options_.weak.conditioning)
        frame.why = "the steps do not become short";
    else if (frame.accuracy.weak_count() > 5) frame.why = "the picture determines no motion";
    else {
        frame.verdict = frame.accuracy.is_weak() ? Verdict::weak : Verdict::converged;
        frame.why = weak_motions(frame.accuracy);
    }
}

}}} // namespace tilemesh::track
