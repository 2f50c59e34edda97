#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/engine/arena.hpp>
#include <tilemesh/engine/facts.hpp>
#include <tilemesh/engine/mesh_sizes.hpp>
#include <tilemesh/engine/store_view.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/either.hpp>
#include <tilemesh/machine/operations.hpp>
#include <tilemesh/machine/tile.hpp>
#include <tuple>
#include <type_traits>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace engine {

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
        view().require_grid();
        if constexpr (StepTraits<Program>::has_grid) expect_grid(program_, grid);
        hot_ = Arena(std::size_t{grid.size()} * hot_stride);
        capacity_ = sizes_.slots;
        view().make();
    }

    MachineSize const& machine() const noexcept { return sizes_.machine; }
    Grid grid() const noexcept { return grid_; }
    /// The program, whose counts (passes of a step, rounds of a Loop) may be changed between runs.
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
    std::uint64_t sram_bytes() const noexcept { return view().sram_bytes(); }

    /// The store without the types of its program.
    StoreView view() const noexcept
    {
        auto& own = const_cast<TileStore&>(*this); // the view of a const store is read alone
        return {state_table<Program, Guarded>.at, States::count, link_table<Program>.at, Links::count, grid_, &sizes_.machine, sizes_.slots.data(),
                sizes_.links.data(), sizes_.shares_memory.data(), sizes_.undigested.data(), sizes_.undigested_links.data(), sizes_.sram_bytes,
                sizes_.wide, guard_words, hot_stride, &hot_, own.items_.data(), own.stride_.data(), own.capacity_.data(),
                own.link_capacity_.data(), &shared_};
    }

    TILEMESH_KERNEL TileId tile(std::uint32_t i) const noexcept { return grid_.tile(i); }

    template <class X>
    TILEMESH_KERNEL machine::Place state_place(std::uint32_t tile) noexcept
    {
        constexpr auto i = index_of_state<X>;
        auto* const hot = hot_.data() + std::size_t{tile} * hot_stride + state_table<Program, Guarded>.at[i].hot_offset;
        if constexpr (is_list<X>)
            return {hot, items_[i].data() + std::size_t{tile} * stride_[i] + guard_words, capacity_[i]};
        else if constexpr (detail::lies_hot<X>)
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
    auto const& shareds() const noexcept { return shared_; }
    static constexpr std::uint32_t guard_words = Guarded ? guard_words_around : 0;
    static constexpr std::uint32_t hot_stride = (state_table<Program, Guarded>.hot_words + 15u) & ~15u;

    template <class X>
    static constexpr std::uint32_t find_state() noexcept
    {
        static_assert(machine::contains<X, States>, "no kernel of this program keeps this state");
        return machine::index_in<X>(States{});
    }
    template <class C>
    static constexpr std::uint32_t find_link() noexcept
    {
        static_assert(machine::contains<C, Links>, "no kernel of this program uses this channel");
        return machine::index_in<C>(Links{});
    }
    template <class X>
    static constexpr std::uint32_t index_of_state = find_state<X>();
    template <class C>
    static constexpr std::uint32_t index_of_link = find_link<C>();
    template <class C>
    std::uint32_t link_capacity() const noexcept
    {
        return link_capacity_[index_of_link<C>];
    }

    /// The bytes of a message of C on the machine. `end_bytes` are the bytes of an end of C with n slots and its head.
    template <class C>
    TILEMESH_KERNEL std::uint32_t message_bytes() const noexcept
    {
        return sizes_.links[index_of_link<C>].message_bytes;
    }
    template <class C>
    TILEMESH_KERNEL std::uint32_t end_bytes(std::uint32_t n) const noexcept
    {
        return 8 + n * message_bytes<C>();
    }
    /// The words of state X as one piece, including its head.
    template <class X>
    std::size_t words() const noexcept
    {
        return view().words(index_of_state<X>);
    }
    /// The heads and small structs of a tile.
    TILEMESH_KERNEL std::uint32_t const* hot(std::uint32_t tile) const noexcept
    {
        return hot_.data() + std::size_t{tile} * hot_stride;
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
};

}}} // namespace tilemesh::engine
