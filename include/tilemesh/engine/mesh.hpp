#pragma once
#include <algorithm>
#include <atomic>
#include <bit>
#include <chrono>
#include <exception>
#include <system_error>
#include <thread>
#include <tilemesh/engine/barrier.hpp>
#include <tilemesh/engine/store.hpp>

namespace tilemesh {

namespace engine::detail {

/// The names of a program's steps, in program order.
template <class K>
void list_steps(Superstep<K>*, std::vector<StepCounters>& out)
{
    out.push_back({text(name_of<K>())});
}
template <std::uint32_t N, class K>
void list_steps(Repeat<N, K>*, std::vector<StepCounters>& out)
{
    out.push_back({text(name_of<K>())});
}
template <class K>
void list_steps(UntilQuiet<K>*, std::vector<StepCounters>& out)
{
    out.push_back({text(name_of<K>())});
}
template <class... S>
void list_steps(Sequence<S...>*, std::vector<StepCounters>& out)
{
    (list_steps(static_cast<S*>(nullptr), out), ...);
}

/// A broken contract, or an exception, on its way from a tile to the caller of run().
struct Failure {
    std::uint32_t tile = 0xffffffffu;
    char const* text = nullptr;
};
inline Error failed(Grid grid, Failure const& f, std::string const& kernel, std::uint64_t pass)
{
    return Error(std::string(f.text) + " [tile " + text(grid.tile(f.tile)) + ", superstep " + std::to_string(pass) + " (" +
                 kernel + ")]");
}

/// Both banks of a channel on the host: the exchange swaps them. A sender writes straight into its neighbour's place.
struct Bank {
    Arena heads[2];
    Arena items[2];
    std::size_t stride = 0;
    std::uint32_t capacity = 0;
};

} // namespace engine::detail

/// How a Mesh runs.
struct MeshOptions {
    std::uint32_t threads = 1; ///< at most 1,024: a claim of tiles each would be all they do
    bool digest = false; ///< RunCounters::digests: costs a pass over all live words each superstep
};

/// Runs a program on host threads. Every worker walks the program itself and meets the others at one barrier a superstep;
/// tiles are claimed in small groups, so that uneven tiles keep all threads busy. Pictures, counters and digests do not
/// depend on the number of threads and equal those of CheckedMesh.
///
/// Cost: idle tiles and empty channels cost nothing in a superstep but two bits; memory follows live records. A mesh stays as
/// it is between runs: states, and mail that a bound (`at_most`) left under way.
///
/// Errors: the constructor and `limit` throw Error for a machine that is too small; `run` throws Error for a contract that a
/// kernel broke, with tile and superstep, and what an observer threw; after that the mesh refuses to run again.
template <class Program, class Machine = Mk2>
class Mesh : public engine::detail::Store<Program, Machine, false> {
    using Base = engine::detail::Store<Program, Machine, false>;
    using Bank = engine::detail::Bank;
    using Clock = std::chrono::steady_clock;

public:
    using typename Base::Layout;
    using typename Base::Links;
    using typename Base::States;
    using Options = MeshOptions;

    explicit Mesh(Grid grid, Options options = {}, Program program = {})
        : Base(grid, program), options_(options), barrier_(std::max(options.threads, 1u)),
          workers_(std::clamp(options.threads, 1u, 1024u))
    {
        if (options.threads > 1024)
            throw Error(std::to_string(options.threads) + " threads (a mesh runs on at most 1,024); ask for fewer");
        options_.threads = std::max(options.threads, 1u);
        bitmap_words_ = (grid.size() + 63) / 64;
        // About 32 claims a thread and superstep; whole multiples of 16 tiles, so that claims rarely share a bitmap word.
        claim_tiles_ = std::max(16u, grid.size() / (options_.threads * 32) / 16 * 16);
        slots_.resize(std::size_t{grid.size()} * 4);
        for (std::uint32_t i = 0; i < grid.size(); ++i)
            for (Direction d : news) {
                auto const t = grid.tile(i);
                slots_[4 * std::size_t{i} + index(d)] =
                    4 * grid.index_of(grid.neighbour(t, d)) + index(grid.arrival(t, d));
            }
        make_banks(Links{});
        for (auto& w : workers_) w.make(bitmap_words_);
        engine::detail::list_steps(static_cast<Program*>(nullptr), steps_);
        threads_.reserve(options_.threads);
        try {
            for (std::uint32_t w = 1; w < options_.threads; ++w) threads_.emplace_back([this, w] { serve(w); });
        } catch (std::system_error const& e) {
            auto const started = threads_.size() + 1;
            join();
            throw Error(std::to_string(options_.threads) + " threads (the system gave " + std::to_string(started) + ": " +
                        e.what() + "); ask for fewer");
        }
    }
    ~Mesh() { join(); }
    Mesh(Mesh const&) = delete;
    Mesh& operator=(Mesh const&) = delete;

    /// At most `items` in this Limited buffer, or this many slots in this Limited or dynamic channel, on every tile.
    template <class X>
    void limit(std::uint32_t items)
    {
        if constexpr (tilemesh::detail::is_channel<X>) {
            this->template limit_link<X>(items, unread<X>(workers_[0]));
            make_bank<X>();
        } else {
            this->template limit_state<X>(items);
        }
    }

    /// What tile t's channel C will read from side d when a kernel next takes In<C>. Only between runs, or from an observer.
    template <class C>
    typename C::Receiver incoming(TileId t, Direction d) noexcept
    {
        auto const l = Base::template index_of_link<C>();
        return typename C::Receiver{place(l, workers_[0].bank[l] ^ 1u, 4 * this->grid_.index_of(t) + index(d))};
    }

    /// Called after every superstep by the thread that called run().
    void observe(Observer observer) { observer_ = std::move(observer); }

    /// Runs the whole program once.
    RunCounters run()
    {
        if (broken_) throw Error("a mesh that stopped on an error cannot run again (its state is half a superstep); build a new one");
        this->require_capacities(Links{});
        for (auto& w : workers_) w.begin(steps_.size());
        error_ = nullptr;
        failure_ = {};
        pass_ = 0;
        digests_.clear();
        epoch_.fetch_add(1, std::memory_order_release);
        epoch_.notify_all();
        work(0);
        RunCounters run;
        run.steps = steps_;
        for (auto const& w : workers_)
            for (std::size_t i = 0; i < run.steps.size(); ++i) {
                auto const& s = w.steps[i];
                run.steps[i].messages += s.messages;
                run.steps[i].live_bytes += s.live_bytes;
                run.steps[i].tile_runs += s.tile_runs;
            }
        for (std::size_t i = 0; i < run.steps.size(); ++i) {
            auto const& s = workers_[0].steps[i];
            run.steps[i].passes = s.passes;
            run.steps[i].supersteps = s.supersteps;
            run.steps[i].capacity_bytes = s.capacity_bytes;
            run.steps[i].milliseconds = s.milliseconds;
        }
        add_peaks(run, States{}, Links{});
        run.digests = std::move(digests_);
        if (error_) std::rethrow_exception(error_);
        return run;
    }

private:
    void join() noexcept
    {
        stop_.store(true);
        epoch_.fetch_add(1);
        epoch_.notify_all();
        for (auto& t : threads_) t.join();
    }

    using Bits = std::vector<std::uint64_t>;
    static constexpr std::uint32_t links = Links::count + 1;
    struct alignas(64) WorkerState {
        Bits busy[2];                                       ///< who voted busy, by parity of the superstep
        std::array<std::array<Bits, 2>, links> mail;        ///< who was sent something, by channel and bank
        std::array<bool, 2> any_busy{};
        std::array<std::array<bool, 2>, links> any_mail{};
        std::array<std::uint32_t, links> bank{};            ///< the bank that senders write now
        std::uint32_t parity = 0;
        std::uint32_t step = 0;
        bool stopped = false;
        std::vector<StepCounters> steps;
        std::array<std::uint32_t, States::count + 1> state_peak{};
        std::array<std::uint32_t, links> link_peak{};
        std::uint64_t sent = 0, runs = 0, digest = 0;       ///< of the superstep of now
        engine::detail::Failure failure;                    ///< of the lowest tile
        std::array<bool, 2> failed{};                       ///< in the superstep of this parity

        void make(std::uint32_t words)
        {
            for (auto& b : busy) b.assign(words, 0);
            for (auto& m : mail)
                for (auto& b : m) b.assign(words, 0);
        }
        void begin(std::size_t n)
        {
            steps.assign(n, {});
            state_peak.fill(0);
            link_peak.fill(0);
            for (auto p : {0, 1}) clear(busy[p], any_busy[static_cast<std::size_t>(p)]);
            parity = step = 0;
            stopped = false;
            failure = {};
            failed = {};
        }
        static void clear(Bits& bits, bool& any)
        {
            if (any) std::fill(bits.begin(), bits.end(), 0);
            any = false;
        }
    };

    /// What this interpreter offers a kernel.
    struct Source {
        Mesh& mesh;
        WorkerState const& me;
        std::uint32_t tile;
        Worker share;
        template <class X>
        TILEMESH_KERNEL Place state() noexcept
        {
            return mesh.template state_place<X>(tile);
        }
        template <class C>
        TILEMESH_KERNEL Place in(Direction d) noexcept
        {
            constexpr auto l = Base::template index_of_link<C>();
            return mesh.place(l, me.bank[l] ^ 1u, 4 * tile + index(d));
        }
        template <class C>
        TILEMESH_KERNEL Place out(Direction d) noexcept
        {
            constexpr auto l = Base::template index_of_link<C>();
            return mesh.place(l, me.bank[l], mesh.slots_[4 * std::size_t{tile} + index(d)]);
        }
        template <class P>
        TILEMESH_KERNEL P const* shared() noexcept
        {
            return mesh.Base::template shared<P>();
        }
        TILEMESH_KERNEL Here here() noexcept { return {mesh.grid_.tile(tile), mesh.grid_}; }
        TILEMESH_KERNEL Worker worker() noexcept { return share; }
    };

    TILEMESH_KERNEL Place place(std::uint32_t link, std::uint32_t bank, std::uint32_t slot) noexcept
    {
        auto const& b = banks_[link];
        return {b.heads[bank].data() + 2 * std::size_t{slot}, b.items[bank].data() + std::size_t{slot} * b.stride, b.capacity};
    }

    template <class... C>
    void make_banks(Types<C...>)
    {
        (make_bank<C>(), ...);
    }
    template <class C>
    void make_bank()
    {
        constexpr auto l = Base::template index_of_link<C>();
        auto& b = banks_[l];
        auto const n = std::size_t{this->grid_.size()} * 4;
        b.capacity = this->template link_capacity<C>();
        auto const most = C::static_capacity == dynamic_capacity ? b.capacity : C::static_capacity;
        auto const stride = ((std::size_t{most} * C::Receiver::item_words + 15u) & ~std::size_t{15}) | 16u;
        for (int i : {0, 1}) {
            if (b.heads[i].data() == nullptr) b.heads[i] = engine::detail::Arena(n * 2);
            if (stride != b.stride) b.items[i] = engine::detail::Arena(n * stride);
        }
        b.stride = stride;
    }

    // --- one tile -------------------------------------------------------------------------------------------------------
    template <class Kernel>
    TILEMESH_KERNEL void run_tile(WorkerState& me, std::uint32_t tile) noexcept
    {
        char const* broken = nullptr;
        engine::detail::broken_contract = &broken;
        Source source{*this, me, tile, {0, 1}};
        if constexpr (KernelTraits<Kernel>::multi_worker) { // one host thread takes the shares of all of the tile's workers
            for (std::uint32_t w = 0; w < Machine::workers; ++w) {
                source.share = {w, Machine::workers};
                (void)run_kernel<Kernel>(source);
            }
        } else if (run_kernel<Kernel>(source) == Vote::busy) {
            me.busy[me.parity ^ 1u][tile / 64] |= std::uint64_t{1} << (tile % 64);
            me.any_busy[me.parity ^ 1u] = true;
        }
        after_kernel(me, source, typename KernelTraits<Kernel>::Arguments{});
        ++me.runs;
        if (broken != nullptr) fail(me, {tile, broken});
    }
    void fail(WorkerState& me, engine::detail::Failure const& failure) noexcept
    {
        if (failure.tile < me.failure.tile) me.failure = failure;
        me.failed[me.parity] = true;
    }
    template <class... A>
    TILEMESH_KERNEL void after_kernel(WorkerState& me, Source& source, Types<A...>) noexcept
    {
        (after(me, source, static_cast<std::remove_reference_t<A>*>(nullptr)), ...);
    }
    template <class X>
    TILEMESH_KERNEL void after(WorkerState& me, Source& source, X*) noexcept
    {
        if constexpr (tilemesh::detail::is_list<X> && !std::is_const_v<X>) {
            auto& peak = me.state_peak[Base::template index_of_state<X>()];
            peak = std::max(peak, source.template state<X>().head[0]);
        }
    }
    template <class C>
    TILEMESH_KERNEL void after(WorkerState&, Source& source, In<C>*) noexcept // mail is read once
    {
        for (Direction d : news) {
            auto* const head = source.template in<C>(d).head;
            if ((head[0] | head[1]) != 0) head[0] = head[1] = 0;
        }
    }
    template <class C>
    TILEMESH_KERNEL void after(WorkerState& me, Source& source, Out<C>*) noexcept
    {
        constexpr auto l = Base::template index_of_link<C>();
        for (Direction d : news) {
            auto const* const head = source.template out<C>(d).head;
            if ((head[0] | head[1]) == 0) continue;
            auto const to = slots_[4 * std::size_t{source.tile} + index(d)] / 4;
            me.mail[l][me.bank[l]][to / 64] |= std::uint64_t{1} << (to % 64);
            me.any_mail[l][me.bank[l]] = true;
            me.sent += head[0];
            me.steps[me.step].messages += head[0];
            me.steps[me.step].live_bytes += std::uint64_t{head[0]} * sizeof(typename C::value_type);
            me.link_peak[l] = std::max(me.link_peak[l], head[0]);
        }
    }

    // --- one superstep --------------------------------------------------------------------------------------------------
    template <class... A>
    bool any_mail_for(WorkerState const& me, Types<A...>) const noexcept
    {
        return (has_mail(me, static_cast<std::remove_reference_t<A>*>(nullptr)) || ...);
    }
    template <class X>
    bool has_mail(WorkerState const&, X*) const noexcept
    {
        return false;
    }
    template <class C>
    bool has_mail(WorkerState const& me, In<C>*) const noexcept
    {
        return unread<C>(me);
    }
    template <class C>
    bool unread(WorkerState const& me) const noexcept
    {
        constexpr auto l = Base::template index_of_link<C>();
        return std::any_of(workers_.begin(), workers_.end(),
                           [&](auto const& w) { return w.any_mail[l][me.bank[l] ^ 1u]; });
    }
    template <class... A>
    std::uint64_t mail_bits(WorkerState const& me, std::uint32_t word, Types<A...>) const noexcept
    {
        return (std::uint64_t{0} | ... | mail_word(me, word, static_cast<std::remove_reference_t<A>*>(nullptr)));
    }
    template <class X>
    std::uint64_t mail_word(WorkerState const&, std::uint32_t, X*) const noexcept
    {
        return 0;
    }
    template <class C>
    std::uint64_t mail_word(WorkerState const& me, std::uint32_t word, In<C>*) const noexcept
    {
        constexpr auto l = Base::template index_of_link<C>();
        std::uint64_t bits = 0;
        for (auto const& w : workers_)
            if (w.any_mail[l][me.bank[l] ^ 1u]) bits |= w.mail[l][me.bank[l] ^ 1u][word];
        return bits;
    }
    /// Forgets who was told what in the bank that is written next.
    template <class... C>
    void forget(WorkerState& me, Types<C...>) noexcept
    {
        (WorkerState::clear(me.mail[Base::template index_of_link<C>()][me.bank[Base::template index_of_link<C>()]],
                            me.any_mail[Base::template index_of_link<C>()][me.bank[Base::template index_of_link<C>()]]),
         ...);
    }
    template <class... C>
    void flip(WorkerState& me, Types<C...>) noexcept
    {
        ((me.bank[Base::template index_of_link<C>()] ^= 1u), ...);
    }
    template <class K, class... C>
    bool sends_over_unread(WorkerState const& me, Types<C...>) const noexcept
    {
        return ((KernelTraits<K>::template writes<C> && !KernelTraits<K>::template reads<C> && unread<C>(me)) || ...);
    }
    template <class K, class... C>
    std::uint64_t capacity_bytes(Types<C...>) const noexcept
    {
        return (std::uint64_t{0} + ... +
                (KernelTraits<K>::template writes<C>
                     ? std::uint64_t{16} * this->grid_.size() * C::Receiver::words(this->template link_capacity<C>())
                     : 0));
    }
    template <class K, class... C>
    bool sent_anything(WorkerState const& me, Types<C...>) const noexcept // before the banks flip
    {
        [[maybe_unused]] auto const any = [&](auto tag) {
            constexpr auto l = Base::template index_of_link<typename decltype(tag)::type>();
            return std::any_of(workers_.begin(), workers_.end(), [&](auto const& w) { return w.any_mail[l][me.bank[l]]; });
        };
        return ((KernelTraits<K>::template writes<C> && any(tilemesh::detail::Tag<C>{})) || ...);
    }

    /// One superstep on all tiles, or on those that must run; false, having done nothing, when nobody must, or all stopped.
    template <class Kernel, bool All>
    bool superstep(std::uint32_t w) noexcept
    {
        using Traits = KernelTraits<Kernel>;
        using KernelLinks = typename Traits::Links;
        auto& me = workers_[w];
        if (me.stopped) return false;
        auto const p = me.parity;
        bool const any_busy =
            All || std::any_of(workers_.begin(), workers_.end(), [p](auto const& o) { return o.any_busy[p]; });
        if (!any_busy && !any_mail_for(me, typename Traits::Arguments{})) return false;

        forget(me, KernelLinks{});
        me.sent = me.runs = 0;
        if (w == 0) {
            if (sends_over_unread<Kernel>(me, KernelLinks{}))
                fail(me, {0, "a kernel sends on a channel with unread mail (a bound cut the step that reads it); raise the "
                             "bound, or let the sending kernel read the channel"});
            claims_[p ^ 1u].store(0, std::memory_order_relaxed);
        }
        auto const tiles = this->grid_.size();
        for (;;) {
            auto const first = claims_[p].fetch_add(claim_tiles_, std::memory_order_relaxed);
            if (first >= tiles) break;
            auto const last = std::min(first + claim_tiles_, tiles);
            if constexpr (All) {
                for (auto t = first; t < last; ++t) run_tile<Kernel>(me, t);
            } else {
                for (auto word = first / 64; word * 64 < last; ++word) {
                    std::uint64_t bits = mail_bits(me, word, typename Traits::Arguments{});
                    for (auto const& o : workers_)
                        if (o.any_busy[p]) bits |= o.busy[p][word];
                    if (word * 64 < first) bits &= ~std::uint64_t{0} << (first % 64);
                    if (last < word * 64 + 64) bits &= (std::uint64_t{1} << (last % 64)) - 1;
                    for (; bits != 0; bits &= bits - 1)
                        run_tile<Kernel>(me, word * 64 + static_cast<std::uint32_t>(std::countr_zero(bits)));
                }
            }
        }
        me.steps[me.step].tile_runs += me.runs;
        barrier_.arrive_and_wait();

        // What is read from here on is written again only after the barrier of the next superstep: votes and failures are
        // kept by parity, mail by bank.
        bool const sent = sent_anything<Kernel>(me, KernelLinks{});
        ++me.steps[me.step].passes;
        me.steps[me.step].supersteps += sent ? 1 : 0;
        if (sent) me.steps[me.step].capacity_bytes += capacity_bytes<Kernel>(KernelLinks{});
        flip(me, KernelLinks{});
        for (auto const& o : workers_) me.stopped = me.stopped || o.failed[p];
        if (options_.digest || observer_ || me.stopped) {
            if (options_.digest) digest_share(w);
            barrier_.arrive_and_wait();
            if (w == 0) report(steps_[me.step].kernel);
            barrier_.arrive_and_wait();
            me.stopped = me.stopped || error_ != nullptr;
        }
        if (w == 0) ++pass_;
        WorkerState::clear(me.busy[p], me.any_busy[p]);
        me.parity ^= 1u;
        return true;
    }

    /// Worker 0, alone: the digest, the observer, a failure.
    void report(std::string const& kernel) noexcept
    {
        std::uint64_t messages = 0, runs = 0, digest = 0;
        for (auto const& o : workers_) {
            messages += o.sent;
            runs += o.runs;
            digest += o.digest;
            if (o.failure.text != nullptr && o.failure.tile < failure_.tile) failure_ = o.failure;
        }
        if (options_.digest) digests_.push_back(digest);
        engine::detail::broken_contract = nullptr; // an observer is no kernel
        try {
            if (failure_.text != nullptr) throw engine::detail::failed(this->grid_, failure_, kernel, pass_);
            if (observer_)
                observer_({kernel, workers_[0].step, pass_, messages, runs, options_.digest ? digest : 0});
        } catch (...) {
            error_ = std::current_exception();
            broken_ = true;
        }
    }
    void digest_share(std::uint32_t w) noexcept
    {
        auto& me = workers_[w];
        auto const tiles = std::uint64_t{this->grid_.size()};
        me.digest = 0;
        for (auto t = tiles * w / options_.threads; t < tiles * (w + 1) / options_.threads; ++t)
            me.digest += engine::detail::mix(digest_mail(me, static_cast<std::uint32_t>(t), Links{}),
                                             this->digest_states(static_cast<std::uint32_t>(t)));
    }
    template <class... C>
    std::uint64_t digest_mail(WorkerState const& me, std::uint32_t tile, Types<C...>) noexcept
    {
        std::uint64_t h = 0;
        [[maybe_unused]] auto const one = [&](auto tag) {
            using L = typename decltype(tag)::type;
            constexpr auto l = Base::template index_of_link<L>();
            for (Direction d : news) {
                auto const p = place(l, me.bank[l] ^ 1u, 4 * tile + index(d));
                h = engine::detail::mix(h, p.head[1]);
                h = engine::detail::mix_words(h, p.items, std::size_t{p.head[0]} * L::Receiver::item_words);
            }
        };
        (one(tilemesh::detail::Tag<C>{}), ...);
        return h;
    }

    // --- the program ----------------------------------------------------------------------------------------------------
    template <class K>
    void walk(std::uint32_t w, Superstep<K> const&) noexcept
    {
        timed(w, [&] { superstep<K, true>(w); });
    }
    template <std::uint32_t N, class K>
    void walk(std::uint32_t w, Repeat<N, K> const&) noexcept
    {
        timed(w, [&] {
            for (std::uint32_t i = 0; i < N && superstep<K, true>(w); ++i) {}
        });
    }
    template <class K>
    void walk(std::uint32_t w, UntilQuiet<K> const& step) noexcept
    {
        timed(w, [&] {
            for (auto n = step.at_most; n > 0 && superstep<K, false>(w); --n) {}
        });
    }
    template <class... S>
    void walk(std::uint32_t w, Sequence<S...> const& q) noexcept
    {
        std::apply([&](auto const&... s) { (walk(w, s), ...); }, q.steps);
    }
    template <class F>
    void timed(std::uint32_t w, F const& run) noexcept
    {
        auto& me = workers_[w];
        auto const begin = w == 0 ? Clock::now() : Clock::time_point{};
        run();
        if (w == 0)
            me.steps[me.step].milliseconds = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
        ++me.step;
    }
    void work(std::uint32_t w) noexcept
    {
        if (w == 0) claims_[0].store(0), claims_[1].store(0);
        barrier_.arrive_and_wait();
        walk(w, this->program_);
        engine::detail::broken_contract = nullptr;
        barrier_.arrive_and_wait();
    }
    void serve(std::uint32_t w) noexcept
    {
        for (std::uint32_t seen = 0;;) {
            for (int i = 0; epoch_.load(std::memory_order_acquire) == seen; ++i) {
                if (i < engine::detail::spins_before_sleep)
                    engine::detail::relax();
                else
                    epoch_.wait(seen);
            }
            seen = epoch_.load();
            if (stop_.load()) return;
            work(w);
        }
    }
    template <class... X, class... C>
    void add_peaks(RunCounters& run, Types<X...>, Types<C...>) const
    {
        [[maybe_unused]] auto const state = [&](auto tag) {
            using S = typename decltype(tag)::type;
            if constexpr (tilemesh::detail::is_list<S>) {
                constexpr auto i = Base::template index_of_state<S>();
                Peak peak{engine::detail::text(name_of<S>()), 0, this->capacity_[i]};
                for (auto const& w : workers_) peak.items = std::max(peak.items, w.state_peak[i]);
                run.peaks.push_back(peak);
            }
        };
        [[maybe_unused]] auto const link = [&](auto tag) {
            using L = typename decltype(tag)::type;
            constexpr auto l = Base::template index_of_link<L>();
            Peak peak{engine::detail::text(name_of<L>()), 0, this->template link_capacity<L>()};
            for (auto const& w : workers_) peak.items = std::max(peak.items, w.link_peak[l]);
            run.peaks.push_back(peak);
        };
        (state(tilemesh::detail::Tag<X>{}), ...);
        (link(tilemesh::detail::Tag<C>{}), ...);
    }

    Options options_;
    std::uint32_t bitmap_words_ = 0;
    std::uint32_t claim_tiles_ = 16;
    std::vector<std::uint32_t> slots_;                 ///< where each tile's four outgoing ends are read
    std::array<Bank, links> banks_;
    engine::detail::Barrier barrier_;
    std::vector<WorkerState> workers_;
    std::vector<StepCounters> steps_;
    Observer observer_;
    std::exception_ptr error_;
    engine::detail::Failure failure_;
    std::vector<std::uint64_t> digests_;
    std::uint64_t pass_ = 0;
    bool broken_ = false;
    alignas(64) std::atomic<std::uint32_t> claims_[2]{};
    alignas(64) std::atomic<std::uint32_t> epoch_{0};
    std::atomic<bool> stop_{false};
    std::vector<std::thread> threads_;
};

} // namespace tilemesh
