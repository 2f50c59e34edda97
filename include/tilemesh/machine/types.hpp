#pragma once
#include <cstdint>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 {
namespace machine {

/// A list of types: the steps of a program, the parameters of a kernel, the regions of a tile.
template <class... Ts>
struct Types {
    static constexpr std::uint32_t count = sizeof...(Ts);
};

/// A type as a value: an argument for generic functions that need a type and no object.
template <class T>
struct Tag {
    using type = T;
};

/// Is T among the types of a list?
template <class T, class List>
inline constexpr bool contains = false;
template <class T, class... L>
inline constexpr bool contains<T, Types<L...>> = (std::is_same_v<T, L> || ...);

/// The place of T in a list of types; 0 if the list does not have it (ask `contains` first).
template <class T, class... L>
constexpr std::uint32_t index_in(Types<L...>) noexcept
{
    std::uint32_t i = 0, found = 0;
    ((found = std::is_same_v<T, L> ? i : found, ++i), ...);
    return found;
}

} // namespace machine

namespace detail {
template <class L, class T>
struct Insert;
template <class... L, class T>
struct Insert<machine::Types<L...>, T> {
    using type = std::conditional_t<machine::contains<T, machine::Types<L...>>, machine::Types<L...>, machine::Types<L..., T>>;
};

/// The concatenation of lists of types.
template <class... Lists>
struct Concat {
    using type = machine::Types<>;
};
template <class... A>
struct Concat<machine::Types<A...>> {
    using type = machine::Types<A...>;
};
template <class... A, class... B, class... Rest>
struct Concat<machine::Types<A...>, machine::Types<B...>, Rest...> : Concat<machine::Types<A..., B...>, Rest...> {};
} // namespace detail

}} // namespace tilemesh
