#pragma once
#include "../standard.hpp"
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/gaussian.hpp>

TILEMESH_EXACT_BEGIN
/// The canonical float32 formulas, as a reader of the literature writes them (Zwicker et al. 2001; Kerbl et al. 2023). The covariance is
/// formed in world space, projected, inverted by its determinant, and evaluated as a conic around an absolute pixel mean. All formulas are
/// right; the rounding causes the errors. It is compiled as written: no contraction, no reordering. The 0.99 clamp and the other cut-offs
/// of alpha are left out, because they are not rounding. Rows of the catalogue replace single functions.
namespace naive {

struct Matrix3 {
    float m[3][3];
};
struct Point {
    float x, y, z;
};
struct Quaternion {
    float w, x, y, z;
};
/// Covariance on the screen (a b; b c), dilated.
struct Screen {
    float a, b, c;
};
/// Its inverse (xx xy; xy yy).
struct Conic {
    float xx, xy, yy;
};

inline Quaternion raw(float const (&q)[4]) noexcept
{
    return {q[0], q[1], q[2], q[3]};
}
inline Quaternion normalised(float const (&q)[4]) noexcept
{
    float const reciprocal = 1.0f / std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    return {q[0] * reciprocal, q[1] * reciprocal, q[2] * reciprocal, q[3] * reciprocal};
}

/// The rotation of a quaternion of length 1.
inline Matrix3 rotation(Quaternion const& q) noexcept
{
    return {{{1.0f - 2.0f * (q.y * q.y + q.z * q.z), 2.0f * (q.x * q.y - q.w * q.z), 2.0f * (q.x * q.z + q.w * q.y)},
             {2.0f * (q.x * q.y + q.w * q.z), 1.0f - 2.0f * (q.x * q.x + q.z * q.z), 2.0f * (q.y * q.z - q.w * q.x)},
             {2.0f * (q.x * q.z - q.w * q.y), 2.0f * (q.y * q.z + q.w * q.x), 1.0f - 2.0f * (q.x * q.x + q.y * q.y)}}};
}

/// R S S^T R^T.
inline Matrix3 covariance_world(Matrix3 const& r, float const (&scale)[3]) noexcept
{
    Matrix3 scaled{}, sigma{};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) scaled.m[i][j] = r.m[i][j] * scale[j];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k) sigma.m[i][j] += scaled.m[i][k] * scaled.m[j][k];
    return sigma;
}

/// W p + t with t = -W c, as in a 4 x 4 matrix.
inline Point view_point(tilemesh::splat::Camera const& c, float const (&p)[3]) noexcept
{
    float out[3];
    for (int i = 0; i < 3; ++i) {
        float const* const w = c.rotation[i];
        float const t = -(w[0] * c.position[0] + w[1] * c.position[1] + w[2] * c.position[2]);
        out[i] = w[0] * p[0] + w[1] * p[1] + w[2] * p[2] + t;
    }
    return {out[0], out[1], out[2]};
}

/// J W Sigma W^T J^T + dilation, with x/z and y/z clamped in J to `limit` half fields of view; limit 0: not clamped.
inline Screen covariance_screen(Matrix3 const& sigma, tilemesh::splat::Camera const& c, Point const& t, float limit, float dilation) noexcept
{
    float tx = t.x / t.z, ty = t.y / t.z;
    if (limit > 0) {
        float const limit_x = limit * (0.5f * static_cast<float>(c.width) / c.fx);
        float const limit_y = limit * (0.5f * static_cast<float>(c.height) / c.fy);
        tx = std::min(limit_x, std::max(-limit_x, tx));
        ty = std::min(limit_y, std::max(-limit_y, ty));
    }
    tx = tx * t.z;
    ty = ty * t.z;
    float const j[2][3] = {{c.fx / t.z, 0, -(c.fx * tx) / (t.z * t.z)}, {0, c.fy / t.z, -(c.fy * ty) / (t.z * t.z)}};
    float jw[2][3] = {}, half[2][3] = {}, out[2][2] = {};
    for (int r = 0; r < 2; ++r)
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) jw[r][i] += j[r][k] * c.rotation[k][i];
    for (int r = 0; r < 2; ++r)
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) half[r][i] += jw[r][k] * sigma.m[k][i];
    for (int r = 0; r < 2; ++r)
        for (int q = 0; q < 2; ++q)
            for (int k = 0; k < 3; ++k) out[r][q] += half[r][k] * jw[q][k];
    return {out[0][0] + dilation, out[0][1], out[1][1] + dilation};
}

inline float determinant(Screen const& s) noexcept
{
    return s.a * s.c - s.b * s.b;
}
/// a c - b^2, within 1.5 ulp of its value for the three rounded entries (Kahan).
inline float determinant_kahan(Screen const& s) noexcept
{
    float const bb = s.b * s.b;
    return std::fma(s.a, s.c, -bb) + std::fma(-s.b, s.b, bb);
}

inline Conic conic(Screen const& s, float determinant) noexcept
{
    float const reciprocal = 1.0f / determinant;
    return {s.c * reciprocal, -s.b * reciprocal, s.a * reciprocal};
}

/// The exponent at (dx, dy) from the mean. It is above 0 only because of rounding.
inline float power(Conic const& k, float dx, float dy) noexcept
{
    return -0.5f * (k.xx * dx * dx + k.yy * dy * dy) - k.xy * dx * dy;
}

/// lambda_max of the covariance; the 0.1 keeps the square root real.
inline float largest_eigenvalue(Screen const& s, float determinant) noexcept
{
    float const mid = 0.5f * (s.a + s.c);
    return mid + std::sqrt(std::max(0.1f, mid * mid - determinant));
}
inline float smallest_eigenvalue(Screen const& s, float determinant) noexcept
{
    float const mid = 0.5f * (s.a + s.c);
    return mid - std::sqrt(std::max(0.1f, mid * mid - determinant));
}
inline float radius(Screen const& s, float determinant) noexcept
{
    return std::ceil(3.0f * std::sqrt(largest_eigenvalue(s, determinant)));
}

/// static_cast<int> as on x86: a value that does not fit, also NaN, becomes the smallest int. In C++ this is undefined.
inline int to_int(float v) noexcept
{
    return v >= -2147483648.0f && v < 2147483648.0f ? static_cast<int>(v) : std::numeric_limits<int>::min();
}

struct Splat {
    bool drawn = false; ///< in front of the near plane, determinant positive
    Point view;
    float x, y; ///< mean in pixels, from the frame's corner
    Screen screen;
    float determinant;
    Conic conic;
    float opacity;
};

struct Variant {
    Quaternion (*unit)(float const (&)[4]) noexcept = normalised;
    float (*determinant)(Screen const&) noexcept = naive::determinant;
    bool near_plane = true;
    float limit = 1.3f;
    float dilation = 0.3f;
};

inline Matrix3 covariance_world(tilemesh::splat::Gaussian const& g, Variant const& v = {}) noexcept
{
    float const scale[3] = {std::exp(g.log_scale[0]), std::exp(g.log_scale[1]), std::exp(g.log_scale[2])};
    return covariance_world(rotation(v.unit(g.rotation)), scale);
}

inline Splat project(tilemesh::splat::Gaussian const& g, tilemesh::splat::Camera const& c, Variant const& v = {}) noexcept
{
    Splat s{};
    s.view = view_point(c, g.mean_world);
    if (v.near_plane && s.view.z <= c.near_depth) return s;
    s.screen = covariance_screen(covariance_world(g, v), c, s.view, v.limit, v.dilation);
    s.determinant = v.determinant(s.screen);
    if (s.determinant <= 0.0f) return s;
    s.conic = conic(s.screen, s.determinant);
    s.x = c.fx * s.view.x / s.view.z + c.cx;
    s.y = c.fy * s.view.y / s.view.z + c.cy;
    s.opacity = g.opacity;
    s.drawn = true;
    return s;
}

/// At the centre of pixel (x, y). A positive exponent is skipped.
inline float alpha_at(Splat const& s, std::uint32_t x, std::uint32_t y) noexcept
{
    if (!s.drawn) return 0.0f;
    float const p = power(s.conic, s.x - (static_cast<float>(x) + 0.5f), s.y - (static_cast<float>(y) + 0.5f));
    return p > 0.0f ? 0.0f : s.opacity * std::exp(p);
}

} // namespace naive
TILEMESH_EXACT_END
