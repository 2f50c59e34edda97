#pragma once
#include <cstdint>
#include <tilemesh/machine/operations.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat::map {

/// The operations on which the kernels of a mapping step spend their time, besides those of a frame (splat/operations.hpp). `mk2()` has no
/// prices for them; bench/mapping has.
struct Operation {
    enum Kind : std::uint32_t {
        slot,        ///< a slot of a list that a kernel looks at
        cast_copy,   ///< a projected copy that is taken from a channel or given to one
        map_pair,    ///< a Gaussian-pixel pair of the first walk, on all workers
        walked_pair, ///< a pair of the second walk, on all workers
        pixel_slope, ///< the loss of a pixel and its slopes, on all workers
        gathered,    ///< the ten sums of a worker that are cleared and added, on all workers
        returned,    ///< an answer that is taken from a channel or given to one
        chain        ///< the chain rule and the step of a record, on all workers
    };
    static constexpr char const* names[] = {"slot", "cast_copy", "map_pair", "walked_pair", "pixel_slope", "gathered", "returned", "chain"};
};
using Operations = tilemesh::Operations<Operation>;

/// The operations of records with harmonics.
struct ShadedOperation {
    enum Kind : std::uint32_t {
        slot, projection, chain, ///< as in `Operation` and `splat::Operation`
        harmonic                 ///< a function of the direction, for three channels: in a colour, or in a step; on all workers
    };
    static constexpr char const* names[] = {"slot", "projection", "chain", "harmonic"};
};
using ShadedOperations = tilemesh::Operations<ShadedOperation>;

}}} // namespace tilemesh::splat::map
