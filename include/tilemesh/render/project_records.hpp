#pragma once
#include <cstdint>
#include <tilemesh/config.hpp>
#include <tilemesh/render/record_table.hpp>
#include <tilemesh/splat/projection.hpp>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// The splat of a row, as a tile projects the record that it holds: with the record's harmonics, if there are any.
splat::Splat project_row(RecordTable const& records, std::uint32_t row, splat::View const& view, splat::Tiling const& tiling) noexcept;
/// Projects n rows from `first` on, several at once.
void project_rows(RecordTable const& records, std::uint32_t first, std::uint32_t n, splat::View const& view, splat::Tiling const& tiling,
                  splat::Splat* out) noexcept;
/// Projects the n rows that a list names, in its order, several at once.
void project_listed(RecordTable const& records, std::uint32_t const* rows, std::uint32_t n, splat::View const& view,
                  splat::Tiling const& tiling, splat::Splat* out) noexcept;

}}} // namespace tilemesh::render

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/render/detail/project_records_code.hpp>
#endif
