#pragma once
#include <cstdint>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/splat/frame_program.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The bytes of one record, message and pixel on the machine. They are the same if a host moves references instead of values.
struct FrameWords {
    std::uint32_t record, road_message, beam_message, pixel;
    std::uint32_t slot_lists; ///< mark, projected record and sort key of one storage slot; 0 if these do not count against the SRAM

    constexpr std::uint32_t slot() const noexcept { return record + slot_lists; }
};
constexpr std::uint32_t slot_list_bytes(bool lists_fit, std::uint32_t mark_bytes) noexcept
{
    return lists_fit ? mark_bytes + static_cast<std::uint32_t>(sizeof(Splat) + sizeof(SortKey)) : 0;
}
template <class S>
constexpr FrameWords frame_words() noexcept
{
    using P = PoliciesOf<S>;
    return {sizeof(typename P::Record), wire_bytes<RoadMessage<P>>, wire_bytes<BeamMessage<P>>, sizeof(typename P::Pixel),
            slot_list_bytes(S::sizes.lists_fit, sizeof(MarkOf<P>))};
}

/// The number of slots in a region of `bytes` bytes. The result is at most the largest capacity that a size can hold.
constexpr std::uint32_t slots_in(std::uint64_t bytes, std::uint32_t slot_bytes) noexcept
{
    auto const slots = bytes / slot_bytes;
    return slots < 0xffffffffu ? static_cast<std::uint32_t>(slots) : 0xfffffffeu;
}

/// The SRAM of a tile that routing takes (`bloom_bytes`: that bloom takes). A setup without the step frees it. If `limit` gives the slots
/// of a channel, only the channel's heads count.
constexpr std::uint64_t routing_bytes(Sizes const& sizes, FrameWords const& words, bool holds) noexcept
{
    std::uint64_t const road = sizes.road == dynamic_capacity ? 0 : sizes.road;
    return 8 * (8 + road * words.road_message) + (holds ? 2 * (8 + std::uint64_t{sizes.waiting} * words.road_message) : 0) +
           sizeof(FlowControl);
}
constexpr std::uint64_t bloom_bytes(Sizes const& sizes, FrameWords const& words) noexcept
{
    std::uint64_t const beam = sizes.beam == dynamic_capacity ? 0 : sizes.beam;
    return 8 * (8 + beam * words.beam_message) + sizeof(OwedCopies);
}

/// Returns the sizes for other words in the same bytes of SRAM. Channels and FIFOs keep their bytes, so their slots follow from the size of
/// a message. Storage keeps its bytes and gets the `freed` ones. Example: `Lossless` has 2,000 slots of 60-byte records with their lists;
/// with 240-byte records 860 slots, without routing 2,941, without routing and bloom 3,758. A channel whose slots `limit` gives keeps that
/// form.
constexpr Sizes refitted(Sizes sizes, FrameWords const& before, FrameWords const& now, std::uint64_t freed = 0) noexcept
{
    if (sizes.road != dynamic_capacity) sizes.road = slots_in(std::uint64_t{sizes.road} * before.road_message, now.road_message);
    if (sizes.beam != dynamic_capacity) sizes.beam = slots_in(std::uint64_t{sizes.beam} * before.beam_message, now.beam_message);
    sizes.waiting = slots_in(std::uint64_t{sizes.waiting} * before.road_message, now.road_message);
    sizes.storage = slots_in(std::uint64_t{sizes.storage} * before.slot() + freed, now.slot());
    return sizes;
}

/// Returns the sizes for pixels of `pixel` bytes instead of those of `words`. `room`: free bytes of SRAM. If larger pixels need more than
/// `room`, storage gives up as many slots as they need: of the 2,000 slots of `Lossless`, 7 for a depth, and 25 for depth and alpha.
constexpr Sizes with_pixels_of(Sizes sizes, FrameWords const& words, std::uint32_t pixel, std::uint64_t room) noexcept
{
    std::uint64_t const before = std::uint64_t{words.pixel} * sizes.tile_pixels;
    std::uint64_t const after = std::uint64_t{pixel} * sizes.tile_pixels;
    std::uint64_t const missing = after > before + room ? after - before - room : 0;
    auto const slots = static_cast<std::uint32_t>((missing + words.slot() - 1) / words.slot());
    sizes.storage = sizes.storage > slots ? sizes.storage - slots : 0;
    return sizes;
}

/// `Base` reduced to what a scene needs, in the same bytes (`refitted`): harmonics up to `Degree`, and routing and bloom only if the scene
/// needs them. scene/demand.hpp computes what a scene needs.
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
    static constexpr std::uint64_t freed =
        (Base::routes && !Routes ? routing_bytes(Base::sizes, frame_words<Base>(), Base::Saturation::holds) : 0) +
        (Base::blooms && !Blooms ? bloom_bytes(Base::sizes, frame_words<Base>()) : 0);

public:
    static constexpr Sizes sizes = refitted(Base::sizes, frame_words<Base>(), frame_words<Slot>(), freed);
};

/// `Base` with other pixels, in the same SRAM (`with_pixels_of`). Example: `WithPixel<Lossless, WithDepth<FloatPixel>>`.
template <class Base, class P>
struct WithPixel : Base {
    using Pixel = P;
    static constexpr Sizes sizes =
        with_pixels_of(Base::sizes, frame_words<Base>(), sizeof(P),
                       Base::Machine::sram_bytes - Tile<typename Base::Machine, Frame<Base>, Base>::bytes);
};

}}} // namespace tilemesh::splat
