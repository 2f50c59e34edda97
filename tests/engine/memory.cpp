// Memory follows live records: an idle tile of any capacity costs at most 256 bytes of the host's memory (see `most_bytes_a_tile`).
#include "everywhere.hpp"
#include <new>
#include <sys/mman.h>
#include <tilemesh/splat/frame_program.hpp>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#    define UNDER_SANITIZER 1
#elif defined(__has_feature)
#    if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#        define UNDER_SANITIZER 1
#    endif
#endif

using namespace engine_test;

namespace {

#if defined(UNDER_SANITIZER)
constexpr bool sanitized = true;
#else
constexpr bool sanitized = false;
#endif

/// Resident bytes of this process now; 0 if the system does not report them.
std::int64_t resident_bytes()
{
    std::ifstream file("/proc/self/statm");
    std::int64_t all = 0, resident = 0;
    return file >> all >> resident ? resident * ::sysconf(_SC_PAGESIZE) : 0;
}

/// Bytes that an idle tile may take. Linux maps pages that were only read to one page of zeros. Some kernels (seen: a 6.18 in a virtual
/// machine) give each its own memory instead, so there the lists that a kernel reads and finds empty cost memory, too.
std::uint32_t most_bytes_a_tile()
{
    constexpr std::size_t page = 4096, pages = 1000;
    void* const p = ::mmap(nullptr, pages * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (p == MAP_FAILED) return 256;
    auto const before = resident_bytes();
    for (std::size_t i = 0; i < pages; ++i) (void)static_cast<unsigned char const volatile*>(p)[i * page];
    bool const reading_takes_memory = resident_bytes() - before > static_cast<std::int64_t>(pages * page / 2);
    ::munmap(p, pages * page);
    if (reading_takes_memory) MESSAGE("on this system a page that is only read takes memory: 384 bytes an idle tile are allowed");
    return reading_takes_memory ? 384 : 256;
}

struct Item {
    std::uint32_t word[15];
};
struct Store : Buffer<Item, 1000> {};
struct Road : Channel<Item, 400> {};
struct PassOn { // sends the items of the tile east, and stores the items that arrive
    void operator()(Store& store, In<Road> in, Out<Road> out) const noexcept
    {
        for (Item const& item : store)
            if (!out[Direction::east].try_push(item)) break;
        store.truncate(0);
        for (Direction d : news)
            for (Item const& item : in[d]) (void)store.try_push(item);
    }
};

/// A machine of any number of tiles, each with Mk2's SRAM.
struct Field : splat::Lossless {
    using Machine = TestMachine<624 * 1024>;
};

constexpr Grid grid{400, 250};

/// Resident bytes per tile that a mesh without records adds in two runs; negative if they cannot be measured.
template <class M, class Prepare>
double bytes_a_tile(std::uint32_t threads, typename M::Sizes const& sizes, Prepare const& prepare)
{
    auto const before = resident_bytes();
    if (sanitized || before == 0) return -1;
    try {
        M mesh{{}, grid, sizes, {.threads = threads}};
        prepare(mesh);
        for (int i = 0; i < 2; ++i) {
            auto const run = mesh.run();
            CHECK(run.messages() == 0);
            CHECK(run.exchanges() == 0);
        }
        return static_cast<double>(resident_bytes() - before) / grid.size();
    } catch (std::bad_alloc const&) { // the system limits the address space
        return -1;
    }
}

void check_idle(char const* what, double bytes)
{
    if (bytes < 0) {
        MESSAGE("not measured: no /proc/self/statm, too little address space, or a sanitizer");
        return;
    }
    MESSAGE(what, ": ", bytes, " bytes an idle tile");
    CHECK(bytes > 0);
    CHECK(bytes <= most_bytes_a_tile());
}

} // namespace

TEST_CASE("an idle tile of a small program costs at most 256 bytes")
{
    using Program = Sequence<Superstep<PassOn>, UntilQuiet<PassOn>>;
    CHECK(Tile<Field::Machine, Program>::bytes > 200'000); // the capacity of a tile
    for (std::uint32_t threads : {1u, 2u}) {
        CAPTURE(threads);
        check_idle("small program", bytes_a_tile<Mesh<Program, Field::Machine>>(threads, mesh_sizes<Program, Field::Machine>(), [](auto&) {}));
    }
}

TEST_CASE("an idle tile of the splat frame costs at most 256 bytes")
{
    using Program = splat::Frame<Field>;
    CHECK(Tile<Field::Machine, Program, Field>::bytes > 500'000);
    auto const bytes = bytes_a_tile<Mesh<Program, Field::Machine>>(1, mesh_sizes<Program, Field::Machine, Field>(), [](auto& mesh) {
        // The tiling has no pixels, so the camera shows nothing.
        splat::Camera camera{};
        camera.fx = camera.fy = 1000;
        auto& frame = mesh.template broadcast<splat::FrameParameters>();
        frame.view = splat::make_view(camera, {});
        frame.tiling = splat::make_tiling(0, 0, 32, 20);
        frame.view_changed = 1;
    });
    check_idle("splat frame", bytes);
}

TEST_CASE("memory follows live records: what one tile holds is paid for once, not by every tile")
{
    using Program = Sequence<Superstep<PassOn>, UntilQuiet<PassOn>>;
    if (sanitized || resident_bytes() == 0) {
        MESSAGE("not measured: no /proc/self/statm, or a sanitizer");
        return;
    }
    Mesh<Program, Field::Machine> mesh{{}, {200, 100}};
    mesh.run();
    auto const before = resident_bytes();
    for (std::uint32_t x = 0; x < 10; ++x) {
        auto store = mesh.state<Store>(TileId::at(x, 7));
        for (std::uint32_t i = 0; i < 400; ++i) store.push({{x, i}});
    }
    CHECK(mesh.run().messages() == 4000);
    auto const bytes = resident_bytes() - before;
    // 240 KB in the stores, 240 KB in the channels, and 240 KB in the stores of the receivers: with page edges this is well below 2 MB.
    CHECK(bytes < 2'000'000);
    std::uint32_t held = 0;
    for (std::uint32_t x = 0; x < 11; ++x) held += mesh.state<Store>(TileId::at(x, 7)).size();
    CHECK(held == 4000);
}
