#pragma once
#include "renderers.hpp"
#include <memory>
#include <tilemesh/fit_renderer.hpp>
#include <tilemesh/render/host_form.hpp>
#include <type_traits>
#include <utility>

namespace render_map {

/// The policies of the library's setups by reference: with or without planes, routing and bloom.
template <bool Planes, bool Routes = true, bool Blooms = true>
struct HostSetup : tilemesh::splat::Fitted<tilemesh::splat::Lossless, 0, Routes, Blooms> {
    using Pixel = std::conditional_t<Planes, tilemesh::splat::WithAlpha<tilemesh::splat::WithDepth<tilemesh::splat::FloatPixel>>,
                                     tilemesh::splat::FloatPixel>;
};
template <template <class, class> class Engine, class Machine, bool Planes, bool Routes = true, bool Blooms = true>
using HostRenderer =
    tilemesh::render::FrameRenderer<tilemesh::splat::PoliciesOf<tilemesh::splat::Referenced<HostSetup<Planes, Routes, Blooms>>>, Engine,
                                    Machine>;

template <class Renderer>
std::unique_ptr<AnyRenderer> make(tilemesh::scene::Map const& map, tilemesh::render::SetupFacts facts, tilemesh::RendererOptions const& options)
{
    return std::make_unique<Renderer>(map, std::move(facts), options);
}

} // namespace render_map
