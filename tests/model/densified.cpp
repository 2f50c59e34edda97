#include <common/scenes.cpp>
#include <cstring>
#include <doctest/doctest.h>
#include <glm/geometric.hpp>

TEST_CASE("a densified map: n Gaussians, the same each time, as large as the ones that they replace")
{
    auto const whole = tilemesh::scene::built_in_map();
    tilemesh::scene::Map map;
    for (std::size_t i = 0; i < whole.gaussians.size(); i += 400) map.gaussians.push_back(whole.gaussians[i]);
    auto const rows = static_cast<std::uint32_t>(map.gaussians.size()), n = 10 * rows + 7;
    auto const dense = bench::densified(map, n).gaussians, again = bench::densified(map, n).gaussians;
    REQUIRE(dense.size() == n);
    CHECK(std::memcmp(dense.data(), again.data(), n * sizeof dense[0]) == 0);

    double squares = 0;
    std::uint32_t at = 0;
    for (std::uint32_t row = 0; row < rows; ++row) {
        auto const& from = map.gaussians[row];
        auto const turn = tilemesh::scene::rotation_matrix(from.rotation[0], from.rotation[1], from.rotation[2], from.rotation[3]);
        auto const copies = (row + 1) * n / rows - row * n / rows;
        CHECK((copies == 10 || copies == 11));
        double area = 0;
        for (std::uint32_t i = 0; i < copies; ++i, ++at) {
            auto const& g = dense[at];
            CHECK(g.id == tilemesh::splat::GaussianId{at + 1});
            CHECK(g.opacity == from.opacity);
            area += std::exp(2.0 * static_cast<double>(g.log_scale[0] - from.log_scale[0]));
            glm::dvec3 moved;
            for (int k = 0; k < 3; ++k) moved[k] = static_cast<double>(g.mean_world[k]) - static_cast<double>(from.mean_world[k]);
            for (int axis = 0; axis < 3; ++axis) {
                auto const length = std::exp(static_cast<double>(from.log_scale[axis]));
                auto const along = glm::dot(turn[axis], moved);
                CHECK(std::fabs(along) < 3.001 * length + 1e-6);
                if (axis == 0) squares += along / length * along / length;
            }
        }
        CHECK(area == doctest::Approx(1).epsilon(1e-4));
    }
    CHECK(squares / n == doctest::Approx(1).epsilon(0.1)); // one standard deviation of the first axis
    auto const same = bench::densified(map, rows).gaussians;
    for (std::uint32_t row = 0; row < rows; ++row)
        CHECK(std::memcmp(same[row].mean_world, map.gaussians[row].mean_world, sizeof same[row].mean_world) == 0);
}
