#pragma once
#include <cstdint>
#include <tilemesh/machine/operations.hpp>
#include <tilemesh/splat/camera.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The operations on which the kernels of splatting spend their time. `mk2()` gives them prices.
struct Operation {
    enum Kind : std::uint32_t {
        slot,       ///< a slot of a list or channel end that a kernel looks at
        projection, ///< a record that is projected, in units of a pinhole's (projections_through)
        routed,     ///< a record on its way that is taken from a channel or given to one
        copied,     ///< a copy that is taken from a channel or given to one
        comparison, ///< two keys that are compared and put in order
        pair,       ///< a Gaussian-pixel pair that is evaluated
        pixel       ///< a pixel that is begun and written
    };
    static constexpr char const* names[] = {"slot", "projection", "routed", "copied", "comparison", "pair", "pixel"};
};
using Operations = tilemesh::Operations<Operation>;

/// n projections, as a cost model counts them: one through a lens that bends, or by a rolling shutter, counts so many sixteenths more as it
/// takes more issue slots (tests/model/cost_parameters.cpp counts them).
inline std::uint32_t projections_through(Camera const& c, std::uint32_t n) noexcept
{
    constexpr std::uint32_t of_lens[] = {0, 3, 1, 4, 0}, of_shutter[] = {11, 23, 22, 27, 0}; // by LensKind
    auto const kind = static_cast<std::uint32_t>(c.lens.kind);
    std::uint32_t const sixteenths = 16 + (c.shutter.reach > 0 ? of_shutter[kind] : of_lens[kind]);
    return n / 16 * sixteenths + n % 16 * sixteenths / 16;
}

}}} // namespace tilemesh::splat
