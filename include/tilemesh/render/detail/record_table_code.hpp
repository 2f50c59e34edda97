#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/engine/digest.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/render/detail/sorted_table.hpp>
#include <tilemesh/render/record_table.hpp>
#include <tilemesh/scene/records.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

TILEMESH_HOST RecordTable::RecordTable(scene::Map map, std::uint32_t degree) : map_(std::move(map))
{
    if (map_.sh_degree > degree)
        throw Error("a map with view-dependent colour of degree " + std::to_string(map_.sh_degree) +
                    " (the setup's records hold degree " + std::to_string(degree) +
                    "); give the records that degree (splat::fitted(setup, " + std::to_string(map_.sh_degree) +
                    ")), or give up the rest with scene::at_degree");
    scene::require_harmonics(map_);
    SortedTable ids;
    ids.reserve(rows());
    for (std::uint32_t row = 0; row < rows(); ++row) ids.add(static_cast<std::uint32_t>(id(row)), row);
    bool const unique = ids.sort();
    for (std::uint32_t row = 0; row < rows(); ++row)
        if (id(row) == splat::GaussianId::none || (!unique && *ids.find(static_cast<std::uint32_t>(id(row))) != row)) refuse_id(id(row));
}
TILEMESH_HOST void RecordTable::take(std::vector<std::uint32_t> const& row_at)
{
    std::vector<splat::Gaussian> gaussians;
    std::vector<float> harmonics;
    gaussians.reserve(row_at.size());
    harmonics.reserve(map_.harmonics.size());
    for (auto const row : row_at) {
        gaussians.push_back(map_.gaussians[row]);
        harmonics.insert(harmonics.end(), harmonics_of(row), harmonics_of(row) + floats_a_row());
    }
    map_.gaussians = std::move(gaussians);
    map_.harmonics = std::move(harmonics);
}
TILEMESH_HOST std::uint64_t RecordTable::digest() const noexcept
{
    auto const mixed = [](std::uint64_t h, auto const& items) {
        for (auto const& item : items) {
            std::uint32_t words[sizeof item / 4];
            __builtin_memcpy(words, &item, sizeof item);
            h = engine::mix_words(h, words, sizeof item / 4);
        }
        return h;
    };
    return mixed(mixed(map_.sh_degree, map_.gaussians), map_.harmonics);
}
TILEMESH_HOST void RecordTable::refuse_id(splat::GaussianId id)
{
    throw Error("two Gaussians with id " + std::to_string(static_cast<std::uint32_t>(id)) +
                ", or an id of 0 (a record is known by its id); number them from 1");
}

}}} // namespace tilemesh::render
