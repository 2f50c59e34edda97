#include "points.hpp"
#include <tilemesh/track/pose_accuracy.hpp>
#include <tilemesh/track/pose_solver.hpp>
#include <tilemesh/track/small_system.hpp>

using namespace track_test;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Random rows: H is positive definite for more than `unknowns` of them.
track::NormalEquations random_sums(Random& random, std::uint32_t unknowns, int rows)
{
    track::NormalEquations e;
    e.unknowns = unknowns;
    for (int i = 0; i < rows; ++i) {
        double j[8]{};
        for (std::uint32_t k = 0; k < unknowns; ++k) j[k] = random.number() * std::pow(10.0, 2.0 * k - 7.0); // columns of unlike size
        add_row(e, j, random.number(), 1e9);
        ++e.pixels;
    }
    return e;
}

/// Forward mode at full resolution, or the hybrid method from a coarser level on.
template <class Evaluate>
track::Solution solve(Evaluate&& evaluate, scene::Pose const& start, std::uint32_t coarsest = 1)
{
    auto const stages = track::stages_of(coarsest == 1 ? track::Method::forward : track::Method::hybrid, coarsest);
    return track::solve_pose(evaluate, start, lens(), scale_of_points, stages);
}

bool is_finite(scene::Pose const& pose)
{
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) {
        sum += pose.position[i];
        for (int j = 0; j < 3; ++j) sum += pose.rotation[i][j];
    }
    return std::isfinite(sum);
}

} // namespace

TEST_CASE("a damped step solves its equations, for 6 and 8 unknowns of unlike size")
{
    Random random;
    for (std::uint32_t const n : {6u, 8u})
        for (double const lambda : {0.0, 1e-4, 1.0, 1e6})
            for (int i = 0; i < 50; ++i) {
                auto const e = random_sums(random, n, 40);
                auto const x = track::solve_damped(e, lambda);
                REQUIRE(x);
                for (std::uint32_t a = 0; a < n; ++a) {
                    double left = lambda * e.h[a][a] * (*x)[a] + e.g[a], size = std::fabs(e.g[a]);
                    for (std::uint32_t b = 0; b < n; ++b) {
                        left += e.h[a][b] * (*x)[b];
                        size += std::fabs(e.h[a][b] * (*x)[b]);
                    }
                    CHECK(std::fabs(left) <= 1e-12 * size);
                }
                for (std::uint32_t a = n; a < 8; ++a) CHECK((*x)[a] == 0.0);
            }
}

TEST_CASE("sums that are singular, empty or not finite are refused, and nothing of them is NaN")
{
    Random random;
    CHECK(!track::solve_damped({}, 1e-4)); // all zero
    auto const good = random_sums(random, 6, 40);
    CHECK(track::is_usable(good));
    auto const refused = [&](auto change) {
        auto e = good;
        change(e);
        CHECK(!track::is_usable(e));
        CHECK(!track::solve_damped(e, 1e-4));
    };
    for (double const bad : {not_a_number, infinity, -infinity}) {
        refused([&](auto& e) { e.h[3][3] = bad; });
        refused([&](auto& e) { e.h[2][4] = bad; });
        refused([&](auto& e) { e.g[5] = bad; });
        refused([&](auto& e) { e.cost = bad; });
    }
    refused([](auto& e) { e.h[1][1] = -1.0; });
    refused([](auto& e) { e.cost = -1.0; });
    refused([](auto& e) { e.pixels = 0; });
    refused([](auto& e) { e.unknowns = 7; });

    // One row: rank 1. Undamped it is singular, damped it has the shortest step along the row.
    auto const line = random_sums(random, 6, 1);
    CHECK(!track::solve_damped(line, 0.0));
    CHECK(track::solve_damped(line, 1e-4));
    // Not positive definite: correlations of 1.5 and more.
    auto wild = good;
    wild.h[0][1] = wild.h[1][0] = 1.5 * std::sqrt(good.h[0][0] * good.h[1][1]);
    CHECK(track::is_usable(wild));
    CHECK(!track::solve_damped(wild, 1e-4));
    // An unknown on which nothing depends stays where it is, and the others move as without it.
    auto free = good;
    free.unknowns = 8;
    auto const with = track::solve_damped(free, 1e-4), without = track::solve_damped(good, 1e-4);
    REQUIRE(with);
    CHECK(*with == *without);
    // A step that leaves the range of double.
    auto huge = good;
    for (double& g : huge.g) g = 1e308;
    for (auto& row : huge.h)
        for (double& h : row) h *= 1e-200;
    CHECK(!track::solve_damped(huge, 1e-4));
}

TEST_CASE("eigenvalues and eigenvectors of a symmetric matrix, also of rank 1 and of multiples")
{
    Random random;
    for (int trial = 0; trial < 100; ++trial) {
        auto const e = random_sums(random, 6, trial % 4 == 0 ? 1 : 20);
        track::Matrix6 m{};
        for (std::size_t i = 0; i < 6; ++i)
            for (std::size_t j = 0; j < 6; ++j) m[i][j] = trial % 5 == 0 ? (i == j ? 3.0 : 0.0) : e.h[i][j] * std::pow(10.0, 14.0 - 2.0 * static_cast<double>(i + j));
        auto const eigen = track::eigen_of(m);
        double const size = std::fmax(eigen.values[5], -eigen.values[0]);
        for (std::size_t k = 0; k < 6; ++k) {
            if (k > 0) CHECK(eigen.values[k - 1] <= eigen.values[k]);
            for (std::size_t i = 0; i < 6; ++i) {
                double image = 0.0, dot = 0.0;
                for (std::size_t j = 0; j < 6; ++j) {
                    image += m[i][j] * eigen.vectors[k][j];
                    dot += eigen.vectors[k][j] * eigen.vectors[i][j];
                }
                CHECK(std::fabs(image - eigen.values[k] * eigen.vectors[k][i]) < 1e-14 * size);
                CHECK(std::fabs(dot - (i == k ? 1.0 : 0.0)) < 1e-14);
            }
        }
    }
}

TEST_CASE("a pyramid ends at full resolution, and hybrid ends with forward mode")
{
    auto const hybrid = track::stages_of(track::Method::hybrid, 8);
    REQUIRE(hybrid.size() == 4);
    for (std::size_t i = 0; i < 4; ++i) {
        CHECK(hybrid[i].cell == 8u >> i);
        CHECK(hybrid[i].jacobian == (i < 3 ? track::Jacobian::esm : track::Jacobian::forward));
    }
    CHECK(hybrid.back().stop_px == 0.01);
    for (auto const& stage : track::stages_of(track::Method::forward, 4)) CHECK(stage.jacobian == track::Jacobian::forward);
    for (auto const& stage : track::stages_of(track::Method::gradient, 4)) CHECK(stage.jacobian == track::Jacobian::gradient);
    for (auto const& stage : track::stages_of(track::Method::esm, 1)) CHECK(stage.jacobian == track::Jacobian::esm);
    CHECK(track::stages_of(track::Method::esm, 1).size() == 1);
}

TEST_CASE("the solver finds a camera that saw a cloud of points, from 20 degrees and a fifth of the depth")
{
    Random random;
    auto const camera = true_camera();
    auto const truth = scene::pose_of(camera);
    for (int trial = 0; trial < 20; ++trial) {
        auto points = cloud(camera, 200, random);
        auto const start = disturbed(truth, trial + 1.0, 0.01 * trial, random);
        auto const s = solve(points, start);
        CHECK(s.converged());
        CHECK(degrees_between(s.pose.rotation, truth.rotation) < 1e-5); // floats of a camera: 3e-6 degrees
        CHECK(glm::length(s.pose.position - truth.position) < 1e-6);
        CHECK(s.evaluations == points.calls);
        CHECK(s.evaluations <= 6);
        CHECK(s.steps == s.evaluations); // the last step is not evaluated, the start is
    }
}

TEST_CASE("every level is asked for, coarse first, and the last step is in pixels")
{
    Random random;
    auto points = cloud(true_camera(), 100, random);
    std::vector<std::uint32_t> cells;
    auto const ask = altered(points, [&](auto&, auto const&, track::Level const& level) {
        if (cells.empty() || cells.back() != level.cell) cells.push_back(level.cell);
    });
    auto const s = solve(ask, disturbed(scene::pose_of(true_camera()), 3.0, 0.02, random), 8);
    CHECK(cells == std::vector<std::uint32_t>{8, 4, 2, 1});
    CHECK(s.ending == track::Ending::small_step);
    CHECK(s.last_step_px < 0.01);
}

TEST_CASE("the covariance is the scatter of the estimates, and the marginal one with exposure")
{
    Random random;
    auto const camera = true_camera();
    auto const truth = scene::pose_of(camera);
    track::Matrix6 scatter{}, told{};
    int const trials = 600;
    auto const clean = cloud(camera, 60, random);
    for (int trial = 0; trial < trials; ++trial) {
        auto noisy = clean;
        for (auto& p : noisy.points) p.u += 0.2 * random.normal(), p.v += 0.2 * random.normal();
        auto const s = solve(noisy, truth);
        REQUIRE(s.converged());
        auto const error = track::twist_between(truth, s.pose);
        std::array<double, 6> const x{error.rho.x / scale_of_points, error.rho.y / scale_of_points, error.rho.z / scale_of_points, error.phi.x, error.phi.y, error.phi.z};
        auto const accuracy = track::accuracy_of(s.at, 500.0, 2.0);
        CHECK(!accuracy.is_weak());
        for (std::size_t i = 0; i < 6; ++i)
            for (std::size_t j = 0; j < 6; ++j) {
                scatter[i][j] += x[i] * x[j] / trials;
                told[i][j] += accuracy.covariance[i][j] / trials;
            }
    }
    // A variance of 600 samples is within 6 % one time in three; 20 % is over three deviations.
    for (std::size_t i = 0; i < 6; ++i)
        for (std::size_t j = 0; j < 6; ++j) CHECK(std::fabs(scatter[i][j] - told[i][j]) < 0.2 * std::sqrt(told[i][i] * told[j][j]));

    // Eight unknowns: the covariance is the 6 x 6 corner of the inverse of the whole.
    for (int trial = 0; trial < 20; ++trial) {
        auto e = random_sums(random, 8, 30);
        for (std::size_t i = 0; i < 8; ++i)
            for (std::size_t j = 0; j < 8; ++j) e.h[i][j] *= std::pow(10.0, 14.0 - 2.0 * static_cast<double>(i + j));
        auto const c = track::accuracy_of(e, 1.0, 1.0).covariance;
        double const variance = 2.0 * e.cost / (30 - 8);
        for (std::size_t column = 0; column < 6; ++column) {
            auto unit = e;
            for (std::size_t i = 0; i < 8; ++i) unit.g[i] = i == column ? -1.0 : 0.0;
            auto const inverse = track::solve_damped(unit, 0.0);
            REQUIRE(inverse);
            for (std::size_t i = 0; i < 6; ++i) CHECK(variance * (*inverse)[i] == doctest::Approx(c[i][column]).epsilon(1e-8));
        }
    }
}

TEST_CASE("geometry that leaves motions open is weak, and the motions are named")
{
    Random random;
    auto const camera = true_camera();
    auto const truth = scene::pose_of(camera);
    auto const name = [&](track::NormalEquations const& e) { return track::weak_motions(track::accuracy_of(e, 500.0, 2.0)); };

    // Points on one horizontal line straight ahead, at the depth S: a turn about that line moves no point.
    Points line;
    for (int i = -20; i <= 20; ++i) line.see(camera, truth.position + glm::transpose(truth.rotation) * glm::dvec3{0.1 * i, 0.0, scale_of_points});
    CHECK(name(line(camera, {})) == "vertically and in pitch");
    auto const s = solve(line, disturbed(truth, 0.5, 0.0, random));
    CHECK(is_finite(s.pose));
    CHECK(s.at.cost < 1e-8);

    // Depth of a plane that fills the view: it tells the distance and two angles.
    track::NormalEquations plane;
    for (int y = 0; y < 480; y += 16)
        for (int x = 0; x < 640; x += 16, ++plane.pixels) {
            glm::dvec3 const p{scale_of_points * (x - 320) / 500.0, scale_of_points * (y - 240) / 500.0, scale_of_points}, normal{0, 0, 1};
            auto const by_phi = glm::cross(p, normal) / scale_of_points;
            double const j[8] = {0, 0, 1, by_phi.x, by_phi.y, by_phi.z, 0, 0};
            add_row(plane, j, 1e-3 * random.normal(), 1e9);
        }
    CHECK(name(plane) == "sideways, vertically and in roll");

    // Two points: far too few.
    CHECK(name(cloud(camera, 2, random)(camera, {})) != "");
    // A cloud is not weak. With noise of 40 pixels it is: its worst motion is uncertain by pixels.
    CHECK(name(cloud(camera, 100, random)(camera, {})) == "");
    auto const rough = track::accuracy_of(cloud(camera, 20, random, 40.0)(camera, {}), 500.0, 2.0);
    CHECK(rough.is_weak());
    CHECK(rough.worst_px > 0.5);
    CHECK(rough.conditioning > 1e-6);
    // Nothing of a rank 1 is NaN.
    auto const one = track::accuracy_of(random_sums(random, 6, 1), 500.0, 1.0);
    for (auto const& row : one.covariance)
        for (double const value : row) CHECK(std::isfinite(value));
    CHECK(track::weak_motions(one) != "");
}

TEST_CASE("an evaluator that returns NaN, sometimes or always, moves no pose and ends the solver")
{
    Random random;
    auto const truth = scene::pose_of(true_camera());
    auto const start = disturbed(truth, 2.0, 0.02, random);
    auto points = cloud(true_camera(), 100, random);
    auto const s = solve(altered(points,
                                 [](auto& e) {
                                     e.cost = not_a_number;
                                     std::fill_n(&e.h[0][0], 64, not_a_number);
                                 }),
                         start, 8);
    CHECK(s.ending == track::Ending::unusable);
    CHECK(s.pose.position == start.position);
    CHECK(s.pose.rotation == start.rotation);
    CHECK(points.calls == 4); // once a level

    // NaN everywhere but at the start: all steps are refused.
    std::uint32_t seen = 0;
    auto const stuck = solve(altered(points,
                                     [&](auto& e) {
                                         if (seen++ > 0) e.cost = not_a_number;
                                     }),
                             start);
    CHECK(!stuck.converged());
    CHECK(stuck.pose.position == start.position);
    CHECK(stuck.evaluations <= 30);

    // Every third evaluation: those steps are refused, and the others lead to the end.
    seen = 0;
    auto const found = solve(altered(points,
                                     [&](auto& e) {
                                         if (seen++ % 3 == 2) e.g[0] = not_a_number;
                                     }),
                             start);
    CHECK(found.converged());
    CHECK(degrees_between(found.pose.rotation, truth.rotation) < 1e-4);
}

TEST_CASE("steps that never lower the cost do not count as convergence far from the end, and do near it")
{
    Random random;
    auto const truth = scene::pose_of(true_camera());
    auto points = cloud(true_camera(), 100, random);
    auto const uphill = altered(points, [](auto& e) {
        for (double& g : e.g) g = -g;
    });
    auto const start = disturbed(truth, 5.0, 0.05, random);
    auto const far = solve(uphill, start);
    CHECK(!far.converged());
    CHECK(far.pose.position == start.position);
    // Half a pixel from the end, the cost has steps of its own: four rejections end it.
    auto const close = solve(uphill, disturbed(truth, 0.03, 0.0, random));
    CHECK(close.ending == track::Ending::rejections);
    CHECK(close.evaluations == 5);
}

TEST_CASE("leaving the map wins nothing: a step that keeps half of the pixels or less is refused")
{
    Random random;
    auto const truth = scene::pose_of(true_camera());
    // The cost is that of 100 points; beyond a border on the way to the minimum, most of them no longer count, and those that do match.
    for (std::uint32_t const rest : {50u, 51u}) {
        auto points = cloud(true_camera(), 100, random);
        auto const start = disturbed(truth, 2.0, 0.02, random);
        auto const s = solve(altered(points,
                                     [&](auto& e, splat::Camera const& camera, track::Level const&) {
                                         bool const at_start =
                                             scene::pose_of(camera).position == scene::pose_of(scene::make_camera(start, lens())).position;
                                         e.pixels = at_start ? 100 : rest;
                                     }),
                             start);
        CHECK((s.steps > 0) == (rest == 51));
    }
    // Nor does leaving in several steps, each of which keeps 70 %: what counts is the most of the level.
    std::uint32_t count = 1000;
    double cost = 1.0;
    auto points = cloud(true_camera(), 100, random);
    auto const slowly = altered(points, [&](auto& e) {
        e.pixels = count;
        e.cost = cost * count;
        count = count * 7 / 10;
        cost *= 0.5;
        for (double& g : e.g) g = 1e-2 * e.h[0][0];
    });
    CHECK(solve(slowly, truth).steps == 1);
}

TEST_CASE("the last short step counts although the cost is rounded too coarsely to show its gain")
{
    Random random;
    auto const camera = true_camera();
    auto const truth = scene::pose_of(camera);
    auto points = cloud(camera, 100, random);
    // Residuals of a picture: a ten-thousandth for each pixel. The cost of a point is rounded as on the mesh.
    auto const rounded = altered(points, [](auto& e) {
        for (auto& row : e.h)
            for (double& v : row) v *= 1e-8;
        for (double& v : e.g) v *= 1e-8;
        double const mean = e.pixels == 0 ? 0.0 : e.cost * 1e-8 / e.pixels;
        e.cost = std::floor(mean * 0x1p21 + 0.5) * 0x1p-21 * e.pixels;
    });
    auto const start = disturbed(truth, 5e-4, 0.0, random); // 0.004 pixels
    auto const s = solve(rounded, start);
    CHECK(s.converged());
    CHECK(s.steps >= 1);
    CHECK(degrees_between(s.pose.rotation, truth.rotation) < 5e-5);
}

namespace {

/// A problem with a known answer: the residual of an unknown is its distance from `target`, in view space at the identity, times `weight`.
/// Where it is quadratic, the first step of Gauss and Newton ends on the target.
struct Quadratic {
    track::Twist target{};
    track::Exposure light{};
    std::array<double, 8> weight{1, 1, 1, 1, 1, 1, 1, 1};
    std::uint32_t unknowns = 6;
    std::vector<track::Level> asked{};

    track::NormalEquations operator()(splat::Camera const& camera, track::Level const& level)
    {
        asked.push_back(level);
        auto const here = track::twist_between({}, scene::pose_of(camera));
        double const off[8] = {(here.rho.x - target.rho.x) / scale_of_points, (here.rho.y - target.rho.y) / scale_of_points, (here.rho.z - target.rho.z) / scale_of_points,
                               here.phi.x - target.phi.x, here.phi.y - target.phi.y, here.phi.z - target.phi.z,
                               level.exposure.log_gain - light.log_gain, level.exposure.offset - light.offset};
        track::NormalEquations e;
        e.unknowns = unknowns;
        e.pixels = 100;
        for (std::uint32_t i = 0; i < unknowns; ++i) {
            double j[8]{};
            j[i] = weight[i];
            add_row(e, j, weight[i] * off[i], 1e9);
        }
        return e;
    }
};
track::Twist shift_px(double px) // sideways, in pixels of the picture
{
    return {{px / 500.0 * scale_of_points, 0.0, 0.0}, {}};
}
std::vector<std::uint32_t> evaluations_by_level(Quadratic const& problem)
{
    std::vector<std::uint32_t> out;
    for (std::size_t i = 0; i < problem.asked.size(); ++i) {
        if (i == 0 || problem.asked[i].cell != problem.asked[i - 1].cell) out.push_back(0);
        ++out.back();
    }
    return out;
}

} // namespace

TEST_CASE("a level of a quadratic problem takes one evaluation if its step is below the limit, and two if it is longer")
{
    for (auto const& stage : track::stages_of(track::Method::hybrid, 4)) CHECK(stage.stop_px == (stage.cell > 1 ? 0.25 : 0.01));
    // The first level finds the target with its first step, so the others evaluate once, at the target.
    for (double const px : {0.0, 0.9, 1.1, 30.0}) {
        Quadratic problem{shift_px(px)};
        auto const s = solve(problem, {}, 4);
        CHECK(s.ending == track::Ending::small_step);
        CHECK(evaluations_by_level(problem) == std::vector<std::uint32_t>{px < 1.0 ? 1u : 2u, 1u, 1u}); // a quarter of a cell of 4 is a pixel
        CHECK(s.evaluations == problem.asked.size());
        CHECK(glm::length(s.pose.position + problem.target.rho) < 1e-3 / 500.0 * scale_of_points); // lambda leaves 1e-4 of each step
    }
    // At full resolution the limit is 0.01 pixels. The step below it is taken.
    for (double const px : {0.009, 0.011}) {
        Quadratic problem{shift_px(px)};
        auto const s = solve(problem, {});
        CHECK(s.evaluations == (px < 0.01 ? 1 : 2));
        CHECK(s.steps == s.evaluations);
        CHECK(s.last_step_px < 0.01);
        CHECK(glm::length(s.pose.position + problem.target.rho) < 1e-2 * glm::length(problem.target.rho));
        CHECK(s.at.pixels == 100);
    }
}

TEST_CASE("a short step that changes the exposure is evaluated on the last level, and only there")
{
    for (double const brighter : {0.0, 5e-4, 2e-3, 0.5}) {
        Quadratic problem;
        problem.light = {brighter, -0.5 * brighter};
        problem.unknowns = 8;
        // The coarse level leaves the exposure as it was, so that the last level has to find it.
        auto const s = solve(altered(problem,
                                     [](auto& e, auto const&, track::Level const& level) {
                                         if (level.cell == 2) e.g[6] = e.g[7] = 0.0;
                                     }),
                             {}, 2);
        CHECK(evaluations_by_level(problem) == std::vector<std::uint32_t>{1, brighter < 9e-4 ? 1u : 2u});
        CHECK(s.ending == track::Ending::small_step);
        CHECK(std::fabs(s.exposure.log_gain - brighter) <= 1e-3 * brighter);
        CHECK(std::fabs(s.exposure.offset + 0.5 * brighter) <= 1e-3 * brighter);
        // The sums belong to this exposure.
        CHECK(std::fabs(problem.asked.back().exposure.log_gain - s.exposure.log_gain) <= track::detail::noticeable_exposure);
    }
}

TEST_CASE("the exposure stays within its limits, and the pose takes the step that is best there")
{
    for (double const beyond : {100.0, -100.0}) {
        Quadratic problem{shift_px(3.0)};
        problem.unknowns = 8;
        problem.light = {beyond, 0.5 * beyond};
        // A pose that depends on the exposure: with the gain at its limit, the shift is not that of the free minimum.
        auto const ask = altered(problem, [&](auto& e, splat::Camera const& camera, track::Level const& level) {
            double const both[8] = {1, 0, 0, 0, 0, 0, 1e-3, 0};
            add_row(e, both, scene::pose_of(camera).position.x / -scale_of_points - 3.0 / 500.0 + 1e-3 * (level.exposure.log_gain - problem.light.log_gain), 1e9);
        });
        auto const s = solve(ask, {});
        track::ExposureLimits const limits;
        CHECK(s.exposure.log_gain == std::copysign(limits.log_gain, beyond));
        CHECK(s.exposure.offset == std::copysign(limits.offset, beyond));
        CHECK(limits.reached(s.exposure));
        CHECK(limits.log_gain == doctest::Approx(std::log(16.0)));
        for (auto const& level : problem.asked) CHECK((std::fabs(level.exposure.log_gain) <= limits.log_gain && std::fabs(level.exposure.offset) <= limits.offset));
        // Two rows of weight 1 pull the shift: to 3 pixels, and to 3 pixels less what the gain lacks.
        double const lacks = 1e-3 * (s.exposure.log_gain - beyond);
        CHECK(s.pose.position.x / -scale_of_points == doctest::Approx(3.0 / 500.0 - 0.5 * lacks).epsilon(1e-3));
    }
    CHECK(!track::ExposureLimits{}.reached({2.7, -0.24}));
    CHECK(track::ExposureLimits{}.reached({not_a_number, 0.0}));
}

TEST_CASE("a singular problem moves only what the rows determine, and every level has a bound on its evaluations")
{
    Quadratic problem{{{0.4, 0.0, 0.0}, {0.0, 0.01, 0.0}}};
    problem.weight = {1, 0, 0, 0, 1, 0, 0, 0};
    auto const s = solve(problem, {}, 8);
    CHECK(s.converged());
    CHECK(is_finite(s.pose));
    auto const found = track::twist_between({}, s.pose);
    CHECK(found.rho.x == doctest::Approx(0.4).epsilon(1e-3));
    CHECK(found.phi.y == doctest::Approx(0.01).epsilon(1e-3));
    CHECK(std::fabs(found.phi.x) + std::fabs(found.phi.z) < 1e-9);

    // Two unknowns with one sum, one column a multiple of the other: the damping decides.
    Random random;
    auto points = cloud(true_camera(), 1, random);
    auto const one = solve(points, disturbed(scene::pose_of(true_camera()), 0.5, 0.0, random));
    CHECK(is_finite(one.pose));
    CHECK(one.evaluations <= 30);

    // Steps that stay long: 12 evaluations on each coarse level, 30 on the last.
    std::vector<std::uint32_t> calls(9, 0);
    double cost = 1e9;
    auto const endless = [&](splat::Camera const&, track::Level const& level) {
        ++calls[level.cell];
        track::NormalEquations e;
        e.pixels = 100;
        e.cost = cost *= 0.9;
        for (int k = 0; k < 6; ++k) e.h[k][k] = 1.0, e.g[k] = 0.1;
        return e;
    };
    auto const spent = solve(endless, {}, 8);
    CHECK(spent.ending == track::Ending::spent);
    CHECK(calls[8] == 12);
    CHECK(calls[4] == 12);
    CHECK(calls[2] == 12);
    CHECK(calls[1] == 30);
    CHECK(spent.evaluations == 66);
    CHECK(is_finite(spent.pose));
    // A stage with one evaluation takes only a step that needs no other.
    for (double const px : {0.005, 5.0}) {
        Quadratic near{shift_px(px)};
        auto const once = track::solve_pose(near, {}, lens(), scale_of_points, {{1, track::Jacobian::forward, 0.01, 1}});
        CHECK(once.evaluations == 1);
        CHECK(once.ending == (px < 0.01 ? track::Ending::small_step : track::Ending::spent));
        CHECK(once.steps == (px < 0.01 ? 1 : 0));
    }
}

TEST_CASE("a view without room is a refused step; if it is the start, nothing is usable and the reason stays")
{
    Random random;
    auto const truth = scene::pose_of(true_camera());
    auto points = cloud(true_camera(), 100, random);
    std::uint32_t calls = 0, full = 2;
    auto const crowded = altered(points, [&](auto&) {
        if (++calls == full || full == 0) throw track::NoRoom("5 splats without room on a tile (each tile has 4 slots); choose other tiles");
    });
    auto const start = disturbed(truth, 2.0, 0.02, random);
    auto const s = solve(crowded, start);
    CHECK(s.converged());
    CHECK(s.refusal.find("5 splats") == 0);
    CHECK(degrees_between(s.pose.rotation, truth.rotation) < 1e-5);
    full = 0;
    auto const none = solve(crowded, start, 8);
    CHECK(none.ending == track::Ending::unusable);
    CHECK(none.evaluations == 4);
    CHECK(none.pose.position == start.position);
    // Any other error is the caller's.
    auto const broken = [](splat::Camera const&, track::Level const&) -> track::NormalEquations { throw Error("cells of 3 pixels (a cell is 1); choose it"); };
    CHECK_THROWS_AS((void)solve(broken, start), Error);
}
