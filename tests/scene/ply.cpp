// test: needs data
#include "ply_writer.hpp"
#include "support.hpp"
#include <tilemesh/scene/map_file.hpp>

using namespace scene_test;
using tilemesh::scene::load_ply;

namespace {

/// A plain map with one field of its second row of three changed.
tilemesh::scene::Map with_field(int field, double value)
{
    Ply ply;
    ply.rows.resize(3);
    ply.rows[1].f[field] = value;
    return read(ply);
}

} // namespace

TEST_CASE("a row becomes the record of the paper; the map is named after its file")
{
    TempFile const file(Ply{}.bytes(), ".ply");
    auto const map = load_ply(file.path());
    CHECK(map.name == file.path().stem().string());
    CHECK(map.path == file.path().string());
    REQUIRE(map.gaussians.size() == 1);
    auto const& g = map.gaussians[0];
    CHECK(g.mean_world[0] == 1.0f);
    CHECK(g.mean_world[1] == 2.0f);
    CHECK(g.mean_world[2] == 3.0f);
    CHECK(g.colour[0] == doctest::Approx(0.641047395).epsilon(1e-6));
    CHECK(g.colour[1] == doctest::Approx(0.4294763025).epsilon(1e-6));
    CHECK(g.colour[2] == doctest::Approx(1.62837916).epsilon(1e-6)); // not clamped above
    CHECK(g.opacity == 0.5f);
    CHECK(g.log_scale[0] == -1.0f);
    CHECK(g.log_scale[1] == -2.0f);
    CHECK(g.log_scale[2] == -3.0f);
    CHECK(g.rotation[0] == 1.0f);
    CHECK(g.rotation[1] == 0.0f);
    CHECK(static_cast<std::uint32_t>(g.id) == 1);
    CHECK(map.rejected == 0);
    CHECK(map.notes.empty());
}

TEST_CASE("colour is clamped at zero from below only; opacity is the sigmoid of the logit, infinities included; a size of zero is finite")
{
    CHECK(with_field(3, -2.0).gaussians[1].colour[0] == 0.0f);
    CHECK(with_field(3, -1.7724539).gaussians[1].colour[0] == doctest::Approx(0.0).epsilon(1e-6));
    CHECK(with_field(3, 11.7).gaussians[1].colour[0] == doctest::Approx(3.800509).epsilon(1e-6));
    CHECK(with_field(6, 2.0).gaussians[1].opacity == doctest::Approx(0.880797078).epsilon(1e-7));
    CHECK(with_field(6, -2.0).gaussians[1].opacity == doctest::Approx(0.119202922).epsilon(1e-7));
    CHECK(with_field(6, 20.0).gaussians[1].opacity == 1.0f);
    CHECK(with_field(6, -1000.0).gaussians[1].opacity == 0.0f);
    CHECK(with_field(6, static_cast<double>(infinity)).gaussians[1].opacity == 1.0f);
    CHECK(with_field(6, static_cast<double>(-infinity)).gaussians[1].opacity == 0.0f);
    CHECK(with_field(8, static_cast<double>(-infinity)).gaussians[1].log_scale[1] == -87.0f);
    CHECK(with_field(8, -22.0).gaussians[1].log_scale[1] == -22.0f);
}

TEST_CASE("quaternions are normalised at any length")
{
    for (double const length : {1.0, 0.43, 2.04, 1e-44, 1e-38, 3e38}) {
        Ply ply;
        ply.rows[0].f[10] = 0.5 * length, ply.rows[0].f[11] = -0.5 * length;
        ply.rows[0].f[12] = 0.5 * length, ply.rows[0].f[13] = 0.5 * length;
        auto const map = read(ply);
        CAPTURE(length);
        REQUIRE(map.gaussians.size() == 1);
        float const* q = map.gaussians[0].rotation;
        double const tolerance = length < 1e-40 ? 0.1 : 1e-7; // 1e-44 is 7 steps of a denormal float
        CHECK(std::fabs(static_cast<double>(q[0]) - 0.5) <= tolerance);
        CHECK(std::fabs(static_cast<double>(q[1]) + 0.5) <= tolerance);
        double norm = 0.0;
        for (int i = 0; i < 4; ++i) norm += static_cast<double>(q[i]) * static_cast<double>(q[i]);
        CHECK(std::fabs(norm - 1.0) < 1e-6);
    }
    Ply tiny;
    tiny.doubles = true;
    for (int i = 10; i < 14; ++i) tiny.rows[0].f[i] = 1e-320;
    CHECK(read(tiny).gaussians.at(0).rotation[3] == 0.5f);
}

TEST_CASE("a row that is not finite is left out, counted and named, and its id stays unused")
{
    for (int field = 0; field < 14; ++field) {
        CAPTURE(names[field]);
        for (float const bad : {not_a_number, infinity, -infinity}) {
            bool const meant = (field == 6 && !std::isnan(bad)) || (field >= 7 && field < 10 && bad < 0.0f);
            auto const map = with_field(field, static_cast<double>(bad));
            CHECK(map.rejected == (meant ? 0u : 1u));
            if (meant) continue;
            REQUIRE(map.gaussians.size() == 2);
            CHECK(static_cast<std::uint32_t>(map.gaussians[0].id) == 1);
            CHECK(static_cast<std::uint32_t>(map.gaussians[1].id) == 3);
            REQUIRE(map.notes.size() == 1);
            CHECK(has(map.notes[0], "row 2 rejected"));
            CHECK(has(map.notes[0], names[field]));
        }
    }
}

TEST_CASE("a zero quaternion, and a double beyond the range of float, are rejected")
{
    auto map = with_field(10, 0.0);
    CHECK(map.rejected == 1);
    CHECK(map.gaussians.size() == 2);
    CHECK(has(map.notes.at(0), "row 2 rejected: rot_0..3 is zero"));
    Ply ply;
    ply.doubles = true;
    ply.rows.resize(2);
    ply.rows[0].f[1] = 1e39;
    map = read(ply);
    CHECK(map.rejected == 1);
    CHECK(has(map.notes.at(0), "row 1 rejected: y"));
}

TEST_CASE("five rejected rows are named, the others counted")
{
    for (std::size_t const bad : {5u, 6u, 12u}) {
        Ply ply;
        ply.rows.resize(13);
        for (std::size_t i = 0; i < bad; ++i) ply.rows[i].f[0] = static_cast<double>(not_a_number);
        auto const map = read(ply);
        CHECK(map.rejected == bad);
        CHECK(map.gaussians.size() == 13 - bad);
        CHECK(map.notes.size() == (bad == 5 ? 5 : 6));
        if (bad > 5) CHECK(has(map.notes.back(), "and " + std::to_string(bad - 5) + " more"));
    }
}

TEST_CASE("more rows than one read holds come in order")
{
    Ply ply;
    ply.rows.resize(40000); // 56 bytes each: three reads of 1 MiB
    for (std::size_t i = 0; i < ply.rows.size(); ++i) ply.rows[i].f[0] = static_cast<double>(i);
    auto const map = read(ply);
    REQUIRE(map.gaussians.size() == 40000);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < ply.rows.size(); ++i)
        wrong += map.gaussians[i].mean_world[0] != static_cast<float>(i) || static_cast<std::uint32_t>(map.gaussians[i].id) != i + 1;
    CHECK(wrong == 0);
}

TEST_CASE("opacities and scales that may be linear are noted, from 16 rows on")
{
    auto const notes = [](std::size_t rows, double opacity, double scale) {
        Ply ply;
        ply.rows.assign(rows, {{0, 0, 3, 1, 1, 1, 0.5, 0.1, 0.2, 0.3, 1, 0, 0, 0}});
        ply.rows[3].f[6] = opacity;
        ply.rows[4].f[7] = scale;
        std::istringstream stream(ply.bytes());
        std::string all;
        for (auto const& note : tilemesh::scene::read_map(stream, "a.ply").notes) all += note.substr(0, 13) + ";";
        return all;
    };
    CHECK(notes(16, 1, 0.1) == "all opacities;all scales ar;");
    CHECK(notes(16, 1.5, 0.1) == "all scales ar;");
    CHECK(notes(16, 0, -3) == "all opacities;");
    CHECK(notes(15, 1, 0.1).empty());
}

TEST_CASE("the maps of the paper are read whole")
{
    for (auto const& [name, count] : {std::pair{"maps/sloth.ply", 25161u}, std::pair{"maps/salad.ply", 37941u}}) {
        auto const path = data_file(name);
        if (path.empty()) continue;
        auto const map = load_ply(path);
        CHECK(map.gaussians.size() == count);
        CHECK(map.rejected == 0);
        std::size_t wrong = 0;
        for (auto const& g : map.gaussians) {
            double norm = 0.0;
            for (float q : g.rotation) norm += static_cast<double>(q) * static_cast<double>(q);
            wrong += !(std::fabs(norm - 1.0) < 1e-6) || !(g.opacity >= 0.0f && g.opacity <= 1.0f) || g.colour[0] < 0.0f;
        }
        CHECK(wrong == 0);
    }
    if (auto const path = data_file("maps/fruit_drops_sh3.ply"); !path.empty()) {
        auto const map = load_ply(path);
        CHECK(map.gaussians.size() == 4721);
        CHECK(map.sh_degree == 3);
        CHECK(map.harmonics.size() == 4721u * 45u);
    }
}
