#pragma once
#include <cstdint>
#include <tilemesh/splat/frame_program.hpp>

namespace tilemesh::splat {

/// SRAM of a tile that a setup needs for routing, and for bloom: what it frees without.
template <class S>
constexpr std::uint32_t routing_bytes() noexcept
{
    return 8 * 4 * Road<S>::Receiver::words(Road<S>::static_capacity) +
           (S::Saturation::holds ? 2 * 4 * Waiting<S, 0>::words(Waiting<S, 0>::static_capacity) : 0u) +
           static_cast<std::uint32_t>(sizeof(Traffic));
}
template <class S>
constexpr std::uint32_t bloom_bytes() noexcept
{
    return 8 * 4 * Beam<S>::Receiver::words(Beam<S>::static_capacity) + static_cast<std::uint32_t>(sizeof(Debts));
}

/// `Base` cut to what a scene needs: harmonics up to `Degree`, and routing and bloom only where they have something to do
/// (scene/demand.hpp finds out). The bytes of the channels stay as they are, so their slots follow from the record's size. Storage
/// has the bytes of Base's and those that routing and bloom would have taken: of `Lossless` 2,000 slots of 60 bytes and their
/// lists, 860 of 240 bytes, 2,941 without routing, 3,758 without either.
template <class Base, std::uint32_t Degree, bool Routes = true, bool Blooms = true>
struct Fitted : Base {
    static_assert((Routes && Blooms) || !Base::one_channel_memory,
                  "a setup whose routing and bloom share their channels keeps both; fit one that has channels of each kind");
    using Record = GaussianOfDegree<Degree>;
    static constexpr bool routes = Routes;
    static constexpr bool blooms = Blooms;

private:
    struct Slot : Base {
        using Record = GaussianOfDegree<Degree>;
        static constexpr bool routes = Routes;
        static constexpr bool blooms = Blooms;
    };

public:
    static constexpr std::uint32_t storage_slots =
        (Base::storage_slots * detail::slot_bytes<Base>() + (Routes ? 0 : routing_bytes<Base>()) +
         (Blooms ? 0 : bloom_bytes<Base>())) /
        detail::slot_bytes<Slot>();
};

} // namespace tilemesh::splat
