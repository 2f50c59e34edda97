#pragma once
#include "choice.hpp"
#include "variant.hpp"
#include <memory>
#include <tilemesh/renderer.hpp>

namespace render_map {

/// AnyRenderer over one setup and engine.
template <class Setup, template <class, class> class Engine>
class RendererOf final : public AnyRenderer {
public:
    RendererOf(tilemesh::scene::Map const& map, tilemesh::RendererOptions const& options) : renderer_(map, options)
    {
        if (options.footprint) renderer_.model().footprint = *options.footprint;
    }

    tilemesh::RenderedFrame render(tilemesh::splat::Camera const& camera) override { return renderer_.render(camera); }
    tilemesh::splat::Model const& model() const override { return renderer_.model(); }
    tilemesh::Extent2 grid() override
    {
        auto const grid = renderer_.mesh().grid();
        return {grid.width, grid.height};
    }
    tilemesh::Extent2 tile() override { return {renderer_.tiling().tile_width, renderer_.tiling().tile_height}; }

private:
    tilemesh::BasicRenderer<Setup, Engine> renderer_;
};

/// The renderer of Base under the policies of a choice. Eight setups are compiled for each call of this in the program,
/// some 2 s of compile time each: every call has a .cpp of its own.
template <class Base, template <class, class> class Engine>
std::unique_ptr<AnyRenderer> renderer_with_policies(Choice const& choice, tilemesh::scene::Map const& map,
                                                    tilemesh::RendererOptions const& options)
{
    return with_policies<Base>(choice, [&]<class S>(Type<S>) -> std::unique_ptr<AnyRenderer> {
        return std::make_unique<RendererOf<S, Engine>>(map, options);
    });
}

/// The renderer of Base, on either machine, with the planes of a choice: six setups.
template <class Base>
std::unique_ptr<AnyRenderer> renderer_with_planes(Choice const& choice, tilemesh::scene::Map const& map,
                                                  tilemesh::RendererOptions const& options)
{
    auto const make = [&]<class S>(Type<S>) -> std::unique_ptr<AnyRenderer> {
        return std::make_unique<RendererOf<S, tilemesh::Mesh>>(map, options);
    };
    return choice.machine == MachineKind::mk2 ? with_planes<Base>(choice, make)
                                              : with_planes<tilemesh::splat::Roomy<Base>>(choice, make);
}

} // namespace render_map
