#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <tilemesh/engine/arena.hpp>
#include <tilemesh/engine/contract.hpp>
#include <tilemesh/engine/digest.hpp>
#include <tilemesh/engine/mesh_sizes.hpp>
#include <tilemesh/engine/rectangle.hpp>
#include <tilemesh/engine/text.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/either.hpp>
#include <tilemesh/machine/operations.hpp>
#include <tilemesh/machine/tile.hpp>
#include <tuple>
#include <type_traits>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace engine {

/// Guard words, which no kernel may touch, surround each region of a guarded store. Dead words are filled with the poison word: as a float
/// it is a NaN, as an index it is out of range.
inline constexpr std::uint32_t guard_word = 0x7fa0beefu;
inline constexpr std::uint32_t poison_word = 0x7fa0dead;

/// A tile and its state X: a reference to a struct, or a view of a Buffer. X is const for a const mesh.
template <class X>
struct TileState {
    TileId tile;
    std::conditional_t<is_list<std::remove_const_t<X>>, X, X&> state;
};

/// The states X of all tiles of a store, row by row.
template <class Store, class X>
class StateRange {
public:
    class Iterator {
    public:
        using value_type = TileState<X>;
        using difference_type = std::ptrdiff_t;
        Iterator() = default;
        Iterator(Store* store, std::uint32_t i) noexcept : store_(store), i_(i) {}
        TileState<X> operator*() const noexcept
        {
            auto const tile = store_->grid().tile(i_);
            return {tile, store_->template state<std::remove_const_t<X>>(tile)};
        }
        Iterator& operator++() noexcept
        {
            ++i_;
            return *this;
        }
        Iterator operator++(int) noexcept { return {store_, i_++}; }
        friend bool operator==(Iterator const& a, Iterator const& b) noexcept { return a.i_ == b.i_; }

    private:
        Store* store_ = nullptr;
        std::uint32_t i_ = 0;
    };
    explicit StateRange(Store& store) noexcept : StateRange(store, 0, store.grid().size()) {}
    /// The states of tiles first..last-1.
    StateRange(Store& store, std::uint32_t first, std::uint32_t last) noexcept : store_(&store), first_(first), last_(last) {}
    Iterator begin() const noexcept { return {store_, first_}; }
    Iterator end() const noexcept { return {store_, last_}; }

private:
    Store* store_;
    std::uint32_t first_, last_;
};

/// Throws Error if a part of the program has the counts of another grid than that of the mesh.
template <class... Step>
void expect_grid(SequenceOn<Step...> const& part, Grid grid)
{
    if (part.grid.width != grid.width || part.grid.height != grid.height)
        throw Error("a part of the program for a grid of " + std::to_string(part.grid.width) + " x " + std::to_string(part.grid.height) +
                    " tiles (the mesh has " + std::to_string(grid.width) + " x " + std::to_string(grid.height) +
                    "); give reduce_on the grid of the mesh");
}
template <class Part>
void expect_grid(Part const& part, Grid grid)
{
    if constexpr (StepTraits<Part>::has_grid)
        std::apply([&](auto const&... inner) { (expect_grid(inner, grid), ...); }, part.steps);
}

/// The words of all tiles' states and broadcasts. All engines derive from this class. `Guarded` puts guard words around every region.
///
/// The heads of lists and the small structs of a tile lie together in `hot`, so a tile with little work uses one or two cache lines. Items
/// and large structs lie in one arena per region, which takes host memory only for live words.
template <class Program, bool Guarded>
class TileStore {
public:
    using Sizes = MeshSizes<Program>;
    using States = typename machine::Needs<Program>::States;
    using Links = typename machine::Needs<Program>::Links;
    using Shareds = typename machine::Needs<Program>::Shareds;

    static_assert(operations_fit(StepsOf<Program>{}));

    TileStore(Program program, Grid grid, Sizes const& sizes) : program_(program), grid_(grid), sizes_(sizes)
    {
        auto const& machine = sizes_.machine;
        if (grid.width == 0 || grid.height == 0 || grid.width > 65535 || grid.height > 65535)
            throw Error("a grid of " + std::to_string(grid.width) + " x " + std::to_string(grid.height) +
                        " tiles (each side is 1 to 65,535); choose another");
        if (grid.size() > machine.tiles)
            throw Error("a grid of " + std::to_string(grid.width) + " x " + std::to_string(grid.height) + " = " +
                        std::to_string(grid.size()) + " tiles (" + machine.name + " has " + std::to_string(machine.tiles) +
                        "); choose a smaller grid, larger tiles or another machine");
        if constexpr (StepTraits<Program>::has_grid) expect_grid(program_, grid);
        hot_ = Arena(std::size_t{grid.size()} * hot_stride);
        capacity_ = sizes_.slots;
        make(States{});
        set_capacities(Links{});
        guard_all(States{});
    }

    MachineSize const& machine() const noexcept { return sizes_.machine; }
    Grid grid() const noexcept { return grid_; }
    Program& program() noexcept { return program_; }

    /// Tile t's state X: a reference to a struct, or a view of a Buffer. Call it only between runs, or from an observer.
    template <class X>
    decltype(auto) state(TileId t) noexcept
    {
        auto const place = state_place<X>(grid_.index_of(t));
        if constexpr (is_list<X>)
            return X{place};
        else
            return static_cast<X&>(*reinterpret_cast<X*>(place.items));
    }
    /// Tile t's state X, read only.
    template <class X>
    decltype(auto) state(TileId t) const noexcept
    {
        auto const place = const_cast<TileStore*>(this)->template state_place<X>(grid_.index_of(t));
        if constexpr (is_list<X>) {
            X const view{place};
            return view;
        } else {
            return static_cast<X const&>(*reinterpret_cast<X const*>(place.items));
        }
    }
    /// The states X of all tiles, row by row: `for (auto [tile, cell] : mesh.states<Cell>()) cell.kelvin = 300;`. For a Buffer, the second
    /// name is a view of the tile's list. Call it only between runs, or from an observer.
    template <class X>
    StateRange<TileStore, X> states() noexcept
    {
        return StateRange<TileStore, X>{*this};
    }
    template <class X>
    StateRange<TileStore const, X const> states() const noexcept
    {
        return StateRange<TileStore const, X const>{*this};
    }
    /// The broadcast P that every tile holds in the next run. The host may change it between runs.
    template <class P>
    P& broadcast() noexcept
    {
        return std::get<P>(shared_);
    }

    /// The bytes of SRAM on a tile with the present capacities, including dynamic channels.
    std::uint64_t sram_bytes() const noexcept { return sram_bytes(Links{}); }

    TILEMESH_KERNEL TileId tile(std::uint32_t i) const noexcept { return grid_.tile(i); }

    template <class X>
    TILEMESH_KERNEL machine::Place state_place(std::uint32_t tile) noexcept
    {
        auto* const hot = hot_.data() + std::size_t{tile} * hot_stride + hot_offset<X>();
        constexpr auto i = index_of_state<X>();
        if constexpr (is_list<X>)
            return {hot, items_[i].data() + std::size_t{tile} * stride_[i] + guard_words, capacity_[i]};
        else if constexpr (is_small<X>)
            return {nullptr, hot, 1};
        else
            return {nullptr, items_[i].data() + std::size_t{tile} * stride_[i] + guard_words, 1};
    }
    template <class P>
    TILEMESH_KERNEL P const* shared() const noexcept
    {
        return &std::get<P>(shared_);
    }

protected:
    static constexpr std::uint32_t guard_words = Guarded ? 4 : 0;
    template <class X>
    static constexpr bool is_small = !is_list<X> && sizeof(X) <= 64;

    template <class X>
    static constexpr std::uint32_t index_of_state() noexcept
    {
        static_assert(machine::contains<X, States>, "no kernel of this program keeps this state");
        return machine::index_in<X>(States{});
    }
    template <class C>
    static constexpr std::uint32_t index_of_link() noexcept
    {
        static_assert(machine::contains<C, Links>, "no kernel of this program uses this channel");
        return machine::index_in<C>(Links{});
    }
    template <class C>
    std::uint32_t link_capacity() const noexcept
    {
        return link_capacity_[index_of_link<C>()];
    }

    template <class X>
    void limit_state(std::uint32_t items)
    {
        auto& capacity = capacity_[index_of_state<X>()];
        check_limit(name_of<X>(), items, most_slots<X>());
        for (std::uint32_t i = 0; i < grid_.size(); ++i)
            if (state_place<X>(i).head[0] > items)
                throw Error("a limit of " + std::to_string(items) + " items for " + text(name_of<X>()) + " (tile " +
                            text(grid_.tile(i)) + " holds " + std::to_string(state_place<X>(i).head[0]) +
                            "); set limits before the mesh is loaded");
        capacity = items;
    }
    /// Limits channel C to `items` slots. `unread`: does the channel carry mail on any tile? Throws Error if it does, and for slots that do
    /// not fit.
    template <class C>
    void limit_link(std::uint32_t items, bool unread)
    {
        if (unread)
            throw Error("new slots for channel " + text(name_of<C>()) +
                        " (it carries mail of the last run); set limits before the first run");
        if (!gets_slots_by_limit<C>()) check_limit(name_of<C>(), items, most_slots<C>());
        auto const before = std::exchange(link_capacity_[index_of_link<C>()], items);
        if (sram_bytes() > sizes_.machine.sram_bytes) {
            auto const over = sram_bytes() - sizes_.machine.sram_bytes;
            link_capacity_[index_of_link<C>()] = before;
            throw Error("channel " + text(name_of<C>()) + " with " + std::to_string(items) + " slots (the program is then " +
                        std::to_string(over) + " bytes over a tile's SRAM); give it fewer slots");
        }
    }
    /// The bytes that the compile-time exchange after kernel K moves from a tile to a neighbour, if every channel has that side.
    template <class K, class... C>
    std::uint32_t capacity_a_side(machine::Types<C...>) const noexcept
    {
        return (0u + ... + (KernelTraits<K>::template writes<C> ? end_bytes<C>(link_capacity<C>()) : 0u));
    }
    /// The part of these bytes that it does not move to each side, because channels lack it.
    template <class K, class... C>
    std::array<std::uint32_t, 4> absent_a_side(machine::Types<C...>) const noexcept
    {
        std::array<std::uint32_t, 4> bytes{};
        [[maybe_unused]] auto const add = [&](auto tag) {
            using L = typename decltype(tag)::type;
            if constexpr (KernelTraits<K>::template writes<L> && L::sends_to != Sides::all)
                for (Direction d : news)
                    if (!contains(L::sends_to, d)) bytes[index(d)] += end_bytes<L>(link_capacity<L>());
        };
        (add(machine::Tag<C>{}), ...);
        return bytes;
    }
    /// The bytes that this exchange moves on all sides of all tiles.
    template <class K, class... C>
    std::uint64_t capacity_bytes(machine::Types<C...>) const noexcept
    {
        return (std::uint64_t{0} + ... + (KernelTraits<K>::template writes<C> ? sides<C>() * end_bytes<C>(link_capacity<C>()) : 0u));
    }
    /// The number of sides of tiles from which the exchange moves channel C.
    template <class C>
    std::uint64_t sides() const noexcept
    {
        std::uint64_t sides = 0;
        for (Direction d : news)
            if (contains(C::sends_to, d))
                sides += grid_.size() - (C::edge == Edge::drop ? without_reader<C>(d) : 0);
        return sides;
    }
    /// The number of tiles that are too near to the grid's edge on side d for a reader of channel C.
    template <class C>
    std::uint64_t without_reader(Direction d) const noexcept
    {
        bool const column = d == Direction::north || d == Direction::south;
        return std::uint64_t{column ? grid_.width : grid_.height} * std::min(C::distance, column ? grid_.height : grid_.width);
    }
    /// The bytes of a message of C on the machine. `end_bytes` are the bytes of an end of C with n slots and its head.
    template <class C>
    TILEMESH_KERNEL std::uint32_t message_bytes() const noexcept
    {
        return sizes_.links[index_of_link<C>()].message_bytes;
    }
    template <class C>
    TILEMESH_KERNEL std::uint32_t end_bytes(std::uint32_t n) const noexcept
    {
        return 8 + n * message_bytes<C>();
    }
    /// The words of an item of list X in the form in use.
    template <class X>
    std::uint32_t item_words() const noexcept
    {
        return machine::words_in_form<typename X::value_type>(sizes_.wide);
    }
    /// The words of state X as one piece, including its head.
    template <class X>
    std::size_t words() const noexcept
    {
        if constexpr (is_list<X>)
            return X::head_words + std::size_t{most_slots<X>()} * item_words<X>();
        else
            return sizeof(X) / 4;
    }
    /// The slots with which the mesh was built. The store has memory for them.
    template <class X>
    std::uint32_t most_slots() const noexcept
    {
        if constexpr (is_channel<X>)
            return sizes_.links[index_of_link<X>()].slots;
        else
            return sizes_.slots[index_of_state<X>()];
    }
    template <class C>
    bool gets_slots_by_limit() const noexcept
    {
        return most_slots<C>() == dynamic_capacity;
    }
    template <class... C>
    void require_capacities(machine::Types<C...>) const
    {
        (require_capacity<C>(), ...);
    }

    /// The heads and small structs of a tile.
    TILEMESH_KERNEL std::uint32_t const* hot(std::uint32_t tile) const noexcept
    {
        return hot_.data() + std::size_t{tile} * hot_stride;
    }

    /// A digest of all live words of tile i's states. Items beyond a list's size do not count.
    std::uint64_t digest_states(std::uint32_t tile) noexcept { return digest_states(tile, States{}); }

    template <class... X>
    std::uint64_t digest_states(std::uint32_t tile, machine::Types<X...>) noexcept
    {
        std::uint64_t h = tile;
        ((h = digest_state<X>(h, tile)), ...);
        return h;
    }
    template <class X>
    std::uint64_t digest_state(std::uint64_t h, std::uint32_t tile) noexcept
    {
        auto const p = state_place<X>(tile);
        std::uint32_t const out = sizes_.undigested[index_of_state<X>()];
        if (out == Sizes::no_digest) return h;
        if constexpr (is_list<X>) {
            h = mix(h, p.head[0]);
            if constexpr (has_whole_words<typename X::value_type>) return mix_items<typename X::value_type>(h, p);
            std::size_t const item = item_words<X>();
            if (out == 0) return mix_words(h, p.items, p.head[0] * item);
            for (std::uint32_t i = 0; i < p.head[0]; ++i) h = mix_words_on(h, p.items + i * item, item - out);
            return mix(h, p.head[0] * (item - out));
        } else {
            return mix_words(h, p.items, sizeof(X) / 4 - out);
        }
    }

    /// Mixes the items of a list into a digest, and the number of their words.
    template <class T>
    std::uint64_t mix_items(std::uint64_t h, machine::Place const& p) const noexcept
    {
        if constexpr (has_whole_words<T>) {
            auto const& by = shared_like<typename T::WholeBy>(Shareds{});
            for (std::uint32_t i = 0; i < p.head[0]; ++i) {
                auto const whole = reinterpret_cast<T const*>(p.items)[i].whole(by);
                std::uint32_t words[sizeof whole / 4];
                std::memcpy(words, &whole, sizeof whole);
                h = mix_words_on(h, words, sizeof whole / 4);
            }
            return mix(h, std::size_t{p.head[0]} * (sizeof(typename T::Whole) / 4));
        } else {
            return mix_words(h, p.items, std::size_t{p.head[0]} * (sizeof(T) / 4));
        }
    }
    /// The broadcast that is a B.
    template <class B, class First, class... P>
    B const& shared_like(machine::Types<First, P...>) const noexcept
    {
        if constexpr (std::is_base_of_v<B, First>)
            return std::get<First>(shared_);
        else
            return shared_like<B>(machine::Types<P...>{});
    }

    Program program_;
    Grid grid_;
    Sizes sizes_;
    std::array<std::size_t, States::count + 1> stride_{};
    std::array<std::uint32_t, Links::count + 1> link_capacity_{};
    std::array<std::uint32_t, States::count + 1> capacity_{};
    std::array<Arena, States::count + 1> items_;
    Arena hot_;

private:
    template <class>
    struct TupleOf;
    template <class... P>
    struct TupleOf<machine::Types<P...>> {
        using type = std::tuple<P...>;
    };
    typename TupleOf<Shareds>::type shared_{};

    /// The words of X among the heads and small structs of its tile. In a guarded store one guard word follows each.
    template <class X>
    static constexpr std::uint32_t hot_words() noexcept
    {
        if constexpr (is_list<X>)
            return 2 + (Guarded ? 1 : 0);
        else
            return is_small<X> ? sizeof(X) / 4 + (Guarded ? 1 : 0) : 0;
    }
    template <class... X>
    static constexpr std::uint32_t all_hot_words(machine::Types<X...>) noexcept
    {
        return (0u + ... + hot_words<X>());
    }
    template <class X, class... Y>
    static constexpr std::uint32_t hot_offset_in(machine::Types<Y...>) noexcept
    {
        std::uint32_t at = 0;
        bool found = false;
        ((found = found || std::is_same_v<X, Y>, at += found ? 0 : hot_words<Y>()), ...);
        return at;
    }
    template <class X>
    static constexpr std::uint32_t hot_offset() noexcept
    {
        return hot_offset_in<X>(States{});
    }
    template <class X>
    std::size_t stride() const noexcept // an odd number of cache lines, so that neighbours fall on different cache sets
    {
        return ((words<X>() + 2 * guard_words + 15u) & ~std::size_t{15}) | 16u;
    }

protected:
    static constexpr std::uint32_t hot_stride = (all_hot_words(States{}) + 15u) & ~15u;

    template <class... X>
    bool guards_hold([[maybe_unused]] std::uint32_t tile, machine::Types<X...>) noexcept
    {
        return (guard_holds<X>(tile) && ...);
    }
    template <class X>
    bool guard_holds(std::uint32_t tile) noexcept
    {
        auto const p = state_place<X>(tile);
        bool ok = true;
        if constexpr (is_list<X>) {
            ok = p.head[2] == guard_word && p.head[0] <= p.capacity;
        } else if constexpr (is_small<X>) {
            return p.items[sizeof(X) / 4] == guard_word;
        }
        auto const words = item_words_of<X>();
        for (std::size_t i = 0; i < guard_words; ++i)
            ok = ok && p.items[words + i] == guard_word && (p.items - guard_words)[i] == guard_word;
        return ok;
    }
    template <class X>
    std::size_t item_words_of() const noexcept
    {
        if constexpr (is_list<X>)
            return std::size_t{most_slots<X>()} * item_words<X>();
        else
            return sizeof(X) / 4;
    }

private:
    template <class... X>
    void guard_all(machine::Types<X...>)
    {
        if constexpr (Guarded) (guard<X>(), ...);
    }
    template <class X>
    void guard()
    {
        constexpr std::size_t poisoned_at_once = std::size_t{64} << 18; // words: 64 MiB; in a larger region only dead words are poisoned
        bool const fill = is_list<X> && std::size_t{grid_.size()} * item_words_of<X>() <= poisoned_at_once;
        for (std::uint32_t i = 0; i < grid_.size(); ++i) {
            auto const p = state_place<X>(i);
            if constexpr (is_list<X>)
                p.head[2] = guard_word;
            else if constexpr (is_small<X>) {
                p.items[sizeof(X) / 4] = guard_word;
                continue;
            }
            for (std::uint32_t g = 0; g < guard_words; ++g)
                (p.items - guard_words)[g] = p.items[item_words_of<X>() + g] = guard_word;
            if (fill) std::fill(p.items, p.items + item_words_of<X>(), poison_word);
        }
    }
    template <class... X>
    void make(machine::Types<X...>)
    {
        (make_one<X>(), ...);
    }
    template <class X>
    void make_one()
    {
        constexpr auto i = index_of_state<X>();
        auto slack = std::size_t{0}; // a guarded store has room for one item past the last region
        if constexpr (Guarded && is_list<X>) slack = item_words<X>();
        stride_[i] = stride<X>();
        if constexpr (!is_small<X>) items_[i] = Arena(std::uint64_t{grid_.size()} * stride_[i] + slack);
    }
    template <class... C>
    void set_capacities(machine::Types<C...>)
    {
        ((link_capacity_[index_of_link<C>()] = gets_slots_by_limit<C>() ? 0 : most_slots<C>()), ...);
    }
    /// Channels that share one memory count as the largest of them. A dynamic channel counts with its present capacity.
    template <class... C>
    std::uint64_t sram_bytes(machine::Types<C...>) const noexcept
    {
        std::array<std::uint64_t, Links::count + 1> now{}, built{}; // for each channel with its own memory
        [[maybe_unused]] auto const add = [&](auto tag) {
            using Link = typename decltype(tag)::type;
            constexpr auto l = index_of_link<Link>();
            auto const host = sizes_.shares_memory[l] ? index_of_link<MemoryOf<Link>>() : l;
            bool const dynamic = gets_slots_by_limit<Link>();
            auto const all_ends = [&](std::uint32_t slots) {
                return (std::uint64_t{ends_in<Link>} + ends_out<Link>) * message_bytes<Link>() * slots;
            };
            now[host] = std::max(now[host], all_ends(dynamic ? link_capacity<Link>() : most_slots<Link>()));
            built[host] = std::max(built[host], dynamic ? 0 : all_ends(most_slots<Link>()));
        };
        (add(machine::Tag<C>{}), ...);
        auto bytes = sizes_.sram_bytes;
        for (std::size_t l = 0; l < now.size(); ++l) bytes += now[l] - built[l];
        return bytes;
    }
    template <class C>
    void require_capacity() const
    {
        if (link_capacity<C>() != 0) return;
        auto const channel = "channel " + text(name_of<C>());
        if (gets_slots_by_limit<C>())
            throw Error(channel + " has no slots (its capacity is dynamic and was never set, or was limited to 0); call "
                                  "limit<Channel>(slots) before run()");
        throw Error(channel + " has no slots (the sizes of the mesh give it none, or it was limited to 0); give it at least one");
    }
    static void check_limit(machine::Name name, std::uint32_t items, std::uint32_t most)
    {
        if (items > most)
            throw Error("a limit of " + std::to_string(items) + " items for " + text(name) + " (the program's layout has " +
                        std::to_string(most) + "); choose a smaller limit or a program with more slots");
    }
};

}}} // namespace tilemesh::engine
