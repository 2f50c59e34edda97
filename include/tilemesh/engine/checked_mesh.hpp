#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <memory>
#include <string>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/engine/port.hpp>
#include <tilemesh/engine/quiet_change.hpp>
#include <tilemesh/engine/run.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// Options of a CheckedMesh.
struct CheckedMeshOptions {
    std::uint32_t threads = 1; ///< not used: this engine has one thread. So the options of a Mesh are also options of a CheckedMesh
    bool digest = false;
    /// Also runs the tiles that need not run, and checks that this changes no word and sends nothing. `Vote` promises this. Without the
    /// promise, a machine that runs every tile (the IPU) would give other results. If no tile must run an UntilQuiet's kernel, and its
    /// own votes said so, all tiles run once more for this check. A run in which no tile runs, because it begins with UntilQuiet and nobody
    /// has voted, is an error if a pass would have changed a word. Counters, traces and words are those of a run without the check.
    bool check_quiet_tiles = true;
    std::uint32_t most_passes = 0; ///< see MeshOptions
    ExplainNotQuiet explain = nullptr; ///< see MeshOptions
    bool trace = true; ///< see MeshOptions
};

/// The sequential engine, which checks every rule. It runs the tiles one by one in order. Incoming and outgoing ends of channels have
/// separate memory, and the exchange copies them. Guard words surround every region and channel end. Dead words are filled with a poison
/// that is a NaN as a float: items beyond a list's size, mail that was read, and (in regions of up to 64 MiB) slots that were never
/// written.
///
/// It has the members, counters, digests and pictures of Mesh. A multi-worker kernel is called once for each worker, the last worker first;
/// its `AllWorkers` is never called. In addition to Mesh's errors it reports: a write outside a region or channel, a size above its
/// capacity, a quiet tile that is not quiet, two channels that share memory and both carry mail, and a kernel of all workers that changes
/// the size of a list. Cost: about the live words of every tile, in each superstep.
template <class Program, class Machine = Mk2>
class CheckedMesh : public engine::TileStore<Program, true> {
    static_assert(is_machine<Machine>, "no machine (it has the members name, tiles, sram_bytes, code_bytes, workers and clock_khz, as "
                                       "Mk2 has); look for a misspelt one; a setup is not one: give its Machine");
    using Base = engine::TileStore<Program, true>;
    using Run = engine::Run<Program, is_traced<Machine>>;
    friend Run;

public:
    using typename Base::Links;
    using typename Base::States;
    using typename Base::Sizes;
    using Options = CheckedMeshOptions;

    /// A mesh of `Machine`, for a program whose lists all have the capacity that their types name.
    CheckedMesh(Program program, Grid grid, Options options = {})
        : CheckedMesh(program, grid, mesh_sizes<Program, Machine>(), options)
    {
    }
    /// The constructor above, with a value of type `Machine`, so that the compiler deduces it:
    /// `CheckedMesh mesh{program, Grid{8, 8}, Traced<Mk2>{}}`.
    template <std::same_as<Machine> M>
    CheckedMesh(Program program, Grid grid, M, Options options = {}) : CheckedMesh(program, grid, options)
    {
    }
    /// A mesh with the machine and the slots of `sizes`.
    template <std::same_as<Sizes> S>
    CheckedMesh(Program program, Grid grid, S const& sizes, Options options = {})
        : Base(program, grid, sizes), options_(options), rectangle_{0, 0, grid.width, grid.height}
    {
        if constexpr (traced)
            if (options.trace) run_.keep_trace();
        make_ends(Links{});
        busy_[0].assign(grid.size(), 0);
        busy_[1].assign(grid.size(), 0);
    }

    template <class X>
    void limit(std::uint32_t items)
    {
        if constexpr (is_channel<X>) {
            bool mail = false;
            for (std::uint32_t t = 0; t < this->grid_.size(); ++t) mail = mail || unread<X>(t);
            auto const before = this->template link_capacity<X>();
            this->template limit_link<X>(items, mail);
            try {
                make_end<X>();
            } catch (...) { // out of memory: the channel keeps its old capacity
                this->link_capacity_[Base::template index_of_link<X>()] = before;
                throw;
            }
        } else {
            this->template limit_state<X>(items);
        }
    }
    template <class C>
    typename C::Receiver incoming(TileId t, Direction d) noexcept
    {
        return typename C::Receiver{end<C>(in_, 4 * this->grid_.index_of(t) + index(d))};
    }
    /// See Mesh.
    template <class C>
    machine::Place incoming_place(std::uint32_t tile, Direction d) noexcept
    {
        return end<C>(in_, 4 * tile + index(d));
    }
    /// From now on Superstep and Repeat run only the tiles of columns x0 to x1 - 1 and rows y0 to y1 - 1, and those other tiles that voted
    /// busy or have mail for the kernel. Idle tiles outside cost nothing. The caller promises that on the other tiles the kernels would
    /// change no word, send nothing and vote quiet; CheckedMesh checks this. At first the rectangle is the whole grid. Throws Error for a
    /// rectangle that is not in the grid.
    void run_within(std::uint32_t x0, std::uint32_t y0, std::uint32_t x1, std::uint32_t y1)
    {
        rectangle_ = engine::checked_rectangle(this->grid_, {x0, y0, x1, y1});
    }

    void observe(Observer observer) { run_.observer = std::move(observer); }

    /// Calls f(0, 1): this engine has one thread.
    template <class F>
    void on_threads(F const& f)
    {
        f(0u, 1u);
    }

    /// See Mesh.
    Trace const& trace() const
    {
        static_assert(traced, "a mesh without a trace (its machine is not Traced); build it for Traced<Machine>");
        return run_.kept_trace();
    }

    RunCounters run()
    {
        this->require_capacities(Links{});
        state_peak_.fill(0);
        link_peak_.fill(0);
        for (auto& b : busy_) std::fill(b.begin(), b.end(), std::uint8_t{0});
        last_kernel_ = nullptr;
        would_run_.clear();
        auto counters = run_.all(*this, this->program_, this->grid_, {options_.most_passes, options_.digest, options_.explain}, [this] {
            return peaks();
        });
        if (last_kernel_ == nullptr && !would_run_.empty())
            throw Error("a run in which no tile ran (UntilQuiet runs the tiles that voted busy, and nobody had voted; another run of the kernel would "
                        "change a word); begin with Superstep<" + would_run_);
        return counters;
    }

private:
    static constexpr bool traced = is_traced<Machine>;

    std::vector<engine::Peak> peaks() const
    {
        return engine::list_peaks(States{}, Links{}, [&](auto tag) {
            using R = typename decltype(tag)::type;
            engine::Peak peak;
            if constexpr (is_channel<R>) {
                peak.items = link_peak_[Base::template index_of_link<R>()];
                peak.capacity = this->template link_capacity<R>();
            } else {
                peak.items = state_peak_[Base::template index_of_state<R>()];
                peak.capacity = this->capacity_[Base::template index_of_state<R>()];
            }
            return peak;
        });
    }
    static constexpr std::uint32_t links = Links::count + 1;
    static constexpr std::uint32_t guard_words = Base::guard_words;
    /// One side of a channel on all tiles: {size, note, most items ever written}, and guarded items for each slot.
    struct Ends {
        std::vector<std::array<std::uint32_t, 4>> heads;
        engine::Arena items;
        std::size_t stride = 0;
        std::uint32_t capacity = 0;
    };

    struct Source {
        CheckedMesh& mesh;
        std::uint32_t tile;
        Worker share;
        template <class X>
        machine::Place state() noexcept
        {
            return mesh.template state_place<X>(tile);
        }
        template <class C>
        machine::Place in(Direction d) noexcept
        {
            return mesh.template end<C>(mesh.in_, 4 * tile + index(d));
        }
        template <class C>
        machine::Place out(Direction d) noexcept
        {
            return mesh.template end<C>(mesh.out_, 4 * tile + index(d));
        }
        template <class P>
        P const* shared() noexcept
        {
            return mesh.Base::template shared<P>();
        }
        /// The bytes that an end of C with n messages takes on the machine.
        template <class C>
        std::uint32_t end_bytes(std::uint32_t n) const noexcept
        {
            return mesh.template end_bytes<C>(n);
        }
        Here here() noexcept { return {mesh.grid_.tile(tile), mesh.grid_}; }
        Worker worker() noexcept { return share; }
    };

    template <class C>
    machine::Place end(std::array<Ends, links>& side, std::uint32_t slot) noexcept
    {
        auto& e = side[Base::template index_of_link<C>()];
        return {e.heads[slot].data(), e.items.data() + slot * e.stride + guard_words, e.capacity};
    }
    template <class... C>
    void make_ends(machine::Types<C...>)
    {
        (make_end<C>(), ...);
    }
    template <class C>
    void make_end()
    {
        constexpr auto l = Base::template index_of_link<C>();
        Ends made[2];
        for (auto& e : made) {
            e.capacity = this->template link_capacity<C>();
            e.stride = std::size_t{e.capacity} * C::Receiver::item_words + 2 * guard_words;
            auto const n = std::size_t{this->grid_.size()} * 4;
            e.heads.assign(n, {0, 0, 0, engine::guard_word});
            e.items = engine::Arena(n * e.stride + C::Receiver::item_words); // room for one item after the last end
            bool const fill = n * e.stride <= (std::size_t{64} << 18);
            for (std::size_t s = 0; s < n; ++s) {
                auto* const items = e.items.data() + s * e.stride;
                for (std::size_t g = 0; g < guard_words; ++g)
                    items[g] = items[e.stride - 1 - g] = engine::guard_word;
                if (fill) std::fill(items + guard_words, items + e.stride - guard_words, engine::poison_word);
            }
        }
        in_[l] = std::move(made[0]);
        out_[l] = std::move(made[1]);
    }
    template <class C>
    void poison(machine::Place p) noexcept // the list of this end is dead now
    {
        std::fill(p.items, p.items + std::size_t{p.head[0]} * C::Receiver::item_words, engine::poison_word);
        p.head[0] = p.head[1] = 0;
    }

    // --- one tile -------------------------------------------------------------------------------------------------------
    [[noreturn]] void fail(std::uint32_t tile, std::string const& what) const
    {
        throw run_.failed(this->grid_, tile, what);
    }
    template <class Kernel>
    Vote run_tile(std::uint32_t tile)
    {
        Vote vote = Vote::quiet;
        remember_sizes(tile, typename KernelTraits<Kernel>::Arguments{});
        engine::detail::tilemesh_broken_contracts = &broken_;
        [[maybe_unused]] auto const sizes = list_sizes(tile, typename KernelTraits<Kernel>::Arguments{});
        if constexpr (KernelTraits<Kernel>::multi_worker) { // runs the last worker first, because the order of workers must not matter
            for (std::uint32_t w = this->sizes_.machine.workers; w-- > 0;) {
                Source source{*this, tile, {w, this->sizes_.machine.workers}};
                vote = run_kernel<Kernel>(source);
            }
        } else {
            Source source{*this, tile, {0, 1}};
            vote = run_kernel<Kernel>(source);
        }
        engine::detail::tilemesh_broken_contracts = nullptr; // an observer is not a kernel
        if (broken_.count != 0) fail(tile, std::exchange(broken_, {}).first);
        if (!this->guards_hold(tile, States{}))
            fail(tile, "a kernel wrote outside a region of its tile, or a size above its capacity (its guard words are gone); "
                       "use try_push and check indices");
        check_ends(tile, typename KernelTraits<Kernel>::Links{});
        if constexpr (KernelTraits<Kernel>::multi_worker)
            if (list_sizes(tile, typename KernelTraits<Kernel>::Arguments{}) != sizes)
                fail(tile, "a kernel that takes Worker changed the size of a list (one word, which all workers read); give it its size in a "
                           "superstep of one worker");
        return vote;
    }
    template <class... A>
    std::uint64_t list_sizes([[maybe_unused]] std::uint32_t tile, machine::Types<A...>)
    {
        std::uint64_t h = 0;
        ((h = engine::mix(h, list_size(tile, static_cast<std::remove_reference_t<A>*>(nullptr)))), ...);
        return h;
    }
    template <class X>
    std::uint32_t list_size([[maybe_unused]] std::uint32_t tile, X*)
    {
        if constexpr (is_list<X> && !std::is_const_v<X>)
            return this->template state_place<X>(tile).head[0];
        else
            return 0;
    }
    template <class... C>
    void check_ends([[maybe_unused]] std::uint32_t tile, machine::Types<C...>)
    {
        (check_end<C>(tile), ...);
    }
    template <class C>
    void check_end(std::uint32_t tile)
    {
        for (Direction d : news)
            for (auto* side : {&in_, &out_}) {
                auto const p = end<C>(*side, 4 * tile + index(d));
                auto const words = std::size_t{p.capacity} * C::Receiver::item_words;
                bool ok = p.head[3] == engine::guard_word && p.head[0] <= p.capacity;
                for (std::uint32_t g = 0; g < guard_words; ++g)
                    ok = ok && p.items[words + g] == engine::guard_word &&
                         (p.items - guard_words)[g] == engine::guard_word;
                if (!ok)
                    fail(tile, "a kernel wrote outside channel " + engine::text(name_of<C>()) +
                                   " (its guard words are gone, or its size is above its capacity); use try_push");
            }
    }
    /// Runs the kernel on a tile that need not run, and puts back each word. Throws Error if a word that counts is not what it was,
    /// or if the kernel sent or voted busy.
    template <class Kernel>
    void require_quiet(std::uint32_t tile, bool outside)
    {
        if (auto const change = change_of<Kernel>(tile)) fail(tile, change.text(outside));
    }
    /// What the kernel does on a tile that need not run. It is put back.
    template <class Kernel>
    engine::QuietChange change_of(std::uint32_t tile)
    {
        using Arguments = typename KernelTraits<Kernel>::Arguments;
        before_.clear();
        save(tile, Arguments{});
        engine::QuietChange change;
        if (run_tile<Kernel>(tile) == Vote::busy) change.kind = engine::QuietChange::Kind::vote;
        std::uint32_t const* saved = before_.data();
        compare(change, saved, tile, Arguments{});
        return change;
    }
    /// The words that a kernel may change on a tile: the states that it takes without const.
    template <class... A>
    void save([[maybe_unused]] std::uint32_t tile, machine::Types<A...>)
    {
        (save_argument(tile, static_cast<std::remove_reference_t<A>*>(nullptr)), ...);
    }
    template <class X>
    void save_argument([[maybe_unused]] std::uint32_t tile, X*)
    {
        if constexpr (!std::is_const_v<X> && !is_view<X>) {
            auto const p = this->template state_place<X>(tile);
            if constexpr (is_list<X>) before_.push_back(p.head[0]);
            before_.insert(before_.end(), p.items, p.items + live_words<X>(p));
        }
    }
    template <class X>
    std::size_t live_words(machine::Place p) const noexcept
    {
        if constexpr (is_list<X>)
            return std::size_t{p.head[0]} * this->template item_words<X>();
        else
            return sizeof(X) / 4;
    }
    template <class... A>
    void compare([[maybe_unused]] engine::QuietChange& change, [[maybe_unused]] std::uint32_t const* saved,
                 [[maybe_unused]] std::uint32_t tile, machine::Types<A...>)
    {
        (compare_argument(change, saved, tile, static_cast<std::remove_reference_t<A>*>(nullptr)), ...);
    }
    template <class X>
    void compare_argument([[maybe_unused]] engine::QuietChange& change, [[maybe_unused]] std::uint32_t const*& saved,
                          [[maybe_unused]] std::uint32_t tile, X*)
    {
        if constexpr (!std::is_const_v<X> && !is_view<X>) {
            using Kind = engine::QuietChange::Kind;
            auto const p = this->template state_place<X>(tile);
            std::uint32_t const out = this->sizes_.undigested[Base::template index_of_state<X>()];
            bool const counts = out != Sizes::no_digest && !change;
            std::size_t item = sizeof(X) / 4;
            if constexpr (is_list<X>) {
                item = this->template item_words<X>();
                auto const size = *saved++;
                if (counts && p.head[0] != size) change = {Kind::size, name_of<X>(), 0, 0, size, p.head[0]};
                p.head[0] = size;
            }
            auto const words = live_words<X>(p);
            for (std::size_t i = 0; i < words; ++i) {
                if (p.items[i] == saved[i]) continue;
                auto const word = static_cast<std::uint32_t>(i % item);
                if (counts && !change && word < item - out)
                    change = {is_list<X> ? Kind::item : Kind::word, name_of<X>(), word, static_cast<std::uint32_t>(i / item), saved[i],
                              p.items[i]};
                p.items[i] = saved[i];
            }
            saved += words;
        }
    }
    template <class C>
    void compare_argument(engine::QuietChange& change, std::uint32_t const*&, std::uint32_t tile, Out<C>*)
    {
        for (Direction d : news) {
            auto const p = end<C>(out_, 4 * tile + index(d));
            if ((p.head[0] | p.head[1]) != 0 && !change) change = {engine::QuietChange::Kind::message, name_of<C>(), 0, 0, 0, 0};
        }
    }

    // --- one superstep --------------------------------------------------------------------------------------------------
    template <class... A>
    bool has_mail([[maybe_unused]] std::uint32_t tile, machine::Types<A...>)
    {
        return (mail_on(tile, static_cast<std::remove_reference_t<A>*>(nullptr)) || ...);
    }
    template <class X>
    bool mail_on(std::uint32_t, X*)
    {
        return false;
    }
    template <class C>
    bool mail_on(std::uint32_t tile, In<C>*)
    {
        return unread<C>(tile);
    }
    template <class C>
    bool unread(std::uint32_t tile)
    {
        return std::any_of(std::begin(news), std::end(news), [&](Direction d) {
            auto const p = end<C>(in_, 4 * tile + index(d));
            return (p.head[0] | p.head[1]) != 0;
        });
    }
    template <class K, class C>
    void refuse_unread(std::uint32_t tile)
    {
        if constexpr (KernelTraits<K>::template writes<C> && !KernelTraits<K>::template reads<C>)
            if (unread<C>(tile))
                fail(0, "a kernel sends on a channel with unread mail (a bound cut the step that reads it); raise the bound, or "
                        "let the sending kernel read the channel");
    }
    template <class K, class... C>
    void refuse_unread([[maybe_unused]] std::uint32_t tile, machine::Types<C...>)
    {
        (refuse_unread<K, C>(tile), ...);
    }

    bool any_busy() const noexcept
    {
        auto const& busy = busy_[parity_];
        return std::find(busy.begin(), busy.end(), 1) != busy.end();
    }
    template <class Kernel, bool All>
    engine::Passed superstep()
    {
        using Traits = KernelTraits<Kernel>;
        auto const tiles = this->grid_.size();
        auto& busy = busy_[parity_];
        std::vector<std::uint8_t> runs(tiles, 0);
        bool any = All;
        for (std::uint32_t t = 0; t < tiles; ++t) {
            runs[t] = (All && rectangle_.contains(this->grid_.tile(t))) || busy[t] != 0 || has_mail(t, typename Traits::Arguments{});
            any = any || runs[t] != 0;
        }
        if (!any) { // if the tiles voted quiet in this kernel, one pass more must change nothing on any of them
            bool const look = options_.check_quiet_tiles && last_kernel_ == &kernel_tag<Kernel>;
            bool const first = options_.check_quiet_tiles && last_kernel_ == nullptr; // nobody has voted
            for (std::uint32_t t = 0; look && t < tiles; ++t) require_quiet<Kernel>(t, false);
            for (std::uint32_t t = 0; first && would_run_.empty() && t < tiles; ++t)
                if (change_of<Kernel>(t)) would_run_ = engine::text(name_of<Kernel>()) + "> [tile " + engine::text(this->grid_.tile(t)) + "]";
            return {};
        }
        if constexpr (traced)
            if (run_.trace)
                run_.trace->supersteps.push_back({run_.step(), votes_after<Program>(run_.step()),
                                                  this->template capacity_a_side<Kernel>(typename Traits::Links{}), false, {},
                                                  engine::edge_of<Kernel>(typename Traits::Links{}),
                                                  this->template absent_a_side<Kernel>(typename Traits::Links{}),
                                                  distance_of(typename Traits::Links{}), {}});
        engine::Passed passed;
        passed.ran = true;
        for (std::uint32_t t = 0; t < tiles; ++t) refuse_unread<Kernel>(t, typename Traits::Links{});
        for (std::uint32_t t = 0; t < tiles; ++t) {
            if (runs[t] == 0) {
                if (options_.check_quiet_tiles) require_quiet<Kernel>(t, All);
                continue;
            }
            busy_[parity_ ^ 1u][t] = run_tile<Kernel>(t) == Vote::busy;
            if constexpr (traced)
                if (run_.trace) {
                    Source source{*this, t, {0, this->sizes_.machine.workers}};
                    run_.trace->supersteps.back().tiles.push_back(engine::sample<Kernel>(source, t));
                    engine::sample_far<Kernel>(source, t, run_.trace->supersteps.back().far);
                }
            ++passed.tile_runs;
            measure(passed, t, typename Traits::Arguments{});
        }
        passed.sent = exchange<Kernel>(typename Traits::Links{});
        if constexpr (traced)
            if (run_.trace) run_.trace->supersteps.back().sent = passed.sent;
        check_shared_memory(Links{});
        std::fill(busy.begin(), busy.end(), std::uint8_t{0});
        parity_ ^= 1u;
        last_kernel_ = &kernel_tag<Kernel>;
        return passed;
    }
    std::uint64_t digest_now()
    {
        std::uint64_t digest = 0;
        for (std::uint32_t t = 0; t < this->grid_.size(); ++t)
            digest += engine::mix(digest_mail(t, Links{}), this->digest_states(t));
        return digest;
    }
    template <class... A>
    void remember_sizes([[maybe_unused]] std::uint32_t tile, machine::Types<A...>)
    {
        (remember_size(tile, static_cast<std::remove_reference_t<A>*>(nullptr)), ...);
    }
    template <class X>
    void remember_size([[maybe_unused]] std::uint32_t tile, X*)
    {
        if constexpr (is_list<X> && !std::is_const_v<X>) {
            auto& most = most_[Base::template index_of_state<X>()];
            if (most.empty()) most.assign(this->grid_.size(), 0);
            most[tile] = std::max(most[tile], this->template state_place<X>(tile).head[0]);
        }
    }
    template <class... A>
    void measure([[maybe_unused]] engine::Passed& passed, [[maybe_unused]] std::uint32_t tile, machine::Types<A...>)
    {
        (measure_argument(passed, tile, static_cast<std::remove_reference_t<A>*>(nullptr)), ...);
    }
    template <class X>
    void measure_argument(engine::Passed&, std::uint32_t tile, X*)
    {
        if constexpr (is_list<X> && !std::is_const_v<X>) {
            auto const p = this->template state_place<X>(tile);
            auto& peak = state_peak_[Base::template index_of_state<X>()];
            peak = std::max(peak, p.head[0]);
            // The items from the present size to the previous size are dead.
            auto& most = most_[Base::template index_of_state<X>()];
            std::size_t const item = this->template item_words<X>();
            if (most[tile] > p.head[0]) std::fill(p.items + p.head[0] * item, p.items + most[tile] * item, engine::poison_word);
            most[tile] = p.head[0];
        }
    }
    template <class C>
    void measure_argument(engine::Passed& passed, std::uint32_t tile, Out<C>*)
    {
        for (Direction d : news) {
            auto const n = end<C>(out_, 4 * tile + index(d)).head[0];
            if (reader_of<C>(this->grid_, this->grid_.tile(tile), d).delivered) {
                passed.messages += n;
                passed.live_bytes += std::uint64_t{n} * this->template message_bytes<C>();
            }
            auto& peak = link_peak_[Base::template index_of_link<C>()];
            peak = std::max(peak, n);
        }
    }
    /// Poisons the mail that was read, then copies the messages that were sent.
    template <class K, class... C>
    bool exchange(machine::Types<C...>)
    {
        bool sent = false;
        ((sent = exchange_one<K, C>() || sent), ...);
        return sent;
    }
    template <class K, class C>
    bool exchange_one()
    {
        auto const slots = 4 * this->grid_.size();
        if constexpr (KernelTraits<K>::template reads<C>)
            for (std::uint32_t s = 0; s < slots; ++s) poison<C>(end<C>(in_, s));
        bool sent = false;
        for (std::uint32_t s = 0; s < slots; ++s) {
            auto const from = end<C>(out_, s);
            if ((from.head[0] | from.head[1]) == 0) continue;
            auto const reader = reader_of<C>(this->grid_, this->grid_.tile(s / 4), news[s % 4]);
            if (!reader.delivered) {
                poison<C>(from);
                continue;
            }
            sent = true;
            auto const to = end<C>(in_, 4 * this->grid_.index_of(reader.tile) + index(reader.side));
            std::memcpy(to.items, from.items, std::size_t{from.head[0]} * C::Receiver::item_words * 4);
            to.head[0] = from.head[0];
            to.head[1] = from.head[1];
            poison<C>(from);
        }
        return sent;
    }
    template <class... C>
    void check_shared_memory(machine::Types<C...>)
    {
        (check_shared_memory_of<C>(), ...);
    }
    template <class C>
    void check_shared_memory_of()
    {
        using Host = MemoryOf<C>;
        if constexpr (!std::is_same_v<Host, C>) {
            if (!this->sizes_.shares_memory[Base::template index_of_link<C>()]) return;
            for (std::uint32_t t = 0; t < this->grid_.size(); ++t)
                if (unread<C>(t) && unread<Host>(t))
                    fail(t, "channels " + engine::text(name_of<C>()) + " and " + engine::text(name_of<Host>()) +
                                " both carry mail (memory_of says that they share their words); give each its own memory");
        }
    }
    template <class... C>
    std::uint64_t digest_mail(std::uint32_t tile, machine::Types<C...>)
    {
        std::uint64_t h = 0;
        [[maybe_unused]] auto const one = [&](auto tag) {
            using L = typename decltype(tag)::type;
            if (this->sizes_.undigested_links[Base::template index_of_link<L>()]) return;
            for (Direction d : news) {
                auto const p = end<L>(in_, 4 * tile + index(d));
                h = engine::mix(h, p.head[1]);
                h = this->template mix_items<typename L::value_type>(h, p);
            }
        };
        (one(machine::Tag<C>{}), ...);
        return h;
    }

    Options options_;
    engine::Rectangle rectangle_; ///< Superstep and Repeat run all of its tiles
    std::array<Ends, links> in_, out_;
    std::vector<std::uint8_t> busy_[2];
    std::uint32_t parity_ = 0;
    std::array<std::uint32_t, States::count + 1> state_peak_{};
    std::array<std::vector<std::uint32_t>, States::count + 1> most_;
    std::array<std::uint32_t, links> link_peak_{};
    /// Its address stands for the kernel.
    template <class Kernel>
    static inline char const kernel_tag = 0;
    char const* last_kernel_ = nullptr; ///< of the superstep before; null at the start of a run
    std::string would_run_;             ///< the first kernel that would have changed a word, had a tile run before anybody voted; its tile
    std::vector<std::uint32_t> before_; ///< the words of a tile before the kernel ran on it, although it need not run
    engine::detail::BrokenContracts broken_;
    Run run_;
};

template <class Program, class Machine>
    requires(!std::same_as<Machine, CheckedMeshOptions>)
CheckedMesh(Program, Grid, Machine, CheckedMeshOptions = {}) -> CheckedMesh<Program, Machine>;
template <class Program>
CheckedMesh(Program, Grid, MeshSizes<Program>, CheckedMeshOptions = {}) -> CheckedMesh<Program, AnyMachine>;

template <class Program>
std::unique_ptr<engine::Port<Program>> make_checked_port(Program const& program, Grid grid, MeshSizes<Program> const& sizes,
                                                         MeshOptions const& options)
{
    CheckedMeshOptions checked;
    checked.digest = options.digest;
    checked.most_passes = options.most_passes;
    checked.explain = options.explain;
    checked.trace = options.trace;
    return std::make_unique<engine::PortOver<CheckedMesh<Program, Traced<AnyMachine>>>>(program, grid, sizes, checked);
}

}} // namespace tilemesh
