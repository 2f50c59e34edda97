#pragma once
#include <cstdint>
#include <tilemesh/machine/either.hpp>
#include <tilemesh/splat/blending.hpp>
#include <tilemesh/splat/fitted.hpp>
#include <tilemesh/splat/policies.hpp>
#include <tilemesh/splat/references.hpp>
#include <type_traits>

/// The host's form of the frame program: tiles and channels hold references to the rows of a table instead of records.
///
/// The machine moves values: records of 60 bytes or more, and each tile projects its own records. A host that simulates the machine has one
/// memory. It keeps one instance of each record, projects the record once per view, and moves the number of its row. The kernels of both
/// forms are one text, which asks `splat::Access` (by reference: splat/references.hpp); where `Access::on_host` holds, those of homes take a
/// shortcut that leaves the same words. Both forms have the same capacities in slots, bytes on the wire, counters and pictures, bit for bit.
///
/// A reference has the same size for every kind of record, and the rule for full channels is a word in the frame's parameters. So many
/// setups share one set of policies and its code: setups that differ in machine, sizes, degree of harmonics, saturation, addressing, copies
/// or colour format. `HostSetup` has planes, routing and bloom as words too, so its policies serve all of these setups.
namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The policies of a setup as words.
constexpr PolicyWords policy_words(Setup const& s) noexcept
{
    auto const word = [](bool set) { return set ? 1u : 0u; };
    return {word(s.holds), word(s.carried), word(s.reusable), road_bytes(s), beam_bytes(s), word(s.ranks && (s.routes || s.blooms))};
}

/// Do the frame's parameters have the setup's rules, as TableParameters and PolicyParameters do?
template <class Parameters, class = void>
inline constexpr bool has_policies = false;
template <class Parameters>
inline constexpr bool has_policies<Parameters, std::void_t<decltype(Parameters::policies)>> = true;

/// Policies whose rule is a word in the frame's parameters.
struct RunTimeSaturation {
    static constexpr char const* name = "at run time";
    static constexpr bool may_hold = true, may_rank = true;
    template <class Parameters>
    TILEMESH_KERNEL static bool holds_in(Parameters const& frame) noexcept { return frame.policies.holds != 0; }
    template <class Parameters>
    TILEMESH_KERNEL static bool ranks_in(Parameters const& frame) noexcept { return frame.policies.ranks != 0; }
};
struct RunTimeAddressing : Carried {
    static constexpr char const* name = "at run time";
    template <class Parameters>
    TILEMESH_KERNEL static bool carried_in(Parameters const& frame) noexcept { return frame.policies.carried != 0; }
};

/// Bloom sends references: the tiles forget them in a new view, if the setup's copies last for one view only.
struct RunTimeCopies {
    static constexpr char const* name = "at run time";
    template <class Record>
    using Message = Record;
    TILEMESH_KERNEL static bool reusable_in(TableParameters const& frame) noexcept { return frame.policies.reusable != 0; }
    TILEMESH_KERNEL static Reference make(Reference const& g, Splat const&) noexcept { return g; }
    template <class>
    TILEMESH_KERNEL static Reference record(Reference const& m) noexcept
    {
        return m;
    }
    TILEMESH_KERNEL static SplatRow splat(Reference const& m, TableParameters const&) noexcept { return {m.row}; }
};

/// Is the colour in one of the library's formats? For these, the host makes the picture from floats.
template <class Pixel>
inline constexpr bool is_known_colour = colour_format<Pixel> != ColourFormat::own;
/// The pixel type that the host stores. Colours are floats; the picture shows them in the setup's format. If a setup has one plane, the
/// host stores both.
template <class Pixel>
using HostPixel = std::conditional_t<!is_known_colour<Pixel>, Pixel,
                                     std::conditional_t<Pixel::has_depth || Pixel::has_alpha, WithAlpha<WithDepth<FloatPixel>>, FloatPixel>>;

/// The policies of setup S by reference. The ledger is still that of S; it is in `Tile<Machine, Frame<S>, S>`.
template <class S>
struct Referenced : S {
    using Value = S;
    using Record = Reference;
    using Projected = SplatRow;
    using Parameters = TableParameters;
    using Saturation = RunTimeSaturation;
    using Addressing = RunTimeAddressing;
    using Copies = RunTimeCopies;
    using Pixel = HostPixel<typename S::Pixel>;
};

/// The pixel of a host that serves setups with and without planes: all planes, or only a colour, as the parameters say.
struct HostPixels : machine::Either<WithAlpha<WithDepth<FloatPixel>>, FloatPixel> {
    static constexpr char const* name = FloatPixel::name;
    static constexpr bool has_depth = true, has_alpha = true;
};
template <>
inline constexpr ColourFormat colour_format<HostPixels> = ColourFormat::float32;

/// The policies of setups by reference as words: a program of these policies serves every setup `Referenced<S>` whose S has the library's
/// routing, blending and colours. Pictures, counters, traces and digests are those of `PoliciesOf<Referenced<S>>`. A step that a setup
/// leaves out does not run, and its states and channels are in no digest.
template <class S>
struct HostSetup : Referenced<S> {
    using Parameters = HostParameters;
    using Pixel = HostPixels;
    static constexpr bool routes = true, blooms = true; ///< the program has these steps; the parameters say whether a frame has them
};
namespace detail {
template <class P>
inline constexpr bool is_host_form = false;
template <class R, class Pixel, class B, class Parts, class... Motion>
inline constexpr bool is_host_form<Policies<machine::Types<Reference, SplatRow, TableParameters>, machine::Types<R, Motion...>,
                                            machine::Types<Pixel, B>, Parts>> =
    std::is_same_v<machine::Types<R, Motion...>, machine::Types<RowFirst, RunTimeSaturation, RunTimeAddressing, RunTimeCopies>> &&
    std::is_same_v<B, BlendAsAsked> && is_known_colour<Pixel>;
} // namespace detail
/// Does a program of the policies of `HostSetup` serve the setups with these policies?
template <class S>
inline constexpr bool is_served_by_words = detail::is_host_form<PoliciesOf<S>>;

/// The setup whose machine S simulates: T if S is Referenced<T> or Valued<T>, otherwise S.
template <class S, class = void>
struct ValueOf {
    using type = S;
};
template <class S>
struct ValueOf<S, std::void_t<typename S::Value>> {
    using type = typename S::Value;
};

}}} // namespace tilemesh::splat

#if defined(TILEMESH_COMPILED)
namespace tilemesh { inline namespace v0_2 { namespace splat {

// The compiled library blends by reference. Its functions take the place of the templates in splat/blending.hpp and have the same results.
// Their types name no lanes, so a unit that was built for another number of lanes links.
PairCount blend_tile(PixelRect const& tile, Camera const& camera, Rules const& rules, std::uint32_t n, RowsInOrder const& at,
                     FloatPixel* pixels, std::uint32_t stride_px, Worker worker) noexcept;
PairCount blend_tile(PixelRect const& tile, Camera const& camera, Rules const& rules, std::uint32_t n, RowsInOrder const& at,
                     WithAlpha<WithDepth<FloatPixel>>* pixels, std::uint32_t stride_px, Worker worker) noexcept;
void blend_whole_tile(PixelRect const& tile, Camera const& camera, Rules const& rules, std::uint32_t n, RowsInOrder const& at,
                      FloatPixel* pixels, std::uint32_t stride_px, PairCount* counts, std::uint32_t workers) noexcept;
void blend_whole_tile(PixelRect const& tile, Camera const& camera, Rules const& rules, std::uint32_t n, RowsInOrder const& at,
                      WithAlpha<WithDepth<FloatPixel>>* pixels, std::uint32_t stride_px, PairCount* counts, std::uint32_t workers) noexcept;

}}} // namespace tilemesh::splat
#endif
