#include "support.hpp"
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/track/pose_update.hpp>

using namespace track_test;
using namespace tilemesh;

namespace {

using Matrix4 = std::array<std::array<long double, 4>, 4>;

Matrix4 product(Matrix4 const& a, Matrix4 const& b)
{
    Matrix4 out{};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j)
            for (std::size_t k = 0; k < 4; ++k) out[i][j] += a[i][k] * b[k][j];
    return out;
}

/// exp of the 4x4 matrix of a twist, by 50 terms of its power series.
Matrix4 series(track::Twist const& t)
{
    Matrix4 const x{{{0, -t.phi.z, t.phi.y, t.rho.x}, {t.phi.z, 0, -t.phi.x, t.rho.y}, {-t.phi.y, t.phi.x, 0, t.rho.z}, {0, 0, 0, 0}}};
    Matrix4 sum{}, term{};
    for (std::size_t i = 0; i < 4; ++i) sum[i][i] = term[i][i] = 1;
    for (int k = 1; k < 50; ++k) {
        term = product(term, x);
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = 0; j < 4; ++j) sum[i][j] += term[i][j] /= k;
    }
    return sum;
}

double off_orthonormal(glm::dmat3 const& r)
{
    return largest_difference(glm::transpose(r) * r, glm::dmat3{1.0});
}

} // namespace

TEST_CASE("the rotation and the translation of a twist are those of a power series of 50 terms")
{
    Random random;
    double most = 0.0, most_relative = 0.0;
    for (double const angle : {0.0, 1e-300, 1e-12, 1e-8, 1e-4, 1e-2, 0.3, 0.9999999, 1.0, 1.0000001, 2.0, 3.1415926, 4.5, 6.2})
        for (int i = 0; i < 20; ++i) {
            track::Twist const twist{random.vector(), angle * random.direction()};
            auto const expected = series(twist);
            auto const rotation = track::rotation_by(twist.phi);
            auto const translation = track::mean_rotation_by(twist.phi) * twist.rho;
            for (int row = 0; row < 3; ++row) {
                auto const r = static_cast<std::size_t>(row);
                for (int column = 0; column < 3; ++column) {
                    auto const wanted = static_cast<double>(expected[r][static_cast<std::size_t>(column)]);
                    most = std::fmax(most, std::fabs(rotation[column][row] - wanted));
                }
                most = std::fmax(most, std::fabs(translation[row] - static_cast<double>(expected[r][3])));
                // Small rotations keep their relative digits: exp(phi) - 1 is about phi.
                glm::dmat3 const small = track::rotation_by(twist.phi) - glm::dmat3{1.0};
                if (angle > 0.0 && angle < 1e-3) most_relative = std::fmax(most_relative, std::fabs(small[1][2] - twist.phi.x) / angle - angle);
            }
        }
    CHECK(most < 2e-15);
    CHECK(most_relative < 1e-15);
}

TEST_CASE("the three factors meet where the series ends")
{
    auto const below = track::rotation_factors(std::nextafter(1.0, 0.0)), above = track::rotation_factors(1.0);
    CHECK(below.first == doctest::Approx(above.first).epsilon(1e-15));
    CHECK(below.second == doctest::Approx(above.second).epsilon(1e-15));
    CHECK(below.third == doctest::Approx(above.third).epsilon(3e-15));
    CHECK(track::rotation_factors(0.0).third == 1.0 / 6.0);
}

TEST_CASE("a rotation vector comes back, also near half a turn; so does a quaternion")
{
    Random random;
    double const pi = 3.14159265358979323846;
    for (double const angle : {1e-200, 1e-9, 1e-3, 1.0, 3.0, pi - 1e-6, pi - 1e-10})
        for (int i = 0; i < 50; ++i) {
            auto const phi = angle * random.direction();
            auto const back = track::rotation_vector(track::rotation_by(phi));
            CHECK(glm::length(back - phi) <= 4e-15 * std::fmax(1.0, angle) * (angle < 1e-3 ? angle : 1.0));
        }
    CHECK(glm::length(track::rotation_vector(glm::dmat3{1.0})) == 0.0);
    for (int i = 0; i < 200; ++i) {
        auto const rotation = track::rotation_by(pi * random.vector());
        auto const q = scene::quaternion_of(rotation);
        CHECK(q[0] >= 0.0);
        CHECK(largest_difference(scene::rotation_matrix(q[0], q[1], q[2], q[3]), rotation) < 2e-15);
    }
    for (int axis = 0; axis < 3; ++axis) { // exact half turns: w is 0
        glm::dmat3 half{-1.0};
        half[axis][axis] = 1.0;
        CHECK(scene::quaternion_of(half)[static_cast<std::size_t>(axis + 1)] == 1.0);
    }
}

TEST_CASE("a pose moves as its points do, and a twist between two poses leads from one to the other")
{
    Random random;
    for (int i = 0; i < 100; ++i) {
        scene::Pose const pose{track::rotation_by(3.0 * random.vector()), 10.0 * random.vector()};
        track::Twist const twist{random.vector(), random.vector()};
        auto const next = track::moved(pose, twist);
        // A point of view space goes to exp(phi) p + V rho.
        glm::dvec3 const world = 5.0 * random.vector(), p = pose.rotation * (world - pose.position);
        auto const expected = series(twist);
        glm::dvec3 wanted{0.0};
        for (int row = 0; row < 3; ++row) {
            auto const& r = expected[static_cast<std::size_t>(row)];
            wanted[row] = static_cast<double>(r[0] * p.x + r[1] * p.y + r[2] * p.z + r[3]);
        }
        CHECK(glm::length(next.rotation * (world - next.position) - wanted) < 1e-13);
        auto const back = track::twist_between(pose, next);
        CHECK(glm::length(back.rho - twist.rho) < 1e-13);
        CHECK(glm::length(back.phi - twist.phi) < 1e-14);
    }
}

TEST_CASE("a camera at constant velocity is where it is predicted, for any number of steps")
{
    track::Twist const step{{0.1, -0.02, 0.3}, {0.05, 0.1, -0.02}};
    scene::Pose const first{track::rotation_by({0.3, 1.0, -2.0}), {4.0, 5.0, 6.0}};
    auto const second = track::moved(first, step), third = track::moved(second, step);
    auto const guess = track::predicted(first, second);
    CHECK(largest_difference(guess.rotation, third.rotation) < 1e-15);
    CHECK(glm::length(guess.position - third.position) < 1e-14);
    auto const fourth = track::moved(third, step), two_ahead = track::predicted(first, second, 2.0);
    CHECK(glm::length(two_ahead.position - fourth.position) < 1e-14);
    auto const none = track::predicted(first, second, 0.0);
    CHECK(glm::length(none.position - second.position) == 0.0);
}

TEST_CASE("a camera is predicted with the lens of the last one; a camera that stood still keeps its bits")
{
    scene::Intrinsics const lens{500, 501, 320, 240, 0.25f, 640, 480};
    track::Twist const step{{0.1, -0.02, 0.3}, {0.05, 0.1, -0.02}};
    scene::Pose const first{track::rotation_by({0.3, 1.0, -2.0}), {4.0, 5.0, 6.0}};
    auto const second = track::moved(first, step), third = track::moved(second, step);
    auto other = lens;
    other.fx = 100, other.width = 320;
    auto const last = scene::make_camera(second, lens);
    auto const guess = track::predicted(scene::make_camera(first, other), last);
    auto const pose = scene::pose_of(guess);
    CHECK(largest_difference(pose.rotation, third.rotation) < 1e-6);
    CHECK(glm::length(pose.position - third.position) < 1e-5);
    CHECK(guess.fx == last.fx);
    CHECK(guess.near_depth == last.near_depth);
    CHECK(guess.width == 640);
    CHECK(guess.height == 480);

    auto still = last;
    still.rotation[0][0] *= 1.001f; // no rotation: `moved` would change it
    CHECK(splat::same_view(track::predicted(still, still), still));
}

TEST_CASE("a million updates keep a rotation orthonormal, and a matrix that is off by 5e-3 becomes a rotation")
{
    Random random;
    scene::Pose pose;
    double most = 0.0;
    for (int i = 0; i < 1'000'000; ++i) {
        pose = track::moved(pose, {1e-3 * random.vector(), 1e-2 * random.vector()});
        if (i % 1000 == 0) most = std::fmax(most, off_orthonormal(pose.rotation));
    }
    CHECK(std::fmax(most, off_orthonormal(pose.rotation)) < 1e-15);
    CHECK(glm::determinant(pose.rotation) > 0.0);
    CHECK(off_orthonormal(track::orthonormal(pose.rotation + glm::dmat3{1e-3, -2e-3, 0, 1e-3, 0, 0, 2e-3, 0, 1e-3})) < 1e-9);
}

TEST_CASE("far from the origin a turn does not move the camera, and a step keeps its digits")
{
    scene::Pose pose{track::rotation_by({0.5, -1.0, 0.25}), {1e9, -2e9, 3e9}};
    auto const position = pose.position;
    for (int i = 0; i < 1000; ++i) pose = track::moved(pose, {{}, {1e-3, 2e-3, -1e-3}});
    CHECK(pose.position == position); // every bit
    auto const before = pose.position;
    pose = track::moved(pose, {{0.5, 0.25, -1.0}, {}});
    CHECK(glm::length(pose.position - before) == doctest::Approx(std::sqrt(0.25 + 0.0625 + 1.0)).epsilon(1e-6)); // a step of double at 3e9: 5e-7
}
