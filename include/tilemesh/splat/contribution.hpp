#pragma once
#include <cmath>
#include <tilemesh/splat/access.hpp>
#include <tilemesh/splat/policies.hpp>
#include <type_traits>

/// What a splat changes in the picture, as a number by which a tile ranks its records (`LargestFirst`). All of it is a function of the
/// splats on one tile in one view, so it is the same on every engine.
TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace splat::detail {

/// The integral of a splat's alpha over its rectangle, in pixels, bounded by opacity times the rectangle. 0 if nothing of it shows.
TILEMESH_KERNEL float coverage_of(Splat const& s) noexcept
{
    if (!s.visible()) return 0.0f;
    PixelRect const r = s.rect();
    float const box = static_cast<float>((r.x1 - r.x0) * (r.y1 - r.y0)), inverse = s.along * s.across; // 1 / (4 a c - 4 b^2)
    float const all = inverse > 0.0f ? 3.14159265f / std::sqrt(inverse) : box;
    return s.opacity * (all < box ? all : box);
}
/// Which records of several sides go first, if a side has room for a part of them: those with the largest coverage, in half octaves.
class SideCuts {
public:
    static std::uint32_t octave_of(Splat const& s) noexcept
    {
        std::uint32_t const half_octaves = __builtin_bit_cast(std::uint32_t, coverage_of(s)) >> 22, lowest = 115u << 1; // 2^-12 pixels
        return half_octaves <= lowest ? 0 : half_octaves - lowest < octaves ? half_octaves - lowest : octaves - 1;
    }
    void add(Direction d, std::uint32_t octave) noexcept { ++count_[index(d)][octave]; }
    /// Side d has room for so many.
    void close(Direction d, std::uint32_t room) noexcept
    {
        std::uint32_t octave = octaves, sum = 0;
        while (octave != 0 && sum + count_[index(d)][octave - 1] <= room) sum += count_[index(d)][--octave];
        first_[index(d)] = octave;
    }
    /// Is this octave among those for all of which the side has room?
    bool has_room(Direction d, std::uint32_t octave) const noexcept { return octave >= first_[index(d)]; }

private:
    static constexpr std::uint32_t octaves = 64;
    std::uint32_t count_[4][octaves] = {};
    std::uint32_t first_[4] = {};
};

/// A part of a tile's pixels, in 4 columns and 4 rows of cells: which cells a rectangle touches, and with how many pixels.
struct RankCells {
    static constexpr std::uint32_t across = 4, count = across * across;
    std::uint32_t x[across + 1], y[across + 1]; ///< borders, in pixels of the frame
    RankCells() noexcept = default;
    RankCells(Tiling const& tiling, TileId t) noexcept
    {
        for (std::uint32_t i = 0; i <= across; ++i) {
            x[i] = t.x() * tiling.tile_width + i * tiling.tile_width / across;
            y[i] = t.y() * tiling.tile_height + i * tiling.tile_height / across;
        }
    }
    /// Calls f(cell, pixels) for each cell that the rectangle touches. `beyond`: the cells at the tile's border go on beyond it.
    template <class F>
    void for_each(PixelRect const& r, bool beyond, F const& f) const noexcept
    {
        for (std::uint32_t j = 0; j < across; ++j) {
            std::uint32_t const top = overlap_begin(r.y0, y, j, beyond), bottom = overlap_end(r.y1, y, j, beyond);
            for (std::uint32_t i = 0; i < across && top < bottom; ++i) {
                std::uint32_t const left = overlap_begin(r.x0, x, i, beyond), right = overlap_end(r.x1, x, i, beyond);
                if (left < right) f(across * j + i, static_cast<float>((right - left) * (bottom - top)));
            }
        }
    }

private:
    static std::uint32_t overlap_begin(std::uint32_t v, std::uint32_t const (&border)[across + 1], std::uint32_t i, bool beyond) noexcept
    {
        return v > border[i] || (beyond && i == 0) ? v : border[i];
    }
    static std::uint32_t overlap_end(std::uint32_t v, std::uint32_t const (&border)[across + 1], std::uint32_t i, bool beyond) noexcept
    {
        return v < border[i + 1] || (beyond && i + 1 == across) ? v : border[i + 1];
    }
};

/// The ranks of a tile's records in one pass of a kernel. It is empty until a record finds the storage full. A rank is the coverage in each
/// cell of the tile times the estimated transmittance in front of the record there: exp(-sum of the nearer coverages / pixels of the cell).
/// A copy counts on this tile only. A record counts with all of its coverage, because its copies on other tiles come from here.
///
/// Ranks stand in the upper half of the marks' words; nothing else uses it. Cost: no SRAM besides the stack; a full tile looks once a
/// pass at all its splats, and at all its marks for each record that takes the place of another.
template <class S>
class Ranking {
public:
    /// The slot whose record has a smaller rank than this entry, which is to take its place; `no_slot` if no record has. The caller
    /// puts the entry there, with `rank_bits` in its mark.
    template <class MarkList, class SplatList, class Entry>
    std::uint32_t slot_for(Here const& here, typename S::Parameters const& frame, MarkList& marks, SplatList const& splats,
                           Entry const& entry, GaussianId id, bool copy) noexcept
    {
        std::uint32_t const n = marks.size();
        if (n == 0) return no_slot;
        if (!ready_) look(here, frame, marks, splats);
        rank_ = rank_of(AccessOf<S>::splat_of(frame, entry), copy);
        if (least_ == no_slot) {
            least_ = 0;
            for (std::uint32_t i = 1; i < n; ++i)
                if (is_less(marks[i].bits & rank_mask, marks[i].id, marks[least_].bits & rank_mask, marks[least_].id)) least_ = i;
        }
        if (!is_less(marks[least_].bits & rank_mask, marks[least_].id, rank_, id)) return no_slot;
        std::uint32_t const slot = least_;
        least_ = no_slot;
        return slot;
    }
    std::uint32_t rank_bits() const noexcept { return rank_; }

private:
    static constexpr std::uint32_t rank_mask = 0xffff0000u;
    static constexpr std::uint32_t bins = 48, bits_a_bin = 19; ///< a bin is 3 to 6 % of a depth; the last one has the rest

    static bool is_less(std::uint32_t rank, GaussianId id, std::uint32_t than, GaussianId other) noexcept
    {
        return rank != than ? rank < than : id > other;
    }
    static std::uint32_t depth_of(Splat const& s) noexcept { return __builtin_bit_cast(std::uint32_t, s.depth()) >> bits_a_bin; }
    std::uint32_t bin_of(Splat const& s) const noexcept
    {
        std::uint32_t const depth = depth_of(s);
        return depth <= nearest_ ? 0 : depth - nearest_ < bins ? depth - nearest_ : bins - 1;
    }
    static float per_pixel(Splat const& s) noexcept
    {
        PixelRect const r = s.rect();
        return coverage_of(s) / static_cast<float>((r.x1 - r.x0) * (r.y1 - r.y0));
    }
    std::uint32_t rank_of(Splat const& s, bool copy) const noexcept
    {
        if (!s.visible()) return rank_mask; // it keeps its slot, as with first come: a later view may show it
        float const density = per_pixel(s);
        auto const& through = through_[bin_of(s)];
        bool const in_front = depth_of(s) < nearest_; // of all records that the tile had
        float value = 0;
        cells_.for_each(s.rect(), !copy, [&](std::uint32_t cell, float pixels) noexcept {
            value += density * pixels * (in_front ? 1.0f : through[cell]);
        });
        return __builtin_bit_cast(std::uint32_t, value) & rank_mask;
    }
    template <class MarkList, class SplatList>
    void look(Here const& here, typename S::Parameters const& frame, MarkList& marks, SplatList const& splats) noexcept
    {
        ready_ = true;
        cells_ = RankCells(frame.tiling, here.tile);
        std::uint32_t const n = marks.size();
        nearest_ = 0xffffffffu;
        for (std::uint32_t i = 0; i < n; ++i) {
            Splat const& s = AccessOf<S>::splat_of(frame, splats[i]);
            if (s.visible() && depth_of(s) < nearest_) nearest_ = depth_of(s);
        }
        for (auto& row : through_)
            for (float& v : row) v = 0;
        for (std::uint32_t i = 0; i < n; ++i) {
            Splat const& s = AccessOf<S>::splat_of(frame, splats[i]);
            if (!s.visible()) continue;
            float const density = per_pixel(s);
            auto& row = through_[bin_of(s)];
            cells_.for_each(s.rect(), false, [&](std::uint32_t cell, float pixels) noexcept { row[cell] += density * pixels; });
        }
        float const cell_pixels = static_cast<float>(frame.tiling.tile_width * frame.tiling.tile_height) / RankCells::count;
        for (std::uint32_t cell = 0; cell < RankCells::count; ++cell) {
            float before = 0;
            for (auto& row : through_) { // half of the bin's own coverage counts as nearer
                float const own = row[cell] / cell_pixels, x = before + 0.5f * own;
                before += own;
                row[cell] = 1.0f / (1.0f + x * (1.0f + x * (0.5f + x * (1.0f / 6)))); // about exp(-x)
            }
        }
        for (std::uint32_t i = 0; i < n; ++i)
            marks[i].bits = (marks[i].bits & ~rank_mask) | rank_of(AccessOf<S>::splat_of(frame, splats[i]), marks[i].is(Mark::copy));
    }

    bool ready_ = false;
    std::uint32_t least_ = no_slot, rank_ = 0, nearest_ = 0;
    RankCells cells_;
    float through_[bins][RankCells::count];
};

/// The lookup of a kernel, with a ranking if the policies have one.
template <class S>
struct RankedLookup : AccessOf<S>::Lookup {
    Ranking<S> ranking;
};
template <class S>
using LookupOf = typename std::conditional_t<may_rank<typename S::Saturation>, machine::Tag<RankedLookup<S>>,
                                             machine::Tag<typename AccessOf<S>::Lookup>>::type;

/// Storage is full: the record takes the place of the one with the smallest rank, if that is smaller than its own. Returns the slot, or
/// `no_slot`. Counts the record that the tile then lacks: `counts.copies_full` if it is a copy, otherwise `counts.storage_full`.
template <class S, class Record, class Entry>
std::uint32_t take_place(Here const& here, typename S::Parameters const& frame, Storage<S>& storage, Marks<S>& marks, Splats<S>& splats,
                         Counts& counts, LookupOf<S>& lookup, Record const& g, Entry const& entry, std::uint32_t bits) noexcept
{
    std::uint32_t const slot = lookup.ranking.slot_for(here, frame, marks, splats, entry, g.id, (bits & Mark::copy) != 0);
    std::uint32_t const lost = slot == no_slot ? bits : marks[slot].bits;
    ++((lost & Mark::copy) != 0 ? counts.copies_full : counts.storage_full);
    if (slot == no_slot) return no_slot;
    storage[slot] = g;
    marks[slot] = {g.id, bits | lookup.ranking.rank_bits()};
    splats[slot] = entry;
    lookup.add(entry);
    ++counts.changes;
    return slot;
}

}}} // namespace tilemesh::splat::detail
TILEMESH_EXACT_END
