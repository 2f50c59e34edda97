#pragma once
#include <memory>
#include <tilemesh/any_renderer.hpp>
#include <tilemesh/auto_renderer.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/fit_renderer.hpp>
#include <tilemesh/render/homes_renderer.hpp>
#include <tilemesh/scene/demand.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 {

/// Returns a renderer whose pictures are complete, for a map of any density and for any cameras, on host threads. `Base` is a setup of
/// the library that holds (`Hold`). It runs `options.program`. `automatic` runs the anchored program until a frame would lack something, then the
/// program of homes (AutoRenderer). A bound on rounds (`options.rounds`) may leave tiles unfinished; a bound on hops keeps `automatic` on the
/// anchored program.
///
/// Throws Error if the machine has no room for the map: each record needs a place on some tile, whichever program runs; also for options
/// that only the other program has (homes: no `tile`, no `hops`).
template <class Base = splat::Lossless>
std::unique_ptr<AnyRenderer> exact_renderer(scene::Map const& map, RendererOptions const& options = {})
{
    using report::Program;
    static_assert(Base::Saturation::holds && !Base::Pixel::has_depth && !Base::Pixel::has_alpha,
                  "a setup that drops, or has planes (exact_renderer makes complete pictures of colours); use Lossless, or make_homes_renderer");
    bool const only_anchored = options.hops != 0 || options.tile.width != 0 || options.tile.height != 0 || options.sizes;
    if (options.program == Program::homes && only_anchored)
        throw Error("the program of homes with bounded hops, a tile's size or a setup's sizes (only the anchored program has these); leave them "
                    "out, or choose Program::anchored");
    auto const make_homes = [options](scene::Map const& of) {
        auto choice = splat::as_homes(splat::setup_of<Base>());
        choice.sh_degree = scene::demand_of(of).sh_degree;
        return render::make_homes_renderer(scene::needed(of, scene::demand_of(of)), choice,
                                             options.program == Program::homes ? options : render::within(choice, options));
    };
    if (options.program == Program::homes) return make_homes(map);
    auto anchored = fit_to_map<Base>(map, options);
    if (options.program == Program::anchored || only_anchored) return anchored;
    auto const may_fit = render::may_fit_anchored(map.gaussians.size(), anchored->setup(), options);
    return std::make_unique<AutoRenderer>(std::move(anchored), make_homes, may_fit);
}

}} // namespace tilemesh
