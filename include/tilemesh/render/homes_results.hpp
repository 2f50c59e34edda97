#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/either.hpp>
#include <tilemesh/render/host_form.hpp>
#include <tilemesh/render/picture.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/render/tile_sums.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/splat/homes/program.hpp>
#include <type_traits>
#include <utility>

/// What a frame of homes gives: its report from counters, and its picture from the tiles' blocks.
namespace tilemesh { inline namespace v0_2 { namespace render {

using HomesSums = TileSums<splat::homes::Counts, splat::homes::Work>;

/// Adds a run of the program `homes::Frame<P>` to the report of its frame, without the list of unfinished tiles. Throws Error if the
/// protocol is broken.
template <class P>
void account(RunCounters const& run, HomesSums const& sums, report::FrameReport& r)
{
    auto const asked = sums[&splat::homes::Counts::asked], arrived = sums[&splat::homes::Counts::arrived];
    if (asked != arrived)
        throw Error("a frame in which homes sent " + std::to_string(asked) + " splats and tiles received " + std::to_string(arrived) +
                    " (the protocol of homes is broken); report this");
    sums.add_to(r);
    add_traffic(run, r);
    r.homes.rounds += run.loops[0].rounds;
    using namespace splat;
    using Program = homes::Frame<P>;
    constexpr auto tell = step_of<Program, homes::Tell<P>>(), sort = step_of<Program, homes::SortRuns<P>>();
    for (std::uint32_t i = 0; i < run.steps.size(); ++i) { // in program order: project, begin; tell to deliver; sort to finish
        using Stages = report::FrameReport::ByStage;
        auto const stage = i < tell ? &Stages::project : i < sort ? &Stages::route : &Stages::composite;
        r.passes.*stage += run.steps[i].passes;
        r.exchanges.*stage += run.steps[i].exchanges;
        (i < tell ? r.host_ms.project : i < sort ? r.host_ms.route : r.host_ms.composite) += run.steps[i].milliseconds;
    }
    for (auto const& p : run.peaks) {
        if (p.region == homes::Held<P>::name) r.peak_storage = std::max(r.peak_storage, p.items);
        if (p.region == homes::Parcels<P>::name) r.peak_channel = std::max(r.peak_channel, p.items);
    }
}

/// Copies the tiles' blocks into one picture, with the planes that the choice has.
template <class P, class Host>
void copy_blocks(Host& host, splat::homes::Fold const& fold, Setup const& setup, splat::Camera const& camera, RenderedFrame& to)
{
    size_planes(camera, setup.depth, setup.alpha, to);
    bool const round = setup.colour == ColourFormat::rgbx8 && splat::colour_format<typename P::Pixel> == ColourFormat::float32;
    auto const& mesh = std::as_const(host.mesh());
    auto const grid = mesh.grid();
    host.on_threads(grid.size(), [&](std::uint32_t first, std::uint32_t last) {
        for (auto t = first; t < last; ++t) {
            auto const tile = grid.tile(t);
            auto const framebuffer = mesh.template state<splat::homes::Framebuffer<typename P::Pixel>>(tile);
            machine::in_form(setup.has_planes(), framebuffer.begin(), [&](auto const* pixel) {
                for (std::uint32_t b = 0; b < framebuffer.size() / (splat::block_width * splat::block_height); ++b) {
                    auto const place = splat::homes::block_at(fold, tile, b);
                    for (std::uint32_t j = 0; j < splat::block_height; ++j, pixel += splat::block_width) {
                        auto const y = place.y + j;
                        if (!place.exists || y >= camera.height) continue;
                        auto const width = std::min(splat::block_width, camera.width - place.x);
                        for (std::uint32_t i = 0; i < width; ++i) detail::show(pixel[i], place.x + i, y, to);
                        if (round) detail::round_to_levels(to.image.pixel(place.x, y), 3 * width);
                    }
                }
            });
        }
    });
}

}}} // namespace tilemesh::render
