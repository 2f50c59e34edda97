#pragma once
#include <atomic>
#include <cstdint>
#include <thread>
#include <tilemesh/config.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace engine::detail {

inline void relax() noexcept
{
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause(); // <immintrin.h>, which has a name for it, takes 0.6 s to compile
#endif
}

/// The way in which a waiting thread waits. Between supersteps, work comes within a few microseconds: the thread spins for that time.
/// Longer spinning would be slow if another process, or another thread of the team, needs the core. So it then yields between two looks,
/// which costs 0.5 microseconds if no other thread is ready. Successive runs follow within about 100 microseconds, and a wake-up costs tens
/// of microseconds, so the thread sleeps only after that.
inline constexpr std::uint32_t spins_before_yield = 200;  ///< about 5 us, at 40 to 140 cycles per pause
inline constexpr std::uint32_t yields_before_sleep = 200; ///< about 100 us

/// A caller and its helper threads, which take part in the work that the caller shares out.
///
/// The caller opens a gate and works. A helper that sees the open gate comes in. The gate closes when the caller's own part is done. The
/// caller waits only for helpers that came in: if another process has taken a helper's core, the caller loses only that helper's work.
///
/// A child of `fork` has none of the helpers. There the team starts new ones when it next shares; fork while no call runs.
class Team {
public:
    /// `threads` includes the caller's thread and is at least 1. Throws Error if the system gives fewer threads. If the constructor throws,
    /// the helpers that were started have ended.
    explicit Team(std::uint32_t threads);
    ~Team() { join(); }
    Team(Team const&) = delete;
    Team& operator=(Team const&) = delete;

    std::uint32_t size() const noexcept { return static_cast<std::uint32_t>(threads_.size()) + 1; }

    /// Calls f(0) on this thread, and f(w) on each helper w that comes before f(0) returns. f must not throw, and must do all the work for
    /// any set of helpers. All threads see the words written before the call, and the caller sees afterwards the words that any thread
    /// wrote.
    template <class F>
    void share(F const& f) noexcept
    {
        if (threads_.empty()) {
            f(0u);
            return;
        }
        if (forks_ != forks.load(std::memory_order_relaxed)) start_in_child();
        call_ = [](void const* what, std::uint32_t w) noexcept { (*static_cast<F const*>(what))(w); };
        what_ = &f;
        gate_.fetch_add(next_epoch + open);
        wake();
        f(0u);
        gate_.fetch_sub(open, std::memory_order_acq_rel);
        for (std::uint32_t i = 0; (gate_.load(std::memory_order_acquire) & inside) != 0; ++i) pause(i);
    }
    /// Calls f(w) on every thread of the team.
    template <class F>
    void each(F const& f) noexcept
    {
        std::atomic<std::uint32_t> done{0};
        share([&](std::uint32_t w) noexcept {
            f(w);
            done.fetch_add(1, std::memory_order_acq_rel);
            if (w != 0) return;
            for (std::uint32_t i = 0; done.load(std::memory_order_acquire) != size(); ++i) pause(i); // the gate stays open
        });
    }

private:
    // The gate: the number of helpers inside, whether more may come in, and how often it was opened.
    static constexpr std::uint64_t inside = 0xffffffffu;
    static constexpr std::uint64_t open = std::uint64_t{1} << 32;
    static constexpr std::uint64_t next_epoch = std::uint64_t{1} << 33;

    static void pause(std::uint32_t i) noexcept
    {
        if (i < spins_before_yield)
            relax();
        else
            std::this_thread::yield();
    }
    bool may_enter(std::uint64_t gate, std::uint64_t seen) const noexcept
    {
        return (gate & open) != 0 && gate / next_epoch != seen;
    }
    void run_calls(std::uint32_t w) noexcept;
    void start(std::uint32_t threads);
    void start_in_child() noexcept;
    void abandon() noexcept;
    // No helper misses a bell. A helper that reads the bell before it rings does not sleep; one that reads it later tells the next ring.
    void sleep(std::uint64_t seen) noexcept
    {
        auto const bell = bell_.load();
        asleep_.store(1);
        if (!may_enter(gate_.load(), seen) && !stop_.load()) bell_.wait(bell);
    }
    void wake() noexcept
    {
        if (asleep_.load() == 0) return;
        asleep_.store(0);
        bell_.fetch_add(1);
        bell_.notify_all();
    }
    void join() noexcept;

    inline static std::atomic<std::uint32_t> forks{0}; ///< how often this process and its parents were forked off, since a team watches it

    alignas(64) std::atomic<std::uint64_t> gate_{0};
    std::atomic<bool> stop_{false};
    alignas(64) std::atomic<std::uint32_t> asleep_{0}; ///< may a helper be asleep?
    std::atomic<std::uint32_t> bell_{0};
    void (*call_)(void const*, std::uint32_t) noexcept = nullptr;
    void const* what_ = nullptr;
    std::uint32_t forks_ = 0; ///< at the start of the helpers
    std::vector<std::thread> threads_;
};

/// Items 0..n-1 for the threads of a team. Each thread has an even share and takes it in pieces. A thread that is done takes half of the
/// rest of another thread. So threads keep to the same tiles from superstep to superstep, whose words are in their caches, and a few heavy
/// tiles next to each other leave no thread idle at the end.
class Shares {
public:
    explicit Shares(std::uint32_t threads) : parts_(threads) {}

    /// Call it before a team shares the items.
    void set(std::uint32_t n) noexcept
    {
        auto const threads = parts_.size();
        for (std::size_t w = 0; w < threads; ++w)
            parts_[w].span.store(pack(static_cast<std::uint32_t>(n * std::uint64_t{w} / threads),
                                      static_cast<std::uint32_t>(n * (std::uint64_t{w} + 1) / threads)),
                                 std::memory_order_relaxed);
    }
    /// Takes the next piece for thread w: items first..last-1. Returns false if there is none.
    bool take(std::uint32_t w, std::uint32_t& first, std::uint32_t& last) noexcept
    {
        auto& mine = parts_[w].span;
        for (;;) {
            auto span = mine.load(std::memory_order_relaxed);
            while (begin(span) < end(span)) {
                // An eighth of the rest: few pieces, and single items at the end.
                auto const size = (end(span) - begin(span) + 7) / 8;
                if (!mine.compare_exchange_weak(span, pack(begin(span) + size, end(span)), std::memory_order_relaxed)) continue;
                first = begin(span);
                last = first + size;
                return true;
            }
            if (!steal(w, mine)) return false;
        }
    }

private:
    struct alignas(64) Part {
        std::atomic<std::uint64_t> span{0};
    };
    static std::uint64_t pack(std::uint32_t begin, std::uint32_t end) noexcept { return std::uint64_t{end} << 32 | begin; }
    static std::uint32_t begin(std::uint64_t span) noexcept { return static_cast<std::uint32_t>(span); }
    static std::uint32_t end(std::uint64_t span) noexcept { return static_cast<std::uint32_t>(span >> 32); }

    bool steal(std::uint32_t w, std::atomic<std::uint64_t>& mine) noexcept
    {
        for (std::size_t k = 1; k < parts_.size(); ++k) {
            auto& theirs = parts_[(w + k) % parts_.size()].span;
            auto span = theirs.load(std::memory_order_relaxed);
            while (begin(span) < end(span)) {
                auto const size = (end(span) - begin(span) + 1) / 2;
                if (!theirs.compare_exchange_weak(span, pack(begin(span), end(span) - size), std::memory_order_relaxed)) continue;
                mine.store(pack(end(span) - size, end(span)), std::memory_order_relaxed);
                return true;
            }
        }
        return false;
    }
    std::vector<Part> parts_;
};

}}} // namespace tilemesh::engine::detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/engine/detail/team_code.hpp>
#endif
