#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/render/ranks/row_shares.hpp>
#include <tilemesh/render/record_table.hpp>
#include <tilemesh/scene/map.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// The records of one of several processes: a share of a map's rows. Functions with a row count from the first row of this process.
class RecordShare : public RecordTable {
public:
    /// As RecordTable: the whole map, or this process's part of it.
    RecordShare(scene::Map map, std::uint32_t degree) : RecordTable(std::move(map), degree), shares_(rows()) {}

    /// Of a whole map, each process keeps an equal share. `in_parts` above 0: the processes have parts of one map of so many rows. Every
    /// process calls it, once. Throws Error if the parts have another sum of rows, or two of them have the same id. Cost: with parts, one
    /// exchange of 8 bytes a row.
    template <class M>
    void share(M& mesh, std::uint32_t in_parts)
    {
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
        std::vector<float> harmonics;
        std::vector<splat::Gaussian> gaussians;
        mesh.together([&] {
            equal.emplace(rows(), mesh.ranks(), mesh.rank());
            auto const keep = [&](auto const& items, auto& kept, std::size_t a_row) {
                kept.assign(items.begin() + static_cast<std::ptrdiff_t>(equal->first(mesh.rank()) * a_row),
                            items.begin() + static_cast<std::ptrdiff_t>(equal->last(mesh.rank()) * a_row));
            };
            keep(map_.harmonics, harmonics, floats_a_row());
            keep(map_.gaussians, gaussians, 1);
        });
        take(std::move(gaussians), std::move(harmonics), std::move(*equal)); // all processes, or none
    }
    /// Gives every process other rows, in another order: row r becomes row place_of(r) of all rows, and each process then has an equal
    /// share. `Record`: a record that has room for a row. Every process calls it after `share`. Memory: twice this process's records.
    template <class Record, class M, class PlaceOf>
    void deal(M& mesh, PlaceOf const& place_of)
    {
        struct Moved {
            std::uint32_t row;
            Record record;
        };
        std::vector<Moved> moved;
        std::vector<std::uint64_t> counts;
        std::optional<RowShares> equal;
        auto const in_order = [&] { std::sort(moved.begin(), moved.end(), [](Moved const& a, Moved const& b) { return a.row < b.row; }); };
        mesh.together([&] {
            equal.emplace(all_rows(), mesh.ranks(), mesh.rank());
            counts.assign(mesh.ranks(), 0);
            moved.reserve(rows());
            for (std::uint32_t row = 0; row < rows(); ++row) {
                moved.push_back({static_cast<std::uint32_t>(place_of(first_row() + row)), record<Record>(row)});
                ++counts[equal->process_of(moved.back().row)];
            }
            in_order();
        });
        moved = mesh.deal(std::move(moved), counts);
        std::vector<float> harmonics;
        std::vector<splat::Gaussian> gaussians;
        mesh.together([&] {
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

    RowShares const& shares() const noexcept { return shares_; }
    /// As in RecordTable.
    std::uint32_t all_rows() const noexcept { return static_cast<std::uint32_t>(shares_.rows()); }
    std::uint32_t first_row() const noexcept { return shares_.first(); }
    bool has_row(std::uint32_t row) const noexcept { return shares_.is_own(row); }

private:
    void take(std::vector<splat::Gaussian>&& gaussians, std::vector<float>&& harmonics, RowShares&& shares) noexcept
    {
        map_.gaussians = std::move(gaussians);
        map_.harmonics = std::move(harmonics);
        shares_ = std::move(shares);
    }
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
        auto const process_of_id = [&](std::uint32_t id) { return id % mesh.ranks(); };
        mesh.together([&] {
            counts.assign(mesh.ranks(), 0);
            ids.reserve(rows());
            for (std::uint32_t row = 0; row < rows(); ++row) {
                ids.push_back({static_cast<std::uint32_t>(id(row)), first_row + row});
                ++counts[process_of_id(ids.back().id)];
            }
            std::stable_sort(ids.begin(), ids.end(), [&](Known a, Known b) { return process_of_id(a.id) < process_of_id(b.id); });
        });
        ids = mesh.deal(std::move(ids), counts);
        constexpr std::uint64_t none = ~std::uint64_t{0} >> 1; // processes compare words below 2^63
        std::uint64_t own = none, known_by = none;
        std::sort(ids.begin(), ids.end(), [](Known a, Known b) { return a.id != b.id ? a.id < b.id : a.row < b.row; });
        for (std::size_t i = 1; i < ids.size(); ++i)
            if (ids[i].id == ids[i - 1].id && ids[i].row < own) own = ids[i].row, known_by = ids[i].id;
        std::uint64_t first = own;
        mesh.least(&first, 1);
        if (own != first) known_by = none;
        mesh.least(&known_by, 1);
        if (first != none) refuse_id(splat::GaussianId{static_cast<std::uint32_t>(known_by)});
    }

    RowShares shares_;
};

}}} // namespace tilemesh::render
