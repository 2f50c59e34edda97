#pragma once
#include <cstdint>
#include <tilemesh/error.hpp>
#include <tilemesh/splat/camera.hpp>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 { namespace track {

/// How an evaluator finds the derivative of a pixel by the pose. `forward` differentiates the compositing itself; it converges from about
/// half a pixel of error per cell, and is best on noise. `gradient` takes the gradients of the composited picture. `esm` averages these
/// with the gradients of the target (efficient second-order minimisation, Benhimane and Malis 2004); it converges from farthest away.
enum class Jacobian : std::uint32_t { forward, gradient, esm };

/// The change of brightness between the map and a target: the target shows e^log_gain * C + offset where the map has the colour C.
struct Exposure {
    double log_gain = 0.0, offset = 0.0;
};

/// What one evaluation shall compute. Residuals and derivatives are averaged over cells of `cell` x `cell` pixels of the full picture.
struct Level {
    std::uint32_t cell = 1;
    Jacobian jacobian = Jacobian::forward;
    Exposure exposure{}; ///< of the residuals: e^log_gain * C + offset - target
};

/// The sums of one evaluation of a pose, over the rows that count: J is the derivative of a residual r, w its weight.
///
/// The unknowns are, in this order: rho_x, rho_y, rho_z in units of the map's median depth S, phi_x, phi_y, phi_z in radians, and with
/// exposure log_gain and offset. A point of view space moves by d = S rho + phi x p. Entries beyond `unknowns` are 0.
struct NormalEquations {
    std::uint32_t unknowns = 6; ///< 6, or 8 with exposure
    double h[8][8] = {};        ///< the sum of w J^T J, symmetric, both halves filled
    double g[8] = {};           ///< the sum of w J^T r
    double cost = 0.0;          ///< the sum of the robust costs; w r^2 / 2 for small residuals
    std::uint32_t pixels = 0;   ///< the rows that counted; with depth, a pixel has one row of colour and one of depth: it counts once
};

/// What an evaluator throws for a view that it has no room for. It can evaluate other views afterwards.
class NoRoom : public Error {
public:
    using Error::Error;
};

/// An evaluator of poses: a callable with this form. It must be deterministic. A tracker calls it with poses that were rounded to the
/// camera's floats. It may return sums that are not finite, and it may throw `NoRoom`: then the tracker refuses the step.
template <class F>
concept Evaluator = std::is_invocable_r_v<NormalEquations, F&, splat::Camera const&, Level const&>;

}}} // namespace tilemesh::track
