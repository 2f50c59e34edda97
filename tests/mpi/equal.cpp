#include "../../bench/mesh/traffic.hpp"
#include "../engine/control.hpp"
#include "../engine/programs.hpp"
#include "on_ranks.hpp"

using namespace mpi_test;

namespace {
template <class M>
void load_heat(M& mesh)
{
    mesh.template broadcast<Conductivity>().per_step = 0.2f;
    for (auto [tile, cell] : mesh.template states<Cell>()) cell.kelvin = static_cast<float>(300 + tile.x() * tile.y() % 17);
}
template <class M>
void load_life(M& mesh)
{
    for (auto [tile, patch] : mesh.template states<Patch>()) {
        Random random{tile.packed};
        for (auto& row : patch.row) row = random.bits() & 0xffu;
    }
}
template <class M>
void load_keys(M& mesh)
{
    for (auto [tile, key] : mesh.template states<Key>()) key.value = Random{tile.packed}.bits();
}
/// Parcels from every tile to tiles of its choice, the same on every mesh.
template <class M>
void load_post(M& mesh)
{
    for (auto [tile, outbox] : mesh.template states<Outbox>()) {
        Random random{tile.packed + 1};
        for (auto n = random.below(9), i = 0u; i < n; ++i)
            outbox.push({tile.packed * 32 + i, mesh.grid().tile(random.below(mesh.grid().size())), {1.5f, 2.5f}});
    }
}
template <class M>
void load_records(M& mesh)
{
    for (auto [tile, leaving] : mesh.template states<traffic::Leaving>()) {
        Random random{tile.packed + 7};
        for (std::uint32_t i = 0; i < 4; ++i) {
            traffic::Record r{tile.packed * 8 + i, mesh.grid().tile(random.below(mesh.grid().size())), {}};
            for (std::uint32_t w = 0; w < 13; ++w) r.payload[w] = traffic::payload_word(r.id, w);
            leaving.push(r);
        }
    }
}
} // namespace

TEST_CASE("heat, life and sorting: words, counters and digests of every superstep are those of Mesh")
{
    for (auto grid : {Grid{5, 9}, Grid{3, 1}, Grid{1, 2}, Grid{1, 1}}) { // some with fewer rows than ranks
        CAPTURE(grid.height);
        on_ranks<Heat>(grid, [](auto& mesh) { load_heat(mesh); }, 2, Heat{{12}});
    }
    on_ranks<Generation>({3, 8}, [](auto& mesh) { load_life(mesh); }, 5);
    on_ranks<SortRows>({6, 5}, [](auto& mesh) { load_keys(mesh); }, 1, SortRows{{6}, {}});
}

TEST_CASE("messages to far tiles, and mail that a bound leaves for the next run")
{
    auto const load = [](auto& mesh) { load_post(mesh); };
    on_ranks<Post>({6, 10}, load);
    Post bounded; // a run moves every message by two hops
    get_step<Deliver>(bounded).at_most = 2;
    on_ranks<Post>({2, 9}, load, 1, bounded);
    // Runs of one hop each: the mail between them lies on tiles of other ranks than those that sent it.
    using Hop = Sequence<If<&Wanted::first, Superstep<Depart>>, UntilQuiet<Deliver>>;
    Hop hop;
    get_step<Deliver>(hop).at_most = 1;
    Mesh<Hop, Roomy> reference{hop, Grid{3, 8}};
    MpiMesh<Hop, Roomy> mesh{MPI_COMM_WORLD, hop, Grid{3, 8}};
    auto const states = Mesh<Hop, Roomy>::States{};
    auto const links = Mesh<Hop, Roomy>::Links{};
    load_post(reference);
    load_post(mesh);
    for (std::uint32_t r = 0; r < 14; ++r) {
        CAPTURE(r);
        reference.broadcast<Wanted>().first = mesh.broadcast<Wanted>().first = r == 0 ? 1 : 0;
        check_same(reference.run(), mesh.run());
        for (auto y = mesh.bands().first(rank()); y < mesh.bands().last(rank()); ++y)
            CHECK(words_of_rows(reference, y, y + 1, states, links) ==
                  words_of_rows(mesh, y, y + 1, states, links));
    }
    on_ranks<Bounce>({10, 3}, [](auto& row) {
        for (auto [tile, ball] : row.template states<Ball>()) ball.throws = tile.x() == 0 ? 20 + tile.y() : 0;
    });
}

TEST_CASE("channels of one slot, exactly full, and one more: back-pressure crosses bands")
{
    Grid const grid{5, 8};
    constexpr MachineSize machine = size_of_machine<TestMachine<64u << 20>>();
    auto const load = [](auto& mesh) { load_records(mesh); };
    auto const run = [&](std::uint32_t slots, std::uint32_t waiting) {
        return on_ranks<traffic::Program, AnyMachine>(grid, load, 1, {}, mesh_sizes<traffic::Program>(machine, traffic::Sizes{slots, 64, waiting}));
    };
    auto const wide = run(200, 400);
    std::uint32_t full = 0;
    for (auto const& peak : wide.peaks)
        if (peak.region == "Road") full = peak.items;
    REQUIRE(full > 1);
    auto const narrow = run(1, 1);
    CHECK(narrow.exchanges() > wide.exchanges());
    for (std::uint32_t const slots : {2u, 3u, 17u, 199u}) CHECK(run(slots, 400).exchanges() <= narrow.exchanges());
    CHECK(run(full, 400).messages() == wide.messages());
    CHECK(run(full + 1, 400).messages() == wide.messages());
}

TEST_CASE("loops, conditions and reductions end with the votes of all ranks")
{
    auto const tanks = [](auto& mesh) {
        for (auto [tile, tank] : mesh.template states<Tank>()) {
            Random random{tile.packed + 3};
            tank = {random.below(4), random.below(3), 0, 0};
        }
    };
    auto const drained = on_ranks<Draining>({4, 7}, tanks);
    CHECK(drained.loops.at(0).rounds > 1);
    on_ranks<NestedDraining>({4, 7}, tanks);
    on_ranks<Draining>({4, 7}, [](auto& mesh) { // only one tile of the last row votes
        for (auto [tile, tank] : mesh.template states<Tank>())
            if (tile.x() == 3 && tile.y() == 6) tank = {2, 3, 0, 0};
    });
    for (std::uint32_t cooled : {0u, 1u}) {
        auto const settled = on_ranks<Warming>({4, 6}, [&](auto& mesh) {
            if (rank() == 0) mesh.template broadcast<Settling>() = {0.2f, 10, cooled}; // a run takes the broadcasts of rank 0
            if constexpr (!requires { mesh.ranks(); }) mesh.template broadcast<Settling>() = {0.2f, 10, cooled};
            for (auto [tile, plate] : mesh.template states<Plate>()) plate.kelvin = static_cast<float>(40 * (tile.x() + tile.y()));
        });
        CHECK(settled.loops.at(0).rounds > 1);
    }
    on_ranks<Reducing<ReduceTo::all>>({3, 8}, [](auto& mesh) {
        for (auto [tile, load] : mesh.template states<Load>()) {
            Random random{tile.packed};
            load = {static_cast<float>(random.below(1u << 20)) * 0.001f - 300, random.bits() | 5u};
        }
    });
}

TEST_CASE("a rectangle that lies in a part of the ranks, and limits")
{
    Grid const grid{6, 9};
    for (std::uint32_t y0 : {0u, 4u, 8u}) {
        CAPTURE(y0);
        auto const within = [&](auto& mesh) {
            mesh.template broadcast<Conductivity>().per_step = 0.1f;
            for (auto [tile, cell] : mesh.template states<Cell>())
                if (tile.x() == 3 && tile.y() == y0) cell.kelvin = 100;
            mesh.run_within(1, y0, 5, y0 + 1);
        };
        on_ranks<Heat>(grid, within, 1, Heat{{1}});
    }
    on_ranks<Post>(grid, [](auto& mesh) {
        mesh.template limit<Road>(100);
        mesh.template limit<Inbox>(200);
        load_post(mesh);
    });
}

TEST_CASE("the gathered trace is that of Mesh")
{
    check_trace(Post{}, Grid{5, 8}, [](auto& mesh) { load_post(mesh); });
    check_trace(Heat{{12}}, Grid{5, 9}, [](auto& mesh) { load_heat(mesh); });
    check_trace(Generation{}, Grid{3, 8}, [](auto& mesh) { load_life(mesh); });
    check_trace(SortRows{{6}, {}}, Grid{6, 5}, [](auto& mesh) { load_keys(mesh); });
    check_trace(Warming{}, Grid{3, 2}, [](auto& mesh) {
        mesh.template broadcast<Settling>() = {0.2f, 10, 0};
        for (auto [tile, plate] : mesh.template states<Plate>()) plate.kelvin = static_cast<float>(40 * (tile.x() + tile.y()));
    });
}
