#pragma once
#include <tilemesh/machine/kernel.hpp>
#include <type_traits>

namespace tilemesh::splat {

/// Which of the frame's optional steps a setup has.
template <bool Routes, bool Blooms>
struct FrameParts {
    static constexpr bool routes = Routes, blooms = Blooms;
};

/// The types that change what kernels do, and nothing else. Kernels, regions and channels are templates of this set. Two setups that
/// differ only in machine, sizes or model have the same set, and so share all code.
template <class Words, class Motion, class Picture, class Parts>
struct Policies;
template <class RecordType, class ProjectedType, class ParametersType, class RoutingType, class SaturationType, class AddressingType,
          class CopiesType, class PixelType, class BlendingType, class PartsType>
struct Policies<Types<RecordType, ProjectedType, ParametersType>, Types<RoutingType, SaturationType, AddressingType, CopiesType>,
                Types<PixelType, BlendingType>, PartsType> {
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
    using type = Policies<Types<typename S::Record, typename S::Projected, typename S::Parameters>,
                          Types<typename S::Routing, typename S::Saturation, typename S::Addressing, typename S::Copies>,
                          Types<typename S::Pixel, typename S::Blending>, FrameParts<S::routes, S::blooms>>;
};
template <class W, class M, class P, class F>
struct PolicySet<Policies<W, M, P, F>> {
    using type = Policies<W, M, P, F>;
};
} // namespace detail

/// The policies of a setup (setup.hpp). For a set of policies it is that set.
template <class S>
using PoliciesOf = typename detail::PolicySet<S>::type;

} // namespace tilemesh::splat
