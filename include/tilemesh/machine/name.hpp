#pragma once
#include <cstdint>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 {

namespace machine {
/// A piece of a string literal: the name of a region, channel or kernel in reports. It costs nothing on a tile.
struct Name {
    char const* text;
    std::uint32_t size;
};
} // namespace machine

/// A null-terminated text as a Name.
constexpr machine::Name as_name(char const* text) noexcept
{
    std::uint32_t size = 0;
    while (text[size] != '\0') ++size;
    return {text, size};
}

namespace detail {
template <class X, class = void>
inline constexpr bool has_own_name = false;
template <class X>
inline constexpr bool has_own_name<X, std::void_t<decltype(X::name)>> = true;

/// Finds "ns::Outer<A>::Inner" in the compiler's text for this function. The result is only the last component, without arguments.
template <class X>
constexpr machine::Name type_name() noexcept
{
    char const* const text = __PRETTY_FUNCTION__; // "... [with X = T; ...]" (GCC) or "... [X = T]" (Clang)
    std::uint32_t from = 0;
    while (!(text[from] == 'X' && text[from + 1] == ' ' && text[from + 2] == '=')) ++from;
    from += 4;
    std::uint32_t begin = from, end = 0, depth = 0;
    for (std::uint32_t to = from; text[to] != '\0'; ++to) {
        char const c = text[to];
        bool const last = depth == 0 && (c == ';' || c == ']');
        if (end == 0 && depth == 0 && (c == '<' || last)) end = to;
        if (last) break;
        if (depth == 0 && c == ':') begin = to + 1, end = 0;
        if (c == '<') ++depth;
        if (c == '>') --depth;
    }
    return {text + begin, end - begin};
}
} // namespace detail

/// X's own `static constexpr char const* name`, or the name of the type.
template <class X>
constexpr machine::Name name_of() noexcept
{
    if constexpr (detail::has_own_name<X>)
        return as_name(X::name);
    else
        return detail::type_name<X>();
}

}} // namespace tilemesh
