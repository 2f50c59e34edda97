#pragma once
#include <cstdint>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/splat/frame_program.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The ledger of the anchored program under any setup: regions say their bytes as functions of the setup.
using FrameLedger = SramLedger<Frame<Lossless>>;

/// The SRAM that a tile of the anchored program needs, in bytes. The setup need not fit.
constexpr std::uint64_t frame_bytes(Setup const& s) noexcept
{
    return FrameLedger::bytes(s.machine, s);
}
/// The SRAM of the anchored program with this number of storage slots.
constexpr std::uint64_t frame_bytes(Setup s, std::uint32_t storage) noexcept
{
    s.sizes.storage = storage;
    return frame_bytes(s);
}
/// The SRAM of one slot of storage with its mark, projected record and sort key, as far as these count.
constexpr std::uint32_t slot_bytes(Setup const& s) noexcept
{
    return static_cast<std::uint32_t>(frame_bytes(s, 1) - frame_bytes(s, 0));
}

/// The number of slots in a region of `bytes` bytes. The result is at most the largest capacity that a size can hold.
constexpr std::uint32_t slots_in(std::uint64_t bytes, std::uint32_t slot_bytes) noexcept
{
    auto const slots = bytes / slot_bytes;
    return slots < 0xffffffffu ? static_cast<std::uint32_t>(slots) : 0xfffffffeu;
}

/// Returns the setup with other records, messages or steps in the same bytes of SRAM as `before`. Channels and FIFOs keep their bytes, so
/// their slots follow from the size of a message. Storage keeps its bytes and gets those of the steps that are left out. Example: `lossless`
/// has 2,000 slots of 60-byte records with their lists; with 240-byte records 860 slots, without routing 2,941, without routing and bloom
/// 3,758. A channel whose slots `limit` gives keeps that form.
constexpr Setup refitted(Setup now, Setup const& before) noexcept
{
    Setup left_out = before;
    left_out.routes = now.routes;
    left_out.blooms = now.blooms;
    std::uint64_t const freed = frame_bytes(before, 0) - frame_bytes(left_out, 0);
    auto const resized = [](std::uint32_t slots, std::uint32_t from, std::uint32_t to) {
        return slots == dynamic_capacity ? slots : slots_in(std::uint64_t{slots} * from, to);
    };
    now.sizes.road = resized(before.sizes.road, road_bytes(before), road_bytes(now));
    now.sizes.beam = resized(before.sizes.beam, beam_bytes(before), beam_bytes(now));
    now.sizes.waiting = resized(before.sizes.waiting, road_bytes(before), road_bytes(now));
    now.sizes.storage = slots_in(std::uint64_t{before.sizes.storage} * slot_bytes(before) + freed, slot_bytes(now));
    return now;
}

/// Reduces the setup to what a scene needs, in the same bytes of SRAM: records of another degree, and no routing or bloom if these would
/// have nothing to do. A setup with `one_channel_memory` keeps both routing and bloom: to leave out one of them would free memory that the
/// other one needs. scene/demand.hpp computes what a scene needs.
constexpr Setup fitted(Setup const& setup, std::uint32_t degree, bool routes = true, bool blooms = true) noexcept
{
    Setup now = setup;
    now.sh_degree = degree;
    now.own_record_bytes = 0;
    now.routes = routes;
    now.blooms = blooms;
    return refitted(now, setup);
}

namespace detail {
/// The sizes of a setup whose projected records are of type `Entry`, with records of another degree: channels keep their bytes, and so does storage
/// with the lists of its slots.
template <class Entry>
constexpr Sizes sizes_with(Setup const& setup, std::uint32_t degree) noexcept
{
    constexpr std::uint32_t lists = sizeof(Mark) + sizeof(Entry) + sizeof(SortKey);
    Sizes sizes = fitted(setup, degree).sizes;
    sizes.storage = setup.sizes.storage * (record_bytes(0) + lists) / (record_bytes(degree) + lists);
    return sizes;
}
} // namespace detail

/// Returns the setup `now`, whose pixels differ from those of `before`. If the SRAM has no room for larger ones, storage gives up as many
/// slots as they need.
constexpr Setup with_room_for_pixels(Setup now, Setup const& before) noexcept
{
    std::uint64_t const used = frame_bytes(now), slot = slot_bytes(now);
    std::uint64_t const had = frame_bytes(before), room = before.machine.sram_bytes > had ? before.machine.sram_bytes : had;
    std::uint64_t const missing = used > room ? used - room : 0;
    std::uint64_t const slots = slot == 0 ? 0 : (missing + slot - 1) / slot;
    now.sizes.storage = now.sizes.storage > slots ? now.sizes.storage - static_cast<std::uint32_t>(slots) : 0;
    return now;
}

/// Returns the setup with planes in addition to the colours. If the SRAM has no room for them, storage gives up as many slots as they need:
/// of the 2,000 slots of `lossless`, 7 for a depth, and 25 for depth and alpha.
constexpr Setup with_planes(Setup const& setup, bool depth, bool alpha) noexcept
{
    Setup now = setup;
    now.depth = depth;
    now.alpha = alpha;
    return with_room_for_pixels(now, setup);
}
/// `Base` reduced to what a scene needs (`fitted`), as a type.
template <class Base, std::uint32_t Degree, bool Routes = true, bool Blooms = true>
struct Fitted : Base {
    static_assert((Routes && Blooms) || !Base::sizes.one_channel_memory,
                  "a setup whose routing and bloom share their channels keeps both; fit one that has channels of each kind");
    using Record = GaussianOfDegree<Degree>;
    static constexpr bool routes = Routes;
    static constexpr bool blooms = Blooms;
    static constexpr Sizes sizes = fitted(setup_of<Base>(), Degree, Routes, Blooms).sizes;
};

/// `Base` with other pixels, in the same SRAM (`with_room_for_pixels`). Example: `WithPixel<Lossless, WithDepth<FloatPixel>>`.
template <class Base, class P>
struct WithPixel : Base {
    using Pixel = P;
    static constexpr Sizes sizes = [] {
        Setup now = setup_of<Base>();
        now.colour = colour_format<P>;
        now.depth = P::has_depth;
        now.alpha = P::has_alpha;
        now.own_pixel_bytes = now.colour == ColourFormat::own ? std::uint32_t{sizeof(P)} : 0;
        return with_room_for_pixels(now, setup_of<Base>()).sizes;
    }();
};

}}} // namespace tilemesh::splat
