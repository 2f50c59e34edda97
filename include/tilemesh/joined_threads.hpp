#pragma once
#include <cstddef>
#include <thread>
#include <utility>
#include <vector>

namespace tilemesh {

/// Threads that are joined before their owner goes, also where an exception ends its scope: a vector of std::jthread without stop
/// tokens, for standard libraries without std::jthread (libc++ 16).
///
/// What the threads use must outlive this object: declare it after them.
class JoinedThreads {
public:
    JoinedThreads() = default;
    ~JoinedThreads() { join(); }
    JoinedThreads(JoinedThreads const&) = delete;
    JoinedThreads& operator=(JoinedThreads const&) = delete;

    /// Calls f(arguments...) on a new thread, with copies of both. Throws std::system_error when the system gives no thread; the
    /// threads that were started before go on, and are still joined.
    template <class F, class... Arguments>
    void start(F&& f, Arguments&&... arguments)
    {
        threads_.emplace_back(std::forward<F>(f), std::forward<Arguments>(arguments)...);
    }
    /// Waits until all of them have ended, and forgets them.
    void join()
    {
        for (auto& thread : threads_) thread.join();
        threads_.clear();
    }
    std::size_t size() const noexcept { return threads_.size(); }

private:
    std::vector<std::thread> threads_;
};

} // namespace tilemesh
