#pragma once
#include <tilemesh/machine/kernel.hpp>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The optional steps of the frame that a setup has.
template <bool Routes, bool Blooms>
struct FrameParts {
    static constexpr bool routes = Routes, blooms = Blooms;
};

/// The types that change what kernels do, and nothing else. Kernels, regions and channels are templates of this set. Two setups that differ
/// only in machine, sizes or rules have the same set, so they share all code.
template <class Words, class Motion, class Picture, class Parts>
struct Policies;
template <class RecordType, class ProjectedType, class ParametersType, class RoutingType, class SaturationType, class AddressingType,
          class CopiesType, class PixelType, class BlendingType, class PartsType>
struct Policies<machine::Types<RecordType, ProjectedType, ParametersType>, machine::Types<RoutingType, SaturationType, AddressingType, CopiesType>,
                machine::Types<PixelType, BlendingType>, PartsType> {
    using Record = RecordType;
    using Projected = ProjectedType;
    using Parameters = ParametersType;
    using Routing = RoutingType;
    using Saturation = SaturationType;
    using Addressing = AddressingType;
    using Copies = CopiesType;
    using Pixel = PixelType;
    using Blending = BlendingType;
    static constexpr bool routes = PartsType::routes, blooms = PartsType::blooms;
};

namespace detail {
template <class S>
struct PolicySet {
    using type = Policies<machine::Types<typename S::Record, typename S::Projected, typename S::Parameters>,
                          machine::Types<typename S::Routing, typename S::Saturation, typename S::Addressing, typename S::Copies>,
                          machine::Types<typename S::Pixel, typename S::Blending>, FrameParts<S::routes, S::blooms>>;
};
template <class W, class M, class P, class F>
struct PolicySet<Policies<W, M, P, F>> {
    using type = Policies<W, M, P, F>;
};
} // namespace detail

/// Do the parameters say which steps a run has, in words `routes`, `blooms` and `draws`? A host's parameters may
/// (render/host_form.hpp). Then `P::routes` and `P::blooms` mean that the program has these steps under a condition. A run that does not
/// draw ends after bloom: tiles neither sort nor composite.
template <class Parameters, class = void>
inline constexpr bool has_parts_words = false;
template <class Parameters>
inline constexpr bool has_parts_words<
    Parameters, std::void_t<decltype(Parameters::routes), decltype(Parameters::blooms), decltype(Parameters::draws)>> = true;

/// Does this frame route? `frame`: the frame's parameters, or what `Access::hold` keeps of them.
template <class P, class Frame>
TILEMESH_KERNEL constexpr bool routes_in([[maybe_unused]] Frame const& frame) noexcept
{
    if constexpr (P::routes && has_parts_words<Frame>)
        return frame.routes != 0;
    else
        return P::routes;
}
/// Does this frame bloom? See `routes_in`.
template <class P, class Frame>
TILEMESH_KERNEL constexpr bool blooms_in([[maybe_unused]] Frame const& frame) noexcept
{
    if constexpr (P::blooms && has_parts_words<Frame>)
        return frame.blooms != 0;
    else
        return P::blooms;
}

/// The policies of a setup (setup.hpp). If S is a set of policies, it is S.
template <class S>
using PoliciesOf = typename detail::PolicySet<S>::type;

}}} // namespace tilemesh::splat
