#pragma once
#include "choice.hpp"
#include <memory>

/// One function for each renderer that is compiled, in a .cpp of its own. Machines, sizes, saturation, copies, colour formats and degrees
/// of harmonics are values.
namespace render_map {

using MakeRenderer = std::unique_ptr<AnyRenderer>(tilemesh::scene::Map const&, tilemesh::render::SetupFacts,
                                                  tilemesh::RendererOptions const&);
MakeRenderer threads, threads_planes, threads_traced, threads_planes_traced; ///< the traced ones are `Instruments`
MakeRenderer sequential, sequential_planes, sequential_traced, sequential_planes_traced;
MakeRenderer threads_placed;          ///< without routing: the host places the records of a view that stays
MakeRenderer threads_placed_unspread; ///< without routing and bloom: no footprint touches two tiles

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
