#pragma once
#include <cstdint>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/report/image.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

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
