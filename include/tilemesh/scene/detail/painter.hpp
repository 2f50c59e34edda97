#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <tilemesh/scene/detail/brush.hpp>
#include <tilemesh/scene/map.hpp>

// Light, shadow and the surfaces of the built-in scene. Units are metres; x right, y down, z away from the viewer; the desk top is y = 0.
// The numbers were chosen by eye; they have no other source.
namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

using Vec = glm::dvec3;

inline constexpr double full_turn = 6.28318530717958647692;
inline Vec const desk_eye{0.03, -0.62, -1.27};

inline Vec mix(Vec a, Vec b, double share) { return a + (b - a) * share; }
inline double smooth(double low, double high, double x)
{
    double const t = std::clamp((x - low) / (high - low), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

/// The light: a window to the upper left, somewhat in front of the desk, and the sky above.
inline Vec lit(Vec albedo, Vec place, Vec normal, double gloss = 0.0, double shadow = 0.0)
{
    Vec const to_light = glm::normalize(Vec{-0.55, -0.75, -0.50});
    Vec const to_eye = glm::normalize(desk_eye - place);
    double const sun = std::fmax(glm::dot(normal, to_light), 0.0) * (1.0 - shadow);
    double const sky = 0.5 - 0.5 * normal.y;
    Vec const light = Vec{0.20, 0.22, 0.27} + sky * Vec{0.20, 0.21, 0.23} * (1.0 - 0.55 * shadow) + sun * Vec{0.80, 0.75, 0.66};
    double const mirror = std::fmax(glm::dot(normal, glm::normalize(to_light + to_eye)), 0.0);
    double const highlight = std::pow(mirror, 40.0);
    return albedo * light + Vec{1.0, 0.97, 0.90} * (gloss * highlight * (1.0 - shadow));
}

/// A place on the desk, turned about the vertical axis. Objects are made at the origin and moved to this place.
struct Placement {
    double x = 0.0, z = 0.0, angle = 0.0;

    Vec turn(Vec v) const
    {
        double const c = std::cos(angle), s = std::sin(angle);
        return {c * v.x + s * v.z, v.y, c * v.z - s * v.x};
    }
    Vec operator()(Vec v) const { return turn(v) + Vec{x, 0.0, z}; }
};

inline constexpr Placement paper_place{-0.47, -0.25, 0.24}, keyboard_place{-0.03, -0.17, 0.03};

/// Covers surfaces of the scene with lit Gaussians.
class Painter {
public:
    explicit Painter(Map& map) : brush_(map, 2024) {}

protected:
    /// A flat patch, lit on the side of edge_u x edge_v. `paint` returns its unlit colour at (u, v) in [0, 1].
    template <class Paint>
    void rectangle(Vec corner, Vec edge_u, Vec edge_v, double spacing_u, double spacing_v,
                   Paint paint, double gloss = 0.0, double fill = 0.68, double jitter = 0.25)
    {
        double const length_u = glm::length(edge_u), length_v = glm::length(edge_v);
        auto const nu = std::max(1, static_cast<int>(length_u / spacing_u + 0.5));
        auto const nv = std::max(1, static_cast<int>(length_v / spacing_v + 0.5));
        Vec const u_axis = edge_u / length_u, v_axis = edge_v / length_v;
        Vec const normal = glm::cross(u_axis, v_axis);
        for (int j = 0; j < nv; ++j)
            for (int i = 0; i < nu; ++i) {
                double const u = (i + 0.5 + jitter * brush_.random.between(-1.0, 1.0)) / nu;
                double const v = (j + 0.5 + jitter * brush_.random.between(-1.0, 1.0)) / nv;
                Vec const place = corner + u * edge_u + v * edge_v;
                if (covered(place)) continue;
                brush_.touch({place, u_axis, v_axis, length_u / nu, length_v / nv, lit(paint(u, v), place, normal, gloss, shadow_at(place, normal))},
                             fill);
            }
    }

    /// A box about `centre`, before placement. It has four sides, because nobody sees its floor or its back. `paint` takes the side (0 top,
    /// 1 near, 2 left, 3 right) before (u, v).
    template <class Paint>
    void box(Placement const& p, Vec centre, Vec size, double spacing, Paint paint, double gloss = 0.0)
    {
        Vec const x = p.turn({size.x, 0.0, 0.0}), y{0.0, size.y, 0.0}, z = p.turn({0.0, 0.0, size.z});
        Vec const low = p(centre) - 0.5 * (x + y + z); // the left, upper, near corner
        auto const face = [&](int side) { return [&paint, side](double u, double v) { return paint(side, u, v); }; };
        auto const side = [&](int number, Vec corner, Vec u, Vec v, double spacing_u, double spacing_v) {
            rectangle(corner, u, v, spacing_u, spacing_v, face(number), gloss, 0.68, 0.08);
        };
        side(0, low, x, z, spacing, spacing);
        side(1, low + y, x, -y, 0.8 * spacing, 0.66 * spacing);
        side(2, low, z, y, spacing, spacing);
        side(3, low + x + z, -z, y, spacing, 0.66 * spacing);
    }

    /// Equal areas by the golden angle. `part`: 1 is a whole sphere, 0.5 its upper half.
    template <class Paint>
    void ellipsoid(Vec centre, Vec radius, Placement const& p, double part, int count, double gloss, Paint paint)
    {
        for (int k = 0; k < count; ++k) {
            double const up = 1.0 - 2.0 * part * (k + 0.5) / count; // 1 at the top
            double const ring = std::sqrt(1.0 - up * up);
            double const angle = 0.38196601125 * full_turn * k;
            Vec const unit{ring * std::cos(angle), -up, ring * std::sin(angle)};
            Vec const normal = glm::normalize(p.turn(unit / radius));
            Vec const u = glm::normalize(glm::cross(normal, Vec{0.31, 0.17, 0.93}));
            double const mean_radius = std::cbrt(radius.x * radius.y * radius.z);
            double const spacing = std::sqrt(2.0 * full_turn * part / count) * std::fmax(mean_radius, 0.8 * radius.x);
            Vec const place = p(centre + unit * radius);
            brush_.touch({place, u, glm::cross(normal, u), spacing, spacing, lit(paint(unit), place, normal, gloss)}, 0.62);
        }
    }

    /// The side of an upright round object: radius and height as functions of v in [0, 1], seen from inside or outside.
    template <class Radius, class Paint>
    void barrel(Placement const& p, double bottom, double top, Radius radius, double spacing, bool inside, double gloss, Paint paint)
    {
        auto const rows = static_cast<int>((bottom - top) / spacing + 0.5);
        for (int j = 0; j < rows; ++j) {
            double const v = (j + 0.5) / rows, r = radius(v);
            double const slope = (radius(v + 0.01) - radius(v - 0.01)) / 0.02 / (bottom - top);
            auto const count = static_cast<int>(full_turn * r / spacing + 0.5);
            for (int i = 0; i < count; ++i) {
                double const share = (i + 0.5 * (j % 2) + brush_.random.between(-0.06, 0.06)) / count;
                double const c = std::cos(full_turn * share), s = std::sin(full_turn * share);
                Vec const place = p({r * c, bottom + (top - bottom) * v, r * s});
                Vec normal = p.turn(glm::normalize(Vec{c, slope, s}));
                if (inside) normal = -normal;
                Vec const u = p.turn({-s, 0.0, c});
                double const shade = inside ? 0.35 + 0.65 * v : 0.72 + 0.28 * smooth(0.0, 0.25, v);
                brush_.touch({place, u, glm::cross(normal, u), spacing, spacing, shade * lit(paint(share, v), place, normal, gloss)}, 0.64);
            }
        }
    }

    Brush brush_;

private:
    /// Is the place on the desk top under the sheet or the keyboard? A disc there could be sorted in front of the object that lies on it.
    static bool covered(Vec place)
    {
        auto const under = [&](Placement const& p, double half_x, double half_z) {
            double const c = std::cos(p.angle), s = std::sin(p.angle), x = place.x - p.x, z = place.z - p.z;
            return std::fabs(c * x - s * z) < half_x && std::fabs(s * x + c * z) < half_z;
        };
        return place.y == 0.0 && (under(paper_place, 0.14, 0.104) || under(keyboard_place, 0.25, 0.075));
    }

    /// Soft shadows on the desk top: dark spots, each an ellipse that an object throws to the right and to the back.
    static double shadow_at(Vec place, Vec normal)
    {
        if (place.y < -0.004 || normal.y > -0.9) return 0.0;
        struct Spot {
            double x, z, half_x, half_z, angle, depth;
        };
        static constexpr std::array<Spot, 12> spots{{
            {0.03, 0.36, 0.46, 0.15, 0.0, 0.62},       // monitor
            {0.02, 0.34, 0.20, 0.11, 0.0, 0.45},       // its foot
            {-0.02, -0.155, 0.285, 0.085, 0.03, 0.80}, // keyboard
            {0.372, -0.155, 0.045, 0.065, -0.2, 0.75}, // mouse
            {-0.61, 0.26, 0.20, 0.15, 0.22, 0.80},     // books
            {0.77, 0.29, 0.12, 0.10, 0.0, 0.75},       // plant
            {0.53, 0.05, 0.075, 0.07, 0.0, 0.85},      // mug
            {0.59, 0.11, 0.10, 0.055, -0.6, 0.60},
            {-0.485, -0.01, 0.07, 0.065, 0.0, 0.90}, // ball
            {-0.44, 0.035, 0.09, 0.06, -0.6, 0.55},
            {-0.465, -0.245, 0.165, 0.125, 0.24, 0.25}, // paper
            {0.56, -0.23, 0.12, 0.03, -0.4, 0.30},      // pencils
        }};
        double light = 1.0;
        for (auto const& s : spots) {
            double const c = std::cos(s.angle), n = std::sin(s.angle);
            double const dx = place.x - s.x, dz = place.z - s.z;
            double const a = (c * dx - n * dz) / s.half_x, b = (n * dx + c * dz) / s.half_z;
            light *= 1.0 - s.depth * (1.0 - smooth(0.55, 1.35, std::sqrt(std::sqrt(a * a * a * a + b * b * b * b))));
        }
        return 1.0 - light;
    }
};

}}} // namespace tilemesh::scene::detail
