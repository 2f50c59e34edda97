#include "process.hpp"
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fcntl.h>
#include <initializer_list>
#include <new>
#include <unistd.h>

namespace render_map {

namespace {

std::atomic<int> noted{0};
std::atomic<bool> announced{false};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free,
              "a signal handler may use them");

constexpr int interrupts[] = {SIGINT, SIGTERM};

// It calls only functions that POSIX allows in a handler, and restores errno.
extern "C" void note_interrupt(int signal)
{
    int const before = errno;
    noted = signal;
    for (int each : interrupts) std::signal(each, SIG_DFL);
    constexpr char text[] = "\nfinishing this frame; interrupt again to stop at once\n";
    if (announced && write(STDERR_FILENO, text, sizeof text - 1) < 0) announced = false;
    errno = before;
}

// Set by the first allocation that fails. The runtime may have no memory for an exception; then it terminates without one.
std::atomic<bool> without_memory{false};

[[noreturn]] void throw_bad_alloc()
{
    without_memory = true;
    throw std::bad_alloc();
}
// Any other cause of std::terminate is a bug, so it aborts.
[[noreturn]] void end_at_once() noexcept
{
    bool is_memory = without_memory;
    if (auto const error = std::current_exception()) {
        try {
            std::rethrow_exception(error);
        } catch (std::bad_alloc const&) {
            is_memory = true;
        } catch (...) {
            is_memory = false;
        }
    }
    if (!is_memory) std::abort();
    _exit(refuse_for_memory());
}

} // namespace

void make_outputs_fail_softly()
{
    // open takes the lowest free number. The other direction makes every use of the stream an error.
    for (int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (fcntl(stream, F_GETFD) == -1 && errno == EBADF)
            (void)open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
}

void end_softly_without_memory()
{
    std::set_new_handler(throw_bad_alloc);
    std::set_terminate(end_at_once);
}

int refuse_for_memory() noexcept
{
    constexpr char text[] = "not enough memory (an allocation failed); choose a smaller map, frame or grid\n";
    if (write(STDERR_FILENO, text, sizeof text - 1) < 0) return 2; // there is nowhere to report it
    return 2;
}

void note_interrupts(bool announce)
{
    announced = announce;
    for (int signal : interrupts) {
        struct sigaction action;
        if (sigaction(signal, nullptr, &action) != 0 || action.sa_handler == SIG_IGN) continue;
        std::memset(&action, 0, sizeof action);
        action.sa_handler = note_interrupt;
        action.sa_flags = SA_RESTART;
        (void)sigaction(signal, &action, nullptr);
    }
}

int interrupt() noexcept
{
    return noted;
}

char const* signal_name(int signal) noexcept
{
    return signal == SIGTERM ? "SIGTERM" : "SIGINT";
}

} // namespace render_map
