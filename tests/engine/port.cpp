// test: unoptimised test asan
// A mesh behind a port is the mesh: states, mail, counters, digests and traces. Lists whose items have two forms, meshes that may keep a
// trace and do not, and digests that leave words out.
#include "everywhere.hpp"
#include "programs.hpp"
#include <tilemesh/engine/port.hpp>
#include <tilemesh/machine/either.hpp>

using namespace engine_test;

namespace {

// --- a program with one region of each kind: a list, a small struct, a large struct, a channel and a broadcast -----------------
struct Step {
    std::uint32_t add;
};
struct Seeds : Buffer<std::uint32_t, 9> {};
struct Sum {
    std::uint32_t value, passes;
};
struct History {
    std::uint32_t last[40]; ///< too large to lie beside the heads of lists
};
struct Wire : Channel<std::uint32_t, 3> {};
struct Talk {
    static constexpr char const* name = "talk";
    void operator()(Here here, Broadcast<Step> step, Seeds& seeds, Sum& sum, History& history, In<Wire> in, Out<Wire> out) const noexcept
    {
        for (Direction d : news)
            for (auto const word : in[d]) sum.value += word * (1 + index(d));
        history.last[sum.passes++ % 40] = sum.value;
        seeds.resize((sum.value + here.tile.x()) % 9);
        for (std::uint32_t i = 0; i < seeds.size(); ++i) seeds[i] = sum.value + i;
        for (Direction d : news) out[d].unchecked_push(sum.value + step->add + here.tile.y());
    }
};
using Talking = Sequence<Repeat<Talk>>;

PortOptions<Talking> behind(MakePort<Talking>* make, std::uint32_t threads, bool trace)
{
    PortOptions<Talking> options;
    options.threads = threads;
    options.digest = true;
    options.trace = trace;
    options.make = make;
    return options;
}
template <class M>
RunCounters told_and_run(M& mesh)
{
    mesh.template broadcast<Step>().add = 5;
    mesh.template state<Sum>(TileId::at(2, 1)).value = 77;
    mesh.template limit<Wire>(2);
    mesh.template limit<Seeds>(8);
    return mesh.run();
}

// --- a list whose items have two forms, beside the lists of each form ------------------------------------------------------------
struct Long {
    std::uint32_t a, b, c;
};
struct Short {
    std::uint32_t a;
};
template <class Item>
struct Items : Buffer<Item, 7> {};
struct Plain {
    std::uint32_t unused;
};
struct Formed {
    std::uint32_t unused, wide;
};
template <class Parameters, class Item>
struct Grow {
    void operator()(Here here, Broadcast<Parameters> frame, Items<Item>& items, Sum& sum) const noexcept
    {
        std::uint32_t const n = (here.tile.x() + ++sum.passes * 3) % 8; // also shrinks, so that items die
        items.resize(n);
        machine::in_form(machine::is_wide(*frame), items.begin(), [&](auto* to) noexcept {
            for (std::uint32_t i = 0; i < n; ++i) {
                to[i] = {};
                to[i].a = here.tile.y() + i + sum.passes;
            }
        });
    }
};
using Both = machine::Either<Long, Short>;
static_assert(machine::is_either<Both> && !machine::is_either<Long> && machine::has_form_word<Formed> && !machine::has_form_word<Plain>);
static_assert(machine::words_in_form<Both>(true) == 3 && machine::words_in_form<Both>(false) == 1 && machine::words_in_form<Short>(true) == 1);

template <template <class, class> class Engine, class Parameters, class Item>
RunCounters grown(bool wide)
{
    using Program = Sequence<Repeat<Grow<Parameters, Item>>>;
    auto sizes = mesh_sizes<Program, Bench>();
    sizes.wide = wide;
    typename Engine<Program, AnyMachine>::Options options;
    options.digest = true;
    Engine<Program, AnyMachine> mesh{Program{{5}}, {6, 3}, sizes, options};
    if constexpr (machine::has_form_word<Parameters>) mesh.template broadcast<Parameters>().wide = wide ? 1 : 0;
    return mesh.run();
}
template <template <class, class> class Engine>
void forms_agree()
{
    auto const narrow = grown<Engine, Plain, Short>(true), wide = grown<Engine, Plain, Long>(true);
    CHECK(narrow.digests.size() == 5);
    CHECK(narrow.digests != wide.digests);
    CHECK(grown<Engine, Formed, Both>(false).digests == narrow.digests);
    CHECK(grown<Engine, Formed, Both>(true).digests == wide.digests);
}

// --- a step that a run leaves out by a condition ----------------------------------------------------------------------------------
struct Flags {
    std::uint32_t extra;
};
struct Pair {
    std::uint32_t kept, extra;
};
struct Single {
    std::uint32_t kept;
};
template <class Entry>
struct Entries : Buffer<Entry, 4> {};
struct Extra {
    std::uint32_t word;
};
struct Gossip : Channel<std::uint32_t, 1> {};
template <class Entry>
struct Base {
    void operator()(Here here, Entries<Entry>& entries) const noexcept
    {
        Entry entry{};
        entry.kept = 3 * here.tile.x() + here.tile.y();
        entries.push(entry);
    }
};
struct More {
    void operator()(Entries<Pair>& entries, Extra& extra, Broadcast<Flags>, In<Gossip> in, Out<Gossip> out) const noexcept
    {
        for (Direction d : news) {
            for (auto const word : in[d]) extra.word += word;
            out[d].unchecked_push(entries.size());
        }
    }
};
using Without = Sequence<Superstep<Base<Single>>, Superstep<Base<Single>>>;
using WithIf = Sequence<Superstep<Base<Pair>>, If<&Flags::extra, Superstep<More>>, Superstep<Base<Pair>>>;
template <template <class, class> class Engine, class Program>
std::vector<std::uint64_t> digests_of(MeshSizes<Program> const& sizes, bool extra)
{
    typename Engine<Program, AnyMachine>::Options options;
    options.digest = true;
    Engine<Program, AnyMachine> mesh{Program{}, {5, 4}, sizes, options};
    if constexpr (std::is_same_v<Program, WithIf>) mesh.template broadcast<Flags>().extra = extra ? 1 : 0;
    return mesh.run().digests;
}
template <template <class, class> class Engine>
void left_out_agrees()
{
    auto const without = digests_of<Engine, Without>(mesh_sizes<Without, Bench>(), false);
    CHECK(without.size() == 2);
    auto sizes = mesh_sizes<WithIf, Bench>();
    CHECK(digests_of<Engine>(sizes, false) != without); // a state, a channel and a word more
    sizes.undigested_of<Entries<Pair>>() = 1;
    sizes.undigested_of<Extra>() = sizes.no_digest;
    CHECK(digests_of<Engine>(sizes, false) != without); // the channel
    sizes.undigested_links[machine::index_in<Gossip>(decltype(sizes)::Links{})] = true;
    CHECK(digests_of<Engine>(sizes, false) == without);
    CHECK(digests_of<Engine>(sizes, true).size() == 3);
}

} // namespace

TEST_CASE("behind a port, a mesh has its states, mail, counters, digests and trace, on threads and sequentially")
{
    Grid const grid{7, 5};
    auto const sizes = mesh_sizes<Talking, Bench>();
    Mesh<Talking, Traced<AnyMachine>> mesh{Talking{{6}}, grid, sizes, {.threads = 2, .digest = true}};
    auto const want = told_and_run(mesh);
    REQUIRE(want.digests.size() == 6);
    for (auto* const make : {make_threads_port<Talking>, make_checked_port<Talking>})
        for (std::uint32_t threads : {1u, 3u}) {
            PortMesh<Talking> port{Talking{{6}}, grid, sizes, behind(make, threads, true)};
            std::uint32_t seen = 0;
            port.observe([&](SuperstepEvent const&) { ++seen; });
            auto const got = told_and_run(port);
            CHECK(got.digests == want.digests);
            CHECK(got.messages() == want.messages());
            CHECK(seen == 6);
            CHECK(words_of(port) == words_of(mesh));
            CHECK(port.trace() == mesh.trace());
            CHECK(port.grid().size() == grid.size());
            CHECK(port.machine().tiles == mesh.machine().tiles);
        }
}

TEST_CASE("behind a port, limits, rectangles, program and threads are those of the mesh")
{
    auto const sizes = mesh_sizes<Talking, Bench>();
    PortMesh<Talking> port{Talking{{1}}, {3, 2}, sizes, behind(make_threads_port<Talking>, 2, false)};
    CHECK(port.state<Seeds>(TileId::at(2, 1)).capacity() == 9);
    port.limit<Seeds>(4);
    CHECK(port.state<Seeds>(TileId::at(2, 1)).capacity() == 4);
    CHECK(std::as_const(port).state<Seeds>(TileId::at(0, 0)).capacity() == 4);
    CHECK_THROWS_AS(port.limit<Seeds>(10), Error);
    CHECK_THROWS_AS(port.limit<Wire>(4), Error);
    CHECK_THROWS_AS(port.run_within(0, 0, 4, 2), Error);
    std::uint32_t calls[2] = {};
    port.on_threads([&](std::uint32_t thread, std::uint32_t threads) { calls[thread] += threads; });
    CHECK(calls[0] == 2);
    CHECK(calls[1] == 2);
    port.program() = Talking{{0}};
    CHECK(port.run().digests.empty());
    CHECK_THROWS_AS((void)port.trace(), Error); // the options say that it keeps none
    // One tile: there is no second one to tell the stride.
    PortMesh<Talking> one{Talking{{2}}, {1, 1}, sizes, behind(make_checked_port<Talking>, 1, false)};
    (void)one.run();
    CHECK(one.state<Sum>(TileId::at(0, 0)).passes == 2);
}

TEST_CASE("a list of two forms has the words of the form in use")
{
    forms_agree<Mesh>();
    forms_agree<CheckedMesh>();
}

TEST_CASE("digests leave out the words of a step that no run has, and are those of a program without the step")
{
    left_out_agrees<Mesh>();
    left_out_agrees<CheckedMesh>();
}

TEST_CASE("a mesh of a Traced machine keeps a trace, unless its options say that it keeps none")
{
    auto const sizes = mesh_sizes<Talking, Bench>();
    Mesh<Talking, Traced<AnyMachine>> keeps{Talking{{3}}, {4, 4}, sizes, {.digest = true}},
        none{Talking{{3}}, {4, 4}, sizes, {.threads = 2, .digest = true, .trace = false}};
    CheckedMesh<Talking, Traced<AnyMachine>> checked{Talking{{3}}, {4, 4}, sizes, {.digest = true, .trace = false}};
    auto const a = keeps.run(), b = none.run(), c = checked.run();
    CHECK(a.digests == b.digests);
    CHECK(a.digests == c.digests);
    CHECK(keeps.trace().supersteps.size() == 3);
    CHECK(has(error_of([&] { (void)none.trace(); }), "trace = false"));
    CHECK_THROWS_AS((void)checked.trace(), Error);
}
