#pragma once
#include <cstddef>
#include <cstdint>
#include <tilemesh/config.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/harmonics.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// A map's records on the host, by rows: Gaussians and, if the map has them, harmonics of one degree. The degree is a value, not a type, so
/// that maps of all degrees share their code. It is the renderer's one copy of the map.
class RecordTable {
public:
    /// `degree`: the degree of the setup's records. Throws Error if the map has a higher degree, if coefficients are missing, if two
    /// Gaussians have the same id, or if a Gaussian has the id 0. A map that is moved here is not copied.
    RecordTable(scene::Map map, std::uint32_t degree);

    /// Puts the rows into another order: row r becomes row place_of(r). Memory: twice the table's.
    template <class PlaceOf>
    void reorder(PlaceOf const& place_of)
    {
        std::vector<std::uint32_t> row_at(rows());
        for (std::uint32_t row = 0; row < rows(); ++row) row_at[place_of(row)] = row;
        take(row_at);
    }

    std::uint32_t rows() const noexcept { return static_cast<std::uint32_t>(map_.gaussians.size()); }
    splat::GaussianId id(std::uint32_t row) const noexcept { return map_.gaussians[row].id; }
    std::vector<splat::Gaussian> const& gaussians() const noexcept { return map_.gaussians; }
    /// The records as a map, in the order of rows.
    scene::Map const& map() const noexcept { return map_; }

    /// A table of several processes has a share of the rows (render/ranks/record_share.hpp): the rows of all shares, the first of this one, and
    /// whether a row of the map is here.
    std::uint32_t all_rows() const noexcept { return rows(); }
    std::uint32_t first_row() const noexcept { return 0; }
    bool has_row(std::uint32_t) const noexcept { return true; }

    /// Row `row` as a record that the machine stores, Gaussian or ShadedGaussian. Coefficients that the map does not have are zero.
    template <class Record>
    Record record(std::uint32_t row) const noexcept
    {
        Record g{};
        static_cast<splat::Gaussian&>(g) = map_.gaussians[row];
        if constexpr (Record::sh_degree > 0)
            for (std::size_t i = 0; i < floats_a_row(); ++i) g.harmonics[i] = harmonics_of(row)[i];
        return g;
    }

    /// A digest of all rows. Cost: a pass over the table.
    std::uint64_t digest() const noexcept;

protected:
    [[noreturn]] static void refuse_id(splat::GaussianId id);
    std::size_t floats_a_row() const noexcept { return 3 * std::size_t{splat::harmonics_per_channel(map_.sh_degree)}; }
    float const* harmonics_of(std::uint32_t row) const noexcept { return map_.harmonics.data() + row * floats_a_row(); }

    scene::Map map_;

private:
    void take(std::vector<std::uint32_t> const& row_at); ///< row i of the new order is row row_at[i]
};

}}} // namespace tilemesh::render

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/render/detail/record_table_code.hpp>
#endif
