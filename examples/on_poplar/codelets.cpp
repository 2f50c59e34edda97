// The input of popc, the codelet compiler: the supersteps of the frame program for two setups, and of the heat equation. A setup or program
// of your own needs lines like these.
//   popc -O3 -DNDEBUG -I include -I examples examples/on_poplar/codelets.cpp -o codelets.gp
#include "../heat/heat.hpp"
#include <tilemesh/poplar/codelet.hpp>
#include <tilemesh/splat/frame_program.hpp>

namespace splat = tilemesh::splat;
using splat::Lossless, splat::Paper, tilemesh::Mk2;

TILEMESH_VERTEX(lossless_project, Mk2, splat::Frame<Lossless>, splat::Project<Lossless>)
TILEMESH_VERTEX(lossless_route, Mk2, splat::Frame<Lossless>, splat::Route<Lossless>)
TILEMESH_VERTEX(lossless_bloom, Mk2, splat::Frame<Lossless>, splat::Bloom<Lossless>)
TILEMESH_VERTEX(lossless_depth_sort, Mk2, splat::Frame<Lossless>, splat::DepthSort<Lossless>)
TILEMESH_MULTI_VERTEX(lossless_composite, Mk2, splat::Frame<Lossless>, splat::Composite<Lossless>)

TILEMESH_VERTEX(paper_project, Mk2, splat::Frame<Paper>, splat::Project<Paper>)
TILEMESH_VERTEX(paper_route, Mk2, splat::Frame<Paper>, splat::Route<Paper>)
TILEMESH_VERTEX(paper_bloom, Mk2, splat::Frame<Paper>, splat::Bloom<Paper>)
TILEMESH_VERTEX(paper_depth_sort, Mk2, splat::Frame<Paper>, splat::DepthSort<Paper>)
TILEMESH_MULTI_VERTEX(paper_composite, Mk2, splat::Frame<Paper>, splat::Composite<Paper>)

TILEMESH_VERTEX(heat_Diffuse, Mk2, tilemesh::Repeat<Diffuse>, Diffuse)
