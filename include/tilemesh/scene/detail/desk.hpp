#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <tilemesh/scene/detail/painter.hpp>
#include <tilemesh/scene/map.hpp>

// The built-in scene; see painter.hpp for its axes and units.
namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// Paints the objects on the desk, and the wall and floor behind it.
class Desk : Painter {
public:
    using Painter::Painter;

    void paint()
    {
        background();
        desk_top();
        monitor();
        keyboard(keyboard_place);
        mouse({0.36, -0.17, -0.2});
        books({-0.66, 0.22, 0.22});
        plant({0.71, 0.24, 0.0});
        mug({0.50, 0.02, 0.35});
        ball({-0.50, -0.03, 0.0});
        paper(paper_place);
        pencils();
        cables();
    }

private:
    /// Thirteen blobs behind everything: a wall that is warm on the window's side, its side walls to the left and right, and the dark
    /// floor.
    void background()
    {
        auto const colour = [](double across, int row) {
            Vec const wall = mix({0.93, 0.80, 0.64}, {0.31, 0.42, 0.55}, across) * (row == 0 ? 1.0 : 0.82);
            return row == 2 ? mix({0.30, 0.25, 0.24}, {0.14, 0.16, 0.21}, across) : wall;
        };
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column)
                brush_.dab({2.4 * (column - 1), -2.0 + 1.55 * row, 3.2 + 0.15 * row + 0.04 * column}, glm::dmat3{1.0}, {1.8, 1.05, 0.05},
                           colour(0.1 + 0.4 * column, row), row == 1 ? 1.0 : 0.97);
        for (int row = 0; row < 2; ++row)
            for (double const side : {-1.0, 1.0})
                brush_.dab({4.2 * side, -0.9 + 2.1 * row, 1.0}, glm::dmat3{1.0}, {0.05, 1.3, 1.7}, colour(0.5 + 0.5 * side, 1 + row), 0.98);
    }

    void desk_top()
    {
        constexpr double width = 2.5, depth = 1.16, front = -0.56, plank = 0.145;
        auto const wood = [&](double x, double z) {
            double const row = std::floor(z / plank);
            double const in_plank = z / plank - row;
            auto const seed = static_cast<std::uint32_t>(static_cast<std::int32_t>(row) + 100);
            // Long fibres, wandering slowly, and one broad figure a plank.
            double const wander = 0.02 * value_noise(2.5 * x, 6.0 * z, 5 + seed);
            double const fibre = value_noise(3.0 * x, 170.0 * (z + wander), seed);
            double const figure = value_noise(1.3 * x, 26.0 * (z + 3.0 * wander), 77 + seed);
            double const tone = value_noise(0.5, 0.5 + row, 9);
            Vec colour = mix({0.52, 0.31, 0.16}, {0.86, 0.61, 0.37}, 0.30 * fibre + 0.45 * figure + 0.30 * tone);
            double const seam = std::fmin(in_plank, 1.0 - in_plank) * plank;
            return colour * (0.62 + 0.38 * smooth(0.0, 0.006, seam));
        };
        rectangle(
            {-0.5 * width, 0.0, front}, {width, 0.0, 0.0}, {0.0, 0.0, depth}, 0.036, 0.0082,
            [&](double u, double v) { return wood((u - 0.5) * width, front + v * depth); }, 0.10);
        rectangle({-0.5 * width, 0.045, front}, {width, 0.0, 0.0}, {0.0, -0.045, 0.0}, 0.04, 0.009,
                  [&](double u, double) { return 0.8 * wood((u - 0.5) * width, front); });
    }

    void monitor()
    {
        constexpr double half = 0.45, top = -0.60, bottom = -0.125, z = 0.36;
        constexpr double wide = 2.0 * half, high = bottom - top;
        auto const dark = [](double, double) { return Vec{0.13, 0.14, 0.16}; };
        // Foot, neck and back plate.
        rectangle(
            {-0.15, -0.008, 0.26}, {0.30, 0.0, 0.0}, {0.0, 0.0, 0.19}, 0.012, 0.012,
            [](double, double) {
                return Vec{0.30, 0.31, 0.34};
            },
            0.35);
        rectangle({-0.15, 0.0, 0.26}, {0.30, 0.0, 0.0}, {0.0, -0.008, 0.0}, 0.008, 0.004, dark);
        rectangle({-0.035, 0.0, 0.385}, {0.07, 0.0, 0.0}, {0.0, -0.2, 0.0}, 0.010, 0.010, [](double, double v) {
            return Vec{0.24, 0.25, 0.28} * (0.7 + 0.5 * v);
        });
        rectangle({-half, bottom + 0.02, z + 0.012}, {wide, 0.0, 0.0}, {0.0, -high - 0.025, 0.0}, 0.030, 0.030, dark, 0.0, 0.68, 0.0);
        // The bezel: four strips, the lower one higher, with a lamp.
        auto const strip = [&](Vec corner, Vec u, Vec v) {
            rectangle(
                corner, u, v, 0.009, 0.009,
                [](double, double) {
                    return Vec{0.16, 0.17, 0.19};
                },
                0.3, 0.68, 0.04);
        };
        strip({-half - 0.018, top, z}, {wide + 0.036, 0.0, 0.0}, {0.0, -0.018, 0.0});
        strip({-half - 0.018, bottom + 0.034, z}, {wide + 0.036, 0.0, 0.0}, {0.0, -0.034, 0.0});
        strip({-half - 0.018, bottom, z}, {0.018, 0.0, 0.0}, {0.0, -high, 0.0});
        strip({half, bottom, z}, {0.018, 0.0, 0.0}, {0.0, -high, 0.0});
        glow({half - 0.03, bottom + 0.017, z - 0.004}, 0.003, 0.003, {0.35, 1.0, 0.75});

        // The picture it shows: dusk, brighter to the middle, in patches twice as large as a
        // letter's dots.
        constexpr int columns = 84, rows = 45;
        for (int j = 0; j < rows; ++j)
            for (int i = 0; i < columns; ++i) {
                double const u = (i + 0.5) / columns, v = (j + 0.5) / rows;
                double const centre = std::exp(-6.0 * ((u - 0.5) * (u - 0.5) + 1.6 * (v - 0.36) * (v - 0.36)));
                Vec const colour = mix({0.035, 0.05, 0.13}, {0.15, 0.13, 0.36}, centre) + Vec{0.05, 0.0, 0.06} * (1.0 - v);
                glow({-half + wide * u, top + high * v, z}, wide / columns, high / rows, colour);
            }
        lettering(z - 0.010, top + 0.075);
        tiles(z - 0.010, top + 0.255);
    }

    /// A dot of a screen: it shines by itself.
    void glow(Vec place, double spacing_u, double spacing_v, Vec colour, double fill = 0.68)
    {
        brush_.touch({place, {1.0, 0.0, 0.0}, {0.0, -1.0, 0.0}, spacing_u, spacing_v, colour}, fill);
    }

    /// TILEMESH in a 5 x 7 font: each lit cell is 4 x 4 dots of 4 mm.
    void lettering(double z, double top)
    {
        constexpr std::array<std::array<std::uint8_t, 7>, 8> letters{{
            {0x1f, 0x04, 0x04, 0x04, 0x04, 0x04, 0x04}, // T
            {0x0e, 0x04, 0x04, 0x04, 0x04, 0x04, 0x0e}, // I
            {0x10, 0x10, 0x10, 0x10, 0x10, 0x10, 0x1f}, // L
            {0x1f, 0x10, 0x10, 0x1e, 0x10, 0x10, 0x1f}, // E
            {0x11, 0x1b, 0x15, 0x15, 0x11, 0x11, 0x11}, // M
            {0x1f, 0x10, 0x10, 0x1e, 0x10, 0x10, 0x1f}, // E
            {0x0f, 0x10, 0x10, 0x0e, 0x01, 0x01, 0x1e}, // S
            {0x11, 0x11, 0x11, 0x1f, 0x11, 0x11, 0x11}, // H
        }};
        constexpr double cell = 0.0166, dot = cell / 4.0, width = 47.0 * cell;
        for (std::size_t letter = 0; letter < letters.size(); ++letter)
            for (int dot_y = 0; dot_y < 28; ++dot_y)
                for (int dot_x = 0; dot_x < 20; ++dot_x) {
                    unsigned const row = letters[letter][static_cast<std::size_t>(dot_y / 4)];
                    if (!((row >> (4 - dot_x / 4)) & 1u)) continue;
                    double const x = (6.0 * static_cast<double>(letter) * cell) + (dot_x + 0.5) * dot;
                    double const y = (dot_y + 0.5) * dot;
                    Vec const colour = mix(mix({0.45, 0.95, 1.0}, {1.0, 0.98, 0.92}, x / width), {1.0, 0.80, 0.45}, 0.55 * dot_y / 28.0);
                    glow({-0.5 * width + x, top + y, z}, dot, dot, colour, 0.62);
                }
    }

    /// Under the letters, a mesh of tiles: a Gaussian blooms from its anchor tile to the tiles that
    /// it overlaps.
    void tiles(double z, double top)
    {
        constexpr int columns = 22, rows = 5;
        constexpr double pitch = 0.0352, side = 0.029;
        double const left = -0.5 * columns * pitch;
        for (int j = 0; j < rows; ++j)
            for (int i = 0; i < columns; ++i) {
                auto const bloom = [&](double x, double y, double wide, double high) {
                    double const dx = (i - x) / wide, dy = (j - y) / high;
                    return std::exp(-0.5 * (dx * dx + dy * dy));
                };
                Vec const colour = Vec{0.09, 0.11, 0.22} + Vec{1.0, 0.42, 0.16} * bloom(5.0, 2.2, 2.2, 1.1) +
                                   Vec{0.16, 0.80, 0.78} * bloom(11.5, 1.6, 2.6, 1.3) + Vec{0.80, 0.24, 0.75} * bloom(17.0, 2.5, 2.0, 1.0);
                for (int k = 0; k < 9; ++k)
                    glow({left + i * pitch + 0.5 * pitch + (k % 3 - 1) * side / 3.0, top + j * pitch + 0.5 * pitch + (k / 3 - 1) * side / 3.0, z},
                         side / 3.0, side / 3.0, colour * (k == 4 ? 1.12 : 1.0), 0.48);
            }
        // Links between neighbours: needles across the gaps.
        for (int j = 0; j < rows; ++j)
            for (int i = 0; i < columns; ++i) {
                Vec const here{left + (i + 0.5) * pitch, top + (j + 0.5) * pitch, z + 0.001};
                if (i + 1 < columns) brush_.needle(here, here + Vec{pitch, 0.0, 0.0}, 0.00013, {0.21, 0.26, 0.44});
                if (j + 1 < rows) brush_.needle(here, here + Vec{0.0, pitch, 0.0}, 0.00013, {0.21, 0.26, 0.44});
            }
    }

    void keyboard(Placement const& p)
    {
        constexpr double wide = 0.53, deep = 0.165, high = 0.012;
        box(
            p, {0.0, -0.5 * high, 0.0}, {wide, high, deep}, 0.011,
            [](int side, double, double) {
                return side == 0 ? Vec{0.20, 0.21, 0.24} : Vec{0.44, 0.45, 0.48};
            },
            0.1);
        constexpr double pitch = 0.0345;
        for (int row = 0; row < 5; ++row)
            for (int key = 0; key < 15; ++key) {
                // The nearest row has a long space bar in place of six keys.
                bool const space = row == 0 && key == 4;
                if (row == 0 && key > 4 && key < 10) continue;
                double const x = (key - 7.0) * pitch + (space ? 2.5 * pitch : 0.0);
                double const z = (row - 2.0) * 0.0318;
                double const width = space ? 6.0 * pitch - 0.006 : pitch - 0.006;
                bool const accent = (row == 4 && key == 0) || (row == 2 && key == 14);
                bool const grey = key == 0 || key >= 13 || row == 0;
                Vec const cap = accent ? Vec{0.98, 0.48, 0.26} : space ? Vec{0.93, 0.92, 0.88} : grey ? Vec{0.56, 0.62, 0.68} : Vec{0.93, 0.92, 0.88};
                Vec const low = p({x - 0.5 * width, -high - 0.009, z - 0.0128});
                Vec const u = p.turn({width, 0.0, 0.0}), v = p.turn({0.0, 0.0, 0.0256});
                auto const paint = [&](double, double) { return cap; };
                rectangle(low, u, v, 0.0064, 0.0064, paint, 0.15, 0.6, 0.1);
                rectangle(
                    low + Vec{0.0, 0.009, 0.0}, u, {0.0, -0.009, 0.0}, 0.0072, 0.0048, [&](double, double) { return 0.78 * cap; }, 0.0, 0.6, 0.1);
                if (!space) // its legend: two short strokes
                    for (int stroke = 0; stroke < 2; ++stroke) {
                        Vec const a = p({x - 0.004 + 0.004 * stroke, -high - 0.0098, z + 0.004});
                        Vec const b = p({x - 0.006 + 0.009 * stroke, -high - 0.0098, z - 0.003});
                        brush_.needle(a, b, 0.0005, {0.16, 0.17, 0.20});
                    }
            }
    }

    void mouse(Placement const& p)
    {
        ellipsoid({0.0, 0.0, 0.0}, {0.033, 0.034, 0.055}, p, 0.5, 800, 0.12, [](Vec unit) {
            bool const wheel = std::fabs(unit.x) < 0.09 && unit.z < -0.3 && unit.z > -0.75;
            return wheel ? Vec{0.12, 0.12, 0.14} : Vec{0.90, 0.89, 0.86};
        });
    }

    void ball(Placement const& p)
    {
        // Six gores in turn, a cap on the pole; the pole leans towards the viewer.
        ellipsoid({0.0, -0.088, 0.0}, {0.088, 0.088, 0.088}, p, 1.0, 3700, 0.75, [](Vec unit) {
            double const c = 0.80, s = 0.60;
            double const pole = -(c * unit.y) - s * (0.6 * unit.z - 0.8 * unit.x);
            double const x = 0.8 * unit.z + 0.6 * unit.x;
            double const z = c * (0.6 * unit.z - 0.8 * unit.x) - s * unit.y;
            static Vec const white{0.98, 0.96, 0.90};
            static std::array<Vec, 6> const gores{{{0.93, 0.24, 0.20}, white, {0.16, 0.46, 0.85}, white, {0.99, 0.76, 0.16}, white}};
            // Borders blend over about one sample, or they would be ragged.
            double const ring = std::sqrt(std::fmax(1.0 - pole * pole, 1e-6));
            double const at = 6.0 * (std::atan2(z, x) / full_turn + 0.5), gore = std::floor(at);
            auto const here = static_cast<std::size_t>(gore) % 6;
            double const soft = 0.035 / ring;
            Vec const colour = mix(mix(gores[(here + 5) % 6], gores[here], 0.5 + 0.5 * smooth(0.0, soft, at - gore)), gores[(here + 1) % 6],
                                   0.5 * smooth(1.0 - soft, 1.0, at - gore));
            return mix(colour, white, smooth(0.925, 0.955, std::fabs(pole)));
        });
    }

    void books(Placement const& p)
    {
        struct Book {
            double width, height, depth, x, angle;
            Vec cover;
            bool chequered;
        };
        static std::array<Book, 3> const stack{{{0.34, 0.046, 0.25, 0.0, 0.0, {0.13, 0.36, 0.42}, false},
                                                {0.31, 0.034, 0.23, 0.01, 0.10, {0.74, 0.22, 0.20}, false},
                                                {0.25, 0.028, 0.20, -0.01, -0.14, {0.95, 0.72, 0.24}, true}}};
        double floor = 0.0;
        for (auto const& b : stack) {
            Placement const own{p.x + b.x, p.z, p.angle + b.angle};
            auto const paint = [&](int side, double u, double v) {
                bool const pages = side == 3 && v > 0.14 && v < 0.86;
                if (pages) return Vec{0.94, 0.91, 0.82} * (0.82 + 0.18 * value_noise(3.0 * u, 40.0 * v, 3));
                // On the spine that faces the viewer: a label between two gold bands. On the top: a
                // chequered panel.
                if (side == 1 && (std::fabs(u - 0.12) < 0.018 || std::fabs(u - 0.88) < 0.018)) return Vec{0.98, 0.86, 0.52};
                if (side == 1 && u > 0.30 && u < 0.70 && v > 0.3 && v < 0.7) return Vec{0.97, 0.93, 0.83};
                if (side == 0 && b.chequered && u > 0.15 && u < 0.85 && v > 0.125 && v < 0.875) {
                    auto const square = static_cast<int>((u - 0.15) * 10.0) + static_cast<int>((v - 0.125) * 8.0);
                    return square % 2 ? Vec{0.98, 0.95, 0.87} : 0.55 * b.cover;
                }
                return b.cover;
            };
            box(own, {0.0, floor - 0.5 * b.height, 0.0}, {b.width, b.height, b.depth}, b.chequered ? 0.00625 : 0.0082, paint, 0.15);
            floor -= b.height;
        }
    }

    void mug(Placement const& p)
    {
        constexpr double r = 0.056, high = 0.125;
        Vec const glaze{0.15, 0.50, 0.55}, cream{0.97, 0.94, 0.87};
        auto const side = [&](double, double v) {
            if (v > 0.62 && v < 0.72) return Vec{0.98, 0.62, 0.28};
            return v > 0.55 ? cream : glaze;
        };
        barrel(
            p, 0.0, -high, [&](double v) { return r * (0.93 + 0.07 * smooth(0.0, 0.12, v)); }, 0.0049, false, 0.6, side);
        barrel(
            p, -0.09, -high, [&](double) { return r - 0.005; }, 0.0055, true, 0.1, [&](double, double) { return cream; });
        // Lip and coffee.
        for (int i = 0; i < 90; ++i) {
            double const a = full_turn * i / 90.0;
            Vec const u = p.turn({-std::sin(a), 0.0, std::cos(a)}), normal{0.0, -1.0, 0.0};
            Vec const place = p({(r - 0.0025) * std::cos(a), -high, (r - 0.0025) * std::sin(a)});
            brush_.touch({place, u, glm::cross(normal, u), 0.0044, 0.0055, lit(cream, place, normal, 0.3)}, 0.6);
        }
        for (int k = 0; k < 260; ++k) {
            double const a = 0.38196601125 * full_turn * k, ring = (r - 0.006) * std::sqrt((k + 0.5) / 260.0);
            Vec const place = p({ring * std::cos(a), -0.094, ring * std::sin(a)});
            double const froth = smooth(0.55, 1.0, ring / r);
            brush_.touch({place,
                          {1.0, 0.0, 0.0},
                          {0.0, 0.0, 1.0},
                          0.0062,
                          0.0062,
                          lit(mix({0.22, 0.11, 0.06}, {0.62, 0.42, 0.26}, froth), place, {0.0, -1.0, 0.0}, 0.2, 0.35)},
                         0.66);
        }
        // The handle: the outer half of a torus, its ends inside the wall.
        for (int i = 0; i < 46; ++i)
            for (int k = 0; k < 12; ++k) {
                double const a = full_turn * (-0.26 + 0.52 * (i + 0.5) / 46.0), b = full_turn * (k + 0.5 * (i % 2)) / 12.0;
                constexpr double big = 0.033, tube = 0.0085;
                Vec const out{std::cos(a), std::sin(a), 0.0};
                Vec const normal = p.turn(out * std::cos(b) + Vec{0.0, 0.0, 1.0} * std::sin(b));
                Vec const place = p(Vec{r + 0.004, -0.064, 0.0} + big * out + Vec{0.0, 0.0, tube * std::sin(b)} + tube * std::cos(b) * out);
                Vec const u = p.turn({-std::sin(a), std::cos(a), 0.0});
                brush_.touch({place, u, glm::cross(normal, u), 0.0046, 0.0045, lit(glaze, place, normal, 0.6)}, 0.66);
            }
    }

    void plant(Placement const& p)
    {
        constexpr double high = 0.13;
        barrel(
            p, 0.0, -high, [](double v) { return 0.058 + 0.022 * v + (v > 0.82 ? 0.006 : 0.0); }, 0.0075, false, 0.1,
            [](double, double v) {
                return Vec{0.80, 0.42, 0.28} * (v > 0.82 ? 1.08 : 1.0);
            });
        for (int k = 0; k < 160; ++k) { // earth
            double const a = 0.38196601125 * full_turn * k, ring = 0.078 * std::sqrt((k + 0.5) / 160.0);
            Vec const place = p({ring * std::cos(a), -high + 0.012, ring * std::sin(a)});
            // In its own statement, because the compiler chooses the order in which it evaluates arguments.
            Vec const colour = Vec{0.20, 0.13, 0.09} * brush_.random.between(0.6, 1.3);
            brush_.dab(place, glm::dmat3{1.0}, {0.006, 0.004, 0.006}, colour, brush_.opacity());
        }
        // Leaves: arched blades, each a strip of discs with a bright rib.
        for (int leaf = 0; leaf < 26; ++leaf) {
            double const a = full_turn * (0.38196601125 * leaf), reach = brush_.random.between(0.06, 0.20);
            double const lift = brush_.random.between(0.13, 0.34), droop = brush_.random.between(0.3, 0.9) * reach;
            double const broad = brush_.random.between(0.014, 0.024);
            Vec const green = mix({0.13, 0.42, 0.20}, {0.50, 0.74, 0.26}, brush_.random.uniform());
            Vec const out{std::cos(a), 0.0, std::sin(a)}, side{-std::sin(a), 0.0, std::cos(a)};
            auto const spine = [&](double t) { return p(out * (0.012 + reach * t) + Vec{0.0, -high + 0.01 - lift * t + droop * t * t, 0.0}); };
            constexpr int steps = 22;
            for (int i = 0; i < steps; ++i) {
                double const t = (i + 0.5) / steps;
                Vec const along = glm::normalize(spine(t + 0.01) - spine(t - 0.01));
                double const half = broad * std::sqrt(std::fmax(4.0 * t * (1.0 - t), 0.02)) * (1.15 - 0.5 * t);
                Vec normal = glm::normalize(glm::cross(side, along));
                if (normal.y > 0.0) normal = -normal;
                for (int k = -1; k <= 1; ++k) {
                    Vec const place = spine(t) + side * (0.66 * half * k);
                    Vec const bent = glm::normalize(normal + 0.45 * k * side);
                    Vec const colour = green * (k == 0 ? 1.18 : 0.92) * (0.7 + 0.4 * t);
                    brush_.touch({place, along, glm::cross(bent, along), glm::length(spine(1.0) - spine(0.0)) / steps * 1.2, 0.66 * half,
                                  lit(colour, place, bent, 0.12)},
                                 0.62);
                }
            }
        }
    }

    void paper(Placement const& p)
    {
        constexpr double wide = 0.29, deep = 0.21;
        auto const white = [](double, double) { return Vec{0.97, 0.96, 0.93}; };
        rectangle(p({-0.5 * wide, -0.003, -0.5 * deep}), p.turn({wide, 0.0, 0.0}), p.turn({0.0, 0.0, deep}), 0.0098, 0.0098, white, 0.0, 0.62, 0.1);
        // Lines of writing: words are needles.
        for (int line = 0; line < 8; ++line) {
            double x = -0.125;
            double const z = 0.078 - 0.021 * line, end = line % 4 == 3 ? 0.02 : 0.11;
            while (x < end) {
                double const word = brush_.random.between(0.012, 0.034);
                brush_.needle(p({x, -0.006, z}), p({x + word, -0.006, z}), 0.00012 * word / 0.034, {0.14, 0.16, 0.28});
                x += word + 0.009;
            }
        }
    }

    /// Hexagonal rods of long needles around a core; a cone of wood, a tip of lead, an end of
    /// rubber.
    void pencils()
    {
        struct Pencil {
            Vec from, to, colour;
        };
        static std::array<Pencil, 4> const all{{{{0.46, -0.006, -0.30}, {0.63, -0.006, -0.20}, {0.97, 0.70, 0.14}},
                                                {{0.44, -0.006, -0.25}, {0.60, -0.006, -0.14}, {0.20, 0.50, 0.82}},
                                                {{0.66, -0.014, -0.27}, {0.47, -0.014, -0.19}, {0.86, 0.24, 0.24}},
                                                {{-0.35, -0.008, -0.29}, {-0.53, -0.008, -0.21}, {0.24, 0.62, 0.36}}}};
        for (auto const& pencil : all) {
            Vec const way = pencil.to - pencil.from, along = glm::normalize(way);
            Vec const side = glm::normalize(glm::cross(Vec{0.0, 1.0, 0.0}, along)), up = glm::cross(along, side);
            constexpr double radius = 0.0048;
            auto const rod = [&](double begin, double end, double thick, Vec colour, int pieces) {
                for (int k = 0; k < 14; ++k) {
                    double const a = full_turn * k / 14.0;
                    Vec const normal = side * std::cos(a) + up * std::sin(a);
                    for (int i = 0; i < pieces; ++i) {
                        double const at = begin + (end - begin) * i / pieces, width = (end - begin) / pieces;
                        Vec const place = pencil.from + way * at + normal * (thick * radius);
                        // 0.4 * length / 110: an anisotropy above 100.
                        double const length = glm::length(way) * width;
                        brush_.needle(place, place + way * width, std::fmin(0.4 * length / 110.0, 0.0011), lit(colour, place, normal, 0.5));
                    }
                }
            };
            rod(0.13, 0.90, 1.0, pencil.colour, 5);
            rod(0.13, 0.90, 0.75, 0.8 * pencil.colour, 5);
            rod(0.90, 0.94, 1.0, {0.75, 0.76, 0.78}, 1);
            rod(0.94, 1.0, 1.0, {0.95, 0.58, 0.60}, 1);
            for (int ring = 0; ring < 6; ++ring)
                rod(0.02 * ring + 0.015, 0.02 * ring + 0.04, (ring + 0.6) / 6.5, ring < 2 ? Vec{0.15, 0.15, 0.17} : Vec{0.90, 0.72, 0.50}, 1);
        }
    }

    /// Thin leads: chains of needles along cubic arcs on the desk.
    void cables()
    {
        auto const cable = [&](Vec a, Vec b, Vec c, Vec d, Vec colour) {
            auto const at = [&](double t) {
                double const s = 1.0 - t;
                return s * s * s * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t * t * t * d;
            };
            constexpr int pieces = 26;
            for (int i = 0; i < pieces; ++i)
                for (int strand = 0; strand < 7; ++strand) {
                    double const t0 = static_cast<double>(i) / pieces, t1 = (i + 1.35) / pieces;
                    Vec const side = glm::normalize(glm::cross(Vec{0.0, 1.0, 0.0}, at(t1) - at(t0)));
                    double const turn = full_turn * strand / 14.0;
                    Vec const normal = side * std::cos(turn) + Vec{0.0, -std::sin(turn), 0.0};
                    Vec const shift = 0.0022 * normal;
                    double const length = glm::length(at(t1) - at(t0));
                    brush_.needle(at(t0) + shift, at(t1) + shift, 0.4 * length / 105.0, lit(colour, at(t0), normal, 0.3));
                }
        };
        cable({-0.10, -0.003, -0.08}, {-0.14, -0.003, 0.10}, {-0.30, -0.003, 0.12}, {-0.20, -0.003, 0.46}, {0.13, 0.13, 0.15});
        cable({0.37, -0.003, -0.11}, {0.40, -0.003, 0.10}, {0.26, -0.003, 0.14}, {0.22, -0.003, 0.46}, {0.62, 0.62, 0.64});
    }
};

inline void paint_desk_scene(Map& map)
{
    map.gaussians.reserve(42000);
    Desk(map).paint();
}

}}} // namespace tilemesh::scene::detail
