// The kernels of one setup's frame program and nothing else: -DSETUP=minimal, a name of setups.hpp. With -DBESIDE=everything those of
// a second setup stand in the same unit.
#include "setups.hpp"
#include <tilemesh/splat/frame_program.hpp>
#include <tuple>

namespace leave_out {
template <class Step>
struct KernelOf;
template <class Kernel>
struct KernelOf<tilemesh::Superstep<Kernel>> {
    using type = Kernel;
};
template <class Kernel>
struct KernelOf<tilemesh::UntilQuiet<Kernel>> {
    using type = Kernel;
};

/// Instantiates every kernel of a program: a call through its address could come from anywhere.
template <class Program>
struct Emit;
template <class... Steps>
struct Emit<tilemesh::Sequence<Steps...>> {
    static auto kernels() noexcept { return std::tuple{&KernelOf<Steps>::type::operator()...}; }
};

template struct Emit<Frame<SETUP>>;
#ifdef BESIDE
template struct Emit<Frame<BESIDE>>;
#endif
} // namespace leave_out
