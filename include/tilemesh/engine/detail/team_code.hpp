#pragma once
#include <cstdint>
#include <exception>
#include <new>
#include <pthread.h>
#include <string>
#include <system_error>
#include <thread>
#include <tilemesh/engine/team.hpp>
#include <tilemesh/error.hpp>

namespace tilemesh { inline namespace v0_2 { namespace engine::detail {

TILEMESH_HOST Team::Team(std::uint32_t threads)
{
    static int const watches = ::pthread_atfork(nullptr, nullptr, [] { forks.fetch_add(1); });
    if (watches != 0) throw std::bad_alloc{}; // without it, a forked child would wait for threads that it does not have
    threads_.reserve(threads);
    try {
        start(threads);
    } catch (std::system_error const& e) {
        auto const started = size();
        join();
        throw Error(std::to_string(threads) + " threads (the system gave " + std::to_string(started) + ": " + e.what() +
                    "); ask for fewer");
    } catch (...) { // out of memory for a thread's state
        join();
        throw;
    }
}
TILEMESH_HOST void Team::start(std::uint32_t threads)
{
    forks_ = forks.load();
    while (size() < threads) threads_.emplace_back([this, w = size()] { run_calls(w); });
}
/// As many helpers as there were, or as the system gives: a call does all its work with any set of helpers.
TILEMESH_HOST void Team::start_in_child() noexcept
{
    auto const threads = size();
    abandon();
    try {
        start(threads);
    } catch (std::exception const&) {
    }
}
/// Forgets threads that only the parent has: neither `join` nor `detach` is for them, nor the destructor of a thread.
TILEMESH_HOST void Team::abandon() noexcept
{
    for (auto& t : threads_) new (&t) std::thread;
    threads_.clear();
}
TILEMESH_HOST void Team::run_calls(std::uint32_t w) noexcept
{
    for (std::uint64_t seen = 0;;) {
        auto gate = gate_.load(std::memory_order_acquire);
        for (std::uint32_t i = 0; !may_enter(gate, seen); ++i, gate = gate_.load(std::memory_order_acquire)) {
            if (stop_.load(std::memory_order_relaxed)) return;
            if (i < spins_before_yield + yields_before_sleep)
                pause(i);
            else
                sleep(seen);
        }
        if (!gate_.compare_exchange_strong(gate, gate + 1, std::memory_order_acq_rel, std::memory_order_relaxed)) continue;
        seen = gate / next_epoch;
        call_(what_, w);
        gate_.fetch_sub(1, std::memory_order_release);
    }
}
TILEMESH_HOST void Team::join() noexcept
{
    stop_.store(true);
    bell_.fetch_add(1);
    bell_.notify_all();
    if (forks_ != forks.load()) abandon();
    for (auto& t : threads_) t.join();
}

}}} // namespace tilemesh::engine::detail
