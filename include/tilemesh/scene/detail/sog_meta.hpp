#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <istream>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/json_reader.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// A part of meta.json of an SOG map: the pictures of an attribute and what their bytes mean.
struct SogPart {
    std::vector<double> mins, maxs, codebook, shape;
    std::vector<std::string> files;
    double count = -1, bands = 0; ///< -1: the file does not say how many entries the palette has; 0: nor its degree
    bool there = false;
};

/// meta.json of an SOG map.
struct SogMeta {
    std::uint32_t version = 1;
    std::uint64_t count = 0;
    bool antialiased = false; ///< trained with anti-aliasing
    SogPart means, scales, quats, sh0, harmonics;

    /// A part shN without pictures is that of a map without harmonics. Its pictures count, not its `bands`: writers leave `bands` out or at 0.
    bool has_harmonics() const { return harmonics.there && !harmonics.files.empty(); }
    /// The names of the pictures that are read.
    std::vector<std::string> pictures() const
    {
        std::vector<std::string> names;
        for (auto const* part : {&means, &scales, &quats, &sh0, &harmonics})
            if (part != &harmonics || has_harmonics()) names.insert(names.end(), part->files.begin(), part->files.end());
        return names;
    }
};

/// Reads meta.json. Throws `Error` for JSON that is not the meta.json of a version that is read, for lists of more than 256 numbers or 2
/// files, and for a part without what the version needs. The message names the key, for example "scales.codebook".
///
/// Version 1 has no number. A file without a number whose scales have a codebook is of version 2, because only version 2 has codebooks.
/// Keys of other writers: `palette_size` for the `count` of shN, and `means.shape` for a missing `count` of a version 2.
/// Anti-aliasing: `antialias` or `antialiased` is true, or `model` is "antialiased", in the object itself or in `asset`.
///
/// The first entry of a codebook may be null. Published files have it, from a writer whose clusters became NaN when a map had too few
/// different values. The reader that these files were published for, PlayCanvas' engine, puts c[1] + (c[1] - c[255]) / 255 there, a step of
/// the list below c[1]; so does this one. A null at another place is refused: no reader gives it a value.
class SogMetaReader {
public:
    SogMetaReader(std::istream& stream, std::string const& file) : file_(file), json_(stream, file, "name an SOG map, or export it again") {}

    SogMeta read()
    {
        SogMeta meta;
        double version = -1, count = -1;
        if (json_.next() != JsonPart::begin_object) refuse("it is not an object");
        for (JsonPart part; (part = json_.next()) != JsonPart::end_object;) {
            std::string const key = json_.text();
            part = json_.next();
            SogPart* const to = key == "means"    ? &meta.means
                                : key == "scales" ? &meta.scales
                                : key == "quats"  ? &meta.quats
                                : key == "sh0"    ? &meta.sh0
                                : key == "shN"    ? &meta.harmonics
                                                  : nullptr;
            if (to && part == JsonPart::begin_object) {
                read_part(*to, key);
            } else if (key == "asset" && part == JsonPart::begin_object) {
                while (json_.next() != JsonPart::end_object) {
                    std::string const inner = json_.text();
                    read_antialiasing(meta.antialiased, inner, json_.next());
                }
            } else if (key == "version" && part == JsonPart::number) {
                version = json_.number();
            } else if (key == "count" && part == JsonPart::number) {
                count = json_.number();
            } else {
                read_antialiasing(meta.antialiased, key, part);
            }
        }
        json_.next(); // refuses more text
        if (!meta.means.there || !meta.scales.there || !meta.quats.there || !meta.sh0.there)
            throw Error(file_ + " is a JSON file without means, scales, quats and sh0 (so it is no meta.json of an SOG map; cameras are no map); "
                                "name a 3DGS map");
        if (version == -1) version = meta.scales.codebook.empty() ? 1 : 2;
        if (version != 1 && version != 2) throw Error(file_ + " is an SOG map of another version (1 and 2 are read); export the map again");
        meta.version = version == 1 ? 1 : 2;
        if (meta.version == 1 || count == -1) count = meta.means.shape.empty() ? -1 : meta.means.shape[0];
        if (!(count >= 0 && count <= 4294967295.0) || count != std::floor(count))
            refuse(std::string("the number of Gaussians is not a whole number below 2^32, key ") + (meta.version == 1 ? "means.shape" : "count"));
        meta.count = static_cast<std::uint64_t>(count);
        check(meta);
        return meta;
    }

private:
    [[noreturn]] void refuse(std::string const& why) const
    {
        throw Error(file_ + " cannot be read as the meta.json of an SOG map (" + why + "); export the map again");
    }

    /// `name` is the part's key.
    void read_part(SogPart& out, std::string const& name)
    {
        out = {};
        out.there = true;
        bool has_count = false;
        for (JsonPart part; (part = json_.next()) != JsonPart::end_object;) {
            std::string const key = json_.text();
            part = json_.next();
            std::vector<double>* const numbers = key == "mins"       ? &out.mins
                                                 : key == "maxs"     ? &out.maxs
                                                 : key == "codebook" ? &out.codebook
                                                 : key == "shape"    ? &out.shape
                                                                     : nullptr;
            if (numbers) {
                read_numbers(*numbers, part, name + "." + key);
            } else if (key == "files" && part == JsonPart::begin_list) {
                while ((part = json_.next()) == JsonPart::text && out.files.size() < 2) out.files.push_back(json_.text());
                if (part != JsonPart::end_list) refuse(name + ".files is not a list of one or two names");
            } else if (key == "count" && part == JsonPart::number) {
                has_count = true;
                out.count = json_.number();
            } else if (key == "palette_size" && part == JsonPart::number) {
                if (!has_count) out.count = json_.number();
            } else if (key == "bands" && part == JsonPart::number) {
                out.bands = json_.number();
            } else {
                json_.skip(part);
            }
        }
        if (has_count && out.count == -1) out.count = -2; // -1 would mean that there is no count
    }
    /// A list of numbers, or one number.
    void read_numbers(std::vector<double>& out, JsonPart part, std::string const& key)
    {
        out.clear();
        if (part == JsonPart::number) return out.push_back(json_.number());
        if (part != JsonPart::begin_list) return json_.skip(part);
        bool first_is_null = false;
        for (; (part = json_.next()) != JsonPart::end_list; out.push_back(part == JsonPart::number ? json_.number() : 0.0)) {
            bool const null = part == JsonPart::other && json_.text() == "null";
            if (null && (!key.ends_with(".codebook") || !out.empty()))
                refuse(key + " has null at entry " + std::to_string(out.size()) + "; only entry 0 of a codebook may be null");
            first_is_null = first_is_null || null;
            if ((part != JsonPart::number && !null) || out.size() == 256) refuse(key + " is not a list of at most 256 numbers");
        }
        // The value that PlayCanvas' engine takes.
        if (first_is_null && out.size() == 256) out[0] = out[1] + (out[1] - out[255]) / 255.0;
    }
    /// Reads the value of a key that may say that the map was trained with anti-aliasing.
    void read_antialiasing(bool& found, std::string const& key, JsonPart part)
    {
        bool const flag = key == "antialias" || key == "antialiased";
        if (flag && part == JsonPart::other) found = json_.text() == "true";
        else if (flag && part == JsonPart::number) found = json_.number() != 0.0;
        else if (key == "model" && part == JsonPart::text) found = json_.text() == "antialiased";
        else json_.skip(part);
    }

    void check(SogMeta const& meta) const
    {
        auto const has = [&](SogPart const& part, char const* name, std::size_t files) {
            if (part.files.size() != files)
                refuse(std::string(name) + ".files names " + std::to_string(part.files.size()) + " files, not " + std::to_string(files));
            for (auto const& file : part.files)
                if (file.empty() || file.front() == '.' || file.find_first_of("/\\") != file.npos || file.find('\0') != file.npos)
                    refuse(std::string(name) + ".files: the file name " + in_quotes(file) + " leaves the map's folder");
        };
        auto const lists = [&](SogPart const& part, char const* name, std::size_t ranges) {
            if (meta.version == 2 && part.codebook.size() != 256) refuse(std::string(name) + " has no codebook of 256 numbers");
            if (meta.version == 1 && (part.mins.size() != ranges || part.maxs.size() != ranges))
                refuse(std::string(name) + " has no mins and maxs of " + std::to_string(ranges) + " numbers");
        };
        has(meta.means, "means", 2);
        if (meta.means.mins.size() != 3 || meta.means.maxs.size() != 3) refuse("means has no mins and maxs of 3 numbers");
        has(meta.scales, "scales", 1);
        lists(meta.scales, "scales", 3);
        has(meta.quats, "quats", 1);
        has(meta.sh0, "sh0", 1);
        lists(meta.sh0, "sh0", 4);
        if (!meta.harmonics.there) return;
        auto const& n = meta.harmonics;
        if (n.files.empty() && n.bands == 0) return; // a map of degree 0
        has(n, "shN", 2);
        lists(meta.harmonics, "shN", 1);
        if (meta.version == 2 && !(n.bands == 0 || n.bands == 1 || n.bands == 2 || n.bands == 3)) refuse("shN has no bands of 0 to 3");
        if (meta.version == 2 && !(n.count == -1 || (n.count >= 0 && n.count <= 65536))) refuse("shN has no count of at most 65,536");
    }

    std::string const& file_;
    JsonReader json_;
};

}}} // namespace tilemesh::v0_2::scene::detail
