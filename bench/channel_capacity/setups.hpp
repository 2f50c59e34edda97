#pragma once
#include <cstdint>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/splat/frame_program.hpp>
#include <tilemesh/splat/setup_types.hpp>

namespace channel_capacity {

namespace splat = tilemesh::splat;

/// The preset `lossless` on Mk2, with back-pressure.
struct Held : splat::Lossless {
    static constexpr char const* name = "lossless, hold";
    static constexpr splat::Arithmetic arithmetic = splat::Arithmetic::precise; // because pictures are compared with the naive picture
};
/// The same setup with the paper's saturation policy. It has no FIFOs, so its bytes give more slots.
struct Dropped : Held {
    static constexpr char const* name = "lossless, drop";
    using Saturation = splat::Drop;
};

/// A number of slots that nothing is known to fill: a cold start of 250,000 records puts fewer messages into one channel.
inline constexpr std::uint32_t most_slots = 8192;

/// The split of the SRAM of one tile of `S`. Every channel end (road and beam) has c slots; under `Hold` each of the two FIFOs has c slots
/// too; the rest is storage. The bytes per slot, and the bytes that depend on neither, come from the tile's ledger.
template <class S>
struct Budget {
    using Ledger = tilemesh::SramLedger<splat::Frame<S>>;
    static constexpr tilemesh::MachineSize machine = tilemesh::size_of_machine<typename S::Machine>();

    static constexpr splat::Sizes split(std::uint32_t channel, std::uint32_t storage) noexcept
    {
        auto sizes = S::sizes;
        sizes.storage = storage;
        sizes.road = sizes.beam = channel;
        sizes.waiting = S::Saturation::holds ? channel : 0;
        return sizes;
    }
    /// The bytes of a tile with this split.
    static constexpr std::uint64_t bytes(std::uint32_t channel, std::uint32_t storage) noexcept
    {
        return Ledger::bytes(machine, split(channel, storage));
    }
    static constexpr std::uint64_t fixed_bytes = bytes(0, 0);
    /// Eight ends of the road and of the beam, and one slot of each of two FIFOs.
    static constexpr std::uint64_t channel_slot_bytes = bytes(1, 0) - fixed_bytes;
    /// A stored record with its mark, its projection and its sort key.
    static constexpr std::uint64_t storage_slot_bytes = bytes(0, 1) - fixed_bytes;

    /// The slots of storage if every channel has c slots; 0 if the channels alone do not fit.
    static constexpr std::uint32_t storage_slots(std::uint32_t c) noexcept
    {
        auto const channels = fixed_bytes + c * channel_slot_bytes;
        return channels > machine.sram_bytes ? 0 : static_cast<std::uint32_t>((machine.sram_bytes - channels) / storage_slot_bytes);
    }
    /// The largest number of slots for a channel if at least one record can be stored.
    static constexpr std::uint32_t most_channel_slots =
        static_cast<std::uint32_t>((machine.sram_bytes - fixed_bytes - storage_slot_bytes) / channel_slot_bytes);

    /// Checks the arithmetic against the ledger: storage_slots(c) slots fit, one more does not.
    static constexpr bool is_exact(std::uint32_t c) noexcept
    {
        auto const s = storage_slots(c);
        return s >= 1 && bytes(c, s) <= machine.sram_bytes && bytes(c, s + 1) > machine.sram_bytes;
    }
};

static_assert(Budget<Held>::is_exact(1) && Budget<Held>::is_exact(200) && Budget<Held>::is_exact(Budget<Held>::most_channel_slots));
static_assert(Budget<Dropped>::is_exact(1) && Budget<Dropped>::is_exact(200) &&
              Budget<Dropped>::is_exact(Budget<Dropped>::most_channel_slots));
static_assert(Budget<Held>::storage_slots(Budget<Held>::most_channel_slots + 1) == 0, "there the channels leave no record");
/// `lossless` itself has 200 slots a channel and 2,000 of storage, and leaves some bytes free.
static_assert(Held::sizes.road == 200 && Held::sizes.beam == 200 && Held::sizes.waiting == 200 &&
              Budget<Held>::storage_slots(200) ==
                  Held::sizes.storage + (Budget<Held>::machine.sram_bytes - Budget<Held>::bytes(200, Held::sizes.storage)) /
                                            Budget<Held>::storage_slot_bytes);

} // namespace channel_capacity
