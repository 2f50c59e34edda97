#pragma once
#include <cstdint>
#include <tilemesh/machine/operations.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The operations on which the kernels of splatting spend their time. `mk2()` gives them prices.
struct Operation {
    enum Kind : std::uint32_t {
        slot,       ///< a slot of a list or channel end that a kernel looks at
        projection, ///< a record that is projected
        routed,     ///< a record on its way that is taken from a channel or given to one
        copied,     ///< a copy that is taken from a channel or given to one
        comparison, ///< two keys that are compared and put in order
        pair,       ///< a Gaussian-pixel pair that is evaluated
        pixel       ///< a pixel that is begun and written
    };
    static constexpr char const* names[] = {"slot", "projection", "routed", "copied", "comparison", "pair", "pixel"};
};
using Operations = tilemesh::Operations<Operation>;

}}} // namespace tilemesh::splat
