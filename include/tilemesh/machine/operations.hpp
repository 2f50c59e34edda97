#pragma once
#include <tilemesh/machine/tile.hpp>

namespace tilemesh {

/// What a kernel spends its time on, in units that a cost model has cycles for.
enum class Operation : std::uint32_t {
    slot,       ///< a slot of a list or channel end looked at
    projection, ///< a record projected
    routed,     ///< a record taken from a channel, or given to one, on its way
    copied,     ///< a copy taken from a channel, or given to one
    comparison, ///< two keys compared and put in order
    pair,       ///< a Gaussian-pixel pair evaluated
    pixel       ///< a pixel begun and written
};
inline constexpr std::uint32_t operation_kinds = 7;
constexpr std::uint32_t index(Operation o) noexcept
{
    return static_cast<std::uint32_t>(o);
}
constexpr char const* name_of(Operation o) noexcept
{
    constexpr char const* names[operation_kinds] = {"slot", "projection", "routed", "copied", "comparison", "pair", "pixel"};
    return names[index(o)];
}

/// What one run of a kernel on one tile did. A kernel that wants to be modelled says so with
/// `static Operations operations(...) noexcept`, whose parameters are any of the kernel's own (states by const reference): it is
/// called after the kernel, before the exchange, and only where an engine keeps a trace, so that it costs nothing elsewhere. It
/// follows from the tile's words alone: the same on every engine.
struct Operations {
    std::uint32_t count[operation_kinds] = {};
    /// Of messages that had arrived and go no further: what an exchange from any tile to any tile would have brought. 0 where a
    /// kernel does not say.
    std::uint32_t settled_bytes = 0;
    constexpr std::uint32_t& operator[](Operation o) noexcept { return count[index(o)]; }
    constexpr std::uint32_t operator[](Operation o) const noexcept { return count[index(o)]; }
};
constexpr bool operator==(Operations const& a, Operations const& b) noexcept
{
    for (std::uint32_t i = 0; i < operation_kinds; ++i)
        if (a.count[i] != b.count[i]) return false;
    return a.settled_bytes == b.settled_bytes;
}

/// a * b, or what 32 bits hold at most.
constexpr std::uint32_t times(std::uint32_t a, std::uint32_t b) noexcept
{
    return b != 0 && a > 0xffffffffu / b ? 0xffffffffu : a * b;
}

namespace detail {
template <class F>
struct OperationsSignature {
    static constexpr bool fits = false;
    using Arguments = Types<>;
};
template <class... A>
struct OperationsSignature<Operations (*)(A...) noexcept> {
    static constexpr bool fits = true;
    using Arguments = Types<A...>;
};
template <class K, class = void>
struct OperationsOf {
    static constexpr bool declared = false;
};
template <class K>
struct OperationsOf<K, std::void_t<decltype(&K::operations)>> {
    static constexpr bool declared = true;
    using Signature = OperationsSignature<decltype(&K::operations)>;
    static_assert(Signature::fits, "a kernel's operations is `static Operations operations(...) noexcept` (it counts what a run did, from "
                                   "the tile's words); declare it so");
};

template <class K, class A>
inline constexpr bool known_to = KernelTraits<K>::template takes<A>;
template <class K, class X>
inline constexpr bool known_to<K, X const&> = KernelTraits<K>::template takes<X const&> || KernelTraits<K>::template takes<X&>;
template <class K, class X>
inline constexpr bool known_to<K, X&> = false; // it looks, it does not change
template <class K, class C>
inline constexpr bool known_to<K, Out<C>> = KernelTraits<K>::template writes<C>;

template <class K, class Source, class... A>
Operations call_operations(Source& source, Types<A...>) noexcept
{
    static_assert((known_to<K, A> && ...), "a kernel's operations takes what the kernel does not (it follows from what the kernel may "
                                           "touch; states by const reference); take parameters of the kernel");
    return K::operations(Bind<A, Source>::make(source)...);
}
} // namespace detail

/// What the run of kernel K that has just ended on the tile of `source` did; nothing for a kernel that does not say.
template <class K, class Source>
Operations operations_of([[maybe_unused]] Source& source) noexcept
{
    if constexpr (detail::OperationsOf<K>::declared)
        return detail::call_operations<K>(source, typename detail::OperationsOf<K>::Signature::Arguments{});
    else
        return {};
}

/// A machine on which engines keep a trace (engine/trace.hpp): `Machine` in all else. A setup asks for it with
/// `using Machine = Traced<Mk2>`; without it an engine has neither a byte nor an instruction of it.
template <class Machine>
struct Traced : Machine {
    static constexpr bool traced = true;
};
namespace detail {
template <class Machine, class = void>
inline constexpr bool is_traced = false;
template <class Machine>
inline constexpr bool is_traced<Machine, std::void_t<decltype(Machine::traced)>> = Machine::traced;
} // namespace detail

} // namespace tilemesh
