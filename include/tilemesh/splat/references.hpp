#pragma once
#include <cstdint>
#include <tilemesh/splat/access.hpp>

/// Tiles that hold references: where a host simulates the machine, its memory has one table of the map's records and of their splats in this
/// view (render/record_table.hpp, render/screen_cache.hpp), and a tile holds the numbers of rows. Here is what such a tile stores, and how
/// kernels read it. Why, and for which setups: render/host_form.hpp.
namespace tilemesh { inline namespace v0_2 { namespace splat {

/// A record's place in the host's table, with its id.
struct Reference {
    GaussianId id;
    std::uint32_t row;
};

/// An entry of `Splats`: a row of the host's table.
struct SplatRow {
    static constexpr std::uint32_t wire_bytes = sizeof(Splat); ///< the machine stores the splat
    std::uint32_t row;
};

/// An address in the host's memory, as words of a broadcast.
template <class T>
class HostPointer {
public:
    HostPointer() noexcept = default;
    explicit HostPointer(T* p) noexcept { __builtin_memcpy(words_, &p, sizeof p); }
    TILEMESH_KERNEL T* get() const noexcept
    {
        T* p;
        __builtin_memcpy(&p, words_, sizeof words_);
        return p;
    }

private:
    std::uint32_t words_[sizeof(T*) / 4] = {};
};

/// The bits that tiles need of a record in a new view: is it visible, and what changed since the last view? They take one byte, so that the
/// table of a whole map stays in the caches
/// nearest to the processor.
struct RowState {
    static constexpr std::uint8_t visible = 1;
    static constexpr std::uint8_t moved = 2;    ///< touches other tiles, has another anchor, or was put on the mesh by the host
    static constexpr std::uint8_t appeared = 4; ///< appeared or disappeared
};

/// The tiles that a record touches in a view, as the first and the last one, and its anchor tile.
struct TouchedTiles {
    TileId first, last, anchor;
    std::uint32_t visible; ///< 0 or 1
};

/// The tiles on which a record, or a copy of it, may have been when a view began: from the first to the last.
struct TileSpan {
    TileId first, last;
    static constexpr TileSpan all() noexcept { return {TileId::at(0, 0), TileId::at(0xffff, 0xffff)}; }
    constexpr bool has(TileId t) const noexcept
    {
        return t.x() >= first.x() && t.x() <= last.x() && t.y() >= first.y() && t.y() <= last.y();
    }
};

/// The policies of a setup as values, and the bytes of its messages on the machine.
struct PolicyWords {
    std::uint32_t holds, carried, reusable; ///< 0 or 1
    std::uint32_t road_bytes, beam_bytes;
    std::uint32_t ranks = 0; ///< 1: LargestFirst
};

/// The frame's parameters, and the addresses of the host's table of this view, by rows.
struct TableParameters : FrameParameters {
    static constexpr char const* name = "frame parameters and tables";
    static constexpr bool bends = true;
    PolicyWords policies;
    HostPointer<Splat const> splats;
    HostPointer<TouchedTiles const> touched;
    HostPointer<std::uint8_t const> row_states;
    HostPointer<std::uint32_t const> depths; ///< bits of the depth as a float
    /// Valid for rows that moved: outside of this span, no tile had the record or a copy when this view began. A null pointer: unknown.
    HostPointer<TileSpan const> before;
    /// By tiles: 0 if the tile's pixels from the last run are still right, so that it does not composite (render/kept_pixels.hpp). A null pointer:
    /// every tile composites.
    HostPointer<std::uint8_t> stale;
};

/// The parameters of a program that serves setups with and without planes, routing and bloom, and runs without a picture.
struct HostParameters : TableParameters {
    std::uint32_t wide;           ///< 1: pixels have all planes; 0: only a colour (machine/either.hpp)
    std::uint32_t routes, blooms; ///< 1: the frame has this step
    std::uint32_t draws;          ///< 1: the run makes a picture; 0: it only moves records and copies (FrameRenderer::prefetch)
};

/// The splats of a tile in the order of the keys, if the tile holds rows of a table.
struct RowsInOrder {
    Splat const* table;
    SplatRow const* rows;
    SortKey const* keys;
    TILEMESH_KERNEL Splat const& operator()(std::uint32_t i) const noexcept { return table[rows[keys[i].slot].row]; }
};

/// Prefetches all lines of a list.
template <class List>
TILEMESH_KERNEL void fetch_list(List const& list) noexcept
{
    constexpr std::uint32_t items_a_line = 64 / sizeof(typename List::value_type);
    for (std::uint32_t i = 0, n = list.size(); i < n; i += items_a_line) __builtin_prefetch(list.begin() + i);
}

/// The way in which kernels read records if tiles hold rows of a table.
template <class Parameters>
struct TableAccess {
    TILEMESH_KERNEL static SplatRow project(Reference const& g, Parameters const&) noexcept { return {g.row}; }
    static constexpr bool entries_last = true;
    TILEMESH_KERNEL static Parameters hold(Parameters const& frame) noexcept { return frame; }
    /// Prefetches all lines of the list at once into the host's caches. The lists of a tile are short, and far away from those of the
    /// previous tile. Without the prefetch the processor would wait for one line after the other.
    template <class List>
    TILEMESH_KERNEL static void about_to_read(List const& list) noexcept
    {
        fetch_list(list);
    }
    TILEMESH_KERNEL static void about_to_reach(Parameters const& frame, SplatRow s) noexcept
    {
        __builtin_prefetch(frame.touched.get() + s.row);
    }
    template <class M>
    TILEMESH_KERNEL static void about_to_change(M const& mark) noexcept
    {
        __builtin_prefetch(&mark, 1);
    }
    TILEMESH_KERNEL static void about_to_order(Parameters const& frame, SplatRow s) noexcept
    {
        __builtin_prefetch(frame.depths.get() + s.row);
    }
    template <class Record>
    TILEMESH_KERNEL static void about_to_send(Parameters const& frame, SplatRow s, Record const& record) noexcept
    {
        __builtin_prefetch(frame.touched.get() + s.row);
        __builtin_prefetch(&record);
    }
    TILEMESH_KERNEL static void about_to_take(Parameters const& frame, Reference const& message) noexcept
    {
        __builtin_prefetch(frame.touched.get() + message.row);
        about_to_find(frame, message);
    }
    TILEMESH_KERNEL static void about_to_find(Parameters const& frame, Reference const& message) noexcept
    {
        if (TileSpan const* const before = frame.before.get(); before != nullptr) __builtin_prefetch(before + message.row);
    }
    TILEMESH_KERNEL static Splat const& splat_of(Parameters const& frame, SplatRow s) noexcept { return frame.splats.get()[s.row]; }
    TILEMESH_KERNEL static TileId anchor_of(Parameters const& frame, SplatRow s) noexcept { return frame.touched.get()[s.row].anchor; }
    TILEMESH_KERNEL static RowsInOrder in_order(Parameters const& frame, SplatRow const* rows, SortKey const* keys) noexcept
    {
        return {frame.splats.get(), rows, keys};
    }
    TILEMESH_KERNEL static std::uint32_t depth_key(Parameters const& frame, SplatRow s) noexcept { return frame.depths.get()[s.row]; }
    TILEMESH_KERNEL static Reach reach(Here const& here, Parameters const& frame, SplatRow s) noexcept
    {
        TouchedTiles const& t = frame.touched.get()[s.row];
        // Every range lies in the grid, so a side beyond the grid's edge is in no range.
        std::uint32_t const x = here.tile.x() - t.first.x(), columns = t.last.x() - t.first.x();
        std::uint32_t const y = here.tile.y() - t.first.y(), rows = t.last.y() - t.first.y();
        auto const bit = [](bool yes) noexcept { return yes ? 1u : 0u; };
        std::uint32_t const in_x = bit(x <= columns) & t.visible, in_y = bit(y <= rows) & t.visible;
        std::uint32_t const sides = (in_x & bit(y - 1 <= rows)) << index(Direction::north) |
                                    (in_y & bit(x + 1 <= columns)) << index(Direction::east) |
                                    (in_y & bit(x - 1 <= columns)) << index(Direction::west) |
                                    (in_x & bit(y + 1 <= rows)) << index(Direction::south);
        return {t.anchor, t.visible != 0, (in_x & in_y) != 0, sides};
    }
    TILEMESH_KERNEL static bool is_here(Here const& here, Parameters const& frame, SplatRow s) noexcept
    {
        return reach(here, frame, s).here;
    }
    /// Compares rows, not ids: it reads four bytes per slot instead of eight. Most messages bring a record that the tile does not have. If the
    /// record did not touch the tile in the view before, the host's table says so. From the search on that makes it worth while, a set of
    /// hashed rows answers for the others: a row whose bit is not set is not on the tile.
    class Lookup {
    public:
        template <class MarkList>
        std::uint32_t slot_of(Here const& here, Parameters const& frame, MarkList const& marks, SplatRow const* splats,
                              Reference const& message) noexcept
        {
            if (TileSpan const* const before = frame.before.get(); before != nullptr)
                if ((frame.row_states.get()[message.row] & RowState::moved) != 0 && !before[message.row].has(here.tile)) return no_slot;
            std::uint32_t const n = marks.size();
            if (searches_ == searches_before_a_set && n >= fewest_rows) {
                for (auto& word : set_) word = 0;
                for (std::uint32_t i = 0; i < n; ++i) insert(splats[i].row);
                ++searches_;
            }
            if (searches_ > searches_before_a_set) {
                std::uint32_t const h = hash(message.row);
                if ((set_[h / 32] >> (h % 32) & 1u) == 0) return no_slot;
            } else if (searches_ < searches_before_a_set) {
                ++searches_;
            }
            return first_with_word(splats, n, message.row);
        }
        void add(SplatRow s) noexcept
        {
            if (searches_ > searches_before_a_set) insert(s.row);
        }

    private:
        // To search n rows takes n / 8 cycles, and to insert them takes 3 n.
        static constexpr std::uint32_t searches_before_a_set = 16, fewest_rows = 128;
        static constexpr std::uint32_t hash_bits = 16;

        static std::uint32_t hash(std::uint32_t row) noexcept { return row * 0x9e3779b9u >> (32 - hash_bits); } // Knuth: 2^32 / golden ratio
        void insert(std::uint32_t row) noexcept
        {
            std::uint32_t const h = hash(row);
            set_[h / 32] |= 1u << (h % 32);
        }

        std::uint32_t searches_ = 0;
        std::uint32_t set_[(1u << hash_bits) / 32]; ///< valid if searches_ > searches_before_a_set
    };
    TILEMESH_KERNEL static bool is_settled(Parameters const& frame, SplatRow s, std::uint32_t bits, std::uint32_t& row_state) noexcept
    {
        row_state = frame.row_states.get()[s.row];
        return ((bits & (Mark::refused_any | Mark::leaving | Mark::owes)) | (row_state & RowState::moved)) == 0;
    }
    TILEMESH_KERNEL static bool knows_what_moved(Parameters const& frame) noexcept { return frame.before.get() != nullptr; }
    TILEMESH_KERNEL static std::uint32_t moved(Parameters const& frame, SplatRow s) noexcept
    {
        static_assert(RowState::moved == 2);
        return frame.row_states.get()[s.row] >> 1 & 1u;
    }
    TILEMESH_KERNEL static std::uint32_t was_visible(Parameters const& frame, SplatRow s, std::uint32_t visible) noexcept
    {
        return (frame.row_states.get()[s.row] & RowState::appeared) != 0 ? 1u - visible : visible;
    }
    TILEMESH_KERNEL static bool coverage_changed(Here const&, Parameters const& frame, SplatRow s, bool covered,
                                                 std::uint32_t bits) noexcept
    {
        return !covered || (bits & Mark::leaving) != 0 || (frame.row_states.get()[s.row] & RowState::appeared) != 0;
    }
    /// Changes n splats that the host has projected. The library's version changes nothing; a program may specialise it. The list of
    /// missing records (render/losses.hpp) assumes the library's footprint, so keep that footprint if records may be lost.
    static void adjust(Parameters const&, View const&, Tiling const&, Splat*, std::uint32_t) noexcept {}
    /// The list of the tile's splats changed in this run.
    TILEMESH_KERNEL static void list_changed(Here const& here, Parameters const& frame) noexcept
    {
        if (std::uint8_t* const stale = frame.stale.get(); stale != nullptr) stale[here.grid.index_of(here.tile)] = 1;
    }
    /// The tile's pixels, and its counters of pairs, are those that compositing it would give.
    TILEMESH_KERNEL static bool keeps_pixels(Here const& here, Parameters const& frame) noexcept
    {
        std::uint8_t const* const stale = frame.stale.get();
        return stale != nullptr && stale[here.grid.index_of(here.tile)] == 0;
    }
    template <class>
    static std::uint32_t road_bytes(Parameters const& frame) noexcept
    {
        return frame.policies.road_bytes;
    }
    template <class>
    static std::uint32_t beam_bytes(Parameters const& frame) noexcept
    {
        return frame.policies.beam_bytes;
    }
};
template <>
struct Access<TableParameters> : TableAccess<TableParameters> {};
template <>
struct Access<HostParameters> : TableAccess<HostParameters> {};

}}} // namespace tilemesh::splat
