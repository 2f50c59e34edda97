#pragma once
#include <cmath>
#include <cstdint>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/track/normal_equations.hpp>
#include <tilemesh/track/pose_accuracy.hpp>
#include <tilemesh/track/pose_solver.hpp>
#include <tilemesh/track/pose_update.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace track {

/// What a tracker says of a frame. `weak`: it converged, or would have, but the picture leaves at least one motion open. `lost`: its pose is
/// a prediction, not a measurement.
enum class Verdict { converged, weak, lost };

inline char const* name_of(Verdict verdict) noexcept
{
    return verdict == Verdict::converged ? "converged" : verdict == Verdict::weak ? "weak" : "lost";
}

/// How a tracker follows a camera.
struct TrackerOptions {
    Method method = Method::hybrid;
    std::uint32_t coarsest = 4;      ///< cell, from frame to frame: a power of two
    std::uint32_t coarsest_wide = 8; ///< cell of the first frame, and of frames after a lost one, which take `hybrid` in place of `forward`
    bool constant_velocity = true;   ///< start each frame where the last step leads; else from the last pose
    double rows_per_pixel = 3.0;     ///< residuals of a pixel: 3 for colour, 4 with depth
    WeakLimits weak{};
    /// A frame is lost if its mean cost is above this multiple of the last tracked frame's: three times its residuals. In a wrong minimum they
    /// are five to ten times as large.
    double lost_cost_ratio = 9.0;
    /// A mean cost up to this never makes a frame lost. It is that of three channels that are off by 0.01 each.
    double harmless_cost = 1.5e-4;
    /// A frame is lost if less than this share of the last tracked frame's pixels counts.
    double least_pixels = 0.5;
    /// A solver that used up its evaluations has converged if its last step was below this many pixels.
    double harmless_step_px = 0.1;
};

/// A frame that was tracked, or lost.
struct TrackedFrame {
    Verdict verdict = Verdict::lost;
    std::string why;         ///< in words: "along the view" for weak, the reason for lost, empty for converged
    scene::Pose pose;        ///< always finite; the prediction if the frame is lost
    scene::Pose start;       ///< where the solver began
    Exposure exposure{};
    PoseAccuracy accuracy{}; ///< only if the frame is not lost
    double mean_cost = 0.0;  ///< of the counted pixels at the end, in full resolution
    Solution solution{};     ///< what the solver found, also for a lost frame
};

/// Follows one camera through frames, each from the last: no map update, no loop closure, no relocalisation over the whole map. It knows
/// neither map nor mesh: for each frame it takes an evaluator of poses against that frame's target.
///
/// The first frame has nothing to be compared with: it counts as tracked wherever the solver converges, so `start` must be good.
///
/// A lost frame changes nothing in the state: the next frame starts from the last tracked pose, at rest, on the wide pyramid.
class Tracker {
public:
    /// `scale` is S, the median depth of the map in the view, in world units; `start` is the guess for the first frame. Throws `Error` for a
    /// scale or a pose that is not finite, a scale that is not positive, and a coarsest cell that is no power of two up to 64.
    Tracker(scene::Intrinsics const& lens, double scale, scene::Pose const& start, TrackerOptions const& options = {})
        : lens_(lens), options_(options), scale_(scale), last_(start), before_(start)
    {
        bool finite = std::isfinite(scale) && scale > 0.0;
        for (int i = 0; i < 3; ++i) {
            finite = finite && std::isfinite(start.position[i]);
            for (int j = 0; j < 3; ++j) finite = finite && std::isfinite(start.rotation[i][j]);
        }
        if (!finite) throw Error("a camera cannot be tracked from here (the pose or the median depth of the map is not finite, or the depth not positive); start where the map is seen");
        for (std::uint32_t const cell : {options.coarsest, options.coarsest_wide})
            if (cell == 0 || cell > 64 || (cell & (cell - 1)) != 0)
                throw Error("cells of " + std::to_string(cell) + " pixels cannot be tracked with (a pyramid halves them down to 1); choose 1, 2, 4, 8, 16, 32 or 64");
    }

    /// Tracks the next frame. `steps` is its distance in time from the last frame, in units of the distance between the two frames before.
    template <Evaluator Evaluate>
    TrackedFrame track(Evaluate&& evaluate, double steps = 1.0)
    {
        TrackedFrame frame;
        frame.start = options_.constant_velocity && !wide_ ? predicted(before_, last_, steps) : last_;
        auto const method = wide_ && options_.method == Method::forward ? Method::hybrid : options_.method;
        auto const stages = stages_of(method, wide_ ? options_.coarsest_wide : options_.coarsest);
        frame.solution = solve_pose(evaluate, frame.start, lens_, scale_, stages, exposure_);
        judge(frame);
        if (frame.verdict == Verdict::lost) {
            frame.pose = frame.start;
            frame.exposure = exposure_;
            wide_ = true;
            return frame;
        }
        frame.pose = frame.solution.pose;
        frame.exposure = exposure_ = frame.solution.exposure;
        before_ = wide_ ? frame.pose : last_; // at rest after a gap: nobody knows how long it was
        last_ = frame.pose;
        last_cost_ = frame.mean_cost;
        last_pixels_ = frame.solution.at.pixels;
        wide_ = false;
        ++tracked_;
        return frame;
    }

private:
    void judge(TrackedFrame& frame) const
    {
        auto const& s = frame.solution;
        if (s.ending == Ending::unusable) {
            frame.why = "no pixel could be compared, or the sums are not finite";
            return;
        }
        frame.mean_cost = detail::mean_cost(s.at);
        frame.accuracy = accuracy_of(s.at, std::max(lens_.fx, lens_.fy), options_.rows_per_pixel, options_.weak);
        if (tracked_ > 0 && s.at.pixels < options_.least_pixels * last_pixels_) frame.why = "most of the view has left the map";
        else if (tracked_ > 0 && frame.mean_cost > options_.harmless_cost && frame.mean_cost > options_.lost_cost_ratio * last_cost_)
            frame.why = "the picture does not match the map at any pose nearby";
        else if (s.ending == Ending::stalled) frame.why = "no step lowers the cost";
        // Along a motion that nothing determines, steps may never become short; all other motions are found.
        else if (s.ending == Ending::spent && s.last_step_px > options_.harmless_step_px && frame.accuracy.conditioning > options_.weak.conditioning)
            frame.why = "the steps do not become short";
        else {
            frame.verdict = frame.accuracy.is_weak() ? Verdict::weak : Verdict::converged;
            frame.why = weak_motions(frame.accuracy);
        }
    }

    scene::Intrinsics lens_;
    TrackerOptions options_;
    double scale_;
    scene::Pose last_, before_;
    Exposure exposure_{};
    double last_cost_ = 0.0;
    std::uint32_t last_pixels_ = 0;
    std::uint64_t tracked_ = 0;
    bool wide_ = true; ///< before the first tracked frame, and after a lost one
};

}}} // namespace tilemesh::track
