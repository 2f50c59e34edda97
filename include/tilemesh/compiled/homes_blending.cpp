// A part of tilemesh::compiled: blending of the program of homes, by one worker of a tile or by one thread for all of them.
#include <tilemesh/render/homes_form.hpp>
#include <tilemesh/splat/homes/blend.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat::homes {

void blend_window(NarrowBlock* blocks, Fold const& fold, TileId tile, View const& view, std::uint32_t finished, std::uint32_t n,
                  HeldRowsInOrder const& at, Worker worker, Work& work) noexcept
{
    blend_window<>(blocks, fold, tile, view, finished, n, at, worker, work);
}
void blend_window(WideBlock* blocks, Fold const& fold, TileId tile, View const& view, std::uint32_t finished, std::uint32_t n,
                  HeldRowsInOrder const& at, Worker worker, Work& work) noexcept
{
    blend_window<>(blocks, fold, tile, view, finished, n, at, worker, work);
}
void blend_whole_window(NarrowBlock* blocks, Fold const& fold, TileId tile, View const& view, std::uint32_t finished, std::uint32_t n,
                        HeldRowsInOrder const& at, std::uint32_t workers, Work& work) noexcept
{
    blend_whole_window<>(blocks, fold, tile, view, finished, n, at, workers, work);
}
void blend_whole_window(WideBlock* blocks, Fold const& fold, TileId tile, View const& view, std::uint32_t finished, std::uint32_t n,
                        HeldRowsInOrder const& at, std::uint32_t workers, Work& work) noexcept
{
    blend_whole_window<>(blocks, fold, tile, view, finished, n, at, workers, work);
}

}}} // namespace tilemesh::splat::homes
