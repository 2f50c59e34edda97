#pragma once
#include "../standard.hpp"
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <tilemesh/scene/pose.hpp>

// Shared by the tests of tracking: random numbers, distances between poses.
namespace track_test {

/// Random numbers that are the same everywhere (splitmix64).
struct Random {
    std::uint64_t state = 1;
    std::uint64_t bits()
    {
        std::uint64_t z = state += 0x9e3779b97f4a7c15u;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return z ^ (z >> 31);
    }
    /// From -1 to 1.
    double number() { return static_cast<double>(bits() >> 11) * 0x1p-52 - 1.0; }
    glm::dvec3 vector() { return {number(), number(), number()}; }
    glm::dvec3 direction()
    {
        for (;;)
            if (glm::dvec3 const v = vector(); glm::length(v) > 0.1 && glm::length(v) <= 1.0) return glm::normalize(v);
    }
    /// About a standard normal: the sum of twelve uniform numbers.
    double normal()
    {
        double sum = 0.0;
        for (int i = 0; i < 12; ++i) sum += 0.5 * number();
        return sum;
    }
};

inline double largest_difference(glm::dmat3 const& a, glm::dmat3 const& b)
{
    double most = 0.0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) most = std::fmax(most, std::fabs(a[i][j] - b[i][j]));
    return most;
}

/// The angle between two rotations, in degrees; exact near 0, unlike the arc cosine of the trace.
inline double degrees_between(glm::dmat3 const& a, glm::dmat3 const& b)
{
    double squares = 0.0; // |A - B|^2 = 8 sin^2(angle / 2)
    for (int i = 0; i < 3; ++i) squares += glm::dot(a[i] - b[i], a[i] - b[i]);
    return 2.0 * std::asin(std::min(1.0, std::sqrt(squares / 8.0))) * 180.0 / 3.14159265358979323846;
}

} // namespace track_test
