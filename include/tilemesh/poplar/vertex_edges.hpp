#pragma once
#include <cstdint>
#include <tilemesh/machine/kernel.hpp>
#include <type_traits>

/// The edges of a kernel's vertex and their order, on which a codelet, its graph and its ledger agree. Kernel code; experimental until an
/// SDK has compiled it.
namespace tilemesh { inline namespace v0_2 { namespace on_poplar {

namespace detail {
/// The number of edges that argument A of Kernel takes in each list.
template <class Kernel, class A>
struct EdgesOf {
    static constexpr std::uint32_t reads = 0, keeps = 0;
};
template <class Kernel, class X>
struct EdgesOf<Kernel, X const&> {
    static constexpr std::uint32_t reads = KernelTraits<Kernel>::template takes<X&> ? 0 : 1, keeps = 0;
};
template <class Kernel, class X>
struct EdgesOf<Kernel, X&> {
    static constexpr std::uint32_t reads = 0, keeps = 1;
};
template <class Kernel, class C>
struct EdgesOf<Kernel, In<C>> {
    static constexpr std::uint32_t reads = ends_in<C>, keeps = 0;
};
template <class Kernel, class C>
struct EdgesOf<Kernel, Out<C>> {
    static constexpr std::uint32_t reads = KernelTraits<Kernel>::template reads<C> ? 0 : ends_in<C>, keeps = 0;
};
template <class Kernel, class P>
struct EdgesOf<Kernel, Broadcast<P>> {
    static constexpr std::uint32_t reads = 1, keeps = 0;
};

/// The place at which the edges of argument A begin in `reads` and in `keeps`; `sends_at`: those of channel C in `sends`.
template <class Kernel, class A, class... Args>
constexpr std::uint32_t reads_at(machine::Types<Args...>) noexcept
{
    std::uint32_t at = 1;
    bool found = false;
    ((found = found || std::is_same_v<A, Args>, at += found ? 0 : EdgesOf<Kernel, Args>::reads), ...);
    return at;
}
template <class Kernel, class A, class... Args>
constexpr std::uint32_t keeps_at(machine::Types<Args...>) noexcept
{
    std::uint32_t at = 1;
    bool found = false;
    ((found = found || std::is_same_v<A, Args>, at += found ? 0 : EdgesOf<Kernel, Args>::keeps), ...);
    return at;
}
template <class Kernel, class C, bool Sampled, class... L>
constexpr std::uint32_t sends_at(machine::Types<L...>) noexcept
{
    std::uint32_t at = Sampled ? 2 : 1;
    bool found = false;
    ((found = found || std::is_same_v<C, L>, at += !found && KernelTraits<Kernel>::template writes<L> ? ends_out<L> : 0), ...);
    return at;
}
} // namespace detail

}}} // namespace tilemesh::on_poplar
