#pragma once
#include "choice.hpp"
#include <memory>

/// One function a compiled family of setups (`renderer_with_policies`), each in a .cpp of its own name.
namespace render_map {

using MakeRenderer = std::unique_ptr<AnyRenderer>(Choice const&, tilemesh::scene::Map const&,
                                                  tilemesh::RendererOptions const&);
MakeRenderer lossless_mk2_threads, lossless_mk2_sequential;
MakeRenderer lossless_test_threads, lossless_test_sequential;
MakeRenderer paper_mk2_threads, paper_mk2_sequential;
MakeRenderer paper_test_threads, paper_test_sequential;
MakeRenderer lossless_planes, paper_planes; ///< either machine, on threads
MakeRenderer shaded_planes;                 ///< lossless, either machine, on threads: harmonics with both planes
MakeRenderer paper_shaded;                  ///< either machine, on threads
MakeRenderer lossless_traced, paper_traced; ///< mk2, on threads; each is an `Instruments`

/// Lossless cut to the demand; empty where it takes all of lossless at degree 0, which is compiled elsewhere.
using FitRenderer = std::unique_ptr<AnyRenderer>(tilemesh::scene::Map const&, tilemesh::scene::Demand const&,
                                                 tilemesh::RendererOptions const&);
FitRenderer fitted_mk2, fitted_test;

} // namespace render_map
