#pragma once
#include "../scene/map_writers.hpp"
#include "plain_ply.hpp"
#include <nlohmann/json.hpp>

// Slow readers of compressed maps: from the bytes to the quantised numbers of tests/scene/map_writers.hpp, which gives their values, and from
// there through an uncompressed PLY. They are for files that the library reads: they check nothing.
namespace plain {

using scene_test::Bytes;

inline std::uint64_t little(Bytes const& bytes, std::size_t at, std::size_t n)
{
    return scene_test::get_little(scene_test::view(bytes), at, n);
}
inline float little_float(Bytes const& bytes, std::size_t at)
{
    return std::bit_cast<float>(static_cast<std::uint32_t>(little(bytes, at, 4)));
}

/// The map that has these rows.
inline std::optional<Map> map_of(scene_test::PlainMap const& rows)
{
    Bytes const bytes = write_plain_ply(rows);
    auto map = Ply(bytes).read();
    if (!map) return {};
    for (Gaussian& g : map->gaussians) {
        auto const& row = rows.rows[static_cast<std::size_t>(g.id) - 1];
        if (row.opacity) g.values[6] = *row.opacity;
        for (std::size_t i = 0; row.colour && i < 3; ++i) g.values[3 + i] = (*row.colour)[i];
    }
    return map;
}

inline std::optional<Map> splat(Bytes const& bytes)
{
    scene_test::PackedSplat packed;
    for (std::size_t at = 0; at + 32 <= bytes.size(); at += 32) {
        auto& row = packed.rows.emplace_back();
        for (std::size_t i = 0; i < 3; ++i) row.mean[i] = little_float(bytes, at + 4 * i), row.scale[i] = little_float(bytes, at + 12 + 4 * i);
        for (std::size_t i = 0; i < 4; ++i)
            row.rgba[i] = static_cast<std::uint8_t>(bytes[at + 24 + i]), row.rotation[i] = static_cast<std::uint8_t>(bytes[at + 28 + i]);
    }
    return map_of(packed.expected());
}

/// What the stand-in decoders of tests/scene/plain_codecs.hpp make of the stream at `at`.
inline Bytes unpacked(Bytes const& bytes, std::size_t at)
{
    return bytes.substr(at + 11, static_cast<std::size_t>(little(bytes, at + 3, 4)));
}

inline std::optional<Map> spz(Bytes const& file)
{
    Bytes const bytes = file[0] == '\x1f' ? unpacked(file, 0) : file;
    auto const byte = [&](std::size_t at) { return static_cast<std::uint32_t>(little(bytes, at, 1)); };
    auto const rows = static_cast<std::size_t>(little(bytes, 8, 4));
    scene_test::PackedSpz packed{static_cast<std::uint32_t>(little(bytes, 4, 4)), byte(12), byte(13), 0, {}, {}};
    bool const first = packed.version == 1, turned = packed.version >= 3;
    std::size_t const coefficients = packed.degree == 4 ? 72 : scene_test::coefficients_of(packed.degree);
    std::array<std::size_t, 6> const sizes{first ? 6u : 9u, 1, 3, 3, turned ? 4u : 3u, coefficients};
    Bytes body = bytes.substr(16);
    if (packed.version == 4) {
        body.clear();
        std::size_t const streams = byte(15), table = static_cast<std::size_t>(little(bytes, 16, 4));
        for (std::size_t i = 0, at = table + 16 * streams; i < streams; at += static_cast<std::size_t>(little(bytes, table + 16 * i, 8)), ++i) body += unpacked(bytes, at);
    }
    packed.rows.resize(rows);
    std::size_t at = 0;
    auto const next = [&](std::size_t n) { return little(body, std::exchange(at, at + n), n); };
    for (std::size_t part = 0; part < 6; ++part)
        for (auto& row : packed.rows) {
            if (part == 0)
                for (auto& v : row.mean) v = static_cast<std::uint32_t>(next(sizes[0] / 3));
            else if (part == 1) row.opacity = static_cast<std::uint8_t>(next(1));
            else if (part == 4) row.rotation = static_cast<std::uint32_t>(next(sizes[4]));
            else if (part == 5)
                for (std::size_t i = 0; i < coefficients; ++i) row.sh[i] = static_cast<std::uint8_t>(next(1));
            else
                for (auto& v : part == 2 ? row.colour : row.scale) v = static_cast<std::uint8_t>(next(1));
        }
    return map_of(packed.expected());
}

inline std::optional<Map> compressed_ply(Bytes const& bytes)
{
    Ply ply(bytes);
    auto const elements = ply.read_tables();
    if (!elements) return {};
    scene_test::PackedPly packed;
    auto const& tables = *elements;
    auto const chunk = tables.find("chunk"), vertex = tables.find("vertex"), sh = tables.find("sh");
    if (chunk == tables.end() || vertex == tables.end()) return {};
    packed.coloured = chunk->second.count("min_r") != 0;
    char const* const box[18] = {"min_x", "min_y", "min_z", "max_x", "max_y", "max_z", "min_scale_x", "min_scale_y", "min_scale_z", "max_scale_x", "max_scale_y", "max_scale_z",
                                 "min_r", "min_g", "min_b", "max_r", "max_g", "max_b"};
    auto const field = [](auto const& table, std::string const& name, std::size_t row) { return table.at(name).at(row); };
    for (std::size_t row = 0; row < chunk->second.at("min_x").size(); ++row) {
        auto& out = packed.chunks.emplace_back();
        for (std::size_t i = 0; i < (packed.coloured ? 18u : 12u); ++i) out[i] = static_cast<float>(field(chunk->second, box[i], row));
    }
    std::size_t columns = 0;
    for (auto const& [name, values] : sh == tables.end() ? Ply::Table{} : sh->second) columns += name.substr(0, 7) == "f_rest_" ? 1 : 0;
    std::uint32_t file_degree = 0;
    while (file_degree < 100 && scene_test::coefficients_of(file_degree) < columns) ++file_degree;
    packed.degree = scene_test::coefficients_of(file_degree) == columns ? std::min(file_degree, 3u) : 0;
    std::size_t const in_file = columns / 3, read = scene_test::coefficients_of(packed.degree) / 3;
    auto const column = [&](std::size_t i) { return "f_rest_" + std::to_string(i / read * in_file + i % read); };
    for (std::size_t i = 0; i < 3 * read; ++i)
        if (sh->second.count(column(i)) == 0) packed.degree = 0; // an unknown numbering
    for (std::size_t row = 0; row < vertex->second.at("packed_position").size(); ++row) {
        auto& words = packed.words.emplace_back();
        for (std::size_t i = 0; i < 4; ++i)
            words[i] = static_cast<std::uint32_t>(field(vertex->second, std::string("packed_") + std::array{"position", "rotation", "scale", "color"}[i], row));
        auto& bytes_of_row = packed.sh.emplace_back();
        for (std::size_t i = 0; i < scene_test::coefficients_of(packed.degree); ++i) bytes_of_row[i] = static_cast<std::uint8_t>(field(sh->second, column(i), row));
    }
    return map_of(packed.expected());
}

/// A file of a ZIP archive. Nothing if the archive has no file of this name.
inline std::optional<Bytes> unzipped(Bytes const& archive, std::string const& name)
{
    auto const half = [&](std::size_t at) { return static_cast<std::size_t>(little(archive, at, 2)); };
    auto const word = [&](std::size_t at) { return static_cast<std::size_t>(little(archive, at, 4)); };
    std::size_t end = archive.size() - 22; // of the directory, whose comment ends the archive
    while (archive.substr(end, 4) != "PK\5\6" || end + 22 + half(end + 20) != archive.size()) --end;
    for (std::size_t at = word(end + 16), i = half(end + 10); i > 0; at += 46 + half(at + 28) + half(at + 30) + half(at + 32), --i) {
        if (archive.substr(at + 46, half(at + 28)) != name) continue;
        std::size_t const local = word(at + 42), from = local + 30 + half(local + 26) + half(local + 28);
        return half(at + 10) == 8 ? unpacked(archive, from) : archive.substr(from, word(at + 20));
    }
    return {};
}

/// A text of JSON. `twice`: an object has a key twice, and parsers differ in which value they take.
struct Json {
    explicit Json(std::string const& text)
    {
        std::vector<std::set<std::string>> keys; // of the objects around
        auto const look = [&](int, nlohmann::json::parse_event_t event, nlohmann::json& part) {
            using Event = nlohmann::json::parse_event_t;
            if (event == Event::object_start) keys.emplace_back();
            if (event == Event::key) twice = !keys.back().insert(part.get<std::string>()).second || twice;
            if (event == Event::object_end) keys.pop_back();
            return true;
        };
        value = nlohmann::json::parse(text, look, false);
    }
    nlohmann::json value;
    bool twice = false;
};
/// Is a map in the SOG format that no slow reader judges?
inline bool has_a_key_twice(Bytes const& archive)
{
    return Json(unzipped(archive, "meta.json").value_or("")).twice;
}

/// A number or a list of numbers, as a list. A null at the beginning is PlayCanvas' step below the second number.
inline std::vector<double> numbers_of(nlohmann::json const& part, char const* key)
{
    if (!part.contains(key)) return {};
    auto const& value = part[key];
    if (value.is_number()) return {value.get<double>()};
    if (!value.is_array()) return {};
    std::vector<double> numbers;
    for (auto const& number : value) numbers.push_back(number.is_null() ? 0 : number.get<double>());
    if (numbers.size() == 256 && value[0].is_null()) numbers[0] = numbers[1] + (numbers[1] - numbers[255]) / 255.0;
    return numbers;
}

inline std::optional<Map> sog(Bytes const& archive)
{
    Json const json(unzipped(archive, "meta.json").value_or(""));
    if (json.value.is_discarded() || json.twice) return {};
    auto const& meta = json.value;
    auto const number = [](nlohmann::json const& part, char const* key, double otherwise) {
        return part.contains(key) && part[key].is_number() ? part[key].get<double>() : otherwise;
    };
    auto const picture = [&](char const* part, std::size_t i) { return *unzipped(archive, meta[part]["files"].at(i).get<std::string>()); };
    auto const byte = [](Bytes const& of, std::size_t pixel, std::size_t channel) { return static_cast<std::uint8_t>(of.at(6 + 4 * pixel + channel)); };

    scene_test::PackedSog packed;
    bool const said = meta.contains("version") && meta["version"].is_number();
    packed.version = number(meta, "version", 1) == 2 || ((!said || meta["version"] == -1) && !numbers_of(meta["scales"], "codebook").empty()) ? 2 : 1;
    auto const lows = numbers_of(meta["means"], "mins"), highs = numbers_of(meta["means"], "maxs");
    for (std::size_t i = 0; i < 3; ++i) packed.mins[i] = lows[i], packed.maxs[i] = highs[i] == lows[i] ? lows[i] + 1 : highs[i];
    char const* const parts[3] = {"scales", "sh0", "shN"};
    for (std::size_t book = 0; book < 3; ++book) {
        if (!meta.contains(parts[book]) || !meta[parts[book]].is_object()) continue;
        packed.books[book] = numbers_of(meta[parts[book]], "codebook");
        auto const mins = numbers_of(meta[parts[book]], "mins"), maxs = numbers_of(meta[parts[book]], "maxs");
        for (std::size_t i = 0; packed.version == 1 && i < mins.size(); ++i) {
            if (book == 2) packed.range_rest = {mins[i], maxs[i]};
            else packed.ranges[book][i] = mins[i], packed.ranges[book][4 + i] = maxs[i];
        }
    }

    Bytes labels;
    if (meta.contains("shN") && meta["shN"].is_object() && meta["shN"].contains("files") && meta["shN"]["files"].is_array() && !meta["shN"]["files"].empty()) {
        Bytes const palette = picture("shN", 0);
        labels = picture("shN", 1);
        auto const per_entry = static_cast<std::size_t>(little(palette, 2, 2) / 64); // pixels; 64 entries a line
        packed.degree = per_entry == 3 ? 1 : per_entry == 8 ? 2 : 3;
        for (std::size_t at = 0; at < 64 * little(palette, 4, 2); ++at) {
            auto& entry = packed.palette.emplace_back();
            for (std::size_t i = 0; i < 3 * per_entry; ++i) entry[i] = byte(palette, at * per_entry + i / 3, i % 3);
        }
    }

    Bytes const low = picture("means", 0), high = picture("means", 1), scales = picture("scales", 0), quats = picture("quats", 0), sh0 = picture("sh0", 0);
    auto const rows = static_cast<std::size_t>(packed.version == 2 && number(meta, "count", -1) != -1 ? number(meta, "count", 0) : numbers_of(meta["means"], "shape")[0]);
    std::vector<std::size_t> without_rotation;
    for (std::size_t r = 0; r < rows; ++r) {
        auto& row = packed.rows.emplace_back();
        for (std::size_t i = 0; i < 3; ++i) {
            row.mean[i] = static_cast<std::uint16_t>(byte(low, r, i) + 256 * byte(high, r, i));
            row.scale[i] = byte(scales, r, i);
        }
        for (std::size_t i = 0; i < 4; ++i) row.rotation[i] = byte(quats, r, i), row.colour[i] = byte(sh0, r, i);
        row.label = static_cast<std::uint16_t>(packed.degree == 0 ? 0 : byte(labels, r, 0) + 256 * byte(labels, r, 1));
        if (row.rotation[3] >= 252) continue;
        without_rotation.push_back(r); // the library rejects the row before it looks at the label
        row.rotation[3] = 252;
        row.label = 0;
    }
    auto expected = packed.expected();
    for (auto const r : without_rotation) expected.rows[r].mean[0] = std::numeric_limits<double>::quiet_NaN();
    return map_of(expected);
}

/// The map of a file that the library reads, if there is a slow reader for it; `note` is the library's note of the format.
inline std::optional<Map> compressed(Bytes const& bytes, std::string const& note)
{
    auto const is = [&](char const* format) { return note.find(format) != note.npos; };
    if (is("read as .splat")) return splat(bytes);
    if (is("read as SPZ")) return spz(bytes);
    if (is("read as a compressed PLY")) return compressed_ply(bytes);
    if (is("read as SOG")) return sog(bytes);
    return {};
}

} // namespace plain
