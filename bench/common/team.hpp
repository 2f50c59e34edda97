#pragma once
#include <atomic>
#include <cstdint>
#include <thread>
#if defined(__x86_64__) || defined(__i386__)
#    include <immintrin.h>
#endif
#include <vector>

namespace bench {

/// Threads that run one task at a time together. The caller is thread 0. A waiting thread spins, then yields, then sleeps. So within a
/// frame it is awake when the next phase begins, and between frames it leaves the core to other programs.
class Team {
public:
    explicit Team(std::uint32_t threads) : size_(threads)
    {
        try {
            for (std::uint32_t t = 1; t < threads; ++t) others_.emplace_back([this, t] { serve(t); });
        } catch (...) { // threads that were started must not outlive this object
            join();
            throw;
        }
    }
    ~Team() { join(); }
    Team(Team const&) = delete;
    Team& operator=(Team const&) = delete;

    std::uint32_t size() const noexcept { return size_; }

    /// Calls f(thread) once on each thread; returns when all calls have returned. f must not throw.
    template <class F>
    void run(F const& f) noexcept
    {
        call_ = [](void const* data, std::uint32_t thread) noexcept { (*static_cast<F const*>(data))(thread); };
        data_ = &f;
        done_.store(0, std::memory_order_relaxed);
        wake();
        f(0u);
        for (std::uint32_t spins = 0; done_.load(std::memory_order_acquire) != size_ - 1; ++spins) {
            if (spins < most_spins) relax();
            else std::this_thread::yield();
        }
    }
    /// Returns when the other threads sleep, so that the next measurement has the cores to itself.
    void rest() noexcept
    {
        while (asleep_.load(std::memory_order_acquire) != size_ - 1) std::this_thread::yield();
    }

private:
    /// About 30 microseconds of pauses: longer than any gap between two phases of a frame.
    static constexpr std::uint32_t most_spins = 2000;
    static constexpr std::uint32_t most_yields = 20;

    static void relax() noexcept
    {
#if defined(__x86_64__) || defined(__i386__)
        _mm_pause();
#endif
    }
    void join() noexcept
    {
        call_ = nullptr;
        wake();
        for (auto& t : others_) t.join();
    }
    void wake() noexcept
    {
        epoch_.fetch_add(1, std::memory_order_release);
        epoch_.notify_all();
    }
    void serve(std::uint32_t thread) noexcept
    {
        for (std::uint32_t seen = 0;; ++seen) {
            std::uint32_t waits = 0;
            for (; waits < most_spins + most_yields && epoch_.load(std::memory_order_acquire) == seen; ++waits) {
                if (waits < most_spins) relax();
                else std::this_thread::yield();
            }
            if (epoch_.load(std::memory_order_acquire) == seen) {
                asleep_.fetch_add(1, std::memory_order_release);
                epoch_.wait(seen, std::memory_order_acquire);
                asleep_.fetch_sub(1, std::memory_order_release);
            }
            if (call_ == nullptr) return;
            call_(data_, thread);
            done_.fetch_add(1, std::memory_order_release);
        }
    }

    std::uint32_t size_;
    void (*call_)(void const*, std::uint32_t) noexcept = nullptr;
    void const* data_ = nullptr;
    alignas(64) std::atomic<std::uint32_t> epoch_{0};
    alignas(64) std::atomic<std::uint32_t> done_{0};
    alignas(64) std::atomic<std::uint32_t> asleep_{0};
    std::vector<std::thread> others_;
};

} // namespace bench
