// test: needs data
#include "ply_writer.hpp"
#include "support.hpp"
#include <sstream>
#include <tilemesh/scene/map_file.hpp>

using namespace scene_test;
using tilemesh::scene::load_ply;
using tilemesh::scene::Map;

namespace {

Map load(std::string const& bytes)
{
    TempFile const file(bytes, ".ply");
    return load_ply(file.path());
}
Map load(Ply const& ply)
{
    return load(ply.bytes());
}

std::string refusal(std::string const& bytes)
{
    return error_of([&] { load(bytes); });
}

/// A plain map with one field of its second row of three changed.
Map with_field(int field, double value)
{
    Ply ply;
    ply.rows.resize(3);
    ply.rows[1].f[field] = value;
    return load(ply);
}

} // namespace

TEST_CASE("a row becomes the record of the paper")
{
    auto const map = load(Ply{});
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

TEST_CASE("the map is named after its file")
{
    TempFile const file(Ply{}.bytes(), ".ply");
    auto const map = load_ply(file.path());
    CHECK(map.name == file.path().stem().string());
    CHECK(map.path == file.path().string());
}

TEST_CASE("colour is clamped at zero from below only")
{
    CHECK(with_field(3, -2.0).gaussians[1].colour[0] == 0.0f);
    CHECK(with_field(3, -1.7724539).gaussians[1].colour[0] == doctest::Approx(0.0).epsilon(1e-6));
    CHECK(with_field(3, 11.7).gaussians[1].colour[0] == doctest::Approx(3.800509).epsilon(1e-6));
}

TEST_CASE("opacity is the sigmoid of the logit, infinities included")
{
    CHECK(with_field(6, 2.0).gaussians[1].opacity == doctest::Approx(0.880797078).epsilon(1e-7));
    CHECK(with_field(6, -2.0).gaussians[1].opacity == doctest::Approx(0.119202922).epsilon(1e-7));
    CHECK(with_field(6, 20.0).gaussians[1].opacity == 1.0f);
    CHECK(with_field(6, -1000.0).gaussians[1].opacity == 0.0f);
    for (auto const& [logit, opacity] : {std::pair{infinity, 1.0f}, std::pair{-infinity, 0.0f}}) {
        auto const map = with_field(6, static_cast<double>(logit));
        CHECK(map.rejected == 0);
        CHECK(map.gaussians[1].opacity == opacity);
    }
}

TEST_CASE("a size of zero is stored as a finite logarithm")
{
    auto const map = with_field(8, static_cast<double>(-infinity));
    CHECK(map.rejected == 0);
    CHECK(map.gaussians[1].log_scale[1] == -87.0f);
    CHECK(with_field(8, -22.0).gaussians[1].log_scale[1] == -22.0f);
}

TEST_CASE("quaternions are normalised at any length")
{
    for (double const length : {1.0, 0.43, 2.04, 1e-44, 1e-38, 3e38}) {
        Ply ply;
        ply.rows[0].f[10] = 0.5 * length, ply.rows[0].f[11] = -0.5 * length;
        ply.rows[0].f[12] = 0.5 * length, ply.rows[0].f[13] = 0.5 * length;
        auto const map = load(ply);
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
    CHECK(load(tiny).gaussians.at(0).rotation[3] == 0.5f);
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

TEST_CASE("a zero quaternion is rejected")
{
    auto const map = with_field(10, 0.0);
    CHECK(map.rejected == 1);
    CHECK(map.gaussians.size() == 2);
    CHECK(has(map.notes.at(0), "row 2 rejected: rot_0..3 is zero"));
}

TEST_CASE("a double beyond the range of float is not finite")
{
    Ply ply;
    ply.doubles = true;
    ply.rows.resize(2);
    ply.rows[0].f[1] = 1e39;
    auto const map = load(ply);
    CHECK(map.rejected == 1);
    CHECK(has(map.notes.at(0), "row 1 rejected: y"));
}

TEST_CASE("five rejected rows are named, the others counted")
{
    for (std::size_t const bad : {5u, 6u, 12u}) {
        Ply ply;
        ply.rows.resize(13);
        for (std::size_t i = 0; i < bad; ++i) ply.rows[i].f[0] = static_cast<double>(not_a_number);
        auto const map = load(ply);
        CHECK(map.rejected == bad);
        CHECK(map.gaussians.size() == 13 - bad);
        CHECK(map.notes.size() == (bad == 5 ? 5 : 6));
        if (bad > 5) CHECK(has(map.notes.back(), "and " + std::to_string(bad - 5) + " more"));
    }
}

TEST_CASE("the order and the type of the columns change no bit")
{
    Ply plain;
    plain.rows.resize(4);
    for (std::size_t i = 0; i < 4; ++i)
        for (int k = 0; k < 14; ++k) plain.rows[i].f[k] = 0.25 * static_cast<double>(i) + 0.125 * k;
    auto const expected = load(plain);
    REQUIRE(expected.gaussians.size() == 4);

    Ply reversed = plain;
    std::reverse(reversed.order.begin(), reversed.order.end());
    CHECK(same_records(load(reversed), expected));
    Ply rotated = plain;
    std::rotate(rotated.order.begin(), rotated.order.begin() + 5, rotated.order.end());
    CHECK(same_records(load(rotated), expected));
    Ply wide = rotated;
    wide.doubles = true;
    CHECK(same_records(load(wide), expected));
    plain.rows[3].f[9] += 0.5;
    CHECK_FALSE(same_records(load(plain), expected));
}

TEST_CASE("integer columns are read as numbers, signed or not")
{
    std::string bytes = "ply\r\nformat binary_little_endian 1.0\r\nelement vertex 1\r\nproperty char x\r\n"
                        "property uchar y\r\nproperty short z\r\nproperty uint16 f_dc_0\r\n"
                        "property int32 f_dc_1\r\nproperty uint f_dc_2\r\nproperty int8 opacity\r\n";
    for (int k = 7; k < 14; ++k) bytes += std::string("property int8 ") + names[k] + "\r\n";
    bytes += "end_header\r\n";
    put(bytes, std::int8_t{-1});
    put(bytes, std::uint8_t{255});
    put(bytes, std::int16_t{-300});
    put(bytes, std::uint16_t{65535});
    put(bytes, std::int32_t{2});
    put(bytes, std::uint32_t{4000000000u});
    for (int value : {0, -1, -2, -3, 0, 0, -1, 0}) put(bytes, static_cast<std::int8_t>(value));
    auto const map = load(bytes);
    REQUIRE(map.gaussians.size() == 1);
    auto const& g = map.gaussians[0];
    CHECK(g.mean_world[0] == -1.0f);
    CHECK(g.mean_world[1] == 255.0f);
    CHECK(g.mean_world[2] == -300.0f);
    CHECK(g.colour[0] == doctest::Approx(0.28209479 * 65535 + 0.5));
    CHECK(g.colour[2] == doctest::Approx(0.28209479 * 4e9));
    CHECK(g.log_scale[2] == -3.0f);
    CHECK(g.rotation[2] == -1.0f);
}

TEST_CASE("other elements are skipped, before the rows and after them")
{
    Ply ply;
    ply.elements_before = "element frame 3\nproperty uchar a\nproperty double b\n";
    ply.bytes_before = std::string(3 * 9, '\x7f');
    ply.elements_after = "element camera 2\nproperty int c\n";
    ply.bytes_after = std::string(2 * 4, '\x7f');
    auto const map = load(ply);
    CHECK(same_records(map, load(Ply{})));
    REQUIRE(map.notes.size() == 2);
    CHECK(has(map.notes[0], "\"frame\": 3 rows skipped"));
    CHECK(has(map.notes[1], "\"camera\": 2 rows skipped"));

    ply.bytes_after.pop_back();
    CHECK(has(refusal(ply.bytes()), "row 2 of element \"camera\""));
}

TEST_CASE("bytes after the last row are noted")
{
    Ply ply;
    ply.bytes_after = "xyz";
    auto const map = load(ply);
    CHECK(map.gaussians.size() == 1);
    CHECK(has(map.notes.at(0), "3 bytes after the last row"));
}

TEST_CASE("no row at all is an empty map")
{
    Ply ply;
    ply.rows.clear();
    auto const map = load(ply);
    CHECK(map.gaussians.empty());
    CHECK(map.rejected == 0);
}

TEST_CASE("more rows than one read holds come in order")
{
    Ply ply;
    ply.rows.resize(40000); // 56 bytes each: three reads of 1 MiB
    for (std::size_t i = 0; i < ply.rows.size(); ++i) ply.rows[i].f[0] = static_cast<double>(i);
    auto const map = load(ply);
    REQUIRE(map.gaussians.size() == 40000);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < ply.rows.size(); ++i)
        wrong += map.gaussians[i].mean_world[0] != static_cast<float>(i) ||
                 static_cast<std::uint32_t>(map.gaussians[i].id) != i + 1;
    CHECK(wrong == 0);
}

TEST_CASE("a body that is too short is refused, for any promise of the header")
{
    Ply ply;
    ply.rows.resize(3);
    std::string cut = ply.bytes();
    cut.pop_back();
    std::string const text = refusal(cut);
    CHECK(has(text, "row 3"));
    CHECK(has(text, "promises 3 rows"));
    CHECK(has(text, "2 are there"));

    ply.count = "4";
    CHECK(has(refusal(ply.bytes()), "row 4"));
    for (char const* count : {"1099511627776", "18446744073709551615", "329406144173384851"}) {
        ply.count = count; // 2^40; 2^64 - 1; the smallest whose bytes, times 56, wrap to less than
                           // are there
        CHECK(has(refusal(ply.bytes()), std::string("promises ") + count + " rows"));
        CHECK(has(refusal(ply.bytes()), "3 are there"));
    }
    ply.count = "18446744073709551616";
    CHECK(has(refusal(ply.bytes()), "below 2^64"));
    for (char const* count : {"-1", "3.0", "three", "0x3"}) {
        ply.count = count;
        CHECK(has(refusal(ply.bytes()), "not a whole number"));
    }
}

TEST_CASE("opacities and scales that may be linear are noted, from 16 rows on")
{
    auto const notes = [](int rows, char const* opacity, char const* scale) {
        std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(rows) + "\n";
        for (char const* name :
             {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
            text += std::string("property float ") + name + "\n";
        text += "end_header\n";
        for (int i = 0; i < rows; ++i)
            text += "0 0 3 1 1 1 " + std::string(i == 3 ? opacity : "0.5") + " " + (i == 4 ? scale : "0.1") + " 0.2 0.3 1 0 0 0\n";
        std::istringstream stream(text);
        std::string all;
        for (auto const& note : tilemesh::scene::read_map(stream, "a.ply").notes) all += note.substr(0, 13) + ";";
        return all;
    };
    CHECK(notes(16, "1", "0.1") == "all opacities;all scales ar;");
    CHECK(notes(16, "1.5", "0.1") == "all scales ar;");
    CHECK(notes(16, "0", "-3") == "all opacities;");
    CHECK(notes(15, "1", "0.1").empty());
}

TEST_CASE("a path that is not a PLY file is refused with its reason")
{
    auto const folder = std::filesystem::temp_directory_path();
    CHECK(has(error_of([&] { load_ply(folder / "tilemesh_no_such_file.ply"); }), "no such file"));
    CHECK(has(error_of([&] { load_ply(folder); }), "directory"));
    CHECK(has(refusal(""), "not a PLY"));
    CHECK(has(refusal("pl"), "not a PLY"));
    CHECK(has(refusal("\x89PNG\r\n\x1a\n"), "not a PLY"));
    CHECK(has(refusal("plyx\n"), "not a PLY"));
    CHECK(has(refusal("ply\nformat binary_little_endian 1.0\n"), "end_header"));
    CHECK(has(refusal("ply\n" + std::string(1u << 20, 'x')), "end_header"));
    CHECK(has(refusal("ply\nformat binary_little_endian 1.0\nend_header\n"), "no element vertex"));
    CHECK(has(refusal("ply\nend_header\n"), "no format"));
    CHECK(has(refusal("ply\nhello\nend_header\n"), "line 2: unknown word \"hello\""));
    CHECK(has(refusal("ply\nproperty float x\nend_header\n"), "before the first element"));
}

TEST_CASE("every needed property is asked for by name")
{
    for (int field = 0; field < 14; ++field) {
        Ply ply;
        ply.order.erase(ply.order.begin() + field);
        CHECK(has(refusal(ply.bytes()), std::string("no property ") + names[field] + " ("));
    }
    Ply ply;
    ply.order = {0, 1, 2};
    CHECK(has(refusal(ply.bytes()), "f_dc_0, f_dc_1, f_dc_2, opacity"));
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
