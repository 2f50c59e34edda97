#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/track/normal_equations.hpp>
#include <tilemesh/track/pose_update.hpp>
#include <tilemesh/track/small_system.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace track {

/// Which derivative each level of a pyramid takes. `hybrid` converges from far away with `esm` on coarse cells, and ends with `forward`,
/// which is best on noise.
enum class Method { hybrid, forward, gradient, esm };

/// A level of the pyramid, with its bounds. `stop_px` is in cells: a level ends with a step below it, which is taken but not evaluated.
struct Stage {
    std::uint32_t cell;
    Jacobian jacobian;
    double stop_px;
    std::uint32_t most_evaluations;
};

/// Cells of `coarsest` pixels, then half as wide until 1: 8, 4, 2, 1. `coarsest` is a power of two. All are means over cells of the full
/// picture; the last level is always the full picture, because a smaller rendering would be biased. From 8 a start may be off by 5 to 10
/// degrees, from 4 by 2 to 5, at 1 by half a pixel.
///
/// A coarse level ends below a quarter of its cells, or after 12 evaluations: the next level begins with half a cell of its own, well within
/// its reach. The last level ends below 0.01 pixels, or after 30.
TILEMESH_HOST std::vector<Stage> stages_of(Method method, std::uint32_t coarsest);

/// Why the solver ended its last level.
enum class Ending {
    small_step,  ///< the step was below the level's limit
    rejections,  ///< several small steps in a row did not lower the cost, which has steps of its own at the cuts of blending: convergence
    stalled,     ///< no step of any length lowered the cost, far from a minimum
    spent,       ///< the level's evaluations were used up
    unusable     ///< the first sums of the last level were not finite, empty or all zero
};

/// How far the exposure may go. Without limits, a gain of 0 explains every picture.
struct ExposureLimits {
    double log_gain = 2.7725887222397811; ///< at most 16 times as bright or as dark: four stops
    double offset = 0.25;                 ///< a quarter of white, either way

    bool reached(Exposure const& e) const noexcept { return !(std::fabs(e.log_gain) < log_gain && std::fabs(e.offset) < offset); }
};

/// The pose that the solver found, and its last evaluation.
struct Solution {
    scene::Pose pose;
    Exposure exposure{};
    NormalEquations at{};            ///< on the last level, at this pose or less than `stop_px` before it; only if `ending` is not `unusable`
    Ending ending = Ending::unusable; ///< of the last level
    double last_step_px = 0.0;       ///< the last step that the last level tried, in pixels
    std::uint32_t evaluations = 0;   ///< of all levels
    std::uint32_t steps = 0;         ///< taken, of all levels
    std::string refusal{};           ///< the text of the evaluator's last `NoRoom`; empty if there was none

    bool converged() const noexcept { return ending == Ending::small_step || ending == Ending::rejections; }
};

namespace detail {

/// Levenberg-Marquardt's constants. The damping starts small, because a prediction is near; after a bad step it grows faster than it shrinks.
inline constexpr double first_lambda = 1e-4;
inline constexpr double better_factor = 0.2;
inline constexpr double worse_factor = 10.0;
inline constexpr double least_lambda = 1e-9;
inline constexpr double most_lambda = 1e8;
/// With at most this damping, a step is at most a tenth shorter than Gauss and Newton's along each axis.
inline constexpr double free_lambda = 0.1;
/// A step below one cell is near the end: there the picture is close to linear.
inline constexpr double near_cells = 1.0;
/// So many rejected steps in a row near the end are convergence. Each shortens the next tenfold, so the fourth is below a thousandth of a cell.
inline constexpr std::uint32_t most_rejections = 4;
/// A step that changes the brightness by more, a quarter of an 8-bit level, changes the residuals: the last level evaluates it.
inline constexpr double noticeable_exposure = 0.25 / 255.0;
/// No step turns the camera, or moves it in units of the median depth, by more: half a radian is the picture's half width.
inline constexpr double longest_step = 0.5;

TILEMESH_HOST double mean_cost(NormalEquations const& e) noexcept;

/// A damped step that keeps the exposure within its limits: an unknown that would leave them goes to the limit, and the others take the step
/// that is best with it there.
TILEMESH_HOST std::optional<std::array<double, 8>> bounded_step(NormalEquations e, double lambda, Exposure const& exposure,
                                                                ExposureLimits const& limits);

} // namespace detail

/// Finds the pose with the least mean cost from `start`, level by level (Levenberg-Marquardt). `scale` is S, the map's median depth in the
/// view. A step counts only if the sums are finite, the mean cost falls, and the pixels that count are more than half of the most that
/// counted on this level: leaving the map wins nothing.
///
/// A step below the level's limit ends the level. It is taken and not evaluated: the next level begins with an evaluation there, and after
/// the last level it is below 0.01 pixels. Only if the last level's step changes the exposure as well, it is evaluated like any other.
///
/// The pose of the result is always finite. If no level is usable, it is `start`. Cost: `Solution::evaluations` calls of `evaluate`.
template <Evaluator Evaluate>
Solution solve_pose(Evaluate&& evaluate, scene::Pose const& start, scene::Intrinsics const& lens, double scale,
                    std::vector<Stage> const& stages, Exposure const& exposure = {}, ExposureLimits const& limits = {})
{
    Solution out{start, exposure};
    for (auto const& stage : stages) {
        bool const is_last = &stage == &stages.back();
        auto const ask = [&](scene::Pose const& pose, Exposure const& light) {
            ++out.evaluations;
            try {
                return static_cast<NormalEquations>(evaluate(scene::make_camera(pose, lens), Level{stage.cell, stage.jacobian, light}));
            } catch (NoRoom const& refusal) {
                out.refusal = refusal.what();
                return NormalEquations{};
            }
        };
        NormalEquations now = ask(out.pose, out.exposure);
        out.ending = Ending::unusable;
        if (!is_usable(now)) continue;
        out.ending = Ending::spent;
        std::uint32_t most_pixels = now.pixels, rejected = 0;
        double lambda = detail::first_lambda, first_rejected_px = 0.0;
        for (std::uint32_t used = 1;;) {
            if (lambda > detail::most_lambda) {
                out.ending = Ending::stalled;
                break;
            }
            auto const solved = detail::bounded_step(now, lambda, out.exposure, limits);
            if (!solved) {
                lambda *= detail::worse_factor;
                continue;
            }
            auto x = *solved;
            double const turn = std::hypot(x[3], x[4], x[5]), shift = std::hypot(x[0], x[1], x[2]);
            double const longest = std::max(turn, shift);
            for (double& each : x) each *= longest > detail::longest_step ? detail::longest_step / longest : 1.0;
            double const step_px = std::max(lens.fx, lens.fy) / stage.cell * std::min(turn + shift, 2.0 * detail::longest_step);

            scene::Pose const pose = moved(out.pose, {scale * glm::dvec3{x[0], x[1], x[2]}, {x[3], x[4], x[5]}});
            Exposure const light{std::clamp(out.exposure.log_gain + x[6], -limits.log_gain, limits.log_gain),
                                 std::clamp(out.exposure.offset + x[7], -limits.offset, limits.offset)};
            // A step that only the damping makes short is no convergence. After a rejection near the end, a short step is not tried again.
            bool const is_short = step_px < stage.stop_px && (rejected == 0 ? lambda <= detail::free_lambda : first_rejected_px < detail::near_cells);
            bool const brighter = is_last && std::fabs(x[6]) + std::fabs(x[7]) > detail::noticeable_exposure;
            if (is_short && (rejected != 0 || !brighter)) {
                if (rejected == 0) {
                    out.pose = pose;
                    out.exposure = light;
                    out.last_step_px = step_px * stage.cell;
                    ++out.steps;
                }
                out.ending = Ending::small_step;
                break;
            }
            if (used >= stage.most_evaluations) break;
            out.last_step_px = step_px * stage.cell;
            NormalEquations const trial = ask(pose, light);
            ++used;
            bool const better = is_usable(trial) && 2 * std::uint64_t{trial.pixels} > most_pixels &&
                                detail::mean_cost(trial) < detail::mean_cost(now);
            if (better) {
                out.pose = pose;
                out.exposure = light;
                now = trial;
                most_pixels = std::max(most_pixels, trial.pixels);
                lambda = std::max(lambda * detail::better_factor, detail::least_lambda);
                ++out.steps;
                rejected = 0;
            } else {
                if (rejected++ == 0) first_rejected_px = step_px;
                lambda *= detail::worse_factor;
            }
            if (rejected >= detail::most_rejections && first_rejected_px < detail::near_cells) {
                out.ending = Ending::rejections;
                break;
            }
        }
        out.at = now;
    }
    return out;
}

}}} // namespace tilemesh::track

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/track/detail/pose_solver_code.hpp>
#endif
