#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <istream>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/json_reader.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
#include <tilemesh/scene/detail/sog_meta.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

TILEMESH_HOST std::vector<std::string> SogMeta::pictures() const
{
    std::vector<std::string> names;
    for (auto const* part : {&means, &scales, &quats, &sh0, &harmonics})
        if (part != &harmonics || has_harmonics()) names.insert(names.end(), part->files.begin(), part->files.end());
    return names;
}

TILEMESH_HOST auto SogMetaReader::read() -> SogMeta
{
    SogMeta meta;
    double version = 1, count = -1;
    if (json_.next() != JsonPart::begin_object) refuse("it is not an object");
    for (JsonPart part; (part = json_.next()) != JsonPart::end_object;) {
        std::string const key = json_.text();
        part = json_.next();
        SogPart* const to = key == "means" ? &meta.means : key == "scales" ? &meta.scales : key == "quats" ? &meta.quats
                            : key == "sh0" ? &meta.sh0 : key == "shN" ? &meta.harmonics : nullptr;
        if (to && part == JsonPart::begin_object) read_part(*to);
        else if (key == "version" && part == JsonPart::number) version = json_.number();
        else if (key == "count" && part == JsonPart::number) count = json_.number();
        else json_.skip(part);
    }
    json_.next(); // refuses more text
    if (!meta.means.there || !meta.scales.there || !meta.quats.there || !meta.sh0.there)
        throw Error(file_ + " is a JSON file without means, scales, quats and sh0 (so it is no meta.json of an SOG map; cameras are no map); "
                            "name a 3DGS map");
    if (version != 1 && version != 2) throw Error(file_ + " is an SOG map of another version (1 and 2 are read); export the map again");
    meta.version = version == 1 ? 1 : 2;
    if (meta.version == 1) count = meta.means.shape.empty() ? -1 : meta.means.shape[0];
    if (!(count >= 0 && count <= 4294967295.0) || count != std::floor(count)) refuse("the number of Gaussians is not a whole number below 2^32");
    meta.count = static_cast<std::uint64_t>(count);
    check(meta);
    return meta;
}

TILEMESH_HOST void SogMetaReader::refuse(std::string const& why) const
{
    throw Error(file_ + " cannot be read as the meta.json of an SOG map (" + why + "); export the map again");
}

TILEMESH_HOST void SogMetaReader::read_part(SogPart& out)
{
    out = {};
    out.there = true;
    for (JsonPart part; (part = json_.next()) != JsonPart::end_object;) {
        std::string const key = json_.text();
        part = json_.next();
        std::vector<double>* const numbers = key == "mins" ? &out.mins : key == "maxs" ? &out.maxs : key == "codebook" ? &out.codebook
                                             : key == "shape" ? &out.shape : nullptr;
        if (numbers) {
            read_numbers(*numbers, part);
        } else if (key == "files" && part == JsonPart::begin_list) {
            while ((part = json_.next()) == JsonPart::text && out.files.size() < 2) out.files.push_back(json_.text());
            if (part != JsonPart::end_list) refuse("files is not a list of one or two names");
        } else if (key == "count" && part == JsonPart::number) {
            out.count = json_.number();
        } else if (key == "bands" && part == JsonPart::number) {
            out.bands = json_.number();
        } else {
            json_.skip(part);
        }
    }
}

TILEMESH_HOST void SogMetaReader::read_numbers(std::vector<double>& out, JsonPart part)
{
    out.clear();
    if (part == JsonPart::number) return out.push_back(json_.number());
    if (part != JsonPart::begin_list) return json_.skip(part);
    while ((part = json_.next()) == JsonPart::number && out.size() < 256) out.push_back(json_.number());
    if (part != JsonPart::end_list) refuse("a list is not of at most 256 numbers");
}

TILEMESH_HOST void SogMetaReader::check(SogMeta const& meta) const
{
    auto const has = [&](SogPart const& part, char const* name, std::size_t files) {
        if (part.files.size() != files) refuse(std::string(name) + " names " + std::to_string(part.files.size()) + " files");
        for (auto const& file : part.files)
            if (file.empty() || file.front() == '.' || file.find_first_of("/\\") != file.npos || file.find('\0') != file.npos)
                refuse("the file name " + in_quotes(file) + " leaves the map's folder");
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
    has(meta.harmonics, "shN", 2);
    lists(meta.harmonics, "shN", 1);
    auto const& n = meta.harmonics;
    if (meta.version == 2 && !(n.bands == 0 || n.bands == 1 || n.bands == 2 || n.bands == 3)) refuse("shN has no bands of 0 to 3");
    if (meta.version == 2 && !(n.count >= 0 && n.count <= 65536)) refuse("shN has no count of at most 65,536");
}

}}} // namespace tilemesh::scene
