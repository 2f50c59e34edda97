#pragma once
#include <tilemesh/machine/run_kernel.hpp>
#include <tilemesh/machine/tile.hpp>

namespace tilemesh { inline namespace v0_2 {

/// The largest number of kinds of operations that a kernel may count.
inline constexpr std::uint32_t most_operation_kinds = 8;

/// The operations of one run of a kernel on one tile, as engines record them. Count i belongs to the i-th name of the kernel's set. 36
/// bytes.
struct OperationCounts {
    std::uint32_t count[most_operation_kinds] = {};
    /// Bytes of messages that arrived and go no further. An exchange from any tile to any tile would move only these. 0 if the kernel does
    /// not count them.
    std::uint32_t settled_bytes = 0;
    constexpr std::uint32_t& operator[](std::uint32_t kind) noexcept { return count[kind]; }
    constexpr std::uint32_t operator[](std::uint32_t kind) const noexcept { return count[kind]; }
};
constexpr bool operator==(OperationCounts const& a, OperationCounts const& b) noexcept
{
    for (std::uint32_t i = 0; i < most_operation_kinds; ++i)
        if (a.count[i] != b.count[i]) return false;
    return a.settled_bytes == b.settled_bytes;
}

namespace detail {
template <class Name, std::uint32_t N>
constexpr std::uint32_t length_of(Name const (&)[N]) noexcept
{
    return N;
}
template <class Set, class = void>
struct KindsOf {
    static constexpr std::uint32_t count = 0;
};
template <class Set>
struct KindsOf<Set, std::void_t<typename Set::Kind, decltype(Set::names)>> {
    static constexpr std::uint32_t count = length_of(Set::names);
};
} // namespace detail

/// The work of one run of a kernel on one tile, in operations that a cost model prices. `Set` belongs to the program and names them:
///   struct Sorting {
///       enum Kind : std::uint32_t { compare, swap };
///       static constexpr char const* names[] = {"compare", "swap"};
///   };
/// A trace carries the names, and a cost model prices operations by name. A name has the same price in every program.
///
/// A kernel for a cost model has a member `static Operations<Sorting> operations(...) noexcept`. Its parameters are any of the kernel's
/// parameters; it takes states by const reference. Engines call it after the kernel and before the exchange, but only if they keep a trace;
/// otherwise it costs nothing. Its result depends only on the tile's words, so it is equal on every engine.
template <class Set>
struct Operations : OperationCounts {
    static_assert(detail::KindsOf<Set>::count != 0, "a set of operations has no names (a trace and the prices of a cost model need them); "
                                              "give it `enum Kind : std::uint32_t {...}` and `static constexpr char const* names[]`");
    static_assert(detail::KindsOf<Set>::count <= most_operation_kinds, "a kernel counts too many kinds of operations (a trace holds "
                                                                 "most_operation_kinds of them); count fewer");
    constexpr std::uint32_t& operator[](typename Set::Kind kind) noexcept { return this->count[kind]; }
    constexpr std::uint32_t operator[](typename Set::Kind kind) const noexcept { return this->count[kind]; }
};

/// The names of a set's operations, in the order of their counts.
struct OperationNames {
    char const* const* begin = nullptr;
    std::uint32_t size = 0;
};

/// a * b, or 2^32 - 1 if the product is larger.
constexpr std::uint32_t times(std::uint32_t a, std::uint32_t b) noexcept
{
    return b != 0 && a > 0xffffffffu / b ? 0xffffffffu : a * b;
}

namespace detail {
template <class F>
struct OperationsSignature {
    static constexpr bool fits = false;
    using Arguments = machine::Types<>;
};
template <class S, class... A>
struct OperationsSignature<Operations<S> (*)(A...) noexcept> {
    static constexpr bool fits = true;
    using Set = S;
    using Arguments = machine::Types<A...>;
};
/// Helps to test whether K has any member called `operations`. If K has one, the name is ambiguous in a class that derives from K and from
/// this class.
struct HasOperations {
    int operations;
};
template <class K>
struct BothOperations : K, HasOperations {};
template <class K, bool Final = std::is_final_v<K>, class = void>
inline constexpr bool names_operations = !Final; // no class can derive from a final class
template <class K>
inline constexpr bool names_operations<K, false, std::void_t<decltype(&BothOperations<K>::operations)>> = false;

template <class K, class = void>
struct OperationsOf {
    static constexpr bool declared = false;
    static_assert(!names_operations<K>,
                  "a kernel's operations is one function (it is overloaded, a template or private); declare it `static Operations<Set> "
                  "operations(...) noexcept`");
};
template <class K>
struct OperationsOf<K, std::void_t<decltype(&K::operations)>> {
    static constexpr bool declared = true;
    using Signature = OperationsSignature<decltype(&K::operations)>;
    static_assert(Signature::fits, "a kernel's operations is `static Operations<Set> operations(...) noexcept` (it counts what a run did, from "
                                   "the tile's words); declare it so");
};

template <class K, class A>
inline constexpr bool known_to = KernelTraits<K>::template takes<A>;
template <class K, class X>
inline constexpr bool known_to<K, X const&> = KernelTraits<K>::template takes<X const&> || KernelTraits<K>::template takes<X&>;
template <class K, class X>
inline constexpr bool known_to<K, X&> = false; // `operations` must not change a state
template <class K, class C>
inline constexpr bool known_to<K, Out<C>> = KernelTraits<K>::template writes<C>;

template <class K, class Source, class... A>
OperationCounts call_operations(Source& source, machine::Types<A...>) noexcept
{
    return K::operations(Bind<A, Source>::make(source)...);
}
} // namespace detail

/// The operations of kernel K in its last run on the tile of `source`; all zero for a kernel without `operations`.
template <class K, class Source>
OperationCounts operations_of([[maybe_unused]] Source& source) noexcept
{
    if constexpr (detail::OperationsOf<K>::declared)
        return detail::call_operations<K>(source, typename detail::OperationsOf<K>::Signature::Arguments{});
    else
        return {};
}

namespace detail {
template <class K, class... A>
constexpr bool operations_fit_kernel(machine::Types<A...>) noexcept
{
    static_assert((known_to<K, A> && ...), "a kernel's operations takes what the kernel does not (it follows from what the kernel may "
                                           "touch; states by const reference); take parameters of the kernel");
    return true;
}
template <class K>
constexpr bool operations_fit_kernel() noexcept
{
    if constexpr (OperationsOf<K>::declared)
        return operations_fit_kernel<K>(typename OperationsOf<K>::Signature::Arguments{});
    else
        return true;
}
} // namespace detail
/// True if the `operations` of the kernels of these steps are correct; otherwise it does not compile. Engines check this on every machine,
/// although only an engine on a Traced machine calls them.
template <class... Step>
constexpr bool operations_fit(machine::Types<Step...>) noexcept
{
    return (detail::operations_fit_kernel<KernelOf<Step>>() && ...);
}

/// The names of the operations that kernel K counts; none for a kernel without `operations`.
template <class K>
constexpr OperationNames operation_names() noexcept
{
    if constexpr (detail::OperationsOf<K>::declared) {
        using Set = typename detail::OperationsOf<K>::Signature::Set;
        return {Set::names, detail::KindsOf<Set>::count};
    } else {
        return {};
    }
}

/// A machine on which engines keep a trace (engine/trace.hpp). In all other respects it is `Machine`. A setup selects it with `using
/// Machine = Traced<Mk2>`. On other machines an engine has no instruction for traces where
/// kernels run.
template <class Machine>
struct Traced : Machine {
    static constexpr bool traced = true;
};
/// Do engines keep a trace on this machine?
template <class Machine, class = void>
inline constexpr bool is_traced = false;
template <class Machine>
inline constexpr bool is_traced<Machine, std::void_t<decltype(Machine::traced)>> = Machine::traced;

}} // namespace tilemesh
