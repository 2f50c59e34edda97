#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <tilemesh/config.hpp>
#include <tilemesh/track/normal_equations.hpp>

namespace tilemesh { inline namespace v0_2 { namespace track {

/// Are all sums of an evaluation finite, and is there anything to solve? Sums with a negative cost or diagonal are of no evaluation.
TILEMESH_HOST bool is_usable(NormalEquations const& e) noexcept;

/// Solves (H + lambda diag H) x = -g by Cholesky's decomposition: a step of Levenberg-Marquardt with Marquardt's diagonal (1963). Empty if
/// the sums are not usable, if the damped matrix is not positive definite, or if the step is not finite. An unknown that no row depends on
/// (a zero column) does not move.
///
/// These are 30 lines rather than a dependency on Eigen. The system has 6 or 8 unknowns, and it is solved about ten times a frame, so speed
/// does not matter. The order of all operations stands here, so that two builds take the same steps. Eigen vectorises by instruction set,
/// which changes the order of sums, and every user of these headers would have to install it.
TILEMESH_HOST std::optional<std::array<double, 8>> solve_damped(NormalEquations const& e, double lambda);

template <std::size_t N>
using SquareMatrix = std::array<std::array<double, N>, N>;
using Matrix6 = SquareMatrix<6>;

/// The eigenvalues of a symmetric matrix, ascending; `vectors[k]` is the unit eigenvector of `values[k]`.
template <std::size_t N>
struct Eigen {
    std::array<double, N> values{};
    SquareMatrix<N> vectors{};
};

/// Jacobi's method (Golub and Van Loan, section 8.5): rotations that zero one entry after the other. It keeps the relative digits of small
/// eigenvalues, and ends after at most 30 sweeps; 6 to 8 are usual.
template <std::size_t N>
Eigen<N> eigen_of(SquareMatrix<N> a)
{
    SquareMatrix<N> v{};
    for (std::size_t i = 0; i < N; ++i) v[i][i] = 1.0;
    for (int sweep = 0; sweep < 30; ++sweep) {
        double off = 0.0, all = 0.0;
        for (std::size_t i = 0; i < N; ++i)
            for (std::size_t j = 0; j < N; ++j) (i == j ? all : off) += a[i][j] * a[i][j];
        if (!(off > 1e-34 * all)) break;
        for (std::size_t p = 0; p + 1 < N; ++p)
            for (std::size_t q = p + 1; q < N; ++q) {
                if (a[p][q] == 0.0) continue;
                double const theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                double const t = (theta < 0.0 ? -1.0 : 1.0) / (std::fabs(theta) + std::hypot(theta, 1.0));
                double const c = 1.0 / std::hypot(t, 1.0), s = t * c;
                for (std::size_t k = 0; k < N; ++k) { // columns
                    double const kp = a[k][p], kq = a[k][q];
                    a[k][p] = c * kp - s * kq, a[k][q] = s * kp + c * kq;
                }
                for (std::size_t k = 0; k < N; ++k) { // rows
                    double const pk = a[p][k], qk = a[q][k];
                    a[p][k] = c * pk - s * qk, a[q][k] = s * pk + c * qk;
                    double const vp = v[p][k], vq = v[q][k];
                    v[p][k] = c * vp - s * vq, v[q][k] = s * vp + c * vq;
                }
            }
    }
    std::array<std::size_t, N> order{};
    for (std::size_t i = 0; i < N; ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return a[i][i] != a[j][j] ? a[i][i] < a[j][j] : i < j; });
    Eigen<N> out;
    for (std::size_t k = 0; k < N; ++k) {
        out.values[k] = a[order[k]][order[k]];
        out.vectors[k] = v[order[k]];
    }
    return out;
}

}}} // namespace tilemesh::track

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/track/detail/small_system_code.hpp>
#endif
