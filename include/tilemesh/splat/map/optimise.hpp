#pragma once
#include <cmath>
#include <cstdint>
#include <tilemesh/splat/exponential.hpp>
#include <tilemesh/splat/harmonics.hpp>
#include <tilemesh/splat/map/chain.hpp>

/// Optimisers as policies: how a Gaussian moves by its slopes in one view. Every operation is correctly rounded, or the library's own:
/// the bits are equal for every compiler that fuses multiply_add alike.
TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace splat::map {

/// The length of a step of each kind: world units, logarithms, quaternion, logit, linear colour; coefficients of harmonics.
struct Rates {
    float mean, log_scale, rotation, logit, colour, harmonics = 0;

    constexpr float of(Kind kind) const noexcept
    {
        return kind == Kind::mean        ? mean
               : kind == Kind::log_scale ? log_scale
               : kind == Kind::rotation  ? rotation
               : kind == Kind::logit     ? logit
                                         : colour;
    }
};
/// The rates at which `bench/mapping` refines maps. `scene_depth`: the median depth of the views, in world units.
constexpr Rates usual_rates(float scene_depth) noexcept
{
    return {1e-3f * scene_depth, 5e-3f, 2e-3f, 2.5e-2f, 5e-3f, 2.5e-4f}; // harmonics: a twentieth of colours
}
constexpr Rates operator*(Rates const& r, float by) noexcept
{
    return {r.mean * by, r.log_scale * by, r.rotation * by, r.logit * by, r.colour * by, r.harmonics * by};
}
/// Rates that fall evenly, by the logarithm, from `rates` at share 0 of a run to a tenth of them at share 1.
inline Rates faded(Rates const& rates, float share) noexcept
{
    float const by = exponential(-2.30258509f * share);
    return rates * by;
}

/// The decays of the moments, and what keeps a step finite where no slope was ever seen. The constants are Adam's (Kingma and Ba 2015),
/// but for `least`: slopes here are not averaged over pixels.
struct Decays {
    float first = 0.9f, second = 0.999f, least = 1e-12f;
    float log_first = -0.105360516f, log_second = -1.00050033e-3f; ///< natural logarithms of the two
};

namespace detail {
/// 1 / (1 - decay^n): a mean of n slopes that began at 0.
inline float correction(float log_decay, std::uint32_t n) noexcept
{
    return 1.0f / (1.0f - exponential(log_decay * static_cast<float>(n)));
}
/// Moves a record by `step`, and brings it back to where it is valid: a quaternion of length 1, colours of at least 0 (not where they are
/// the first part of harmonics), a logit from -9 to 9. An opacity outside these bounds is moved inside.
inline void move(Gaussian& g, float const (&step)[parameters], bool clamps_colour) noexcept
{
    for (std::uint32_t i = 0; i < 3; ++i) {
        g.mean_world[i] = g.mean_world[i] + step[i];
        g.log_scale[i] = g.log_scale[i] + step[places_of(Kind::log_scale).first + i];
        float const colour = g.colour[i] + step[places_of(Kind::colour).first + i];
        g.colour[i] = colour > 0 || !clamps_colour ? colour : 0.0f;
    }
    float q[4], squares = 0;
    for (std::uint32_t i = 0; i < 4; ++i) {
        q[i] = g.rotation[i] + step[places_of(Kind::rotation).first + i];
        squares = multiply_add(q[i], q[i], squares);
    }
    if (squares > 1e-30f && squares < 1e30f) { // else the record keeps its rotation
        float const per_length = 1.0f / std::sqrt(squares);
        for (std::uint32_t i = 0; i < 4; ++i) g.rotation[i] = q[i] * per_length;
    }
    // The logit moves without a logarithm: o e^d / (1 - o + o e^d).
    constexpr float least = 1.2339458e-4f, most = 0.99987661f; // logits of -9 and 9
    float const before = g.opacity < least ? least : g.opacity > most ? most : g.opacity;
    float const odds = before * exponential(step[places_of(Kind::logit).first]), opacity = odds / ((1.0f - before) + odds);
    g.opacity = opacity < least ? least : opacity > most ? most : opacity;
}
} // namespace detail

/// Adam: a first and a second moment of each parameter. 29 words a Gaussian.
struct Adam {
    static constexpr char const* name = "adam";
    struct State {
        float first[parameters], second[parameters];
        std::uint32_t steps;
    };
    static void step(Gaussian& g, RecordSlopes const& slopes, Rates const& rates, Decays const& d, State& s,
                     bool clamps_colour = true) noexcept
    {
        s.steps = s.steps + 1;
        float const first = detail::correction(d.log_first, s.steps), second = detail::correction(d.log_second, s.steps);
        float step[parameters];
        for (std::uint32_t kind = 0; kind < kinds; ++kind) {
            Places const p = places_of(static_cast<Kind>(kind));
            float const rate = rates.of(static_cast<Kind>(kind)) * first;
            for (std::uint32_t i = p.first; i < p.end; ++i) {
                float const v = slopes.of[i];
                s.first[i] = multiply_add(d.first, s.first[i], (1.0f - d.first) * v);
                s.second[i] = multiply_add(d.second, s.second[i], (1.0f - d.second) * (v * v));
                step[i] = -rate * s.first[i] / (std::sqrt(s.second[i] * second) + d.least);
            }
        }
        detail::move(g, step, clamps_colour);
    }
};
/// No first moment, and one second moment for all parameters of a kind. 6 words a Gaussian. It refines maps better than Adam; from an
/// empty map, Adam is better.
struct SecondMomentByKind {
    static constexpr char const* name = "second_moment_by_kind";
    struct State {
        float second[kinds];
        std::uint32_t steps;
    };
    static void step(Gaussian& g, RecordSlopes const& slopes, Rates const& rates, Decays const& d, State& s,
                     bool clamps_colour = true) noexcept
    {
        s.steps = s.steps + 1;
        float const second = detail::correction(d.log_second, s.steps);
        float step[parameters];
        for (std::uint32_t kind = 0; kind < kinds; ++kind) {
            Places const p = places_of(static_cast<Kind>(kind));
            float squares = 0;
            for (std::uint32_t i = p.first; i < p.end; ++i) squares = multiply_add(slopes.of[i], slopes.of[i], squares);
            s.second[kind] = multiply_add(d.second, s.second[kind], (1.0f - d.second) * (squares / static_cast<float>(p.end - p.first)));
            float const by = -rates.of(static_cast<Kind>(kind)) / (std::sqrt(s.second[kind] * second) + d.least);
            for (std::uint32_t i = p.first; i < p.end; ++i) step[i] = by * slopes.of[i];
        }
        detail::move(g, step, clamps_colour);
    }
};
/// The step of a Gaussian's harmonics, with either optimiser: no first moment, one second moment for all coefficients. 2 words a Gaussian.
struct HarmonicsStep {
    struct State {
        float second;
        std::uint32_t steps;
    };
    /// A coefficient's slope is that of the colour times its function of the direction. `g`: as the view showed it, before its own step.
    template <std::uint32_t Degree>
    static void step(float* harmonics, Gaussian const& g, View const& view, RecordSlopes const& slopes, float rate, Decays const& d,
                     State& s) noexcept
    {
        constexpr std::uint32_t n = harmonics_per_channel(Degree);
        float basis[n], squares = 0;
        splat::detail::harmonic_basis<Degree>(splat::detail::direction_of(g, view), basis);
        float const* const colour = slopes.of + places_of(Kind::colour).first;
        for (float const b : basis)
            for (std::uint32_t c = 0; c < 3; ++c) squares = multiply_add(b * colour[c], b * colour[c], squares);
        s.steps = s.steps + 1;
        s.second = multiply_add(d.second, s.second, (1.0f - d.second) * (squares / static_cast<float>(3 * n)));
        float const by = -rate / (std::sqrt(s.second * detail::correction(d.log_second, s.steps)) + d.least);
        for (std::uint32_t k = 0; k < n; ++k)
            for (std::uint32_t c = 0; c < 3; ++c) harmonics[3 * k + c] = multiply_add(by * basis[k], colour[c], harmonics[3 * k + c]);
    }
};
/// An optimiser for maps with harmonics of degree 1 to 3, on a mesh: its state also holds the record's harmonics and their own state. So
/// they rest, move and go with the record, and a machine of degree 0 pays nothing. `Base`: `Adam` or `SecondMomentByKind`.
template <class Base, std::uint32_t Degree>
struct Shaded {
    static_assert(Degree >= 1 && Degree <= 3, "harmonics have degree 1 to 3 (a map of degree 0 has none); take the optimiser itself");
    static constexpr char const* name = Base::name;
    static constexpr std::uint32_t degree = Degree, words = 3 * harmonics_per_channel(Degree);
    struct State {
        typename Base::State record;
        HarmonicsStep::State shading;
        float harmonics[words]; ///< as in ShadedGaussian<Degree>
    };
    static void step(Gaussian& g, View const& view, RecordSlopes const& slopes, Rates const& rates, Decays const& d, State& s) noexcept
    {
        HarmonicsStep::step<Degree>(s.harmonics, g, view, slopes, rates.harmonics, d, s.shading);
        Base::step(g, slopes, rates, d, s.record, false);
    }
};
/// The degree of the harmonics that an optimiser's states hold.
template <class Optimiser>
inline constexpr std::uint32_t degree_of = 0;
template <class Base, std::uint32_t Degree>
inline constexpr std::uint32_t degree_of<Shaded<Base, Degree>> = Degree;

static_assert(sizeof(Adam::State) == 4 * 29 && sizeof(SecondMomentByKind::State) == 4 * 6, "the words that an anchored Gaussian keeps");

}}} // namespace tilemesh::splat::map
TILEMESH_EXACT_END
