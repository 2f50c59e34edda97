#pragma once
#include <cstdint>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/splat/frame_program.hpp>

namespace tilemesh::splat {

/// Bytes on a tile of what the sizes of a frame count: records and messages as they are on the machine, whatever a host moves.
struct FrameWords {
    std::uint32_t record, road_message, beam_message, pixel; ///< bytes of one
    std::uint32_t slot; ///< of storage, with its mark, projected record and sort key where these count
};
template <class S>
constexpr FrameWords frame_words() noexcept
{
    using P = PoliciesOf<S>;
    return {sizeof(typename P::Record), wire_bytes<RoadMessage<P>>, wire_bytes<BeamMessage<P>>, sizeof(typename P::Pixel),
            static_cast<std::uint32_t>(sizeof(typename P::Record) +
                                       (S::sizes.lists_fit ? sizeof(MarkOf<P>) + sizeof(typename P::Projected) + sizeof(SortKey) : 0))};
}

namespace detail {
/// SRAM of a tile that routing takes under a setup, and bloom: what it frees without.
template <class S>
constexpr std::uint32_t routing_bytes() noexcept
{
    return 8 * 4 * Road<S>::Receiver::words(S::sizes.road) +
           (S::Saturation::holds ? 2 * 4 * Waiting<S, 0>::words(S::sizes.waiting) : 0u) + static_cast<std::uint32_t>(sizeof(Traffic));
}
template <class S>
constexpr std::uint32_t bloom_bytes() noexcept
{
    return 8 * 4 * Beam<S>::Receiver::words(S::sizes.beam) + static_cast<std::uint32_t>(sizeof(Debts));
}
} // namespace detail

/// The sizes of `From` for a setup `To` of other records, messages or parts, in the same bytes of SRAM: channels and FIFOs keep their bytes,
/// so their slots follow from the size of a message. Storage has the bytes of From's, and those that routing and bloom leave where
/// To goes without: of `Lossless` 2,000 slots of 60 bytes and their lists, 860 of 240 bytes, 2,941 without routing, 3,758 without
/// either.
template <class From, class To>
constexpr Sizes refitted_sizes() noexcept
{
    constexpr auto old = frame_words<From>(), now = frame_words<To>();
    Sizes sizes = From::sizes;
    sizes.road = slots_in(sizes.road * old.road_message, now.road_message);
    sizes.beam = slots_in(sizes.beam * old.beam_message, now.beam_message);
    sizes.waiting = slots_in(sizes.waiting * old.road_message, now.road_message);
    sizes.storage = slots_in(From::sizes.storage * old.slot + (From::routes && !To::routes ? detail::routing_bytes<From>() : 0) +
                                 (From::blooms && !To::blooms ? detail::bloom_bytes<From>() : 0),
                             now.slot);
    return sizes;
}

/// The sizes of `S` where its pixels become `bytes` large each. Where the SRAM has no room for what they take beyond S's, storage gives
/// up as many slots as that needs: of the 2,000 of `Lossless` 7 for a depth, 25 for depth and alpha.
template <class S>
constexpr Sizes sizes_for_pixels(std::uint32_t bytes) noexcept
{
    Sizes sizes = S::sizes;
    std::uint64_t const room = S::Machine::sram_bytes - Tile<typename S::Machine, Frame<S>, S>::bytes;
    std::uint64_t const before = std::uint64_t{sizeof(typename S::Pixel)} * sizes.tile_pixels;
    std::uint64_t const after = std::uint64_t{bytes} * sizes.tile_pixels;
    std::uint64_t const missing = after > before + room ? after - before - room : 0;
    auto const slot = frame_words<S>().slot;
    sizes.storage -= static_cast<std::uint32_t>((missing + slot - 1) / slot);
    return sizes;
}

/// `Base` cut to what a scene needs: harmonics up to `Degree`, and routing and bloom only where they have something to do
/// (scene/demand.hpp finds out), in Base's bytes (`refitted_sizes`).
template <class Base, std::uint32_t Degree, bool Routes = true, bool Blooms = true>
struct Fitted : Base {
    static_assert((Routes && Blooms) || !Base::sizes.one_channel_memory,
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
    static constexpr Sizes sizes = refitted_sizes<Base, Slot>();
};

/// `Base` with other pixels: `WithPixel<Lossless, WithDepth<FloatPixel>>`, in the same SRAM (`sizes_for_pixels`).
template <class Base, class P>
struct WithPixel : Base {
    using Pixel = P;
    static constexpr Sizes sizes = sizes_for_pixels<Base>(sizeof(P));
};

} // namespace tilemesh::splat
