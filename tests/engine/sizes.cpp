// test: unoptimised test asan tsan
// Machine and slots as values: one program and one copy of its code serve meshes of any sizes.
#include "everywhere.hpp"
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/splat/frame_program.hpp>

using namespace engine_test;

namespace {

struct Slots {
    std::uint32_t stock = 0, belt = 0, lane = 0;
    bool counted = true, shared = false;
};
struct Stock : Buffer<std::uint32_t> {
    static constexpr auto slots = &Slots::stock;
    static constexpr auto budgeted_if = &Slots::counted;
};
struct Belt : Channel<std::uint32_t> {
    static constexpr auto slots = &Slots::belt;
};
struct Hopper : Buffer<std::uint32_t> { // needs at least two slots
    static constexpr auto slots = &Slots::stock;
    static constexpr std::uint32_t least_slots = 2;
};
struct Wire : Channel<std::uint32_t> {
    static constexpr auto slots = &Slots::lane;
    static constexpr std::uint32_t least_slots = 3;
};
struct Hop {
    void operator()(Hopper&, In<Wire>, Out<Wire>) const noexcept {}
};
struct Lane : Channel<std::uint32_t> {
    using memory_of = Belt;
    static constexpr auto slots = &Slots::lane;
    static constexpr auto memory_shared = &Slots::shared;
};
struct Seen {
    std::uint32_t belt, lane;
};

/// Fills its list and its channel.
struct Stuff {
    void operator()(Stock& stock, Out<Belt> out) const noexcept
    {
        std::uint32_t n = 0;
        while (stock.try_push(n)) ++n;
        for (Direction d : news)
            while (out[d].try_push(1)) {
            }
    }
};
struct Pass {
    void operator()(Seen& seen, In<Belt> in) const noexcept
    {
        for (Direction d : news) seen.belt += in[d].size();
    }
};
struct Follow {
    void operator()(Stock const& stock, Out<Lane> out) const noexcept
    {
        for (auto n : stock)
            for (Direction d : news) (void)out[d].try_push(n);
    }
};
struct Finish {
    void operator()(Stock& stock, Seen& seen, In<Lane> in) const noexcept
    {
        for (Direction d : news) seen.lane += in[d].size();
        stock.truncate(0);
    }
};
using Freight = Sequence<Superstep<Stuff>, Superstep<Pass>, Superstep<Follow>, Superstep<Finish>>;
/// Sends on the lane while the belt carries mail. This is an error only if the two channels share their memory.
using Crowded = Sequence<Superstep<Stuff>, Superstep<Follow>, Superstep<Pass>, Superstep<Finish>>;

constexpr Grid grid{3, 2};

template <std::uint32_t N, bool Shared = false>
struct Constant {
    using Machine = TestMachine<8192>;
    static constexpr Slots sizes{N, 3, 2, true, Shared};
};
constexpr std::uint32_t fixed_bytes = 8; // Seen
constexpr std::uint64_t bytes_of(Slots const& s)
{
    auto const belt = 32 * (2 + s.belt), lane = 32 * (2 + s.lane);
    return fixed_bytes + (s.counted ? 4 * (2 + s.stock) : 0) + (s.shared ? std::max(belt, lane) : belt + lane);
}
constexpr MachineSize machine_with(std::uint64_t sram)
{
    return {"some machine", 100, static_cast<std::uint32_t>(sram), 0, 6, 1000};
}

} // namespace

// Setups that differ only in sizes or machine have one frame program. Another policy makes another program.
namespace sizes_test {
struct Fewer : splat::Lossless {
    static constexpr splat::Sizes sizes{.storage = 700, .road = 100, .beam = 50, .waiting = 20, .tile_pixels = 64};
    using Machine = TestMachine<1u << 20>;
};
struct Dropping : splat::Lossless {
    using Saturation = splat::Drop;
};
} // namespace sizes_test
static_assert(std::is_same_v<splat::Frame<splat::Lossless>, splat::Frame<sizes_test::Fewer>>);
static_assert(std::is_same_v<splat::Storage<splat::Lossless>, splat::Storage<sizes_test::Fewer>>);
static_assert(std::is_same_v<splat::Frame<splat::Paper>, splat::Frame<splat::Prototype>>, "another name and other slots");
static_assert(!std::is_same_v<splat::Frame<splat::Lossless>, splat::Frame<sizes_test::Dropping>>);
static_assert(std::is_same_v<MeshSizes<splat::Frame<splat::Lossless>>, MeshSizes<splat::Frame<sizes_test::Fewer>>>);

TEST_CASE("mesh_sizes of a constant and of the same values at run time are one")
{
    using Setup = Constant<5, true>;
    constexpr auto constant = mesh_sizes<Freight, Setup::Machine, Setup>();
    auto const value = mesh_sizes<Freight>(size_of_machine<Setup::Machine>(), Slots{5, 3, 2, true, true});
    CHECK(constant.slots == value.slots);
    CHECK(constant.shares_memory == value.shares_memory);
    CHECK(constant.sram_bytes == value.sram_bytes);
    CHECK(value.sram_bytes == bytes_of({5, 3, 2, true, true}));
    CHECK(value.machine.sram_bytes == 8192);
    auto changed = value;
    CHECK(changed.slots_of<Stock>() == 5);
    CHECK(changed.slots_of<Seen>() == 1);
    CHECK(changed.link<Belt>().slots == 3);
    CHECK(changed.link<Lane>().slots == 2);
    CHECK(changed.link<Lane>().message_bytes == 4);
}

TEST_CASE("sizes that come at run time: 0, 1, n - 1, n and n + 1 slots on every engine, with every flag")
{
    for (std::uint32_t n : {0u, 1u, 4u, 5u, 6u})
        for (bool counted : {false, true})
            for (bool shared : {false, true}) {
                CAPTURE(n);
                CAPTURE(counted);
                CAPTURE(shared);
                Slots const slots{n, n + 1, 3, counted, shared};
                auto const sizes = mesh_sizes<Freight>(machine_with(8192), slots);
                auto const p = everywhere<Freight, AnyMachine>(grid, [](auto&) {}, 1, {}, sizes);
                auto const lane = std::min(n, 3u);
                CHECK(p.step(0).messages == 6 * 4 * (n + 1));
                CHECK(p.step(0).capacity_bytes == 16 * 6 * (2 + n + 1));
                CHECK(p.step(2).messages == 6 * 4 * lane);
                CHECK(p.mesh->template state<Seen>(TileId::at(2, 1)).belt == 4 * (n + 1));
                CHECK(p.mesh->template state<Seen>(TileId::at(0, 0)).lane == 4 * lane);
                CHECK(p.mesh->template state<Stock>(TileId::at(0, 0)).capacity() == n);
                CHECK(p.mesh->sram_bytes() == bytes_of(slots));
                REQUIRE(p.last().peaks.size() == 3);
                CHECK(p.last().peaks[0].region == "Stock");
                CHECK(p.last().peaks[0].items == n);
                CHECK(p.last().peaks[0].capacity == n);
                CHECK(p.last().peaks[1].capacity == n + 1);
                CHECK(p.last().peaks[2].capacity == 3);
            }
}

TEST_CASE("a channel to which the sizes give no slot is refused by a run, and nobody is told to limit it")
{
    Slots const slots{5, 4, 0};
    on_each<Freight, AnyMachine>(
        grid, [](auto& mesh) { CHECK(has(error_of([&] { mesh.run(); }), "channel Lane has no slots (the sizes of the mesh give it none")); }, {},
        mesh_sizes<Freight>(machine_with(8192), slots));
}

TEST_CASE("a limit is at most the slots of the sizes, and frees no SRAM")
{
    Slots const slots{5, 4, 3};
    on_each<Freight, AnyMachine>(
        grid,
        [&](auto& mesh) {
            CHECK(has(error_of([&] { mesh.template limit<Stock>(6); }), "a limit of 6 items for Stock (the program's layout has 5)"));
            CHECK(has(error_of([&] { mesh.template limit<Belt>(5); }), "a limit of 5 items for Belt (the program's layout has 4)"));
            for (std::uint32_t limit : {5u, 4u, 1u, 0u}) {
                mesh.template limit<Stock>(limit);
                if (limit > 0) mesh.template limit<Belt>(std::min(limit, 4u));
                auto const run = mesh.run();
                CHECK(run.peaks[0].items == limit);
                CHECK(run.peaks[1].items == std::clamp(limit, 1u, 4u));
                CHECK(mesh.sram_bytes() == bytes_of(slots));
            }
        },
        {}, mesh_sizes<Freight>(machine_with(8192), slots));
}

TEST_CASE("sizes that come at run time and do not fit are refused with the sentence of Tile; exactly full fits")
{
    auto const text = [](std::uint64_t sram, Slots const& slots) {
        return error_of([&] { (void)mesh_sizes<Freight>(machine_with(sram), slots); });
    };
    for (bool counted : {false, true})
        for (bool shared : {false, true}) {
            CAPTURE(counted);
            CAPTURE(shared);
            Slots const slots{10, 6, 9, counted, shared};
            auto const bytes = bytes_of(slots);
            CHECK(text(bytes, slots).empty());
            CHECK(text(bytes + 1, slots).empty());
            auto const over = text(bytes - 1, slots);
            CHECK(has(over, "the program does not fit in a tile's SRAM (machine some machine, region "));
            CHECK(has(over, ", and the sum is 1 bytes over); give it fewer slots"));
            CHECK(has(text(bytes - 12, slots), ", and the sum is 12 bytes over)"));
        }
    // The error names the largest region, with its bytes. If two regions share memory, the second counts only its bytes beyond the first.
    CHECK(has(text(100, {1, 3, 2}), "region Belt has 160 bytes"));
    CHECK(has(text(100, {1, 2, 3}), "region Lane has 160 bytes"));
    CHECK(has(text(100, {1, 2, 3, true, true}), "region Belt has 128 bytes"));
    CHECK(has(text(100, {1000, 2, 3}), "region Stock has 4008 bytes"));
    CHECK(has(text(100, {1000, 2, 3, false}), "region Lane has 160 bytes")); // the stock is outside the budget
    CHECK(text(500, {1000, 2, 3, false}).empty());
    // The bytes reserved for code alone can be too large.
    auto reserve = machine_with(1000);
    reserve.code_bytes = 1001;
    CHECK(has(error_of([&] { (void)mesh_sizes<Freight>(reserve, Slots{}); }), "the sum is 145 bytes over"));
    // Sums beyond 32 bits do not wrap around.
    CHECK(has(text(8192, {0x40000000u, 1, 1}), "does not fit"));
    CHECK(has(text(8192, {0xffffffffu, 1, 1}), "does not fit"));
    CHECK(has(text(8192, {1, 0x08000000u, 1}), "region Belt"));
    CHECK(has(text(8192, {1, 1, 0x07fffffeu}), "region Lane"));
    // A frame program gets the same sentence as any other program.
    auto sizes = splat::Lossless::sizes;
    auto const frame = [&] { return error_of([&] { (void)mesh_sizes<splat::Frame<splat::Lossless>>(size_of_machine<Mk2>(), sizes); }); };
    CHECK(frame().empty());
    sizes.storage += 1000;
    CHECK(has(frame(), "(machine mk2, region storage has 180008 bytes, and the sum is "));
}

TEST_CASE("a machine with more workers than a kernel has words for is refused, and one without workers")
{
    auto const refused = [](std::uint32_t workers) {
        auto machine = size_of_machine<Mk2>();
        machine.workers = workers;
        return error_of([&] { (void)mesh_sizes<splat::Frame<splat::Lossless>>(machine, splat::Lossless::sizes); });
    };
    CHECK(refused(1).empty());
    CHECK(refused(6).empty());
    CHECK(has(refused(7), "machine mk2 with 7 workers"));
    CHECK(has(refused(0), "machine mk2 with 0 workers"));
    // A program without a word per worker runs on any machine.
    auto many = machine_with(8192);
    many.workers = 100;
    CHECK(error_of([&] { (void)mesh_sizes<Freight>(many, Slots{3, 3, 3}); }).empty());
}

TEST_CASE("a list or channel with fewer slots than its least_slots is refused before a mesh is built")
{
    using Program = Sequence<Superstep<Hop>>;
    auto const refused = [](std::uint32_t hopper, std::uint32_t wire) {
        return error_of([&] { (void)mesh_sizes<Program>(machine_with(8192), Slots{hopper, 0, wire}); });
    };
    for (std::uint32_t n : {2u, 3u}) CHECK(refused(n, 3).empty());
    for (std::uint32_t n : {0u, 1u})
        CHECK(refused(n, 3) == "list Hopper with " + std::to_string(n) + " slots (with fewer than 2 its program makes no progress); give it more slots");
    CHECK(refused(2, 4).empty());
    CHECK(has(refused(2, 2), "list Wire with 2 slots (with fewer than 3"));
    // A frame that holds records has FIFOs of at least one slot. A frame that drops records has no FIFOs.
    auto sizes = splat::Lossless::sizes;
    auto const frame = [&](auto setup) {
        return error_of([&] { (void)mesh_sizes<splat::Frame<decltype(setup)>>(size_of_machine<Mk2>(), sizes); });
    };
    sizes.waiting = 0;
    CHECK(has(frame(splat::Lossless{}), "list waiting (side 0) with 0 slots"));
    CHECK(frame(sizes_test::Dropping{}).empty());
    sizes.waiting = 1;
    CHECK(frame(splat::Lossless{}).empty());
}

TEST_CASE("memory_shared: two channels in one memory may not carry mail at once, and may where the flag says they have their own")
{
    auto const crowded = [](bool shared) {
        return error_of([&] {
            CheckedMesh<Crowded, AnyMachine> mesh{{}, grid, mesh_sizes<Crowded>(machine_with(8192), Slots{3, 3, 3, true, shared})};
            mesh.run();
        });
    };
    CHECK(crowded(false).empty());
    CHECK(has(crowded(true), "channels Lane and Belt both carry mail"));
}

TEST_CASE("a mesh on AnyMachine is one on the machine that it is told")
{
    using Setup = Constant<5>;
    auto const named = everywhere<Freight, Mk2>(grid, [](auto&) {}, 2, {}, mesh_sizes<Freight, Mk2, Setup>());
    auto const any = everywhere<Freight, AnyMachine>(grid, [](auto&) {}, 2, {}, mesh_sizes<Freight>(size_of_machine<Mk2>(), Setup::sizes));
    CHECK(words_of(*named.mesh) == words_of(*any.mesh));
    CHECK(named.mesh->sram_bytes() == any.mesh->sram_bytes());
    for (std::size_t r = 0; r < 2; ++r) check_same(named.runs[r], any.runs[r]);
    CHECK(std::string(any.mesh->machine().name) == "mk2");
    CHECK(any.mesh->machine().tiles == 1472);
    // The mesh has the tiles of that machine.
    auto few = size_of_machine<Mk2>();
    few.tiles = 5;
    CHECK(has(error_of([&] { Mesh<Freight, AnyMachine>{{}, grid, mesh_sizes<Freight>(few, Setup::sizes)}; }),
              "a grid of 3 x 2 = 6 tiles (mk2 has 5)"));
    // The mesh has the trace of that machine.
    Mesh<Freight, Traced<Mk2>> traced{{}, grid, mesh_sizes<Freight, Mk2, Setup>()};
    Mesh<Freight, Traced<AnyMachine>> told{{}, grid, mesh_sizes<Freight>(size_of_machine<Mk2>(), Setup::sizes)};
    traced.run();
    told.run();
    CHECK(traced.trace() == told.trace());
    CHECK(traced.trace().supersteps.size() == 4);
}
