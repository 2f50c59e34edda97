#pragma once
#include "support.hpp"
#include <charconv>
#include <tilemesh/scene/ply.hpp>

// Shared by the tests of PLY files: small files, written in every format.
namespace scene_test {

inline constexpr float infinity = std::numeric_limits<float>::infinity();
inline constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

/// The fields of a row in the order that the 3DGS training writes them, without normals.
struct Row {
    double f[14] = {1, 2, 3, 0.5, -0.25, 4, 0, -1, -2, -3, 2, 0, 0, 0};
};
inline constexpr char const* names[14] = {"x",       "y",       "z",       "f_dc_0", "f_dc_1", "f_dc_2", "opacity",
                                          "scale_0", "scale_1", "scale_2", "rot_0",  "rot_1",  "rot_2",  "rot_3"};

inline constexpr char const* little = "binary_little_endian";
inline constexpr char const* big = "binary_big_endian";
inline constexpr char const* ascii = "ascii";

/// Appends a number in the format of the body; in ASCII exactly, and with a blank after it.
template <class T>
void put(std::string& bytes, T value, std::string const& format = little)
{
    if (format == ascii) {
        char text[64];
        auto const end = sizeof value == 1 ? std::to_chars(text, text + 64, static_cast<int>(value)).ptr : std::to_chars(text, text + 64, value).ptr;
        bytes.append(text, end).append(1, ' ');
        return;
    }
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    std::uint16_t const one = 1;
    bool const host_is_big = reinterpret_cast<unsigned char const*>(&one)[0] == 0;
    if ((format == big) != host_is_big) std::reverse(raw, raw + sizeof value);
    bytes.append(raw, sizeof value);
}

/// The content of a file. The defaults are a plain map.
struct Ply {
    std::vector<Row> rows{Row{}};
    std::vector<int> order{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13};
    std::string format = little;
    bool doubles = false;
    bool lists = false; ///< in each row, as the third property: as many short as the row's index
    int rest = 0;       ///< columns f_rest_*, in the middle
    bool rest_counts = false; ///< column f_rest_i of a row is i + 1 + 100 rows; else not a number
    std::string count;  ///< instead of the number of rows
    std::string line_end = "\n";
    std::string elements_before, elements_after, bytes_before, bytes_after;

    std::string header() const
    {
        std::string out = "ply\nformat " + format + " 1.0\ncomment a test\n" + elements_before + "element vertex " +
                          (count.empty() ? std::to_string(rows.size()) : count) + "\n";
        for (std::size_t k = 0; k < order.size(); ++k) {
            if (k == 3)
                for (int i = 0; i < rest; ++i) out += "property float f_rest_" + std::to_string(i) + "\n";
            if (k == 2 && lists) out += "property list uchar short history\n";
            out += std::string("property ") + (doubles ? "double " : "float ") + names[order[k]] + "\n";
        }
        return with_line_ends(out + elements_after + "end_header\n");
    }
    std::string row(std::size_t index) const
    {
        std::string out;
        for (std::size_t k = 0; k < order.size(); ++k) {
            if (k == 3)
                for (int i = 0; i < rest; ++i)
                    put(out, rest_counts ? static_cast<float>(i + 1) + 100.0f * static_cast<float>(index) : static_cast<float>(not_a_number), format);
            if (k == 2 && lists) {
                put(out, static_cast<std::uint8_t>(index), format);
                for (std::size_t i = 0; i < index; ++i) put(out, static_cast<std::int16_t>(-7), format);
            }
            double const value = rows[index].f[order[k]];
            if (doubles) put(out, value, format);
            else put(out, static_cast<float>(value), format);
        }
        if (format == ascii) out.back() = '\n';
        return format == ascii ? with_line_ends(out) : out;
    }
    std::string bytes() const
    {
        std::string out = header() + bytes_before;
        for (std::size_t i = 0; i < rows.size(); ++i) out += row(i);
        return out + bytes_after;
    }

private:
    std::string with_line_ends(std::string const& text) const
    {
        std::string out;
        for (char c : text) {
            if (c == '\n') out += line_end;
            else out += c;
        }
        return out;
    }
};

/// Rows that differ in every field, with numbers that a float holds.
inline Ply several(std::size_t rows)
{
    Ply ply;
    ply.rows.resize(rows);
    for (std::size_t i = 0; i < rows; ++i)
        for (int k = 0; k < 14; ++k) ply.rows[i].f[k] = 0.25 * static_cast<double>(i) + 0.125 * k;
    return ply;
}

/// Plain maps and maps with lists inside, before and after the rows.
inline std::vector<Ply> variants(std::string const& format)
{
    Ply const plain = several(3);
    Ply inside = plain;
    inside.lists = true;
    Ply around = plain;
    around.elements_before = "element nothing 9223372036854775808\nelement path 2\nproperty list uchar double way\n"
                             "property uchar last\n";
    around.elements_after = "element face 2\nproperty uchar first\nproperty list int int corners\n";
    std::vector<Ply> all{plain, inside, around};
    for (Ply& ply : all) ply.format = format;
    auto& before = all[2].bytes_before;
    auto& after = all[2].bytes_after;
    auto const end_line = [&](std::string& text) {
        if (format == ascii) text.back() = '\n';
    };
    for (std::uint8_t items : {std::uint8_t{0}, std::uint8_t{2}}) {
        put(before, items, format);
        for (int i = 0; i < items; ++i) put(before, 1.5 * i, format);
        put(before, std::uint8_t{10}, format);
        end_line(before);
        put(after, std::uint8_t{10}, format);
        put(after, std::int32_t{items}, format);
        for (int i = 0; i < items; ++i) put(after, i, format);
        end_line(after);
    }
    return all;
}

inline tilemesh::scene::Map read(std::string const& bytes, std::string const& name = "test.ply")
{
    std::istringstream stream(bytes);
    return tilemesh::scene::read_ply(stream, name);
}
inline tilemesh::scene::Map read(Ply const& ply)
{
    return read(ply.bytes());
}
inline std::string refusal(std::string const& bytes, std::string const& name = "test.ply")
{
    return error_of([&] { read(bytes, name); });
}
inline std::string refusal(Ply const& ply)
{
    return refusal(ply.bytes());
}

inline bool same_records(tilemesh::scene::Map const& a, tilemesh::scene::Map const& b)
{
    return a.gaussians.size() == b.gaussians.size() &&
           (a.gaussians.empty() || std::memcmp(a.gaussians.data(), b.gaussians.data(), a.gaussians.size() * 60) == 0);
}

} // namespace scene_test
