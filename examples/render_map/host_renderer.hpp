#pragma once
#include "renderers.hpp"
#include <tilemesh/fit_renderer.hpp>
#include <tilemesh/render/host_form.hpp>
#include <type_traits>

namespace render_map {

/// The policies of the library's setups by reference; with planes, without routing or bloom.
template <bool Planes, bool Routes = true, bool Blooms = true>
struct HostSetup : tilemesh::splat::Fitted<tilemesh::splat::Lossless, 0, Routes, Blooms> {
    using Pixel = std::conditional_t<Planes, tilemesh::splat::WithAlpha<tilemesh::splat::WithDepth<tilemesh::splat::FloatPixel>>,
                                     tilemesh::splat::FloatPixel>;
};
template <template <class, class> class Engine, class Machine, bool Planes, bool Routes = true, bool Blooms = true>
using HostRenderer =
    tilemesh::render::FrameRenderer<tilemesh::splat::PoliciesOf<tilemesh::splat::Referenced<HostSetup<Planes, Routes, Blooms>>>, Engine,
                                    Machine>;

} // namespace render_map
