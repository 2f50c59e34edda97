// test: unoptimised test asan
#include "ply_writer.hpp"
#include "support.hpp"
#include <glm/geometric.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/colmap.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/scene/ply.hpp>
#include <tilemesh/scene/trajectory.hpp>

using namespace scene_test;
using namespace tilemesh;
using scene::FarMeans;
using Means = std::vector<std::array<double, 3>>;

namespace {

/// A PLY whose columns have this type. Every row has another colour, so that rows can be told apart.
std::string ply_of(Means const& means, bool doubles, bool in_ascii = false)
{
    Ply ply;
    ply.doubles = doubles;
    ply.format = in_ascii ? ascii : little;
    ply.rows.clear();
    for (auto const& [x, y, z] : means) ply.rows.push_back({{x, y, z, static_cast<double>(ply.rows.size()) * 0.01, 0, 0, 2, -3, -3, -3, 1, 0, 0, 0}});
    return ply.bytes();
}
scene::Map read(std::string const& bytes, FarMeans far)
{
    std::istringstream stream(bytes);
    return scene::read_map(stream, "far.ply", {}, far);
}
Means around(std::array<double, 3> const& centre, double spread, std::size_t n, std::mt19937& random)
{
    std::uniform_real_distribution<double> number(-spread, spread);
    Means means(n);
    for (auto& mean : means)
        for (std::size_t i = 0; i < 3; ++i) mean[i] = centre[i] + number(random);
    return means;
}
std::array<double, 3> const utm{465123.25, 5264987.5, 431.0};

} // namespace

TEST_CASE("far means of double columns keep all digits when their origin is subtracted")
{
    std::mt19937 random(1);
    for (auto const& centre : {utm, std::array{5e6, 5e6, 5e6}, std::array{-4.1e6, 0.0, 4.8e6}, std::array{12345.0, 0.0, 0.0}})
        for (std::size_t n : {1u, 2u, 60u, 300u})
            for (bool const in_ascii : {false, true}) {
                auto means = around(centre, 5, n, random);
                if (n > 50) means[7] = {0, 0, 0}; // an outlier moves no median
                auto const map = read(ply_of(means, true, in_ascii), FarMeans::moved);
                REQUIRE(map.gaussians.size() == n);
                for (std::size_t i = 0; i < 3; ++i) {
                    CHECK(map.origin[i] == std::round(map.origin[i]));
                    CHECK(std::fabs(map.origin[i] - centre[i]) <= 6);
                }
                for (std::size_t row = 0; row < n; ++row)
                    for (std::size_t i = 0; i < 3; ++i)
                        CHECK(std::fabs(static_cast<double>(map.gaussians[row].mean_world[i]) - (means[row][i] - map.origin[i])) <=
                              std::fabs(means[row][i] - map.origin[i]) * 1.2e-7 + 1e-8);
                CHECK(notes_have(map, "is subtracted from the map, and from cameras and trajectories"));
                CHECK_FALSE(notes_have(map, "export the map"));
                // In float32 the digits are gone, and the note says so.
                auto const rounded = read(ply_of(means, false, in_ascii), FarMeans::moved);
                for (std::size_t row = 0; row < n; ++row)
                    for (std::size_t i = 0; i < 3; ++i)
                        CHECK(rounded.gaussians[row].mean_world[i] ==
                              static_cast<float>(static_cast<double>(static_cast<float>(means[row][i])) - rounded.origin[i]));
                CHECK(notes_have(rounded, "export the map as PLY with double columns x, y, z"));
                // Kept means are those of the file, with a note.
                auto const kept = read(ply_of(means, true, in_ascii), FarMeans::kept);
                CHECK(kept.origin == std::array<double, 3>{});
                for (std::size_t row = 0; row < n; ++row) CHECK(kept.gaussians[row].mean_world[1] == static_cast<float>(means[row][1]));
                CHECK(notes_have(kept, "far from 0 against their spread, and float32 has steps of"));
            }
    CHECK(notes_have(read(ply_of(around({5e6, 5e6, 5e6}, 5, 9, random), false), FarMeans::moved), "float32 has steps of 0.5 there"));
    CHECK(notes_have(read(ply_of({{5e6, -4e5, 0.25}}, true), FarMeans::moved), "the origin 5000000, -400000, 0 is subtracted"));
}

TEST_CASE("other maps stay bit for bit what they are")
{
    std::mt19937 random(2);
    for (auto const& means : {around({0, 0, 4}, 5, 100, random), around({9000, 9000, 0}, 1, 50, random), around({5e6, 0, 0}, 1e4, 100, random), around({0, 0, 0}, 1e7, 100, random),
                              Means{{0, 0, 9999}}, Means{}}) {
        auto const moved = read(ply_of(means, true), FarMeans::moved), kept = read(ply_of(means, true), FarMeans::kept);
        CHECK(moved.origin == std::array<double, 3>{});
        CHECK(moved.notes == kept.notes);
        REQUIRE(moved.gaussians.size() == means.size());
        for (std::size_t row = 0; row < means.size(); ++row) {
            CHECK(std::memcmp(&moved.gaussians[row], &kept.gaussians[row], sizeof kept.gaussians[row]) == 0);
            for (std::size_t i = 0; i < 3; ++i) CHECK(moved.gaussians[row].mean_world[i] == static_cast<float>(means[row][i]));
        }
        CHECK_FALSE(scene::has_far_means(kept));
    }
}

TEST_CASE("maps of several origins are joined at the first one's; a turn turns the origin")
{
    std::mt19937 random(3);
    auto const first_means = around(utm, 5, 20, random), second_means = around({utm[0] + 30, utm[1] - 12, utm[2]}, 5, 20, random);
    auto const first = read(ply_of(first_means, true), FarMeans::moved), second = read(ply_of(second_means, true), FarMeans::moved);
    auto const joined = scene::join_maps({first, second});
    CHECK(joined.origin == first.origin);
    for (std::size_t row = 0; row < 40; ++row)
        for (std::size_t i = 0; i < 3; ++i) {
            double const expected = (row < 20 ? first_means[row] : second_means[row - 20])[i] - joined.origin[i];
            CHECK(std::fabs(static_cast<double>(joined.gaussians[row].mean_world[i]) - expected) < 1e-5);
        }
    auto const turned = scene::turned(first, scene::Turn::z90); // x to y, y to -x
    CHECK(turned.origin == std::array<double, 3>{-first.origin[1], first.origin[0], first.origin[2]});
    CHECK(turned.gaussians[3].mean_world[1] == first.gaussians[3].mean_world[0]);
}

TEST_CASE("cameras of every format and trajectories see far Gaussians where a near map has them")
{
    std::array<double, 3> const place{utm[0] + 1.0625, utm[1] - 2.4375, utm[2] + 0.3125}, origin{465123, 5264988, 431};
    auto const number = [](double v) {
        char word[64];
        std::snprintf(word, sizeof word, "%.17g", v);
        return std::string(word);
    };
    std::string const x = number(place[0]), y = number(place[1]), z = number(place[2]), ix = number(-place[0]), iy = number(-place[1]), iz = number(-place[2]);
    std::string const size = "\"width\":64,\"height\":48,\"fx\":50,\"fy\":50";
    auto const json = [](std::string const& text) {
        std::istringstream stream(text);
        return scene::read_cameras_json(stream, "c.json");
    };
    std::istringstream lenses("1 PINHOLE 64 48 50 50 32 24\n"), images("1 1 0 0 0 " + ix + " " + iy + " " + iz + " 1 a.png\n\n");
    std::vector<std::vector<scene::NamedCamera>> const all{
        json(R"({"cameras":[{"name":"a","cx":32,"cy":24,"world_to_camera":[[1,0,0,)" + ix + "],[0,1,0," + iy + "],[0,0,1," + iz + "],[0,0,0,1]]," + size + "}]}"),
        json(R"([{"id":0,"img_name":"a","position":[)" + x + "," + y + "," + z + "],\"rotation\":[[1,0,0],[0,1,0],[0,0,1]]," + size + "}]"),
        json(R"({"w":64,"h":48,"fl_x":50,"frames":[{"file_path":"a","transform_matrix":[[1,0,0,)" + x + "],[0,-1,0," + y + "],[0,0,-1," + z + "],[0,0,0,1]]}]}"),
        scene::read_colmap(lenses, images)};
    for (auto const& cameras : all) {
        REQUIRE(cameras.size() == 1);
        auto const moved = scene::relative_to_origin(cameras, origin);
        for (std::size_t i = 0; i < 3; ++i) {
            CHECK(cameras[0].camera.position[i] == static_cast<float>(place[i]));
            CHECK(static_cast<double>(moved[0].camera.position[i]) == place[i] - origin[i]);
        }
        CHECK(scene::relative_to_origin(cameras, {})[0].camera.position[1] == cameras[0].camera.position[1]);
    }
    scene::NamedCamera own{"", "", "own", all[0][0].camera, {}}; // of a program, without a position in double
    CHECK(static_cast<double>(scene::relative_to_origin({own}, origin)[0].camera.position[0]) == static_cast<double>(own.camera.position[0]) - origin[0]);
    std::istringstream walk("0 " + x + " " + y + " " + z + " 0 0 0 1\n");
    auto const poses = scene::relative_to_origin(scene::read_tum(walk, "walk"), origin);
    CHECK(glm::length(poses[0].pose.position - glm::dvec3{place[0] - origin[0], place[1] - origin[1], place[2] - origin[2]}) == 0.0);
}
