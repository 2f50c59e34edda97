#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <tilemesh/engine/text.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/tile.hpp>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 {

namespace engine {
/// The slots of a channel end, and the bytes that one of its messages takes on the machine.
struct LinkSize {
    std::uint32_t slots;
    std::uint32_t message_bytes;
};
/// In place of a number of words: the state is in no digest.
inline constexpr std::uint32_t no_digest = 0xffffffffu;
} // namespace engine

/// The machine and the list sizes of a mesh. They are a value, so meshes of different sizes share their code.
///
/// `mesh_sizes` makes such a value and checks that it fits the SRAM. Entries are in the order of `Needs<Program>`.
template <class Program>
struct MeshSizes {
    using States = typename machine::Needs<Program>::States;
    using Links = typename machine::Needs<Program>::Links;
    MachineSize machine{};
    std::array<std::uint32_t, States::count + 1> slots{}; ///< of each list; 1 for a struct
    std::array<engine::LinkSize, Links::count + 1> links{};       ///< `dynamic_capacity` slots: `limit` sets the number later
    std::array<bool, Links::count + 1> shares_memory{};   ///< does the channel lie in the memory of its `memory_of`?
    std::uint64_t sram_bytes = 0;                         ///< of a tile; a channel without slots yet counts only its heads
    bool wide = true;                                     ///< the form of all lists of machine::Either
    /// The last words of each state, or of each item of a list, that digests leave out: words of steps that all runs leave out by a
    /// condition (If). So the digests are those of a program without the steps. `no_digest`: the state is in no digest.
    std::array<std::uint32_t, States::count + 1> undigested{};
    std::array<bool, Links::count + 1> undigested_links{}; ///< is the channel in no digest?
    static constexpr std::uint32_t no_digest = engine::no_digest;

    template <class X>
    constexpr std::uint32_t& slots_of() noexcept
    {
        return slots[machine::index_in<X>(States{})];
    }
    template <class X>
    constexpr std::uint32_t& undigested_of() noexcept
    {
        return undigested[machine::index_in<X>(States{})];
    }
    template <class C>
    constexpr engine::LinkSize& link() noexcept
    {
        return links[machine::index_in<C>(Links{})];
    }
};

namespace engine {
/// The slots of a list or channel; 1 for a struct.
template <class X, class Sizes>
constexpr std::uint32_t slots_or_one([[maybe_unused]] Sizes const& sizes) noexcept
{
    if constexpr (is_list<X> || is_channel<X>)
        return capacity_of<X>(sizes);
    else
        return 1;
}
/// The sizes of a program on a machine. The program need not fit.
template <class Program, class Sizes, class... S, class... L>
constexpr MeshSizes<Program> plain_sizes(MachineSize const& machine, Sizes const& sizes, machine::Types<S...>, machine::Types<L...>) noexcept
{
    MeshSizes<Program> m;
    m.machine = machine;
    m.slots = {slots_or_one<S>(sizes)..., 0u};
    m.links = {engine::LinkSize{capacity_of<L>(sizes), item_bytes_of<L>(sizes)}..., engine::LinkSize{0, 0}};
    m.shares_memory = {tilemesh::shares_memory<L>(sizes)..., false};
    m.sram_bytes = SramLedger<Program>::bytes(machine, sizes);
    m.undigested = {(is_per_pass<S> ? MeshSizes<Program>::no_digest : 0u)..., 0u};
    return m;
}
/// The number of workers for which kernel K has words: its `most_workers`; without that member any number.
template <class K, class = void>
inline constexpr std::uint32_t most_workers_of = 0xffffffffu;
template <class K>
inline constexpr std::uint32_t most_workers_of<K, std::void_t<decltype(K::most_workers)>> = K::most_workers;
/// Does every kernel of a program have words for all of the machine's workers?
template <class... Step>
constexpr bool has_words_for_workers([[maybe_unused]] MachineSize const& machine, machine::Types<Step...>) noexcept
{
    return ((most_workers_of<KernelOf<Step>> == 0xffffffffu ||
             (machine.workers >= 1 && machine.workers <= most_workers_of<KernelOf<Step>>)) && ...);
}
/// Does every list and channel of a program have at least its `least_slots`?
template <class Sizes, class... X, class... C>
constexpr bool all_have_least_slots([[maybe_unused]] Sizes const& sizes, machine::Types<X...>, machine::Types<C...>) noexcept
{
    return (has_least_slots<X>(sizes) && ...) && (has_least_slots<C>(sizes) && ...);
}
[[noreturn]] inline void refuse_slots(machine::Name list, std::uint32_t slots, std::uint32_t least)
{
    throw Error("list " + text(list) + " with " + std::to_string(slots) + " slots (with fewer than " + std::to_string(least) +
                " its program makes no progress); give it more slots");
}
template <class Sizes, class... X>
void require_least_slots([[maybe_unused]] Sizes const& sizes, machine::Types<X...>)
{
    ((has_least_slots<X>(sizes) ? void() : refuse_slots(name_of<X>(), slots_or_one<X>(sizes), least_slots_of<X>)), ...);
}
/// The sizes of a program under a setup. They are computed by the compiler, so a program has no code for it.
template <class Program, class Machine, class Setup>
inline constexpr auto constant_sizes = plain_sizes<Program>(size_of_machine<Machine>(), sizes_of<Setup>, typename machine::Needs<Program>::States{},
                                                            typename machine::Needs<Program>::Links{});
} // namespace engine

/// The sizes of a program under a setup, both known at compile time. A program that does not fit does not compile (`Tile`).
template <class Program, class Machine, class Setup = NoSetup>
constexpr MeshSizes<Program> mesh_sizes() noexcept
{
    static_cast<void>(Tile<Machine, Program, Setup>::bytes); // Tile refuses what does not fit, with a sentence
    static_assert(engine::has_words_for_workers(size_of_machine<Machine>(), StepsOf<Program>{}),
                  "a machine with more workers than a kernel of this program has words for, or with none (the kernel's most_workers says how "
                  "many); choose another machine, or give the kernel more words");
    constexpr bool all_have_least_slots = // named, because Clang repeats an expression's types in its error
        engine::all_have_least_slots(sizes_of<Setup>, typename machine::Needs<Program>::States{}, typename machine::Needs<Program>::Links{});
    static_assert(all_have_least_slots,
                  "a list with fewer slots than its program needs to make progress (the least_slots of a region, as of a frame's FIFOs, say "
                  "how many); give it more slots");
    return engine::constant_sizes<Program, Machine, Setup>;
}

/// The error sentence of `Tile` for a ledger that needs more than the machine's SRAM.
template <class Lines>
Error does_not_fit(MachineSize const& machine, Lines const& ledger, std::uint64_t bytes)
{
    machine::Region largest{{"code and stacks", 15}, "reserve", 0, true};
    for (machine::Region const& r : ledger)
        if (r.budgeted && r.bytes > largest.bytes && std::string(r.what) != "reserve") largest = r;
    return Error("the program does not fit in a tile's SRAM (machine " + std::string(machine.name) + ", region " +
                 std::string(largest.name.text, largest.name.size) + " has " + std::to_string(largest.bytes) + " bytes, and the sum is " +
                 std::to_string(bytes - machine.sram_bytes) + " bytes over); give it fewer slots");
}
/// Throws Error if a program of these sizes does not fit into a tile's SRAM, has no words for all of the machine's workers, or has a list
/// with fewer slots than its `least_slots`.
template <class Program, class Sizes>
void require_fit(MachineSize const& machine, Sizes const& sizes)
{
    if (!engine::has_words_for_workers(machine, StepsOf<Program>{}))
        throw Error("machine " + std::string(machine.name) + " with " + std::to_string(machine.workers) +
                    " workers (a kernel of the program has words for fewer, and needs one); choose another machine");
    engine::require_least_slots(sizes, typename machine::Needs<Program>::States{});
    engine::require_least_slots(sizes, typename machine::Needs<Program>::Links{});
    auto const bytes = SramLedger<Program>::bytes(machine, sizes);
    if (bytes > machine.sram_bytes) throw does_not_fit(machine, SramLedger<Program>::lines(machine, sizes), bytes);
}
/// The sizes of a program on a machine and with sizes known only at run time. Throws Error, with the sentence of `Tile`, if the program
/// does not fit.
template <class Program, class Sizes>
MeshSizes<Program> mesh_sizes(MachineSize const& machine, Sizes const& sizes)
{
    require_fit<Program>(machine, sizes);
    return engine::plain_sizes<Program>(machine, sizes, typename machine::Needs<Program>::States{}, typename machine::Needs<Program>::Links{});
}

}} // namespace tilemesh
