// test: unoptimised test asan
#include "everywhere.hpp"
#include "programs.hpp"
#include <thread>

using namespace engine_test;

namespace {

struct Event {
    std::string kernel;
    std::uint32_t step;
    std::uint64_t pass, messages, tile_runs, digest;
    friend bool operator==(Event const&, Event const&) = default;
};
Event copy(SuperstepEvent const& e)
{
    return {e.kernel, e.step, e.pass, e.messages, e.tile_runs, e.digest};
}

struct Stop : std::runtime_error {
    std::uint64_t pass;
    explicit Stop(std::uint64_t p) : std::runtime_error("stop"), pass(p) {}
};

struct Tick { // uses no channel
    void operator()(Visits& visits) const noexcept { visits.count += 10; }
};
struct Two : Buffer<std::uint32_t, 2> {};
struct Overflow { // breaks a contract in the third superstep
    void operator()(Two& two) const noexcept { two.push(1); }
};

template <class M>
std::uint64_t parcels_on_the_road(M& mesh)
{
    std::uint64_t n = 0;
    for (std::uint32_t i = 0; i < mesh.grid().size(); ++i)
        for (Direction d : news) n += mesh.template incoming<Road>(mesh.grid().tile(i), d).size();
    return n;
}
template <class M>
std::uint64_t parcels_at_rest(M& mesh)
{
    std::uint64_t n = 0;
    for (std::uint32_t i = 0; i < mesh.grid().size(); ++i)
        n += mesh.template state<Inbox>(mesh.grid().tile(i)).size() +
             mesh.template state<Outbox>(mesh.grid().tile(i)).size();
    return n;
}

} // namespace

TEST_CASE("an observer is called once a superstep, in order, with its name, pass, messages and runs")
{
    using Program = Sequence<Superstep<Throw>, UntilQuiet<Catch>, UntilQuiet<Catch>, Repeat<Tick>>;
    Program const program{{}, {}, {}, {2}};
    std::vector<Event> want;
    want.push_back({"Throw", 0, 0, 1, 10, 0});
    for (std::uint64_t p = 1; p <= 4; ++p) want.push_back({"Catch", 1, p, p == 4 ? 0u : 1u, 1, 0});
    for (std::uint64_t p = 5; p <= 6; ++p) want.push_back({"Tick", 3, p, 0, 10, 0});
    on_each<Program>({5, 2}, [&](auto& mesh) {
        std::vector<Event> events;
        bool my_thread = true;
        auto const me = std::this_thread::get_id();
        mesh.observe([&](SuperstepEvent const& e) {
            events.push_back(copy(e));
            my_thread = my_thread && std::this_thread::get_id() == me;
        });
        mesh.template state<Ball>(TileId::at(0, 1)).throws = 4;
        mesh.run();
        CHECK(events == want);
        CHECK(my_thread);

        events.clear();
        mesh.template state<Ball>(TileId::at(0, 1)).throws = 4;
        mesh.run(); // each run counts passes from 0
        CHECK(events == want);

        events.clear();
        mesh.observe({});
        mesh.run();
        CHECK(events.empty());
    }, program);
}

TEST_CASE("an observer sees every engine do the same, digest by digest")
{
    Grid const grid{6, 5};
    auto const load = [&](auto& mesh) {
        Random random{7};
        for (std::uint32_t i = 0; i < grid.size(); ++i) {
            auto outbox = mesh.template state<Outbox>(grid.tile(i));
            for (std::uint32_t k = 0; k < 8; ++k) {
                auto const to = random.below(grid.size());
                outbox.push({8 * i + k, grid.tile(to), {}});
            }
        }
    };
    std::vector<Event> want;
    auto const record = [&](auto& mesh, std::vector<Event>& events) {
        load(mesh);
        bool conserved = true, counted = true;
        mesh.observe([&](SuperstepEvent const& e) {
            events.push_back(copy(e));
            conserved = conserved && parcels_on_the_road(mesh) + parcels_at_rest(mesh) == 8 * grid.size();
            counted = counted && parcels_on_the_road(mesh) == e.messages; // the messages sent are the messages that are readable now
        });
        auto const run = mesh.run();
        CHECK(conserved);
        CHECK(counted);
        REQUIRE(run.digests.size() == events.size());
        for (std::size_t i = 0; i < events.size(); ++i) CHECK(run.digests[i] == events[i].digest);
    };
    CheckedMesh<Post, Bench> checked{{}, grid, {.digest = true}};
    record(checked, want);
    CHECK(want.size() > 3);
    for (auto threads : thread_counts) {
        CAPTURE(threads);
        Mesh<Post, Bench> mesh{{}, grid, {.threads = threads, .digest = true}};
        std::vector<Event> events;
        record(mesh, events);
        CHECK(events == want);
    }
}

TEST_CASE("an observer may change states between supersteps")
{
    using Program = Repeat<Tick>;
    on_each<Program>({5, 2}, [&](auto& mesh) {
        mesh.observe([&](SuperstepEvent const& e) {
            mesh.template state<Visits>(TileId::at(4, 1)).count += static_cast<std::uint32_t>(e.pass);
        });
        mesh.run();
        CHECK(mesh.template state<Visits>(TileId::at(4, 1)).count == 0 + 1 + 2 + 3 * 10);
        CHECK(mesh.template state<Visits>(TileId::at(0, 0)).count == 3 * 10);
    }, {3});
}

TEST_CASE("what an observer throws comes out of run(), itself, and the mesh refuses to run again")
{
    for (std::uint64_t at : {0u, 2u, 6u}) {
        CAPTURE(at);
        on_each<Repeat<Tick>>({5, 2}, [&](auto& mesh) {
            std::uint64_t calls = 0;
            mesh.observe([&](SuperstepEvent const& e) {
                ++calls;
                if (e.pass == at) throw Stop(e.pass);
            });
            std::uint64_t caught = 99;
            try {
                mesh.run();
            } catch (Stop const& stop) {
                caught = stop.pass;
            }
            CHECK(caught == at);
            CHECK(calls == at + 1); // no superstep ran after the exception
            CHECK(mesh.template state<Visits>(TileId::at(1, 1)).count == (at + 1) * 10);
            mesh.observe({});
            CHECK(has(error_of([&] { mesh.run(); }), "cannot run again"));
        }, {7});
    }
}

TEST_CASE("an observer that runs or observes its own mesh gets an error, and the run goes on")
{
    on_each<Repeat<Tick>>({5, 2}, [&](auto& mesh) {
        std::uint64_t calls = 0;
        mesh.observe([&](SuperstepEvent const&) {
            ++calls;
            CHECK(has(error_of([&] { mesh.run(); }), "its own observer"));
            CHECK(has(error_of([&] { mesh.observe({}); }), "its own observer"));
        });
        mesh.run();
        CHECK(calls == 7);
        CHECK(mesh.template state<Visits>(TileId::at(1, 1)).count == 7 * 10);
        mesh.observe({});
        mesh.run();
        CHECK(calls == 7);
    }, {7});
}

TEST_CASE("an observer is not told of a superstep that broke a contract")
{
    on_each<Repeat<Overflow>>({5, 2}, [&](auto& mesh) {
        std::uint64_t calls = 0;
        mesh.observe([&](SuperstepEvent const&) { ++calls; });
        CHECK(has(error_of([&] { mesh.run(); }), "[tile (0, 0), superstep 2 (Overflow)"));
        CHECK(calls == 2);
    }, {3});
}

TEST_CASE("an observer may run another mesh: contracts of the outer one are still heard")
{
    on_each<Repeat<Overflow>>({5, 2}, [&](auto& mesh) {
        mesh.observe([&](SuperstepEvent const&) {
            CheckedMesh<Repeat<Tick>> checked{{2}, {2, 2}};
            checked.run();
            Mesh<Repeat<Tick>> threads{{2}, {2, 2}, {.threads = 2}};
            threads.run();
            CHECK(threads.state<Visits>(TileId::at(1, 1)).count == 20);
        });
        CHECK(has(error_of([&] { mesh.run(); }), "[tile (0, 0), superstep 2 (Overflow)"));
    }, {3});
}
