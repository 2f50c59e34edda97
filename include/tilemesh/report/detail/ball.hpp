#pragma once
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <tilemesh/config.hpp>

/// 1 if the host has numbers of 113 bits, and rounds each operation of doubles once.
#if FLT_EVAL_METHOD == 0 && (defined(__SIZEOF_FLOAT128__) || LDBL_MANT_DIG == 113)
#    define TILEMESH_HAS_QUAD 1
#else
#    define TILEMESH_HAS_QUAD 0
#endif

#if TILEMESH_HAS_QUAD
TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace report::detail {

/// A number of 113 bits, rounded to nearest (IEEE 754 binary128).
#    if defined(__SIZEOF_FLOAT128__)
__extension__ typedef __float128 Quad;
#    else
using Quad = long double;
#    endif

/// A real number as a ball: a middle in binary128 and a radius in double. Each operation encloses the exact result: the radius takes what the
/// operands' radii can do, and `quad_rounding` of the result for the rounding of the middle.
struct Ball {
    Quad v = 0;
    double r = 0;
    Ball() = default;
    Ball(float x) : v(x) {}
    Ball(double x) : v(x) {}
    Ball(int x) : v(x) {}
    Ball(Quad x, double radius) : v(x), r(radius) {}
};
/// Rounding to nearest is off by at most 2^-113 of the result; twice that, because the result is the rounded one.
inline constexpr double quad_rounding = 0x1p-112;

inline Quad magnitude(Quad v)
{
    return v < 0 ? -v : v;
}
/// |v| in double, not below. The conversion is off by 2^-53 of |v| or by 2^-1075; the product by 2^-53 again.
inline double size_of(Quad v)
{
    return static_cast<double>(magnitude(v)) * (1 + 0x1p-51) + 1e-300;
}
/// A radius that was added up in double, not below the exact sum: a radius has at most ten operations on values that are not negative.
inline double up(double r)
{
    return r * (1 + 0x1p-48) + 1e-300;
}

inline Ball operator-(Ball const& a)
{
    return {-a.v, a.r};
}
inline Ball operator+(Ball const& a, Ball const& b)
{
    Quad const v = a.v + b.v;
    return {v, up(a.r + b.r + quad_rounding * size_of(v))};
}
inline Ball operator-(Ball const& a, Ball const& b)
{
    return a + -b;
}
inline Ball operator*(Ball const& a, Ball const& b)
{
    Quad const v = a.v * b.v;
    return {v, up(size_of(a.v) * b.r + size_of(b.v) * a.r + a.r * b.r + quad_rounding * size_of(v))};
}
/// Infinite radius if the divisor may be 0.
inline Ball operator/(Ball const& a, Ball const& b)
{
    double const least = static_cast<double>(magnitude(b.v)) * (1 - 0x1p-51) - b.r;
    if (!(least > 0)) return {0, std::numeric_limits<double>::infinity()};
    Quad const v = a.v / b.v;
    return {v, up((a.r + size_of(v) * b.r) / least * (1 + 0x1p-50) + quad_rounding * size_of(v))};
}
inline double upper(Ball const& a)
{
    auto const m = static_cast<double>(a.v);
    return m + (std::fabs(m) * 0x1p-50 + up(a.r)) * (1 + 0x1p-50);
}
inline double lower(Ball const& a)
{
    return -upper(-a);
}
inline bool is_finite(Ball const& a)
{
    return std::isfinite(upper(a)) && std::isfinite(lower(a));
}

/// -1, 1, or nothing if the ball contains 0 or cannot say.
inline std::optional<int> sign(Ball const& a)
{
    Quad const r = a.r;
    if (a.v > r) return 1;
    if (a.v < -r) return -1;
    return std::nullopt;
}
/// A ball around both.
inline Ball hull(Ball const& a, Ball const& b)
{
    Quad const v = (a.v + b.v) / 2;
    double const ra = size_of(a.v - v) + a.r, rb = size_of(b.v - v) + b.r;
    return {v, up((ra > rb ? ra : rb) * (1 + 0x1p-40))};
}
inline Ball smaller(Ball const& a, Ball const& b)
{
    auto const s = sign(a - b);
    return !s ? hull(a, b) : *s < 0 ? a : b;
}
inline Ball larger(Ball const& a, Ball const& b)
{
    return -smaller(-a, -b);
}

/// e^x for |x| <= 100, by 2^10 squarings of a Taylor polynomial of degree 18: |x / 1024| < 0.1, and the rest of the series is below
/// 0.1^19 / 19! * 1.2 < 1.1e-36.
inline Ball exponential(Ball const& x)
{
    Ball const y{x.v / 1024, up(x.r / 1024 + quad_rounding * size_of(x.v / 1024))};
    Ball sum = 1;
    for (int k = 18; k > 0; --k) sum = Ball(1) + y * sum / Ball(k);
    sum.r = up(sum.r + 1.1e-36);
    for (int k = 0; k < 10; ++k) sum = sum * sum;
    return sum;
}
/// The root of x >= 0. The middle is Newton's; the square proves the radius: with s > 0, |s - root| = |s^2 - x| / (s + root) <= |s^2 - x| / s.
inline Ball root(Ball const& x)
{
    if (!(x.v > 0)) return {0, up(std::sqrt(up(size_of(x.v) + x.r)))};
    Quad s = std::sqrt(static_cast<double>(x.v));
    if (!(s > 0)) return {0, up(std::sqrt(up(size_of(x.v) + x.r)))};
    for (int k = 0; k < 3; ++k) s = (s + x.v / s) / 2;
    Ball const off = Ball(s, 0) * Ball(s, 0) - x;
    return {s, up((size_of(off.v) + off.r) / static_cast<double>(s) * (1 + 0x1p-40))};
}

/// A sum of doubles without rounding: components that do not overlap, of increasing size (Shewchuk 1997, Grow-Expansion).
class ExactSum {
public:
    /// At most 16 times.
    void add(double b)
    {
        int kept = 0;
        for (int i = 0; i < n_; ++i) { // two-sum (Knuth)
            double const a = part_[i], s = a + b, part_of_b = s - a, low = (a - (s - part_of_b)) + (b - part_of_b);
            if (low != 0) part_[kept++] = low;
            b = s;
        }
        if (b != 0) part_[kept++] = b;
        n_ = kept;
    }
    /// Adds the product of two floats, which is exact in double.
    void add_product(float a, float b, double factor) { add(factor * (double{a} * double{b})); }
    int sign() const { return n_ == 0 ? 0 : part_[n_ - 1] > 0 ? 1 : -1; }

private:
    double part_[16] = {};
    int n_ = 0;
};

}}} // namespace tilemesh::v0_2::report::detail
TILEMESH_EXACT_END
#endif
