#pragma once
#include <tilemesh/render/host_form.hpp>
#include <tilemesh/splat/homes/regions.hpp>

/// The host's form of the program of homes: homes, parcels and tiles hold rows of a table instead of records and splats (as in
/// host_form.hpp). Slots, bytes on the wire, counters and pictures are those of the form by value.
namespace tilemesh { inline namespace v0_2 { namespace splat {

namespace homes {
/// The frame's parameters, and the addresses of the host's table of this view, by rows.
struct TableParameters : Parameters {
    static constexpr char const* name = "frame parameters and tables";
    HostPointer<Splat const> splats;
    HostPointer<Key> keys; ///< of the splats; each home writes those of its records
    HostPointer<WindowNotice const> windows; ///< the table of one tile, for the homes of all. A null pointer: each home reads its own
    std::uint32_t district_shift; ///< as in Parameters, as a word of the run
    static constexpr bool has_districts = true, bends = true;
};
/// A row's parcel has 12 bytes on a host, because a frame of a large map has millions of hops. Its key is in a table.
template <>
struct Parcel<SplatRow> {
    static constexpr std::uint32_t wire_bytes = sizeof(Parcel<Splat>);
    SplatRow row;
    TileId corner;
    std::uint32_t to;

    TILEMESH_KERNEL static Parcel make(SplatRow row, Splat const&, GaussianId, TileId first, std::uint32_t to) noexcept { return {row, first, to}; }
    TILEMESH_KERNEL TileId first() const noexcept { return corner; }
    TILEMESH_KERNEL SplatRow projected() const noexcept { return row; }

    /// The words of a digest, with the key.
    struct Whole {
        SplatRow row;
        std::uint32_t depth, id;
        TileId corner;
        std::uint32_t to;
    };
    using WholeBy = TableParameters;
    Whole whole(TableParameters const& frame) const noexcept
    {
        Key const k = frame.keys.get()[row.row];
        return {row, k.depth, k.id, corner, to};
    }
};
/// The parameters of a program that serves choices with and without planes.
struct HostParameters : TableParameters {
    std::uint32_t wide; ///< as in splat::HostParameters
};
/// The policies of all machines by reference, for records of any degree.
template <class Pixel = FloatPixel>
using HostPolicies = Policies<Reference, SplatRow, TableParameters, HostPixel<Pixel>>;
/// The same, with planes as a word: for choices with and without planes.
using AnyHostPolicies = Policies<Reference, SplatRow, HostParameters, HostPixels>;

/// The splats of a window in the order of a list of key numbers, if the tile holds rows of a table.
struct HeldRowsInOrder {
    Splat const* table;
    SplatRow const* held;
    SortKey const* keys;
    std::uint32_t const* order;
    TILEMESH_KERNEL Splat const& operator()(std::uint32_t i) const noexcept { return table[held[keys[order[i]].slot].row]; }
};
/// The way in which kernels read records if tiles hold rows of a table.
template <class Frame>
struct TableAccess {
    TILEMESH_KERNEL static SplatRow project(Reference const& g, Frame const& frame) noexcept
    {
        frame.keys.get()[g.row] = {frame.splats.get()[g.row].depth_key, static_cast<std::uint32_t>(g.id)};
        return {g.row};
    }
    static constexpr bool on_host = true;
    TILEMESH_KERNEL static Frame hold(Frame const& frame) noexcept { return frame; }
    template <class List>
    TILEMESH_KERNEL static void about_to_read(List const& list) noexcept
    {
        fetch_list(list);
    }
    TILEMESH_KERNEL static Splat const& splat_of(Frame const& frame, SplatRow s) noexcept { return frame.splats.get()[s.row]; }
    TILEMESH_KERNEL static Key key_of(Frame const& frame, SplatRow s) noexcept { return frame.keys.get()[s.row]; }
    /// Tells the memory that a kernel will ask for the key of a splat soon.
    TILEMESH_KERNEL static void about_to_take(Frame const& frame, SplatRow s) noexcept { __builtin_prefetch(frame.keys.get() + s.row); }
    TILEMESH_KERNEL static HeldRowsInOrder in_order(Frame const& frame, SplatRow const* held, SortKey const* keys,
                                                    std::uint32_t const* order) noexcept
    {
        return {frame.splats.get(), held, keys, order};
    }
};
} // namespace homes

template <>
struct Access<homes::TableParameters> : homes::TableAccess<homes::TableParameters> {};
template <>
struct Access<homes::HostParameters> : homes::TableAccess<homes::HostParameters> {};

}}} // namespace tilemesh::splat

#if defined(TILEMESH_COMPILED)
namespace tilemesh { inline namespace v0_2 { namespace splat::homes {

// As in host_form.hpp: the compiled library's functions take the place of the templates in splat/homes/blend.hpp.
void blend_window(NarrowBlock* blocks, Fold const& fold, TileId tile, View const& view, std::uint32_t finished,
                  std::uint32_t n, HeldRowsInOrder const& at, Worker worker, Work& work) noexcept;
void blend_window(WideBlock* blocks, Fold const& fold, TileId tile, View const& view, std::uint32_t finished,
                  std::uint32_t n, HeldRowsInOrder const& at, Worker worker, Work& work) noexcept;
void blend_whole_window(NarrowBlock* blocks, Fold const& fold, TileId tile, View const& view, std::uint32_t finished,
                        std::uint32_t n, HeldRowsInOrder const& at, std::uint32_t workers, Work& work) noexcept;
void blend_whole_window(WideBlock* blocks, Fold const& fold, TileId tile, View const& view, std::uint32_t finished,
                        std::uint32_t n, HeldRowsInOrder const& at, std::uint32_t workers, Work& work) noexcept;

}}} // namespace tilemesh::splat::homes
#endif
