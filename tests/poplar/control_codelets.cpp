// test: unoptimised test asan tsan
#include "../engine/control.hpp"
#include "on_poplar.hpp"
#include <standin_vertex.hpp>
#include <tilemesh/poplar/codelet.hpp>

// Codelets of the programs that control.cpp and ledger.cpp run.
using namespace engine_test;
using tilemesh::detail::BeginReduce;
using tilemesh::detail::GoOnReducing;

namespace {
constexpr auto to_all = ReduceTo::all;
} // namespace
using Nested = NestedDraining;

TILEMESH_VERTEX(nested_OpenTap, Mk2, Nested, OpenTap)
TILEMESH_VERTEX(nested_Drain, Mk2, Nested, Drain)
TILEMESH_VERTEX(nested_Refill, Mk2, Nested, Refill)
TILEMESH_VERTEX(warm_Warm, Mk2, Warming, Warm)
TILEMESH_VERTEX(warm_Spread, Mk2, Warming, Spread)
TILEMESH_VERTEX(warm_Cool, Mk2, Warming, Cool)
TILEMESH_VERTEX(warm_most_change_of_all_begin, Mk2, Warming, BeginReduce<Change, Most, to_all>)
TILEMESH_VERTEX(warm_most_change_of_all, Mk2, Warming, GoOnReducing<Change, Most, to_all>)
TILEMESH_VERTEX(warm_Judge, Mk2, Warming, Judge)
TILEMESH_VERTEX(warm_Forget, Mk2, Warming, Forget)

#define ENTER(Name) POPLAR_STANDIN_VERTEX(Name, reads, keeps, sends, x, y, width, height, step, log_at, task, program)
ENTER(nested_OpenTap);
ENTER(nested_Drain);
ENTER(nested_Refill);
ENTER(warm_Warm);
ENTER(warm_Spread);
ENTER(warm_Cool);
ENTER(warm_most_change_of_all_begin);
ENTER(warm_most_change_of_all);
ENTER(warm_Judge);
ENTER(warm_Forget);
