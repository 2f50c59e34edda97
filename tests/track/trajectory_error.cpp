#include "support.hpp"
#include <glm/mat4x4.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <tilemesh/track/depth_misfit.hpp>
#include <tilemesh/track/pose_update.hpp>
#include <tilemesh/track/trajectory_error.hpp>

using namespace track_test;
using namespace tilemesh;

namespace {

constexpr double pi = 3.14159265358979323846;

std::vector<scene::Pose> random_walk(Random& random, int count, double flat = 1.0)
{
    std::vector<scene::Pose> out{{track::rotation_by(random.vector()), 5.0 * random.vector()}};
    out[0].position.z *= flat;
    for (int i = 1; i < count; ++i) {
        auto next = track::moved(out.back(), {0.3 * random.vector(), 0.1 * random.vector()});
        next.position.z = flat * next.position.z;
        out.push_back(next);
    }
    return out;
}

std::vector<scene::Pose> noisy(std::vector<scene::Pose> poses, double size, Random& random)
{
    for (auto& pose : poses) pose = track::moved(pose, {size * random.vector(), size * random.vector()});
    return poses;
}

/// The whole world turned and moved, the cameras with it.
std::vector<scene::Pose> carried(std::vector<scene::Pose> poses, glm::dmat3 const& rotation, glm::dvec3 translation)
{
    for (auto& pose : poses) pose = {pose.rotation * glm::transpose(rotation), rotation * pose.position + translation};
    return poses;
}

/// Camera to world as a matrix of 4 x 4, for an implementation that shares no code: evo multiplies such matrices.
glm::dmat4 matrix(scene::Pose const& pose)
{
    glm::dmat4 m{glm::transpose(pose.rotation)};
    m[3] = {pose.position, 1.0};
    return m;
}
double translation(glm::dmat4 const& m)
{
    return glm::length(glm::dvec3{m[3]});
}
double degrees(glm::dmat4 const& m)
{
    return std::acos(std::fmin(1.0, std::fmax(-1.0, (m[0][0] + m[1][1] + m[2][2] - 1.0) / 2.0))) * 180.0 / pi;
}

/// The best rotation by the polar decomposition of the covariance, for points that span the space (Newton's iteration, Higham 1986).
glm::dmat3 polar_alignment(std::vector<scene::Pose> const& from, std::vector<scene::Pose> const& to, glm::dvec3& shift)
{
    glm::dvec3 a{0.0}, b{0.0};
    for (std::size_t i = 0; i < from.size(); ++i) a += from[i].position / static_cast<double>(from.size()), b += to[i].position / static_cast<double>(from.size());
    glm::dmat3 m{0.0};
    for (std::size_t i = 0; i < from.size(); ++i) m += glm::outerProduct(to[i].position - b, from[i].position - a);
    for (int i = 0; i < 60; ++i) m = 0.5 * (m + glm::transpose(glm::inverse(m)));
    shift = b - m * a;
    return m;
}

double rmse(std::vector<double> const& values)
{
    double sum = 0.0;
    for (double const v : values) sum += v * v;
    return std::sqrt(sum / static_cast<double>(values.size()));
}

} // namespace

TEST_CASE("errors of trajectories with known answers")
{
    Random random;
    auto const truth = random_walk(random, 30);
    auto const none = track::trajectory_errors(truth, truth);
    CHECK(none.poses == 30);
    CHECK(none.ate.rmse == 0.0);
    CHECK(none.ate_aligned.largest < 1e-13);
    CHECK(none.rotation_deg.largest < 1e-13);
    CHECK(none.rpe_deg.largest < 1e-13);

    // All poses moved by (3, 4, 0): 5 units off, 0 when aligned, no relative error.
    auto const shifted = track::trajectory_errors(carried(truth, glm::dmat3{1.0}, {3, 4, 0}), truth);
    CHECK(shifted.ate.rmse == doctest::Approx(5.0));
    CHECK(shifted.ate.mean == doctest::Approx(5.0));
    CHECK(shifted.ate_aligned.rmse < 1e-13);
    CHECK(shifted.rpe.rmse < 1e-13);

    // The world turned by 40 degrees: the alignment finds it, and cameras see the same steps.
    auto const turn = track::rotation_by(40.0 * pi / 180.0 * random.direction());
    auto const turned = track::trajectory_errors(carried(truth, turn, {1, 2, 3}), truth);
    CHECK(turned.ate.rmse > 0.5);
    CHECK(turned.ate_aligned.rmse < 1e-12);
    CHECK(largest_difference(turned.alignment.rotation, glm::transpose(turn)) < 1e-13);
    CHECK(turned.rotation_deg.rmse == doctest::Approx(40.0));
    CHECK(turned.rpe.rmse < 1e-13);
    CHECK(turned.rpe_deg.rmse < 1e-12);

    // One pose of four is 2 units off: 2 / sqrt(4); it is in two of the three steps.
    std::vector<scene::Pose> const line{{glm::dmat3{1.0}, {0, 0, 0}}, {glm::dmat3{1.0}, {1, 0, 0}}, {glm::dmat3{1.0}, {2, 0, 0}}, {glm::dmat3{1.0}, {3, 0, 0}}};
    auto bent = line;
    bent[1].position.y = 2.0;
    auto const one = track::trajectory_errors(bent, line);
    CHECK(one.ate.rmse == doctest::Approx(1.0));
    CHECK(one.ate.mean == doctest::Approx(0.5));
    CHECK(one.ate.largest == 2.0);
    CHECK(one.rpe.rmse == doctest::Approx(std::sqrt(8.0 / 3.0)));
    CHECK(one.ate_aligned.rmse < one.ate.rmse);

    // A mirrored path is not aligned by a reflection.
    auto mirrored = truth;
    for (auto& pose : mirrored) pose.position.x = -pose.position.x;
    auto const m = track::trajectory_errors(mirrored, truth);
    CHECK(m.ate_aligned.rmse > 0.01);
    CHECK(glm::determinant(m.alignment.rotation) == doctest::Approx(1.0));
}

TEST_CASE("errors of random trajectories are those of products of 4 x 4 matrices and of the polar decomposition")
{
    Random random;
    for (int trial = 0; trial < 30; ++trial) {
        auto const truth = random_walk(random, 40);
        auto const estimate = carried(noisy(truth, 0.05, random), track::rotation_by(random.vector()), random.vector());
        auto const e = track::trajectory_errors(estimate, truth);
        glm::dvec3 shift;
        auto const rotation = polar_alignment(estimate, truth, shift);
        std::vector<double> ate, aligned, turned, rpe, rpe_deg;
        for (std::size_t i = 0; i < truth.size(); ++i) {
            auto const p = matrix(estimate[i]), q = matrix(truth[i]);
            ate.push_back(glm::length(glm::dvec3{p[3] - q[3]}));
            aligned.push_back(glm::length(rotation * estimate[i].position + shift - truth[i].position));
            turned.push_back(degrees(glm::inverse(q) * p));
            if (i == 0) continue;
            // evo: (Q_i^-1 Q_j)^-1 (P_i^-1 P_j)
            auto const step = glm::inverse(glm::inverse(matrix(truth[i - 1])) * q) * (glm::inverse(matrix(estimate[i - 1])) * p);
            rpe.push_back(translation(step));
            rpe_deg.push_back(degrees(step));
        }
        CHECK(e.ate.rmse == doctest::Approx(rmse(ate)).epsilon(1e-12));
        CHECK(e.ate_aligned.rmse == doctest::Approx(rmse(aligned)).epsilon(1e-9));
        CHECK(e.rotation_deg.rmse == doctest::Approx(rmse(turned)).epsilon(1e-9));
        CHECK(e.rpe.rmse == doctest::Approx(rmse(rpe)).epsilon(1e-9));
        CHECK(e.rpe_deg.rmse == doctest::Approx(rmse(rpe_deg)).epsilon(1e-7));
        CHECK(largest_difference(e.alignment.rotation, rotation) < 1e-9);
    }
}

TEST_CASE("no small motion improves an alignment, also of a flat path, a line, a point and two poses")
{
    Random random;
    for (double const flat : {1.0, 0.0})
        for (int const count : {1, 2, 20}) {
            auto const truth = random_walk(random, count, flat);
            auto const estimate = noisy(truth, 0.1, random);
            auto const e = track::trajectory_errors(estimate, truth);
            CHECK(std::isfinite(e.ate_aligned.rmse));
            CHECK(e.ate_aligned.rmse <= e.ate.rmse + 1e-12);
            if (count == 1) CHECK(e.rpe.rmse == 0.0);
            for (int trial = 0; trial < 50; ++trial) {
                auto const turn = track::rotation_by(0.01 * random.vector());
                auto const shift = 0.01 * random.vector();
                std::vector<double> worse;
                for (std::size_t i = 0; i < truth.size(); ++i)
                    worse.push_back(glm::length(turn * (e.alignment.rotation * estimate[i].position + e.alignment.translation) + shift - truth[i].position));
                CHECK(rmse(worse) >= e.ate_aligned.rmse * (1.0 - 1e-12));
            }
        }
}

TEST_CASE("depths in another unit than the map's are said; those near the map's, and unknown ones, are not")
{
    auto const of = [](float depth, std::uint32_t unknown) {
        report::Plane plane(8, 4);
        for (std::size_t i = 0; i < plane.values.size(); ++i)
            plane.values[i] = i < unknown ? 0.0f : depth + 0.01f * depth * static_cast<float>(i % 3);
        return plane;
    };
    CHECK(track::depth_misfit(of(1.0f, 5), 1.0, 2.0).empty());
    CHECK(track::depth_misfit(of(1.8f, 5), 1.0, 2.0).empty());
    CHECK(track::depth_misfit(of(0.6f, 5), 1.0, 2.0).empty());
    CHECK(track::depth_misfit(of(5.0f, 5), 1.0, 2.0) == "5.05 at the median, 5.05 times the map's 1");
    CHECK(track::depth_misfit(of(0.2f, 5), 1.0, 2.0) == "0.202 at the median, 0.202 times the map's 1");
    CHECK(track::depth_misfit(of(5.0f, 5), 1.0, 10.0).empty());
    CHECK(track::depth_misfit(of(5.0f, 32), 1.0, 2.0).empty());
    CHECK(track::depth_misfit(report::Plane{}, 1.0, 2.0).empty());
    CHECK(track::depth_misfit(of(5.0f, 0), 0.0, 2.0).empty());
}

TEST_CASE("trajectories of different lengths, and of none, are refused")
{
    Random random;
    auto const truth = random_walk(random, 3);
    CHECK_THROWS_AS(track::trajectory_errors(std::span(truth).first(2), truth), Error);
    CHECK_THROWS_AS(track::trajectory_errors({}, {}), Error);
}

TEST_CASE("a trajectory that is written as TUM is read as the same poses")
{
    Random random;
    std::vector<scene::StampedPose> poses;
    auto const walk = random_walk(random, 50);
    for (std::size_t i = 0; i < walk.size(); ++i) poses.push_back({1305031098.6659 + 0.0321 * static_cast<double>(i), walk[i]});
    auto const text = scene::tum_text(poses);
    std::istringstream stream(text);
    auto const back = scene::read_tum(stream, "text");
    REQUIRE(back.size() == poses.size());
    CHECK(back.far_from_unit == 0);
    for (std::size_t i = 0; i < poses.size(); ++i) {
        CHECK(back[i].seconds == poses[i].seconds);
        CHECK(back[i].pose.position == poses[i].pose.position);
        CHECK(largest_difference(back[i].pose.rotation, poses[i].pose.rotation) < 2e-15);
    }
    CHECK_THROWS_AS(scene::tum_text({}), Error);
    poses[3].pose.position.x = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_AS(scene::tum_text(poses), Error);
}
