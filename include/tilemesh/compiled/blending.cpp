// A part of tilemesh::compiled: blending by reference, by one worker of a tile or by one thread for all of them.
#include <tilemesh/render/host_form.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

using Planes = WithAlpha<WithDepth<FloatPixel>>;

PairCount blend_tile(PixelRect const& tile, Camera const& camera, Rules const& rules, std::uint32_t n, RowsInOrder const& at,
                     FloatPixel* pixels, std::uint32_t stride_px, Worker worker) noexcept
{
    return blend_tile<detail::native_lanes>(tile, camera, rules, n, at, pixels, stride_px, worker);
}
PairCount blend_tile(PixelRect const& tile, Camera const& camera, Rules const& rules, std::uint32_t n, RowsInOrder const& at,
                     Planes* pixels, std::uint32_t stride_px, Worker worker) noexcept
{
    return blend_tile<detail::native_lanes>(tile, camera, rules, n, at, pixels, stride_px, worker);
}
void blend_whole_tile(PixelRect const& tile, Camera const& camera, Rules const& rules, std::uint32_t n, RowsInOrder const& at,
                      FloatPixel* pixels, std::uint32_t stride_px, PairCount* counts, std::uint32_t workers) noexcept
{
    blend_whole_tile<detail::lanes_in_use>(tile, camera, rules, n, at, pixels, stride_px, counts, workers);
}
void blend_whole_tile(PixelRect const& tile, Camera const& camera, Rules const& rules, std::uint32_t n, RowsInOrder const& at,
                      Planes* pixels, std::uint32_t stride_px, PairCount* counts, std::uint32_t workers) noexcept
{
    blend_whole_tile<detail::lanes_in_use>(tile, camera, rules, n, at, pixels, stride_px, counts, workers);
}

}}} // namespace tilemesh::splat
