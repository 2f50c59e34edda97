#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/render/over_ranks.hpp>
#include <tilemesh/render/row_shares.hpp>
#include <tilemesh/render/sorted_table.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/project_all.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// A map's records on the host, by rows: Gaussians and, if the map has them, harmonics of one degree. The degree is a value, not a type, so
/// that maps of all degrees share their code.
///
/// On an engine over several processes, `share` leaves each process its share of the rows. Functions with a row then count rows from the
/// first row of this process.
class RecordTable {
public:
    /// `degree`: the degree of the setup's records. Throws Error if the map has a higher degree, if coefficients are missing, if two
    /// Gaussians have the same id, or if a Gaussian has the id 0.
    RecordTable(scene::Map const& map, std::uint32_t degree);

    /// Over several processes: of a whole map, each process keeps an equal share. `in_parts` above 0: the processes have parts of one map of
    /// so many rows. Every process calls it, once. Throws Error if the parts have another sum of rows, or two of them have the same id.
    /// Cost: with parts, one exchange of 8 bytes a row.
    template <class M>
    void share([[maybe_unused]] M& mesh, [[maybe_unused]] std::uint32_t in_parts)
    {
        if constexpr (over_ranks<M>) {
            if (in_parts != 0) {
                auto parts = RowShares::of_parts(mesh, rows());
                if (parts.rows() != in_parts)
                    throw Error("parts of a map with " + std::to_string(parts.rows()) + " rows (the options say " + std::to_string(in_parts) +
                                "); give each process its part, and the number of all rows");
                require_other_ids(mesh, parts.first());
                shares_ = std::move(parts);
                return;
            }
            std::optional<RowShares> equal; // an empty one takes no memory
            auto harmonics = std::vector<float>();
            auto gaussians = std::vector<splat::Gaussian>();
            together(mesh, [&] {
                equal.emplace(rows(), processes(mesh), this_process(mesh));
                auto const keep = [&](auto const& items, auto& kept, std::size_t a_row) {
                    auto const own = this_process(mesh);
                    kept.assign(items.begin() + static_cast<std::ptrdiff_t>(equal->first(own) * a_row),
                                items.begin() + static_cast<std::ptrdiff_t>(equal->last(own) * a_row));
                };
                keep(harmonics_, harmonics, floats_a_row());
                keep(gaussians_, gaussians, 1);
            });
            take(std::move(gaussians), std::move(harmonics), std::move(*equal)); // all processes, or none
        }
    }
    /// Gives every process other rows, in another order: row r becomes row `place_of(r)` of all rows, and each process then has an equal
    /// share. `Record`: a record that has room for a row. Every process calls it after `share`. Memory: twice this process's records.
    template <class Record, class M, class PlaceOf>
    void reorder(M& mesh, PlaceOf const& place_of)
    {
        struct Moved {
            std::uint32_t row;
            Record record;
        };
        std::vector<Moved> moved;
        std::vector<std::uint64_t> counts;
        std::optional<RowShares> equal;
        auto const in_order = [&] { std::sort(moved.begin(), moved.end(), [](Moved const& a, Moved const& b) { return a.row < b.row; }); };
        together(mesh, [&] {
            equal.emplace(all_rows(), processes(mesh), this_process(mesh));
            counts.assign(processes(mesh), 0);
            moved.reserve(rows());
            for (std::uint32_t row = 0; row < rows(); ++row) {
                moved.push_back({static_cast<std::uint32_t>(place_of(shares_.first() + row)), record<Record>(row)});
                ++counts[equal->process_of(moved.back().row)];
            }
            in_order();
        });
        moved = deal(mesh, std::move(moved), counts);
        auto harmonics = std::vector<float>();
        auto gaussians = std::vector<splat::Gaussian>();
        together(mesh, [&] {
            in_order();
            gaussians.reserve(moved.size());
            harmonics.reserve(moved.size() * floats_a_row());
            for (auto const& m : moved) {
                gaussians.push_back(m.record);
                if constexpr (Record::sh_degree > 0) harmonics.insert(harmonics.end(), m.record.harmonics, m.record.harmonics + floats_a_row());
            }
        });
        take(std::move(gaussians), std::move(harmonics), std::move(*equal));
    }
    /// The shares of all processes.
    RowShares const& shares() const noexcept { return shares_; }
    /// The rows of all processes.
    std::uint32_t all_rows() const noexcept { return static_cast<std::uint32_t>(shares_.rows()); }

    /// The rows of this process.
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
    splat::Splat project(std::uint32_t row, splat::View const& view, splat::Tiling const& tiling) const noexcept;
    /// Projects n rows from `first` on, several at once.
    void project(std::uint32_t first, std::uint32_t n, splat::View const& view, splat::Tiling const& tiling,
                 splat::Splat* out) const noexcept;
    /// Projects n rows, in any order, several at once.
    void project_rows(std::uint32_t const* rows, std::uint32_t n, splat::View const& view, splat::Tiling const& tiling,
                      splat::Splat* out) const noexcept;
    /// The bits of the view depth of row `row`, as `project` computes it; 0 if it is not greater than `near_depth`, or not finite.
    std::uint32_t depth_bits(std::uint32_t row, splat::View const& view) const noexcept
    {
        return splat::depth_bits(gaussians_[row], view);
    }

    /// A digest of all rows. Cost: a pass over the table.
    std::uint64_t digest() const noexcept;

private:
    void take(std::vector<splat::Gaussian>&& gaussians, std::vector<float>&& harmonics, RowShares&& shares) noexcept
    {
        gaussians_ = std::move(gaussians);
        harmonics_ = std::move(harmonics);
        shares_ = std::move(shares);
    }
    [[noreturn]] static void refuse_id(splat::GaussianId id);
    /// Throws Error if two processes have the same id. Each process compares some of the ids: those that leave its number as remainder.
    /// `first_row`: the first row of this process.
    template <class M>
    void require_other_ids(M& mesh, std::uint32_t first_row) const
    {
        struct Known {
            std::uint32_t id, row;
        };
        std::vector<Known> ids;
        std::vector<std::uint64_t> counts;
        auto const process_of_id = [&](std::uint32_t id) { return id % processes(mesh); };
        together(mesh, [&] {
            counts.assign(processes(mesh), 0);
            ids.reserve(rows());
            for (std::uint32_t row = 0; row < rows(); ++row) {
                ids.push_back({static_cast<std::uint32_t>(id(row)), first_row + row});
                ++counts[process_of_id(ids.back().id)];
            }
            std::stable_sort(ids.begin(), ids.end(), [&](Known a, Known b) { return process_of_id(a.id) < process_of_id(b.id); });
        });
        ids = deal(mesh, std::move(ids), counts);
        constexpr std::uint64_t none = ~std::uint64_t{0} >> 1; // processes compare words below 2^63
        std::uint64_t first = none, own = none, known_by = none;
        std::sort(ids.begin(), ids.end(), [](Known a, Known b) { return a.id != b.id ? a.id < b.id : a.row < b.row; });
        for (std::size_t i = 1; i < ids.size(); ++i)
            if (ids[i].id == ids[i - 1].id && ids[i].row < own) own = ids[i].row, known_by = ids[i].id;
        first = own;
        least(mesh, &first, 1);
        if (own != first) known_by = none;
        least(mesh, &known_by, 1);
        if (first != none) refuse_id(splat::GaussianId{static_cast<std::uint32_t>(known_by)});
    }
    std::size_t floats_a_row() const noexcept { return 3 * std::size_t{splat::harmonics_per_channel(degree_)}; }
    float const* harmonics_of(std::uint32_t row) const noexcept { return harmonics_.data() + row * floats_a_row(); }
    bool shade(std::uint32_t row, splat::View const& view, splat::Splat& s) const noexcept;

    std::vector<splat::Gaussian> gaussians_;
    std::vector<float> harmonics_;
    RowShares shares_;
    std::uint32_t degree_;
};

}}} // namespace tilemesh::render

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/render/detail/record_table_code.hpp>
#endif
