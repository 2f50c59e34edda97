// test: unoptimised asan, without tsan, cost 10
#include "../mapping/support.hpp"
#include "on_poplar.hpp"
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <tilemesh/mapping/mesh_refiner.hpp>
#include <tilemesh/splat/map/grow.hpp>
#include <tilemesh/splat/map/insert.hpp>
#include <tilemesh/splat/map/program.hpp>
#include <vector>

// A mapping step as codelets on a graph, on the stand-in for Poplar: the map, the losses, the counters and the words of all tiles are those
// of the thread engine. So are those of a map that grows.
using namespace tilemesh;
namespace map = splat::map;
using poplar_test::executions;

using Optimiser = map::SecondMomentByKind;
using Growing = map::GrowStep<Optimiser>;
using ShadedOptimiser = map::Shaded<Optimiser, 2>;
using Shading = map::MapStep<ShadedOptimiser>;

/// The vertices of MapStep, which GrowStep has too. `Projection`: the kernel that projects the records.
#define MAP_STEP_VERTICES(prefix, Program, Opt, Projection)                \
    VERTEX(prefix##_begin_rest, Mk2, Program, map::BeginRest)              \
    MULTI_VERTEX(prefix##_find_goals, Mk2, Program, map::FindGoals)        \
    VERTEX(prefix##_start_rest, Mk2, Program, map::StartRest)              \
    VERTEX(prefix##_offer_room, Mk2, Program, map::OfferRoom<Opt>)         \
    VERTEX(prefix##_move_records, Mk2, Program, map::MoveRecords<Opt>)     \
    VERTEX(prefix##_begin_view, Mk2, Program, map::BeginView)              \
    MULTI_VERTEX(prefix##_project_records, Mk2, Program, Projection)       \
    VERTEX(prefix##_cast, Mk2, Program, map::Cast)                         \
    VERTEX(prefix##_sort_entries, Mk2, Program, map::SortEntries)          \
    MULTI_VERTEX(prefix##_walk, Mk2, Program, map::Walk)                   \
    MULTI_VERTEX(prefix##_add_up, Mk2, Program, map::AddUp)                \
    VERTEX(prefix##_return, Mk2, Program, map::Return)                     \
    MULTI_VERTEX(prefix##_take_step, Mk2, Program, map::TakeStep<Opt>)

MAP_STEP_VERTICES(grow, Growing, Optimiser, map::ProjectRecords)
MAP_STEP_VERTICES(shade, Shading, ShadedOptimiser, map::ProjectShaded<ShadedOptimiser>)
VERTEX(grow_begin_cells, Mk2, Growing, map::BeginCells)
MULTI_VERTEX(grow_look, Mk2, Growing, map::Look)
VERTEX(grow_pass_cells, Mk2, Growing, map::PassCells)
VERTEX(grow_insert_cells, Mk2, Growing, map::InsertCells<Optimiser>)
VERTEX(grow_remove_faded, Mk2, Growing, map::RemoveFaded<Optimiser>)

namespace {
scene::Map cloud(std::uint32_t gaussians)
{
    auto made = support::cloud(gaussians, 3);
    for (auto& g : made)
        for (float& s : g.log_scale) s = std::max(s, -4.0f);
    return support::map_of(std::move(made));
}
mapping::MeshRefineOptions options()
{
    mapping::MeshRefineOptions o;
    o.refine.view = {{32, 15}, 1, {1, 0.5f, 0, 0, 4}};
    o.channel_slots = 2;
    return o;
}
bool same(std::vector<splat::Gaussian> const& a, std::vector<splat::Gaussian> const& b)
{
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
}
} // namespace

TEST_CASE("poplar: a mapping step with harmonics has the map, losses, counters and words of the thread engine, in every order of workers")
{
    standin::Restore const restore;
    auto truth = cloud(support::fast() ? 30 : 60);
    truth.sh_degree = 2;
    support::Random random(7);
    truth.harmonics.resize(truth.gaussians.size() * ShadedOptimiser::words);
    for (float& v : truth.harmonics) v = random.uniform(-0.3f, 0.3f);
    auto const views = support::mapping::views_of(truth, {support::lens(64, 30), support::lens(64, 30, 0.2f)});
    auto const start = support::mapping::spoilt(truth, 2, 5);
    for (auto const& e : executions) {
        CAPTURE(e.name);
        poplar_test::use(e);
        mapping::MeshRefiner<ShadedOptimiser, Mesh, Mk2> threads(start, views.cameras[0], options());
        mapping::MeshRefiner<ShadedOptimiser, PoplarMesh, Mk2> graph(start, views.cameras[0], options(), poplar_test::options("shade"));
        for (std::uint32_t i = 0; i < 4; ++i) {
            if (i == 2) threads.rest(views.cameras[1]), graph.rest(views.cameras[1]);
            auto const expected = threads.step(views.cameras[i % 2], views.targets[i % 2], map::usual_rates(2));
            auto const fit = graph.step(views.cameras[i % 2], views.targets[i % 2], map::usual_rates(2));
            CHECK(fit.loss == expected.loss);
            CHECK(fit.pixels == 64 * 30);
            engine_test::check_same(threads.run(), graph.run());
            poplar_test::check_same_words(threads.mesh(), graph.mesh());
        }
        auto const a = threads.map(), b = graph.map();
        CHECK(a.gaussians.size() == start.gaussians.size());
        CHECK(same(a.gaussians, b.gaussians));
        CHECK(a.harmonics == b.harmonics);
        CHECK(a.harmonics != start.harmonics);
        CHECK(threads.lost().copies == 0);
    }
}

TEST_CASE("poplar: a map that grows has the map, counters and words of the thread engine, in every order of workers")
{
    standin::Restore const restore;
    auto const truth = cloud(40);
    auto const views = support::mapping::views_of(truth, {support::lens(64, 30), support::lens(64, 30, 0.2f)});
    for (auto const& e : executions) {
        CAPTURE(e.name);
        poplar_test::use(e);
        auto o = options();
        o.record_slots = 8; // too few for some tiles
        o.remove.least_opacity = 0.72f;
        o.insert.cell = 2; // the border of the rows of tiles cuts cells
        mapping::MeshRefiner<Optimiser, Mesh, Mk2, map::GrowStep> threads(support::map_of({}), views.cameras[0], o);
        mapping::MeshRefiner<Optimiser, PoplarMesh, Mk2, map::GrowStep> graph(support::map_of({}), views.cameras[0], o,
                                                                             poplar_test::options("grow"));
        auto const check = [&] {
            engine_test::check_same(threads.run(), graph.run());
            poplar_test::check_same_words(threads.mesh(), graph.mesh());
        };
        std::size_t inserted = 0, refused = 0, removed = 0;
        for (std::uint32_t i = 0; i < 2; ++i) {
            auto const expected = threads.insert(views.cameras[i], views.targets[i], i + 1);
            auto const grown = graph.insert(views.cameras[i], views.targets[i], i + 1);
            CHECK(grown.inserted == expected.inserted);
            CHECK(grown.refused == expected.refused);
            inserted += grown.inserted, refused += grown.refused;
            check();
            threads.step(views.cameras[i], views.targets[i], map::usual_rates(2));
            graph.step(views.cameras[i], views.targets[i], map::usual_rates(2));
            check();
            auto const gone = graph.remove(2);
            CHECK(gone == threads.remove(2));
            removed += gone;
            check();
        }
        CHECK(inserted > 20);
        CHECK(refused > 0);
        CHECK(removed > 0);
        auto const map = graph.map().gaussians;
        CHECK(map.size() == inserted - removed);
        CHECK(same(map, threads.map().gaussians));
    }
}
