#pragma once
#include "plain_codecs.hpp"
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

// Writers of the map formats, after their public descriptions, and what their reference readers make of the same quantised numbers. They
// share no code with the library's readers.
namespace scene_test {

inline constexpr double sh_c0 = 0.28209479177387814;

/// A Gaussian as a PLY has it. Reference readers end with such numbers, each a float32.
struct PlainRow {
    std::array<double, 3> mean{}, f_dc{}, scale{};
    double logit = 0;
    std::array<double, 4> rotation{1, 0, 0, 0}; ///< w, x, y, z
    std::array<double, 45> rest{};              ///< coefficient 3 k + channel
    std::optional<double> opacity;              ///< after the sigmoid, where the format has that
    std::optional<std::array<double, 3>> colour; ///< 0.5 + f_dc / (2 sqrt pi), where the format has that
};
struct PlainMap {
    std::uint32_t degree = 0;
    std::vector<PlainRow> rows;
};
inline std::size_t coefficients_of(std::uint32_t degree)
{
    return 3 * degree * (degree + 2);
}

/// The PLY that a reference reader would write.
inline Bytes write_plain_ply(PlainMap const& map)
{
    Bytes out = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(map.rows.size()) + "\n";
    for (char const* name : {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2"}) out += std::string("property float ") + name + "\n";
    std::size_t const n = coefficients_of(map.degree);
    for (std::size_t i = 0; i < n; ++i) out += "property float f_rest_" + std::to_string(i) + "\n";
    for (char const* name : {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"}) out += std::string("property float ") + name + "\n";
    out += "end_header\n";
    auto const put = [&](double value) { put_little(out, std::bit_cast<std::uint32_t>(static_cast<float>(value)), 4); };
    for (PlainRow const& row : map.rows) {
        for (double v : row.mean) put(v);
        for (double v : row.f_dc) put(v);
        for (std::size_t channel = 0; channel < 3; ++channel)
            for (std::size_t k = 0; k < n / 3; ++k) put(row.rest[3 * k + channel]);
        put(row.logit);
        for (double v : row.scale) put(v);
        for (double v : row.rotation) put(v);
    }
    return out;
}

/// Random numbers that are the same on every machine.
class Numbers {
public:
    explicit Numbers(std::uint32_t seed) : engine_(seed) {}
    std::uint32_t word() { return static_cast<std::uint32_t>(engine_()); }
    std::uint8_t byte() { return static_cast<std::uint8_t>(word() >> 13); }
    double between(double low, double high) { return low + (high - low) * (word() / 4294967295.0); }

private:
    std::mt19937 engine_;
};

inline std::uint32_t quantised(double t, std::uint32_t most)
{
    return static_cast<std::uint32_t>(std::lround(std::clamp(t, 0.0, 1.0) * most));
}
inline double sigmoid(double x)
{
    return 1 / (1 + std::exp(-x));
}
inline std::array<double, 4> unit(std::array<double, 4> q)
{
    double const length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (double& v : q) v /= length;
    return q;
}
inline std::size_t largest_of(std::array<double, 4> const& q)
{
    std::size_t largest = 0;
    for (std::size_t i = 1; i < 4; ++i)
        if (std::fabs(q[i]) > std::fabs(q[largest])) largest = i;
    return largest;
}

// --- compressed PLY ----------------------------------------------------------------------------

struct PackedPly {
    std::uint32_t degree = 0;
    bool coloured = true; ///< chunks have a box of colours
    bool big = false;     ///< byte order
    std::vector<std::array<float, 18>> chunks;
    std::vector<std::array<std::uint32_t, 4>> words;
    std::vector<std::array<std::uint8_t, 45>> sh; ///< as the columns are: f_rest_0, f_rest_1, ...

    static PackedPly random(std::size_t n, std::uint32_t degree, bool coloured, Numbers& numbers)
    {
        PackedPly out;
        out.degree = degree;
        out.coloured = coloured;
        for (std::size_t i = 0; i < (n + 255) / 256; ++i) {
            auto& chunk = out.chunks.emplace_back();
            for (std::size_t k = 0; k < 18; ++k) {
                bool const is_max = k % 6 >= 3;
                chunk[k] = static_cast<float>(is_max ? numbers.between(0.5, 4) : numbers.between(-4, 0.5));
            }
        }
        for (std::size_t i = 0; i < n; ++i) {
            out.words.push_back({numbers.word(), numbers.word(), numbers.word(), numbers.word()});
            auto& sh = out.sh.emplace_back();
            for (auto& byte : sh) byte = numbers.byte();
        }
        return out;
    }
    static PackedPly of(PlainMap const& map)
    {
        PackedPly out;
        out.degree = map.degree;
        for (std::size_t begin = 0; begin < map.rows.size(); begin += 256) {
            std::size_t const end = std::min(begin + 256, map.rows.size());
            auto& box = out.chunks.emplace_back();
            auto const value = [&](std::size_t row, std::size_t k) {
                auto const& r = map.rows[row];
                return k < 3 ? r.mean[k] : k < 6 ? r.scale[k - 3] : r.f_dc[k - 6] * sh_c0 + 0.5;
            };
            for (std::size_t k = 0; k < 9; ++k) {
                float low = std::numeric_limits<float>::max(), high = -low;
                for (std::size_t r = begin; r < end; ++r) low = std::min(low, static_cast<float>(value(r, k))), high = std::max(high, static_cast<float>(value(r, k)));
                box[k / 3 * 6 + k % 3] = low;
                box[k / 3 * 6 + 3 + k % 3] = high;
            }
            auto const share = [&](std::size_t row, std::size_t k, std::uint32_t bits) {
                double const low = box[k / 3 * 6 + k % 3], high = box[k / 3 * 6 + 3 + k % 3];
                return quantised(high > low ? (value(row, k) - low) / (high - low) : 0, (1u << bits) - 1);
            };
            for (std::size_t r = begin; r < end; ++r) {
                auto const vector = [&](std::size_t k) { return share(r, k, 11) << 21 | share(r, k + 1, 10) << 11 | share(r, k + 2, 11); };
                auto q = unit(map.rows[r].rotation);
                std::size_t const largest = largest_of(q);
                std::uint32_t rotation = static_cast<std::uint32_t>(largest);
                for (std::size_t i = 0; i < 4; ++i)
                    if (i != largest) rotation = rotation << 10 | quantised((q[largest] < 0 ? -q[i] : q[i]) * std::sqrt(2.0) / 2 + 0.5, 1023);
                std::uint32_t const colour = share(r, 6, 8) << 24 | share(r, 7, 8) << 16 | share(r, 8, 8) << 8 | quantised(sigmoid(map.rows[r].logit), 255);
                out.words.push_back({vector(0), rotation, vector(3), colour});
                auto& sh = out.sh.emplace_back();
                std::size_t const n = coefficients_of(map.degree);
                for (std::size_t i = 0; i < n; ++i) {
                    double const v = map.rows[r].rest[3 * (i % (n / 3)) + i / (n / 3)];
                    sh[i] = static_cast<std::uint8_t>(std::clamp(std::floor((v / 8 + 0.5) * 256), 0.0, 255.0));
                }
            }
        }
        return out;
    }
    Bytes bytes() const
    {
        std::size_t const n = coefficients_of(degree);
        Bytes out = std::string("ply\nformat binary_") + (big ? "big" : "little") + "_endian 1.0\nelement chunk " + std::to_string(chunks.size()) + "\n";
        for (char const* what : {"", "scale_", "colour"})
            for (char const* side : {"min_", "max_"})
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    bool const colour = what[0] == 'c';
                    if (colour && !coloured) continue;
                    out += std::string("property float ") + side + (colour ? "" : what) + (colour ? "rgb" : "xyz")[axis] + "\n";
                }
        out += "element vertex " + std::to_string(words.size()) + "\n";
        for (char const* name : {"position", "rotation", "scale", "color"}) out += std::string("property uint packed_") + name + "\n";
        if (n != 0) out += "element sh " + std::to_string(words.size()) + "\n";
        for (std::size_t i = 0; i < n; ++i) out += "property uchar f_rest_" + std::to_string(i) + "\n";
        out += "end_header\n";
        auto const put = [&](std::uint32_t word) {
            if (big) word = word >> 24 | (word >> 8 & 0xff00u) | (word << 8 & 0xff0000u) | word << 24;
            put_little(out, word, 4);
        };
        for (auto const& chunk : chunks)
            for (std::size_t i = 0; i < (coloured ? 18u : 12u); ++i) put(std::bit_cast<std::uint32_t>(chunk[i]));
        for (auto const& row : words)
            for (std::uint32_t word : row) put(word);
        for (auto const& row : sh)
            for (std::size_t i = 0; i < n; ++i) out += static_cast<char>(row[i]);
        return out;
    }
    PlainMap expected() const
    {
        PlainMap map{degree, {}};
        auto const unorm = [](std::uint32_t value, std::uint32_t bits) { return (value & ((1u << bits) - 1)) / static_cast<double>((1u << bits) - 1); };
        for (std::size_t i = 0; i < words.size(); ++i) {
            auto const& c = chunks[i / 256];
            PlainRow row;
            auto const lerp = [&](std::size_t at, std::size_t axis, double t) {
                volatile double const low = static_cast<double>(c[at + axis]) * (1 - t), high = static_cast<double>(c[at + 3 + axis]) * t; // not fused
                return low + high;
            };
            for (auto [word, at, to] : {std::tuple(words[i][0], std::size_t{0}, &row.mean), std::tuple(words[i][2], std::size_t{6}, &row.scale)}) {
                (*to)[0] = lerp(at, 0, unorm(word >> 21, 11));
                (*to)[1] = lerp(at, 1, unorm(word >> 11, 10));
                (*to)[2] = lerp(at, 2, unorm(word, 11));
            }
            double abc[3], squares = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                abc[k] = (unorm(words[i][1] >> (20 - 10 * k), 10) - 0.5) * (1.0 / (std::sqrt(2.0) * 0.5));
                volatile double const square = abc[k] * abc[k];
                squares += square;
            }
            std::size_t const largest = words[i][1] >> 30;
            for (std::size_t k = 0, next = 0; k < 4; ++k) row.rotation[k] = k == largest ? std::sqrt(std::max(0.0, 1 - squares)) : abc[next++];
            for (std::size_t k = 0; k < 3; ++k) {
                double const t = unorm(words[i][3] >> (24 - 8 * k), 8);
                row.f_dc[k] = ((coloured ? lerp(12, k, t) : t) - 0.5) / sh_c0;
            }
            row.opacity = unorm(words[i][3], 8);
            std::size_t const n = coefficients_of(degree);
            for (std::size_t k = 0; k < n; ++k) {
                double const s = sh[i][k], t = s == 0 ? 0 : s == 255 ? 1 : (s + 0.5) / 256;
                row.rest[3 * (k % (n / 3)) + k / (n / 3)] = (t - 0.5) * 8;
            }
            map.rows.push_back(row);
        }
        return map;
    }
};

// --- .splat ------------------------------------------------------------------------------------

struct PackedSplat {
    struct Row {
        std::array<float, 3> mean, scale;
        std::array<std::uint8_t, 4> rgba, rotation;
    };
    std::vector<Row> rows;

    static PackedSplat random(std::size_t n, Numbers& numbers)
    {
        PackedSplat out;
        for (std::size_t i = 0; i < n; ++i) {
            auto& row = out.rows.emplace_back();
            for (auto& v : row.mean) v = static_cast<float>(numbers.between(-9, 9));
            for (auto& v : row.scale) v = static_cast<float>(std::exp(numbers.between(-9, 2)));
            for (auto& v : row.rgba) v = numbers.byte();
            for (auto& v : row.rotation) v = numbers.byte();
        }
        return out;
    }
    static PackedSplat of(PlainMap const& map)
    {
        PackedSplat out;
        for (PlainRow const& from : map.rows) {
            auto& row = out.rows.emplace_back();
            auto const q = unit(from.rotation);
            for (std::size_t i = 0; i < 3; ++i) {
                row.mean[i] = static_cast<float>(from.mean[i]);
                row.scale[i] = static_cast<float>(std::exp(from.scale[i]));
                row.rgba[i] = static_cast<std::uint8_t>(quantised(from.f_dc[i] * sh_c0 + 0.5, 255));
            }
            row.rgba[3] = static_cast<std::uint8_t>(quantised(sigmoid(from.logit), 255));
            for (std::size_t i = 0; i < 4; ++i) row.rotation[i] = static_cast<std::uint8_t>(std::clamp(std::lround(q[i] * 128 + 128), 0l, 255l));
        }
        return out;
    }
    Bytes bytes() const
    {
        Bytes out;
        for (Row const& row : rows) {
            for (float v : row.mean) put_little(out, std::bit_cast<std::uint32_t>(v), 4);
            for (float v : row.scale) put_little(out, std::bit_cast<std::uint32_t>(v), 4);
            for (auto v : row.rgba) out += static_cast<char>(v);
            for (auto v : row.rotation) out += static_cast<char>(v);
        }
        return out;
    }
    PlainMap expected() const
    {
        PlainMap map;
        for (Row const& from : rows) {
            PlainRow row;
            row.colour.emplace();
            for (std::size_t i = 0; i < 3; ++i) {
                row.mean[i] = from.mean[i];
                row.scale[i] = std::log(static_cast<double>(from.scale[i]));
                (*row.colour)[i] = from.rgba[i] / 255.0;
            }
            row.opacity = from.rgba[3] / 255.0;
            for (std::size_t i = 0; i < 4; ++i) row.rotation[i] = (from.rotation[i] - 128) / 128.0;
            map.rows.push_back(row);
        }
        return map;
    }
};

// --- SPZ ---------------------------------------------------------------------------------------

/// How a test compresses: with a library, or with the stand-ins of plain_codecs.hpp.
struct Packing {
    tilemesh::scene::Codecs codecs = plain_codecs();
    Bytes (*gzip)(Bytes const&) = +[](Bytes const& in) { return plain_pack(in); };
    Bytes (*deflate)(Bytes const&) = +[](Bytes const& in) { return plain_pack(in, "DEF"); };
    Bytes (*zstd)(Bytes const&) = +[](Bytes const& in) { return plain_pack(in, "ZST"); };
    Bytes (*webp)(std::uint32_t, std::uint32_t, Bytes const&) = plain_picture;
};

struct PackedSpz {
    std::uint32_t version = 3, degree = 0, fractional_bits = 12, flags = 0;
    struct Row {
        std::array<std::uint32_t, 3> mean; ///< 24 bits, or 16 in version 1
        std::uint8_t opacity;
        std::array<std::uint8_t, 3> colour, scale;
        std::uint32_t rotation; ///< 32 bits, or three bytes in versions 1 and 2
        std::array<std::uint8_t, 72> sh;
    };
    std::vector<Row> rows;
    Bytes after; ///< behind the last row

    static PackedSpz random(std::size_t n, std::uint32_t version, std::uint32_t degree, Numbers& numbers)
    {
        PackedSpz out{version, degree, 12, 0, {}, {}};
        for (std::size_t i = 0; i < n; ++i) {
            auto& row = out.rows.emplace_back();
            for (auto& v : row.mean) v = numbers.word() >> (version == 1 ? 16 : 8);
            row.opacity = numbers.byte();
            for (auto& v : row.colour) v = numbers.byte();
            for (auto& v : row.scale) v = numbers.byte();
            row.rotation = version >= 3 ? numbers.word() : numbers.word() >> 8;
            for (auto& v : row.sh) v = numbers.byte();
        }
        return out;
    }
    /// From the axes of a PLY to those of the format.
    static PackedSpz of(PlainMap const& map, std::uint32_t version)
    {
        PackedSpz out{version, map.degree, 12, 0, {}, {}};
        for (PlainRow const& from : map.rows) {
            auto& row = out.rows.emplace_back();
            std::array<double, 3> const flip{1, -1, -1};
            for (std::size_t i = 0; i < 3; ++i) {
                double const v = flip[i] * from.mean[i];
                row.mean[i] = version == 1 ? to_half(v) : static_cast<std::uint32_t>(std::lround(v * 4096)) & 0xffffffu;
                row.colour[i] = static_cast<std::uint8_t>(quantised(from.f_dc[i] * 0.15 + 0.5, 255));
                row.scale[i] = static_cast<std::uint8_t>(std::clamp(std::lround((from.scale[i] + 10) * 16), 0l, 255l));
            }
            row.opacity = static_cast<std::uint8_t>(quantised(sigmoid(from.logit), 255));
            auto const w = unit(from.rotation);
            std::array<double, 4> q{w[1], -w[2], -w[3], w[0]};
            if (version < 3) {
                row.rotation = 0;
                for (std::size_t i = 0; i < 3; ++i) row.rotation |= quantised((q[3] < 0 ? -q[i] : q[i]) / 2 + 0.5, 255) << 8 * i;
            } else {
                std::size_t const largest = largest_of(q);
                row.rotation = static_cast<std::uint32_t>(largest);
                for (std::size_t i = 0; i < 4; ++i) {
                    if (i == largest) continue;
                    double const v = q[largest] < 0 ? -q[i] : q[i];
                    row.rotation = row.rotation << 10 | (v < 0 ? 512u : 0u) | quantised(std::fabs(v) * std::sqrt(2.0), 511);
                }
            }
            row.sh.fill(128);
            for (std::size_t i = 0; i < coefficients_of(map.degree); ++i)
                row.sh[i] = static_cast<std::uint8_t>(std::clamp(std::lround(odd_in_yz(i / 3) * from.rest[i] * 128 + 128), 0l, 255l));
        }
        return out;
    }
    /// -1 where a harmonic changes its sign with y and z.
    static double odd_in_yz(std::size_t k)
    {
        // y, z, x; xy, yz, zz, xz, xx-yy; y(xx-yy), xyz, y zz, z, x zz, z(xx-yy), x
        constexpr char const* powers[15] = {"y", "z", "", "y", "yz", "", "z", "", "y", "yz", "y", "z", "", "z", ""};
        return std::string(powers[k]).size() % 2 == 1 ? -1 : 1;
    }
    static std::uint32_t to_half(double v)
    {
        // Numbers of the tests are normal in 16 bits, or 0.
        if (v == 0) return 0;
        int exponent = 0;
        double const fraction = std::frexp(std::fabs(v), &exponent); // in [0.5, 1)
        auto const bits = static_cast<std::uint32_t>(std::lround((fraction * 2 - 1) * 1024)) + (static_cast<std::uint32_t>(exponent + 14) << 10);
        return bits | (v < 0 ? 0x8000u : 0u);
    }
    std::array<Bytes, 6> attributes() const
    {
        std::array<Bytes, 6> out;
        std::size_t const n = degree == 4 ? 72 : coefficients_of(degree);
        for (Row const& row : rows) {
            for (std::uint32_t v : row.mean) put_little(out[0], v, version == 1 ? 2 : 3);
            put_little(out[1], row.opacity, 1);
            for (auto v : row.colour) put_little(out[2], v, 1);
            for (auto v : row.scale) put_little(out[3], v, 1);
            put_little(out[4], row.rotation, version >= 3 ? 4 : 3);
            for (std::size_t i = 0; i < n; ++i) put_little(out[5], row.sh[i], 1);
        }
        return out;
    }
    Bytes header(std::uint32_t last, std::uint64_t count) const
    {
        Bytes out = "NGSP";
        put_little(out, version, 4);
        put_little(out, count, 4);
        for (std::uint32_t byte : {degree, fractional_bits, flags, last}) put_little(out, byte, 1);
        return out;
    }
    /// Versions 1 to 3, not compressed.
    Bytes plain() const
    {
        Bytes out = header(0, rows.size());
        for (Bytes const& part : attributes()) out += part;
        return out + after;
    }
    Bytes bytes(Packing const& packing) const
    {
        if (version < 4) return packing.gzip(plain());
        std::vector<Bytes> streams;
        Bytes table;
        for (Bytes const& part : attributes()) {
            if (part.empty()) continue;
            streams.push_back(packing.zstd(part));
            put_little(table, streams.back().size(), 8);
            put_little(table, part.size(), 8);
        }
        Bytes out = header(static_cast<std::uint32_t>(streams.size()), rows.size());
        put_little(out, 32 + after.size(), 4); // extensions are before the table
        out += Bytes(12, '\0') + after + table;
        for (Bytes const& stream : streams) out += stream;
        return out;
    }
    PlainMap expected() const
    {
        PlainMap map{std::min(degree, 3u), {}};
        for (Row const& from : rows) {
            PlainRow row;
            std::array<double, 3> const flip{1, -1, -1};
            for (std::size_t i = 0; i < 3; ++i) {
                double mean = 0;
                if (version == 1) {
                    std::uint32_t const e = from.mean[i] >> 10 & 31, f = from.mean[i] & 1023;
                    mean = e == 31 ? (f == 0 ? std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN())
                           : e == 0 ? std::ldexp(f, -24) : std::ldexp(1024 + f, static_cast<int>(e) - 25);
                    if ((from.mean[i] & 0x8000u) != 0) mean = -mean;
                } else {
                    std::int64_t const fixed = from.mean[i] >= 0x800000u ? static_cast<std::int64_t>(from.mean[i]) - 0x1000000 : from.mean[i];
                    mean = std::ldexp(static_cast<double>(fixed), -static_cast<int>(fractional_bits));
                }
                row.mean[i] = flip[i] * mean;
                row.f_dc[i] = (static_cast<float>(from.colour[i]) / 255.0f - 0.5f) / 0.15f;
                row.scale[i] = from.scale[i] / 16.0 - 10;
            }
            row.opacity = from.opacity / 255.0;
            float q[4];
            if (version >= 3) {
                std::uint32_t const largest = from.rotation >> 30;
                float squares = 0;
                int shift = 0;
                for (int i = 3; i >= 0; --i) {
                    if (i == static_cast<int>(largest)) continue;
                    std::uint32_t const bits = from.rotation >> shift & 1023;
                    q[i] = static_cast<float>(0.707106781186547524401) * static_cast<float>(bits & 511) / 511.0f;
                    if (bits >= 512) q[i] = -q[i];
                    volatile float const square = q[i] * q[i];
                    squares += square;
                    shift += 10;
                }
                q[largest] = std::sqrt(1.0f - squares);
            } else {
                float squares = 0;
                for (int i = 0; i < 3; ++i) {
                    volatile float const part = static_cast<float>(from.rotation >> 8 * i & 255) * (1.0f / 127.5f);
                    q[i] = part - 1.0f;
                    volatile float const square = q[i] * q[i];
                    squares += square;
                }
                q[3] = std::sqrt(std::max(0.0f, 1.0f - squares));
            }
            row.rotation = {q[3], q[0], -q[1], -q[2]};
            for (std::size_t i = 0; i < coefficients_of(map.degree); ++i) row.rest[i] = odd_in_yz(i / 3) * (from.sh[i] - 128.0) / 128.0;
            map.rows.push_back(row);
        }
        return map;
    }
};

// --- SOG ---------------------------------------------------------------------------------------

struct PackedSog {
    std::uint32_t version = 2, degree = 0, width = 0, height = 0;
    std::array<double, 4> mins{}, maxs{};                 ///< of the means
    std::array<std::vector<double>, 3> books;             ///< version 2: scales, sh0, shN
    std::array<std::array<double, 8>, 2> ranges{};        ///< version 1: mins and maxs of scales, sh0
    std::array<double, 2> range_rest{};                   ///< version 1: of shN
    struct Row {
        std::array<std::uint16_t, 3> mean;
        std::array<std::uint8_t, 3> scale;
        std::array<std::uint8_t, 4> rotation, colour;
        std::uint16_t label;
    };
    std::vector<Row> rows;
    std::vector<std::array<std::uint8_t, 45>> palette; ///< 3 k + channel

    void set_size()
    {
        auto const n = static_cast<double>(rows.size());
        width = std::max(4u, static_cast<std::uint32_t>(std::ceil(std::sqrt(n) / 4)) * 4);
        height = std::max(4u, static_cast<std::uint32_t>(std::ceil(n / width / 4)) * 4);
    }
    static PackedSog random(std::size_t n, std::uint32_t version, std::uint32_t degree, Numbers& numbers)
    {
        PackedSog out;
        out.version = version;
        out.degree = degree;
        for (std::size_t i = 0; i < 3; ++i) out.mins[i] = numbers.between(-3, 0), out.maxs[i] = numbers.between(0, 3);
        for (auto& book : out.books) {
            for (int i = 0; i < 256; ++i) book.push_back(numbers.between(-4, 2));
            std::sort(book.begin(), book.end());
        }
        for (auto& range : out.ranges)
            for (std::size_t i = 0; i < 4; ++i) range[i] = numbers.between(-5, 0), range[4 + i] = numbers.between(0, 3);
        out.range_rest = {numbers.between(-2, 0), numbers.between(0, 2)};
        for (std::size_t i = 0; i < (degree == 0 ? 0u : 100u); ++i)
            for (auto& byte : out.palette.emplace_back()) byte = numbers.byte();
        for (std::size_t i = 0; i < n; ++i) {
            auto& row = out.rows.emplace_back();
            for (auto& v : row.mean) v = static_cast<std::uint16_t>(numbers.word() >> 16);
            for (auto& v : row.scale) v = numbers.byte();
            for (auto& v : row.rotation) v = numbers.byte();
            row.rotation[3] = static_cast<std::uint8_t>(252 + numbers.byte() % 4);
            for (auto& v : row.colour) v = numbers.byte();
            row.label = static_cast<std::uint16_t>(degree == 0 ? 0 : numbers.word() % 100);
        }
        out.set_size();
        return out;
    }
    /// The values of version 2 are even steps, as those of version 1 always are. The palette has each Gaussian's own harmonics.
    static PackedSog of(PlainMap const& map, std::uint32_t version = 2)
    {
        PackedSog out;
        out.version = version;
        out.degree = map.degree;
        auto const logs = [](double v) { return (v < 0 ? -1 : 1) * std::log(std::fabs(v) + 1); };
        out.mins.fill(std::numeric_limits<double>::max());
        out.maxs.fill(-std::numeric_limits<double>::max());
        std::array<std::array<double, 2>, 4> book_range{}; // of scales, f_dc, harmonics and, for version 1, logits
        for (auto& range : book_range) range = {std::numeric_limits<double>::max(), -std::numeric_limits<double>::max()};
        auto const widen = [&](std::size_t book, double v) { book_range[book] = {std::min(book_range[book][0], v), std::max(book_range[book][1], v)}; };
        for (PlainRow const& row : map.rows) {
            for (std::size_t i = 0; i < 3; ++i) {
                out.mins[i] = std::min(out.mins[i], logs(row.mean[i]));
                out.maxs[i] = std::max(out.maxs[i], logs(row.mean[i]));
                widen(0, row.scale[i]);
                widen(1, row.f_dc[i]);
            }
            for (std::size_t i = 0; i < coefficients_of(map.degree); ++i) widen(2, row.rest[i]);
            widen(3, row.logit);
        }
        for (std::size_t book = 0; book < 3; ++book)
            for (int i = 0; i < 256; ++i) out.books[book].push_back(book_range[book][0] + (book_range[book][1] - book_range[book][0]) * i / 255);
        for (std::size_t book = 0; book < 2; ++book)
            for (std::size_t i = 0; i < 4; ++i)
                for (std::size_t side = 0; side < 2; ++side) out.ranges[book][4 * side + i] = book_range[i == 3 ? 3 : book][side];
        out.range_rest = book_range[2];
        auto const nearest = [&](std::size_t book, double v) {
            return static_cast<std::uint8_t>(quantised((v - book_range[book][0]) / (book_range[book][1] - book_range[book][0]), 255));
        };
        for (PlainRow const& from : map.rows) {
            auto& row = out.rows.emplace_back();
            for (std::size_t i = 0; i < 3; ++i) {
                row.mean[i] = static_cast<std::uint16_t>(quantised((logs(from.mean[i]) - out.mins[i]) / (out.maxs[i] - out.mins[i]), 65535));
                row.scale[i] = nearest(0, from.scale[i]);
                row.colour[i] = nearest(1, from.f_dc[i]);
            }
            row.colour[3] = version == 1 ? nearest(3, from.logit) : static_cast<std::uint8_t>(quantised(sigmoid(from.logit), 255));
            auto const q = unit(from.rotation);
            std::size_t const largest = largest_of(q);
            for (std::size_t i = 0, k = 0; i < 4; ++i)
                if (i != largest) row.rotation[k++] = static_cast<std::uint8_t>(quantised((q[largest] < 0 ? -q[i] : q[i]) * std::sqrt(2.0) / 2 + 0.5, 255));
            row.rotation[3] = static_cast<std::uint8_t>(252 + largest);
            row.label = static_cast<std::uint16_t>(out.palette.size());
            if (map.degree == 0) continue;
            auto& entry = out.palette.emplace_back();
            for (std::size_t i = 0; i < coefficients_of(map.degree); ++i) entry[i] = nearest(2, from.rest[i]);
        }
        out.set_size();
        return out;
    }

    static std::string text(double v)
    {
        char out[40];
        std::snprintf(out, sizeof out, "%.17g", v);
        return out;
    }
    template <class List>
    static std::string list(List const& values, std::size_t first, std::size_t n)
    {
        std::string out = "[";
        for (std::size_t i = 0; i < n; ++i) out += (i != 0 ? "," : "") + text(values[first + i]);
        return out + "]";
    }
    std::string meta() const
    {
        std::string const quote = "\"";
        auto const files = [&](char const* a, char const* b) { return "\"files\":[\"" + std::string(a) + ".webp\"" + (b ? ",\"" + std::string(b) + ".webp\"" : "") + "]}"; };
        std::string const n = std::to_string(rows.size());
        std::string out = version == 2 ? "{\"version\":2,\"asset\":{\"generator\":\"test [\\u00e9]\"},\"count\":" + n + "," : "{";
        std::string const shape = version == 1 ? "\"shape\":[" + n + ",3]," : "";
        out += "\"means\":{" + shape + "\"mins\":" + list(mins, 0, 3) + ",\"maxs\":" + list(maxs, 0, 3) + "," + files("means_l", "means_u");
        auto const values = [&](std::size_t book, std::size_t channels) {
            if (version == 2) return "\"codebook\":" + list(books[book], 0, 256) + ",";
            return "\"dtype\":\"float32\",\"mins\":" + list(ranges[book], 0, channels) + ",\"maxs\":" + list(ranges[book], 4, channels) + ",";
        };
        out += ",\"scales\":{" + values(0, 3) + files("scales", nullptr) + ",\"quats\":{" + files("quats", nullptr) + ",\"sh0\":{" + values(1, 4) + files("sh0", nullptr);
        if (degree != 0) {
            out += ",\"shN\":{";
            if (version == 2) out += "\"count\":" + std::to_string(palette.size()) + ",\"bands\":" + std::to_string(degree) + ",\"codebook\":" + list(books[2], 0, 256) + ",";
            else out += "\"quantization\":8,\"mins\":" + text(range_rest[0]) + ",\"maxs\":" + text(range_rest[1]) + ",";
            out += files("shN_centroids", "shN_labels");
        }
        return out + "}";
    }
    /// The files of the folder.
    std::map<std::string, Bytes> files(Packing const& packing) const
    {
        std::map<std::string, Bytes> out;
        std::array<Bytes, 6> pixels;
        for (Bytes& p : pixels) p.assign(std::size_t{4} * width * height, '\x55');
        for (std::size_t i = 0; i < rows.size(); ++i) {
            auto const set = [&](std::size_t picture, std::array<std::uint32_t, 4> const& rgba) {
                for (std::size_t k = 0; k < 4; ++k) pixels[picture][4 * i + k] = static_cast<char>(rgba[k]);
            };
            Row const& r = rows[i];
            set(0, {r.mean[0] & 255u, r.mean[1] & 255u, r.mean[2] & 255u, 255});
            set(1, {r.mean[0] / 256u, r.mean[1] / 256u, r.mean[2] / 256u, 255});
            set(2, {r.scale[0], r.scale[1], r.scale[2], 255});
            set(3, {r.rotation[0], r.rotation[1], r.rotation[2], r.rotation[3]});
            set(4, {r.colour[0], r.colour[1], r.colour[2], r.colour[3]});
            set(5, {r.label & 255u, r.label / 256u, 0, 255});
        }
        char const* const planes[6] = {"means_l", "means_u", "scales", "quats", "sh0", "shN_labels"};
        for (std::size_t i = 0; i < (degree == 0 ? 5u : 6u); ++i) out[std::string(planes[i]) + ".webp"] = packing.webp(width, height, pixels[i]);
        if (degree != 0) {
            std::size_t const k = coefficients_of(degree) / 3, lines = (palette.size() + 63) / 64;
            Bytes centroids(4 * 64 * k * lines, '\xff');
            for (std::size_t i = 0; i < palette.size(); ++i)
                for (std::size_t c = 0; c < 3 * k; ++c) centroids[4 * (i / 64 * 64 * k + i % 64 * k + c / 3) + c % 3] = static_cast<char>(palette[i][c]);
            out["shN_centroids.webp"] = packing.webp(static_cast<std::uint32_t>(64 * k), static_cast<std::uint32_t>(lines), centroids);
        }
        out["meta.json"] = meta();
        return out;
    }
    PlainMap expected() const
    {
        PlainMap map{degree, {}};
        for (Row const& from : rows) {
            PlainRow row;
            auto const share = [&](std::size_t book, std::size_t channel, std::uint8_t v) {
                volatile double const part = (ranges[book][4 + channel] - ranges[book][channel]) * (v / 255.0);
                return ranges[book][channel] + part;
            };
            for (std::size_t i = 0; i < 3; ++i) {
                volatile double const part = (maxs[i] - mins[i]) * (from.mean[i] / 65535.0);
                double const v = mins[i] + part, size = std::exp(std::fabs(v)) - 1;
                row.mean[i] = v < 0 ? -size : size;
                row.scale[i] = version == 2 ? books[0][from.scale[i]] : share(0, i, from.scale[i]);
                row.f_dc[i] = version == 2 ? books[1][from.colour[i]] : share(1, i, from.colour[i]);
            }
            if (version == 2) row.opacity = from.colour[3] / 255.0;
            else row.logit = share(1, 3, from.colour[3]);
            double squares = 0;
            std::size_t const largest = from.rotation[3] - 252u;
            for (std::size_t i = 0, k = 0; i < 4; ++i) {
                if (i == largest) continue;
                row.rotation[i] = (from.rotation[k++] / 255.0 * 2 - 1) / std::sqrt(2.0);
                volatile double const square = row.rotation[i] * row.rotation[i];
                squares += square;
            }
            row.rotation[largest] = std::sqrt(std::max(0.0, 1 - squares));
            for (std::size_t i = 0; i < coefficients_of(degree); ++i) {
                std::uint8_t const b = palette[from.label][i];
                volatile double const part = (range_rest[1] - range_rest[0]) * (b / 255.0);
                row.rest[i] = version == 2 ? books[2][b] : range_rest[0] + part;
            }
            map.rows.push_back(row);
        }
        return map;
    }
};

/// A ZIP archive; its entries are stored or, with `deflate`, compressed.
inline Bytes write_zip(std::map<std::string, Bytes> const& files, Packing const& packing, bool deflate)
{
    Bytes out, directory;
    for (auto const& file : files) {
        auto const &name = file.first, &content = file.second; // Clang 14 captures no structured binding
        Bytes const packed = deflate ? packing.deflate(content) : content;
        auto const common = [&](Bytes& to) {
            put_little(to, 20, 2); // version needed
            put_little(to, 0, 2);
            put_little(to, deflate ? 8 : 0, 2);
            put_little(to, 0, 4); // time and date
            put_little(to, packing.codecs.crc32(view(content)), 4);
            put_little(to, packed.size(), 4);
            put_little(to, content.size(), 4);
            put_little(to, name.size(), 2);
            put_little(to, 0, 2);
        };
        directory += "PK\x01\x02";
        put_little(directory, 20, 2);
        common(directory);
        put_little(directory, 0, 2); // comment
        put_little(directory, 0, 2); // disk
        put_little(directory, 0, 2);
        put_little(directory, 0, 4);
        put_little(directory, out.size(), 4);
        directory += name;
        out += "PK\x03\x04";
        common(out);
        out += name + packed;
    }
    std::size_t const at = out.size();
    out += directory + "PK\x05\x06";
    put_little(out, 0, 4);
    put_little(out, files.size(), 2);
    put_little(out, files.size(), 2);
    put_little(out, directory.size(), 4);
    put_little(out, at, 4);
    put_little(out, 0, 2);
    return out;
}

} // namespace scene_test
