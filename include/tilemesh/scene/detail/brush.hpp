#pragma once
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/gaussian.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// PCG32 (O'Neill 2014, XSH-RR 64/32). It uses integers only, so every platform draws the same numbers.
class Pcg32 {
public:
    explicit Pcg32(std::uint64_t seed, std::uint64_t stream = 54) : state_(seed + (stream << 1 | 1)), increment_(stream << 1 | 1) { next(); }

    std::uint32_t next()
    {
        std::uint64_t const old = state_;
        state_ = old * 6364136223846793005u + increment_;
        auto const word = static_cast<std::uint32_t>(((old >> 18) ^ old) >> 27);
        auto const turn = static_cast<std::uint32_t>(old >> 59);
        return (word >> turn) | (word << ((32 - turn) & 31));
    }

    /// A multiple of 2^-32 in [0, 1).
    double uniform() { return next() * 0x1p-32; }
    double between(double low, double high) { return low + (high - low) * uniform(); }

private:
    std::uint64_t state_, increment_;
};

/// Smooth noise in [0, 1) over the plane. Independent values are 1 apart: a hashed lattice with a cubic blend.
inline double value_noise(double x, double y, std::uint32_t seed)
{
    auto const lattice = [&](double cell_x, double cell_y) {
        std::uint32_t h = seed + 0x9e3779b9u * static_cast<std::uint32_t>(static_cast<std::int32_t>(cell_x)) +
                          0x85ebca6bu * static_cast<std::uint32_t>(static_cast<std::int32_t>(cell_y));
        h = (h ^ (h >> 16)) * 0x7feb352du;
        h = (h ^ (h >> 15)) * 0x846ca68bu;
        return (h ^ (h >> 16)) * 0x1p-32;
    };
    double const cell_x = std::floor(x), cell_y = std::floor(y);
    double u = x - cell_x, v = y - cell_y;
    u *= u * (3.0 - 2.0 * u), v *= v * (3.0 - 2.0 * v);
    double const top = lattice(cell_x, cell_y) * (1.0 - u) + lattice(cell_x + 1.0, cell_y) * u;
    double const bottom = lattice(cell_x, cell_y + 1.0) * (1.0 - u) + lattice(cell_x + 1.0, cell_y + 1.0) * u;
    return top * (1.0 - v) + bottom * v;
}

/// A place on a surface: unit tangents u and v, the spacing of the samples along them, and the colour that is painted there.
struct Touch {
    glm::dvec3 place;
    glm::dvec3 along_u, along_v;
    double spacing_u, spacing_v;
    glm::dvec3 colour; ///< already lit
};

/// Lays Gaussians onto surfaces, in the order of the calls. Ids count from 1.
class Brush {
public:
    explicit Brush(Map& map, std::uint64_t seed) : random(seed), map_(map) {}

    /// One Gaussian with standard deviations `sigma` along the columns of `axes`, which are
    /// orthonormal.
    void dab(glm::dvec3 place, glm::dmat3 const& axes, glm::dvec3 sigma, glm::dvec3 colour, double opacity)
    {
        splat::Gaussian g{};
        for (int i = 0; i < 3; ++i) {
            g.mean_world[i] = static_cast<float>(place[i]);
            g.colour[i] = static_cast<float>(std::fmax(colour[i], 0.0));
            g.log_scale[i] = static_cast<float>(std::log(sigma[i]));
        }
        g.opacity = static_cast<float>(opacity);
        store_rotation(axes, g.rotation);
        g.id = splat::GaussianId{static_cast<std::uint32_t>(map_.gaussians.size() + 1)};
        map_.gaussians.push_back(g);
    }

    /// Lays a disc into the surface. At 0.68 of the spacing and an opacity of 0.85, the layer below shows through by 3 to 4 % halfway
    /// between samples of a square lattice, and an edge is sharp to two thirds of a spacing.
    void touch(Touch const& t, double fill = 0.68)
    {
        double const thin = 0.06 * std::fmin(t.spacing_u, t.spacing_v);
        dab(t.place, {t.along_u, t.along_v, glm::cross(t.along_u, t.along_v)}, {fill * t.spacing_u, fill * t.spacing_v, thin}, t.colour, opacity());
    }

    /// A thread from a to b: a needle of radius `radius` that overlaps the next one of a chain.
    void needle(glm::dvec3 a, glm::dvec3 b, double radius, glm::dvec3 colour)
    {
        glm::dvec3 const along = glm::normalize(b - a);
        glm::dvec3 const helper = std::fabs(along.y) < 0.9 ? glm::dvec3{0.0, 1.0, 0.0} : glm::dvec3{1.0, 0.0, 0.0};
        glm::dvec3 const side = glm::normalize(glm::cross(helper, along));
        dab(0.5 * (a + b), {along, side, glm::cross(along, side)}, {0.4 * glm::length(b - a), radius, radius}, colour, opacity());
    }

    /// 3 % are exactly opaque, as in maps that SLAM makes. The others are 0.85 to 0.98.
    double opacity() { return random.uniform() < 0.03 ? 1.0 : random.between(0.85, 0.98); }

    Pcg32 random;

private:
    /// Shepperd's method: a root gives the largest of w, x, y, z, so no division is by a small number.
    static void store_rotation(glm::dmat3 const& m, float (&out)[4])
    {
        double const trace = m[0][0] + m[1][1] + m[2][2];
        double q[4];
        if (trace >= m[0][0] && trace >= m[1][1] && trace >= m[2][2]) {
            q[0] = 1.0 + trace;
            q[1] = m[1][2] - m[2][1];
            q[2] = m[2][0] - m[0][2];
            q[3] = m[0][1] - m[1][0];
        } else {
            int i = m[1][1] > m[0][0] ? 1 : 0;
            if (m[2][2] > m[i][i]) i = 2;
            int const j = (i + 1) % 3, k = (j + 1) % 3;
            q[0] = m[j][k] - m[k][j];
            q[1 + i] = 1.0 + 2.0 * m[i][i] - trace;
            q[1 + j] = m[i][j] + m[j][i];
            q[1 + k] = m[i][k] + m[k][i];
        }
        double const length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        for (int i = 0; i < 4; ++i) out[i] = static_cast<float>(q[i] / length);
    }

    Map& map_;
};

}}} // namespace tilemesh::scene::detail
