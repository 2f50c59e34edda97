#pragma once
#include <tilemesh/machine/spec.hpp>
#include <tilemesh/splat/policies.hpp>
#include <tilemesh/splat/setup.hpp>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 { namespace splat {

struct BlendAsAsked;

namespace detail {
/// The machine of a setup's value as a type.
template <auto const& V>
struct MachineOf {
    static constexpr char const* name = V.machine.name;
    static constexpr std::uint32_t tiles = V.machine.tiles, sram_bytes = V.machine.sram_bytes, code_bytes = V.machine.code_bytes,
                                   workers = V.machine.workers, clock_khz = V.machine.clock_khz;
};
template <bool Has, template <class> class Plane, class Pixel>
using AddPlane = std::conditional_t<Has, Plane<Pixel>, Pixel>;
} // namespace detail

/// A setup's value as types: kernels are compiled for it alone, for codelets and for what a scene does not need. `V` is a constant of
/// namespace scope: `struct Narrow : SetupType<narrow> {};`. Derive from a setup type to replace members by your own types: a policy, a
/// machine, a record or a pixel. Setups that differ only in machine, sizes or rules of the picture share all kernels.
template <auto const& V>
struct SetupType {
    using Machine = detail::MachineOf<V>;
    using Record = GaussianOfDegree<V.sh_degree>;     ///< or ShadedGaussian<Degree>, for a colour that depends on the view
    using Projected = Splat;                          ///< an entry of Splats
    using Parameters = FrameParameters;               ///< the frame's broadcast
    using Routing = RowFirst;
    using PlainSaturation = std::conditional_t<V.holds, Hold, Drop>;
    using Saturation = std::conditional_t<V.ranks, LargestFirst<PlainSaturation>, PlainSaturation>;
    using Addressing = std::conditional_t<V.carried, Carried, Recomputed>;
    using Copies = std::conditional_t<V.reusable, WorldCopies, ScreenCopies>;
    using Pixel = detail::AddPlane<V.alpha, WithAlpha,
                                   detail::AddPlane<V.depth, WithDepth,
                                                    std::conditional_t<V.colour == ColourFormat::rgbx8, Rgbx8Pixel, FloatPixel>>>;
    using Blending = BlendAsAsked;                    ///< blending.hpp
    static constexpr char const* name = V.name;
    static constexpr Sizes sizes = V.sizes;
    static constexpr bool routes = V.routes, blooms = V.blooms;
    static constexpr Footprint footprint = V.rules.footprint;
    static constexpr float alpha_max = V.rules.alpha_max, transmittance_min = V.rules.transmittance_min;
    static constexpr Arithmetic arithmetic = V.rules.arithmetic;
};

/// The setups of the library as types.
struct Lossless : SetupType<lossless> {
    using Machine = Mk2;
};
struct Paper : SetupType<paper> {
    using Machine = Mk2;
};
struct Prototype : SetupType<prototype> {
    using Machine = Mk2;
};

/// The value of a setup type: the way back from types that were replaced.
template <class S>
constexpr Setup setup_of() noexcept
{
    constexpr auto colour = colour_format<typename S::Pixel>;
    Setup s;
    s.name = S::name;
    s.machine = size_of_machine<typename S::Machine>();
    s.sizes = S::sizes;
    s.holds = S::Saturation::holds;
    s.carried = S::Addressing::carried;
    s.reusable = S::Copies::reusable;
    s.ranks = may_rank<typename S::Saturation>;
    s.routes = S::routes;
    s.blooms = S::blooms;
    s.sh_degree = S::Record::sh_degree;
    s.colour = colour;
    s.depth = S::Pixel::has_depth;
    s.alpha = S::Pixel::has_alpha;
    s.rules.footprint = S::footprint;
    s.rules.alpha_max = S::alpha_max;
    s.rules.transmittance_min = S::transmittance_min;
    s.rules.arithmetic = S::arithmetic;
    if constexpr (!std::is_same_v<typename S::Record, GaussianOfDegree<S::Record::sh_degree>>) s.own_record_bytes = sizeof(typename S::Record);
    if constexpr (!std::is_same_v<typename S::Parameters, FrameParameters>) s.own_parameter_bytes = sizeof(typename S::Parameters);
    if constexpr (colour == ColourFormat::own) s.own_pixel_bytes = sizeof(typename S::Pixel);
    return s;
}

/// A machine and sizes with room for a whole map and a whole frame on one tile. Channels keep their slots.
using RoomyMachine = TestMachine<64u << 20>;
constexpr Sizes roomy(Sizes sizes) noexcept
{
    sizes.storage = 40'000;
    sizes.tile_pixels = 1u << 20;
    sizes.lists_fit = true;
    return sizes;
}

}}} // namespace tilemesh::splat

namespace tilemesh { inline namespace v0_2 {
/// The ledger of a program under a setup type of splatting is that of the setup's value.
template <class S>
inline constexpr auto sizes_of<S, std::void_t<typename S::Saturation, typename S::Addressing, typename S::Pixel>> = splat::setup_of<S>();
}} // namespace tilemesh
