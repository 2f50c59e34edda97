// test: unoptimised test asan tsan
#include "ply_writer.hpp"
#include "support.hpp"
#include <tilemesh/scene/records.hpp>

using namespace scene_test;

namespace {

/// An ASCII map of one row, its words as given.
std::string ascii_row(std::string const& row)
{
    Ply ply;
    ply.format = ascii;
    return ply.header() + row + "\n";
}
std::string const plain_row = "1 2 3 0.5 -0.25 4 0 -1 -2 -3 2 0 0 0";

} // namespace

TEST_CASE("every format gives the same records, with lists before, in and after the rows, with columns in any order, and with CR LF")
{
    auto const expected = read(several(3));
    REQUIRE(expected.gaussians.size() == 3);
    for (char const* format : {little, big, ascii})
        for (Ply ply : variants(format))
            for (bool const doubles : {false, true})
                for (char const* line_end : {"\n", "\r\n"}) {
                    CAPTURE(format);
                    CAPTURE(ply.lists);
                    CAPTURE(doubles);
                    ply.doubles = doubles;
                    ply.line_end = line_end;
                    auto const map = read(ply);
                    CHECK(same_records(map, expected));
                    CHECK(map.rejected == 0);
                    CHECK(map.notes.size() == (ply.lists ? 1u : ply.elements_after.empty() ? 0u : 3u));
                    auto reordered = ply;
                    std::reverse(reordered.order.begin(), reordered.order.end());
                    CHECK(same_records(read(reordered), expected));
                    std::rotate(reordered.order.begin(), reordered.order.begin() + 5, reordered.order.end());
                    CHECK(same_records(read(reordered), expected));
                }
    auto other = several(3);
    other.rows[2].f[9] += 0.5;
    CHECK_FALSE(same_records(read(other), expected));
}

TEST_CASE("integers of every type, signed or not, in both orders and both spellings; their file has CR LF")
{
    for (char const* order : {little, big}) {
        CAPTURE(order);
        std::string bytes = std::string("ply\r\nformat ") + order + " 1.0\r\nelement vertex 1\r\nproperty char x\r\nproperty uint8 y\r\n" +
                            "property short z\r\nproperty ushort f_dc_0\r\nproperty int f_dc_1\r\nproperty uint32 f_dc_2\r\n" +
                            "property float64 opacity\r\nproperty float32 scale_0\r\nproperty int8 scale_1\r\nproperty uchar scale_2\r\n" +
                            "property uint16 rot_0\r\nproperty int16 rot_1\r\nproperty int32 rot_2\r\nproperty uint rot_3\r\nend_header\r\n";
        auto const put_all = [&](auto... values) { (put(bytes, values, order), ...); };
        put_all(std::int8_t{-1}, std::uint8_t{255}, std::int16_t{-300}, std::uint16_t{65535}, std::int32_t{-2}, std::uint32_t{4000000000u}, 2.0);
        put_all(-1.5f, std::int8_t{-3}, std::uint8_t{2}, std::uint16_t{0}, std::int16_t{0}, std::int32_t{-1}, std::uint32_t{0});
        auto const map = read(bytes);
        REQUIRE(map.gaussians.size() == 1);
        auto const& g = map.gaussians[0];
        CHECK(g.mean_world[0] == -1.0f);
        CHECK(g.mean_world[1] == 255.0f);
        CHECK(g.mean_world[2] == -300.0f);
        CHECK(g.colour[0] == doctest::Approx(0.28209479 * 65535 + 0.5));
        CHECK(g.colour[1] == 0.0f);
        CHECK(g.colour[2] == doctest::Approx(0.28209479 * 4e9));
        CHECK(g.opacity == doctest::Approx(0.880797078));
        CHECK(g.log_scale[0] == -1.5f);
        CHECK(g.log_scale[1] == -3.0f);
        CHECK(g.log_scale[2] == 2.0f);
        CHECK(g.rotation[2] == -1.0f);
    }
}

TEST_CASE("ASCII numbers: signs, exponents, words, and texts that are not numbers")
{
    auto const x = [](std::string const& word) { return read(ascii_row(word + plain_row.substr(1))); };
    for (auto const& example : {std::pair{"+1.5", 1.5f}, {"-1.5", -1.5f}, {"1e2", 100.0f}, {"+.5E+1", 5.0f}, {"5.", 5.0f}, {"1e-400", 0.0f},
                                {"3.4028235e38", 3.40282347e38f}, {"-0", 0.0f}}) {
        CAPTURE(example.first);
        auto const map = x(example.first);
        REQUIRE(map.gaussians.size() == 1);
        CHECK(map.gaussians[0].mean_world[0] == example.second);
    }
    for (char const* word : {"nan", "NaN", "-nan", "nan(ind)", "inf", "+inf", "-Infinity", "1e39", "1e400", "-1e400"}) {
        CAPTURE(word);
        auto const map = x(word);
        CHECK(map.rejected == 1);
        CHECK(has(map.notes.at(0), "row 1 rejected: x is not finite"));
    }
    for (char const* word : {"0x10", "1,5", "abc", "1.5f", "+-1", "++1", "+", "-", "1e", "1.#INF", "\x01", "\"1\""}) {
        CAPTURE(word);
        CHECK(has(refusal(ascii_row(word + plain_row.substr(1))), "is not a number"));
    }
    CHECK(has(refusal(ascii_row(std::string("1\0", 2) + plain_row.substr(1))), "\"1?\" is not a number"));
    CHECK(has(refusal(ascii_row(std::string(513, '1') + plain_row.substr(1))), "more than 512 characters"));
    // Large by its digits, but small by the exponent's sign, or the reverse.
    CHECK(x("1" + std::string(400, '0') + "e-80").rejected == 1);
    CHECK(x("0." + std::string(400, '0') + "1e30").gaussians.at(0).mean_world[0] == 0.0f);
    CHECK(x("0." + std::string(400, '0') + "1").gaussians.at(0).mean_world[0] == 0.0f);
    CHECK(x(std::string(509, '0') + "1.5").gaussians.at(0).mean_world[0] == 1.5f);

    auto const opacity = [](std::string const& word) { return read(ascii_row("1 2 3 0 0 0 " + word + " -1e400 -2 -3 2 0 0 0")).gaussians.at(0); };
    CHECK(opacity("-1e400").opacity == 0.0f);
    CHECK(opacity("1e400").opacity == 1.0f);
    CHECK(opacity("-inf").opacity == 0.0f);
    CHECK(opacity("0").log_scale[0] == -87.0f);
}

TEST_CASE("ASCII rows are lines: blank ones are passed, short and long ones refused by row and line")
{
    Ply ply = several(3);
    ply.format = ascii;
    auto const expected = read(several(3));
    auto const head = ply.header();
    CHECK(same_records(read(head + "\n \t\r\n" + ply.row(0) + "\n\n" + ply.row(1) + "  " + ply.row(2) + "\n \n"), expected));
    CHECK(read(head + ply.row(0) + ply.row(1) + ply.row(2) + "\n \n").notes.empty());

    // The header has 19 lines.
    auto cut = ply.row(1);
    cut.erase(cut.rfind(' '));
    CHECK(has(refusal(head + ply.row(0) + "\n" + cut + "\n" + ply.row(2)), "line 22, row 2 of element \"vertex\": fewer numbers"));
    auto longer = ply.row(1);
    longer.back() = ' ';
    CHECK(has(refusal(head + ply.row(0) + longer + "0\n" + ply.row(2)), "line 21, row 2 of element \"vertex\": more numbers"));
    CHECK(has(refusal(head + ply.row(0) + longer + ply.row(2)), "more numbers"));
    CHECK(has(refusal(head + ply.row(0) + longer), "ends inside row 3"));

    // Without the last line end the last number may be cut off. Text after the last row is skipped.
    auto whole = ply.bytes();
    whole.pop_back();
    auto map = read(whole);
    CHECK(same_records(map, expected));
    CHECK(has(map.notes.at(0), "the last line has no end"));
    map = read(ply.bytes() + "\n1 2 3\n");
    CHECK(same_records(map, expected));
    CHECK(has(map.notes.at(0), "6 bytes after the last row"));
}

TEST_CASE("no rows are an empty map, and the note says so")
{
    for (char const* format : {little, big, ascii}) {
        Ply ply;
        ply.format = format;
        ply.rows.clear();
        auto const map = read(ply);
        CHECK(map.gaussians.empty());
        CHECK(map.rejected == 0);
        REQUIRE(map.notes.size() == 1);
        CHECK(has(map.notes[0], "no rows: the map is empty"));
    }
}

TEST_CASE("elements without properties have no bytes, for any number of rows")
{
    for (char const* format : {little, big, ascii}) {
        Ply ply = several(2);
        ply.format = format;
        ply.elements_before = "element a 9223372036854775808\nelement b 18446744073709551615\n";
        ply.elements_after = "element c 18446744073709551615\n";
        CHECK(same_records(read(ply), read(several(2))));
    }
}

TEST_CASE("lists: counts below zero, too large, of no integer type")
{
    Ply ply;
    auto const head = [&](std::string const& format, std::string const& types) {
        ply.format = format;
        ply.elements_before = "element face 1\nproperty list " + types + " corners\n";
        return ply.header();
    };
    for (char const* format : {little, big}) {
        auto const with = [&](std::string const& types, auto count) {
            std::string bytes = head(format, types);
            put(bytes, count, format);
            return bytes + ply.row(0);
        };
        CHECK(has(refusal(with("char int", std::int8_t{-1})), "a list of -1 items (row 1 of element \"face\")"));
        CHECK(has(refusal(with("int uchar", std::int32_t{-2147483647 - 1})), "a list of -2147483648 items"));
        CHECK(has(refusal(with("uint double", std::uint32_t{0xffffffffu})), "ends inside row 1 of element \"face\""));
        CHECK(has(refusal(with("short int", std::int16_t{15})), "ends inside row 1 of element \"face\""));
        CHECK(has(refusal(with("short int", std::int16_t{14})), "ends inside row 1 of element \"vertex\""));
        CHECK(read(with("ushort int", std::uint16_t{0})).gaussians.size() == 1);
    }
    for (char const* count : {"-1", "1.0", "+1", "x", "18446744073709551616"})
        CHECK(has(refusal(head(ascii, "int int") + count + " 5\n" + ply.row(0)), std::string("a list of \"") + count));
    CHECK(has(refusal(head(ascii, "int int") + "18446744073709551615 5\n" + ply.row(0)), "fewer numbers"));
    CHECK(has(refusal(head(ascii, "int int") + "1 5 6\n" + ply.row(0)), "line 22, row 1 of element \"face\": more numbers"));
    CHECK(read(head(ascii, "int int") + "1 5\n" + ply.row(0)).gaussians.size() == 1);
    CHECK(has(refusal(head(little, "float int")), "no integer type"));
    CHECK(has(refusal(head(little, "double int")), "no integer type"));
    CHECK(has(refusal(head(little, "int")), "a list needs"));
    CHECK(has(refusal(head(little, "int quad")), "unknown type \"quad\""));
    CHECK(has(refusal(head(little, "int list")), "unknown type \"list\""));

    Ply x;
    x.order.erase(x.order.begin());
    x.elements_after = "property list uchar float x\n";
    CHECK(has(refusal(x), "a list as property x"));
}

TEST_CASE("view-dependent colour: every degree up to 3 is read, channel by channel, in every format")
{
    for (auto const& [columns, degree] : {std::pair{0, 0u}, std::pair{9, 1u}, std::pair{24, 2u}, std::pair{45, 3u}})
        for (char const* format : {little, big, ascii}) {
            Ply ply = several(3);
            ply.rest = columns;
            ply.rest_counts = true;
            ply.format = format;
            auto const map = read(ply);
            CHECK(map.notes.empty());
            CHECK(map.sh_degree == degree);
            REQUIRE(map.harmonics.size() == 3 * static_cast<std::size_t>(columns));
            auto const per_channel = static_cast<std::size_t>(columns) / 3;
            for (std::size_t row = 0; row < 3; ++row)
                for (std::size_t k = 0; k < per_channel; ++k)
                    for (std::size_t c = 0; c < 3; ++c)
                        CHECK(map.harmonics[row * 3 * per_channel + 3 * k + c] == static_cast<float>(c * per_channel + k + 1 + 100 * row));
            CHECK(same_records(tilemesh::scene::at_degree(map, 0), read(several(3))));
        }
}

TEST_CASE("view-dependent colour: the part of degree 0 is clamped only if no harmonics are added to it")
{
    Ply ply;
    ply.rows[0].f[3] = -10;
    CHECK(read(ply).gaussians[0].colour[0] == 0);
    ply.rest = 9;
    ply.rest_counts = true;
    CHECK(read(ply).gaussians[0].colour[0] == doctest::Approx(0.5 - 2.8209479));
    CHECK(tilemesh::scene::at_degree(read(ply), 0).gaussians[0].colour[0] == 0);
}

TEST_CASE("view-dependent colour: a number of columns without a degree is skipped and named; a degree above 3 is read up to 3; bad rows are rejected")
{
    for (int const columns : {1, 44})
        for (char const* format : {little, big, ascii}) {
            Ply ply = several(2);
            ply.rest = columns;
            ply.format = format;
            auto const map = read(ply);
            CHECK(same_records(map, read(several(2))));
            REQUIRE(map.notes.size() == 1);
            CHECK(map.notes[0] == std::to_string(columns) + " columns f_rest_* skipped (they fit no degree of view-dependent colour: 9, 24, 45)");
            CHECK(map.harmonics.empty());
        }
    Ply ply = several(2);
    ply.rest = 72;
    ply.rest_counts = true;
    auto const map = read(ply);
    CHECK(map.sh_degree == 3);
    REQUIRE(map.notes.size() == 1);
    CHECK(map.notes[0] == "view-dependent colour of degree 4 (72 columns f_rest_*) read up to degree 3");
    REQUIRE(map.harmonics.size() == 90);
    CHECK(map.harmonics[1] == 25.0f); // green's first coefficient: 24 columns a channel
    CHECK(map.harmonics[42] == 15.0f);

    ply.rest = 9;
    ply.rest_counts = false;
    auto const none = read(ply);
    CHECK(none.rejected == 2);
    CHECK(none.gaussians.empty());
    CHECK(none.harmonics.empty());
    CHECK(has(none.notes[0], "row 1 rejected: f_rest_0 is not finite"));
}

TEST_CASE("other columns are named, at most ten of them; other elements are skipped, and each has a note")
{
    Ply ply;
    for (int i = 0; i < 12; ++i) {
        ply.elements_after += "property uchar extra_" + std::to_string(i) + "\n";
        ply.bytes_after += '\x01';
    }
    auto map = read(ply);
    REQUIRE(map.notes.size() == 1);
    CHECK(has(map.notes[0], "columns skipped: extra_0, extra_1, "));
    CHECK(has(map.notes[0], "extra_9 and 2 more"));

    ply = {};
    ply.elements_before = "element frame 3\nproperty uchar a\nproperty double b\n";
    ply.bytes_before = std::string(3 * 9, '\x7f');
    ply.elements_after = "element camera 2\nproperty int c\n";
    ply.bytes_after = std::string(2 * 4, '\x7f');
    map = read(ply);
    CHECK(same_records(map, read(Ply{})));
    REQUIRE(map.notes.size() == 2);
    CHECK(has(map.notes[0], "\"frame\": 3 rows skipped"));
    CHECK(has(map.notes[1], "\"camera\": 2 rows skipped"));
    ply.bytes_after.pop_back();
    CHECK(has(refusal(ply), "row 2 of element \"camera\""));
}
