#pragma once
#include "../standin_vertex.hpp"
#include <array>
#include <csetjmp>
#include <csignal>
#include <cstddef>
#include <exception>
#include <memory>
#include <semaphore.h>
#include <thread>
#include <utility>

/// Calls a vertex's compute: with a net that catches its faults, or on six threads at once.
namespace standin::detail {

/// Worker contexts of a tile of a Mk2 IPU.
inline constexpr unsigned workers_per_tile = 6;

/// The point to which a fault of this thread jumps while a vertex computes on it.
struct FaultPoint {
    sigjmp_buf environment;
    void* address = nullptr;
};
inline thread_local FaultPoint* fault_point = nullptr;

inline void on_fault(int signal, siginfo_t* info, void*)
{
    if (FaultPoint* const point = fault_point) {
        point->address = info->si_addr;
        siglongjmp(point->environment, 1);
    }
    ::signal(signal, SIG_DFL); // no vertex computes: the instruction runs again and ends the process
}

/// During its lifetime, faults in a vertex are caught.
class FaultNet {
public:
    FaultNet()
    {
        struct sigaction action {};
        action.sa_sigaction = &on_fault;
        action.sa_flags = SA_SIGINFO | SA_ONSTACK;
        sigemptyset(&action.sa_mask);
        ::sigaction(SIGSEGV, &action, &segv_);
        ::sigaction(SIGBUS, &action, &bus_);
    }
    FaultNet(FaultNet const&) = delete;
    FaultNet& operator=(FaultNet const&) = delete;
    ~FaultNet()
    {
        ::sigaction(SIGSEGV, &segv_, nullptr);
        ::sigaction(SIGBUS, &bus_, nullptr);
    }

private:
    struct sigaction segv_ {
    }, bus_{};
};

/// A stack for this thread's signal handlers. With it, the net catches a vertex that overflows its own stack.
class HandlerStack {
public:
    HandlerStack() : memory_(new char[bytes])
    {
        stack_t mine{};
        mine.ss_sp = memory_.get();
        mine.ss_size = bytes;
        ::sigaltstack(&mine, &before_);
    }
    HandlerStack(HandlerStack const&) = delete;
    HandlerStack& operator=(HandlerStack const&) = delete;
    ~HandlerStack() { ::sigaltstack(&before_, nullptr); }

private:
    static constexpr std::size_t bytes = 65536; // a handler frame with AVX-512 state takes about 12 KiB
    std::unique_ptr<char[]> memory_;
    stack_t before_{};
};

/// Runs compute. On a fault it returns false and the address of the access, and no destructor of the vertex's frames runs.
inline bool compute_in_net(VertexType const& type, void* vertex, unsigned worker, void*& address)
{
    FaultPoint point;
    fault_point = &point;
    if (sigsetjmp(point.environment, 1) != 0) {
        address = fault_point->address;
        fault_point = nullptr;
        return false;
    }
    try {
        type.compute(vertex, worker);
    } catch (...) {
        fault_point = nullptr;
        throw;
    }
    fault_point = nullptr;
    return true;
}

/// Six threads that wait for work. Each has its own semaphores, so nothing orders one worker after another. So
/// ThreadSanitizer sees a race between workers even if they happen to run one after the other.
class WorkerThreads {
public:
    WorkerThreads()
    {
        for (unsigned w = 0; w < workers_per_tile; ++w) {
            ::sem_init(&workers_[w].go, 0, 0);
            ::sem_init(&workers_[w].done, 0, 0);
            workers_[w].thread = std::thread([this, w] { serve(w); });
        }
    }
    WorkerThreads(WorkerThreads const&) = delete;
    WorkerThreads& operator=(WorkerThreads const&) = delete;
    ~WorkerThreads()
    {
        task_ = nullptr;
        for (Worker& w : workers_) ::sem_post(&w.go);
        for (Worker& w : workers_) {
            w.thread.join();
            ::sem_destroy(&w.go);
            ::sem_destroy(&w.done);
        }
    }

    /// Runs task(worker) on all threads, and wakes them in the given order. Throws the exception of the lowest worker that threw one.
    template <class Task>
    void run(Task const& task, std::array<unsigned, workers_per_tile> const& order)
    {
        task_ = &task;
        call_ = [](void const* t, unsigned w) { (*static_cast<Task const*>(t))(w); };
        for (unsigned w : order) ::sem_post(&workers_[w].go);
        for (Worker& w : workers_)
            while (::sem_wait(&w.done) != 0) {
            }
        std::exception_ptr first;
        for (Worker& w : workers_) {
            std::exception_ptr const error = std::exchange(w.error, nullptr);
            if (!first) first = error;
        }
        if (first) std::rethrow_exception(first);
    }

private:
    struct Worker {
        sem_t go, done;
        std::exception_ptr error{};
        std::thread thread{};
    };
    void serve(unsigned w)
    {
        HandlerStack const stack;
        for (;;) {
            while (::sem_wait(&workers_[w].go) != 0) {
            }
            if (task_ == nullptr) return;
            try {
                call_(task_, w);
            } catch (...) {
                workers_[w].error = std::current_exception();
            }
            ::sem_post(&workers_[w].done);
        }
    }

    std::array<Worker, workers_per_tile> workers_{};
    void const* task_ = nullptr;
    void (*call_)(void const*, unsigned) = nullptr;
};

} // namespace standin::detail
