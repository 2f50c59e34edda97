// test: unoptimised test asan, without tsan
// A PLY map in parts: the parts together have the rows, the notes and the ids of the whole map.
#include "ply_writer.hpp"
#include "support.hpp"

using namespace scene_test;
using tilemesh::scene::Map;
using tilemesh::scene::MapPart;

namespace {

std::optional<MapPart> part_of(std::string const& bytes, std::uint64_t part, std::uint64_t parts)
{
    std::istringstream stream(bytes);
    return tilemesh::scene::read_ply_part(stream, "test.ply", part, parts);
}
/// The parts of a map, joined as processes join them.
Map joined(std::string const& bytes, std::uint64_t parts)
{
    auto all = part_of(bytes, 0, parts).value();
    for (std::uint64_t p = 1; p < parts; ++p) {
        auto const next = part_of(bytes, p, parts).value();
        CHECK(next.map.name == all.map.name);
        CHECK(next.map.sh_degree == all.map.sh_degree);
        CHECK(next.map.notes == all.map.notes);
        CHECK(next.last_notes == all.last_notes);
        all.map.gaussians.insert(all.map.gaussians.end(), next.map.gaussians.begin(), next.map.gaussians.end());
        all.map.harmonics.insert(all.map.harmonics.end(), next.map.harmonics.begin(), next.map.harmonics.end());
        all.map.rejected += next.map.rejected;
        all.rejected.insert(all.rejected.end(), next.rejected.begin(), next.rejected.end());
    }
    return with_all_notes(std::move(all));
}
template <class T>
bool same_words(std::vector<T> const& a, std::vector<T> const& b)
{
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}
/// Checks the joined parts for every number of parts, also more parts than rows.
void check(Ply const& ply)
{
    auto const bytes = ply.bytes();
    auto const whole = read(bytes);
    for (std::uint64_t const parts : {1u, 2u, 3u, 5u, 40u}) {
        CAPTURE(parts);
        auto const map = joined(bytes, parts);
        CHECK(same_words(map.gaussians, whole.gaussians));
        CHECK(same_words(map.harmonics, whole.harmonics));
        CHECK(map.notes == whole.notes);
        CHECK(map.rejected == whole.rejected);
        CHECK(map.sh_degree == whole.sh_degree);
        CHECK(map.name == whole.name);
        CHECK(map.path == whole.path);
    }
}

} // namespace

TEST_CASE("parts: every format, harmonics, lists, other elements, rejected rows, bytes at the end")
{
    for (auto const* const format : {little, big, ascii})
        for (bool const lists : {false, true}) {
            CAPTURE(format);
            CAPTURE(lists);
            auto ply = several(23);
            ply.format = format;
            ply.lists = lists;
            check(ply);
            ply.rest = 9;
            ply.rest_counts = true;
            for (std::size_t const row : {2u, 3u, 9u, 10u, 11u, 15u, 22u}) ply.rows[row].f[1] = static_cast<double>(infinity);
            if (std::string(format) != ascii) {
                ply.elements_before = "element face 3\nproperty int a\n";
                ply.bytes_before = std::string(12, 'x');
                ply.bytes_after = "more";
            }
            check(ply);
        }
}

TEST_CASE("parts: a short body is refused by every part; a bad line of ASCII too")
{
    auto ply = several(9);
    auto const bytes = ply.bytes();
    for (std::uint64_t p = 0; p < 3; ++p) {
        auto const text = error_of([&] { part_of(bytes.substr(0, bytes.size() - 3), p, 3); });
        CHECK(text == error_of([&] { read(bytes.substr(0, bytes.size() - 3)); }));
        CHECK(text.find("ends inside row 9") != std::string::npos);
    }
    ply.format = ascii;
    auto lines = ply.bytes();
    lines.insert(lines.rfind('\n', lines.size() - 2) + 1, "x ");
    for (std::uint64_t p = 0; p < 3; ++p) CHECK(error_of([&] { part_of(lines, p, 3); }) == error_of([&] { read(lines); }));
}

TEST_CASE("parts: other files are not read in parts")
{
    CHECK_FALSE(part_of("NGSP and more", 0, 2));
    CHECK_FALSE(part_of("", 0, 2));
    CHECK_FALSE(part_of("ply\nformat binary_little_endian 1.0\nelement chunk 1\nproperty float min_x\nelement vertex 1\nproperty uint packed_position\n"
                        "end_header\n" + std::string(8, '\0'),
                        0, 2));
}
