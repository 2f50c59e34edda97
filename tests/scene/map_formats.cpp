// test: unoptimised test asan tsan
#include "map_writers.hpp"
#include "real_packing.hpp"
#include "support.hpp"
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/scene/ply.hpp>
#include <tilemesh/scene/pose.hpp>

using namespace scene_test;
using tilemesh::scene::Codecs;
using tilemesh::scene::Map;
using tilemesh::scene::Turn;

namespace {

Map read(Bytes const& bytes, Codecs const& codecs = plain_codecs(), std::string const& name = "test.splat")
{
    std::istringstream stream(bytes);
    return tilemesh::scene::read_map(stream, name, codecs);
}

/// The map that `read_ply` makes of what a reference reader returns. Opacities and colours that the format has after their functions are exact.
Map expected_map(PlainMap const& plain)
{
    Map map = read(write_plain_ply(plain));
    for (auto& g : map.gaussians) {
        auto const& row = plain.rows[static_cast<std::size_t>(g.id) - 1];
        if (row.opacity) g.opacity = static_cast<float>(*row.opacity);
        for (std::size_t i = 0; row.colour && i < 3; ++i) g.colour[i] = static_cast<float>((*row.colour)[i]);
    }
    return map;
}

/// Bit for bit, with ids and rejected rows; but -0 and 0 are the same number.
bool same(Map const& a, Map const& b)
{
    auto const equal = [](auto const& v, auto const& w) { return std::equal(std::begin(v), std::end(v), std::begin(w)); };
    auto const same_gaussian = [&](auto const& g, auto const& h) {
        return g.id == h.id && g.opacity == h.opacity && equal(g.mean_world, h.mean_world) && equal(g.colour, h.colour) &&
               equal(g.log_scale, h.log_scale) && equal(g.rotation, h.rotation);
    };
    return a.rejected == b.rejected && a.sh_degree == b.sh_degree && a.harmonics == b.harmonics &&
           std::equal(a.gaussians.begin(), a.gaussians.end(), b.gaussians.begin(), b.gaussians.end(), same_gaussian);
}

constexpr std::size_t sizes[] = {0, 1, 255, 256, 257};

} // namespace

TEST_CASE("compressed PLY: bit for bit what its reference reader gives, with and without harmonics and colours of chunks")
{
    Numbers numbers(1);
    for (std::uint32_t degree = 0; degree <= 3; ++degree)
        for (std::size_t n : sizes)
            for (int form = 0; form < 4; ++form) {
                auto packed = PackedPly::random(n, degree, form % 2 == 0, numbers);
                packed.big = form >= 2;
                Map const map = read(packed.bytes());
                CAPTURE(degree);
                CAPTURE(n);
                CHECK(map.gaussians.size() == n);
                CHECK(same(map, expected_map(packed.expected())));
                CHECK(notes_have(map, "read as a compressed PLY of degree " + std::to_string(degree)));
            }
    // A chunk that is not finite: its rows are named, the harmonics of the others stay with them.
    auto packed = PackedPly::random(600, 2, true, numbers);
    packed.chunks[1][3] = std::numeric_limits<float>::infinity();
    Map const map = read(packed.bytes());
    CHECK(map.rejected == 256);
    CHECK(notes_have(map, "row 257 rejected: x is not finite"));
    CHECK(notes_have(map, "and 251 more rows rejected"));
    CHECK(same(map, expected_map(packed.expected())));
}

TEST_CASE(".splat: bit for bit what its reference reader gives")
{
    Numbers numbers(2);
    CHECK(has(error_of([&] { read(PackedSplat{}.bytes()); }), "is empty")); // a file without bytes has no format
    for (std::size_t n : {1u, 255u, 256u, 257u}) {
        auto packed = PackedSplat::random(n, numbers);
        Map const map = read(packed.bytes());
        CHECK(map.gaussians.size() == n);
        CHECK(same(map, expected_map(packed.expected())));
    }
    auto packed = PackedSplat::random(4, numbers);
    packed.rows[0].scale[1] = 0.0f;
    packed.rows[1].scale[1] = -1.0f;
    packed.rows[2].mean[2] = std::numeric_limits<float>::quiet_NaN();
    packed.rows[3].rotation = {128, 128, 128, 128};
    Map const map = read(packed.bytes());
    REQUIRE(map.gaussians.size() == 1);
    CHECK(map.gaussians[0].log_scale[1] == -87.0f);
    CHECK(notes_have(map, "row 2 rejected: scale_1 is not finite"));
    CHECK(notes_have(map, "row 3 rejected: z is not finite"));
    CHECK(notes_have(map, "row 4 rejected: rot_0..3 is zero"));
    CHECK(has(error_of([&] { read(packed.bytes().substr(0, 127)); }), "ends inside row 4 (a row of a .splat map has 32 bytes, and 31 are there)"));
    CHECK(has(error_of([&] { read(packed.bytes(), {}, "test.bin"); }), "does not begin with \"ply\"")); // a .splat has no magic: its name counts
    CHECK(read(write_plain_ply({0, {PlainRow{}}})).gaussians.size() == 1); // a PLY of that name is a PLY
    packed = PackedSplat::random(1, numbers);
    packed.rows[0].mean[0] = std::bit_cast<float>(0x3f008b1fu); // as gzip begins, but for the third byte
    CHECK(read(packed.bytes()).gaussians.size() == 1);
}

TEST_CASE("SPZ: bit for bit what its reference reader gives, in all versions, with the axes of a PLY")
{
    Numbers numbers(3);
    for (Packing const& packing : {Packing{}, real_packing()})
        for (std::uint32_t version = 1; version <= 4; ++version)
            for (std::uint32_t degree = 0; degree <= 4; ++degree)
                for (std::size_t n : sizes) {
                    CAPTURE(version);
                    CAPTURE(degree);
                    CAPTURE(n);
                    auto packed = PackedSpz::random(n, version, degree, numbers);
                    packed.fractional_bits = n == 255 ? 24 : n == 256 ? 0 : 12;
                    Map const map = read(packed.bytes(packing), packing.codecs);
                    Map const expected = expected_map(packed.expected());
                    CHECK(map.gaussians.size() + map.rejected == n);
                    CHECK(same(map, expected));
                    CHECK(notes_have(map, "read as SPZ version " + std::to_string(version) + " of degree " + std::to_string(degree)));
                    CHECK(notes_have(map, "y and z changed sign"));
                    if (version < 4) CHECK(same(read(packed.plain(), {}), expected)); // not compressed: no decoder
                }
    auto packed = PackedSpz::random(2, 3, 1, numbers);
    packed.flags = 3;
    packed.after = Bytes(12, 'e');
    Map const map = read(packed.bytes({}));
    CHECK(notes_have(map, "trained with anti-aliasing"));
    CHECK(notes_have(map, "extensions skipped"));
    packed.version = 4;
    CHECK(same(read(packed.bytes({})), map));
    packed.version = 2;
    packed.flags = 0;
    CHECK(notes_have(read(packed.plain()), "bytes after the last row skipped"));
}

/// The harmonics of degree 1 to 3 in a unit direction, by their definition.
std::array<double, 15> harmonics_in(glm::dvec3 const& d)
{
    std::array<double, 15> out{};
    std::size_t k = 0;
    for (int l = 1; l <= 3; ++l)
        for (int m = -l; m <= l; ++m) out[k++] = tilemesh::report::detail::harmonic(l, m, d.x, d.y, d.z);
    return out;
}

TEST_CASE("SPZ: the extension of a coordinate system turns and mirrors means, rotations and harmonics, in every version")
{
    // A map in each of the 16 systems is a map with the same bytes, read as right up back, whose axes are moved: the picture of any point and
    // direction says so.
    char const* const systems[] = {"LDB", "RDB", "LUB", "RUB", "LDF", "RDF", "LUF", "RUF", "LFD", "RFD", "LFU", "RFU", "LBD", "RBD", "LBU", "RBU"};
    Numbers numbers(11);
    for (std::uint32_t version = 1; version <= 4; ++version)
        for (std::uint32_t system = 1; system <= 16; ++system) {
            CAPTURE(version);
            CAPTURE(system);
            auto packed = PackedSpz::random(9, version, 3, numbers);
            auto const plain = read(packed.bytes({}));
            packed.flags = 2;
            for (std::uint32_t word : {0xadbe0002u, 12u, 1u, 2u, 3u, 0xadbe0003u, 4u, system}) put_little(packed.after, word, 4);
            auto const map = read(packed.bytes({}));
            CHECK(notes_have(map, "an extension says that its axes are "));
            CHECK(notes_have(map, "extensions skipped"));
            REQUIRE(map.gaussians.size() == plain.gaussians.size());
            glm::dmat3 m{0.0}; // from right, down, front as `plain` has them (x right, y down, z front of RUB); by columns
            for (int axis = 0; axis < 3; ++axis) {
                char const letter = systems[system - 1][axis];
                int const row = letter == 'L' || letter == 'R' ? 0 : letter == 'U' || letter == 'D' ? 1 : 2;
                double const sign = letter == 'R' || letter == 'D' || letter == 'F' ? 1 : -1,
                             stored = axis == 0 ? 1 : -1; // y and z of `plain` are turned
                m[axis][row] = sign * stored;
            }
            auto const mean_of = [](auto const& g) { return glm::dvec3{g.mean_world[0], g.mean_world[1], g.mean_world[2]}; };
            auto const covariance = [](auto const& g) { // with the sizes 1, sqrt(2), sqrt(3)
                auto const r = tilemesh::scene::rotation_matrix(g.rotation[0], g.rotation[1], g.rotation[2], g.rotation[3]);
                return r * glm::dmat3{1, 0, 0, 0, 2, 0, 0, 0, 3} * glm::transpose(r);
            };
            for (std::size_t i = 0; i < map.gaussians.size(); ++i) {
                auto const &a = plain.gaussians[i], &b = map.gaussians[i];
                CHECK(mean_of(b) == m * mean_of(a));
                auto const mine = covariance(b), turned = m * covariance(a) * glm::transpose(m);
                for (int column = 0; column < 3; ++column)
                    for (int row = 0; row < 3; ++row) CHECK(mine[column][row] == doctest::Approx(turned[column][row]).epsilon(1e-5).scale(1));
                glm::dvec3 const d{0.48, -0.6, 0.64};
                auto const before = harmonics_in(d), after = harmonics_in(m * d);
                double one = 0, two = 0;
                for (std::size_t k = 0; k < 15; ++k) {
                    one += before[k] * double{plain.harmonics[45 * i + 3 * k]};
                    two += after[k] * double{map.harmonics[45 * i + 3 * k]};
                }
                CHECK(two == doctest::Approx(one).epsilon(1e-5).scale(1));
            }
        }
    auto packed = PackedSpz::random(1, 4, 0, numbers);
    packed.flags = 2;
    for (std::uint32_t word : {0xadbe0003u, 4u, 17u}) put_little(packed.after, word, 4);
    CHECK(has(error_of([&] { read(packed.bytes({})); }), "none of the 16 of SPZ"));
}

TEST_CASE("SOG: bit for bit what its reference reader gives, in both versions, as an archive and as a folder")
{
    Numbers numbers(4);
    for (bool real : {false, true}) {
        Packing const packing = real ? real_packing() : Packing{};
        for (std::uint32_t version = 1; version <= 2; ++version)
            for (std::uint32_t degree = 0; degree <= 3; ++degree)
                for (std::size_t n : sizes) {
                    CAPTURE(version);
                    CAPTURE(degree);
                    CAPTURE(n);
                    auto const packed = PackedSog::random(n, version, degree, numbers);
                    auto const files = packed.files(packing);
                    Map const map = read(write_zip(files, packing, n == 256), packing.codecs);
                    CHECK(map.gaussians.size() == n);
                    CHECK(same(map, expected_map(packed.expected())));
                    CHECK(notes_have(map, "read as SOG version " + std::to_string(version) + " of degree " + std::to_string(degree)));
                    if (n != 255) continue;
                    TempFolder const place("older.sog");
                    auto const& folder = place.path();
                    std::vector<std::filesystem::path> written;
                    auto const renamed = [](Bytes text) { // meta.json names the pictures; .webp is a habit
                        for (std::size_t at; (at = text.find(".webp")) != text.npos;) text.replace(at, 5, ".data");
                        return text;
                    };
                    for (auto const& [name, content] : files)
                        written.push_back(place.write(renamed(name), name == "meta.json" ? renamed(content) : content));
                    place.write("other.webp", "not of the map");
                    auto of_map = tilemesh::scene::map_files(folder);
                    CHECK(of_map == tilemesh::scene::map_files(folder / "meta.json"));
                    std::sort(of_map.begin(), of_map.end());
                    CHECK(of_map == written);
                    CHECK(tilemesh::scene::map_files(folder / "quats.data") == std::vector{folder / "quats.data"});
                    Map const unpacked = tilemesh::scene::load_map(folder, packing.codecs);
                    CHECK(same(unpacked, map));
                    CHECK(unpacked.name == folder.stem().string());
                    CHECK(same(tilemesh::scene::load_map(folder / "meta.json", packing.codecs), map));
                    std::filesystem::remove(folder / "quats.data");
                    CHECK(has(error_of([&] { tilemesh::scene::load_map(folder, packing.codecs); }), "quats.data cannot be opened"));
                    std::filesystem::remove(folder / "meta.json");
                    CHECK(has(error_of([&] { tilemesh::scene::load_map(folder, packing.codecs); }), "is a folder without meta.json"));
                }
    }
    auto packed = PackedSog::random(3, 2, 1, numbers);
    packed.rows[1].rotation[3] = 251;
    Map const map = read(write_zip(packed.files({}), {}, false));
    CHECK(map.rejected == 1);
    CHECK(notes_have(map, "row 2 rejected: its rotation has no largest component"));
    packed.rows[2].label = 100;
    CHECK(has(error_of([&] { read(write_zip(packed.files({}), {}, false)); }), "row 3 names entry 100 of 100"));
}

TEST_CASE("SOG: what other writers leave out, or call otherwise, changes nothing")
{
    Numbers numbers(41);
    Packing const packing;
    for (std::uint32_t degree : {1u, 2u, 3u})
        for (int round = 0; round < 4; ++round) {
            auto const packed = PackedSog::random(3 + 50 * static_cast<std::size_t>(round), 2, degree, numbers);
            Map const expected = read(write_zip(packed.files(packing), packing, false));
            auto const with = [&](std::vector<std::array<std::string, 2>> const& changes) {
                auto files = packed.files(packing);
                for (auto const& [from, to] : changes) files["meta.json"] = replaced(files["meta.json"], from, to);
                return read(write_zip(files, packing, false));
            };
            std::string const d = std::to_string(degree), rows = std::to_string(packed.rows.size());
            for (std::string const& bands : {std::string(""), std::string("\"bands\":0,"), std::string("\"bands\":null,"), std::string("\"coeffs\":5,")}) {
                Map const map = with({{"\"bands\":" + d + ",", bands}});
                CHECK(same(map, expected));
                CHECK(notes_have(map, "the palette's width says degree " + d));
            }
            CHECK_FALSE(notes_have(expected, "the palette's width says"));
            CHECK(same(with({{"\"count\":100,\"bands\"", "\"palette_size\":100,\"bands\""}}), expected));
            CHECK(same(with({{"\"count\":100,\"bands\"", "\"bands\""}}), expected));
            CHECK(same(with({{"\"version\":2,", ""}}), expected));
            CHECK(same(with({{"\"count\":" + rows + ",", ""}, {"\"means\":{", "\"means\":{\"shape\":[" + rows + ",3],"}}), expected));
            // A map of degree 0 whose writer names the part all the same.
            auto const flat = PackedSog::random(2, 2, 0, numbers);
            auto files = flat.files(packing);
            Map const plain = read(write_zip(files, packing, false));
            auto& meta = files["meta.json"];
            meta.replace(meta.rfind('}'), 1, ",\"shN\":{\"bands\":0,\"files\":[]}}");
            CHECK(same(read(write_zip(files, packing, false)), plain));
        }
}

TEST_CASE("SOG: a first entry null of a codebook is a step below the second, as PlayCanvas' engine reads it")
{
    Numbers numbers(42);
    Packing const packing;
    for (std::size_t book = 0; book < 3; ++book)
        for (int round = 0; round < 5; ++round) {
            auto packed = PackedSog::random(40, 2, 1, numbers);
            for (auto& row : packed.rows) row.scale[0] = row.colour[1] = 0; // rows that use the entry
            for (auto& entry : packed.palette) entry[2] = 0;
            auto files = packed.files(packing);
            files["meta.json"] = replaced(files["meta.json"], "\"codebook\":[" + PackedSog::text(packed.books[book][0]) + ",", "\"codebook\":[null,");
            auto& values = packed.books[book];
            values[0] = values[1] + (values[1] - values[255]) / 255.0;
            CHECK(values[0] < values[1]);
            CHECK(same(read(write_zip(files, packing, false)), read(write_zip(packed.files(packing), packing, false))));
        }
}

TEST_CASE("a map that was trained with anti-aliasing has a note in every format that can say so")
{
    Numbers numbers(43);
    Packing const packing;
    char const* const note = "trained with anti-aliasing; --antialias (splat::Coverage::preserved) applies it";
    auto const sog = [&](std::string const& key) {
        auto files = PackedSog::random(2, 2, 0, numbers).files(packing);
        files["meta.json"] = replaced(files["meta.json"], "\"count\"", key + "\"count\"");
        return notes_have(read(write_zip(files, packing, false)), note);
    };
    CHECK(sog("\"antialias\":true,"));
    CHECK(sog("\"antialiased\":1,"));
    CHECK(sog("\"model\":\"antialiased\","));
    CHECK(sog("\"asset\":{\"generator\":\"a\",\"antialias\":true},"));
    CHECK_FALSE(sog(""));
    CHECK_FALSE(sog("\"antialias\":false,"));
    CHECK_FALSE(sog("\"model\":\"default\","));
    auto const ply = [&](Bytes const& bytes, std::string const& line) {
        return notes_have(read(replaced(bytes, "element", line + "element"), {}, "a.ply"), note);
    };
    Bytes const compressed = PackedPly::random(2, 0, true, numbers).bytes();
    for (Bytes const& bytes : {compressed, write_plain_ply({0, {PlainRow{}}})}) {
        CHECK(ply(bytes, "comment antialiased 1\n"));
        CHECK(ply(bytes, "comment SplatRenderMode: mip\r\n"));
        CHECK(ply(bytes, "comment antialiased 0\ncomment SplatRenderMode: mip\n"));
        CHECK_FALSE(ply(bytes, "comment antialiased 0\n"));
        CHECK_FALSE(ply(bytes, "comment SplatRenderMode: mip\ncomment SplatRenderMode: default\n"));
        CHECK_FALSE(ply(bytes, "comment not antialiased\n"));
    }
}

TEST_CASE("a format without its decoder is refused in a line that names the package")
{
    Numbers numbers(5);
    Packing const packing;
    auto const refused = [&](Bytes const& bytes, Codecs codecs = {}) { return error_of([&] { read(bytes, codecs); }); };
    CHECK(has(refused(PackedSpz::random(1, 3, 0, numbers).bytes(packing)), "built without zlib); install zlib1g-dev"));
    CHECK(has(refused(PackedSpz::random(1, 4, 0, numbers).bytes(packing)), "built without libzstd); install libzstd-dev"));
    auto const sog = write_zip(PackedSog::random(1, 2, 0, numbers).files(packing), packing, true);
    CHECK(has(refused(sog), "built without zlib); install zlib1g-dev"));
    Codecs only_zip = packing.codecs;
    only_zip.webp_read = nullptr;
    CHECK(has(refused(sog, only_zip), "built without libwebp); install libwebp-dev"));
}

TEST_CASE("several maps are one: ids count on behind all rows, degrees and notes are kept")
{
    Numbers numbers(6);
    auto a = PackedSplat::random(3, numbers);
    a.rows[1].mean[0] = std::numeric_limits<float>::infinity();
    auto const b = PackedPly::random(2, 2, true, numbers);
    auto const c = PackedSpz::random(2, 2, 1, numbers);
    Map const first = read(a.bytes(), {}, "a.splat"), second = read(b.bytes(), {}, "b.ply"), third = read(c.plain(), {}, "c.spz");
    Map const joined = tilemesh::scene::join_maps({first, second, third});
    REQUIRE(joined.gaussians.size() == 6);
    std::uint32_t const ids[6] = {1, 3, 4, 5, 6, 7};
    for (std::size_t i = 0; i < 6; ++i) {
        CHECK(static_cast<std::uint32_t>(joined.gaussians[i].id) == ids[i]);
        auto g = i < 2 ? first.gaussians[i] : i < 4 ? second.gaussians[i - 2] : third.gaussians[i - 4];
        g.id = joined.gaussians[i].id;
        CHECK(std::memcmp(&g, &joined.gaussians[i], sizeof g) == 0);
    }
    CHECK(joined.sh_degree == 2);
    REQUIRE(joined.harmonics.size() == 6 * 24);
    for (std::size_t i = 0; i < 6 * 24; ++i) {
        float const own = i < 48 ? 0.0f : i < 96 ? second.harmonics[i - 48] : i % 24 < 9 ? third.harmonics[(i - 96) / 24 * 9 + i % 24] : 0.0f;
        CHECK(joined.harmonics[i] == own);
    }
    CHECK(joined.rejected == 1);
    CHECK(joined.name == "a");
    CHECK(joined.path == "a.splat + b.ply + c.spz");
    CHECK(notes_have(joined, "a.splat: row 2 rejected: x is not finite"));
    CHECK(same(tilemesh::scene::join_maps({second}), second));
    CHECK(tilemesh::scene::join_maps({}).gaussians.empty());
}

TEST_CASE("a map and its SOG are the same map")
{
    auto const ply = data_file("maps/playbot_31k_sh2.ply"), sog = data_file("formats/playbot_31k.sog");
    if (ply.empty() || sog.empty()) return;
#if defined(TILEMESH_HAS_WEBP)
    Codecs const codecs = real_packing().codecs;
    Map const a = tilemesh::scene::load_map(ply), b = tilemesh::scene::load_map(sog, codecs);
    REQUIRE(b.gaussians.size() == 31000);
    CHECK(b.name == "playbot_31k");
    // The PLY was made from the SOG by its reference reader. Its opacities are logits, each rounded to float32.
    Map opaque = a;
    bool near = true;
    for (std::size_t i = 0; i < a.gaussians.size(); ++i) {
        near = near && std::fabs(a.gaussians[i].opacity - b.gaussians[i].opacity) <= 1.1e-6f;
        opaque.gaussians[i].opacity = b.gaussians[i].opacity;
    }
    CHECK(near);
    CHECK(same(opaque, b));
#else
    CHECK(has(error_of([&] { tilemesh::scene::load_map(sog); }), "libwebp-dev"));
#endif
}

TEST_CASE("the smallest files of other writers")
{
    Codecs const codecs = real_packing().codecs;
    for (char const* name : {"minimal-raw.spz", "minimal-v2.spz", "minimal-v3.spz", "minimal-v4.spz", "minimal.splat"}) {
        auto const path = data_file(std::string("formats/minimal/") + name);
        if (path.empty()) continue;
        bool const packed = std::string(name).find("-v") != std::string::npos;
#if !defined(TILEMESH_HAS_ZLIB) || !defined(TILEMESH_HAS_ZSTD)
        if (packed) continue;
#endif
        (void)packed;
        Map const map = tilemesh::scene::load_map(path, codecs);
        CAPTURE(name);
        REQUIRE(map.gaussians.size() == 4);
        for (std::size_t i = 0; i < 4; ++i) {
            auto const& g = map.gaussians[i];
            CHECK(g.mean_world[0] == (i % 2 == 0 ? -1.0f : 0.0f));
            CHECK(g.mean_world[1] == 0.0f);
            CHECK(std::fabs(g.mean_world[2]) == (i < 2 ? 1.0f : 0.0f));
            CHECK(g.opacity == static_cast<float>(230 / 255.0));
            CHECK(g.log_scale[1] == doctest::Approx(-2.3).epsilon(0.02));
        }
    }
}
