#pragma once
#include <array>
#include <cstddef>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/poplar/program_log.hpp>
#include <tilemesh/poplar/vertex_edges.hpp>

namespace tilemesh { inline namespace v0_2 { namespace on_poplar {

namespace detail {
/// The bytes of fields in a vertex's state. A SPAN is a pointer and a size; each inner vector of a list is one too. An edge of one element
/// is a pointer; a plain member is a word. Sources: the SDK's documents of vertex fields; hardware: pointers are 32 bits.
inline constexpr std::uint32_t span_bytes = 8, word_bytes = 4;

template <class Kernel, class... A, class... C>
constexpr std::uint32_t kernel_vertex_bytes(machine::Types<A...>, machine::Types<C...>) noexcept
{
    using Traits = KernelTraits<Kernel>;
    auto const edges = 3 + (0u + ... + (EdgesOf<Kernel, A>::reads + EdgesOf<Kernel, A>::keeps)) +
                       (0u + ... + (Traits::template writes<C> ? ends_out<C> : 0u));
    auto const forgotten = (0u + ... + (Traits::template writes<C> ? 0u : ends_in<C>)); // heads of mail that was only read
    return span_bytes * (3 + edges) + 8 * word_bytes + (forgotten == 0 ? 0 : span_bytes * (1 + forgotten));
}
template <class Step>
inline constexpr std::uint32_t begin_bytes = StepTraits<Step>::everywhere ? 0 : span_bytes + 3 * word_bytes; // BeginStep
/// Vertices of loops (BeginLoop, TestLoop) and of conditions (TestFlag).
template <class Program>
inline constexpr std::uint32_t control_bytes = StepTraits<Program>::loops*(2 * span_bytes + word_bytes + span_bytes + 2 * word_bytes) +
                                               StepTraits<Program>::Flags::count*(span_bytes + word_bytes);
template <class Sizes, class... Step, class... L>
constexpr std::uint32_t vertex_bytes([[maybe_unused]] Sizes const& sizes, machine::Types<Step...>, machine::Types<L...>) noexcept
{
    auto const own = (0u + ... + (tilemesh::shares_memory<L>(sizes) ? 0u : ends_in<L>));
    auto const start = span_bytes * (1 + 3 + own), begin = span_bytes * (1 + 2);
    auto const votes = 2 * span_bytes + 2 * span_bytes + 4 * word_bytes; // GatherVotes, CountPass
    return start + begin +
           (0u + ... +
            (kernel_vertex_bytes<KernelOf<Step>>(typename KernelTraits<KernelOf<Step>>::Arguments{}, typename KernelTraits<KernelOf<Step>>::Links{}) +
             begin_bytes<Step> + votes));
}
} // namespace detail

/// The bytes on the fullest tile, tile 0, for logs, votes and the tiles that must run.
template <class Program>
constexpr std::uint32_t log_bytes() noexcept
{
    // said, rows said, again (a bool, stored as a word)
    return 4 * (TileLog<Program>::words + RunLog::words<Program> + StepTraits<Program>::loops + 1 + 1 + 1) +
           static_cast<std::uint32_t>(sizeof(RunRectangle));
}
/// The bytes on tile 0 to which the votes of its row, and those of all rows, arrive after each step. If Poplar let steps share them, the
/// bytes of one step would be enough.
template <class Program>
constexpr std::uint32_t arriving_bytes(Grid grid) noexcept
{
    return 4 * StepsOf<Program>::count * ((grid.width > 1 ? grid.width : 0) + (grid.height > 1 ? grid.height : 0));
}
/// The bytes of the states of all vertices on tile 0.
template <class Program, class Setup = NoSetup>
constexpr std::uint32_t vertex_bytes() noexcept
{
    return detail::control_bytes<Program> + detail::vertex_bytes(sizes_of<Setup>, StepsOf<Program>{}, typename machine::Needs<Program>::Links{});
}

/// The ledger of a tile as Poplar stores the program. Experimental until an SDK has compiled it. The first lines are those of
/// `Tile<Machine, Program>`; they are the graph's variables, byte for byte. The other lines are the bytes that Poplar needs in addition on
/// tile 0, the fullest tile. They come out of the reserve for code and stacks (a machine's `code_bytes`), so that the sum is the tile's.
/// Mk2's reserve is the "~130 KB code + stacks" that the paper's authors measured for a whole Poplar program, including exchange code. On a
/// machine without a reserve, nothing is left for these lines, and the total exceeds the sum.
template <class Machine, class Program, class Setup = NoSetup>
constexpr auto ledger(Grid grid) noexcept
{
    using Layout = Tile<Machine, Program, Setup>;
    constexpr auto tile = Layout::ledger();
    constexpr auto n = tile.size() - 1; // without the reserve
    std::array<machine::Region, n + 4> lines{};
    for (std::size_t i = 0; i < n; ++i) lines[i] = tile[i];
    auto const logs = log_bytes<Program>(), arriving = arriving_bytes<Program>(grid), vertices = vertex_bytes<Program, Setup>();
    auto const used = logs + arriving + vertices;
    lines[n] = {{"logs and votes", 14}, "variables beside the program's", logs, true};
    lines[n + 1] = {{"votes arriving", 14}, "temporaries", arriving, true};
    lines[n + 2] = {{"vertices", 8}, "their fields: SPAN 8 bytes, words 4", vertices, true};
    lines[n + 3] = {{"code and stacks", 15}, "what is left of the reserve", Machine::code_bytes > used ? Machine::code_bytes - used : 0, true};
    return lines;
}

}}} // namespace tilemesh::on_poplar
