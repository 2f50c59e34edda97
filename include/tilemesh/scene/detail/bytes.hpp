#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <tilemesh/config.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// The `T` at `bytes`, on a host of any byte order. The caller has checked that its bytes are there.
template <class T, std::endian order = std::endian::little>
T number_at(unsigned char const* bytes)
{
    std::array<unsigned char, sizeof(T)> raw;
    std::copy_n(bytes, sizeof(T), raw.begin());
    if constexpr (order != std::endian::native) std::reverse(raw.begin(), raw.end());
    return __builtin_bit_cast(T, raw);
}

}}} // namespace tilemesh::scene::detail
