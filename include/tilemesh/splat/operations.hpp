#pragma once
#include <cstdint>
#include <tilemesh/machine/operations.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// What the kernels of splatting spend their time on; `mk2()` prices these.
struct Operation {
    enum Kind : std::uint32_t {
        slot,       ///< a slot of a list or channel end looked at
        projection, ///< a record projected
        routed,     ///< a record taken from a channel, or given to one, on its way
        copied,     ///< a copy taken from a channel, or given to one
        comparison, ///< two keys compared and put in order
        pair,       ///< a Gaussian-pixel pair evaluated
        pixel       ///< a pixel begun and written
    };
    static constexpr char const* names[] = {"slot", "projection", "routed", "copied", "comparison", "pair", "pixel"};
};
using Operations = tilemesh::Operations<Operation>;

}}} // namespace tilemesh::splat
