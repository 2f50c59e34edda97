#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/report/image.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

namespace detail {

/// The weights of one output pixel along one axis, in units of 2^-22, for the input pixels from `first` on.
struct Taps {
    std::size_t first = 0;
    std::vector<std::int32_t> weights;
};
/// 22: eight bits of a value, two bits for sums of weights above 1 and the sign leave 22 of 32.
inline constexpr int tap_bits = 22;

/// Keys' cubic convolution with a = -0.5 (IEEE Trans. ASSP 29, 1981).
TILEMESH_HOST double cubic(double x);

/// The cubic, stretched by the ratio of the sizes if the picture shrinks, sampled at the centres of the input pixels, and normalised.
TILEMESH_HOST std::vector<Taps> taps_of(std::uint32_t from, std::uint32_t to);

/// The rounded, clamped level of a weighted sum of levels. `at(k)` is the level at the k-th tap.
template <class At>
std::uint8_t level_of(Taps const& taps, At const& at)
{
    std::int64_t sum = std::int64_t{1} << (tap_bits - 1);
    for (std::size_t k = 0; k < taps.weights.size(); ++k) sum += std::int64_t{taps.weights[k]} * at(taps.first + k);
    return static_cast<std::uint8_t>(std::clamp<std::int64_t>(sum >> tap_bits, 0, 255));
}

} // namespace detail

/// A photograph in another size, as the trainers of 3D Gaussian Splatting and gsplat make it: Pillow's `resize(size, BICUBIC)` of 8-bit
/// pixels. Each channel alone; a cubic filter, stretched if the picture shrinks; first along rows, then along columns, rounded to 8 bits
/// after each. The result has levels of 1/255, like a photograph. Values of `photograph` are clamped to [0, 1] and rounded to 8 bits first.
///
/// Throws `tilemesh::Error` for a picture without pixels and for a side outside 1..65535. Cost: 3 bytes for each pixel of the larger and of
/// the middle picture; time linear in the pixels and in the ratio of the sizes.
TILEMESH_HOST Image resized_as_photograph(Image const& photograph, std::uint32_t width, std::uint32_t height);

}}} // namespace tilemesh::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/resample_code.hpp>
#endif
