#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/engine/digest.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/render/sorted_table.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/scene/records.hpp>
#include <tilemesh/splat/project_all.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// A map's records on the host, by rows: Gaussians and, if the map has them, harmonics of one degree. The degree is a value, not a type, so
/// that maps of all degrees share their code.
class RecordTable {
public:
    /// `degree`: the degree of the setup's records. Throws Error if the map has a higher degree, if coefficients are missing, if two
    /// Gaussians have the same id, or if a Gaussian has the id 0.
    RecordTable(scene::Map const& map, std::uint32_t degree) : gaussians_(map.gaussians), degree_(map.sh_degree)
    {
        if (map.sh_degree > degree)
            throw Error("a map with view-dependent colour of degree " + std::to_string(map.sh_degree) +
                        " (the setup's records hold degree " + std::to_string(degree) +
                        "); render it with fit_renderer or a Fitted<Lossless, " + std::to_string(map.sh_degree) +
                        "> setup, or give up the rest with scene::at_degree");
        scene::require_harmonics(map);
        harmonics_ = map.harmonics;
        SortedTable ids;
        ids.reserve(gaussians_.size());
        for (std::uint32_t row = 0; row < rows(); ++row) ids.add(static_cast<std::uint32_t>(id(row)), row);
        bool const unique = ids.sort();
        for (std::uint32_t row = 0; row < rows(); ++row)
            if (id(row) == splat::GaussianId::none || (!unique && *ids.find(static_cast<std::uint32_t>(id(row))) != row))
                throw Error("two Gaussians with id " + std::to_string(static_cast<std::uint32_t>(id(row))) +
                            ", or an id of 0 (a record is known by its id); number them from 1");
    }

    std::uint32_t rows() const noexcept { return static_cast<std::uint32_t>(gaussians_.size()); }
    splat::GaussianId id(std::uint32_t row) const noexcept { return gaussians_[row].id; }

    /// Row `row` as a record that the machine stores, Gaussian or ShadedGaussian. Coefficients that the map does not have are zero.
    template <class Record>
    Record record(std::uint32_t row) const noexcept
    {
        Record g{};
        static_cast<splat::Gaussian&>(g) = gaussians_[row];
        if constexpr (Record::sh_degree > 0)
            for (std::size_t i = 0; i < floats_a_row(); ++i) g.harmonics[i] = harmonics_of(row)[i];
        return g;
    }

    /// Row `row`, projected as by a tile that holds the record.
    splat::Splat project(std::uint32_t row, splat::View const& view, splat::Tiling const& tiling) const noexcept
    {
        auto s = splat::project(gaussians_[row], view, tiling);
        if (s.visible() && !shade(row, view, s)) s = {};
        return s;
    }
    /// Projects n rows from `first` on, several at once.
    void project(std::uint32_t first, std::uint32_t n, splat::View const& view, splat::Tiling const& tiling,
                 splat::Splat* out) const noexcept
    {
        splat::project_all(gaussians_.data() + first, n, view, tiling, out);
        if (degree_ == 0) return;
        for (std::uint32_t i = 0; i < n; ++i)
            if (out[i].visible() && !shade(first + i, view, out[i])) out[i] = {};
    }

    /// Projects n rows, in any order, several at once.
    void project_rows(std::uint32_t const* rows, std::uint32_t n, splat::View const& view, splat::Tiling const& tiling,
                      splat::Splat* out) const noexcept
    {
        constexpr std::uint32_t at_once = 64;
        splat::Gaussian some[at_once];
        for (std::uint32_t from = 0; from < n; from += at_once) {
            std::uint32_t const count = n - from < at_once ? n - from : at_once;
            for (std::uint32_t i = 0; i < count; ++i) some[i] = gaussians_[rows[from + i]];
            splat::project_all(some, count, view, tiling, out + from);
            for (std::uint32_t i = 0; i < count && degree_ != 0; ++i)
                if (out[from + i].visible() && !shade(rows[from + i], view, out[from + i])) out[from + i] = {};
        }
    }
    /// The bits of the view depth of row `row`, as `project` computes it; 0 if it is not greater than `near_depth`, or not finite.
    std::uint32_t depth_bits(std::uint32_t row, splat::View const& view) const noexcept
    {
        return splat::depth_bits(gaussians_[row], view);
    }

    /// A digest of all rows. Cost: a pass over the table.
    std::uint64_t digest() const noexcept
    {
        auto const mixed = [](std::uint64_t h, auto const& items) {
            for (auto const& item : items) {
                std::uint32_t words[sizeof item / 4];
                __builtin_memcpy(words, &item, sizeof item);
                h = engine::mix_words(h, words, sizeof item / 4);
            }
            return h;
        };
        return mixed(mixed(degree_, gaussians_), harmonics_);
    }

private:
    std::size_t floats_a_row() const noexcept { return 3 * std::size_t{splat::harmonics_per_channel(degree_)}; }
    float const* harmonics_of(std::uint32_t row) const noexcept { return harmonics_.data() + row * floats_a_row(); }
    bool shade(std::uint32_t row, splat::View const& view, splat::Splat& s) const noexcept
    {
        auto const& g = gaussians_[row];
        switch (degree_) {
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

    std::vector<splat::Gaussian> gaussians_;
    std::vector<float> harmonics_;
    std::uint32_t degree_;
};

}}} // namespace tilemesh::render
