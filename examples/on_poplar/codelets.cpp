// The input of popc, the codelet compiler: the supersteps of the frame program for two setups, of the program of homes, and of the heat
// equation. A setup or program of your own needs lines like these.
//   popc -O3 -DNDEBUG -I include -I examples examples/on_poplar/codelets.cpp -o codelets.gp
#include "../heat/heat.hpp"
#include <tilemesh/poplar/codelet.hpp>
#include <tilemesh/splat/frame_program.hpp>
#include <tilemesh/splat/homes/program.hpp>

namespace splat = tilemesh::splat;
namespace homes = tilemesh::splat::homes;
using splat::Lossless, splat::Paper, tilemesh::Mk2;
using ByValue = homes::ValuePolicies<>;

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

TILEMESH_MULTI_VERTEX(homes_project, Mk2, homes::Frame<ByValue>, homes::Project<ByValue>)
TILEMESH_VERTEX(homes_begin, Mk2, homes::Frame<ByValue>, homes::Begin<ByValue>)
TILEMESH_VERTEX(homes_tell, Mk2, homes::Frame<ByValue>, homes::Tell<ByValue>)
TILEMESH_MULTI_VERTEX(homes_offer, Mk2, homes::Frame<ByValue>, homes::Offer<ByValue>)
TILEMESH_VERTEX(homes_deliver, Mk2, homes::Frame<ByValue>, homes::Deliver<ByValue>)
TILEMESH_MULTI_VERTEX(homes_sort_runs, Mk2, homes::Frame<ByValue>, homes::SortRuns<ByValue>)
TILEMESH_VERTEX(homes_merge, Mk2, homes::Frame<ByValue>, homes::Merge<ByValue>)
TILEMESH_MULTI_VERTEX(homes_blend, Mk2, homes::Frame<ByValue>, homes::Blend<ByValue>)
TILEMESH_VERTEX(homes_advance, Mk2, homes::Frame<ByValue>, homes::Advance<ByValue>)
TILEMESH_MULTI_VERTEX(homes_finish, Mk2, homes::Frame<ByValue>, homes::Finish<ByValue>)

TILEMESH_VERTEX(heat_Diffuse, Mk2, tilemesh::Repeat<Diffuse>, Diffuse)
