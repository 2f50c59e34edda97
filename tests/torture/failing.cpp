#include "failing.hpp"
#include "../standard.hpp"
#include <atomic>
#include <cerrno>
#include <exception>
#include <new>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>
#if defined(__SANITIZE_ADDRESS__)
#    define TORTURE_ASAN 1
#elif defined(__has_feature)
#    if __has_feature(address_sanitizer)
#        define TORTURE_ASAN 1
#    endif
#endif
#if !defined(TORTURE_ASAN) // AddressSanitizer has a pthread_create of its own
#    include <dlfcn.h>
#    include <pthread.h>
#endif

namespace {

using torture::What;

// --- the calls that fail -----------------------------------------------------------------------------------------------------

std::atomic<bool> armed{false};
std::atomic<std::uint64_t> calls{0};  ///< of functions that can fail, while armed
std::atomic<std::int64_t> held{0};    ///< allocations and mappings that are not freed
What failing = What::memory;
std::uint64_t first_to_fail = 0;      ///< counted from 1; 0: no call fails
bool only_one = true;

bool fails(What what) noexcept
{
    if (!armed || what != failing) return false;
    auto const k = ++calls;
    return first_to_fail != 0 && (only_one ? k == first_to_fail : k >= first_to_fail);
}

void* allocate(std::size_t bytes, std::size_t alignment) noexcept
{
    if (fails(What::memory)) return nullptr;
    bytes = (bytes + alignment - 1) / alignment * alignment;
    void* const p = std::aligned_alloc(alignment, bytes == 0 ? alignment : bytes);
    if (p != nullptr) ++held;
    return p;
}
void* allocate_or_throw(std::size_t bytes, std::size_t alignment)
{
    if (void* const p = allocate(bytes, alignment)) return p;
    throw std::bad_alloc();
}
void release(void* p) noexcept
{
    if (p != nullptr) --held;
    std::free(p);
}
constexpr std::size_t usual = alignof(std::max_align_t);

} // namespace

// The program's own operators: all of the library, and of the standard library, calls them.
void* operator new(std::size_t n) { return allocate_or_throw(n, usual); }
void* operator new[](std::size_t n) { return allocate_or_throw(n, usual); }
void* operator new(std::size_t n, std::nothrow_t const&) noexcept { return allocate(n, usual); }
void* operator new[](std::size_t n, std::nothrow_t const&) noexcept { return allocate(n, usual); }
void* operator new(std::size_t n, std::align_val_t a) { return allocate_or_throw(n, static_cast<std::size_t>(a)); }
void* operator new[](std::size_t n, std::align_val_t a) { return allocate_or_throw(n, static_cast<std::size_t>(a)); }
void* operator new(std::size_t n, std::align_val_t a, std::nothrow_t const&) noexcept { return allocate(n, static_cast<std::size_t>(a)); }
void* operator new[](std::size_t n, std::align_val_t a, std::nothrow_t const&) noexcept { return allocate(n, static_cast<std::size_t>(a)); }
void operator delete(void* p) noexcept { release(p); }
void operator delete[](void* p) noexcept { release(p); }
void operator delete(void* p, std::size_t) noexcept { release(p); }
void operator delete[](void* p, std::size_t) noexcept { release(p); }
void operator delete(void* p, std::nothrow_t const&) noexcept { release(p); }
void operator delete[](void* p, std::nothrow_t const&) noexcept { release(p); }
void operator delete(void* p, std::align_val_t) noexcept { release(p); }
void operator delete[](void* p, std::align_val_t) noexcept { release(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { release(p); }
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept { release(p); }
void operator delete(void* p, std::align_val_t, std::nothrow_t const&) noexcept { release(p); }
void operator delete[](void* p, std::align_val_t, std::nothrow_t const&) noexcept { release(p); }

// Arenas: the regions of a mesh.
extern "C" void* mmap(void* at, std::size_t bytes, int protection, int flags, int file, off_t offset) noexcept
{
    if (fails(What::memory)) {
        errno = ENOMEM;
        return MAP_FAILED;
    }
    auto const p = ::syscall(SYS_mmap, at, bytes, protection, flags, file, offset);
    if (p == -1) return MAP_FAILED;
    ++held;
    return reinterpret_cast<void*>(p);
}
extern "C" int munmap(void* at, std::size_t bytes) noexcept
{
    --held;
    return static_cast<int>(::syscall(SYS_munmap, at, bytes));
}
#if !defined(TORTURE_ASAN)
extern "C" int pthread_create(pthread_t* thread, pthread_attr_t const* attributes, void* (*run)(void*), void* argument) noexcept
{
    if (fails(What::thread)) return EAGAIN;
    using Create = int (*)(pthread_t*, pthread_attr_t const*, void* (*)(void*), void*);
    static auto const create = reinterpret_cast<Create>(::dlsym(RTLD_NEXT, "pthread_create"));
    return create(thread, attributes, run, argument);
}
#endif

namespace torture {

namespace {

struct Row {
    std::uint64_t last = 0, runs = 0, right = 0, errors = 0, no_memory = 0, refused = 0, wrong = 0, leaks = 0;
};

/// The current case, for a process that ends in the middle of it.
char const* now_tried = "";
[[noreturn]] void say_terminated() noexcept
{
    armed = false;
    std::fprintf(stderr, "std::terminate: %s, k %llu%s\n", now_tried, static_cast<unsigned long long>(first_to_fail), only_one ? "" : " and all after");
    std::abort();
}

struct Disarm {
    ~Disarm() { armed = false; }
};
/// Calls act() while call k fails; 0: no call fails.
void act_armed(Act& act, std::uint64_t k, bool alone, What what)
{
    failing = what;
    first_to_fail = k;
    only_one = alone;
    calls = 0;
    armed = true;
    Disarm const disarm;
    act.act();
}

void say_wrong(Row& row, Case const& c, std::uint64_t k, bool alone, std::string const& what)
{
    if (++row.wrong <= 5) MESSAGE(c.name, ", k ", k, alone ? "" : " and all after", ": ", what);
}

/// One run. Returns false if the failing call was not reached.
bool try_one(Case const& c, std::string const& right, std::uint64_t k, bool alone, Row& row)
{
    auto const held_before = held.load();
    bool reached = false;
    {
        auto const act = c.make();
        bool threw = true;
        try {
            act_armed(*act, k, alone, c.what);
            threw = false;
        } catch (tilemesh::Error const&) {
            ++row.errors;
        } catch (std::bad_alloc const&) {
            ++row.no_memory;
        } catch (std::exception const& other) {
            say_wrong(row, c, k, alone, std::string("another exception: ") + other.what());
        }
        reached = calls >= k;
        ++row.runs;
        if (!threw) {
            if (auto const now = act->result(); now == right) ++row.right;
            else say_wrong(row, c, k, alone, "another result, and no word: " + now.substr(0, 200));
        } else {
            try {
                if (auto const harm = act->after_failure(right); !harm.empty()) say_wrong(row, c, k, alone, harm);
            } catch (tilemesh::Error const&) {
                ++row.refused;
            }
        }
    }
    if (held != held_before && ++row.leaks <= 5) MESSAGE(c.name, ", k ", k, ": ", held - held_before, " allocations are leaked");
    return reached;
}

} // namespace

bool has_threads_that_fail() noexcept
{
#if defined(TORTURE_ASAN)
    return false;
#else
    return true;
#endif
}

void torture(std::vector<Case> const& cases)
{
    std::set_terminate(say_terminated);
    char const* const wanted = std::getenv("TILEMESH_TORTURE");
    bool const all = wanted != nullptr && std::string(wanted) == "all";
    std::printf("%-44s %8s %8s %8s %8s %10s %8s %6s %6s\n", "case", "last k", "runs", "right", "Error", "bad_alloc", "refused", "wrong", "leaks");
    for (auto const& c : cases) {
        CAPTURE(c.name);
        now_tried = c.name.c_str();
        std::string right;
        Row row;
        for (int warm = 0; warm < 2; ++warm) { // objects that a process makes only once are made here
            auto const act = c.make();
            act_armed(*act, 0, true, c.what);
            row.last = calls;
            right = act->result();
        }
        CHECK(row.last != 0);
        constexpr std::uint64_t few = 64, thinned = 8;
        auto const step = all || row.last <= few ? 1 : row.last / thinned;
        for (bool const alone : {true, false})
            for (std::uint64_t k = 1; try_one(c, right, k, alone, row); k += step) {}
        auto const number = [](std::uint64_t n, int width) { std::printf(" %*llu", width, static_cast<unsigned long long>(n)); };
        std::printf("%-44s", c.name.c_str());
        for (auto const n : {row.last, row.runs, row.right, row.errors}) number(n, 8);
        number(row.no_memory, 10), number(row.refused, 8), number(row.wrong, 6), number(row.leaks, 6);
        std::printf("\n");
        std::fflush(stdout);
        CHECK(row.wrong == 0);
        CHECK(row.leaks == 0);
    }
}

} // namespace torture
