#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/engine/digest.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/render/detail/sorted_table.hpp>
#include <tilemesh/render/record_table.hpp>
#include <tilemesh/scene/records.hpp>
#include <tilemesh/splat/project_all.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

TILEMESH_HOST RecordTable::RecordTable(scene::Map map, std::uint32_t degree) : map_(std::move(map))
{
    if (map_.sh_degree > degree)
        throw Error("a map with view-dependent colour of degree " + std::to_string(map_.sh_degree) +
                    " (the setup's records hold degree " + std::to_string(degree) +
                    "); render it with fit_renderer or a Fitted<Lossless, " + std::to_string(map_.sh_degree) +
                    "> setup, or give up the rest with scene::at_degree");
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
TILEMESH_HOST splat::Splat RecordTable::project(std::uint32_t row, splat::View const& view, splat::Tiling const& tiling) const noexcept
{
    auto s = splat::project(map_.gaussians[row], view, tiling);
    if (s.visible() && !shade(row, view, s)) s = {};
    return s;
}
TILEMESH_HOST void RecordTable::project(std::uint32_t first, std::uint32_t n, splat::View const& view, splat::Tiling const& tiling,
                                        splat::Splat* out) const noexcept
{
    splat::project_all(map_.gaussians.data() + first, n, view, tiling, out);
    if (map_.sh_degree == 0) return;
    for (std::uint32_t i = 0; i < n; ++i)
        if (out[i].visible() && !shade(first + i, view, out[i])) out[i] = {};
}
TILEMESH_HOST void RecordTable::project_rows(std::uint32_t const* rows, std::uint32_t n, splat::View const& view, splat::Tiling const& tiling,
                                             splat::Splat* out) const noexcept
{
    constexpr std::uint32_t at_once = 64;
    splat::Gaussian some[at_once];
    for (std::uint32_t from = 0; from < n; from += at_once) {
        std::uint32_t const count = n - from < at_once ? n - from : at_once;
        for (std::uint32_t i = 0; i < count; ++i) some[i] = map_.gaussians[rows[from + i]];
        splat::project_all(some, count, view, tiling, out + from);
        for (std::uint32_t i = 0; i < count && map_.sh_degree != 0; ++i)
            if (out[from + i].visible() && !shade(rows[from + i], view, out[from + i])) out[from + i] = {};
    }
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
TILEMESH_HOST bool RecordTable::shade(std::uint32_t row, splat::View const& view, splat::Splat& s) const noexcept
{
    auto const& g = map_.gaussians[row];
    switch (map_.sh_degree) {
    case 1:
        return splat::shade<1>(g, harmonics_of(row), view, s);
    case 2:
        return splat::shade<2>(g, harmonics_of(row), view, s);
    case 3:
        return splat::shade<3>(g, harmonics_of(row), view, s);
    default:
        return true;
    }
}

}}} // namespace tilemesh::render
