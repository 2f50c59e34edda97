#pragma once
#include <cstring>
#include <tilemesh/splat/blending_cells.hpp>
#include <tilemesh/splat/cell_lists.hpp>
#include <type_traits>

/// Blends a list of splats into the open cells of a window: it takes chunks of the list (cell_state.hpp), lists the splats that reach each cell
/// (cell_lists.hpp), and blends them (blending_cells.hpp).
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat::detail {

/// After every `blended_between_looks` splats that a cell blends, it checks whether all its pixels have stopped. With `Tally::by_groups`, the cell
/// also checks after every `splats_a_group` splats of the whole list, and then restarts its count. So the number of evaluated pairs does not
/// depend on the size of a chunk.
inline constexpr std::uint32_t splats_a_group = 128;

/// Can two cells be blended at once? Only with large chunks: a tile's worker has no memory for the lists of a second cell.
template <std::uint32_t Size>
inline constexpr bool pairs_cells = (Size > 16) && most_native_lanes == 2 * cell_width;

/// `second`: the splats of the right cell. `both`: the splats of the left cell or the right cell.
template <std::uint32_t Size, bool = pairs_cells<Size>>
struct PairLists {
    typename ListsOf<Size>::Number second[Size + 8], both[Size + 8];
};
template <std::uint32_t Size>
struct PairLists<Size, false> {};

/// What a host thread or a worker needs besides its list.
template <bool HasDepth, std::uint32_t Group, std::uint32_t Size>
struct CellMemory : PairLists<Size> {
    static_assert(splats_a_group % Size == 0, "a group is whole chunks");
    static constexpr std::uint32_t group = Group, size = Size;
    OpenCell<HasDepth> cells[Group];
    CellChunk<Size> chunk;
    using Lists = ListsOf<Size>;
    Lists lists;
    typename Lists::Number list[Size + 8]; // it is written 8 numbers at a time
};

/// All bits of Special that a listed splat has.
template <std::uint32_t Size, class Number>
std::uint32_t special_in(CellChunk<Size> const& chunk, Number const* list, std::uint32_t n) noexcept
{
    std::uint32_t any = 0;
    for (std::uint32_t h = 0; h < n; ++h) any |= chunk.special[list[h]];
    return any;
}
template <class AnyCell>
bool goes_on(AnyCell const* cells, std::uint32_t n) noexcept
{
    std::uint32_t columns = 0;
    for (std::uint32_t b = 0; b < n; ++b) columns |= cells[b].columns;
    return columns != 0;
}
/// Blends a batch into a cell. Returns 1 if a pixel goes on.
template <class Rule, class Stop, class Set, class... Arguments>
std::uint32_t blend_batch(Set const& set, Rules const& rules, Arguments&&... arguments) noexcept
{
    if constexpr (std::is_same_v<Stop, StopAsAsked>)
        return rules.stop == splat::Stop::after_crossing ? blend_batch<Rule, StopEachPixel>(set, rules, arguments...)
                                                  : blend_batch<Rule, StopBeforeCrossing>(set, rules, arguments...);
    else
        return set.template call<BlendCell<Rule, Stop>>(arguments..., rules);
}
/// Blends the listed splats of a chunk into a cell. `tally` counts what is evaluated, and looks which columns go on.
template <class Rule, class Stop, class Set, class Memory, class AnyCell, class Tally>
void blend_listed(Set const& set, Memory const& m, AnyCell& cell, std::uint32_t n, bool special, Rules const& rules, Tally const& tally) noexcept
{
    constexpr std::uint32_t most = batch_of<Memory::size>;
    for (std::uint32_t done = 0; done < n && cell.columns != 0;) {
        std::uint32_t part = blended_between_looks - cell.blended % blended_between_looks;
        if (part > most) part = most;
        if (part > n - done) part = n - done;
        auto const* const list = m.list + done;
        bool const some = special && special_in(m.chunk, list, part) != 0;
        cell.going = blend_batch<Rule, Stop>(set, rules, cell.state, m.chunk, list, part, cell.at, cell.columns, some);
        tally.evaluated(cell, part);
        done += part;
        cell.blended += part;
        if (cell.blended % blended_between_looks == 0) tally.look(cell);
    }
}
template <class AnyCell>
bool beside(AnyCell const& left, AnyCell const& right) noexcept
{
    return right.at.row == left.at.row && right.at.column == left.at.column + cell_width;
}
/// How many numbers of a rising list are below `end`.
template <class Number>
std::uint32_t numbers_below(std::uint32_t end, Number const* list, std::uint32_t n) noexcept
{
    std::uint32_t below = 0;
    for (std::uint32_t i = 0; i < n; ++i) below += list[i] < end ? 1u : 0u; // no branch: it becomes vectors
    return below;
}
/// A cell and what is left of its list.
template <class AnyCell, class Number>
struct Listed {
    AnyCell& cell;
    Number const* list;
    std::uint32_t left;

    /// The number behind that of the last splat before the next look; `most` if the list ends before.
    std::uint32_t next_look(std::uint32_t most) const noexcept
    {
        std::uint32_t const part = blended_between_looks - cell.blended % blended_between_looks;
        return part <= left ? list[part - 1] + 1u : most;
    }
    template <class Tally>
    void pass(std::uint32_t end, Tally const& tally) noexcept
    {
        std::uint32_t const n = numbers_below(end, list, left);
        tally.evaluated(cell, n);
        cell.blended += n;
        if (n != 0 && cell.blended % blended_between_looks == 0) tally.look(cell);
        list += n, left -= n;
    }
};
/// `blend_listed` for two cells side by side, as long as both have splats, with a splat's row of both in one vector.
template <class Rule, class Stop, class Set, class Memory, class AnyListed, class Tally>
void blend_pair(Set const& set, Memory& m, AnyListed& left, AnyListed& right, bool special, Rules const& rules, Tally const& tally) noexcept
{
    if constexpr (std::is_same_v<Stop, StopAsAsked>) {
        if (rules.stop == splat::Stop::after_crossing) blend_pair<Rule, StopEachPixel>(set, m, left, right, special, rules, tally);
        else blend_pair<Rule, StopBeforeCrossing>(set, m, left, right, special, rules, tally);
    } else {
        std::uint32_t all = m.lists.list_of_both(left.cell.in_window, right.cell.in_window, m.both);
        auto const* both = m.both;
        if (special && (special_in(m.chunk, both, all) & ~Special::clamped) != 0) return;
        while (left.left != 0 && right.left != 0 && left.cell.columns != 0 && right.cell.columns != 0) {
            std::uint32_t const a = left.next_look(Memory::size), b = right.next_look(Memory::size), end = a < b ? a : b;
            std::uint32_t const n = numbers_below(end, both, all);
            CellPair<decltype(left.cell.state)> const cells{left.cell.state, right.cell.state};
            std::uint32_t const going = set.template call<BlendPair<Rule, Stop>>(cells, m.chunk, both, n, left.cell.at, rules);
            left.cell.going = going & 1u, right.cell.going = going >> 1;
            left.pass(end, tally), right.pass(end, tally);
            both += n, all -= n;
        }
    }
}
/// Blends n splats, front to back, into the open cells of a window.
template <class Rule, class Stop, std::uint32_t N, class Memory, class SplatAt, class Tally>
void blend_open_cells(Memory& m, CellWindow const& window, std::uint32_t open, Rules const& rules, std::uint32_t n, SplatAt const& at,
                      Tally const& tally) noexcept
{
    constexpr std::uint32_t size = Memory::size;
    SetOf<N> const set{};
    fetch_ahead(0, n < size ? n : size, at);
    std::uint32_t going = open;
    for (std::uint32_t begin = 0; begin < n && going != 0; begin += size) {
        std::uint32_t const most = fill<(SetOf<N>::most_lanes >= 4)>(m.chunk, begin, n, at);
        bool const special = set.template call<CompleteCells<Rule>>(m.chunk, most, *window.camera, rules.alpha_max) != 0;
        set.template call<ReachCells>(m.chunk, most, window);
        m.lists.begin(m.chunk, most, window.columns * window.bands);
        going = 0;
        for (std::uint32_t b = 0; b < open; ++b) {
            auto& cell = m.cells[b];
            fetch_part_ahead<size>(begin + size, n, b, open, at);
            if (cell.columns == 0) continue;
            if (Tally::by_groups && begin % splats_a_group == 0) cell.blended = 0;
            if constexpr (pairs_cells<size> && !decltype(cell.state)::has_depth)
                if (set.lanes() == 2 * cell_width && b + 1 != open && m.cells[b + 1].columns != 0 && beside(cell, m.cells[b + 1])) {
                    auto& right = m.cells[++b];
                    fetch_part_ahead<size>(begin + size, n, b, open, at);
                    if (Tally::by_groups && begin % splats_a_group == 0) right.blended = 0;
                    Listed<std::remove_reference_t<decltype(cell)>, typename Memory::Lists::Number> one{
                        cell, m.list, m.lists.list(cell.in_window, m.list)};
                    decltype(one) other{right, m.second, m.lists.list(right.in_window, m.second)};
                    blend_pair<Rule, Stop>(set, m, one, other, special, rules, tally);
                    for (auto const* listed : {&one, &other}) {
                        std::memmove(m.list, listed->list, (listed->left + 1) * sizeof *listed->list);
                        blend_listed<Rule, Stop>(set, m, listed->cell, listed->left, special, rules, tally);
                        if (Tally::by_groups && (begin + size) % splats_a_group == 0) tally.look(listed->cell);
                        going += listed->cell.columns != 0 ? 1u : 0u;
                    }
                    continue;
                }
            std::uint32_t const listed = m.lists.list(cell.in_window, m.list);
            blend_listed<Rule, Stop>(set, m, cell, listed, special, rules, tally);
            if (Tally::by_groups && (begin + size) % splats_a_group == 0) tally.look(cell);
            going += cell.columns != 0 ? 1u : 0u;
        }
    }
}

}}} // namespace tilemesh::splat::detail
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
