// test: optimised, without test tsan
#include "../standard.hpp"
#include <common/scenes.cpp>
#include <glm/geometric.hpp>
#include <tilemesh/render/homes_renderer.hpp>
#include <tilemesh/report/naive.hpp>
#include <tilemesh/scene/records.hpp>

using namespace tilemesh;

namespace {
/// The built-in map, or every n-th Gaussian of it, with made-up view-dependent colour of degree 3.
scene::Map shaded(std::size_t every)
{
    auto const whole = scene::built_in_map();
    scene::Map map;
    map.name = whole.name;
    map.sh_degree = 3;
    for (std::size_t i = 0; i < whole.gaussians.size(); i += every) {
        map.gaussians.push_back(whole.gaussians[i]);
        for (std::uint32_t k = 0; k < 45; ++k) map.harmonics.push_back(static_cast<float>(0.2 * bench::even(static_cast<std::uint32_t>(i), k) - 0.1));
    }
    return map;
}
} // namespace

TEST_CASE("a densified map: n Gaussians, the same each time, as large as the ones that they replace")
{
    auto const whole = scene::built_in_map();
    scene::Map map;
    for (std::size_t i = 0; i < whole.gaussians.size(); i += 400) map.gaussians.push_back(whole.gaussians[i]);
    auto const rows = static_cast<std::uint32_t>(map.gaussians.size()), n = 10 * rows + 7;
    auto const dense = bench::densified(map, n).gaussians, again = bench::densified(map, n).gaussians;
    REQUIRE(dense.size() == n);
    CHECK(std::memcmp(dense.data(), again.data(), n * sizeof dense[0]) == 0);

    double squares = 0;
    std::uint32_t at = 0;
    for (std::uint32_t row = 0; row < rows; ++row) {
        auto const& from = map.gaussians[row];
        auto const turn = scene::rotation_matrix(from.rotation[0], from.rotation[1], from.rotation[2], from.rotation[3]);
        auto const copies = (row + 1) * n / rows - row * n / rows;
        CHECK((copies == 10 || copies == 11));
        double area = 0;
        for (std::uint32_t i = 0; i < copies; ++i, ++at) {
            auto const& g = dense[at];
            CHECK(g.id == splat::GaussianId{at + 1});
            CHECK(g.opacity == from.opacity);
            area += std::exp(2.0 * static_cast<double>(g.log_scale[0] - from.log_scale[0]));
            glm::dvec3 moved;
            for (int k = 0; k < 3; ++k) moved[k] = static_cast<double>(g.mean_world[k]) - static_cast<double>(from.mean_world[k]);
            for (int axis = 0; axis < 3; ++axis) {
                auto const length = std::exp(static_cast<double>(from.log_scale[axis])), along = glm::dot(turn[axis], moved);
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

TEST_CASE("a densified map has the harmonics of the Gaussians that it replaces")
{
    auto const map = shaded(4000);
    auto const rows = static_cast<std::uint32_t>(map.gaussians.size()), n = 3 * rows + 2;
    auto const dense = bench::densified(map, n);
    CHECK(dense.sh_degree == 3);
    REQUIRE(dense.harmonics.size() == 45 * dense.gaussians.size());
    std::size_t at = 0;
    for (std::uint32_t row = 0; row < rows; ++row)
        for (auto copies = (row + 1) * n / rows - row * n / rows; copies > 0; --copies, ++at)
            CHECK(std::memcmp(&dense.harmonics[45 * at], &map.harmonics[std::size_t{45} * row], 45 * sizeof(float)) == 0);
}

TEST_CASE("slow: 600,000 Gaussians of degree 3 are complete on tiles of Mk2: with homes for all, and in chapters")
{
    auto const map = bench::densified(shaded(1), 600'000);
    auto const camera = scene::built_in_camera({640, 360});
    auto choice = splat::homes_setup;
    choice.fit = true;
    choice.sh_degree = 3;
    choice.rules.arithmetic = splat::Arithmetic::precise;
    auto const expected = report::render_naive(scene::records<splat::GaussianOfDegree<3>>(map), camera, choice.rules);
    for (auto const& grid : {Extent2{40, 36}, Extent2{20, 18}}) { // a quarter of the tiles has too few homes
        RendererOptions options;
        options.grid = grid;
        render::HomesRenderer<splat::homes::HostPolicies<>> renderer(map, choice, options);
        auto const frame = renderer.render(camera);
        CHECK(render::sram_bytes_of(renderer.setup()) <= Mk2::sram_bytes);
        CHECK(render::record_bytes(renderer.setup()) == 240);
        CHECK((frame.report.homes.chapters > 1) == (grid.width == 20));
        CHECK(frame.report.homes.unfinished_tiles == 0);
        CHECK(frame.report.homes.entries > 0);
        REQUIRE(frame.image.rgb.size() == expected.rgb.size());
        CHECK(std::memcmp(frame.image.rgb.data(), expected.rgb.data(), expected.rgb.size() * sizeof(float)) == 0);
        MESSAGE(grid.width, " x ", grid.height, " tiles: ", frame.report.homes.chapters, " chapters, ", frame.report.homes.streamed_bytes, " bytes streamed, ",
                frame.report.homes.rounds, " rounds");
    }
}
