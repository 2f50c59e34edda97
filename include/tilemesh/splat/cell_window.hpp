#pragma once
#include <cstring>
#include <tilemesh/splat/blending_cells.hpp>
#include <tilemesh/splat/cell_lists.hpp>
#include <tilemesh/splat/cell_wide.hpp>
#include <type_traits>

/// Blends a list of splats into the open cells of a window: it takes chunks of the list (cell_state.hpp), lists the splats that reach each cell
/// (cell_lists.hpp), and blends them (blending_cells.hpp, cell_wide.hpp).
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat::detail {

/// After every `blended_between_looks` splats that a cell blends, it checks whether all its pixels have stopped. With `Tally::by_groups`, the cell
/// also checks after every `splats_a_group` splats of the whole list, and then restarts its count. So the number of evaluated pairs does not
/// depend on the size of a chunk.
inline constexpr std::uint32_t splats_a_group = 128;

/// What a host thread or a worker needs besides its list.
template <bool HasDepth, std::uint32_t Group, std::uint32_t Size>
struct CellMemory {
    static_assert(splats_a_group % Size == 0, "a group is whole chunks");
    static constexpr std::uint32_t group = Group, size = Size;
    OpenCell<HasDepth> cells[Group];
    CellChunk<Size> chunk;
    using Lists = ListsOf<Size>;
    Lists lists;
    typename Lists::Number list[Size + (Size > 16 ? 64 : 8)]; // it is written 8 or 64 numbers at a time
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
/// What a set in use asks of blending: `Work` by the stop that the rules ask for.
template <template <class, class, bool...> class Work, class Rule, class Stop, bool... Flags, class Set, class... Arguments>
std::uint32_t blend_as_asked(Set const& set, Rules const& rules, Arguments&&... arguments) noexcept
{
    if constexpr (std::is_same_v<Stop, StopAsAsked>)
        return rules.stop == splat::Stop::after_crossing ? set.template call<Work<Rule, StopEachPixel, Flags...>>(arguments..., rules)
                                                         : set.template call<Work<Rule, StopBeforeCrossing, Flags...>>(arguments..., rules);
    else
        return set.template call<Work<Rule, Stop, Flags...>>(arguments..., rules);
}
/// Blends the listed splats of a chunk into a cell. `special`: the bits of Special in the chunk. `tally` counts what is evaluated, and looks which
/// columns go on.
template <class Rule, class Stop, class Set, class Memory, class AnyCell, class Tally>
void blend_listed(Set const& set, Memory const& m, AnyCell& cell, std::uint32_t n, std::uint32_t special, Rules const& rules,
                  Tally const& tally) noexcept
{
    constexpr std::uint32_t most = batch_of<Memory::size>;
    for (std::uint32_t done = 0; done < n && cell.columns != 0;) {
        std::uint32_t part = blended_between_looks - cell.blended % blended_between_looks;
        if (part > most) part = most;
        if (part > n - done) part = n - done;
        auto const* const list = m.list + done;
        bool const wide = blends_wide<Memory::size> && set.lanes() == wide_lanes;
        bool const all_recur = special == 0 || (clamps_in_loops<Memory::size> && recurs(special));
        std::uint32_t const some = all_recur ? special : special_in(m.chunk, list, part);
        if (!wide || !recurs(some))
            cell.going = blend_as_asked<BlendCell, Rule, Stop>(set, rules, cell.state, m.chunk, list, part, cell.at, cell.columns, some);
        else if constexpr (blends_wide<Memory::size>)
            cell.going = some == 0 ? blend_as_asked<BlendStacked, Rule, Stop, false>(set, rules, cell.state, m.chunk, list, part, cell.at)
                                   : blend_as_asked<BlendStacked, Rule, Stop, true>(set, rules, cell.state, m.chunk, list, part, cell.at);
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
/// Blends the splats of two cells side by side, with a row of both in one vector, if that costs less than one cell after the other: if they have
/// enough splats in common, and neither looks in between. Returns whether.
template <class Rule, class Stop, class Set, class Memory, class AnyCell, class Tally>
bool blend_pair(Set const& set, Memory& m, AnyCell& left, AnyCell& right, std::uint32_t special, Rules const& rules, Tally const& tally) noexcept
{
    std::uint32_t const a = left.in_window, b = right.in_window;
    std::uint32_t const mine = m.lists.count(a, a), others = m.lists.count(b, b), all = m.lists.count(a, b);
    // A splat of a pair takes 1.3 times as long as one of a cell (measured on Zen 5).
    if (mine == 0 || others == 0 || 10 * (mine + others) <= 13 * all) return false;
    constexpr std::uint32_t between = blended_between_looks;
    if (left.blended % between + mine > between || right.blended % between + others > between) return false;
    (void)m.lists.list(a, b, m.list);
    if (!recurs(special) && !recurs(special_in(m.chunk, m.list, all))) return false;
    std::uint32_t const going =
        special == 0 ? blend_as_asked<BlendPair, Rule, Stop, false>(set, rules, left.state, right.state, m.chunk, m.list, all, left.at)
                     : blend_as_asked<BlendPair, Rule, Stop, true>(set, rules, left.state, right.state, m.chunk, m.list, all, left.at);
    left.going = going & 1u, right.going = going >> 1;
    tally.evaluated(left, mine), tally.evaluated(right, others);
    left.blended += mine, right.blended += others;
    if (left.blended % between == 0) tally.look(left);
    if (right.blended % between == 0) tally.look(right);
    return true;
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
        std::uint32_t const special = set.template call<CompleteCells<Rule>>(m.chunk, most, *window.camera, rules.alpha_max);
        set.template call<ReachCells>(m.chunk, most, window);
        m.lists.begin(m.chunk, most, window.columns * window.bands);
        if (Tally::by_groups && begin % splats_a_group == 0)
            for (std::uint32_t b = 0; b < open; ++b) m.cells[b].blended = 0;
        bool const group_ends = Tally::by_groups && (begin + size) % splats_a_group == 0;
        going = 0;
        auto const close = [&](auto& cell) {
            if (group_ends) tally.look(cell);
            going += cell.columns != 0 ? 1u : 0u;
        };
        for (std::uint32_t b = 0; b < open; ++b) {
            auto& cell = m.cells[b];
            fetch_part_ahead<size>(begin + size, n, b, open, at);
            if (cell.columns == 0) continue;
            if constexpr (blends_wide<size> && !decltype(cell.state)::has_depth)
                if (set.lanes() == wide_lanes && b + 1 != open && m.cells[b + 1].columns != 0 && beside(cell, m.cells[b + 1]) &&
                    blend_pair<Rule, Stop>(set, m, cell, m.cells[b + 1], special, rules, tally)) {
                    fetch_part_ahead<size>(begin + size, n, ++b, open, at);
                    close(cell), close(m.cells[b]);
                    continue;
                }
            std::uint32_t const listed = m.lists.list(cell.in_window, cell.in_window, m.list);
            blend_listed<Rule, Stop>(set, m, cell, listed, special, rules, tally);
            close(cell);
        }
    }
}

}}} // namespace tilemesh::splat::detail
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
