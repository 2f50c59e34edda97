// The kernels of one setup's frame program and nothing else: -DSETUP=minimal, a name of setups.hpp. With -DBESIDE=everything those of
// a second setup stand in the same unit.
#include "setups.hpp"
#include <tilemesh/splat/frame_program.hpp>
#include <tuple>

namespace leave_out {
/// Instantiates every kernel of a program: a call through its address could come from anywhere.
template <class Steps>
struct Emit;
template <class... Step>
struct Emit<tilemesh::machine::Types<Step...>> {
    static auto kernels() noexcept { return std::tuple{&tilemesh::KernelOf<Step>::operator()...}; }
};

template struct Emit<tilemesh::StepsOf<Frame<SETUP>>>;
#ifdef BESIDE
template struct Emit<tilemesh::StepsOf<Frame<BESIDE>>>;
#endif
} // namespace leave_out
