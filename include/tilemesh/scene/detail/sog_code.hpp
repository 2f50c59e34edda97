#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <functional>
#include <sstream>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/bytes.hpp>
#include <tilemesh/scene/detail/map_sink.hpp>
#include <tilemesh/scene/detail/packed_input.hpp>
#include <tilemesh/scene/detail/ply_gaussian.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
#include <tilemesh/scene/detail/sog_meta.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/detail/zip.hpp>
#include <tilemesh/scene/sog.hpp>
#include <tilemesh/splat/gaussian.hpp>

TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace scene {

namespace detail {

/// A decoded picture: 4 bytes a pixel.
struct SogPicture {
    Codecs::Size size;
    Bytes rgba;
    unsigned char const* pixel(std::size_t i) const { return rgba.data() + 4 * i; }
};

/// Is a WebP lossy? Its pixels are in a chunk "VP8 ", lossless ones in "VP8L"; a chunk is 4 letters, its length and its bytes, padded to an even
/// number (WebP container specification).
inline bool is_lossy_webp(Bytes const& in)
{
    auto const is = [&](std::uint64_t at, char const* letters) { return at + 8 <= in.size() && std::equal(letters, letters + 4, in.data() + at); };
    if (!is(0, "RIFF")) return false;
    for (std::uint64_t at = 12; at + 8 <= in.size() && !is(at, "VP8L");
         at += 8 + (std::uint64_t{number_at<std::uint32_t>(in.data() + at + 4)} + 1) / 2 * 2)
        if (is(at, "VP8 ")) return true;
    return false;
}

/// Decodes a picture that has at least `least` and at most `most` pixels. Throws `Error` for any other.
inline SogPicture decode_picture(Bytes const& in, std::uint64_t least, std::uint64_t most, Codecs const& codecs, std::string const& picture,
                                 std::string const& file)
{
    SogPicture out{codecs.webp_size(in), {}};
    auto const refuse = [&](std::string const& why) {
        throw Error(file + " has a picture that cannot be used (" + in_quotes(picture) + ": " + why + "); copy or export the map again");
    };
    std::uint64_t const pixels = std::uint64_t{out.size.width} * out.size.height;
    if (pixels == 0) refuse("it is not WebP");
    if (pixels < least || pixels > most)
        refuse(std::to_string(out.size.width) + " x " + std::to_string(out.size.height) + " pixels, " + std::to_string(least) + " to " +
               std::to_string(most) + " are expected");
    if (is_lossy_webp(in)) refuse("it is a lossy WebP, which changes the values; SOG needs lossless ones");
    out.rgba.resize(static_cast<std::size_t>(4 * pixels));
    if (!codecs.webp_read(in, out.rgba)) refuse("it is damaged");
    return out;
}

/// The value of each byte for one channel: of a codebook, or a share of the range [low, high]. As a float32.
inline std::array<double, 256> values_of(SogPart const& part, std::uint32_t version, std::size_t channel)
{
    std::array<double, 256> values{};
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = rounded_to_float(version == 2 ? part.codebook[i]
                                            : part.mins[channel] + (part.maxs[channel] - part.mins[channel]) * (static_cast<double>(i) / 255.0));
    return values;
}

/// The harmonics of an SOG map: a palette and the entry of each Gaussian.
struct SogHarmonics {
    std::uint32_t degree = 0;
    bool width_says = false; ///< the degree is that of the palette's width, because the file does not say it
    std::size_t entries = 0;
    SogPicture palette, labels;
    std::array<double, 256> values{};
};

/// Reads an SOG map from its files. `read` returns the content of a file.
inline Map read_sog_files(std::function<Bytes(std::string const&)> const& read, std::string const& name, std::string const& file,
                          Codecs const& codecs)
{
    SogMeta meta;
    std::uint64_t file_bytes = 0;
    {
        Bytes const text = read("meta.json");
        file_bytes += text.size();
        std::istringstream stream(std::string(text.begin(), text.end()));
        meta = SogMetaReader(stream, file).read();
    }
    if (!codecs.webp_size || !codecs.webp_read) refuse_without(file, "is an SOG map, whose pictures are WebP", "libwebp", "libwebp-dev");
    std::array<std::string, 5> const names{meta.means.files[0], meta.means.files[1], meta.scales.files[0], meta.quats.files[0], meta.sh0.files[0]};
    std::array<Bytes, 5> packed;
    for (std::size_t i = 0; i < packed.size(); ++i) {
        packed[i] = read(names[i]);
        file_bytes += packed[i].size();
    }
    require_plausible_rows(meta.count, file_bytes, file);

    // Writers round the number of pixels up to a rectangle.
    std::uint64_t const most = 65536 + 4 * meta.count;
    std::array<SogPicture, 5> pictures;
    auto const require_same_size = [&](SogPicture const& picture, std::string const& of) {
        if (picture.size.width != pictures[0].size.width || picture.size.height != pictures[0].size.height)
            throw Error(file + " has pictures of different sizes (" + in_quotes(of) + " and " + in_quotes(names[0]) +
                        "; a Gaussian has the same pixel in all); export the map again");
    };
    for (std::size_t i = 0; i < packed.size(); ++i) {
        pictures[i] = decode_picture(packed[i], meta.count, most, codecs, names[i], file);
        Bytes().swap(packed[i]);
        require_same_size(pictures[i], names[i]);
    }
    auto const& [low, high, scales, quats, sh0] = pictures;

    SogHarmonics harmonics;
    if (meta.has_harmonics()) {
        auto const& part = meta.harmonics;
        // 64 entries a row, a pixel for each coefficient; at most 65,536 entries, because a label has 16 bits.
        constexpr std::uint64_t most_palette = 65536 * 15;
        harmonics.palette = decode_picture(read(part.files[0]), 1, most_palette, codecs, part.files[0], file);
        harmonics.labels = decode_picture(read(part.files[1]), meta.count, most, codecs, part.files[1], file);
        require_same_size(harmonics.labels, part.files[1]);
        auto const [width, height] = harmonics.palette.size;
        std::uint32_t const by_width = width == 192 ? 1 : width == 512 ? 2 : width == 960 ? 3 : 0;
        bool const said = meta.version == 2 && part.bands != 0;
        harmonics.degree = said ? static_cast<std::uint32_t>(part.bands) : by_width;
        if (harmonics.degree == 0 || harmonics.degree != by_width)
            throw Error(file + " has a palette of harmonics " + std::to_string(width) + " pixels wide (" + in_quotes(part.files[0]) +
                        (said ? "; its key shN.bands says degree " + std::to_string(harmonics.degree) : "") +
                        "; 192, 512 or 960 for degree 1, 2 or 3); export the map again");
        harmonics.width_says = meta.version == 2 && !said;
        harmonics.entries = 64 * std::size_t{height};
        if (meta.version == 2 && part.count >= 0 && part.count < static_cast<double>(harmonics.entries))
            harmonics.entries = static_cast<std::size_t>(part.count);
        harmonics.values = values_of(part, meta.version, 0);
    }

    Map map;
    map.name = std::filesystem::path(name).stem().string();
    map.path = name;
    map.sh_degree = harmonics.degree;
    map.notes.push_back("read as SOG version " + std::to_string(meta.version) + " of degree " + std::to_string(map.sh_degree));
    if (harmonics.width_says)
        map.notes.push_back("shN.bands of meta.json is missing or 0: the palette's width says degree " + std::to_string(map.sh_degree));
    if (meta.antialiased) map.notes.push_back(antialiased_note);
    if (meta.count == 0) map.notes.push_back("meta.json promises no Gaussians: the map is empty");
    MapSink sink(map, meta.count, splat::harmonics_per_channel(map.sh_degree));
    std::array<std::array<double, 256>, 3> scale_of, colour_of;
    for (std::size_t i = 0; i < 3; ++i) {
        scale_of[i] = values_of(meta.scales, meta.version, i);
        colour_of[i] = values_of(meta.sh0, meta.version, i);
    }
    auto const logit_of = meta.version == 1 ? values_of(meta.sh0, 1, 3) : std::array<double, 256>{};
    std::array<double, 3> span{};
    for (std::size_t i = 0; i < 3; ++i) {
        span[i] = meta.means.maxs[i] - meta.means.mins[i];
        if (span[i] == 0.0) span[i] = 1.0; // as the reference reader
    }
    GaussianRow row{};
    for (std::size_t r = 0; r < meta.count; ++r) {
        auto const *const l = low.pixel(r), *const h = high.pixel(r), *const s = scales.pixel(r), *const q = quats.pixel(r), *const c = sh0.pixel(r);
        for (std::size_t i = 0; i < 3; ++i) {
            double const v = meta.means.mins[i] + span[i] * (static_cast<double>(l[i] + 256 * h[i]) / 65535.0);
            double const size = std::exp(std::fabs(v)) - 1.0;
            row[i] = rounded_to_float(v < 0.0 ? -size : size);
            row[3 + i] = colour_of[i][c[i]];
            row[7 + i] = scale_of[i][s[i]];
        }
        row[6] = logit_of[c[3]];
        if (q[3] < 252) {
            sink.reject(r + 1, "its rotation has no largest component");
            continue;
        }
        double squares = 0.0;
        for (std::size_t i = 0, k = 0; i < 4; ++i) {
            if (i == q[3] - 252u) continue;
            double const small = (q[k++] / 255.0 * 2.0 - 1.0) / std::sqrt(2.0);
            squares += small * small;
            row[10 + i] = rounded_to_float(small);
        }
        row[10 + (q[3] - 252u)] = rounded_to_float(std::sqrt(std::fmax(0.0, 1.0 - squares)));
        if (harmonics.degree != 0) {
            auto const* const label = harmonics.labels.pixel(r);
            std::size_t const entry = label[0] + 256u * label[1], per_channel = sink.coefficients() / 3;
            if (entry >= harmonics.entries)
                throw Error(file + " has harmonics that are not in its palette (row " + std::to_string(r + 1) + " names entry " +
                            std::to_string(entry) + " of " + std::to_string(harmonics.entries) + "); export the map again");
            for (std::size_t k = 0; k < per_channel; ++k) {
                auto const* const pixel = harmonics.palette.pixel(entry * per_channel + k);
                for (std::size_t i = 0; i < 3; ++i) row[14 + 3 * k + i] = harmonics.values[pixel[i]];
            }
        }
        auto* const g = sink.add(r + 1, row);
        if (g && meta.version == 2) g->opacity = static_cast<float>(c[3] / 255.0);
    }
    sink.finish();
    return map;
}

} // namespace detail

TILEMESH_HOST Map read_sog(std::istream& stream, std::string const& name, Codecs const& codecs)
{
    std::string const file = detail::shown(name, name.size());
    detail::ByteSource source(stream, file);
    detail::Bytes const bytes = detail::read_rest(source);
    if (!codecs.deflate || !codecs.crc32) detail::refuse_without(file, "is a ZIP archive, as SOG maps are", "zlib", "zlib1g-dev");
    detail::Zip const zip(bytes, codecs, file);
    return detail::read_sog_files([&](std::string const& entry) { return zip.read(entry); }, name, file, codecs);
}

namespace detail {
/// The folder of an SOG map, and its meta.json; a path names either.
struct SogFolder {
    explicit SogFolder(std::filesystem::path const& path)
        : folder(std::filesystem::is_directory(path) ? path : path.parent_path()),
          meta(std::filesystem::is_directory(path) ? path / "meta.json" : path)
    {}
    std::filesystem::path folder, meta;

    std::ifstream open(std::filesystem::path const& file) const
    {
        // A picture of the largest size, 16,383 x 16,383, that does not compress.
        return open_file(file, std::uint64_t{1} << 30, "an SOG map");
    }
};
} // namespace detail

TILEMESH_HOST Map load_sog_folder(std::filesystem::path const& path, Codecs const& codecs)
{
    detail::SogFolder const place(path);
    auto const read = [&](std::string const& name) {
        std::filesystem::path const at = name == "meta.json" ? place.meta : place.folder / name;
        auto stream = place.open(at);
        detail::ByteSource source(stream, detail::shown_path(at));
        return detail::read_rest(source);
    };
    Map map = detail::read_sog_files(read, path.string(), detail::shown_path(path), codecs);
    // "room.sog/meta.json" and "room.sog/" are the map "room".
    std::filesystem::path named = place.meta != path || path.filename() == "meta.json" ? place.folder.lexically_normal() : path;
    if (!named.has_filename()) named = named.parent_path();
    if (named.has_stem()) map.name = named.stem().string();
    return map;
}

TILEMESH_HOST std::vector<std::filesystem::path> sog_folder_files(std::filesystem::path const& path)
{
    detail::SogFolder const place(path);
    auto stream = place.open(place.meta);
    std::vector<std::filesystem::path> files{place.meta};
    for (auto const& name : detail::SogMetaReader(stream, detail::shown_path(path)).read().pictures()) files.push_back(place.folder / name);
    return files;
}

}}} // namespace tilemesh::scene
TILEMESH_EXACT_END
