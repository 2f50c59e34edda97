// test: unoptimised asan, without tsan, cost 20
#include "../splat/pose_case.hpp"
#include "on_poplar.hpp"
#include <cstddef>
#include <string>

// The program that tracks as codelets on a graph, on the stand-in for Poplar: the sums that the host reads at tile (0, 0) have the bits of
// the thread engine, and so have the words of all tiles.
using namespace tilemesh;
using namespace tilemesh::track;
using poplar_test::executions;

using Tracked = splat::pose::Tracked<splat::Lossless>;
using Tracking = splat::pose::PoseFrame<Tracked>;
using splat::pose::TileTotal;
using tilemesh::detail::BeginReduce;
using tilemesh::detail::GoOnReducing;

VERTEX(pose_project, Mk2, Tracking, splat::Project<Tracked>)
VERTEX(pose_route, Mk2, Tracking, splat::Route<Tracked>)
VERTEX(pose_bloom, Mk2, Tracking, splat::Bloom<Tracked>)
VERTEX(pose_depth_sort, Mk2, Tracking, splat::DepthSort<Tracked>)
MULTI_VERTEX(pose_composite_with_pose, Mk2, Tracking, splat::pose::CompositeWithPose<Tracked>)
MULTI_VERTEX(pose_composite, Mk2, Tracking, splat::Composite<Tracked>)
VERTEX(pose_send_cells, Mk2, Tracking, splat::pose::SendCells<Tracked>)
VERTEX(pose_add_gradients, Mk2, Tracking, splat::pose::AddGradients<Tracked>)
VERTEX(pose_sum_sums_of_a_tile_begin, Mk2, Tracking, BeginReduce<TileTotal, Sum, ReduceTo::one>)
VERTEX(pose_sum_sums_of_a_tile, Mk2, Tracking, GoOnReducing<TileTotal, Sum, ReduceTo::one>)

namespace {
template <class Program, class>
using OnMk2 = PoplarMesh<Program, Mk2>; // the vertices above
using OnThreads = BasicPoseEvaluator<Tracked>;
using OnGraph = BasicPoseEvaluator<Tracked, OnMk2>;

/// The words of all states of all tiles, but for the workers' memory: what a kernel leaves there is not read again, and host threads do
/// without it.
template <class M, class... X>
engine_test::WordList words_of(M& mesh, machine::Types<X...>)
{
    engine_test::WordList words;
    [[maybe_unused]] auto const add = [&](TileId t, auto* state) {
        using State = std::remove_pointer_t<decltype(state)>;
        if constexpr (!std::is_same_v<State, splat::pose::Workspaces>) engine_test::add_state(mesh, t, words, state);
    };
    for (TileId const t : mesh.grid().tiles()) (add(t, static_cast<X*>(nullptr)), ...);
    return words;
}
void compare(support::pose::SumsCase const& c, Extent2 tile, std::vector<TrackOptions> const& all)
{
    Extent2 const frame{c.camera.width, c.camera.height};
    OnThreads threads(c.map, frame, {2, tile});
    OnGraph graph(c.map, frame, {1, tile}, poplar_test::options("pose"));
    threads.set_target(c.target);
    graph.set_target(c.target);
    auto camera = c.camera;
    for (auto const& o : all) {
        CAPTURE(o.level.cell);
        CAPTURE(static_cast<int>(o.level.jacobian));
        auto const expected = threads.evaluate(camera, o), sums = graph.evaluate(camera, o);
        CHECK(expected.pixels > 0);
        CHECK(expected.h[0][0] > 0);
        CHECK(support::pose::same_sums(sums, expected));
        engine_test::check_same(threads.counters(), graph.counters());
        CHECK(words_of(threads.mesh(), typename OnThreads::MeshType::States{}) == words_of(graph.mesh(), typename OnGraph::MeshType::States{}));
        camera.position[0] += 0.01f; // records move
    }
}
} // namespace

TEST_CASE("poplar: the sums of a pose have the bits of the thread engine, in every order of workers")
{
    using support::pose::sums_options;
    standin::Restore const restore;
    auto const c = support::pose::sums_case(48, 40, 150, 41);
    for (auto const& e : executions) {
        CAPTURE(e.name);
        poplar_test::use(e);
        compare(c, {16, 16}, {sums_options(Jacobian::forward, 1), sums_options(Jacobian::esm, 2), sums_options(Jacobian::forward, 4)});
    }
    poplar_test::use(executions[2]);
    compare(c, {24, 8}, {sums_options(Jacobian::forward, 8), sums_options(Jacobian::gradient, 8), sums_options(Jacobian::forward, 2)});
    compare(c, {17, 13}, {sums_options(Jacobian::gradient, 1), sums_options(Jacobian::forward, 1)}); // one column of tiles has 14 pixels
    compare(c, {48, 40}, {sums_options(Jacobian::esm, 1), sums_options(Jacobian::forward, 4)});      // one tile: nothing to reduce
}

TEST_CASE("poplar: the graph of the program that tracks has the variables of its ledger, and fits where its code fits")
{
    standin::Restore const restore;
    constexpr Grid grid{6, 5};
    constexpr auto lines = on_poplar::ledger<Mk2, Tracking, Tracked>(grid);
    std::size_t left = 0; // bytes that the ledger leaves for code, exchange code and stacks
    for (auto const& line : lines) left = line.bytes;
    auto const sizes = splat::pose::sizes_on<Tracked>(size_of_machine<Mk2>(), Tracked::sizes.tile_pixels);
    CHECK(sizes.storage >= Tracked::sizes.storage);
    standin::settings().code_bytes = left;
    PoplarMesh<Tracking, Mk2> mesh{{}, grid, mesh_sizes<Tracking, Mk2, Tracked>(), poplar_test::options("pose")};
    mesh.prepare();
    auto found = standin::tile_bytes(mesh.engine(), 0).variables;
    for (auto const& line : Tile<Mk2, Tracking, Tracked>::ledger())
        if (std::string(line.what) != "reserve") CHECK(poplar_test::take(found, line) == line.bytes);
}
