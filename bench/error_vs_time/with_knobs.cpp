#include "with_knobs.hpp"
#include <algorithm>
#include <cmath>

namespace error_vs_time {

namespace {

/// The half-precision number (IEEE 754 binary16) nearest to v, ties to even; at most the largest finite one.
double half(double v) noexcept
{
    constexpr double largest = 65504, least_normal = 0x1p-14, least = 0x1p-24;
    double const size = std::fabs(v);
    double const step = size < least_normal ? least : std::ldexp(1.0, std::ilogb(size) - 10);
    return std::copysign(std::min(std::nearbyint(size / step) * step, largest), v);
}

/// Replaces the shape by the one that is read back from storage, in the form along dx^2 + across (dy - slope dx)^2.
void store_as(Shape shape, splat::Splat& s) noexcept
{
    if (shape == Shape::half_factor) {
        double const first = half(std::sqrt(-2.0 * s.along)), second = half(std::sqrt(-2.0 * s.across));
        s.along = static_cast<float>(-0.5 * first * first);
        s.across = static_cast<float>(-0.5 * second * second);
        s.slope = static_cast<float>(half(s.slope));
    } else {
        double const yy = half(-2.0 * s.across), xy = half(2.0 * s.slope * s.across);
        double const xx = half(-2.0 * s.along - 2.0 * double{s.slope} * s.slope * s.across);
        // Rounding may leave a form that is not negative. Along an axis on which it would grow, it is held constant.
        bool const none = !(yy > 0.0);
        s.across = static_cast<float>(-0.5 * yy);
        s.slope = none ? 0.0f : static_cast<float>(-xy / yy);
        s.along = static_cast<float>(std::min(-0.5 * (none ? xx : xx - xy * xy / yy), 0.0));
    }
}

/// The part of the span first | end << 16 within `reach` of `centre`, including the pixels that both ends touch; 0 if there is none.
std::uint32_t cut_span(std::uint32_t span, double centre, double reach) noexcept
{
    double const first = std::max(double(span & 0xffffu), std::floor(centre - reach));
    double const end = std::min(double(span >> 16), std::floor(centre + reach) + 1.0);
    return first < end ? static_cast<std::uint32_t>(first) | static_cast<std::uint32_t>(end) << 16 : 0;
}

/// The tile of the pixel of `centre`, clamped into a span.
std::uint32_t tile_within(std::uint32_t span, double centre, std::uint32_t size) noexcept
{
    double const pixel = std::clamp(std::floor(centre), double(span & 0xffffu), double(span >> 16) - 1.0);
    return static_cast<std::uint32_t>(pixel) / size;
}

} // namespace

void apply(Knobs const& knobs, splat::View const& view, splat::Tiling const& tiling, splat::Splat& s) noexcept
{
    if (!s.visible()) return;
    if (knobs.sigmas > 0) {
        double const a = -0.5 / s.along, determinant = -0.5 * a / s.across, b = s.slope * a, c = (determinant + b * b) / a;
        double const u = double{s.mean_px[0]} + view.camera.cx, v = double{s.mean_px[1]} + view.camera.cy;
        s.columns = cut_span(s.columns, u, knobs.sigmas * std::sqrt(a));
        s.rows = cut_span(s.rows, v, knobs.sigmas * std::sqrt(c));
        if (s.columns == 0 || s.rows == 0) {
            s = {};
            return;
        }
        s.anchor = tilemesh::TileId::at(tile_within(s.columns, u, tiling.tile_width), tile_within(s.rows, v, tiling.tile_height));
    }
    if (knobs.shape != Shape::float32) store_as(knobs.shape, s);
}

} // namespace error_vs_time
