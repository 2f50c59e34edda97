#pragma once
#include <tilemesh/splat/access.hpp>
#include <type_traits>

TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace splat {

// --- routing rules ---------------------------------------------------------------------------------------------------------
// A rule names the two sides of its first leg, and the next side on the way. It must be dimension-ordered (Dally and Seitz 1987): a record
// goes along the first axis until the coordinate fits, then along the other axis, and never back. Only then are FIFOs and credits on the
// first leg enough (routing.hpp). `is_dimension_ordered<Rule>()` proves it at compile time.

/// First along the row, then along the column.
struct RowFirst {
    static constexpr char const* name = "row_first";
    static constexpr Direction first_leg[2] = {Direction::west, Direction::east};
    static constexpr Direction towards(TileId from, TileId to) noexcept // from != to
    {
        if (to.x() != from.x()) return to.x() > from.x() ? Direction::east : Direction::west;
        return to.y() > from.y() ? Direction::south : Direction::north;
    }
};

template <class Rule>
constexpr bool is_dimension_ordered() noexcept
{
    constexpr Grid grid{5, 5};
    for (std::uint32_t i = 0; i < grid.size(); ++i)
        for (std::uint32_t j = 0; j < grid.size(); ++j) {
            bool second = false;
            std::uint32_t hops = 0;
            for (TileId at = grid.tile(i); !(at == grid.tile(j)); ++hops) {
                Direction const d = Rule::towards(at, grid.tile(j));
                bool const first = d == Rule::first_leg[0] || d == Rule::first_leg[1];
                if ((first && second) || hops > 8 || !grid.has_neighbour(at, d)) return false;
                second = !first;
                at = grid.neighbour(at, d);
            }
        }
    return Rule::first_leg[0] == opposite(Rule::first_leg[1]);
}

// --- saturation ------------------------------------------------------------------------------------------------------------

// `may_hold`: the frame has FIFOs. `holds_in(frame)`: in this frame, a full channel makes its sender hold the record back. It is a
// constant, except in a host form in which the host decides frame by frame.

/// Back-pressure: no record or copy that was sent is lost (routing.hpp explains the protocol).
struct Hold {
    static constexpr char const* name = "hold";
    static constexpr bool holds = true, may_hold = true;
    template <class Parameters>
    TILEMESH_KERNEL static constexpr bool holds_in(Parameters const&) noexcept
    {
        return true;
    }
};
/// The paper's policy: no FIFO and no credit. A record that cannot go on takes a storage slot on the tile where it is and tries again
/// later. If the tile has no free slot, the record is lost. A copy that meets a full channel is lost as well.
struct Drop {
    static constexpr char const* name = "drop";
    static constexpr bool holds = false, may_hold = false;
    template <class Parameters>
    TILEMESH_KERNEL static constexpr bool holds_in(Parameters const&) noexcept
    {
        return false;
    }
};

/// Is there a rule which record a full tile keeps and which one goes first, besides that of the order of arrival?
template <class Saturation, class = void>
inline constexpr bool may_rank = false;
template <class Saturation>
inline constexpr bool may_rank<Saturation, std::enable_if_t<Saturation::may_rank>> = true;

/// `Hold` or `Drop`, in which the records that change the picture most go first and stay. A record that finds the storage full takes the
/// place of the record that changes the tile's pixels least (contribution.hpp); that one is lost as if it had found the storage full. Among
/// the records that wait for one side, those that cover most leave first. Cost: no SRAM, no message; time on full tiles.
template <class Saturation>
struct LargestFirst : Saturation {
    static constexpr char const* name = Saturation::holds ? "hold, largest first" : "drop, largest first";
    static constexpr bool may_rank = true;
    template <class Parameters>
    TILEMESH_KERNEL static constexpr bool ranks_in(Parameters const&) noexcept
    {
        return true;
    }
};
/// Does this frame rank records? A constant if the policies do not have the rule.
template <class S, class Frame>
TILEMESH_KERNEL constexpr bool ranks_in([[maybe_unused]] Frame const& frame) noexcept
{
    if constexpr (may_rank<typename S::Saturation>)
        return S::Saturation::ranks_in(frame);
    else
        return false;
}

// --- what a routed message carries --------------------------------------------------------------------------------------------

/// The anchor tile travels with the record. It is computed once a frame.
struct Carried {
    static constexpr char const* name = "carried";
    template <class Record>
    using Message = AddressedRecord<Record>;
    static constexpr bool carried = true;
    template <class Parameters>
    TILEMESH_KERNEL static constexpr bool carried_in(Parameters const&) noexcept // in this frame
    {
        return true;
    }
    template <class Record>
    static AddressedRecord<Record> make(Record const& g, TileId anchor) noexcept
    {
        return {g, anchor};
    }
    template <class Record>
    static Record const& record(AddressedRecord<Record> const& m) noexcept
    {
        return m.record;
    }
    template <class Record>
    static TileId anchor(AddressedRecord<Record> const& m) noexcept
    {
        return m.anchor;
    }
};
/// The paper's 60-byte message. Every tile on the way projects the record again.
struct Recomputed {
    static constexpr char const* name = "recomputed";
    template <class Record>
    using Message = Record;
    static constexpr bool carried = false;
    template <class Parameters>
    TILEMESH_KERNEL static constexpr bool carried_in(Parameters const&) noexcept
    {
        return false;
    }
    template <class Record>
    static Record make(Record const& g, TileId) noexcept
    {
        return g;
    }
    template <class Record>
    static Record const& record(Record const& m) noexcept
    {
        return m;
    }
    template <class Record>
    static TileId anchor(Record const&) noexcept // never called
    {
        return {};
    }
};

// --- what bloom sends (by reference, the message is the reference: RunTimeCopies of render/host_form.hpp) ------------------------

/// The message is the record: 60 bytes at degree 0. The receiver projects it and can keep it for the next view.
struct WorldCopies {
    static constexpr char const* name = "world";
    template <class Record>
    using Message = Record;
    static constexpr bool reusable = true;
    template <class Parameters>
    TILEMESH_KERNEL static constexpr bool reusable_in(Parameters const&) noexcept // in this frame
    {
        return true;
    }
    template <class Record>
    static Record make(Record const& g, Splat const&) noexcept
    {
        return g;
    }
    template <class Record>
    static Record const& record(Record const& m) noexcept
    {
        return m;
    }
    template <class Record, class Parameters>
    static auto splat(Record const& m, Parameters const& f) noexcept
    {
        return Access<Parameters>::project(m, f);
    }
};
/// The message is the projected record: 60 bytes at any degree. The receiver computes nothing. The copy is valid for one view only, so a
/// new view sends all copies again.
struct ScreenCopies {
    static constexpr char const* name = "screen";
    template <class>
    using Message = ScreenCopy;
    static constexpr bool reusable = false;
    template <class Parameters>
    TILEMESH_KERNEL static constexpr bool reusable_in(Parameters const&) noexcept
    {
        return false;
    }
    static ScreenCopy make(Gaussian const& g, Splat const& s) noexcept { return {s, g.id}; }
    template <class Record>
    static Record record(ScreenCopy const& m) noexcept // only its id has a meaning
    {
        Record g{};
        g.id = m.id;
        return g;
    }
    static Splat splat(ScreenCopy const& m, FrameParameters const&) noexcept { return m.splat; }
};

// --- pixels ------------------------------------------------------------------------------------------------------------------------
// A pixel type is what a tile stores of a pixel: plain words, made from a `Blended`. `has_depth` says whether blending must sum depths.

/// The result of blending for one pixel. w = alpha T, for every Gaussian that took part.
struct Blended {
    float rgb[3];        ///< sum(w c)
    float transmittance; ///< T; 1 if no Gaussian took part
    float weight;        ///< sum(w); set only for pixel types with a depth
    float depth;         ///< sum(w z); set only for pixel types with a depth
};
inline constexpr Blended nothing_blended{{0, 0, 0}, 1, 0, 0};

/// Linear RGB, not clamped: 12 bytes a pixel.
struct FloatPixel {
    static constexpr char const* name = "float";
    static constexpr bool has_depth = false, has_alpha = false;
    float rgb[3];
    static FloatPixel make(Blended const& b) noexcept { return {{b.rgb[0], b.rgb[1], b.rgb[2]}}; }
};
/// The paper's pixel: 8 bits a channel, and a byte of padding because the machine stores whole words.
struct Rgbx8Pixel {
    static constexpr char const* name = "rgbx8";
    static constexpr bool has_depth = false, has_alpha = false;
    std::uint32_t word;
    static Rgbx8Pixel make(Blended const& b) noexcept
    {
        return {level(b.rgb[0]) | level(b.rgb[1]) << 8 | level(b.rgb[2]) << 16};
    }
    static std::uint32_t level(float v) noexcept // clamped to [0, 1], rounded to nearest; NaN becomes 0
    {
        if (!(v > 0.0f)) return 0;
        if (!(v < 1.0f)) return 255u;
        auto const n = static_cast<std::uint32_t>(v * 255.0f + 0.5f);
        // The product may have been rounded up to a half. 256 v is exact, and so is its difference from a number near it.
        return 256.0f * v - (static_cast<float>(n) - 0.5f) < v ? n - 1 : n;
    }
};
/// A pixel that also has a depth, sum(w z) / sum(w): view z in world units, 0 if no Gaussian took part. It costs 4 bytes more a pixel.
template <class Colour>
struct WithDepth {
    static constexpr char const* name = Colour::name;
    static constexpr bool has_depth = true, has_alpha = Colour::has_alpha;
    Colour colour;
    float depth;
    static WithDepth make(Blended const& b) noexcept { return {Colour::make(b), b.weight > 0.0f ? b.depth / b.weight : 0.0f}; }
};
/// A pixel that also has an alpha, 1 - T: the share of the pixel that is covered. It costs 4 bytes more a pixel.
template <class Colour>
struct WithAlpha {
    static constexpr char const* name = Colour::name;
    static constexpr bool has_depth = Colour::has_depth, has_alpha = true;
    Colour colour;
    float alpha;
    static WithAlpha make(Blended const& b) noexcept { return {Colour::make(b), 1.0f - b.transmittance}; }
};

/// The format of a pixel's colour: one of the library's, or `own`.
template <class Pixel>
inline constexpr ColourFormat colour_format = ColourFormat::own;
template <>
inline constexpr ColourFormat colour_format<FloatPixel> = ColourFormat::float32;
template <>
inline constexpr ColourFormat colour_format<Rgbx8Pixel> = ColourFormat::rgbx8;
template <class Colour>
inline constexpr ColourFormat colour_format<WithDepth<Colour>> = colour_format<Colour>;
template <class Colour>
inline constexpr ColourFormat colour_format<WithAlpha<Colour>> = colour_format<Colour>;

}}} // namespace tilemesh::splat
TILEMESH_EXACT_END
