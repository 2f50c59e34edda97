#pragma once
#include <tilemesh/splat/fitted.hpp>

/// Setups of the default, feature by feature.
namespace leave_out {
using namespace tilemesh::splat;

using minimal = Fitted<Lossless, 0, false, false>;     ///< one colour a record, one view, nothing that spans two tiles
using with_bloom = Fitted<Lossless, 0, false, true>;
using with_routing = Fitted<Lossless, 0, true, false>;
using both = Fitted<Lossless, 0, true, true>;          ///< what Lossless is
using degree_1 = Fitted<Lossless, 1>;
using degree_2 = Fitted<Lossless, 2>;
using degree_3 = Fitted<Lossless, 3>;
using with_depth = WithPixel<both, WithDepth<FloatPixel>>;
using with_alpha = WithPixel<both, WithAlpha<FloatPixel>>;
using everything = WithPixel<degree_3, WithAlpha<WithDepth<FloatPixel>>>;
/// Room for a frame on one tile of a test machine.
struct Roomy : Lossless {
    using Machine = RoomyMachine;
    static constexpr Sizes sizes = roomy(Lossless::sizes);
};
using one_tile = Fitted<Roomy, 0, false, false>; ///< minimal with room for a frame on one tile of a test machine

/// A setup whose policies are others by name alone: setups that share a set of policies share their kernels.
template <class S>
struct Twin : S {
    struct Parameters : S::Parameters {};
};
} // namespace leave_out
