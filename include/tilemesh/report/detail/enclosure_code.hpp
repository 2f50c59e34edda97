#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <tilemesh/error.hpp>
#include <tilemesh/report/detail/ball.hpp>
#include <tilemesh/report/detail/enclosed_splats.hpp>
#include <tilemesh/report/detail/large_memory.hpp>
#include <tilemesh/report/enclosure.hpp>
#include <tilemesh/report/number_text.hpp>
#include <tuple>

TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace report::detail {

#if TILEMESH_HAS_BALLS
// --- 3. and 4. blending in double ---------------------------------------------------------------------------------------
inline constexpr int block_px = 16; ///< side of the blocks of pixels that have one list of splats

/// A row of a block: transmittance, colours and depth, the sum of errors, 1 where a decision is doubtful, 1 where the pixel goes on.
struct BoundedRow {
    double t[block_px], c[4][block_px], s[block_px], doubtful[block_px], open[block_px];
};

/// Where in a row alpha may be alpha_min, or within its error of it. With a = -1 / (2 along) and d = -1 / (2 across), the power is
/// -(dx - dx_c)^2 / (2 v) - dy^2 / (2 w), where w = slope^2 a + d, v = a d / w and dx_c = slope a / w dy. A margin of .03 in the power is above
/// alpha's error (rho < .01) and the rounding of these numbers, and 1e-9 of a distance and .01 pixels above the others'.
struct Reach {
    double room, of_dy = 0, along_dy = 0, twice_v = 0;
    Reach(DoubleSplat const& e, splat::Rules const& rules) : room(std::numeric_limits<double>::infinity())
    {
        double const a = -0.5 / e.along, d = -0.5 / e.across, w = e.slope * e.slope * a + d;
        if (!(e.rho < 0.01 && a > 0 && d > 0 && w < 1e200)) return; // all of a row
        room = std::log(e.opacity / double{rules.alpha_min}) + 0.03, of_dy = 0.5 / w, along_dy = e.slope * a / w, twice_v = 2 * a * d / w;
    }
    /// Does it reach the pixels whose centres are between `first` and `last`, relative to the mean?
    bool meets(double dy, double first, double last) const
    {
        if (!(room < std::numeric_limits<double>::infinity())) return true;
        double const middle = along_dy * dy, margin = 0.01 + 1e-9 * std::fabs(middle);
        double const beyond = std::max({first - middle, middle - last, margin}) - margin;
        return beyond * beyond < twice_v * (room - of_dy * dy * dy);
    }
};

/// Blends one splat into the row j of the block at (px, py). It has no branches, so that a compiler can use vectors.
inline void blend_row(BoundedRow& row, DoubleSplat const& e, int px, int py, int j, splat::Rules const& rules)
{
    constexpr double u4 = 0x1p-51;
    double const cut = rules.alpha_min, most = rules.alpha_max, limit = rules.transmittance_min;
    double const drops = rules.stop == splat::Stop::before_crossing ? 1.0 : 0.0;
    double const x0 = e.may.x0 - px, x1 = e.may.x1 - px, m0 = e.must.x0 - px, m1 = e.must.x1 - px;
    double const row_must = py + j >= e.must.y0 && py + j < e.must.y1 ? 1.0 : 0.0;
    double const dy = py + j + 0.5 - e.y, wild = e.rho < 1 ? 0.0 : 1.0, rho = e.rho < 1 ? e.rho : 0.0;
    for (int i = 0; i < block_px; ++i) {
        double const t = row.t[i], open = row.open[i];
        double const dx = px + i + 0.5 - e.x;
        double const off = dy - e.slope * dx;
        double power = e.along * dx * dx + e.across * off * off;
        power = power > -600 ? power : -600;
        double const a0 = e.opacity * exp_in_double(power);
        double const at = i; // comparisons of doubles alone
        double const inside = (at >= x0 ? 1.0 : 0.0) * (at < x1 ? 1.0 : 0.0) * open;
        double const must = (at >= m0 ? 1.0 : 0.0) * (at < m1 ? 1.0 : 0.0) * row_must;
        double const in0 = (a0 >= cut ? 1.0 : 0.0) * inside;
        double const a = a0 < most ? a0 : most;
        double const w0 = a * t, behind = t - w0;
        double const crosses = (behind < limit ? in0 : 0.0) * drops;
        double const in = in0 - crosses, w = w0 * in, after = t - w;
        for (int k = 0; k < 4; ++k) row.c[k][i] += w * e.colour[k];
        double const d = a0 * rho;
        double const gap = a0 > cut ? a0 - cut : cut - a0;
        double const near = gap <= d ? 1.0 : 0.0, beside = a0 >= cut - d ? 1.0 - must : 0.0;
        double const flips = (near + beside + wild > 0 ? 1.0 : 0.0) * inside;
        double const size = wild > 0 ? 1.0 : a0 + d; // no alpha is larger than 1
        double s = row.s[i] + in * (t * d + u4) + flips * t * size;
        double const seen = drops > 0 ? behind : after;
        double const away = seen > limit ? seen - limit : limit - seen;
        double const there = drops > 0 ? in0 : in; // a term that may be there may be the last one
        double const stops = away <= s * 1.000001 + t * (d + u4) && limit > 0 ? (there > flips ? there : flips) : 0.0;
        s += stops * (drops > 0 ? t : after) * 1.01;
        row.s[i] = s;
        row.doubtful[i] = flips + stops > 0 ? 1.0 : row.doubtful[i];
        row.open[i] = drops > 0 ? open - crosses : (after < limit ? 0.0 : open);
        row.t[i] = after;
    }
}

// --- 5. a pixel in balls ------------------------------------------------------------------------------------------------
/// Where balls do not decide either, both outcomes are enclosed: a term is the hull of 0 and itself; a stop adds the picture so far to a
/// hull, and the pixel goes on. By induction over the terms, each execution of exact real arithmetic either stops at a term whose picture is in
/// the hull, or is enclosed by the state that goes on.
/// `sums`: colours, depths, transmittance.
inline Enclosure::Decided blend_pixel(Ball (&sums)[5], std::int32_t x, std::int32_t y, EnclosedSplats const& p, std::span<std::uint32_t const> list,
                                      splat::Rules const& rules)
{
    Ball t = 1, c[4];
    bool have_hull = false, stopped = false;
    auto decided = Enclosure::Decided::in_wide;
    bool const drops = rules.stop == splat::Stop::before_crossing;
    auto const keep = [&] {
        for (int k = 0; k < 5; ++k) {
            Ball const now = k == 4 ? t : k == 3 ? c[k] : c[k] + t * Ball(rules.background[k]);
            sums[k] = have_hull ? hull(sums[k], now) : now;
        }
        have_hull = true;
    };
    for (std::uint32_t const n : list) {
        DoubleSplat const& e = p.splats[n];
        if (!e.may.contains(x, y)) continue;
        if (e.rho < 1) { // certainly cut?
            double const dx = x + 0.5 - e.x, off = y + 0.5 - e.y - e.slope * dx;
            double const a = e.opacity * exp_in_double(std::max(-600.0, e.along * dx * dx + e.across * off * off));
            if (a * (1 + 2 * e.rho) < double{rules.alpha_min}) continue;
        }
        BallSplat const& b = p.balls[n];
        Ball const dx = Ball(x + 0.5) - b.x, off = Ball(y + 0.5) - b.y - b.slope * dx;
        Ball power = b.along * dx * dx + b.across * off * off;
        if (upper(power) < -90) continue; // e^-90 is 8e-40, and alpha_min at least 1e-30
        Ball a;
        if (lower(power) > -99) {
            a = exponential(Ball(power.v.hi < 0 ? power.v : Wide(0), 0));
            double const wide = power.v.hi < 0 ? power.r : power.r + size_of(power.v);
            a = b.opacity * Ball(a.v, up(a.r + size_of(a.v) * up(std::expm1(up(wide)))));
        } else {
            a = Ball(0.5, 0.5) * b.opacity; // a ball as large as this says nothing
        }
        if (lower(a) < 0 || upper(a) > upper(b.opacity)) a = larger(Ball(0), smaller(a, b.opacity));
        auto const visible = sign(a - Ball(rules.alpha_min));
        if (visible && *visible < 0) continue;
        a = smaller(a, Ball(rules.alpha_max));
        if (!visible || !e.must.contains(x, y)) a = hull(a, Ball(0)), decided = Enclosure::Decided::undecided;
        Ball const w = a * t, behind = t - w;
        auto const stops = rules.transmittance_min > 0 ? sign(behind - Ball(rules.transmittance_min)) : std::optional(1);
        if (drops && stops && *stops < 0) {
            stopped = true, keep();
            break;
        }
        if (drops && !stops) keep(), decided = Enclosure::Decided::undecided;
        for (int k = 0; k < 4; ++k) c[k] = c[k] + w * (k == 3 ? b.z : b.colour[k]);
        t = behind;
        if (!drops && stops && *stops < 0) {
            stopped = true, keep();
            break;
        }
        if (!drops && !stops) keep(), decided = Enclosure::Decided::undecided;
    }
    if (!stopped) keep();
    return decided;
}

/// An interval as its middle and half of its width, outward.
inline Rounded middle_of(double low, double high)
{
    double const middle = 0.5 * (low + high);
    return {middle, up(std::max(high - middle, middle - low)) + 0x1p-51 * std::fabs(middle)};
}
/// sum(w z) / sum(w) between the depths of a pixel's terms, where sum(w) is 1 - t; 0 without a term.
inline Rounded depth_of(Rounded const& sum, Rounded const& t, double nearest, double farthest)
{
    if (sum.v == 0 && sum.e == 0) return {0, 0};
    constexpr double wider = 1 + 0x1p-49;
    double const least = (1 - t.v - t.e) - 0x1p-51, most = (1 - t.v + t.e) + 0x1p-51;
    if (!(least > 0)) return middle_of(0, farthest * wider);
    return middle_of(std::max((sum.v - sum.e) / (most * wider), nearest / wider), std::min((sum.v + sum.e) / least * wider, farthest * wider));
}

/// A pixel with a larger radius (5e-9 levels, of colours up to 1) is blended in balls, too. Needles of 1e10 and more need it.
inline constexpr double widest_in_double = 2e-11;

/// Encloses the pixels of one block.
inline void enclose_block(Enclosure& out, int px, int py, EnclosedSplats const& p, std::span<std::uint32_t const> list, splat::Rules const& rules,
                          double tail)
{
    BoundedRow rows[block_px];
    for (auto& row : rows)
        for (int i = 0; i < block_px; ++i)
            row.t[i] = row.open[i] = 1, row.c[0][i] = row.c[1][i] = row.c[2][i] = row.c[3][i] = row.s[i] = row.doubtful[i] = 0;
    double spread[4], nearest = std::numeric_limits<double>::infinity(), farthest = 0, colour_error = 0;
    for (int k = 0; k < 4; ++k) {
        double low = k == 3 ? 0.0 : double{rules.background[k]}, high = low;
        for (auto const n : list) low = std::min(low, p.splats[n].colour[k]), high = std::max(high, p.splats[n].colour[k]);
        spread[k] = std::max({high - low, high, -low}) * 1.000001;
    }
    double depth_error = 0;
    for (auto const n : list) {
        auto const& e = p.splats[n];
        nearest = std::min(nearest, e.colour[3] - e.depth_error), farthest = std::max(farthest, e.colour[3] + e.depth_error);
        colour_error = std::max(colour_error, e.colour_error), depth_error = std::max(depth_error, e.depth_error);
    }
    std::uint32_t going = (1u << block_px) - 1; // rows, as bits
    for (std::size_t n = 0; n < list.size() && going != 0; ++n) {
        for (int j = 0; n % 32 == 31 && j < block_px; ++j)
            if (std::none_of(std::begin(rows[j].open), std::end(rows[j].open), [](double open) { return open > 0; })) going &= ~(1u << j);
        auto const& e = p.splats[list[n]];
        Reach const reach(e, rules);
        for (int j = std::max(e.may.y0 - py, 0); j < std::min(e.may.y1 - py, block_px); ++j)
            if ((going >> j & 1u) != 0 && reach.meets(py + j + 0.5 - e.y, px + 0.5 - e.x, px + block_px - 0.5 - e.x))
                blend_row(rows[j], e, px, py, j, rules);
    }
    for (int j = 0; j < block_px && static_cast<std::uint32_t>(py + j) < out.height; ++j)
        for (int i = 0; i < block_px && static_cast<std::uint32_t>(px + i) < out.width; ++i) {
            auto const at = std::size_t{out.width} * static_cast<std::uint32_t>(py + j) + static_cast<std::uint32_t>(px + i);
            auto const& row = rows[j];
            double const s = row.s[i] * 1.000001 + 0x1p-50;
            Rounded sums[5];
            for (int k = 0; k < 4; ++k) { // the weights of a pixel sum to at most 1 + S
                double const error = k == 3 ? depth_error : colour_error;
                sums[k] = {row.c[k][i] + (k == 3 ? 0.0 : row.t[i] * double{rules.background[k]}), spread[k] * s + error * (1.000001 + row.s[i])};
            }
            sums[4] = {row.t[i], s};
            if (row.t[i] == 1 && row.s[i] == 0) sums[3] = {0, 0}, sums[4] = {1, 0}; // no term
            bool const wide = std::max({sums[0].e, sums[1].e, sums[2].e}) > widest_in_double * std::max({1.0, spread[0], spread[1], spread[2]});
            if (row.doubtful[i] != 0 || (tail == 0 && wide)) {
                Ball balls[5];
                out.decided[at] = blend_pixel(balls, px + i, py + j, p, list, rules);
                for (int k = 0; k < 5; ++k) // the narrower one of the two
                    if (auto const narrow = round_to_double(balls[k]); narrow.e < sums[k].e) sums[k] = narrow;
            }
            for (std::size_t k = 0; k < 3; ++k) out.middle[3 * at + k] = sums[k].v, out.radius[3 * at + k] = sums[k].e + tail;
            out.transmittance[at] = static_cast<float>(sums[4].v);
            if (out.alpha.middle.empty()) continue;
            auto const alpha = middle_of(1 - sums[4].v - sums[4].e, 1 - sums[4].v + sums[4].e), depth = depth_of(sums[3], sums[4], nearest, farthest);
            out.alpha.middle[at] = alpha.v, out.alpha.radius[at] = sums[4].e == 0 && sums[4].v == 1 ? 0 : alpha.e + 0x1p-52;
            out.depth.middle[at] = depth.v, out.depth.radius[at] = depth.e;
        }
}

TILEMESH_HOST Enclosure enclose(std::span<EnclosedRecord const> records, splat::Camera const& camera, splat::Rules const& given,
                                EncloseOptions const& options)
{
    constexpr float faintest = 1e-12f; // of a term without cut-offs
    bool const whole = options.cuts == Cuts::none;
    if (whole && options.planes)
        throw Error("no enclosure of depth and alpha without cut-offs (a pixel that shows next to nothing has any depth); take Cuts::same");
    if (camera.lens.kind != splat::LensKind::pinhole || camera.shutter.rolls())
        throw Error("no enclosure of a picture through a lens that bends it, or of a rolling shutter (its projection is not enclosed); take a "
                    "pinhole camera");
    auto rules = given;
    if (whole)
        rules.alpha_min = faintest, rules.alpha_max = 1, rules.transmittance_min = 0, rules.stop = splat::Stop::after_crossing,
        rules.footprint = splat::Footprint::opacity_box;
    if (!(rules.alpha_min >= 1e-30f))
        throw Error("an enclosure for an alpha_min of " + significant(double{rules.alpha_min}, 3) +
                    " (each record lights each pixel, in what a double cannot tell from nothing); give one of 1e-30 or more");
    auto scene = std::make_shared<EnclosedScene>();
    scene->splats = project_all(records, camera, rules, whole ? std::numeric_limits<float>::denorm_min() : rules.alpha_min, options.threads);
    scene->rules = rules;
    auto const& p = scene->splats;
    for (auto const& splat : p.splats) scene->ids.push_back(records[splat.record].gaussian->id);
    double const tail = whole ? 1.000001 * double{faintest} * static_cast<double>(records.size()) * p.spread : 0.0;
    Enclosure out;
    out.width = camera.width, out.height = camera.height, out.splats = p.splats.size(), out.not_enclosed = p.not_enclosed, out.scene = scene;
    auto const pixels = std::size_t{camera.width} * camera.height;
    resize_large(out.middle, 3 * pixels), resize_large(out.radius, 3 * pixels);
    out.decided.resize(pixels, Enclosure::Decided::in_double);
    if (options.planes)
        for (auto* const plane : {&out.depth, &out.alpha}) resize_large(plane->middle, pixels), resize_large(plane->radius, pixels);
    out.transmittance.resize(pixels);
    auto const columns = (camera.width + block_px - 1) / block_px, rows = (camera.height + block_px - 1) / block_px;
    auto& lists = scene->lists;
    lists.resize(std::size_t{columns} * rows), scene->columns = columns;
    for (std::uint32_t n = 0; n < p.splats.size(); ++n) {
        auto const& may = p.splats[n].may;
        for (int y = may.y0 / block_px; y <= (may.y1 - 1) / block_px; ++y)
            for (int x = may.x0 / block_px; x <= (may.x1 - 1) / block_px; ++x)
                lists[std::size_t{columns} * static_cast<std::uint32_t>(y) + static_cast<std::uint32_t>(x)].push_back(n);
    }
    for_each_on(options.threads, lists.size(), [&](std::size_t at) {
        auto const x = static_cast<int>(at % columns), y = static_cast<int>(at / columns);
        enclose_block(out, x * block_px, y * block_px, p, lists[at], rules, tail);
    });
    return out;
}
#else
TILEMESH_HOST Enclosure enclose(std::span<EnclosedRecord const>, splat::Camera const&, splat::Rules const&, EncloseOptions const&)
{
    throw Error("no enclosure on this host (it rounds doubles twice, as x87 does); compile for SSE2 or another host");
}
#endif

}}} // namespace tilemesh::v0_2::report::detail

namespace tilemesh { inline namespace v0_2 { namespace report {

TILEMESH_HOST std::uint64_t Enclosure::count(Decided how) const noexcept
{
    return static_cast<std::uint64_t>(std::count(decided.begin(), decided.end(), how));
}
TILEMESH_HOST double Enclosure::widest() const noexcept
{
    return radius.empty() ? 0.0 : 2 * *std::max_element(radius.begin(), radius.end());
}

namespace detail {
/// For each channel, how far a picture is off at most, in levels.
TILEMESH_HOST std::vector<double> levels_off(Enclosure const& enclosure, Image const& picture, Written const& written)
{
    if (picture.width != enclosure.width || picture.height != enclosure.height)
        throw Error("a picture of " + std::to_string(picture.width) + " x " + std::to_string(picture.height) + " pixels (the enclosure has " +
                    std::to_string(enclosure.width) + " x " + std::to_string(enclosure.height) + "); take the picture of this camera");
    std::vector<double> off(picture.rgb.size());
    for (std::size_t i = 0; i < off.size(); ++i) {
        // To clamp brings no two values farther apart. The first rounding is of 2^-53 of the difference, and the others of that of the result.
        double const middle = written.clamped ? std::clamp(enclosure.middle[i], 0.0, 1.0) : enclosure.middle[i];
        double const apart = std::fabs(double{picture.rgb[i]} - middle), away = apart + 0x1p-52 * apart - written.half_step;
        double const levels = ((away < 0 ? 0.0 : away) + enclosure.radius[i]) * 255 * (1 + 0x1p-50);
        off[i] = std::isnan(levels) ? std::numeric_limits<double>::infinity() : levels;
    }
    return off;
}
inline double quantile(std::vector<double>& values, double q)
{
    if (values.empty()) return 0;
    auto const at = values.begin() + static_cast<std::ptrdiff_t>(std::ceil(q * static_cast<double>(values.size() - 1)));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}
/// One unit of the third digit more than the nearest three digits is not below the number.
inline std::string not_below(double value)
{
    return value > 0 && std::isfinite(value) ? significant(value * 1.01, 3) : significant(value, 3);
}
} // namespace detail

TILEMESH_HOST Certificate certify(Enclosure const& enclosure, Image const& picture, Written const& written)
{
    using Decided = Enclosure::Decided;
    auto off = detail::levels_off(enclosure, picture, written);
    Certificate out;
    out.in_wide = enclosure.count(Decided::in_wide), out.undecided = enclosure.count(Decided::undecided);
    out.widest = 255 * enclosure.widest(), out.not_enclosed = enclosure.not_enclosed;
    std::vector<double> of_pixel(off.size() / 3);
    for (std::size_t i = 0; i < off.size(); ++i) of_pixel[i / 3] = std::max(of_pixel[i / 3], off[i]);
    out.largest = detail::quantile(off, 1.0), out.p99 = detail::quantile(off, 0.99), out.median = detail::quantile(off, 0.5);
    std::vector<std::uint32_t> places;
    for (std::uint32_t i = 0; i < of_pixel.size(); ++i)
        if (of_pixel[i] > 0.01) places.push_back(i);
    out.beyond = places.size();
    auto const shown = std::min<std::size_t>(10, places.size());
    std::partial_sort(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(shown), places.end(),
                      [&](std::uint32_t a, std::uint32_t b) { return of_pixel[a] != of_pixel[b] ? of_pixel[a] > of_pixel[b] : a < b; });
    for (std::size_t i = 0; i < shown; ++i) out.worst.push_back({places[i] % picture.width, places[i] / picture.width, of_pixel[places[i]], {}});
    return out;
}

TILEMESH_HOST Certificate::OfPlane certify(Enclosure::OfPlane const& enclosure, Plane const& plane)
{
    if (plane.values.size() != enclosure.middle.size())
        throw Error("a plane of " + std::to_string(plane.values.size()) + " pixels (the enclosure has " + std::to_string(enclosure.middle.size()) +
                    "); take the plane of this camera, and an enclosure with planes");
    std::vector<double> off(plane.values.size());
    for (std::size_t i = 0; i < off.size(); ++i) {
        double const away = (std::fabs(double{plane.values[i]} - enclosure.middle[i]) + enclosure.radius[i]) * (1 + 0x1p-50);
        off[i] = std::isnan(away) ? std::numeric_limits<double>::infinity() : away;
    }
    return {detail::quantile(off, 1.0), detail::quantile(off, 0.99), detail::quantile(off, 0.5)};
}

TILEMESH_HOST std::string text_of(Certificate const& c)
{
    using detail::not_below;
    auto text = "every channel within " + not_below(c.largest) + "/255 of the exact formula (p99 " + not_below(c.p99) + ", median " +
                not_below(c.median) + "; " + std::to_string(c.beyond) + " pixels beyond 0.01; " + std::to_string(c.in_wide) +
                " decided in 100 bits, " + std::to_string(c.undecided) + " undecided)";
    if (!c.not_enclosed.empty())
        text += "; NOT for the whole map: no interval encloses " + std::to_string(c.not_enclosed.size()) + " records, the first is Gaussian " +
                std::to_string(c.not_enclosed.front());
    for (auto const& [name, plane, unit] : {std::tuple("depth", &c.depth, " world units"), std::tuple("alpha", &c.alpha, "")})
        if (*plane) text += std::string("; ") + name + " " + text_of(**plane) + unit;
    std::uint64_t looked_at = 0;
    for (auto const& [word, pixels] : c.causes) looked_at += pixels;
    for (auto const& [word, pixels] : c.causes) {
        text += &word != &c.causes.front().first ? ", " : looked_at < c.beyond ? "; of " + std::to_string(looked_at) + " looked at by " : "; by ";
        text += word + " " + std::to_string(pixels);
    }
    return text;
}

TILEMESH_HOST std::string text_of(Certificate::OfPlane const& c)
{
    return "within " + detail::not_below(c.largest) + " (p99 " + detail::not_below(c.p99) + ", median " + detail::not_below(c.median) + ")";
}

}}} // namespace tilemesh::v0_2::report
TILEMESH_EXACT_END
