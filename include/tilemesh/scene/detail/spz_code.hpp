#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/bytes.hpp>
#include <tilemesh/scene/detail/map_sink.hpp>
#include <tilemesh/scene/detail/packed_input.hpp>
#include <tilemesh/scene/detail/ply_gaussian.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/scene/spz.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <utility>

TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace scene {

namespace detail {

/// The header of an SPZ file: 16 bytes, in version 4 32 bytes.
struct SpzHeader {
    static constexpr std::size_t bytes = 16, bytes_v4 = 32;
    std::uint32_t version, rows, degree, fractional_bits, flags;
    std::uint32_t streams, table_at; ///< version 4 only

    /// The bytes of a row of each attribute, in the order of the file: mean, opacity, colour, scales, rotation, harmonics.
    std::array<std::uint32_t, 6> row_bytes() const
    {
        return {version == 1 ? 6u : 9u, 1, 3, 3, version >= 3 ? 4u : 3u, 3 * splat::harmonics_per_channel(degree)};
    }
};

/// Throws `Error` for what is not a header. `in` has at least 16 bytes.
inline SpzHeader read_spz_header(ByteView in, std::string const& file)
{
    auto const word = [&](std::size_t at) { return number_at<std::uint32_t>(in.data() + at); };
    SpzHeader header{word(4), word(8), in[12], in[13], in[14], in[15], 0};
    auto const refuse = [&](std::string const& what, char const* why) {
        throw Error(file + " is an SPZ map " + what + " (" + why + "); export the map again");
    };
    if (header.version < 1 || header.version > 4) refuse("of version " + std::to_string(header.version), "versions 1 to 4 are read");
    if (header.degree > 4) refuse("of degree " + std::to_string(header.degree), "harmonics have degree 0 to 4");
    // 1 << 24 in a float of 24 bits is the last that makes sense; a mean has 24 bits.
    if (header.version != 1 && header.fractional_bits > 24)
        refuse("with " + std::to_string(header.fractional_bits) + " fractional bits", "a mean has 24 bits");
    return header;
}

/// The bytes of extensions that are read behind the rows of versions 1 to 3. Those that are known have 20 at most.
inline constexpr std::size_t most_spz_extensions = 65536;

/// The directions of the axes x, y, z of an SPZ map. Every one is right or left; the second is up or down and the third front or back, or, if
/// `swapped`, the second is front or back and the third up or down.
struct SpzAxes {
    bool said = false, right = true, up = true, front = false, swapped = false;

    std::string text() const
    {
        std::string const vertical = up ? "up" : "down", along = front ? "front" : "back";
        return std::string(right ? "right " : "left ") + (swapped ? along + " " + vertical : vertical + " " + along);
    }
};

/// Reads extensions: for each one its type, its length (32 bits each) and its bytes (Niantic's spz, extensions/README.md). Of them,
/// SPZ_ADOBE_coordinate_system, 0xADBE0003, is applied: a number from 1 (left down back) to 16, whose bits, less 1, are right, up, front, and
/// y and z turned by a quarter about x; 0 says nothing. `skipped` counts all others, and one that is cut off. Throws `Error` for another value.
inline SpzAxes read_spz_extensions(ByteView in, std::string const& file, std::size_t& skipped)
{
    SpzAxes axes;
    for (std::size_t at = 0; at < in.size();) {
        std::uint32_t const bytes = in.size() - at < 8 ? 0xffffffffu : number_at<std::uint32_t>(in.data() + at + 4);
        if (in.size() - at < std::uint64_t{8} + bytes) {
            ++skipped;
            break;
        }
        auto const type = number_at<std::uint32_t>(in.data() + at);
        at += 8;
        if (type == 0xadbe0003u) {
            auto const system = bytes == 4 ? number_at<std::uint32_t>(in.data() + at) : 17u;
            if (system > 16)
                throw Error(file + " cannot be read (an extension names a coordinate system that is none of the 16 of SPZ); export the map again");
            std::uint32_t const bits = system == 0 ? 3u : system - 1;
            axes = {system != 0, (bits & 1u) != 0, (bits & 2u) != 0, ((bits & 4u) != 0) != (bits > 7u), bits > 7u};
        } else {
            ++skipped;
        }
        at += bytes;
    }
    return axes;
}

/// A number of 16 bits (IEEE 754 binary16) as a float.
inline float half_to_float(std::uint32_t half)
{
    std::uint32_t const sign = (half & 0x8000u) << 16, exponent = half >> 10 & 31u, fraction = half & 0x3ffu;
    if (exponent == 31) return __builtin_bit_cast(float, sign | 0x7f800000u | fraction << 13);
    if (exponent != 0) return __builtin_bit_cast(float, sign | (exponent + 112) << 23 | fraction << 13);
    float const tiny = static_cast<float>(fraction) * 0x1p-24f; // a subnormal number of 16 bits
    return sign != 0 ? -tiny : tiny;
}

/// Turns the packed rows into records. `parts` are the attributes, each complete.
inline void unpack_spz(SpzHeader const& header, SpzAxes const& axes, std::array<ByteView, 6> const& parts, Map& map)
{
    auto const [means, opacities, colours, scales, rotations, harmonics] = parts;
    MapSink sink(map, header.rows, splat::harmonics_per_channel(header.degree));
    // Changes of sign to x right, y down, z forward: of a vector, of a rotation's x, y, z (as an axial vector), and of the harmonics, which are
    // odd or even in x, y and z. Swapped axes have y forward and z up after it.
    double const x = axes.right ? 1 : -1, y = (axes.swapped ? axes.front : !axes.up) ? 1 : -1, z = (axes.swapped ? axes.up : axes.front) ? 1 : -1;
    std::array<double, 3> const turn{x, y, z}, turn_axis{y * z, x * z, x * y};
    std::array<double, 15> const turn_harmonics{y, z, x, x * y, y * z, 1, x * z, 1, y, x * y * z, y, z, x, z, x};
    float const unit = header.version == 1 ? 1.0f : 1.0f / static_cast<float>(1u << header.fractional_bits);
    GaussianRow row{};
    for (std::size_t r = 0; r < header.rows; ++r) {
        for (std::size_t i = 0; i < 3; ++i) {
            float mean = 0.0f;
            if (header.version == 1) {
                mean = half_to_float(number_at<std::uint16_t>(means.data() + 6 * r + 2 * i));
            } else {
                auto const* const bytes = means.data() + 9 * r + 3 * i;
                std::uint32_t const bits = number_at<std::uint16_t>(bytes) | std::uint32_t{bytes[2]} << 16;
                mean = static_cast<float>(static_cast<std::int32_t>(bits ^ 0x800000u) - 0x800000) * unit;
            }
            row[i] = turn[i] * static_cast<double>(mean);
            row[3 + i] = static_cast<double>((static_cast<float>(colours[3 * r + i]) / 255.0f - 0.5f) / 0.15f);
            row[7 + i] = static_cast<double>(static_cast<float>(scales[3 * r + i]) / 16.0f - 10.0f);
        }
        row[6] = 0.0;
        // x, y, z, w
        std::array<float, 4> q{};
        float squares = 0.0f;
        if (header.version >= 3) {
            auto word = number_at<std::uint32_t>(rotations.data() + 4 * r);
            std::uint32_t const largest = word >> 30;
            for (std::uint32_t i = 4; i-- > 0;) {
                if (i == largest) continue;
                float const size = 0.70710678f * static_cast<float>(word & 511u) / 511.0f; // of 9 bits, up to 1/sqrt(2)
                q[i] = (word >> 9 & 1u) != 0 ? -size : size;
                squares += q[i] * q[i];
                word >>= 10;
            }
            q[largest] = std::sqrt(1.0f - squares); // not a number where no rotation has these three
        } else {
            for (std::size_t i = 0; i < 3; ++i) {
                q[i] = static_cast<float>(rotations[3 * r + i]) * (1.0f / 127.5f) + -1.0f;
                squares += q[i] * q[i];
            }
            q[3] = std::sqrt(std::fmax(0.0f, 1.0f - squares));
        }
        row[10] = static_cast<double>(q[3]);
        for (std::size_t i = 0; i < 3; ++i) row[11 + i] = turn_axis[i] * static_cast<double>(q[i]);
        std::size_t const per_row = 3 * std::size_t{splat::harmonics_per_channel(header.degree)};
        for (std::size_t i = 0; i < sink.coefficients(); ++i)
            row[14 + i] = turn_harmonics[i / 3] * ((static_cast<double>(harmonics[r * per_row + i]) - 128.0) / 128.0);
        if (auto* const g = sink.add(r + 1, row)) g->opacity = static_cast<float>(opacities[r]) / 255.0f;
    }
    sink.finish();
}

/// Splits the decompressed body of versions 1 to 3 into its attributes. Throws `Error` if it is too short.
inline std::array<ByteView, 6> split_spz(SpzHeader const& header, ByteView body, std::string const& file)
{
    std::array<ByteView, 6> parts;
    std::size_t at = 0, i = 0;
    for (std::uint32_t const bytes : header.row_bytes()) {
        std::size_t const n = std::size_t{bytes} * header.rows;
        if (body.size() - at < n)
            throw Error(file + " ends inside its attribute " + std::to_string(i + 1) + " of 6 (the header promises " +
                        std::to_string(header.rows) + " Gaussians); copy or export the map again");
        parts[i++] = body.subspan(at, n);
        at += n;
    }
    return parts;
}

/// Decompresses the streams of version 4 into `body`, one attribute after the other. Throws `Error` for a table that does not fit the header
/// or the file, and for a damaged stream.
inline void decompress_spz_v4(SpzHeader const& header, ByteView in, Codecs const& codecs, Bytes& body, std::string const& file)
{
    auto const refuse = [&](std::string const& why) { throw Error(file + " cannot be read (" + why + "); copy or export the map again"); };
    auto const row_bytes = header.row_bytes();
    // An attribute without bytes has no stream.
    auto const streams =
        static_cast<std::uint32_t>(std::count_if(row_bytes.begin(), row_bytes.end(), [&](std::uint32_t n) { return n != 0 && header.rows != 0; }));
    if (header.streams != streams) refuse("it has " + std::to_string(header.streams) + " streams, and its Gaussians need " + std::to_string(streams));
    std::size_t const table = header.table_at;
    if (table < SpzHeader::bytes_v4 || table > in.size() || in.size() - table < 16 * std::size_t{streams})
        refuse("its table of streams is not inside the file");
    std::size_t from = table + 16 * std::size_t{streams}, to = 0;
    for (std::size_t i = 0; i < streams; ++i) {
        auto const* const entry = in.data() + table + 16 * i;
        auto const packed = number_at<std::uint64_t>(entry), bytes = number_at<std::uint64_t>(entry + 8);
        std::uint64_t const wanted = std::uint64_t{row_bytes[i]} * header.rows;
        auto const which = "stream " + std::to_string(i + 1);
        if (bytes != wanted) refuse(which + " has " + std::to_string(bytes) + " bytes, and its Gaussians have " + std::to_string(wanted));
        if (packed > in.size() - from) refuse(which + " is cut off");
        auto const target = std::span(body).subspan(to, static_cast<std::size_t>(wanted));
        auto const result = codecs.zstd(in.subspan(from, static_cast<std::size_t>(packed)), target);
        if (result.damaged || !result.ended || result.bytes != wanted) refuse(which + " is damaged");
        from += static_cast<std::size_t>(packed);
        to += static_cast<std::size_t>(wanted);
    }
}

} // namespace detail

TILEMESH_HOST Map read_spz(std::istream& stream, std::string const& name, Codecs const& codecs)
{
    using namespace detail;
    std::string const file = shown(name, name.size());
    ByteSource source(stream, file);
    Bytes in = read_rest(source);
    std::uint64_t const file_bytes = in.size();
    auto const refuse = [&](std::string const& why) { throw Error(file + " cannot be read (" + why + "); copy or export the map again"); };
    bool const gzipped = in.size() >= 2 && in[0] == 0x1f && in[1] == 0x8b;
    Bytes begin(in.begin(), in.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(in.size(), SpzHeader::bytes)));
    if (gzipped) {
        if (!codecs.gzip) refuse_without(file, "is compressed by gzip, as SPZ maps are", "zlib", "zlib1g-dev");
        begin.resize(SpzHeader::bytes);
        auto const result = codecs.gzip(in, begin);
        if (result.damaged) refuse("its gzip stream is damaged");
        begin.resize(result.bytes);
    }
    if (begin.size() < SpzHeader::bytes || std::memcmp(begin.data(), "NGSP", 4) != 0)
        throw Error(file + " is not an SPZ map (" + (gzipped ? "what gzip compressed in it" : "it") +
                    " does not begin with a header NGSP of 16 bytes); unpack it if it is a PLY, or name a 3DGS map");
    SpzHeader header = read_spz_header(begin, file);
    if (header.version == 4 && gzipped) refuse("it is of version 4 and compressed by gzip");

    std::uint64_t row_bytes = 0;
    for (std::uint32_t const n : header.row_bytes()) row_bytes += n;
    Map map;
    Bytes body;
    ByteView rows;
    bool more = false;
    bool const extends = (header.flags & 2u) != 0;
    SpzAxes axes;
    std::size_t skipped = 0;
    if (header.version == 4) {
        if (in.size() < SpzHeader::bytes_v4) refuse("it ends inside its header");
        if (!codecs.zstd) refuse_without(file, "is an SPZ map of version 4, compressed by zstd", "libzstd", "libzstd-dev");
        require_plausible_rows(header.rows, file_bytes, file);
        header.table_at = number_at<std::uint32_t>(in.data() + 16);
        body.resize(static_cast<std::size_t>(row_bytes * header.rows));
        decompress_spz_v4(header, in, codecs, body, file);
        rows = body;
        if (extends) axes = read_spz_extensions(ByteView(in).subspan(SpzHeader::bytes_v4, header.table_at - SpzHeader::bytes_v4), file, skipped);
    } else if (gzipped) {
        require_plausible_rows(header.rows, file_bytes, file);
        body.resize(static_cast<std::size_t>(SpzHeader::bytes + row_bytes * header.rows + (extends ? most_spz_extensions : 0)));
        auto const result = codecs.gzip(in, body);
        if (result.damaged) refuse("its gzip stream is damaged");
        if (!result.ended && !result.more && (extends || result.bytes == body.size())) refuse("its gzip stream is cut off");
        more = result.more;
        body.resize(result.bytes);
        rows = ByteView(body).subspan(SpzHeader::bytes);
    } else {
        rows = ByteView(in).subspan(SpzHeader::bytes);
        more = rows.size() > row_bytes * header.rows;
    }
    auto const parts = split_spz(header, rows, file);
    if (header.version != 4 && extends) axes = read_spz_extensions(rows.subspan(static_cast<std::size_t>(row_bytes * header.rows)), file, skipped);
    if (header.version != 4) require_ids(header.rows, file);
    if (!body.empty()) Bytes().swap(in);

    map.name = std::filesystem::path(name).stem().string();
    map.path = name;
    map.sh_degree = std::min(header.degree, 3u);
    map.notes.push_back("read as SPZ version " + std::to_string(header.version) + " of degree " + std::to_string(header.degree) +
                        (header.degree > 3 ? ", up to degree 3" : "") +
                        (axes.said ? "; an extension says that its axes are " + axes.text() + ": they are turned to right down front, those of a PLY"
                                   : "; y and z changed sign: an SPZ has y up and z back, a PLY y down and z forward"));
    if ((header.flags & 1u) != 0) map.notes.push_back(antialiased_note);
    if (skipped != 0) map.notes.push_back("extensions skipped");
    if (more && !extends) map.notes.push_back("bytes after the last row skipped");
    if (header.rows == 0) map.notes.push_back("the header promises no rows: the map is empty");
    unpack_spz(header, axes, parts, map);
    if (axes.swapped) return turned(std::move(map), Turn::x90);
    return map;
}

}}} // namespace tilemesh::scene
TILEMESH_EXACT_END
