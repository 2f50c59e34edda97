#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/track/normal_equations.hpp>
#include <tilemesh/track/pose_accuracy.hpp>
#include <tilemesh/track/pose_solver.hpp>
#include <tilemesh/track/pose_update.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace track {

/// What a tracker says of a frame. `weak`: it converged, or would have, but the picture leaves one to five motions open. `lost`: its pose is
/// a prediction, not a measurement.
enum class Verdict { converged, weak, lost };

TILEMESH_HOST char const* name_of(Verdict verdict) noexcept;

/// How a tracker follows a camera.
struct TrackerOptions {
    Method method = Method::hybrid;
    std::uint32_t coarsest = 4;      ///< cell, from frame to frame: a power of two
    std::uint32_t coarsest_wide = 8; ///< cell of the first frame, and of frames after a lost one, which take `hybrid` in place of `forward`
    /// The time in which the camera reads all rows of a picture, in units of the frames' time; 0: all at once. A frame is then solved twice: with
    /// the shutter (`splat::Shutter`) of the last two tracked poses, and with that of the way to the pose that this finds; the one with the
    /// lower cost counts. The first frame, and the first after a lost one, are solved once and without a shutter: nobody knows the motion. So
    /// is the first solution of a frame that starts at rest, and one whose shutter would turn farther than a camera may (`scene::check_camera`).
    double readout = 0.0;
    bool constant_velocity = true;   ///< start each frame where the last step leads; else from the last pose
    double rows_per_pixel = 3.0;     ///< residuals of a pixel: 3 for colour, 4 with depth
    WeakLimits weak{};
    /// A frame whose mean cost is above this multiple of the last tracked frame's is solved again from up to four other starts. The least cost
    /// wins. A splat that comes through the near plane between the start and the frame makes a wrong minimum, which no derivative shows. On
    /// Salad along fr2_desk, the cost there was at least 5.6 times that of the frame before. Before the first such frame, 990 frames cost at
    /// most 1.8 times as much as the one before; blurred ones of every third pose up to 3.4 times.
    double second_look_ratio = 3.0;
    /// A frame is lost if its mean cost is above this multiple of the last tracked frame's.
    double lost_cost_ratio = 5.0;
    /// A mean cost up to this never makes a frame lost. It is that of three channels that are off by 0.01 each.
    double harmless_cost = 1.5e-4;
    /// A mean cost above this makes any frame lost, also the first. It is Huber's cost of three channels that are off by a quarter of white
    /// each, the width being 0.1.
    double most_cost = 0.06;
    /// A frame is lost if less than this share of the last tracked frame's pixels counts.
    double least_pixels = 0.5;
    /// A frame is lost if its exposure is at one of these limits: then a picture without the map's structure, such as a black one, fits best.
    ExposureLimits exposure{};
    /// A frame later than so many times the time between the last two tracked frames starts like one after a lost frame.
    double most_ahead = 8.0;
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
    splat::Shutter shutter{}; ///< with which it was seen; the pose is that of the row of the centre
    PoseAccuracy accuracy{}; ///< only if the frame is not lost
    double mean_cost = 0.0;  ///< of the counted pixels at the end, in full resolution
    Solution solution{};     ///< what the solver found, also for a lost frame
};

/// Follows one camera through frames, each from the last: no map update, no loop closure, no relocalisation over the whole map. It knows
/// neither map nor mesh: for each frame it takes an evaluator of poses against that frame's target.
///
/// The first frame has no frame before it to be compared with: it counts as tracked wherever the solver converges below `most_cost`, so
/// `start` must be good.
///
/// A lost frame changes nothing in the state: the next frame starts from the last tracked pose, at rest, on the wide pyramid. A frame
/// whose start the evaluator has no room for (`NoRoom`) is lost, too. A copy of a tracker has its whole state, so a caller may keep one, and
/// track a lost frame again from there.
class Tracker {
public:
    /// `scale` is S, the median depth of the map in the view, in world units; `start` is the guess for the first frame. Throws `Error` for a
    /// camera that no frame can be rendered with, a scale that is not finite or not positive, and a coarsest cell that is no power of two up
    /// to 64.
    TILEMESH_HOST Tracker(scene::Intrinsics const& lens, double scale, scene::Pose const& start,
                          TrackerOptions const& options = {});

    /// Tracks the next frame. `steps` is its distance in time from the frame before, in units of the caller; the prediction grows with it.
    template <Evaluator Evaluate>
    TrackedFrame track(Evaluate&& evaluate, double steps = 1.0)
    {
        return track_at(evaluate, now_ + steps);
    }

    /// Tracks the frame of this time stamp. The prediction goes on at the velocity between the last two tracked frames, for as long as the
    /// stamps say. A frame with the stamp of the last one starts at its pose and leaves the velocity as it was. A frame that is earlier, or
    /// much later (`most_ahead`), starts at the last pose, at rest, on the wide pyramid. A stamp that is not finite counts as the last one.
    ///
    /// `share` is the share of the pixels that the evaluator looks at: 0.1 for one block in 10.
    template <Evaluator Evaluate>
    TrackedFrame track_at(Evaluate&& evaluate, double seconds, double share = 1.0)
    {
        now_ = std::isfinite(seconds) ? seconds : now_;
        double const gap = tracked_ > 0 ? now_ - time_ : 0.0;
        bool const wide = wide_ || gap < 0.0 || (interval_ > 0.0 && gap > options_.most_ahead * interval_);
        bool const moves = options_.constant_velocity && !wide && interval_ > 0.0;

        auto const method = wide && options_.method == Method::forward ? Method::hybrid : options_.method;
        auto const stages = stages_of(method, wide ? options_.coarsest_wide : options_.coarsest);
        auto const attempt = [&](scene::Pose const& start) {
            TrackedFrame tried;
            tried.start = start, tried.shutter = lens_.shutter;
            tried.solution = solve_pose(evaluate, start, lens_, scale_, stages, exposure_, options_.exposure);
            judge(tried, share);
            return tried;
        };
        auto const roll = [&](scene::Pose const& from, scene::Pose const& to, double time) -> bool {
            lens_.shutter = {};
            if (!(options_.readout > 0.0 && time > 0.0)) return false;
            auto rolling = lens_;
            rolling.shutter = scene::rolling_shutter(from, to, time / options_.readout, lens_, to);
            try {
                scene::check_camera(scene::make_camera(to, rolling));
            } catch (Error const&) { // it turns farther, while it reads, than a frame can show
                return false;
            }
            lens_ = rolling;
            return true;
        };
        roll(before_, last_, moves ? interval_ : 0.0);
        auto frame = attempt(moves ? predicted(before_, last_, gap / interval_) : last_);
        // Also where the first solution is lost: the shutter of a motion that began just now may be what is missing.
        if (options_.readout > 0.0 && tracked_ > 0 && !wide && gap > 0.0 && frame.solution.ending != Ending::unusable) {
            if (roll(last_, frame.solution.pose, gap)) {
                auto again = attempt(frame.solution.pose);
                again.start = frame.start;
                auto const evaluations = again.solution.evaluations + frame.solution.evaluations;
                bool const better = frame.verdict == Verdict::lost || again.mean_cost <= frame.mean_cost;
                if (again.verdict != Verdict::lost && better) frame = again;
                else lens_.shutter = frame.shutter;
                frame.solution.evaluations = evaluations;
            } else {
                lens_.shutter = frame.shutter;
            }
        }
        if (interval_ > 0.0 && gap > 0.0 && gap <= options_.most_ahead * interval_)
            for (auto const& start : other_starts(gap / interval_, moves)) {
                if (!stands_out(frame, options_.second_look_ratio)) break;
                auto other = attempt(start);
                other.solution.evaluations += frame.solution.evaluations;
                if (other.verdict != Verdict::lost && (frame.verdict == Verdict::lost || other.mean_cost < frame.mean_cost)) frame = other;
                frame.solution.evaluations = other.solution.evaluations;
            }
        if (frame.verdict == Verdict::lost) {
            frame.pose = frame.start;
            frame.exposure = exposure_;
            wide_ = true;
            return frame;
        }
        frame.pose = frame.solution.pose;
        frame.exposure = exposure_ = frame.solution.exposure;
        if (wide || tracked_ == 0) interval_ = 0.0; // at rest after a gap: the motion in it is unknown
        else if (gap > 0.0) before_ = last_, interval_ = gap;
        else if (interval_ > 0.0) before_ = moved(frame.pose, twist_between(last_, before_)); // the old velocity, at the new pose
        last_ = frame.pose;
        time_ = now_;
        last_cost_ = frame.mean_cost;
        last_pixels_ = frame.solution.at.pixels / share;
        wide_ = false;
        ++tracked_;
        return frame;
    }

    /// What the next frame depends on, besides the options: for a run that goes on in another process.
    struct State {
        scene::Pose last, before;
        Exposure exposure{};
        double now = 0.0, time = 0.0, interval = 0.0, last_cost = 0.0, last_pixels = 0.0;
        std::uint64_t tracked = 0;
        std::uint64_t wide = 1; ///< 0 or 1
    };
    TILEMESH_HOST State state() const;
    /// Goes on where another tracker with the same lens, scale and options had this state.
    TILEMESH_HOST void restore(State const& state);

private:
    TILEMESH_HOST bool stands_out(TrackedFrame const& frame, double ratio) const;
    /// Starts around the prediction, `steps` steps from the last pose: as far again, two steps along the view to both sides, and at rest (or,
    /// where the frame began at rest, the prediction).
    TILEMESH_HOST std::array<scene::Pose, 4> other_starts(double steps, bool moves) const;
    TILEMESH_HOST void judge(TrackedFrame& frame, double share) const;

    scene::Intrinsics lens_;
    TrackerOptions options_;
    double scale_;
    scene::Pose last_, before_;
    Exposure exposure_{};
    double now_ = 0.0, time_ = 0.0; ///< of the last frame, and of the last tracked frame
    double interval_ = 0.0;         ///< the time from `before_` to `last_`; 0: at rest
    double last_cost_ = 0.0;
    double last_pixels_ = 0.0;      ///< as if the evaluator had looked at all pixels
    std::uint64_t tracked_ = 0;
    bool wide_ = true; ///< before the first tracked frame, and after a lost one
};

}}} // namespace tilemesh::track

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/track/detail/tracker_code.hpp>
#endif
