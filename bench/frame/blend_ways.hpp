#pragma once
#include <common/direct.hpp>
#include <vector>

namespace frame {

/// A way to blend. The machine has two of these, `precise` and `fast`. The others show the gain and the cost of a polynomial of lower
/// degree, or of a stop by blocks instead of pixels.
struct BlendWay {
    char const* exponential;
    char const* stop;
    bench::BlendTile blend_tile;
};
/// Returns all ways; the first one is `precise`.
std::vector<BlendWay> blend_ways();

} // namespace frame
