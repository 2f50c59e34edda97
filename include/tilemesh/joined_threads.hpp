#pragma once
#include <cstddef>
#include <thread>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// Threads that the destructor joins, also when an exception ends the scope. It replaces a vector of std::jthread in standard libraries
/// without std::jthread (libc++ 16); it has no stop tokens.
///
/// Objects that the threads use must outlive this object: declare it after them.
class JoinedThreads {
public:
    JoinedThreads() = default;
    ~JoinedThreads() { join(); }
    JoinedThreads(JoinedThreads const&) = delete;
    JoinedThreads& operator=(JoinedThreads const&) = delete;

    /// Calls f(arguments...) on a new thread, with copies of f and of the arguments. Throws std::system_error if the system cannot create a
    /// thread; threads that were started before continue, and are still joined.
    template <class F, class... Arguments>
    void start(F&& f, Arguments&&... arguments)
    {
        threads_.emplace_back(std::forward<F>(f), std::forward<Arguments>(arguments)...);
    }
    /// Waits until all threads have ended, and forgets them.
    void join()
    {
        for (auto& thread : threads_) thread.join();
        threads_.clear();
    }
    std::size_t size() const noexcept { return threads_.size(); }

private:
    std::vector<std::thread> threads_;
};

}} // namespace tilemesh
