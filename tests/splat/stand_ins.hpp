#pragma once
#include "support.hpp"
#include <tilemesh/scene/map.hpp>

// Made maps. Each differs from a real map in its own way: a condition that holds for any map must hold for these.
namespace support {

/// A rotation in a random direction; all directions are equally likely.
inline void turn(splat::Gaussian& g, Random& random)
{
    constexpr float two_pi = 6.2831853f;
    float const u = random.uniform(0, 1), a = random.uniform(0, two_pi), b = random.uniform(0, two_pi);
    g.rotation[0] = std::sqrt(1 - u) * std::sin(a);
    g.rotation[1] = std::sqrt(1 - u) * std::cos(a);
    g.rotation[2] = std::sqrt(u) * std::sin(b);
    g.rotation[3] = std::sqrt(u) * std::cos(b);
}

/// One of three maps, equal on every run. They fit onto the tiles of Mk2 at 1280 x 720, and into a bounding box some metres wide. Throws
/// for any other name.
/// - `flat`: 20,000 discs of one size in one plane, a third of them exactly opaque. Seen from the front all have one depth.
/// - `needles`: 12,000 needles far thinner than a pixel, up to 5,000 times as long as wide, in every direction; colours up to 3.8, the
///   brightest
/// in a real map.
/// - `fog`: 3,000 faint balls, each about 200 pixels wide: about a hundred of them contribute to a pixel.
inline scene::Map stand_in(std::string const& name)
{
    scene::Map map;
    map.name = name;
    Random random(2026);
    auto const add = [&](float x, float y, float z, float largest_colour) -> splat::Gaussian& {
        splat::Gaussian g{};
        g.id = splat::GaussianId{static_cast<std::uint32_t>(map.gaussians.size()) + 1};
        g.mean_world[0] = x;
        g.mean_world[1] = y;
        g.mean_world[2] = z;
        for (float& c : g.colour) c = random.uniform(0, largest_colour);
        g.rotation[0] = 1;
        return map.gaussians.emplace_back(g);
    };
    if (name == "flat") {
        for (int i = 0; i < 20'000; ++i) {
            auto& g = add(random.uniform(-4, 4), random.uniform(-2.25f, 2.25f), 0, 1);
            g.log_scale[0] = g.log_scale[1] = std::log(0.03f);
            g.log_scale[2] = -12;
            g.opacity = i % 3 == 0 ? 1 : random.uniform(0.1f, 1);
        }
    } else if (name == "needles") {
        for (int i = 0; i < 12'000; ++i) {
            auto& g = add(random.uniform(-4, 4), random.uniform(-2.25f, 2.25f), random.uniform(-2, 2), 3.8f);
            g.log_scale[0] = random.uniform(std::log(0.02f), std::log(0.5f));
            g.log_scale[1] = g.log_scale[2] = std::log(1e-4f);
            g.opacity = random.uniform(0.05f, 1);
            turn(g, random);
        }
    } else if (name == "fog") {
        for (int i = 0; i < 3'000; ++i) {
            auto& g = add(random.uniform(-4, 4), random.uniform(-2.25f, 2.25f), random.uniform(-2, 2), 1);
            for (float& s : g.log_scale) s = random.uniform(std::log(0.1f), std::log(0.4f));
            g.opacity = random.uniform(0.004f, 0.3f);
            turn(g, random);
        }
    } else {
        throw std::invalid_argument("TILEMESH_STAND_IN is \"" + name + "\" (there is no such map); name flat, needles or fog");
    }
    return map;
}

} // namespace support
