// test: unoptimised test asan tsan
#include "everywhere.hpp"
#include "programs.hpp"

using namespace engine_test;

namespace {

struct Stock : Buffer<std::uint32_t, 8> {};
struct Shelf : Buffer<std::uint32_t, 8> {};
struct Pipe : Channel<std::uint32_t> {}; // limit<> gives its slots
struct Belt : Channel<std::uint32_t, 8> {};

/// Puts its mail on the shelf. Then it fills the stock and the channel.
template <class C>
struct Stuff {
    void operator()(Stock& stock, Shelf& shelf, In<C> in, Out<C> out) const noexcept
    {
        for (Direction d : news)
            for (auto m : in[d])
                if (!shelf.try_push(m)) break;
        std::uint32_t n = 0;
        while (stock.try_push(n)) ++n;
        for (Direction d : news)
            while (out[d].try_push(d == Direction::north ? 1u : 2u)) {
            }
    }
};
template <class C>
struct Empty {
    void operator()(Stock& stock, Shelf& shelf, In<C>) const noexcept
    {
        stock.truncate(0);
        shelf.truncate(0);
    }
};
/// Loaded leaves mail behind; Drained leaves none.
template <class C>
using Loaded = Superstep<Stuff<C>>;
template <class C>
using Drained = Sequence<Superstep<Stuff<C>>, Superstep<Empty<C>>>;

struct Guest : Channel<std::uint32_t> { // limit<> gives its slots, which lie in the memory of Pipe
    using memory_of = Pipe;
};
template <class C>
struct Give {
    void operator()(Shelf&, Out<C> out) const noexcept
    {
        for (Direction d : news)
            for (std::uint32_t n = 0; n < 8 && out[d].try_push(n); ++n) {
            }
    }
};
template <class C>
struct Take {
    void operator()(Shelf&, In<C>) const noexcept {}
};
using Both = Sequence<Superstep<Give<Pipe>>, Superstep<Take<Pipe>>, Superstep<Give<Guest>>, Superstep<Take<Guest>>>;

struct Hint { // a note and no message
    void operator()(In<Belt>, Out<Belt> out) const noexcept { out[Direction::east].set_note(1); }
};

} // namespace

TEST_CASE("a dynamic channel needs limit<> before run, and then holds what it was given")
{
    on_each<Drained<Pipe>>({3, 2}, [](auto& mesh) {
        auto const text = error_of([&] { mesh.run(); });
        CHECK(has(text, "channel Pipe has no slots"));
        CHECK(has(text, "; call limit<Channel>(slots) before run()"));
        mesh.template limit<Pipe>(5); // the mesh still runs after the refusal
        auto const run = mesh.run();
        CHECK(run.steps[0].messages == 6 * 4 * 5);
        CHECK(run.steps[0].capacity_bytes == 16 * 6 * (2 + 5));
        CHECK(run.peaks.back().capacity == 5);
        CHECK(run.peaks.back().items == 5);
    });
}

TEST_CASE("a channel whose type names its slots and one that gets them by limit give the same words and counters")
{
    auto const belt = everywhere<Drained<Belt>>({3, 2}, [](auto&) {});
    auto const pipe = everywhere<Drained<Pipe>>({3, 2}, [](auto& mesh) { mesh.template limit<Pipe>(8); });
    for (std::size_t s = 0; s < 2; ++s) {
        CHECK(belt.step(s).messages == pipe.step(s).messages);
        CHECK(belt.step(s).capacity_bytes == pipe.step(s).capacity_bytes);
        CHECK(belt.step(s).tile_runs == pipe.step(s).tile_runs);
    }
    CHECK(belt.last().digests == pipe.last().digests);
    CHECK(words_of(*belt.mesh) == words_of(*pipe.mesh));
}

TEST_CASE("the SRAM budget of a dynamic channel is checked when it is sized: exactly full fits, one slot over does not")
{
    // Two lists of 2 + 8 words, the heads of 8 ends, and 32 bytes per slot.
    constexpr std::uint32_t base = 2 * 40 + 64, slots = 7;
    using Exact = TestMachine<base + 32 * slots>;
    static_assert(Tile<Exact, Drained<Pipe>>::bytes == base);
    on_each<Drained<Pipe>, Exact>({2, 2}, [&](auto& mesh) {
        CHECK(mesh.sram_bytes() == base);
        mesh.template limit<Pipe>(slots);
        CHECK(mesh.sram_bytes() == base + 32 * slots);
        auto const text = error_of([&] { mesh.template limit<Pipe>(slots + 1); });
        CHECK(has(text, "channel Pipe with 8 slots"));
        CHECK(has(text, "32 bytes over"));
        CHECK(has(text, "; give it fewer slots"));
        CHECK(has(error_of([&] { mesh.template limit<Pipe>(slots + 100); }), " 3200 bytes over"));
        CHECK(has(error_of([&] { mesh.template limit<Pipe>(0xffffffffu); }), " bytes over"));
        CHECK(mesh.sram_bytes() == base + 32 * slots); // the last valid limit still holds
        CHECK(mesh.run().peaks.back().items == slots);
    });
}

TEST_CASE("dynamic channels in one memory are counted once, with the slots of the larger")
{
    // A list of 2 + 8 words, and the heads of 8 ends: the heads of Guest lie in those of Pipe.
    constexpr std::uint32_t base = 40 + 64;
    using Exact = TestMachine<base + 32 * 9>;
    static_assert(Tile<Exact, Both>::bytes == base);
    on_each<Both, Exact>({2, 2}, [&](auto& mesh) {
        CHECK(mesh.sram_bytes() == base);
        mesh.template limit<Pipe>(5);
        mesh.template limit<Guest>(4);
        CHECK(mesh.sram_bytes() == base + 32 * 5);
        mesh.template limit<Guest>(5);
        CHECK(mesh.sram_bytes() == base + 32 * 5);
        mesh.template limit<Guest>(9);
        CHECK(mesh.sram_bytes() == base + 32 * 9);
        CHECK(has(error_of([&] { mesh.template limit<Guest>(10); }), "channel Guest with 10 slots (the program is then 32 bytes over"));
        mesh.template limit<Pipe>(9);
        CHECK(mesh.sram_bytes() == base + 32 * 9);
        CHECK(mesh.run().messages() == 4 * 4 * (8 + 8));
    });
}

TEST_CASE("a limit of 1, N - 1 and N is obeyed by the kernels; N + 1 is refused")
{
    for (std::uint32_t limit : {1u, 7u, 8u}) {
        CAPTURE(limit);
        auto const p = everywhere<Loaded<Belt>>({3, 2}, [&](auto& mesh) {
            mesh.template limit<Belt>(limit);
            mesh.template limit<Stock>(limit);
            mesh.template limit<Shelf>(limit - 1);
        });
        CHECK(p.last().messages() == 6 * 4 * limit);
        CHECK(p.step(0).capacity_bytes == 16 * 6 * (2 + limit));
        CHECK(p.mesh->state<Stock>(TileId::at(1, 1)).size() == limit);
        CHECK(p.mesh->state<Stock>(TileId::at(1, 1)).capacity() == limit);
        CHECK(p.last().peaks[0].capacity == limit);
        CHECK(p.last().peaks[0].items == limit);
        CHECK(p.mesh->sram_bytes() == Tile<Mk2, Loaded<Belt>>::bytes); // a limit frees no SRAM
    }
    on_each<Loaded<Belt>>({3, 2}, [](auto& mesh) {
        auto const channel = error_of([&] { mesh.template limit<Belt>(9); });
        CHECK(has(channel, "a limit of 9 items for Belt"));
        CHECK(has(channel, "has 8"));
        CHECK(has(error_of([&] { mesh.template limit<Stock>(9); }), "a limit of 9 items for Stock"));
        CHECK(has(error_of([&] { mesh.template limit<Stock>(0xffffffffu); }), "for Stock"));
        CHECK(mesh.run().messages() == 6 * 4 * 8); // a refused limit changes nothing
    });
}

TEST_CASE("a buffer limited to 0 takes nothing; a channel limited to 0 is refused by run")
{
    on_each<Loaded<Belt>>({3, 2}, [](auto& mesh) {
        mesh.template limit<Stock>(0);
        CHECK(mesh.run().peaks[0].items == 0);
        CHECK(mesh.template state<Stock>(TileId::at(0, 0)).empty());
    });
    on_each<Loaded<Belt>>({3, 2}, [](auto& mesh) {
        mesh.template limit<Belt>(0);
        CHECK(has(error_of([&] { mesh.run(); }), "channel Belt has no slots"));
        mesh.template limit<Belt>(2);
        CHECK(mesh.run().messages() == 6 * 4 * 2);
    });
}

TEST_CASE("a limit may change between runs, up to the slots that the mesh was built with and no further")
{
    on_each<Drained<Belt>>({3, 2}, [](auto& mesh) {
        for (std::uint32_t limit : {7u, 1u, 8u}) { // a limit may fall and rise
            CAPTURE(limit);
            mesh.template limit<Belt>(limit);
            mesh.template limit<Stock>(limit);
            auto const run = mesh.run();
            CHECK(run.messages() == 6 * 4 * limit);
            CHECK(run.peaks[0].items == limit);
        }
        CHECK(has(error_of([&] { mesh.template limit<Belt>(9); }), "a limit of 9 items for Belt (the program's layout has 8"));
    });
}

TEST_CASE("a loaded buffer keeps its room: a limit below what any tile holds is refused, with the tile")
{
    on_each<Loaded<Belt>>({3, 2}, [](auto& mesh) {
        auto stock = mesh.template state<Stock>(TileId::at(2, 1));
        for (std::uint32_t i = 0; i < 5; ++i) stock.push(i);
        auto const text = error_of([&] { mesh.template limit<Stock>(4); });
        CHECK(has(text, "a limit of 4 items for Stock"));
        CHECK(has(text, "tile (2, 1) holds 5"));
        CHECK(mesh.template state<Stock>(TileId::at(2, 1)).capacity() == 8);
        mesh.template limit<Stock>(5);
        CHECK(mesh.template state<Stock>(TileId::at(2, 1)).room() == 0);
    });
}

TEST_CASE("a channel with mail under way keeps its slots; one that was read may change them")
{
    on_each<Loaded<Belt>>({3, 2}, [](auto& mesh) {
        mesh.run();
        for (std::uint32_t slots : {1u, 7u, 8u}) {
            CAPTURE(slots);
            CHECK(has(error_of([&] { mesh.template limit<Belt>(slots); }), "new slots for channel Belt (it carries mail"));
        }
        CHECK(mesh.template incoming<Belt>(TileId::at(1, 1), Direction::north).size() == 8);
        CHECK(mesh.run().steps[0].capacity_bytes == 16 * 6 * (2 + 8)); // the channel keeps its 8 slots
    });
    on_each<Loaded<Pipe>>({3, 2}, [](auto& mesh) {
        mesh.template limit<Pipe>(3);
        mesh.run();
        CHECK(has(error_of([&] { mesh.template limit<Pipe>(30); }), "new slots for channel Pipe (it carries mail"));
        CHECK(mesh.run().messages() == 6 * 4 * 3);
    });
    on_each<Superstep<Hint>>({3, 2}, [](auto& mesh) { // a note without messages is mail
        mesh.run();
        CHECK(has(error_of([&] { mesh.template limit<Belt>(2); }), "it carries mail"));
    });
    on_each<Drained<Pipe>>({3, 2}, [](auto& mesh) {
        for (std::uint32_t slots : {3u, 30u, 1u, 100u}) {
            mesh.template limit<Pipe>(slots);
            CHECK(mesh.run().messages() == std::uint64_t{6} * 4 * slots);
        }
    });
}

TEST_CASE("a grid that the machine does not have is refused: none, too many, too long")
{
    struct Four : TestMachine<4096, 4> {};
    auto const refused = [](auto tag, Grid grid) {
        using M = typename decltype(tag)::type;
        return error_of([&] { M mesh{{}, grid}; });
    };
    auto const check = [&](auto tag) {
        CHECK(refused(tag, {2, 2}).empty());
        CHECK(refused(tag, {1, 4}).empty());
        CHECK(refused(tag, {1, 1}).empty());
        CHECK(has(refused(tag, {5, 1}), "a grid of 5 x 1 = 5 tiles (test has 4)"));
        CHECK(has(refused(tag, {2, 3}), "2 x 3 = 6 tiles"));
        CHECK(has(refused(tag, {0, 3}), "a grid of 0 x 3 tiles"));
        CHECK(has(refused(tag, {3, 0}), "a grid of 3 x 0 tiles"));
        CHECK(has(refused(tag, {0, 0}), "; choose another"));
        CHECK(has(refused(tag, {65536, 1}), "each side is 1 to 65,535"));
        CHECK(has(refused(tag, {65536, 65536}), "each side is 1 to 65,535")); // their product is 0 in 32 bits
    };
    check(machine::Tag<Mesh<Heat, Four>>{});
    check(machine::Tag<CheckedMesh<Heat, Four>>{});
    CHECK(refused(machine::Tag<Mesh<Heat>>{}, {1472, 1}).empty());
    CHECK(has(refused(machine::Tag<Mesh<Heat>>{}, {1473, 1}), "(mk2 has 1472)"));
    CHECK(has(refused(machine::Tag<CheckedMesh<Heat>>{}, {1473, 1}), "(mk2 has 1472)"));
}
