#pragma once
#include <cstdint>
#include <tilemesh/config.hpp>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 { namespace machine {

/// An item of a list that has one of two forms in a run: `W`, or the shorter `N`. So one program serves both forms. Only a host has such
/// lists: a tile's ledger and codelets have the type of the form.
///
/// The items follow one another in the form in use (`MeshSizes::wide`), so the words of the list are those of a `Buffer<W>` or a
/// `Buffer<N>`. The list's own iterators and operators assume the wide form: reach the items through `in_form`.
template <class W, class N>
struct Either {
    using Wide = W;
    using Narrow = N;
    static_assert(sizeof(W) % 4 == 0 && sizeof(N) % 4 == 0 && sizeof(N) <= sizeof(W), "whole words, and the narrow form is not longer");
    std::uint32_t words[sizeof(W) / 4];
};

/// Has an item of type T two forms?
template <class T, class = void>
inline constexpr bool is_either = false;
template <class T>
inline constexpr bool is_either<T, std::void_t<typename T::Wide, typename T::Narrow>> = true;

/// Do the parameters of a program say which form a run has, in a word `wide`?
template <class Parameters, class = void>
inline constexpr bool has_form_word = false;
template <class Parameters>
inline constexpr bool has_form_word<Parameters, std::void_t<decltype(Parameters::wide)>> = true;

/// Does this run have the wide form? Lists of programs without that word have one form only.
template <class Parameters>
TILEMESH_KERNEL bool is_wide([[maybe_unused]] Parameters const& parameters) noexcept
{
    if constexpr (has_form_word<Parameters>)
        return parameters.wide != 0;
    else
        return true;
}

/// Calls f with the items in the form in use, and returns its result. Kernels ask once for a list, not for each item.
template <class T, class F>
TILEMESH_KERNEL decltype(auto) in_form([[maybe_unused]] bool wide, T* items, F const& f)
{
    if constexpr (is_either<T>) {
        using Wide = std::conditional_t<std::is_const_v<T>, typename T::Wide const, typename T::Wide>;
        using Narrow = std::conditional_t<std::is_const_v<T>, typename T::Narrow const, typename T::Narrow>;
        return wide ? f(reinterpret_cast<Wide*>(items)) : f(reinterpret_cast<Narrow*>(items));
    } else {
        return f(items);
    }
}

/// The words of an item of type T in the form in use.
template <class T>
constexpr std::uint32_t words_in_form([[maybe_unused]] bool wide) noexcept
{
    if constexpr (is_either<T>)
        return static_cast<std::uint32_t>(wide ? sizeof(typename T::Wide) : sizeof(typename T::Narrow)) / 4;
    else
        return sizeof(T) / 4;
}

}}} // namespace tilemesh::machine
