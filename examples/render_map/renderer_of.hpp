#pragma once
#include "choice.hpp"
#include "variant.hpp"
#include <memory>
#include <tilemesh/fit_renderer.hpp>

namespace render_map {

/// The renderer of Base under the policies of a choice. Eight setups are compiled for each call of this in the program,
/// some 2 s of compile time each: every call has a .cpp of its own.
template <class Base, template <class, class> class Engine>
std::unique_ptr<AnyRenderer> renderer_with_policies(Choice const& choice, tilemesh::scene::Map const& map,
                                                    tilemesh::RendererOptions const& options)
{
    return with_policies<Base>(choice, [&]<class S>(Type<S>) -> std::unique_ptr<AnyRenderer> {
        return std::make_unique<tilemesh::RendererOf<S, Engine>>(map, options);
    });
}

/// The renderer of Base, on either machine, with the planes of a choice: six setups.
template <class Base>
std::unique_ptr<AnyRenderer> renderer_with_planes(Choice const& choice, tilemesh::scene::Map const& map,
                                                  tilemesh::RendererOptions const& options)
{
    auto const make = [&]<class S>(Type<S>) -> std::unique_ptr<AnyRenderer> {
        return std::make_unique<tilemesh::RendererOf<S>>(map, options);
    };
    return choice.machine == MachineKind::mk2 ? with_planes<Base>(choice, make)
                                              : with_planes<tilemesh::splat::Roomy<Base>>(choice, make);
}

/// `On` is what the machine makes of a setup. Every degree, and routing and bloom where they have something to do; a build for
/// the compiler's sake has one of each kind.
template <template <class> class On>
std::unique_ptr<AnyRenderer> fitted(tilemesh::scene::Map const& map, tilemesh::scene::Demand const& demand,
                                    tilemesh::RendererOptions const& options)
{
    using tilemesh::splat::Fitted;
    using Base = tilemesh::splat::Lossless;
    if (demand.sh_degree == 0 && demand.moves) return nullptr;
    if constexpr (own_policies_only)
        return tilemesh::fit_renderer<On<Fitted<Base, 0, false, false>>, On<Fitted<Base, 0, false, true>>,
                                      On<Fitted<Base, 3>>>(map, demand, options);
    else
        return tilemesh::fit_renderer<On<Fitted<Base, 0, false, false>>, On<Fitted<Base, 0, false, true>>,
                                      On<Fitted<Base, 1, false>>, On<Fitted<Base, 1>>, On<Fitted<Base, 2, false>>,
                                      On<Fitted<Base, 2>>, On<Fitted<Base, 3, false>>, On<Fitted<Base, 3>>>(map, demand,
                                                                                                            options);
}

} // namespace render_map
