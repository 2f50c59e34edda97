#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/far_means.hpp>
#include <tilemesh/scene/detail/map_sink.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/scene/ply.hpp>
#include <tilemesh/scene/records.hpp>
#include <tilemesh/scene/sog.hpp>
#include <tilemesh/scene/splat_file.hpp>
#include <tilemesh/scene/spz.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <utility>

TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace scene {

namespace detail {

/// The name of a file ends in this extension, in small or capital letters.
inline bool has_extension(std::string const& name, char const* extension)
{
    std::string found = std::filesystem::path(name).extension().string();
    for (char& c : found)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return found == extension;
}

/// Is a file the meta.json of a folder of SOG, and no map itself?
inline bool begins_meta_json(std::filesystem::path const& path, std::istream& stream)
{
    return has_extension(path.string(), ".json") && stream.peek() == '{';
}

/// Notes that a PLY may have linear opacities or scales, where logits and logarithms are read: logits from 0 to 1 are opacities from 0.5 to 0.7311.
/// A map of fewer than 16 Gaussians gets no note, because chance makes such maps.
inline void note_linear(Map& map)
{
    auto const all = [&](auto const& holds) { return map.gaussians.size() >= 16 && std::all_of(map.gaussians.begin(), map.gaussians.end(), holds); };
    if (all([](auto const& g) { return g.opacity >= 0.5f && g.opacity <= 0.7311f; }))
        map.notes.push_back("all opacities are from 0 to 1: they are read as logits; if they are shares, export the map with logits");
    if (all([](auto const& g) { return g.log_scale[0] > 0 && g.log_scale[1] > 0 && g.log_scale[2] > 0; }))
        map.notes.push_back("all scales are above 0: they are read as logarithms; if they are lengths, export the map with logarithms");
}

using Matrix3 = std::array<std::array<double, 3>, 3>;

/// The matrix of a turn, of -1, 0 and 1.
inline Matrix3 matrix_of(Turn turn)
{
    auto const axis = static_cast<std::size_t>(turn) / 3, quarters = static_cast<std::size_t>(turn) % 3 + 1;
    std::size_t const u = (axis + 1) % 3, v = (axis + 2) % 3;
    double const c = quarters == 2 ? -1.0 : 0.0, s = quarters == 1 ? 1.0 : quarters == 3 ? -1.0 : 0.0;
    Matrix3 m{};
    m[axis][axis] = 1.0;
    m[u][u] = m[v][v] = c;
    m[u][v] = -s;
    m[v][u] = s;
    return m;
}

/// The harmonics of degree 1 to 3 in direction (x, y, z), a unit vector, in the order and with the signs of splat/harmonics.hpp.
inline std::array<double, 15> harmonics_at(double x, double y, double z)
{
    double const pi = 3.14159265358979323846;
    double const a = std::sqrt(3 / (4 * pi)), b = std::sqrt(15 / (4 * pi)), c = std::sqrt(5 / (16 * pi)), d = std::sqrt(35 / (32 * pi)),
                 e = std::sqrt(105 / (4 * pi)), f = std::sqrt(21 / (32 * pi)), g = std::sqrt(7 / (16 * pi));
    return {-a * y,
            a * z,
            -a * x,
            b * x * y,
            -b * y * z,
            c * (2 * z * z - x * x - y * y),
            -b * x * z,
            b / 2 * (x * x - y * y),
            -d * y * (3 * x * x - y * y),
            e * x * y * z,
            -f * y * (4 * z * z - x * x - y * y),
            g * z * (2 * z * z - 3 * x * x - 3 * y * y),
            -f * x * (4 * z * z - x * x - y * y),
            e / 2 * z * (x * x - y * y),
            -d * x * (x * x - 3 * y * y)};
}

/// How a turn mixes the harmonics: the coefficients of the turned function are this matrix times those of the function. Its entries are the
/// integrals over the sphere of Y_i(d) Y_j(m^-1 d). The rule has 4 heights of Gauss and Legendre and 8 angles: it is exact for polynomials of
/// degree 7, and the products have degree 6 at most.
inline std::array<std::array<double, 15>, 15> turn_of_harmonics(Matrix3 const& m)
{
    double const pi = 3.14159265358979323846;
    std::array<std::array<double, 15>, 15> out{};
    for (int height = 0; height < 4; ++height) {
        double const inner = height % 2 == 0 ? 1.0 : -1.0, r = inner * 2.0 / 7.0 * std::sqrt(6.0 / 5.0);
        double const z = (height < 2 ? 1.0 : -1.0) * std::sqrt(3.0 / 7.0 - r), weight = (18.0 + inner * std::sqrt(30.0)) / 36.0;
        for (int step = 0; step < 8; ++step) {
            double const angle = (step + 0.5) * pi / 4, flat = std::sqrt(1.0 - z * z);
            std::array<double, 3> const d{flat * std::cos(angle), flat * std::sin(angle), z};
            std::array<double, 3> before{};
            for (std::size_t i = 0; i < 3; ++i)
                for (std::size_t k = 0; k < 3; ++k) before[i] += m[k][i] * d[k];
            auto const to = harmonics_at(d[0], d[1], d[2]), from = harmonics_at(before[0], before[1], before[2]);
            for (std::size_t i = 0; i < 15; ++i)
                for (std::size_t k = 0; k < 15; ++k) out[i][k] += weight * pi / 4 * to[i] * from[k];
        }
    }
    // Rounding is of the order 1e-16; the smallest entry that is not 0 is 1/4.
    for (auto& row : out)
        for (double& value : row)
            if (double const whole = std::round(value); std::fabs(value - whole) < 1e-12) value = whole;
    return out;
}

} // namespace detail

TILEMESH_HOST Map read_map(std::istream& stream, std::string const& name, Codecs const& codecs, FarMeans far)
{
    auto const first = stream.tellg();
    std::array<char, 4> begin{};
    stream.read(begin.data(), begin.size());
    std::string_view const magic(begin.data(), static_cast<std::size_t>(std::max<std::streamsize>(stream.gcount(), 0)));
    stream.clear(stream.rdstate() & ~(std::ios::eofbit | std::ios::failbit));
    stream.seekg(first);
    // The third byte of a gzip file is its method, always 8. The first number of a .splat is a mean, with any bits.
    bool const gzipped = magic.starts_with("\x1f\x8b\x08") || (magic.starts_with("\x1f\x8b") && !detail::has_extension(name, ".splat"));
    auto const has_extension_of = [&](std::initializer_list<char const*> those) {
        return std::any_of(those.begin(), those.end(), [&](char const* each) { return detail::has_extension(name, each); });
    };
    auto const settled = [&](Map map) {
        detail::settle_far_means(map, far);
        return map;
    };
    if (magic.starts_with("NGSP") || gzipped) return settled(read_spz(stream, name, codecs));
    bool const of_training = has_extension_of({".npz", ".pt", ".pth", ".ckpt", ".usdz"});
    if (magic.starts_with("PK\x03\x04") && !of_training) return settled(read_sog(stream, name, codecs));
    // No mean begins like a pointer of git LFS or a web page: "vers" is 2e31, "<htm" is 5e27, "<!DO" is 3e9 (little endian).
    bool const stands_in = std::any_of(detail::stand_ins.begin(), detail::stand_ins.end(), [&](auto each) { return each.starts_with(magic); });
    if (!magic.starts_with("ply") && !magic.empty() && !stands_in && detail::has_extension(name, ".splat")) return settled(read_splat(stream, name));
    Map map = read_ply(stream, name, far);
    detail::note_linear(map);
    return map;
}

TILEMESH_HOST Map load_map(std::filesystem::path const& path, Codecs const& codecs, FarMeans far)
{
    auto const folder = [&] {
        Map map = load_sog_folder(path, codecs);
        detail::settle_far_means(map, far);
        return map;
    };
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) {
        if (!std::filesystem::exists(path / "meta.json", ignored))
            throw Error(detail::shown_path(path) + " is a folder without meta.json (the folder of an SOG map has one); name a 3DGS map");
        return folder();
    }
    auto stream = detail::open_file(path, std::numeric_limits<std::uint64_t>::max(), "a 3DGS map");
    if (detail::begins_meta_json(path, stream)) return folder();
    return read_map(stream, path.string(), codecs, far);
}

TILEMESH_HOST bool has_far_means(Map const& map)
{
    return detail::far_origin(map).has_value();
}

TILEMESH_HOST std::vector<std::filesystem::path> map_files(std::filesystem::path const& path)
{
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) return sog_folder_files(path);
    auto stream = detail::open_file(path, std::numeric_limits<std::uint64_t>::max(), "a 3DGS map");
    return detail::begins_meta_json(path, stream) ? sog_folder_files(path) : std::vector{path};
}

TILEMESH_HOST Map join_maps(std::vector<Map> maps)
{
    if (maps.empty()) return {};
    if (maps.size() == 1) {
        require_harmonics(maps.front());
        return std::move(maps.front());
    }
    Map joined;
    joined.name = maps.front().name;
    joined.origin = maps.front().origin;
    std::uint64_t gaussians = 0, rows = 0;
    for (Map const& map : maps) {
        require_harmonics(map);
        joined.sh_degree = std::max(joined.sh_degree, map.sh_degree);
        gaussians += map.gaussians.size();
        joined.path.append(joined.path.empty() ? "" : " + ").append(map.path);
    }
    std::size_t const wide = 3 * std::size_t{splat::harmonics_per_channel(joined.sh_degree)};
    joined.gaussians.reserve(static_cast<std::size_t>(gaussians));
    joined.harmonics.reserve(static_cast<std::size_t>(gaussians) * wide);
    for (Map& map : maps) {
        std::uint64_t const first = rows;
        rows += map.gaussians.size() + map.rejected;
        detail::require_ids(rows, detail::shown(joined.path, joined.path.size()));
        std::size_t const narrow = 3 * std::size_t{splat::harmonics_per_channel(map.sh_degree)};
        for (std::size_t i = 0; i < map.gaussians.size(); ++i) {
            splat::Gaussian g = map.gaussians[i];
            g.id = splat::GaussianId{static_cast<std::uint32_t>(static_cast<std::uint64_t>(g.id) + first)};
            for (std::size_t k = 0; k < 3 && map.origin != joined.origin; ++k)
                g.mean_world[k] = static_cast<float>(static_cast<double>(g.mean_world[k]) + (map.origin[k] - joined.origin[k]));
            joined.gaussians.push_back(g);
            auto const from = map.harmonics.begin() + static_cast<std::ptrdiff_t>(i * narrow);
            joined.harmonics.insert(joined.harmonics.end(), from, from + static_cast<std::ptrdiff_t>(narrow));
            joined.harmonics.resize(joined.gaussians.size() * wide, 0.0f);
        }
        joined.rejected += map.rejected;
        for (auto const& note : map.notes) joined.notes.push_back(detail::shown(map.path) + ": " + note);
        map = {};
    }
    return joined;
}

TILEMESH_HOST Map turned(Map map, Turn turn)
{
    require_harmonics(map);
    auto const m = detail::matrix_of(turn);
    auto const mixes = detail::turn_of_harmonics(m);
    auto const axis = static_cast<std::size_t>(turn) / 3, quarters = static_cast<std::size_t>(turn) % 3 + 1;
    double const half = 0.70710678118654752440; // cos and sin of 45 degrees
    double const w = quarters == 2 ? 0.0 : half, s = quarters == 2 ? 1.0 : quarters == 1 ? half : -half;
    auto const before_turn = map.origin;
    for (std::size_t i = 0; i < 3; ++i) {
        map.origin[i] = 0.0;
        for (std::size_t k = 0; k < 3; ++k)
            if (m[i][k] != 0.0) map.origin[i] += m[i][k] * before_turn[k];
    }
    for (splat::Gaussian& g : map.gaussians) {
        std::array<float, 3> mean{};
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t k = 0; k < 3; ++k)
                if (m[i][k] != 0.0) mean[i] = static_cast<float>(m[i][k]) * g.mean_world[k];
        std::copy(mean.begin(), mean.end(), g.mean_world);
        // The product (w, s axis) (q0, q1, q2, q3) of quaternions.
        std::array<double, 4> q{}, out{};
        for (std::size_t i = 0; i < 4; ++i) q[i] = static_cast<double>(g.rotation[i]);
        std::size_t const u = (axis + 1) % 3, v = (axis + 2) % 3;
        out[0] = w * q[0] - s * q[1 + axis];
        out[1 + axis] = w * q[1 + axis] + s * q[0];
        out[1 + u] = w * q[1 + u] - s * q[1 + v];
        out[1 + v] = w * q[1 + v] + s * q[1 + u];
        for (std::size_t i = 0; i < 4; ++i) g.rotation[i] = static_cast<float>(out[i]);
    }
    std::size_t const per_channel = splat::harmonics_per_channel(map.sh_degree);
    std::array<double, 45> before{};
    for (std::size_t at = 0; at < map.harmonics.size(); at += 3 * per_channel) {
        for (std::size_t i = 0; i < 3 * per_channel; ++i) before[i] = static_cast<double>(map.harmonics[at + i]);
        for (std::size_t i = 0; i < per_channel; ++i)
            for (std::size_t channel = 0; channel < 3; ++channel) {
                double sum = 0.0;
                for (std::size_t k = 0; k < per_channel; ++k)
                    if (mixes[i][k] != 0.0) sum += mixes[i][k] * before[3 * k + channel];
                map.harmonics[at + 3 * i + channel] = static_cast<float>(sum);
            }
    }
    return map;
}

}}} // namespace tilemesh::scene
TILEMESH_EXACT_END
