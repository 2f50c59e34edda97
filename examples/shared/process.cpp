#include "process.hpp"
#include "text.hpp"
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fcntl.h>
#include <filesystem>
#include <initializer_list>
#include <iostream>
#include <new>
#include <system_error>
#include <tilemesh/error.hpp>

namespace shared {

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

int refuse(std::string const& text)
{
    std::cerr << one_line(text) << std::endl;
    return 2;
}

namespace {

/// Every error of `work` ends in its line, except std::bad_alloc.
int run_with_lines(std::string const& program, std::function<int()> const& work)
{
    try {
        return work();
    } catch (tilemesh::Error const& error) {
        return refuse(error.what());
    } catch (std::bad_alloc const&) {
        throw;
    } catch (std::filesystem::filesystem_error const& error) {
        if (error.code() == std::errc::not_enough_memory) throw std::bad_alloc();
        return refuse("cannot use " + error.path1().string() + " (" + error.code().message() + "); check the path and its permissions");
    } catch (std::system_error const& error) { // from a thread: EAGAIN means too many threads or too little memory
        return refuse(std::string("the system refused a thread, or memory for it (") + error.what() + "); choose fewer --threads or try again");
    } catch (std::exception const& error) {
        return refuse(program + " cannot go on (" + error.what() + "); please report this with the command line");
    }
}

} // namespace

int run_softly(std::string const& program, std::function<int()> const& work) noexcept
{
    make_outputs_fail_softly();
    end_softly_without_memory();
    try {
        return run_with_lines(program, work);
    } catch (...) { // out of memory for the run, or for the text of another error
        return refuse_for_memory();
    }
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

} // namespace shared
