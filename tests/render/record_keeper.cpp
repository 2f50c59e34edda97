// test: unoptimised test asan tsan
// The record keeper on a mesh that renders nothing: records that it loads, places and recalls are present once, and in order.
#include "../splat/support.hpp"
#include <tilemesh/render/host.hpp>
#include <tilemesh/render/record_keeper.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;

namespace {
using Routes = support::Room<>;
using Stays = Fitted<Routes, 0, false, false>;
using Rows = std::vector<std::uint32_t>;

/// A keeper and a mesh whose program never runs; tiles are 8 x 8 pixels.
template <class S>
struct Kept {
    using P = PoliciesOf<S>;
    using Program = Sequence<Superstep<Project<S>>>;

    render::RecordTable records;
    Tiling tiling;
    render::Host<Mesh<Program, AnyMachine>, AnyMachine> host{MeshOptions{}};
    render::RecordKeeper<P> keeper{records, nullptr};

    Kept(std::vector<Gaussian> gaussians, Grid grid, Extent2 picture, std::uint32_t slots)
        : records(support::map_of(std::move(gaussians)), 0), tiling(make_tiling(8 * picture.width, 8 * picture.height, 8, 8))
    {
        host.build({}, records, [&] {
            return render::MeshPlan<Program>{{}, grid, mesh_sizes<Program>(size_of_machine<typename S::Machine>(), support::sized<S>(1, slots))};
        });
        keeper.begin(host, tiling, slots);
    }
    auto& mesh() { return host.mesh(); }
    TileId tile(std::uint32_t i) { return mesh().grid().tile(i); }
    std::uint32_t& changes(std::uint32_t i) { return mesh().template state<Counts>(tile(i)).changes; }
    /// The ids of the records anchored on a tile (or of the copies), slot by slot. Checks that the lists of a tile match each other.
    Rows on(std::uint32_t i, bool copies = false)
    {
        auto const storage = mesh().template state<Storage<S>>(tile(i));
        auto const marks = mesh().template state<Marks<S>>(tile(i));
        CHECK(storage.size() == marks.size());
        CHECK(storage.size() == mesh().template state<Splats<S>>(tile(i)).size());
        Rows ids;
        for (std::uint32_t k = 0; k < storage.size(); ++k) {
            CHECK(storage[k].id == marks[k].id);
            if (marks[k].is(Mark::copy) == copies) ids.push_back(static_cast<std::uint32_t>(marks[k].id));
        }
        return ids;
    }
    /// Drops what a tile has from this slot on.
    void truncate(std::uint32_t i, std::uint32_t slots)
    {
        mesh().template state<Storage<S>>(tile(i)).truncate(slots);
        mesh().template state<Marks<S>>(tile(i)).truncate(slots);
        mesh().template state<Splats<S>>(tile(i)).truncate(slots);
    }
    void bring_copy(std::uint32_t id, std::uint32_t to)
    {
        Gaussian g{};
        g.id = GaussianId{id};
        REQUIRE(support::put<S>(mesh(), tile(to), g));
        auto marks = mesh().template state<Marks<S>>(tile(to));
        marks[marks.size() - 1].bits = Mark::copy;
    }
    /// Is every row anchored on one tile, or missing? A parked row is neither.
    bool each_is_somewhere()
    {
        Rows ids;
        for (std::uint32_t i = 0; i < mesh().grid().size(); ++i)
            for (auto id : on(i)) ids.push_back(id);
        for (auto row : keeper.missing()) ids.push_back(static_cast<std::uint32_t>(records.id(row)));
        std::sort(ids.begin(), ids.end());
        return std::adjacent_find(ids.begin(), ids.end()) == ids.end() && ids.size() + keeper.parked() == records.rows();
    }
};
/// Balls with the ids from 1 on, in the middles of these tiles.
std::vector<Gaussian> balls_on(Rows const& columns)
{
    std::vector<Gaussian> out;
    for (auto x : columns) out.push_back(support::ball(static_cast<std::uint32_t>(out.size()) + 1, 8.0f * static_cast<float>(x) + 4, 4));
    return out;
}
Rows from_to(std::uint32_t first, std::uint32_t last)
{
    Rows out(last - first + 1);
    std::iota(out.begin(), out.end(), first);
    return out;
}
} // namespace

TEST_CASE("keeper: loads in order, an even share a tile of the picture")
{
    Kept<Routes> k(balls_on(Rows(10, 0)), Grid{2, 2}, {2, 2}, 3);
    CHECK(k.on(0) == from_to(1, 3));
    CHECK(k.on(1) == from_to(4, 6));
    CHECK(k.on(2) == from_to(7, 9));
    CHECK(k.on(3) == Rows{10});
    CHECK(k.keeper.missing().empty());
    CHECK(k.each_is_somewhere());
    CHECK(k.changes(0) == 3);
    CHECK(k.changes(3) == 1);
    CHECK(k.mesh().state<Storage<Routes>>(k.tile(3))[0].mean_world[1] == 4); // the record, not its id alone
}

TEST_CASE("keeper: full to the last slot, one beyond, and the tiles beyond the picture before that")
{
    Kept<Routes> full(balls_on(Rows(12, 0)), Grid{2, 2}, {2, 2}, 3);
    CHECK(full.keeper.missing().empty());
    CHECK(full.on(3) == from_to(10, 12));
    CHECK_THROWS_WITH_AS((Kept<Routes>(balls_on(Rows(13, 0)), Grid{2, 2}, {2, 2}, 3)),
                         "a map of 13 Gaussians (4 tiles of 3 slots hold 12); choose more slots or a larger machine", Error);

    Kept<Routes> beyond(balls_on(Rows(13, 0)), Grid{3, 2}, {2, 2}, 3);
    CHECK(beyond.keeper.missing().empty());
    CHECK(beyond.on(2) == Rows{13}); // tile (2, 0)
    CHECK(beyond.on(0) == from_to(1, 3));
    CHECK(beyond.keeper.occupied().width == 3);
    CHECK(beyond.keeper.occupied().height == 2);
    CHECK(beyond.each_is_somewhere());
    Kept<Routes> within(balls_on(Rows(12, 0)), Grid{3, 2}, {2, 2}, 3);
    CHECK(within.keeper.occupied().width == 2); // the third column holds nothing, so it stays idle
}

TEST_CASE("keeper: a missing record takes the slot of a copy that was left of it, or a free one, and is there once")
{
    Kept<Routes> k(balls_on(Rows(4, 0)), Grid{2, 1}, {2, 1}, 3);
    REQUIRE(k.on(0) == Rows{1, 2});
    REQUIRE(k.on(1) == Rows{3, 4});
    // Records 1 and 4 found no room: 1 has a copy on tile 0, 4 nothing.
    k.mesh().state<Marks<Routes>>(k.tile(0))[0].bits = Mark::copy | Mark::owes;
    k.truncate(1, 1);
    k.keeper.set_missing({0, 3});
    CHECK(k.each_is_somewhere());
    auto const before = k.changes(0);
    k.keeper.load(k.host, k.tiling, true);
    CHECK(k.keeper.missing().empty());
    CHECK(k.on(0) == Rows{1, 2});
    CHECK(k.on(1) == Rows{3, 4});
    CHECK(k.mesh().state<Marks<Routes>>(k.tile(0))[0].bits == Mark::owes);
    CHECK(k.changes(0) == before + 1);
    CHECK(k.each_is_somewhere());
}

TEST_CASE("keeper: what finds no room stays missing, in order")
{
    Kept<Routes> k(balls_on(Rows(6, 0)), Grid{2, 1}, {2, 1}, 3);
    REQUIRE(k.on(0) == from_to(1, 3));
    // Records 2, 3 and 5 are lost. Copies of other records have their slots, except one.
    for (std::uint32_t slot : {1u, 2u}) {
        k.mesh().state<Storage<Routes>>(k.tile(0))[slot].id = GaussianId{6};
        k.mesh().state<Marks<Routes>>(k.tile(0))[slot] = {GaussianId{6}, Mark::copy};
    }
    k.mesh().state<Storage<Routes>>(k.tile(1))[1] = k.mesh().state<Storage<Routes>>(k.tile(1))[2];
    k.mesh().state<Marks<Routes>>(k.tile(1))[1] = k.mesh().state<Marks<Routes>>(k.tile(1))[2];
    k.truncate(1, 2);
    k.keeper.set_missing({1, 2, 4});
    k.keeper.load(k.host, k.tiling, true);
    CHECK(k.on(0) == Rows{1});
    CHECK(k.on(1) == Rows{4, 6, 2});
    CHECK(k.keeper.missing() == Rows{2, 4});
    CHECK(k.each_is_somewhere());
}

TEST_CASE("keeper: recalls the copies of missing records, and no other")
{
    Kept<Routes> k(balls_on(Rows(4, 0)), Grid{2, 2}, {2, 2}, 5);
    for (std::uint32_t t : {0u, 2u, 3u}) k.bring_copy(2, t);
    k.bring_copy(1, 3);
    k.bring_copy(3, 0);
    CHECK_FALSE(k.keeper.recall_copies(k.host)); // nothing is missing
    REQUIRE(k.on(1) == Rows{2});
    k.truncate(1, 0);
    k.keeper.set_missing({1});
    auto const before = k.changes(3);
    CHECK(k.keeper.recall_copies(k.host));
    CHECK(k.on(0, true) == Rows{3});
    CHECK(k.on(2, true).empty());
    CHECK(k.on(3, true) == Rows{1});
    CHECK(k.on(0) == Rows{1});
    CHECK(k.on(3) == Rows{4});
    CHECK(k.changes(3) == before + 1);
    CHECK(k.each_is_somewhere());
    CHECK_FALSE(k.keeper.recall_copies(k.host)); // they are gone
    CHECK(k.keeper.missing() == Rows{1});
}

TEST_CASE("keeper: without routing each view places what it shows, in order; a full tile's are missing, the others parked")
{
    auto gaussians = balls_on({0, 1, 1, 2, 1, 1, 0});
    gaussians[3].mean_world[2] = -1; // behind
    Kept<Stays> k(gaussians, Grid{3, 1}, {3, 1}, 3);
    CHECK(k.on(0).empty()); // until there is a view
    auto camera = support::flat_camera(24, 8);
    k.keeper.place(k.host, make_view(camera, Rules{}), k.tiling);
    CHECK(k.on(0) == Rows{1, 7});
    CHECK(k.on(1) == Rows{2, 3, 5});
    CHECK(k.on(2).empty());
    CHECK(k.keeper.missing() == Rows{5}); // row 5 is record 6: three are before it
    CHECK(k.keeper.parked() == 1);
    CHECK(k.each_is_somewhere());
    CHECK(k.mesh().state<Splats<Stays>>(k.tile(1))[0].anchor == k.tile(1));

    camera.cx = 8; // all one tile to the right: missing records are still missing
    k.keeper.place(k.host, make_view(camera, Rules{}), k.tiling);
    CHECK(k.on(0).empty());
    CHECK(k.on(1) == Rows{1, 7});
    CHECK(k.on(2) == Rows{2, 3, 5});
    CHECK(k.keeper.missing() == Rows{5});
    camera.cx = -8; // to the left: two records leave the picture
    k.keeper.place(k.host, make_view(camera, Rules{}), k.tiling);
    CHECK(k.on(0) == Rows{2, 3, 5});
    CHECK(k.keeper.parked() == 3);
    CHECK(k.each_is_somewhere());
    camera.rotation[0][0] = camera.rotation[2][2] = -1; // the other way: 4 alone is in front, or nothing
    k.keeper.place(k.host, make_view(camera, Rules{}), k.tiling);
    CHECK(k.keeper.missing().empty());
    CHECK(k.each_is_somewhere());
}
