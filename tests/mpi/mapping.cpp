#include "../mapping/support.hpp"
#include "on_ranks.hpp"
#include <tilemesh/mapping/mesh_refiner.hpp>
#include <tilemesh/splat/map/grow.hpp>

using namespace mpi_test;
namespace map = tilemesh::splat::map;

namespace {
template <class List, class To, class From>
void copy_lists(To& to, From& from)
{
    for (auto [tile, list] : to.template states<List>())
        for (auto const& item : from.template state<List>(tile)) list.push(item);
}
/// Loads the records, their optimiser states and the target of another mesh.
template <class Optimiser, class To, class From>
void load_map(To& to, From& from)
{
    copy_lists<map::Records>(to, from);
    copy_lists<map::OptimiserStates<Optimiser>>(to, from);
    copy_lists<map::TargetPixels>(to, from);
}
/// 60 Gaussians that are not smaller than `least`.
scene::Map cloud_of(float least)
{
    auto gaussians = support::cloud(60, 3);
    for (auto& g : gaussians)
        for (float& s : g.log_scale) s = std::max(s, least);
    return support::map_of(std::move(gaussians));
}
} // namespace

TEST_CASE("mapping steps: words, counters and digests of every superstep are those of Mesh, also where records move")
{
    using Optimiser = map::SecondMomentByKind;
    using Program = map::MapStep<Optimiser>;
    auto const truth = cloud_of(-4.0f);
    auto const views = support::mapping::views_of(truth, {support::lens(64, 50), support::lens(64, 50, 0.2f)});
    mapping::MeshRefineOptions o;
    o.refine.view = {{32, 10}, 1, {1, 0.5f, 0, 0, 4}};
    o.machine = size_of_machine<Roomy>();
    o.channel_slots = 3;
    o.entry_slots = 200;
    mapping::MeshRefiner<Optimiser, Mesh, Roomy> refiner(support::mapping::spoilt(truth, 2, 5), views.cameras[0], o);
    refiner.step(views.cameras[1], views.targets[1], map::usual_rates(2));
    REQUIRE(refiner.lost().copies == 0);
    // Each rank goes on from there: records move to the tiles of the second view, and step by it.
    auto const load = [&](auto& mesh) {
        load_map<Optimiser>(mesh, refiner.mesh());
        auto& step = mesh.template broadcast<map::StepParameters>();
        step = refiner.mesh().template broadcast<map::StepParameters>();
        step.rests = 1;
    };
    auto const last = on_ranks<Program, Roomy>(refiner.mesh().grid(), load, 2, Program{},
                                               mesh_sizes<Program>(size_of_machine<Roomy>(), refiner.sizes()));
    CHECK(last.messages() > 0);
}

TEST_CASE("a keyframe: words, counters and digests of every superstep are those of Mesh, where borders of ranks cut cells")
{
    using Optimiser = map::SecondMomentByKind;
    using Program = map::GrowStep<Optimiser>;
    auto const truth = cloud_of(-3.5f);
    auto const views = support::mapping::views_of(truth, {support::lens(64, 50), support::lens(64, 50, 0.2f)});
    mapping::MeshRefineOptions o;
    o.refine.view = {{32, 5}, 1, {1, 0.5f, 0, 0, 4}};
    o.machine = size_of_machine<Roomy>();
    o.channel_slots = 3;
    o.record_slots = 60;
    o.entry_slots = 400;
    o.remove.least_opacity = 0.72f;
    mapping::MeshRefiner<Optimiser, Mesh, Roomy, map::GrowStep> refiner(support::map_of({}), views.cameras[0], o);
    REQUIRE(refiner.insert(views.cameras[0], views.targets[0], 1).inserted > 40);
    for (int i = 0; i < 3; ++i) refiner.step(views.cameras[0], views.targets[0], map::usual_rates(2));
    REQUIRE(refiner.insert(views.cameras[1], views.targets[1], 2).inserted > 0);
    // Each rank inserts by the second view once more, and removes.
    auto const load = [&](auto& mesh) {
        load_map<Optimiser>(mesh, refiner.mesh());
        mesh.template broadcast<map::StepParameters>() = refiner.mesh().template broadcast<map::StepParameters>();
        auto& grow = mesh.template broadcast<map::GrowParameters>();
        grow = refiner.mesh().template broadcast<map::GrowParameters>();
        grow.keyframe = 3, grow.scene_depth = 2, grow.removes = 1;
    };
    auto const last = on_ranks<Program, Roomy>(refiner.mesh().grid(), load, 2, Program{},
                                               mesh_sizes<Program>(size_of_machine<Roomy>(), refiner.sizes()));
    CHECK(last.messages() > 0);
}
