#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/arena.hpp>
#include <tilemesh/engine/facts.hpp>
#include <tilemesh/engine/mesh_sizes.hpp>
#include <tilemesh/machine/grid.hpp>

namespace tilemesh { inline namespace v0_2 { namespace engine {

/// No kernel may touch the guard words of a guarded store. Dead words are filled with the poison word: as a float
/// it is a NaN, as an index it is out of range.
inline constexpr std::uint32_t guard_word = 0x7fa0beefu;
inline constexpr std::uint32_t poison_word = 0x7fa0dead;
/// The number of guard words before and after the items of a list or the words of a large struct, in a guarded store. A list's head and a
/// small struct have one guard word, behind them.
inline constexpr std::uint32_t guard_words_around = 4;

/// A store without the types of its program: the tables of its states and channels, and where its words are. What a host does with a store
/// between kernels is here, and is compiled once. A view is made for a call and not kept.
struct StoreView {
    StateFacts const* states;
    std::uint32_t state_count;
    LinkFacts const* links;
    std::uint32_t link_count;
    Grid grid;
    MachineSize const* machine;
    std::uint32_t const* slots;       ///< by states: see MeshSizes
    LinkSize const* link_sizes;
    bool const* shares_memory;
    std::uint32_t const* undigested;  ///< by states
    bool const* undigested_links;
    std::uint64_t ledger_bytes;
    bool wide;
    std::uint32_t guard_words;        ///< 0: the store is not guarded
    std::size_t hot_stride;           ///< words
    Arena const* hot;
    Arena* items;                     ///< by states
    std::size_t* strides;             ///< by states, words
    std::uint32_t* capacities;        ///< by states
    std::uint32_t* link_capacities;
    void const* shareds;              ///< the tuple of the broadcasts

    /// Throws Error for a grid that no machine has, or that this machine has not.
    void require_grid() const;
    /// Makes the arenas of items and the capacities, and fills guards and poison.
    void make() const;

    machine::Place place(std::uint32_t state, std::uint32_t tile) const noexcept
    {
        auto const& x = states[state];
        auto* const head = hot->data() + std::size_t{tile} * hot_stride + x.hot_offset;
        if (x.small) return {nullptr, head, 1};
        auto* const own = items[state].data() + std::size_t{tile} * strides[state] + guard_words;
        if (x.list) return {head, own, capacities[state]};
        return {nullptr, own, 1};
    }
    /// The words of an item of a list in the form in use.
    std::uint32_t item_words(std::uint32_t state) const noexcept { return states[state].item_words[wide ? 1 : 0]; }
    /// The words of a state in its arena; of a list those of all slots with which the store was built.
    std::size_t region_words(std::uint32_t state) const noexcept
    {
        return states[state].list ? std::size_t{slots[state]} * item_words(state) : states[state].words;
    }
    /// The words of a state as one piece, including a list's head.
    std::size_t words(std::uint32_t state) const noexcept { return (states[state].list ? 2 : 0) + region_words(state); }
    /// The live words of a tile's state.
    std::size_t live_words(std::uint32_t state, machine::Place const& at) const noexcept
    {
        return states[state].list ? std::size_t{at.head[0]} * item_words(state) : states[state].words;
    }
    bool gets_slots_by_limit(std::uint32_t link) const noexcept { return link_sizes[link].slots == dynamic_capacity; }
    /// Bytes of an end of a channel with n slots and its head, on the machine.
    std::uint32_t end_bytes(std::uint32_t link, std::uint32_t n) const noexcept { return 8 + n * link_sizes[link].message_bytes; }

    /// Do the guard words around a tile's regions hold, and is no size above its capacity?
    bool guards_hold(std::uint32_t tile) const noexcept;
    /// A digest of all live words of a tile's states. Items beyond a list's size do not count.
    std::uint64_t digest_states(std::uint32_t tile) const noexcept;
    /// Mixes the mail of one end of a channel into a digest.
    std::uint64_t mix_mail(std::uint64_t h, std::uint32_t link, machine::Place const& end) const noexcept;
    /// The bytes of SRAM on a tile with the present capacities. Channels that share one memory count as the largest of them.
    std::uint64_t sram_bytes() const noexcept;

    void limit_state(std::uint32_t state, std::uint32_t items_at_most) const;
    /// Gives each end of a channel at most `at_most` slots. `unread`: has any tile unread mail of this channel? Throws Error if so, if the
    /// layout has fewer slots, or if the tile would then need more than its SRAM.
    void limit_link(std::uint32_t link, std::uint32_t at_most, bool unread) const;
    /// Throws Error for a channel without slots.
    void require_capacities() const;

    /// The bytes that the compile-time exchange after a kernel moves from a tile to a neighbour, if every channel has that side.
    std::uint32_t capacity_a_side(KernelFacts const& kernel) const noexcept;
    /// By sides: the bytes that `capacity_a_side` counts but the exchange does not move, because a channel does not send to that side.
    std::array<std::uint32_t, 4> absent_a_side(KernelFacts const& kernel) const noexcept;
    /// The bytes that this exchange moves on all sides of all tiles.
    std::uint64_t capacity_bytes(KernelFacts const& kernel) const noexcept;
};

}}} // namespace tilemesh::engine

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/engine/detail/store_view_code.hpp>
#endif
