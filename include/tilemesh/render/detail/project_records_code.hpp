#pragma once
#include <cstddef>
#include <cstdint>
#include <tilemesh/render/project_records.hpp>
#include <tilemesh/splat/harmonics.hpp>
#include <tilemesh/splat/project_all.hpp>

namespace tilemesh { inline namespace v0_2 { namespace render {

namespace detail {
/// Gives the visible splat of a row its colour in this view. Returns false if it has none; then nothing of it shows.
TILEMESH_HOST bool shade(scene::Map const& map, std::uint32_t row, splat::View const& view, splat::Splat& s) noexcept
{
    auto const& g = map.gaussians[row];
    float const* const harmonics = map.harmonics.data() + std::size_t{row} * 3 * splat::harmonics_per_channel(map.sh_degree);
    switch (map.sh_degree) {
    case 1:
        return splat::shade<1>(g, harmonics, view, s);
    case 2:
        return splat::shade<2>(g, harmonics, view, s);
    case 3:
        return splat::shade<3>(g, harmonics, view, s);
    default:
        return true;
    }
}
} // namespace detail

TILEMESH_HOST splat::Splat project_row(RecordTable const& records, std::uint32_t row, splat::View const& view,
                                       splat::Tiling const& tiling) noexcept
{
    auto s = splat::project(records.gaussians()[row], view, tiling);
    if (s.visible() && !detail::shade(records.map(), row, view, s)) s = {};
    return s;
}
TILEMESH_HOST void project_rows(RecordTable const& records, std::uint32_t first, std::uint32_t n, splat::View const& view,
                                splat::Tiling const& tiling, splat::Splat* out) noexcept
{
    splat::project_all(records.gaussians().data() + first, n, view, tiling, out);
    if (records.map().sh_degree == 0) return;
    for (std::uint32_t i = 0; i < n; ++i)
        if (out[i].visible() && !detail::shade(records.map(), first + i, view, out[i])) out[i] = {};
}
TILEMESH_HOST void project_listed(RecordTable const& records, std::uint32_t const* rows, std::uint32_t n, splat::View const& view,
                                splat::Tiling const& tiling, splat::Splat* out) noexcept
{
    constexpr std::uint32_t at_once = 64;
    splat::Gaussian some[at_once];
    for (std::uint32_t from = 0; from < n; from += at_once) {
        std::uint32_t const count = n - from < at_once ? n - from : at_once;
        for (std::uint32_t i = 0; i < count; ++i) some[i] = records.gaussians()[rows[from + i]];
        splat::project_all(some, count, view, tiling, out + from);
        for (std::uint32_t i = 0; i < count && records.map().sh_degree != 0; ++i)
            if (out[from + i].visible() && !detail::shade(records.map(), rows[from + i], view, out[from + i])) out[from + i] = {};
    }
}

}}} // namespace tilemesh::render
