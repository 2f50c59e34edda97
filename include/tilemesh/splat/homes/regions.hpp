#pragma once
#include <tilemesh/machine/either.hpp>
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/splat/access.hpp>
#include <tilemesh/splat/blending_block.hpp>
#include <tilemesh/splat/homes/counts.hpp>
#include <tilemesh/splat/homes/fold.hpp>
#include <tilemesh/splat/regions.hpp>

/// The frame program of homes and windows: it renders a map of any density exactly. The types of its state and channels.
///
/// Words. The *key* of a splat is its depth and its id, a strict order. A record lies on its *home*, a tile that does not depend on the
/// view. A *window* of a tile is an interval of keys. In a round, homes send each tile the splats of its window; the tile keeps the nearest
/// ones that it has room for, blends them, and goes on behind them. The *frontier* is the nearest key that it refused. A *district* is a
/// square of tiles that share an entry of the table of windows; on Mk2 it is one tile.
namespace tilemesh { inline namespace v0_2 { namespace splat::homes {

/// The sizes of the program from the number of its homes on a tile, held splats, splats in a channel end, and splats in a FIFO.
constexpr Sizes homes_sizes(std::uint32_t homes, std::uint32_t held, std::uint32_t parcels, std::uint32_t waiting) noexcept
{
    Sizes sizes;
    sizes.homes = homes;
    sizes.storage = held;
    sizes.road = parcels;
    sizes.waiting = waiting;
    return sizes;
}

/// The parameters that the host sends to every tile at the start of a frame.
struct Parameters {
    static constexpr char const* name = "frame parameters";
    View view;
    TileSize tiling; ///< of the projection; it only sets `Splat::anchor`, which this program does not read
    Fold fold;
    /// A map with more records than homes comes in chapters, front to back: the host refills the homes and runs the program again. 0 for
    /// the first chapter; otherwise the key of the nearest depth of this one. The picture goes on where the last chapter ended.
    std::uint32_t chapter_depth;

    /// A district has 2^district_shift x 2^district_shift tiles. Parameters with `has_districts` may have more than one.
    static constexpr std::uint32_t district_shift = 0;
    static constexpr bool has_districts = false;
    static constexpr bool bends = false; ///< as in FrameParameters
};
/// The parameters of a program whose cameras may have any lens.
struct LensParameters : Parameters {
    static constexpr bool bends = true;
};
/// The parameters of machines whose tiles have no room for a window of each tile.
template <std::uint32_t Shift>
struct DistrictParameters : Parameters {
    static constexpr std::uint32_t district_shift = Shift;
    static constexpr bool has_districts = true;
};
static_assert(std::is_trivially_copyable_v<Parameters> && sizeof(Parameters) % 4 == 0, "parameters are plain words");

/// The types that change what kernels do.
template <class RecordType, class ProjectedType, class ParametersType, class PixelType>
struct Policies {
    using Record = RecordType;         ///< what a home stores
    using Projected = ProjectedType;   ///< the splat, or the host's reference to it
    using Parameters = ParametersType;
    using Pixel = PixelType;
};
/// The policies of a machine that moves values, for records of this degree.
template <std::uint32_t Degree = 0, class Pixel = FloatPixel>
using ValuePolicies = Policies<GaussianOfDegree<Degree>, Splat, Parameters, Pixel>;
template <std::uint32_t Degree = 0, class Pixel = FloatPixel>
using LensPolicies = Policies<GaussianOfDegree<Degree>, Splat, LensParameters, Pixel>;
/// The same, with districts of 2^Shift x 2^Shift tiles.
template <std::uint32_t Shift, std::uint32_t Degree = 0, class Pixel = FloatPixel>
using DistrictPolicies = Policies<GaussianOfDegree<Degree>, Splat, DistrictParameters<Shift>, Pixel>;

/// The operations on which the kernels spend their time; those that Operation (splat/operations.hpp) has too have its names and prices.
struct Operation {
    enum Kind : std::uint32_t {
        slot,       ///< a slot of a list that a kernel looks at
        projection, ///< a record that is projected
        left,       ///< a parcel that its home gives to a channel
        passed,     ///< a parcel that is given to a channel on its way
        settled,    ///< a parcel that a tile takes as its own
        comparison, ///< two keys that are compared and put in order
        pair,       ///< a Gaussian-pixel pair that is evaluated
        pixel       ///< a pixel that is begun and written
    };
    static constexpr char const* names[] = {"slot", "projection", "left", "passed", "settled", "comparison", "pair", "pixel"};
};
using Operations = tilemesh::Operations<Operation>;

/// The key of a splat: its depth as a word (depth_key.hpp), then its id.
struct Key {
    std::uint32_t depth, id;
};
constexpr bool operator<(Key const& a, Key const& b) noexcept
{
    return a.depth != b.depth ? a.depth < b.depth : a.id < b.id;
}

// --- channels ------------------------------------------------------------------------------------------------------------

/// A splat on its way to at most 4 x 8 tiles: byte c of `to` names the tiles of column first.x + c, bit r of that byte the tile of row
/// first.y + r. A tile that sends it on clears the bits of the tiles that it has served. A splat that more tiles want travels as several
/// parcels. 64 bytes for records of any degree.
template <class Projected>
struct Parcel;
template <>
struct Parcel<Splat> {
    Splat splat; ///< its `anchor` is `first`
    GaussianId id;
    std::uint32_t to;

    static Parcel make(Splat const& s, Splat const&, GaussianId id, TileId first, std::uint32_t to) noexcept
    {
        Parcel p{s, id, to};
        p.splat.anchor = first;
        return p;
    }
    TileId first() const noexcept { return splat.anchor; }
    Key key() const noexcept
    {
        return {splat.depth_key, static_cast<std::uint32_t>(id)};
    }
    Splat const& projected() const noexcept { return splat; }
};
static_assert(sizeof(Parcel<Splat>) == 64);
inline constexpr std::uint32_t parcel_columns = 4, parcel_rows = 8;

/// What a tile says of its window; in the end every tile has those of all. The notice of a district is the hull of its tiles': the least
/// `lo_depth`, the largest `hi_depth`, and the blocks that are finished on all of them.
struct WindowNotice {
    std::uint32_t lo_depth;  ///< key of the nearest depth that it wants; 0xffffffff: it wants nothing more
    std::uint32_t hi_depth;  ///< bits of the first depth behind the window
    std::uint32_t finished;  ///< blocks whose pixels have all stopped (Fold::bit_of)
};
inline constexpr std::uint32_t infinite_depth = 0xffffffffu;

struct WindowNotices : Channel<WindowNotice> {
    static constexpr char const* name = "window notices";
    static constexpr auto slots = &Sizes::columns;
};
template <class P>
struct Parcels : Channel<Parcel<typename P::Projected>> {
    static constexpr char const* name = "parcels";
    static constexpr auto slots = &Sizes::road;
    static constexpr std::uint32_t least_slots = 1; ///< nothing goes through a channel without a slot
};

// --- state of a tile --------------------------------------------------------------------------------------------------------

template <class P>
struct Home : Buffer<typename P::Record> {
    static constexpr char const* name = "homes";
    static constexpr auto slots = &Sizes::homes;
    static constexpr std::uint32_t item_bytes(Setup const& s) noexcept { return record_bytes(s); }
};
/// The records of this home, projected into this frame's view.
template <class P>
struct Seen : Buffer<typename P::Projected> {
    static constexpr char const* name = "projected records";
    static constexpr auto slots = &Sizes::homes;
};
/// The tiles that want a record's splat in this round, if one parcel names them all.
struct Offered {
    TileId first;
    std::uint32_t to;     ///< as in Parcel
    std::uint16_t parts;  ///< 0: nobody wants it. Above 1: the tiles take several parcels, and the home finds them part by part
    std::uint16_t tested; ///< blocks that were tested for it, for a cost model
};
static_assert(sizeof(Offered) == 12, "an offer is 3 words");
struct Offers : Buffer<Offered> {
    static constexpr char const* name = "offers";
    static constexpr auto slots = &Sizes::homes;
};
/// The splats of this window. `Keys` has one key for each.
template <class P>
struct Held : Buffer<typename P::Projected> {
    static constexpr char const* name = "held splats";
    static constexpr auto slots = &Sizes::storage;
    static constexpr std::uint32_t least_slots = 1; ///< a tile that keeps nothing never goes on
};
struct Keys : Buffer<SortKey> {
    static constexpr char const* name = "sort keys";
    static constexpr auto slots = &Sizes::storage;
};
/// The numbers of the keys, in depth order.
struct Order : Buffer<std::uint32_t> {
    static constexpr char const* name = "depth order";
    static constexpr auto slots = &Sizes::storage;
};
/// The words of a block without and with depth.
using NarrowBlock = splat::detail::BlockFields;
using WideBlock = splat::detail::DepthBlockFields;
/// The colour and transmittance of the tile's blocks, kept from round to round; with a depth plane also their depth.
template <class Fields>
struct Blocks : Buffer<Fields> {
    static constexpr char const* name = "blocks";
    static constexpr auto slots = &Sizes::tile_blocks;
    static constexpr std::uint32_t item_bytes(Setup const& s) noexcept { return s.depth ? sizeof(WideBlock) : sizeof(NarrowBlock); }
};
namespace detail {
template <class Pixel>
using FieldsOf = std::conditional_t<machine::is_either<Pixel>, machine::Either<WideBlock, NarrowBlock>,
                                    std::conditional_t<Pixel::has_depth, WideBlock, NarrowBlock>>;
} // namespace detail
template <class P>
using BlocksOf = Blocks<detail::FieldsOf<typename P::Pixel>>;
/// The finished pixels: 80 for each block, in the order of `Blocks`.
template <class Pixel>
struct Framebuffer : Buffer<Pixel> {
    static constexpr char const* name = "framebuffer";
    static constexpr auto slots = &Sizes::tile_pixels;
    static constexpr std::uint32_t item_bytes(Setup const& s) noexcept { return pixel_bytes(s); }
};
/// The windows of all tiles with blocks, or of all districts, row by row.
struct Table : Buffer<WindowNotice> {
    static constexpr char const* name = "windows of all tiles";
    static constexpr auto slots = &Sizes::tiles;
};
template <class P, std::uint32_t Side>
struct Waiting : Buffer<Parcel<typename P::Projected>> {
    static constexpr char const* name = Side == 0 ? "waiting (side 0)" : "waiting (side 1)";
    static constexpr auto slots = &Sizes::waiting;
    static constexpr std::uint32_t least_slots = 1; ///< without a slot, the tile could give no credit
};

/// A tile's window: keys from lo to (hi_depth, 0), and what it has refused.
struct Window {
    static constexpr char const* name = "window";
    std::uint32_t lo_depth, lo_id;              ///< lo_depth == infinite_depth: the tile is done
    std::uint32_t hi_depth;
    std::uint32_t frontier_depth, frontier_id;  ///< the least key refused, else hi
    std::uint32_t finished;                     ///< blocks (Fold::bit_of)
    std::uint32_t blended;                      ///< splats of all rounds
    std::uint32_t seen, stride;                 ///< refused keys, and every how many of them the sample has
    std::uint32_t pass;                         ///< of Tell in this round
    std::uint32_t runs;                         ///< in which the keys are sorted

    bool done() const noexcept { return lo_depth == infinite_depth; }
    bool refused() const noexcept { return frontier_depth != hi_depth || frontier_id != 0; }
};
static_assert(sizeof(Window) <= 64);
inline constexpr std::uint32_t most_cuts = 32, most_samples = 64;
/// The depths at which windows of this frame end, nearest first.
struct Cuts : Buffer<std::uint32_t, most_cuts> {
    static constexpr char const* name = "cuts";
};
/// The cuts of the next frame.
struct NextCuts : Buffer<std::uint32_t, most_cuts> {
    static constexpr char const* name = "cuts of the next frame";
};
/// Depths that the tile refused in this round, every `stride`-th of them.
struct Sample : Buffer<std::uint32_t, most_samples> {
    static constexpr char const* name = "sample of refused depths";
};

/// How far a home has come in sending its records: for each of west, east and its own column the record, and the part of its tiles. The
/// fill of the FIFOs behind the two row channels follows from `sent` and the notes of the channels.
struct Sending {
    static constexpr char const* name = "sending and flow control";
    std::uint32_t record[3], part[3];
    std::uint32_t rest;     ///< tiles of its own column that a full channel kept from the current part; 0: none
    std::uint32_t sent[2];  ///< parcels sent to the west and to the east in the previous pass
    std::uint32_t turning[2]; ///< in each FIFO, the first so many parcels named tiles of this column when they came; the others go straight on
};

inline constexpr std::uint32_t strip_width = 2;

/// The levels of a heap of n keys.
TILEMESH_KERNEL std::uint32_t heap_levels(std::uint32_t n) noexcept
{
    std::uint32_t levels = 0;
    while (levels < 31 && (1u << levels) < n) ++levels;
    return levels;
}

/// The place of a block in the frame: its first pixel. `exists` is false if the tile has no block of that number.
struct BlockAt {
    std::uint32_t x, y;
    bool exists;
};
inline BlockAt block_at(Fold const& fold, TileId tile, std::uint32_t number) noexcept
{
    std::uint32_t const i = fold.x.block(tile.x(), number % fold.x.layers), j = fold.y.block(tile.y(), number / fold.x.layers);
    return {i * block_width, j * block_height, tile.x() < fold.x.tiles && tile.y() < fold.y.tiles && i < fold.x.blocks && j < fold.y.blocks};
}

/// The districts along n tiles.
constexpr std::uint32_t districts(std::uint32_t n, std::uint32_t shift) noexcept
{
    return n == 0 ? 0 : ((n - 1) >> shift) + 1;
}

/// The shift of districts whose side is this power of 2.
constexpr std::uint32_t district_shift(std::uint32_t side) noexcept
{
    std::uint32_t shift = 0;
    while (shift < 31 && (1u << shift) < side) ++shift;
    return shift;
}

/// The windows of districts, as a home asks for those of tiles.
class DistrictTable {
public:
    DistrictTable(WindowNotice const* table, Fold const& fold, std::uint32_t shift) noexcept
        : table_(table), columns_(districts(fold.x.tiles, shift)), shift_(shift)
    {
    }
    /// A row of tiles.
    struct Row {
        WindowNotice const* notices;
        std::uint32_t shift;
        WindowNotice const& operator[](std::uint32_t x) const noexcept { return notices[x >> shift]; }
    };
    Row row(std::uint32_t y) const noexcept { return {table_ + (y >> shift_) * columns_, shift_}; }

private:
    WindowNotice const* table_;
    std::uint32_t columns_, shift_;
};
/// The windows of a row of tiles.
template <class AnyFold>
TILEMESH_KERNEL WindowNotice const* windows_of_row(WindowNotice const* table, AnyFold const& fold, std::uint32_t y) noexcept
{
    return table + y * fold.x.tiles;
}
template <class AnyFold>
TILEMESH_KERNEL DistrictTable::Row windows_of_row(DistrictTable const& table, AnyFold const&, std::uint32_t y) noexcept
{
    return table.row(y);
}
/// Calls f with what a home asks for windows. After Tell all tables are equal, so the homes of a host share one, which stays in its caches.
template <class Frame, class F>
TILEMESH_KERNEL decltype(auto) with_windows(Frame const& frame, Table const& own, F const& f) noexcept
{
    WindowNotice const* table = own.begin();
    if constexpr (splat::Access<Frame>::on_host)
        if (frame.windows.get() != nullptr) table = frame.windows.get();
    if constexpr (Frame::has_districts)
        return f(DistrictTable(table, frame.fold, frame.district_shift));
    else
        return f(table);
}

/// Does the tile hold pixels?
TILEMESH_KERNEL bool has_blocks(Here const& here, Fold const& fold) noexcept
{
    return here.tile.x() < fold.x.tiles && here.tile.y() < fold.y.tiles;
}

}}} // namespace tilemesh::splat::homes
