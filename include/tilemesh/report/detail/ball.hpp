#pragma once
#include <cfloat>
#include <cmath>
#include <limits>
#include <optional>
#include <tilemesh/config.hpp>

/// 1 if the host rounds each operation of doubles once.
#if FLT_EVAL_METHOD == 0
#    define TILEMESH_HAS_BALLS 1
#else
#    define TILEMESH_HAS_BALLS 0
#endif

#if TILEMESH_HAS_BALLS
TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace report::detail {

/// A number of more than 100 bits: the sum of two doubles of which the first is the rounded sum (Dekker 1971). u = 2^-53, so |lo| <= u |hi|.
struct Wide {
    double hi = 0, lo = 0;
    constexpr Wide() = default;
    constexpr Wide(double x) : hi(x) {}
    constexpr Wide(double h, double l) : hi(h), lo(l) {}
    constexpr explicit operator double() const { return hi; }
};
/// The sum of two doubles is the result, exactly (Knuth 1969).
inline Wide two_sum(double a, double b)
{
    double const s = a + b, b_in_s = s - a;
    return {s, (a - (s - b_in_s)) + (b - b_in_s)};
}
/// The same for |a| >= |b| (Dekker 1971).
inline Wide fast_two_sum(double a, double b)
{
    double const s = a + b;
    return {s, b - (s - a)};
}
/// The product of two doubles is the result, exactly, if nothing underflows: halves of 26 bits (Veltkamp 1968, Dekker 1971). Not finite from
/// 2^996 on.
inline Wide two_product(double a, double b)
{
    constexpr double half = 0x1p27 + 1;
    double const p = a * b, ca = half * a, cb = half * b;
    double const a1 = ca - (ca - a), a2 = a - a1, b1 = cb - (cb - b), b2 = b - b1;
    return {p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2};
}
inline Wide operator-(Wide const& a)
{
    return {-a.hi, -a.lo};
}
/// Off by at most 3 u^2 + 13 u^3 of the sum, whatever the signs (Joldes, Muller, Popescu 2017, AccurateDWPlusDW).
inline Wide operator+(Wide const& a, Wide const& b)
{
    Wide const s = two_sum(a.hi, b.hi), t = two_sum(a.lo, b.lo);
    Wide const v = fast_two_sum(s.hi, s.lo + t.hi);
    return fast_two_sum(v.hi, t.lo + v.lo);
}
inline Wide operator-(Wide const& a, Wide const& b)
{
    return a + -b;
}
/// Off by at most 9 u^2 of the product: lo lo is left out (1), the two mixed products are rounded (2), their sum (2), and that with the product's
/// low part (3).
inline Wide operator*(Wide const& a, Wide const& b)
{
    Wide const p = two_product(a.hi, b.hi);
    return fast_two_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}
/// Off by at most 18 u^2 of the quotient. The rest a - q b is at most 3 u of a, and off by 9 u^2 of a; its low part (3), the low part of b (3) and
/// the rounding of the second quotient (3) are left out.
inline Wide operator/(Wide const& a, Wide const& b)
{
    double const q = a.hi / b.hi;
    Wide const rest = a - b * Wide(q);
    return fast_two_sum(q, rest.hi / b.hi);
}
inline bool operator<(Wide const& a, Wide const& b)
{
    return a.hi < b.hi || (a.hi == b.hi && a.lo < b.lo);
}
inline bool operator>(Wide const& a, Wide const& b)
{
    return b < a;
}
/// Times a power of two, exactly.
inline Wide scaled(Wide const& a, double power_of_two)
{
    return {a.hi * power_of_two, a.lo * power_of_two};
}

/// A real number as a ball: a middle of two doubles and a radius in double. Each operation encloses the exact result: the radius takes what the
/// operands' radii can do, and `wide_rounding` of the result for the rounding of the middle.
struct Ball {
    Wide v;
    double r = 0;
    Ball() = default;
    Ball(float x) : v(x) {}
    Ball(double x) : v(x) {}
    Ball(int x) : v(double{1} * x) {}
    Ball(Wide const& x, double radius) : v(x), r(radius) {}
};
/// 32 u^2, above the 18 u^2 of the worst operation. What underflow takes, at most 2^-1000 an operation, is in `up`; a quotient has its own term.
inline constexpr double wide_rounding = 0x1p-101;

/// |v| in double, not below: |lo| <= u |hi|, and the product is off by u again.
inline double size_of(Wide const& v)
{
    return std::fabs(v.hi) * (1 + 0x1p-51) + 1e-300;
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
    Wide const v = a.v + b.v;
    return {v, up(a.r + b.r + wide_rounding * size_of(v))};
}
inline Ball operator-(Ball const& a, Ball const& b)
{
    return a + -b;
}
inline Ball operator*(Ball const& a, Ball const& b)
{
    Wide const v = a.v * b.v;
    return {v, up(size_of(a.v) * b.r + size_of(b.v) * a.r + a.r * b.r + wide_rounding * size_of(v))};
}
/// Infinite radius if the divisor may be 0.
inline Ball operator/(Ball const& a, Ball const& b)
{
    double const least = std::fabs(b.v.hi) * (1 - 0x1p-51) - b.r;
    if (!(least > 0)) return {Wide(0), std::numeric_limits<double>::infinity()};
    Wide const v = a.v / b.v;
    return {v, up((a.r + size_of(v) * b.r + 0x1p-1000) / least * (1 + 0x1p-50) + wide_rounding * size_of(v))};
}
inline double upper(Ball const& a)
{
    auto const m = a.v.hi;
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
    Wide const r = a.r;
    if (a.v > r) return 1;
    if (a.v < -r) return -1;
    return std::nullopt;
}
/// A ball around both.
inline Ball hull(Ball const& a, Ball const& b)
{
    Wide const v = scaled(a.v + b.v, 0.5);
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

/// e^x for |x| <= 100, by 10 squarings of a Taylor polynomial of degree 16: |x / 1024| < 0.1, and the rest of the series is below
/// 0.1^17 / 17! * 1.2 < 3.4e-32.
inline Ball exponential(Ball const& x)
{
    Ball const y{scaled(x.v, 0x1p-10), up(x.r * 0x1p-10)};
    Ball sum = 1;
    for (int k = 16; k > 0; --k) sum = Ball(1) + y * sum / Ball(k);
    sum.r = up(sum.r + 3.4e-32);
    for (int k = 0; k < 10; ++k) sum = sum * sum;
    return sum;
}
/// The root of x >= 0. The middle is Newton's; the square proves the radius: with s > 0, |s - root| = |s^2 - x| / (s + root) <= |s^2 - x| / s.
inline Ball root(Ball const& x)
{
    if (!(x.v > Wide(0))) return {Wide(0), up(std::sqrt(up(size_of(x.v) + x.r)))};
    Wide s = std::sqrt(x.v.hi);
    if (!(s.hi > 0)) return {Wide(0), up(std::sqrt(up(size_of(x.v) + x.r)))};
    for (int k = 0; k < 2; ++k) s = scaled(s + x.v / s, 0.5);
    Ball const off = Ball(s, 0) * Ball(s, 0) - x;
    return {s, up((size_of(off.v) + off.r) / s.hi * (1 + 0x1p-40))};
}

/// A sum of doubles without rounding: components that do not overlap, of increasing size (Shewchuk 1997, Grow-Expansion).
class ExactSum {
public:
    /// At most 16 times.
    void add(double b)
    {
        int kept = 0;
        for (int i = 0; i < n_; ++i) {
            Wide const s = two_sum(part_[i], b);
            if (s.lo != 0) part_[kept++] = s.lo;
            b = s.hi;
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
