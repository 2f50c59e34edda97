#pragma once
#include <cstdint>
#include <tilemesh/machine/operations.hpp>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/splat/frame_program.hpp>
#include <tilemesh/splat/setup.hpp>

namespace channel_capacity {

namespace splat = tilemesh::splat;

/// The preset `lossless` on Mk2: what holds.
struct Held : splat::Lossless {
    static constexpr char const* name = "lossless, hold";
    static constexpr splat::Arithmetic arithmetic = splat::Arithmetic::precise; // pictures are compared with the naive one
};
/// The same with the paper's saturation: no FIFOs, so that its bytes go further.
struct Dropped : splat::Lossless {
    static constexpr char const* name = "lossless, drop";
    static constexpr splat::Arithmetic arithmetic = splat::Arithmetic::precise;
    using Saturation = splat::Drop;
    static constexpr std::uint32_t waiting_bytes = 0;
};

/// How the SRAM of one tile of `S` is shared out: every channel end (road and beam) has c slots, under `Hold` each of the two
/// FIFOs too, and all that is left is storage. Bytes a slot and bytes that depend on neither come from the tile's ledger.
template <class S>
struct Budget {
    using Layout = tilemesh::Tile<typename S::Machine, splat::Frame<S>>;
    using Road = splat::Road<S>;
    using Beam = splat::Beam<S>;

    static constexpr std::uint32_t sram_bytes = S::Machine::sram_bytes;
    /// Eight ends of the road and of the beam, and one slot of two FIFOs.
    static constexpr std::uint32_t channel_slot_bytes = Layout::template channel_bytes<Road>(1) - Layout::template channel_bytes<Road>(0) +
                                                        Layout::template channel_bytes<Beam>(1) - Layout::template channel_bytes<Beam>(0) +
                                                        (S::Saturation::holds ? 8 * splat::Waiting<S, 0>::item_words : 0);
    /// A stored record with its mark, its projection and its sort key.
    static constexpr std::uint32_t storage_slot_bytes =
        4 * (splat::Storage<S>::item_words + splat::Marks<S>::item_words + splat::Splats<S>::item_words + splat::Order<S>::item_words);
    static constexpr std::uint64_t fixed_bytes =
        Layout::bytes - std::uint64_t{Road::static_capacity} * channel_slot_bytes - std::uint64_t{S::storage_slots} * storage_slot_bytes;

    /// What is left for storage when every channel has c slots; 0 where the channels alone do not fit.
    static constexpr std::uint32_t storage_slots(std::uint32_t c) noexcept
    {
        auto const channels = fixed_bytes + std::uint64_t{c} * channel_slot_bytes;
        return channels > sram_bytes ? 0 : static_cast<std::uint32_t>((sram_bytes - channels) / storage_slot_bytes);
    }
    /// The most slots a channel may have while one record can be stored.
    static constexpr std::uint32_t most_channel_slots =
        static_cast<std::uint32_t>((sram_bytes - fixed_bytes - storage_slot_bytes) / channel_slot_bytes);
};

/// S with c slots a channel and s of storage, as a machine that must compile.
template <class S, std::uint32_t C, std::uint32_t Stored>
struct Split : S {
    static constexpr std::uint32_t storage_slots = Stored;
    static constexpr std::uint32_t road_bytes = C * sizeof(typename splat::Road<S>::value_type);
    static constexpr std::uint32_t beam_bytes = C * sizeof(typename splat::Beam<S>::value_type);
    static constexpr std::uint32_t waiting_bytes = S::Saturation::holds ? road_bytes : 0;
};

/// The arithmetic against the ledger of the real machine: with s(c) slots it fits, with one more it would not.
template <class S, std::uint32_t C>
constexpr bool split_is_exact() noexcept
{
    constexpr std::uint32_t s = Budget<S>::storage_slots(C);
    using Layout = typename Budget<Split<S, C, s>>::Layout;
    return s >= 1 && Layout::bytes <= Budget<S>::sram_bytes && Layout::bytes + Budget<S>::storage_slot_bytes > Budget<S>::sram_bytes;
}
static_assert(split_is_exact<Held, 1>() && split_is_exact<Held, 200>() && split_is_exact<Held, Budget<Held>::most_channel_slots>());
static_assert(split_is_exact<Dropped, 1>() && split_is_exact<Dropped, 200>() &&
              split_is_exact<Dropped, Budget<Dropped>::most_channel_slots>());
static_assert(Budget<Held>::storage_slots(Budget<Held>::most_channel_slots + 1) == 0, "there the channels leave no record");
/// `lossless` itself has 200 slots a channel and 2,000 of storage, and leaves some bytes free.
static_assert(splat::Road<Held>::static_capacity == 200 && splat::Beam<Held>::static_capacity == 200 &&
              Budget<Held>::storage_slots(200) ==
                  splat::Lossless::storage_slots +
                      (Budget<Held>::sram_bytes - Budget<Held>::Layout::bytes) / Budget<Held>::storage_slot_bytes);

/// `S` on a machine with room for every split, whose capacities are limited while it runs: one program, one set of types for the
/// whole sweep. Nothing is known to fill its channels: what a cold start of 250,000 records puts into one is under 8,192.
template <class S>
struct Sweep : S {
    using Machine = tilemesh::Traced<tilemesh::TestMachine<64u << 20>>;
    static constexpr std::uint32_t most_slots = 8192;
    static constexpr std::uint32_t storage_slots = Budget<S>::storage_slots(1);
    static constexpr std::uint32_t road_bytes = most_slots * sizeof(typename splat::Road<S>::value_type);
    static constexpr std::uint32_t beam_bytes = most_slots * sizeof(typename splat::Beam<S>::value_type);
    static constexpr std::uint32_t waiting_bytes = S::Saturation::holds ? road_bytes : 0;
};

} // namespace channel_capacity
