// A library for LD_PRELOAD that makes calls of a process fail: the k-th call of a kind, or the k-th and all after it. The Page of
// torture.hpp says which. The environment variable TILEMESH_TORTURE_PAGE is the descriptor of the file that holds the page; without it
// nothing fails. For Linux and glibc.
#include "torture.hpp"
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

extern "C" {
extern char** environ;
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
}

namespace {

using torture::Kind;
using torture::Page;

/// The page; null: nothing fails. The dynamic linker allocates before there is an environment: that is not the program's.
Page* page() noexcept
{
    static Page* found = nullptr;
    static bool looked = false;
    if (looked || environ == nullptr) return found;
    looked = true;
    if (char const* const number = std::getenv("TILEMESH_TORTURE_PAGE")) {
        auto const at = ::syscall(SYS_mmap, nullptr, sizeof(Page), PROT_READ | PROT_WRITE, MAP_SHARED, std::atoi(number), 0L);
        if (at != -1) found = reinterpret_cast<Page*>(at);
    }
    return found;
}

bool fails(Kind kind, int why) noexcept
{
    auto* const p = page();
    if (p == nullptr || p->kind != kind) return false;
    auto const k = ++p->calls;
    if (p->first == 0 || (p->alone ? k != p->first : k < p->first)) return false;
    errno = why;
    return true;
}

/// The function that this one stands before.
template <class F>
F* next(char const* name) noexcept
{
    return reinterpret_cast<F*>(::dlsym(RTLD_NEXT, name));
}
#define NEXT(function) static auto* const real = next<decltype(function)>(#function)
/// A function that returns `failed` and sets errno to `why`, or else is the real one.
#define FAILING(type, function, parameters, arguments, kind, why, failed) \
    type function parameters \
    { \
        NEXT(function); \
        return fails(kind, why) ? failed : real arguments; \
    }

/// What is written on standard error must arrive: it says what failed.
bool is_heard(std::FILE* file) noexcept { return file == stderr; }

} // namespace

extern "C" {

void* malloc(std::size_t n) { return fails(Kind::memory, ENOMEM) ? nullptr : __libc_malloc(n); }
void* calloc(std::size_t n, std::size_t each) { return fails(Kind::memory, ENOMEM) ? nullptr : __libc_calloc(n, each); }
void* realloc(void* p, std::size_t n) { return fails(Kind::memory, ENOMEM) ? nullptr : __libc_realloc(p, n); }
void* memalign(std::size_t a, std::size_t n) { return fails(Kind::memory, ENOMEM) ? nullptr : __libc_memalign(a, n); }
void* aligned_alloc(std::size_t a, std::size_t n) { return memalign(a, n); }
int posix_memalign(void** p, std::size_t a, std::size_t n)
{
    if (fails(Kind::memory, ENOMEM)) return ENOMEM;
    *p = __libc_memalign(a, n);
    return *p != nullptr ? 0 : ENOMEM;
}
void* mmap(void* at, std::size_t bytes, int protection, int flags, int file, off_t offset) noexcept
{
    if (fails(Kind::memory, ENOMEM)) return MAP_FAILED;
    auto const p = ::syscall(SYS_mmap, at, bytes, protection, flags, file, offset);
    return p == -1 ? MAP_FAILED : reinterpret_cast<void*>(p);
}

FAILING(std::FILE*, fopen, (char const* name, char const* mode), (name, mode), Kind::open, EMFILE, nullptr)
FAILING(std::FILE*, fopen64, (char const* name, char const* mode), (name, mode), Kind::open, EMFILE, nullptr)
FAILING(int, rename, (char const* from, char const* to) noexcept, (from, to), Kind::rename, EIO, -1)
FAILING(int, fsync, (int file), (file), Kind::fsync, EIO, -1)
FAILING(int, fdatasync, (int file), (file), Kind::fsync, EIO, -1)
FAILING(int, mkdir, (char const* name, mode_t mode) noexcept, (name, mode), Kind::mkdir, ENOSPC, -1)
FAILING(int, pthread_create, (pthread_t* thread, pthread_attr_t const* attributes, void* (*run)(void*), void* argument) noexcept,
        (thread, attributes, run, argument), Kind::thread, EAGAIN, EAGAIN)
/// As FAILING, for a function with a mode if it makes a file.
#define FAILING_OPEN(function, parameters, arguments) \
    int function parameters \
    { \
        mode_t mode = 0; \
        if ((flags & (O_CREAT | O_TMPFILE)) != 0) { \
            va_list more; \
            va_start(more, flags); \
            mode = va_arg(more, mode_t); \
            va_end(more); \
        } \
        NEXT(function); \
        return fails(Kind::open, EMFILE) ? -1 : real arguments; \
    }
FAILING_OPEN(open, (char const* name, int flags, ...), (name, flags, mode))
FAILING_OPEN(open64, (char const* name, int flags, ...), (name, flags, mode))
FAILING_OPEN(openat, (int folder, char const* name, int flags, ...), (folder, name, flags, mode))
FAILING_OPEN(openat64, (int folder, char const* name, int flags, ...), (folder, name, flags, mode))
ssize_t write(int file, void const* bytes, std::size_t n)
{
    NEXT(write);
    return file != STDERR_FILENO && fails(Kind::write, ENOSPC) ? -1 : real(file, bytes, n);
}
std::size_t fwrite(void const* bytes, std::size_t size, std::size_t n, std::FILE* file)
{
    NEXT(fwrite);
    return !is_heard(file) && fails(Kind::write, ENOSPC) ? 0 : real(bytes, size, n, file);
}
int fflush(std::FILE* file)
{
    NEXT(fflush);
    return file != nullptr && !is_heard(file) && fails(Kind::write, ENOSPC) ? EOF : real(file);
}
int fclose(std::FILE* file)
{
    NEXT(fclose);
    bool const failed = fails(Kind::write, EIO); // the file is closed whatever fclose says
    int const closed = real(file);
    if (failed) errno = EIO;
    return failed ? EOF : closed;
}
}
