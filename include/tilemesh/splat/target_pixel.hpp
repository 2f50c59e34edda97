#pragma once
#include <cstdint>
#include <tilemesh/config.hpp>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// A pixel of the picture that the camera saw: linear RGB, and the view depth in world units; 0 or NaN if it is not known. A pixel whose
/// colour is NaN does not count.
struct TargetPixel {
    float rgb[3];
    float depth;
};
static_assert(sizeof(TargetPixel) == 16 && std::is_trivially_copyable_v<TargetPixel>, "a target is four words a pixel");

}}} // namespace tilemesh::splat
