// test: unoptimised test, cost 5
#include "../slam/support.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/mapping/mesh_refiner.hpp>
#include <tilemesh/splat/map/grow.hpp>
#include <tilemesh/splat/map/optimise.hpp>

using namespace tilemesh;
using slam::Mapper, slam::MapperOptions;
using splat::map::Adam, splat::map::GrowStep, splat::map::SecondMomentByKind;
namespace on_slam = support::slam;

namespace {
constexpr float depth = 2, missing = std::numeric_limits<float>::quiet_NaN();

/// Keyframes of the wall, with pixels that have no depth and some that do not count.
using Case = support::mapping::Views;
Case keyframes(std::size_t n)
{
    auto out = on_slam::keyframes(n);
    for (auto& target : out.targets)
        for (std::uint32_t y = 0; y < 60; ++y)
            for (std::uint32_t x = 0; x < 96; ++x) {
                auto& p = target.pixels[96 * y + x];
                if (x > 40 && x < 47 && y > 11 && y < 17) p.depth = 0; // over a border of tiles
                if ((x * 7 + y * 5) % 31 == 0) p.rgb[1] = missing;
            }
    return out;
}
MapperOptions mapper_options(slam::Optimiser optimiser, std::uint32_t cell = 2)
{
    MapperOptions o;
    o.optimiser = optimiser;
    o.first_steps = 6, o.steps = 4;
    o.insert.cell = cell;
    o.remove.least_opacity = 0.72f; // a new Gaussian has 0.731
    return o;
}
mapping::MeshRefineOptions mesh_options(MapperOptions const& m, splat::TileSize tile, std::uint32_t threads, std::uint32_t channel_slots,
                                        Grid grid = {0, 0})
{
    mapping::MeshRefineOptions o;
    o.refine.view = {tile, threads, {1, m.depth_weight, 0, 0, 4}};
    o.channel_slots = channel_slots;
    o.grid = grid;
    o.machine.sram_bytes = 16u << 20;
    o.record_slots = 2000;
    o.insert = m.insert;
    o.remove = m.remove;
    return o;
}
struct Result {
    std::vector<splat::Gaussian> records;
    std::vector<std::size_t> counts; ///< inserted and removed at each keyframe
};
bool same(Result const& a, Result const& b)
{
    return a.counts == b.counts && support::same_bits(a.records, b.records);
}
Result on_the_host(Case const& c, MapperOptions const& o)
{
    Mapper mapper({}, depth, o);
    Result out;
    for (std::size_t k = 0; k < c.cameras.size(); ++k) {
        auto const facts = mapper.add(c.cameras[k], c.targets[k]);
        out.counts.push_back(facts.inserted), out.counts.push_back(facts.removed);
    }
    out.records = mapper.map().gaussians;
    return out;
}
template <class Optimiser, template <class, class> class MeshOf = Mesh>
using Growing = mapping::MeshRefiner<Optimiser, MeshOf, AnyMachine, GrowStep>;

template <class Optimiser, template <class, class> class MeshOf = Mesh>
Result on_a_mesh(Case const& c, MapperOptions const& m, mapping::MeshRefineOptions const& o)
{
    Growing<Optimiser, MeshOf> mesh({}, c.cameras[0], o);
    Result out;
    for (std::size_t k = 0; k < c.cameras.size(); ++k)
        for (auto const n : on_slam::add_keyframe(mesh, c, k, m, depth)) out.counts.push_back(n);
    out.records = mesh.map().gaussians;
    return out;
}
using support::mapping::messages_of;
} // namespace

TEST_CASE("growth on the mesh: after three keyframes, the map has the records, ids and order of the host's mapper")
{
    auto const c = keyframes(3);
    auto const m = mapper_options(slam::Optimiser::by_kind);
    auto const host = on_the_host(c, m);
    REQUIRE(host.counts.size() == 6);
    CHECK(host.counts[0] > 1200); // of 48 x 30 cells
    for (std::size_t const n : host.counts) CHECK(n > 4);
    using By = SecondMomentByKind;
    CHECK(same(host, on_a_mesh<By>(c, m, mesh_options(m, {32, 20}, 1, 200))));
    CHECK(same(host, on_a_mesh<By>(c, m, mesh_options(m, {16, 15}, 2, 1)))); // borders cut cells
    CHECK(same(host, on_a_mesh<By>(c, m, mesh_options(m, {16, 5}, 3, 2))));
    CHECK(same(host, on_a_mesh<By>(c, m, mesh_options(m, {64, 40}, 2, 3)))); // the frame ends within tiles
    CHECK(same(host, on_a_mesh<By>(c, m, mesh_options(m, {16, 15}, 7, 200, {9, 7})))); // tiles outside of the picture
    CHECK(same(host, on_a_mesh<By, CheckedMesh>(c, m, mesh_options(m, {16, 15}, 1, 1))));

    auto const adam = mapper_options(slam::Optimiser::adam);
    CHECK(same(on_the_host(c, adam), on_a_mesh<Adam>(c, adam, mesh_options(adam, {16, 15}, 2, 1))));
}

TEST_CASE("growth on the mesh: cells of 1 to 16 pixels, also those that lie on several tiles, give the Gaussians of the host")
{
    auto const c = keyframes(2);
    for (std::uint32_t const cell : {1u, 2u, 4u, 8u, 16u}) {
        CAPTURE(cell);
        auto m = mapper_options(slam::Optimiser::by_kind, cell);
        m.first_steps = m.steps = 0;
        m.insert.opacity = 0.9f;
        auto const host = on_the_host(c, m);
        CHECK(host.counts[0] > 0);
        for (splat::TileSize const tile : {splat::TileSize{16, 5}, splat::TileSize{16, 15}, splat::TileSize{48, 20}}) {
            CAPTURE(tile.tile_height);
            CHECK(same(host, on_a_mesh<SecondMomentByKind>(c, m, mesh_options(m, tile, 2, 1))));
            CHECK(same(host, on_a_mesh<SecondMomentByKind, CheckedMesh>(c, m, mesh_options(m, tile, 1, 200))));
        }
    }
}

TEST_CASE("growth on the mesh: the sums of a cell cross each border that cuts it once, and nothing else crosses borders")
{
    auto const c = keyframes(1);
    auto const messages = [&](std::uint32_t cell, splat::TileSize tile, std::uint32_t slots) {
        auto const m = mapper_options(slam::Optimiser::by_kind, cell);
        Growing<SecondMomentByKind> mesh({}, c.cameras[0], mesh_options(m, tile, 1, slots));
        mesh.insert(c.cameras[0], c.targets[0], 1);
        CHECK(mesh.run().messages() == messages_of(mesh.run(), "pass cells"));
        return mesh.run().messages();
    };
    CHECK(messages(2, {32, 20}, 200) == 0);
    CHECK(messages(2, {16, 15}, 200) == 2 * 48); // borders at rows 15 and 45
    CHECK(messages(2, {16, 15}, 1) == 2 * 48);
    CHECK(messages(8, {16, 5}, 3) == 10 * 12);   // rows 5, 10, 15, ... but 40
    CHECK(messages(16, {16, 15}, 1) == 3 * 6);
}

TEST_CASE("growth on the mesh: a full tile refuses the Gaussians of its last cells, and counts them, whatever the engine and the channels")
{
    auto const c = keyframes(1);
    auto m = mapper_options(slam::Optimiser::by_kind);
    m.first_steps = 0;
    m.remove.least_opacity = 0;
    auto const wanted = on_the_host(c, m);
    auto const tiling = splat::make_tiling(96, 60, 16, 15);
    // The first `slots` cells of each tile, in the order of cells. A cell belongs to the tile of its last row.
    std::uint32_t const slots = 20;
    std::vector<splat::Gaussian> expected;
    std::vector<std::uint32_t> taken(24, 0);
    for (auto const& g : wanted.records) {
        auto const cell = (static_cast<std::uint32_t>(g.id) & 0xfffffu) - 1, row = 2 * (cell / 48) + 1, column = 2 * (cell % 48);
        if (taken[row / 15 * tiling.columns + column / 16]++ < slots) expected.push_back(g);
    }
    CHECK(expected.size() + 400 < wanted.records.size());
    auto const check = [&](auto& mesh) {
        auto const grown = mesh.insert(c.cameras[0], c.targets[0], 1);
        CHECK(grown.inserted == expected.size());
        CHECK(grown.refused == wanted.records.size() - expected.size());
        CHECK(support::same_bits(mesh.map().gaussians, expected));
        CHECK(mesh.remove(depth) == 0);
    };
    for (std::uint32_t const channel : {1u, 200u}) {
        auto o = mesh_options(m, {16, 15}, 2, channel);
        o.record_slots = slots;
        Growing<SecondMomentByKind> threads({}, c.cameras[0], o);
        check(threads);
        Growing<SecondMomentByKind, CheckedMesh> checked({}, c.cameras[0], o);
        check(checked);
    }
}

TEST_CASE("growth on the mesh: what is removed, and what stays, of a map to start from")
{
    auto const c = keyframes(1);
    auto start = on_slam::wall();
    start.gaussians[3].opacity = 0.017f;
    start.gaussians[9].opacity = 0.018f;                // stays
    start.gaussians[17].log_scale[1] = -0.5f;           // 0.607 of 2 * 0.3
    start.gaussians[20].log_scale[2] = -0.52f;          // 0.595
    start.gaussians[31].mean_world[0] = missing;
    std::vector<std::ptrdiff_t> gone{3, 17, 31};
    for (std::size_t i = 40; i < start.gaussians.size(); ++i) // many, so that one that goes moves into the slot of another
        if (i % 3 != 0) start.gaussians[i].opacity = 0.01f, gone.push_back(static_cast<std::ptrdiff_t>(i));
    MapperOptions const m;
    Growing<Adam> mesh(start, c.cameras[0], mesh_options(m, {32, 20}, 2, 10));
    CHECK(mesh.remove(depth) == gone.size());
    CHECK(mesh.run().messages() == 0);
    auto stays = start.gaussians;
    for (auto i = gone.rbegin(); i != gone.rend(); ++i) stays.erase(stays.begin() + *i);
    CHECK(support::same_bits(mesh.map().gaussians, stays));
    CHECK(mesh.remove(depth) == 0);
    std::size_t states = 0;
    for (auto [tile, list] : mesh.mesh().states<splat::map::OptimiserStates<Adam>>()) states += list.size();
    CHECK(states == stays.size());
}

TEST_CASE("growth on the mesh: a tile's bytes, and a program that does not grow pays nothing")
{
    using By = SecondMomentByKind;
    auto const machine = size_of_machine<Mk2>();
    auto sizes = splat::map::sizes_on<By, GrowStep>(machine, {32, 20}, 300, 100, 2);
    CHECK(sizes.cells == 16);
    CHECK(sizes.cell_slots == 16);
    CHECK(splat::map::sizes_on<By, GrowStep>(machine, {32, 20}, 300, 3, 2).cell_slots == 3);
    // Shown pixels; cells from above; two channel ends; the state of cells, counters of growth and of a pass; parameters.
    std::uint64_t const growth = (8 + 640 * 20) + (8 + 16 * 36) + 2 * (8 + 16 * 36) + 4 + 12 + 12 + 52;
    CHECK(SramLedger<GrowStep<By>>::bytes(machine, sizes) == SramLedger<splat::map::MapStep<By>>::bytes(machine, sizes) + growth);
    CHECK(SramLedger<GrowStep<By>>::bytes(machine, sizes) <= machine.sram_bytes);
    CHECK(splat::map::sizes_on<By>(machine, {32, 20}, 300, 100).entries == 1471);
    CHECK(sizes.entries == 1471 - 61);
}

TEST_CASE("growth on the mesh: what has no ids or no room is refused with a line")
{
    auto const c = keyframes(1);
    MapperOptions const m;
    auto const with = [&](auto const& change) {
        auto o = mesh_options(m, {32, 20}, 1, 10);
        change(o);
        return tests::error_of([&] { Growing<Adam> r({}, c.cameras[0], o); });
    };
    CHECK(with([](auto&) {}).empty());
    CHECK(with([](auto& o) { o.insert.cell = 3; }) ==
          "a map cannot grow in cells of 3 pixels on tiles of 32 x 20 (a tile adds up whole columns of cells); take cells whose side "
          "divides the width of a tile");
    CHECK(with([](auto& o) { o.insert.cell = 0; }).find("a map cannot grow in cells of 0 pixels") == 0);
    CHECK(with([](auto& o) { o.record_slots = 0; }) ==
          "a map cannot grow on tiles without a free slot (record_slots is 0); give the records that a tile may hold");
    Growing<Adam> mesh({}, c.cameras[0], mesh_options(m, {32, 20}, 1, 10));
    auto const insert = [&](std::uint32_t keyframe) {
        return tests::error_of([&] { mesh.insert(c.cameras[0], c.targets[0], keyframe); });
    };
    CHECK(insert(2).empty());
    CHECK(insert(2) == "a keyframe cannot have the number 2 (the map has ids of keyframe 2, and the last number is 4095); number keyframes "
                       "from 1 on, each above the one before");
    CHECK(insert(4096).find("a keyframe cannot have the number 4096") == 0);
    Growing<Adam> again(mesh.map(), c.cameras[0], mesh_options(m, {32, 20}, 1, 10));
    CHECK(tests::error_of([&] { again.insert(c.cameras[0], c.targets[0], 1); }).find("a keyframe cannot have the number 1 (") == 0);
}
