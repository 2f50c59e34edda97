// test: unoptimised test asan tsan
// The codelet file that is given to popc, with the stand-in's registrations for its codelets.
#include "../../examples/on_poplar/codelets.cpp"
#include <standin_vertex.hpp>
#include <tilemesh/engine/contract.hpp>

namespace {
using namespace tilemesh::vertices;
}
POPLAR_STANDIN_VERTEX_NAMED("tilemesh::vertices::Clear", Clear, words);
POPLAR_STANDIN_VERTEX_NAMED("tilemesh::vertices::GatherVotes", GatherVotes, said, any);
POPLAR_STANDIN_VERTEX_NAMED("tilemesh::vertices::CountPass", CountPass, said, log, again, log_at, touched, reads);
POPLAR_STANDIN_VERTEX_NAMED("tilemesh::vertices::BeginStep", BeginStep, log, again, at_most, reads);
POPLAR_STANDIN_VERTEX_NAMED("tilemesh::vertices::BeginLoop", BeginLoop, log, log_at, at_most);
POPLAR_STANDIN_VERTEX_NAMED("tilemesh::vertices::TestLoop", TestLoop, log, again, log_at);
POPLAR_STANDIN_VERTEX_NAMED("tilemesh::vertices::TestFlag", TestFlag, word, again);

#define ENTER(Name) POPLAR_STANDIN_VERTEX(Name, reads, keeps, sends, x, y, width, height, step, log_at, task, program)
ENTER(lossless_project);
ENTER(lossless_route);
ENTER(lossless_bloom);
ENTER(lossless_depth_sort);
ENTER(lossless_composite);
ENTER(paper_project);
ENTER(paper_route);
ENTER(paper_bloom);
ENTER(paper_depth_sort);
ENTER(paper_composite);
ENTER(homes_project);
ENTER(homes_begin);
ENTER(homes_tell);
ENTER(homes_offer);
ENTER(homes_deliver);
ENTER(homes_sort_runs);
ENTER(homes_merge);
ENTER(homes_blend);
ENTER(homes_advance);
ENTER(homes_finish);
ENTER(heat_Diffuse);
