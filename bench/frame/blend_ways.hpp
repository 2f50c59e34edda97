#pragma once
#include <common/direct.hpp>
#include <vector>

namespace frame {

/// A way to blend. The machine has two of these, `precise` and `fast`; the others show what a polynomial of lower degree, or a
/// stop by blocks instead of pixels, would gain and cost.
struct BlendWay {
    char const* exponential;
    char const* stop;
    bench::BlendTile blend_tile;
};
/// The first is `precise`.
std::vector<BlendWay> blend_ways();

} // namespace frame
