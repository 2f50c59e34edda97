#pragma once
#include <array>
#include <cstddef>
#include <tilemesh/poplar/codelet.hpp>

namespace tilemesh::on_poplar {

namespace detail {
/// Bytes of a vertex in a tile's memory. A vector field is a pointer and a size (the documents' SPAN: 8 bytes), so is each of its
/// inner vectors; a plain member is 4 bytes, and so is the entry that tells the tile to run the vertex (a guess: not documented).
template <class Kernel, class... A>
constexpr std::uint32_t edges(Types<A...>) noexcept
{
    return (0u + ... + (EdgesOf<Kernel, A>::reads + EdgesOf<Kernel, A>::keeps));
}
template <class Kernel, class... C>
constexpr std::uint32_t sent_edges(Types<C...>) noexcept
{
    return (0u + ... + (KernelTraits<Kernel>::template writes<C> ? 4u : 0u));
}
template <class Kernel, class... C>
constexpr std::uint32_t only_read(Types<C...>) noexcept
{
    return (0u + ... + (KernelTraits<Kernel>::template writes<C> ? 0u : 4u));
}
inline constexpr std::uint32_t span_bytes = 8, word_bytes = 4;

template <class Kernel>
constexpr std::uint32_t vertex_bytes() noexcept
{
    using Traits = KernelTraits<Kernel>;
    auto const lists = 3 + 3 + edges<Kernel>(typename Traits::Arguments{}) + sent_edges<Kernel>(typename Traits::Links{});
    auto const forget = only_read<Kernel>(typename Traits::Links{});
    return span_bytes * lists + 7 * word_bytes + word_bytes + (forget == 0 ? 0 : span_bytes * (1 + forget) + word_bytes);
}
template <class... Step, class... L>
constexpr std::uint32_t all_vertex_bytes(Types<Step...>, Types<L...>) noexcept
{
    // Start and begin of a run: Clear, of the log, what is said and all heads; of the log.
    auto const clears = span_bytes * (1 + 3 + 4 * static_cast<std::uint32_t>(sizeof...(L))) + word_bytes + span_bytes * (1 + 2) + word_bytes;
    // On tile 0 also a row's votes and the end of each pass, and the begin of an UntilQuiet.
    auto const votes = static_cast<std::uint32_t>(sizeof...(Step)) * (2 * span_bytes + word_bytes + 3 * span_bytes + 3 * word_bytes + word_bytes +
                                                                    2 * span_bytes + 2 * word_bytes + word_bytes);
    return clears + votes + (0u + ... + vertex_bytes<KernelOf<Step>>());
}
} // namespace detail

/// Bytes of the busiest tile, 0, that hold votes, logs and who runs, with a row's votes and those of all rows as they arrive.
template <class Program>
constexpr std::uint32_t log_bytes(Grid grid) noexcept
{
    return 4 * (TileLog<Program>::words + RunLog<Program>::words + 1 + 1 + grid.width + grid.height) + 4 + sizeof(Within);
}
template <class Program>
constexpr std::uint32_t vertex_bytes() noexcept
{
    return detail::all_vertex_bytes(StepsOf<Program>{}, typename Needs<Program>::Links{});
}

/// The ledger of a tile as Poplar stores the program: the lines of `Tile<Machine, Program>`, which are the graph's variables byte
/// for byte, and what Poplar needs besides, taken out of the reserve for code and stacks (a machine's `code_bytes`; Mk2's is
/// the "~130 KB code + stacks" that the paper's authors measured for a whole program): logs and votes, the vertices' state, and
/// what is left for code, exchange code and stacks. Of tile 0, the fullest. A machine without a reserve shows 0 left.
template <class Machine, class Program>
constexpr auto ledger(Grid grid) noexcept
{
    using Layout = Tile<Machine, Program>;
    constexpr auto tile = Layout::ledger();
    std::array<Region, tile.size() + 2> lines{};
    for (std::size_t i = 0; i + 1 < tile.size(); ++i) lines[i] = tile[i];
    auto const logs = log_bytes<Program>(grid);
    auto const vertices = on_poplar::vertex_bytes<Program>();
    auto const reserve = Machine::code_bytes;
    lines[tile.size() - 1] = {{"logs and votes", 14}, "variables beside the program's", logs, true};
    lines[tile.size()] = {{"vertices", 8}, "fields: SPAN is 8 bytes, a word 4", vertices, true};
    lines[tile.size() + 1] = {{"code and stacks", 15}, "what is left of the reserve", reserve > logs + vertices ? reserve - logs - vertices : 0, true};
    return lines;
}

} // namespace tilemesh::on_poplar
