#pragma once
#include <cstdint>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 {

/// Graphcore's Mk2 IPU (GC200). A machine is one type with these static members. To describe another machine, write a type with them.
///
/// Sources of tiles, sram_bytes, workers and clock: the paper, section "The Graphcore IPU". code_bytes is the reserve on every tile for
/// codelets, exchange code and stacks: the authors' later code measures "~130 KB code + stacks".
struct Mk2 {
    static constexpr char const* name = "mk2";
    static constexpr std::uint32_t tiles = 1472;
    static constexpr std::uint32_t sram_bytes = 624 * 1024;
    static constexpr std::uint32_t code_bytes = 130 * 1024;
    static constexpr std::uint32_t workers = 6;
    static constexpr std::uint32_t clock_khz = 1'325'000;
};

/// A machine for tests and experiments: Mk2's workers and clock, with any SRAM and any number of tiles.
template <std::uint32_t SramBytes, std::uint32_t Tiles = 0xffffffffu>
struct TestMachine {
    static constexpr char const* name = "test";
    static constexpr std::uint32_t tiles = Tiles;
    static constexpr std::uint32_t sram_bytes = SramBytes;
    static constexpr std::uint32_t code_bytes = 0;
    static constexpr std::uint32_t workers = 6;
    static constexpr std::uint32_t clock_khz = 1'325'000;
};

/// A machine as a value, with all facts that engines and ledgers need. So meshes of different machines share their code.
struct MachineSize {
    char const* name;
    std::uint32_t tiles;
    std::uint32_t sram_bytes;
    std::uint32_t code_bytes;
    std::uint32_t workers;
    std::uint32_t clock_khz;
};
namespace detail {
template <class M>
using MachineMembers = decltype(M::name[0] + M::tiles + M::sram_bytes + M::code_bytes + M::workers + M::clock_khz);
template <class M, class = void>
inline constexpr bool is_machine = false;
template <class M>
inline constexpr bool is_machine<M, std::void_t<MachineMembers<M>>> = true;
} // namespace detail

/// The machine type of a mesh that gets its MachineSize when it is built. All such meshes of a program have one type, so they share code.
struct AnyMachine {};

/// Does M describe a machine? Engines and layouts accept only such types.
template <class M>
inline constexpr bool is_machine = detail::is_machine<M> || std::is_base_of_v<AnyMachine, M>;

template <class Machine>
constexpr MachineSize size_of_machine() noexcept
{
    static_assert(detail::is_machine<Machine>, "no machine (it has the members name, tiles, sram_bytes, code_bytes, workers and clock_khz, as "
                                               "Mk2 has); look for a misspelt one");
    if constexpr (detail::is_machine<Machine>)
        return {Machine::name, Machine::tiles, Machine::sram_bytes, Machine::code_bytes, Machine::workers, Machine::clock_khz};
    else
        return {}; // so that the sentence above is the first error
}

}} // namespace tilemesh
