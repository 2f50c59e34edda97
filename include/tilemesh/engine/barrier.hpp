#pragma once
#include <atomic>
#include <cstdint>
#if defined(__x86_64__) || defined(__i386__)
#    include <immintrin.h>
#endif

namespace tilemesh::engine::detail {

inline void relax() noexcept
{
#if defined(__x86_64__) || defined(__i386__)
    _mm_pause();
#endif
}

/// How often a waiting thread looks before it sleeps: a superstep's barrier is met in well under a microsecond, but pure
/// spinning collapses when another process wants the core.
inline constexpr int spins_before_sleep = 4000;

/// All of `n` threads meet here. With one thread it is free.
class alignas(64) Barrier {
public:
    explicit Barrier(std::uint32_t n) noexcept : n_(n) {}
    void arrive_and_wait() noexcept
    {
        if (n_ == 1) return;
        auto const generation = generation_.load(std::memory_order_relaxed);
        if (arrived_.fetch_add(1, std::memory_order_acq_rel) + 1 == n_) {
            arrived_.store(0, std::memory_order_relaxed);
            generation_.store(generation + 1, std::memory_order_release);
            generation_.notify_all();
            return;
        }
        for (int spins = 0; generation_.load(std::memory_order_acquire) == generation; ++spins) {
            if (spins < spins_before_sleep)
                relax();
            else
                generation_.wait(generation);
        }
    }

private:
    alignas(64) std::atomic<std::uint32_t> arrived_{0};
    alignas(64) std::atomic<std::uint32_t> generation_{0};
    std::uint32_t n_;
};

} // namespace tilemesh::engine::detail
