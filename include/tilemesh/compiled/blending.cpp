// A part of tilemesh::compiled: blending on the host, by one thread for all workers of a tile or by one worker.
#include <tilemesh/render/host_form.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat::detail {
#define TILEMESH_BLENDS(Lanes, Group, Size, Pixel)                                                                                        \
    template void blend_tile_as_asked<Lanes, Group, Size, Pixel, RowsInOrder>(PixelRect const&, Camera const&, Model const&,             \
                                                                              std::uint32_t, RowsInOrder const&, Pixel*, std::uint32_t,   \
                                                                              Worker, PairCount*, std::uint32_t) noexcept
TILEMESH_BLENDS(lanes_in_use, 8, 128, FloatPixel);
TILEMESH_BLENDS(lanes_in_use, 8, 128, WithAlpha<WithDepth<FloatPixel>>);
TILEMESH_BLENDS(native_lanes, 1, 16, FloatPixel);
TILEMESH_BLENDS(native_lanes, 1, 16, WithAlpha<WithDepth<FloatPixel>>);
#undef TILEMESH_BLENDS
}}} // namespace tilemesh::splat::detail
