// test: unoptimised test asan tsan
// The codelet file that is given to popc, and its codelets made known to the stand-in.
#include "../../examples/on_poplar/codelets.cpp"
#include "standin/standin.hpp"
#include <tilemesh/engine/contract.hpp>

namespace {
namespace vertices = tilemesh::vertices;
standin::Vertices<vertices::Clear, vertices::GatherVotes, vertices::CountPass, vertices::BeginStep, vertices::BeginLoop, vertices::TestLoop,
                  vertices::TestFlag> const control;
standin::Vertices<lossless_project, lossless_route, lossless_bloom, lossless_depth_sort, lossless_composite> const lossless;
standin::Vertices<paper_project, paper_route, paper_bloom, paper_depth_sort, paper_composite> const paper;
standin::Vertices<homes_project, homes_begin, homes_tell, homes_offer, homes_deliver, homes_sort_runs, homes_merge, homes_blend, homes_advance,
                  homes_finish> const of_homes;
standin::Vertices<heat_Diffuse> const heat;
} // namespace
