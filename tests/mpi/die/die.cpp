// A process fails at a place that TILEMESH_DIE names, "RANK PLACE N": when rank RANK comes to this place the N-th time. The dynamic linker
// puts this library before MPI, the C and the C++ library (LD_PRELOAD). The process gets SIGKILL at the places MPI_Bcast, MPI_Isend,
// MPI_Alltoallv, states (MPI_Send of the states that rank 0 gathers), items (MPI_Send of items that rank 0 joins, as the rows of a picture),
// write (half of the bytes are in a .part file), rename (the file is whole, and still has the name of a .part file). At the place memory, an
// allocation of 4,000 bytes or more fails. At the place disk, and from then on, no file takes bytes: errno is ENOSPC.
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <mpi.h>
#include <new>
#include <unistd.h>

namespace {
int const tag_of_states = 2, tag_of_items = 4; // mpi/detail/band_mesh.hpp, mpi/detail/ranks.hpp

int rank()
{
    int initialized = 0, r = -1;
    MPI_Initialized(&initialized);
    if (initialized != 0) PMPI_Comm_rank(MPI_COMM_WORLD, &r);
    return r;
}
/// Is this the call at which the process dies?
bool ends_at(char const* place)
{
    static int calls = 0;
    char const* const text = std::getenv("TILEMESH_DIE");
    char name[32] = {};
    int victim = 0, n = 0;
    if (text == nullptr || std::sscanf(text, "%d %31s %d", &victim, name, &n) != 3) return false;
    return std::strcmp(name, place) == 0 && victim == rank() && ++calls == n;
}
void die_at(char const* place)
{
    if (ends_at(place)) raise(SIGKILL);
}
template <class F>
F next(char const* name)
{
    void* const symbol = dlsym(RTLD_NEXT, name);
    F f = nullptr;
    std::memcpy(&f, &symbol, sizeof f);
    return f;
}
bool is_part(int file)
{
    char link[64], path[4096];
    std::snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    auto const n = readlink(link, path, sizeof path - 1);
    return n > 5 && std::strncmp(path + n - 5, ".part", 5) == 0;
}
} // namespace

void* operator new(std::size_t n)
{
    void* const p = n >= 4000 && ends_at("memory") ? nullptr : std::malloc(n == 0 ? 1 : n);
    if (p == nullptr) throw std::bad_alloc();
    return p;
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }

extern "C" {
int MPI_Alltoallv(void const* out, int const* out_n, int const* out_at, MPI_Datatype out_type, void* in, int const* in_n, int const* in_at,
                  MPI_Datatype in_type, MPI_Comm comm)
{
    die_at("MPI_Alltoallv");
    return PMPI_Alltoallv(out, out_n, out_at, out_type, in, in_n, in_at, in_type, comm);
}
int MPI_Bcast(void* buffer, int n, MPI_Datatype type, int root, MPI_Comm comm)
{
    die_at("MPI_Bcast");
    return PMPI_Bcast(buffer, n, type, root, comm);
}
int MPI_Isend(void const* buffer, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request)
{
    die_at("MPI_Isend");
    return PMPI_Isend(buffer, n, type, to, tag, comm, request);
}
int MPI_Send(void const* buffer, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm)
{
    if (tag == tag_of_states) die_at("states");
    if (tag == tag_of_items) die_at("items");
    return PMPI_Send(buffer, n, type, to, tag, comm);
}
size_t fwrite(void const* bytes, size_t size, size_t n, FILE* file)
{
    static auto const real = next<size_t (*)(void const*, size_t, size_t, FILE*)>("fwrite");
    static bool full = false;
    if (is_part(fileno(file)) && (full || ends_at("disk"))) {
        full = true;
        errno = ENOSPC;
        return 0;
    }
    if (is_part(fileno(file)) && ends_at("write")) {
        real(bytes, size, n / 2, file);
        std::fflush(file);
        raise(SIGKILL);
    }
    return real(bytes, size, n, file);
}
int rename(char const* from, char const* to)
{
    static auto const real = next<int (*)(char const*, char const*)>("rename");
    auto const n = std::strlen(from);
    if (n > 5 && std::strcmp(from + n - 5, ".part") == 0) die_at("rename");
    return real(from, to);
}
}
