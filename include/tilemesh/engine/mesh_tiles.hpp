#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <tilemesh/engine/contract.hpp>
#include <tilemesh/engine/mesh_core.hpp>
#include <tilemesh/engine/store.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/machine/run_kernel.hpp>
#include <type_traits>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace engine {

/// Runs the kernels of a program on the tiles of a Mesh: all that a mesh does in a superstep with the types of the program. Channels, threads
/// and the superstep itself are in MeshCore. `Traced`: may the mesh keep a trace?
template <class Program, bool Traced>
class MeshTiles : public TileStore<Program, false>, protected MeshCore {
    using Base = TileStore<Program, false>;

public:
    using typename Base::Links;
    using typename Base::Sizes;
    using typename Base::States;

protected:
    MeshTiles(Program const& program, Grid grid, Sizes const& sizes, std::uint32_t threads)
        : Base(program, grid, sizes), MeshCore(this->view(), threads)
    {
    }

    static constexpr std::uint32_t links = Links::count + 1;
    /// The `source` argument of run_kernel: it finds the states, channel ends and broadcasts of a tile.
    struct Source {
        MeshTiles& mesh;
        WorkerState& me;
        detail::TileSet* mail;                      ///< those of `me`
        std::uint32_t *state_peak, *link_peak;
        std::array<Ends, links> const links_now;
        std::uint32_t const* slots;                         ///< places at which neighbours read this tile's four outgoing ends
        std::uint32_t tile;
        Worker share;
        bool const keeps_samples; ///< does the run keep a trace?
        std::array<std::array<std::uint32_t*, 4>, links> next{}; ///< where the messages of this tile go, by channel and side
        /// The place at which the messages that this tile sends towards d are read.
        template <class C>
        TILEMESH_KERNEL std::uint32_t slot(Direction d) const noexcept
        {
            if constexpr (C::edge == Edge::reflect)
                return slots[index(d)];
            else
                return mesh.template slot<C>(tile, d);
        }
        template <class X>
        TILEMESH_KERNEL machine::Place state() noexcept
        {
            return mesh.template state_place<X>(tile);
        }
        template <class C>
        TILEMESH_KERNEL machine::Place in(Direction d) noexcept
        {
            return links_now[Base::template index_of_link<C>].in(4 * tile + index(d));
        }
        template <class C>
        TILEMESH_KERNEL machine::Place out(Direction d) noexcept
        {
            constexpr auto l = Base::template index_of_link<C>;
            return {links_now[l].out_head(slot<C>(d)), next[l][index(d)], links_now[l].capacity};
        }
        template <class P>
        TILEMESH_KERNEL P const* shared() noexcept
        {
            return mesh.Base::template shared<P>();
        }
        /// The bytes that an end of C with n messages takes on the machine.
        template <class C>
        std::uint32_t end_bytes(std::uint32_t n) const noexcept
        {
            return mesh.template end_bytes<C>(n);
        }
        TILEMESH_KERNEL Here here() noexcept { return {mesh.grid_.tile(tile), mesh.grid_}; }
        TILEMESH_KERNEL Worker worker() noexcept { return share; }
    };

    template <class C>
    TILEMESH_KERNEL std::uint32_t slot(std::uint32_t tile, Direction d) const noexcept
    {
        return MeshCore::slot(C::edge, tile, d);
    }

    // --- one tile -------------------------------------------------------------------------------------------------------
    template <class Kernel>
    TILEMESH_KERNEL void run_tile(Source& source, std::uint32_t tile) noexcept
    {
        source.tile = tile;
        source.slots = this->slots_.data() + 4 * std::size_t{tile};
        using AllWorkers = AllWorkersOf<Kernel>;
        if constexpr (AllWorkers::exists) {
            source.share = {0, this->sizes_.machine.workers};
            (void)run_kernel<typename AllWorkers::type>(source);
        } else if constexpr (KernelTraits<Kernel>::multi_worker) { // one host thread does the shares of all of the tile's workers
            for (std::uint32_t w = 0; w < this->sizes_.machine.workers; ++w) {
                source.share = {w, this->sizes_.machine.workers};
                (void)run_kernel<Kernel>(source);
            }
        } else if (run_kernel<Kernel>(source) == Vote::busy) {
            source.me.busy.insert(tile);
        }
        if constexpr (Traced)
            if (source.keeps_samples) [[unlikely]] keep_sample<Kernel>(source);
        after_kernel(source, typename KernelTraits<Kernel>::Arguments{});
    }
    template <class Kernel>
    [[gnu::noinline, gnu::cold]] static void keep_sample(Source& source) noexcept
    {
        try {
            source.me.samples.push_back(sample<Kernel>(source, source.tile));
        } catch (...) { // out of memory, perhaps on a helper thread: the superstep rethrows it
            source.me.thrown = std::current_exception();
        }
    }
    template <class... A>
    TILEMESH_KERNEL void after_kernel(Source& source, machine::Types<A...>) noexcept
    {
        (after(source, static_cast<std::remove_reference_t<A>*>(nullptr)), ...);
    }
    template <class X>
    TILEMESH_KERNEL void after([[maybe_unused]] Source& source, X*) noexcept
    {
        if constexpr (is_list<X> && !std::is_const_v<X>) {
            auto& peak = source.state_peak[Base::template index_of_state<X>];
            peak = std::max(peak, source.template state<X>().head[0]);
        }
    }
    template <class C>
    TILEMESH_KERNEL void after(Source& source, In<C>*) noexcept // mail is read once
    {
        auto* const heads = source.template in<C>(news[0]).head; // the heads of the four sides are contiguous
        std::uint32_t any = 0;
        for (std::uint32_t i = 0; i < 4; ++i) any |= heads[Ends::head_words * i] | heads[Ends::head_words * i + 1];
        if (any == 0) return;
        for (std::uint32_t i = 0; i < 4; ++i) heads[Ends::head_words * i] = heads[Ends::head_words * i + 1] = 0;
    }
    template <class C>
    TILEMESH_KERNEL void after(Source& source, Out<C>*) noexcept
    {
        constexpr auto l = Base::template index_of_link<C>;
        auto& me = source.me;
        for (Direction d : news) {
            if constexpr (C::sends_to != Sides::all)
                if (!contains(C::sends_to, d)) continue;
            auto const [head, items, capacity] = source.template out<C>(d);
            auto const n = head[0];
            if ((n | head[1]) == 0) continue;
            std::memcpy(head + 2, &items, sizeof items);
            if constexpr (C::edge == Edge::drop)
                if (source.template slot<C>(d) >= 4 * this->grid_.size()) {
                    source.link_peak[l] = std::max(source.link_peak[l], n);
                    head[0] = head[1] = 0;
                    continue;
                }
            source.next[l][index(d)] += std::size_t{n} * C::Sender::item_words;
            source.mail[l].insert(source.template slot<C>(d) / 4);
            me.messages += n;
            me.live_bytes += std::uint64_t{n} * this->template message_bytes<C>();
            source.link_peak[l] = std::max(source.link_peak[l], n);
        }
    }
    /// Prefetches the words that say where a tile's words are. On a grid larger than the caches they come from memory.
    template <class... A>
    TILEMESH_KERNEL void prefetch_heads([[maybe_unused]] Source const& source, [[maybe_unused]] std::uint32_t tile,
                                        machine::Types<A...>) const noexcept
    {
        (prefetch_head(source, tile, static_cast<std::remove_reference_t<A>*>(nullptr)), ...);
    }
    template <class X>
    TILEMESH_KERNEL void prefetch_head(Source const&, std::uint32_t, X*) const noexcept
    {
    }
    template <class C>
    TILEMESH_KERNEL void prefetch_head(Source const& source, std::uint32_t tile, In<C>*) const noexcept
    {
        __builtin_prefetch(source.links_now[Base::template index_of_link<C>].in(4 * tile).head, 1);
        __builtin_prefetch(this->hot(tile), 1);
    }
    template <class C>
    TILEMESH_KERNEL void prefetch_head(Source const&, [[maybe_unused]] std::uint32_t tile, Out<C>*) const noexcept
    {
        if constexpr (C::edge == Edge::reflect) __builtin_prefetch(slots_.data() + 4 * std::size_t{tile});
    }
    /// Prefetches the words of a tile that will run soon. If it has mail, its channel ends are far apart in memory.
    template <class... A>
    TILEMESH_KERNEL void prefetch([[maybe_unused]] Source const& source, [[maybe_unused]] std::uint32_t tile,
                                  machine::Types<A...>) const noexcept
    {
        [[maybe_unused]] bool mail = false;
        (prefetch_argument(source, tile, mail, static_cast<std::remove_reference_t<A>*>(nullptr)), ...);
    }
    template <class X>
    TILEMESH_KERNEL void prefetch_argument(Source const&, std::uint32_t, bool&, X*) const noexcept
    {
    }
    /// Prefetches the beginnings of a tile's lists, for a kernel that works only on lists. The processor continues from there.
    template <class... A>
    TILEMESH_KERNEL void prefetch_lists([[maybe_unused]] std::uint32_t tile, machine::Types<A...>) noexcept
    {
        (prefetch_list(tile, static_cast<std::remove_cv_t<std::remove_reference_t<A>>*>(nullptr)), ...);
    }
    template <class X>
    TILEMESH_KERNEL void prefetch_list([[maybe_unused]] std::uint32_t tile, X*) noexcept
    {
        if constexpr (is_list<X>) {
            auto const* const items = this->template state_place<X>(tile).items;
            for (std::uint32_t line = 0; line < 4; ++line) __builtin_prefetch(items + 16 * line);
        }
    }
    template <class C>
    TILEMESH_KERNEL void prefetch_argument(Source const& source, std::uint32_t tile, bool& mail, In<C>*) const noexcept
    {
        auto const& ends = source.links_now[Base::template index_of_link<C>];
        for (Direction d : news) {
            auto const p = ends.in(4 * tile + index(d));
            if (p.head[0] == 0) continue;
            mail = true;
            __builtin_prefetch(p.items);
            __builtin_prefetch(p.items + 16);
        }
    }
    template <class C>
    TILEMESH_KERNEL void prefetch_argument(Source const& source, std::uint32_t tile, bool& mail, Out<C>*) const noexcept
    {
        if (!mail) return;
        auto const& ends = source.links_now[Base::template index_of_link<C>];
        for (Direction d : news) __builtin_prefetch(ends.out_head(slot<C>(tile, d)), 1);
    }

    using Piece = MeshCore::Piece;
    template <class... A>
    TILEMESH_KERNEL void begin_piece([[maybe_unused]] Source& source, [[maybe_unused]] Piece const& piece, machine::Types<A...>) noexcept
    {
        (begin_stream(source, piece, static_cast<std::remove_reference_t<A>*>(nullptr)), ...);
    }
    template <class X>
    TILEMESH_KERNEL void begin_stream(Source&, Piece const&, X*) noexcept
    {
    }
    template <class C>
    TILEMESH_KERNEL void begin_stream(Source& source, Piece const& piece, Out<C>*) noexcept
    {
        constexpr auto l = Base::template index_of_link<C>;
        source.next[l] = MeshCore::begin_stream(l, piece, this->grid_.size(), source.next[l]); // by value: `source` stays in registers
    }

    template <std::uint32_t... L>
    TILEMESH_KERNEL std::array<Ends, links> all_ends(std::integer_sequence<std::uint32_t, L...>) const noexcept
    {
        return {{MeshCore::ends(L)..., Ends{}}}; // not a loop: a compiler would leave the array in memory
    }
    /// Runs worker w's part of the n tiles: the listed tiles, or all tiles without a list.
    template <class Kernel>
    static void run_tiles(void* mesh, std::uint32_t w, std::uint32_t const* tiles, std::uint32_t n, bool together) noexcept
    {
        using Arguments = typename KernelTraits<Kernel>::Arguments;
        auto& self = *static_cast<MeshTiles*>(mesh);
        auto& me = self.workers_[w];
        detail::BrokenContracts broken;
        detail::tilemesh_broken_contracts = &broken;
        auto* const peaks = me.state_peaks();
        Source source{self, me, me.mail.data(), peaks, peaks + States::count,
                      self.all_ends(std::make_integer_sequence<std::uint32_t, Links::count>{}), nullptr, 0, {0, 1}, self.keeps_trace(), {}};
        std::uint32_t first = 0, last = n;
        bool begins = me.exchange != self.exchange_;
        for (bool more = together ? self.shares_.take(w, first, last) : n != 0; more; more = together && self.shares_.take(w, first, last)) {
            self.begin_piece(source, {w, tiles == nullptr ? first : tiles[first], last - first, std::exchange(begins, false)}, Arguments{});
            for (auto i = first; i < last; ++i) {
                if (i + 4 < last) self.prefetch_heads(source, tiles == nullptr ? i + 4 : tiles[i + 4], Arguments{});
                if (i + 2 < last) self.prefetch(source, tiles == nullptr ? i + 2 : tiles[i + 2], Arguments{});
                if constexpr (KernelTraits<Kernel>::Links::count == 0)
                    if (i + 1 < last) self.prefetch_lists(tiles == nullptr ? i + 1 : tiles[i + 1], Arguments{});
                auto const tile = tiles == nullptr ? i : tiles[i];
                self.template run_tile<Kernel>(source, tile);
                if (broken.count != 0) [[unlikely]] {
                    me.failure.add({tile, broken.first, broken.count});
                    broken = {};
                }
            }
            me.runs += last - first;
        }
        if (!begins) { // another run may follow before the exchange; a thread that took no piece has not begun
            me.exchange = self.exchange_;
            self.begin_piece(source, {w, 0, 0, false}, Arguments{});
        }
        detail::tilemesh_broken_contracts = nullptr; // the next function on this thread may not be a kernel
    }

    template <class... Step>
    static RunTiles const* runs_of(machine::Types<Step...>) noexcept
    {
        static constexpr RunTiles all[] = {run_tiles<KernelOf<Step>>..., nullptr};
        return all;
    }
    Steps steps() noexcept { return {&program_facts<Program>, runs_of(StepsOf<Program>{}), this}; }
    bool keeps_trace() const noexcept
    {
        if constexpr (Traced)
            return run_.trace != nullptr;
        else
            return false;
    }
    RunState run_;
};

}}} // namespace tilemesh::engine
