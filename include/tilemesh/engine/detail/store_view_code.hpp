#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/engine/digest.hpp>
#include <tilemesh/engine/store_view.hpp>
#include <tilemesh/engine/text.hpp>
#include <tilemesh/error.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace engine {

namespace detail {
TILEMESH_HOST void check_limit(machine::Name name, std::uint32_t items, std::uint32_t most)
{
    if (items > most)
        throw Error("a limit of " + std::to_string(items) + " items for " + text(name) + " (the program's layout has " + std::to_string(most) +
                    "); choose a smaller limit or a program with more slots");
}
/// The number of sides of tiles from which an exchange moves a channel.
TILEMESH_HOST std::uint64_t sides_of(Grid grid, LinkFacts const& link) noexcept
{
    std::uint64_t sides = 0;
    for (Direction d : news)
        if (contains(link.sends_to, d)) {
            bool const column = d == Direction::north || d == Direction::south;
            sides += grid.size() - (link.edge == Edge::drop ? (column ? grid.width : grid.height) : 0);
        }
    return sides;
}
} // namespace detail

TILEMESH_HOST void StoreView::require_grid() const
{
    auto const size = std::to_string(grid.width) + " x " + std::to_string(grid.height);
    if (grid.width == 0 || grid.height == 0 || grid.width > 65535 || grid.height > 65535)
        throw Error("a grid of " + size + " tiles (each side is 1 to 65,535); choose another");
    if (grid.size() > machine->tiles)
        throw Error("a grid of " + size + " = " + std::to_string(grid.size()) + " tiles (" + machine->name + " has " +
                    std::to_string(machine->tiles) + "); choose a smaller grid, larger tiles or another machine");
}
TILEMESH_HOST void StoreView::make() const
{
    for (std::uint32_t i = 0; i < state_count; ++i) {
        auto const& x = states[i];
        strides[i] = ((words(i) + 2 * guard_words + 15u) & ~std::size_t{15}) | 16u; // an odd number of cache lines: neighbours fall on different sets
        std::size_t const slack = guard_words != 0 && x.list ? item_words(i) : 0; // room for one item past the last region
        if (!x.small) items[i] = Arena(std::uint64_t{grid.size()} * strides[i] + slack);
    }
    for (std::uint32_t l = 0; l < link_count; ++l) link_capacities[l] = gets_slots_by_limit(l) ? 0 : link_sizes[l].slots;
    if (guard_words == 0) return;
    constexpr std::size_t poisoned_at_once = std::size_t{64} << 18; // words: 64 MiB; in a larger region only dead words are poisoned
    for (std::uint32_t i = 0; i < state_count; ++i) {
        auto const& x = states[i];
        auto const own = region_words(i);
        bool const fill = x.list && std::size_t{grid.size()} * own <= poisoned_at_once;
        for (std::uint32_t tile = 0; tile < grid.size(); ++tile) {
            auto const p = place(i, tile);
            if (x.list) p.head[2] = guard_word;
            if (x.small) {
                p.items[own] = guard_word;
                continue;
            }
            for (std::uint32_t g = 0; g < guard_words; ++g) (p.items - guard_words)[g] = p.items[own + g] = guard_word;
            if (fill) std::fill(p.items, p.items + own, poison_word);
        }
    }
}
TILEMESH_HOST bool StoreView::guards_hold(std::uint32_t tile) const noexcept
{
    for (std::uint32_t i = 0; i < state_count; ++i) {
        auto const& x = states[i];
        auto const p = place(i, tile);
        auto const own = region_words(i);
        if (x.small) {
            if (p.items[own] != guard_word) return false;
            continue;
        }
        bool ok = !x.list || (p.head[2] == guard_word && p.head[0] <= p.capacity);
        for (std::size_t g = 0; g < guard_words; ++g) ok = ok && p.items[own + g] == guard_word && (p.items - guard_words)[g] == guard_word;
        if (!ok) return false;
    }
    return true;
}
TILEMESH_HOST std::uint64_t StoreView::digest_states(std::uint32_t tile) const noexcept
{
    std::uint64_t h = tile;
    for (std::uint32_t s = 0; s < state_count; ++s) {
        std::uint32_t const out = undigested[s];
        if (out == no_digest) continue;
        auto const& x = states[s];
        auto const p = place(s, tile);
        if (!x.list) {
            h = mix_words(h, p.items, x.words - out);
            continue;
        }
        h = mix(h, p.head[0]);
        std::size_t const item = item_words(s);
        if (x.mix != nullptr) {
            h = x.mix(h, p, shareds);
        } else if (out == 0) {
            h = mix_words(h, p.items, p.head[0] * item);
        } else {
            for (std::uint32_t i = 0; i < p.head[0]; ++i) h = mix_words_on(h, p.items + i * item, item - out);
            h = mix(h, p.head[0] * (item - out));
        }
    }
    return h;
}
TILEMESH_HOST std::uint64_t StoreView::mix_mail(std::uint64_t h, std::uint32_t link, machine::Place const& end) const noexcept
{
    h = mix(h, end.head[1]);
    auto const& c = links[link];
    return c.mix != nullptr ? c.mix(h, end, shareds) : mix_words(h, end.items, std::size_t{end.head[0]} * c.item_words);
}
TILEMESH_HOST std::uint64_t StoreView::sram_bytes() const noexcept
{
    auto bytes = ledger_bytes;
    for (std::uint32_t host = 0; host < link_count; ++host) {
        std::uint64_t now = 0, built = 0; // of the channels that lie in the memory of `host`
        for (std::uint32_t l = 0; l < link_count; ++l) {
            if ((shares_memory[l] ? links[l].memory : l) != host) continue;
            bool const dynamic = gets_slots_by_limit(l);
            auto const all_ends = [&](std::uint32_t n) { return std::uint64_t{links[l].ends} * link_sizes[l].message_bytes * n; };
            now = std::max(now, all_ends(dynamic ? link_capacities[l] : link_sizes[l].slots));
            built = std::max(built, dynamic ? 0 : all_ends(link_sizes[l].slots));
        }
        bytes += now - built;
    }
    return bytes;
}
TILEMESH_HOST void StoreView::limit_state(std::uint32_t state, std::uint32_t items_at_most) const
{
    auto const name = states[state].name;
    detail::check_limit(name, items_at_most, slots[state]);
    for (std::uint32_t tile = 0; tile < grid.size(); ++tile)
        if (auto const held = place(state, tile).head[0]; held > items_at_most)
            throw Error("a limit of " + std::to_string(items_at_most) + " items for " + text(name) + " (tile " + text(grid.tile(tile)) +
                        " holds " + std::to_string(held) + "); set limits before the mesh is loaded");
    capacities[state] = items_at_most;
}
TILEMESH_HOST void StoreView::limit_link(std::uint32_t link, std::uint32_t at_most, bool unread) const
{
    auto const name = links[link].name;
    if (unread)
        throw Error("new slots for channel " + text(name) + " (it carries mail of the last run); set limits before the first run");
    if (!gets_slots_by_limit(link)) detail::check_limit(name, at_most, link_sizes[link].slots);
    auto const before = std::exchange(link_capacities[link], at_most);
    if (auto const bytes = sram_bytes(); bytes > machine->sram_bytes) {
        link_capacities[link] = before;
        throw Error("channel " + text(name) + " with " + std::to_string(at_most) + " slots (the program is then " +
                    std::to_string(bytes - machine->sram_bytes) + " bytes over a tile's SRAM); give it fewer slots");
    }
}
TILEMESH_HOST void StoreView::require_capacities() const
{
    for (std::uint32_t l = 0; l < link_count; ++l) {
        if (link_capacities[l] != 0) continue;
        auto const channel = "channel " + text(links[l].name);
        if (gets_slots_by_limit(l))
            throw Error(channel + " has no slots (its capacity is dynamic and was never set, or was limited to 0); call "
                                  "limit<Channel>(slots) before run()");
        throw Error(channel + " has no slots (the sizes of the mesh give it none, or it was limited to 0); give it at least one");
    }
}
TILEMESH_HOST std::uint32_t StoreView::capacity_a_side(KernelFacts const& kernel) const noexcept
{
    std::uint32_t bytes = 0;
    for (auto const& use : kernel.links)
        if (use.writes) bytes += end_bytes(use.link, link_capacities[use.link]);
    return bytes;
}
TILEMESH_HOST std::array<std::uint32_t, 4> StoreView::absent_a_side(KernelFacts const& kernel) const noexcept
{
    std::array<std::uint32_t, 4> bytes{};
    for (auto const& use : kernel.links)
        if (use.writes)
            for (Direction d : news)
                if (!contains(links[use.link].sends_to, d)) bytes[index(d)] += end_bytes(use.link, link_capacities[use.link]);
    return bytes;
}
TILEMESH_HOST std::uint64_t StoreView::capacity_bytes(KernelFacts const& kernel) const noexcept
{
    std::uint64_t bytes = 0;
    for (auto const& use : kernel.links)
        if (use.writes) bytes += detail::sides_of(grid, links[use.link]) * end_bytes(use.link, link_capacities[use.link]);
    return bytes;
}

}}} // namespace tilemesh::engine
