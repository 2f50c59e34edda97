#pragma once
#include "choice.hpp"
#include <memory>
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/render/ranks/host.hpp>
#include <tilemesh/mpi/mpi_mesh.hpp>
#include <tilemesh/render/ranks/value_form.hpp>
#include <tilemesh/render/homes_renderer.hpp>
#include <type_traits>
#include <utility>

namespace render_map {

/// The policies of the library's setups by value, with rules at run time: records of degree 0 or 3, which also holds 1 and 2.
template <bool Planes, std::uint32_t Degree, bool Routes = true, bool Blooms = true>
struct RankSetup : tilemesh::splat::Fitted<tilemesh::splat::Lossless, Degree, Routes, Blooms> {
    using Pixel = std::conditional_t<Planes, tilemesh::splat::WithAlpha<tilemesh::splat::WithDepth<tilemesh::splat::FloatPixel>>,
                                     tilemesh::splat::FloatPixel>;
};
using MakeRankRenderer = std::unique_ptr<tilemesh::render::Core>(tilemesh::scene::Map, tilemesh::render::Setup,
                                                      tilemesh::RendererOptions const&, MPI_Comm);
template <bool Planes, std::uint32_t Degree, bool Routes = true, bool Blooms = true>
std::unique_ptr<tilemesh::render::Core> make_on_ranks(tilemesh::scene::Map map, tilemesh::render::Setup facts,
                                           tilemesh::RendererOptions const& options, MPI_Comm comm)
{
    using Setup = tilemesh::splat::Valued<RankSetup<Planes, Degree, Routes, Blooms>>;
    using OnRanks = tilemesh::render::FrameRenderer<tilemesh::splat::PoliciesOf<Setup>, tilemesh::MpiMesh, tilemesh::AnyMachine>;
    tilemesh::MpiMeshOptions engine;
    engine.comm = comm;
    return std::make_unique<OnRanks>(std::move(map), std::move(facts), options, std::move(engine));
}

using MakeRankHomes = std::unique_ptr<tilemesh::render::Core>(tilemesh::scene::Map, tilemesh::render::Setup const&,
                                                   tilemesh::RendererOptions const&, MPI_Comm);
/// The program of homes by value: records of any degree up to `Degree`, and colours in either format.
template <std::uint32_t Degree, class Pixel>
std::unique_ptr<tilemesh::render::Core> make_homes_on_ranks(tilemesh::scene::Map map, tilemesh::render::Setup const& choice,
                                                 tilemesh::RendererOptions const& options, MPI_Comm comm)
{
    using Policies = tilemesh::splat::homes::LensPolicies<Degree, Pixel>;
    tilemesh::MpiMeshOptions engine;
    engine.comm = comm;
    return std::make_unique<tilemesh::render::HomesRenderer<Policies, tilemesh::MpiMesh>>(std::move(map), choice, options, std::move(engine));
}

/// One function for each compiled renderer: by degree 0 or 3, and by planes.
extern MakeRankRenderer &on_ranks_plain, &on_ranks_planes, &on_ranks_shaded, &on_ranks_shaded_planes;
extern MakeRankRenderer &on_ranks_placed, &on_ranks_placed_shaded; ///< without routing
extern MakeRankRenderer& on_ranks_placed_unspread;                 ///< without routing and bloom
extern MakeRankHomes &homes_on_ranks_plain, &homes_on_ranks_any;   ///< degree 0 without planes; degree 3 with both planes

} // namespace render_map
