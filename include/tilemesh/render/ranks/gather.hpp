#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tilemesh/render/picture.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/splat/view.hpp>
#include <vector>

/// What the first of several processes collects of a frame. Every process calls these functions with its own part of a mesh.
namespace tilemesh { inline namespace v0_2 { namespace render {

/// A process has whole rows of the picture, one process after the other, so the first receives the others' rows where they belong. The
/// others then have a picture of no width, and keep its memory for the next frame.
template <class P, class M>
void gather_picture(M& mesh, Setup const& setup, splat::Tiling const& tiling, splat::Camera const& camera, RenderedFrame& to)
{
    auto const row_of = [&](std::uint32_t rank) {
        return rank == mesh.ranks() ? tiling.rows : std::min(mesh.bands().first(rank), tiling.rows);
    };
    auto const y_of = [&](std::uint32_t rank) { return std::min(row_of(rank) * tiling.tile_height, camera.height); };
    auto const pixels_of = [&](std::uint32_t rank) { return std::size_t{camera.width} * (y_of(rank + 1) - y_of(rank)); };
    auto const me = mesh.rank();
    mesh.together([&] {
        if (me == 0) {
            size_planes(camera, setup.depth, setup.alpha, to);
        } else {
            to.image.rgb.resize(3 * pixels_of(me));
            to.depth.values.resize(setup.depth ? pixels_of(me) : 0);
            to.alpha.values.resize(setup.alpha ? pixels_of(me) : 0);
            to.image.width = camera.width;
            to.depth.width = setup.depth ? camera.width : 0;
            to.alpha.width = setup.alpha ? camera.width : 0;
        }
        copy_picture<P>(mesh, setup, tiling, camera, row_of(me), row_of(me + 1), to);
    });
    mesh.join(to.image.rgb.data(), [&](std::uint32_t rank) { return 3 * pixels_of(rank); });
    if (setup.depth) mesh.join(to.depth.values.data(), pixels_of);
    if (setup.alpha) mesh.join(to.alpha.values.data(), pixels_of);
    if (me == 0) return;
    to.image.width = to.depth.width = to.alpha.width = 0; // the colours stay in memory: to fill them with zeros in each frame takes as
    to.depth.values.clear();                              // long as to copy them
    to.alpha.values.clear();
}

/// Gives every process the counts in the first one's report that follow from the losses.
template <class M>
void share_counts(M& mesh, report::FrameReport& r)
{
    auto const full = r.full_tiles.value_or(report::FullTiles{});
    std::vector<std::uint64_t> words;
    mesh.together([&] {
        words = {r.gaussians.under_way, r.gaussians.unplaced, r.gaussians.dropped, r.lost_copies, r.late_copies, r.full_tiles ? 1u : 0u,
                 full.count, full.fullest, full.slots_needed, full.slots_available};
    });
    mesh.share(words);
    r.gaussians.under_way = words[0];
    r.gaussians.unplaced = words[1];
    r.gaussians.dropped = words[2];
    r.lost_copies = words[3];
    r.late_copies = words[4];
    if (words[5] != 0)
        r.full_tiles = {static_cast<std::uint32_t>(words[6]), static_cast<std::uint32_t>(words[7]), words[8], words[9]};
}

}}} // namespace tilemesh::render
