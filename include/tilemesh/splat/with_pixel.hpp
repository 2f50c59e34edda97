#pragma once
#include <cstdint>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/splat/fitted.hpp>

namespace tilemesh::splat {

namespace detail {
/// Slots of storage that a tile of `Base` must give up for pixels of type P.
template <class Base, class P>
constexpr std::uint32_t slots_for_pixels() noexcept
{
    using Machine = typename Base::Machine;
    constexpr std::uint64_t room = Machine::sram_bytes - Tile<Machine, Frame<Base>>::bytes;
    constexpr std::uint64_t old_bytes = std::uint64_t{sizeof(typename Base::Pixel)} * Base::tile_pixels;
    constexpr std::uint64_t new_bytes = std::uint64_t{sizeof(P)} * Base::tile_pixels;
    constexpr std::uint64_t missing = new_bytes > old_bytes + room ? new_bytes - old_bytes - room : 0;
    return static_cast<std::uint32_t>((missing + slot_bytes<Base>() - 1) / slot_bytes<Base>());
}
} // namespace detail

/// `Base` with other pixels: `WithPixel<Lossless, WithDepth<FloatPixel>>`. Where the SRAM has no room for what they take beyond
/// Base's, storage gives up as many slots as that needs: of the 2,000 of `Lossless` 7 for a depth, 25 for depth and alpha.
template <class Base, class P>
struct WithPixel : Base {
    using Pixel = P;
    static constexpr std::uint32_t storage_slots = Base::storage_slots - detail::slots_for_pixels<Base, P>();
};

} // namespace tilemesh::splat
