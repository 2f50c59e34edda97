// test: unoptimised test asan tsan
// The program of bench/mesh: no record is lost at any capacity, and every record takes a shortest path.
#include "../../bench/mesh/traffic.hpp"
#include "everywhere.hpp"

using namespace engine_test;

namespace {

constexpr MachineSize machine = size_of_machine<TestMachine<64u << 20>>();

traffic::Record record(std::uint32_t id, TileId to)
{
    traffic::Record r{id, to, {}};
    for (std::uint32_t i = 0; i < 13; ++i) r.payload[i] = traffic::payload_word(id, i);
    return r;
}

/// Loads `each` records on every tile, each to the tile `to(from, random)`, and runs. Returns the number of exchanges.
template <class To>
std::uint64_t check_load(traffic::Sizes sizes, Grid grid, std::uint32_t each, To const& to)
{
    std::uint64_t distances = 0;
    std::vector<TileId> ends;
    {
        Random random{5};
        for (std::uint32_t i = 0; i < grid.size() * each; ++i) {
            auto const from = grid.tile(i % grid.size());
            ends.push_back(to(from, random));
            distances += std::max(from.x(), ends[i].x()) - std::min(from.x(), ends[i].x());
            distances += std::max(from.y(), ends[i].y()) - std::min(from.y(), ends[i].y());
        }
    }
    auto const load = [&](auto& mesh) {
        for (std::uint32_t i = 0; i < ends.size(); ++i)
            mesh.template state<traffic::Leaving>(grid.tile(i % grid.size())).push(record(i, ends[i]));
    };
    auto const p = everywhere<traffic::Program, AnyMachine>(grid, load, 1, {}, mesh_sizes<traffic::Program>(machine, sizes));
    CHECK(p.last().messages() == distances);
    std::vector<int> seen(ends.size(), 0);
    for (std::uint32_t t = 0; t < grid.size(); ++t)
        for (auto const& r : p.mesh->template state<traffic::Arrived>(grid.tile(t))) {
            REQUIRE(r.id < ends.size());
            ++seen[r.id];
            CHECK(r.to == grid.tile(t));
            CHECK(ends[r.id] == r.to);
            auto const want = record(r.id, r.to);
            CHECK(std::equal(std::begin(r.payload), std::end(r.payload), std::begin(want.payload)));
        }
    CHECK(seen == std::vector<int>(ends.size(), 1));
    return p.last().exchanges();
}

} // namespace

TEST_CASE("traffic: with room for all, as many supersteps as the farthest has to go")
{
    Grid const grid{7, 5};
    auto const supersteps = check_load({64, 400, 64}, grid, 3, [&](TileId from, Random&) {
        return TileId::at(grid.width - 1 - from.x(), grid.height - 1 - from.y());
    });
    CHECK(supersteps == 7 + 5 - 2);
}

TEST_CASE("traffic: random places, channels and FIFOs of one slot and more")
{
    Grid const grid{9, 6};
    auto const anywhere = [&](TileId, Random& random) { return grid.tile(random.below(grid.size())); };
    check_load({1, 400, 1}, grid, 6, anywhere);
    check_load({2, 400, 1}, grid, 6, anywhere);
    check_load({1, 400, 3}, grid, 6, anywhere);
    check_load({5, 400, 4}, grid, 12, anywhere);
}

TEST_CASE("traffic: everybody to one tile, and one row across another")
{
    Grid const grid{8, 5};
    check_load({1, 400, 1}, grid, 4, [](TileId, Random&) { return TileId::at(3, 2); });
    check_load({2, 400, 2}, grid, 4, [](TileId from, Random&) { return TileId::at(7 - from.x(), from.y()); });
    check_load({1, 400, 1}, {1, 9}, 4, [](TileId from, Random&) { return TileId::at(0, 8 - from.y()); });
    check_load({1, 400, 1}, {9, 1}, 4, [](TileId from, Random&) { return TileId::at(8 - from.x(), 0); });
}
