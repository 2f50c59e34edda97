#pragma once
#include <tilemesh/machine/operations.hpp>

/// The words on which the vertices of a program and its host agree. Kernel code, which the codelets and the graph share.
///
/// All of poplar/ is experimental until an SDK has compiled it: names and layouts here may change.
namespace tilemesh { inline namespace v0_2 { namespace on_poplar {

/// The log that a tile writes in a run, word by word; the host reads it after the run. Cost: 12 bytes, 4 for each step and for each channel
/// of the step, and 4 for each list and each channel of the program.
template <class Program, class = StepsOf<Program>, class = machine::Needs<Program>>
struct TileLog;
template <class Program, class... Step, class... S, class... L, class... P>
struct TileLog<Program, machine::Types<Step...>, RegionTypes<machine::Types<S...>, machine::Types<L...>, machine::Types<P...>>> {
    static constexpr std::uint32_t vote = 0;   ///< vote of the tile's last run
    /// 1 + the first step that sent over unread mail; 0: none; `other_program`: a vertex was compiled for another program.
    static constexpr std::uint32_t broken = 1;
    static constexpr std::uint32_t other_program = 0xffffffffu;
    static constexpr std::uint32_t ran = 2; ///< 1: the tile had to run in the last pass
    /// The place of step i: the number of times that the tile ran, then for each channel of its kernel the messages sent.
    static constexpr std::uint32_t step(std::uint32_t i) noexcept
    {
        std::uint32_t at = 3, n = 0;
        ((at += n++ < i ? 1 + KernelTraits<KernelOf<Step>>::Links::count : 0), ...);
        return at;
    }
    /// The most items that a list, or any side of a channel, held at the end of a pass.
    template <class X>
    static constexpr std::uint32_t state_peak() noexcept
    {
        return step(sizeof...(Step)) + machine::index_in<X>(machine::Types<S...>{});
    }
    template <class C>
    static constexpr std::uint32_t link_peak() noexcept
    {
        return step(sizeof...(Step)) + static_cast<std::uint32_t>(sizeof...(S)) + machine::index_in<C>(machine::Types<L...>{});
    }
    static constexpr std::uint32_t words = step(sizeof...(Step)) + static_cast<std::uint32_t>(sizeof...(S) + sizeof...(L));
};

/// The report of a tile about a pass, for the host's Trace; only on a Traced machine. 15 words.
struct PassSample {
    static constexpr char const* name = "sample";
    std::uint32_t step; ///< number of the step in the program
    std::uint32_t ran;  ///< 0: the tile did not run, and the rest has no meaning
    OperationCounts operations;
    std::uint32_t sent_bytes[4];
};
static_assert(sizeof(PassSample) == 15 * 4, "a sample goes to the host word by word");

/// The log that one tile writes for all: the channels with mail, and the number of runs of each step.
struct RunLog {
    static constexpr std::uint32_t mail = 0; ///< bit i: channel i of the program holds unread mail on some tile; outlives a run
    static constexpr std::uint32_t busy = 1; ///< 1: a tile voted busy in the superstep before
    static constexpr std::uint32_t left = 2; ///< passes that an UntilQuiet may still take
    static constexpr std::uint32_t step(std::uint32_t i) noexcept { return 3 + 2 * i; } ///< passes, then passes that sent
    /// The place of Loop l's words: the rounds that it may still make, then the rounds that it made in this run.
    template <class Program>
    static constexpr std::uint32_t loop(std::uint32_t l) noexcept
    {
        return step(StepsOf<Program>::count) + 2 * l;
    }
    template <class Program>
    static constexpr std::uint32_t words = loop<Program>(StepTraits<Program>::loops);
};

namespace detail {
constexpr std::uint32_t mix(std::uint32_t h, std::uint32_t word) noexcept
{
    return (h ^ word) * 16777619u; // FNV-1a, a word at a time
}
constexpr std::uint32_t mix(std::uint32_t h, machine::Name name) noexcept
{
    for (std::uint32_t i = 0; i < name.size; ++i) h = mix(h, static_cast<std::uint32_t>(name.text[i]));
    return h;
}
template <class X>
constexpr std::uint32_t mix_state(std::uint32_t h) noexcept
{
    h = mix(h, name_of<X>());
    if constexpr (is_list<X>) return mix(mix(h, X::static_capacity), X::item_words);
    else return mix(h, static_cast<std::uint32_t>(sizeof(X)));
}
template <class... Step, class... S, class... L, class... P>
constexpr std::uint32_t mark_of(std::uint32_t workers, bool traced, machine::Types<Step...>, machine::Types<S...>, machine::Types<L...>,
                                machine::Types<P...>) noexcept
{
    std::uint32_t h = mix(mix(2166136261u, workers), traced ? 1u : 0u);
    ((h = mix(h, name_of<KernelOf<Step>>())), ...);
    ((h = mix_state<S>(h)), ...);
    ((h = mix(mix(mix(mix(h, name_of<L>()), L::static_capacity), L::Receiver::item_words), static_cast<std::uint32_t>(L::edge))), ...);
    ((h = L::sends_to == Sides::all ? h : mix(h, static_cast<std::uint32_t>(L::sends_to))), ...);
    ((h = mix(mix(h, name_of<P>()), static_cast<std::uint32_t>(sizeof(P)))), ...);
    return h;
}
} // namespace detail
/// A number that identifies a program, as far as 32 bits can: a vertex and its graph must agree on it. It does not depend on slots that
/// are values, because a vertex takes lists of any length.
template <class Program>
constexpr std::uint32_t program_mark_on(std::uint32_t workers, bool traced) noexcept
{
    return detail::mark_of(workers, traced, StepsOf<Program>{}, typename machine::Needs<Program>::States{}, typename machine::Needs<Program>::Links{},
                           typename machine::Needs<Program>::Shareds{});
}
template <class Machine, class Program>
inline constexpr std::uint32_t program_mark = program_mark_on<Program>(Machine::workers, is_traced<Machine>);

/// The word that a tile sends after each pass: bit 0 is its vote; bit 1 + i is set if it sent on channel i of the program.
inline constexpr std::uint32_t said_busy = 1;
constexpr std::uint32_t said_mail(std::uint32_t channel) noexcept
{
    return 2u << channel;
}

/// The bits of the program's channels that a kernel reads, or that it touches at all.
template <class Program, class Kernel, class... L>
constexpr std::uint32_t links_read(machine::Types<L...>) noexcept
{
    return (0u | ... | (KernelTraits<Kernel>::template reads<L> ? 1u << machine::index_in<L>(typename machine::Needs<Program>::Links{}) : 0u));
}
template <class Program, class... L>
constexpr std::uint32_t links_touched(machine::Types<L...>) noexcept
{
    return (0u | ... | (1u << machine::index_in<L>(typename machine::Needs<Program>::Links{})));
}

/// The condition on which a vertex runs its kernel.
enum class Task : std::uint32_t {
    if_needed, ///< if the tile voted busy or has mail: UntilQuiet
    always,    ///< in the rectangle of RunRectangle, and elsewhere if needed
    sample     ///< never; it reports the work of the pass before (a kernel of all workers cannot do so while they run)
};

/// The columns and rows whose tiles every Superstep and Repeat runs (Mesh::run_within): words of a broadcast of its own.
struct RunRectangle {
    static constexpr char const* name = "who runs";
    std::uint32_t x0, y0, x1, y1;
    TILEMESH_KERNEL constexpr bool contains(std::uint32_t x, std::uint32_t y) const noexcept { return x >= x0 && x < x1 && y >= y0 && y < y1; }
};

}}} // namespace tilemesh::on_poplar
