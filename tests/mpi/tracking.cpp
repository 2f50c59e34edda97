// The program that tracks over ranks: its sums, tile by tile and those that rank 0 reads at tile (0, 0), have the bits of one process.
#include "../splat/pose_case.hpp"
#include "on_ranks.hpp"

using namespace mpi_test;
using namespace tilemesh::track;

namespace {
using Tracked = splat::pose::Tracked<splat::Lossless>;
using Program = splat::pose::PoseFrame<Tracked>;
using OneProcess = BasicPoseEvaluator<Tracked>;
using Totals = Reduced<splat::pose::TileTotal, Sum>;
using Parameters = OneProcess::Parameters;

template <class T>
bool same_bits(T const& a, T const& b)
{
    return std::memcmp(&a, &b, sizeof a) == 0;
}
/// What the host loads before the first evaluation: the records, tile by tile in turn, and each tile's targets and framebuffer.
void load(MpiMesh<Program, Mk2>& mesh, support::pose::SumsCase const& c, OneProcess& from)
{
    auto const grid = mesh.grid();
    for (std::uint32_t i = 0; i < grid.size(); ++i) {
        auto const tile = grid.tile(i);
        if (!mesh.owns(tile)) continue;
        for (std::size_t k = i; k < c.map.gaussians.size(); k += grid.size()) REQUIRE(support::put<Tracked>(mesh, tile, c.map.gaussians[k]));
        mesh.state<splat::Counts>(tile).changes = 1;
        auto target = mesh.state<splat::pose::Target<Tracked>>(tile);
        for (auto const& pixel : from.mesh().state<splat::pose::Target<Tracked>>(tile)) target.unchecked_push(pixel);
        auto pixels = mesh.state<splat::Framebuffer<Tracked>>(tile);
        for (auto const& pixel : from.mesh().state<splat::Framebuffer<Tracked>>(tile)) pixels.unchecked_push(pixel);
    }
}
/// Evaluates one case after the other over the ranks and in one process, in several forms of the engine.
void compare(support::pose::SumsCase const& c, Extent2 tile, std::vector<TrackOptions> const& all)
{
    for (std::uint32_t form = 0; form < 2; ++form) {
        CAPTURE(form);
        OneProcess one(c.map, {c.camera.width, c.camera.height}, {1, tile});
        one.set_target(c.target);
        (void)one.evaluate(c.camera, all.front());
        auto const grid = one.mesh().grid();
        delay(form == 0 ? 0 : 30);
        MpiMeshOptions how{.threads = form + 1};
        if (form == 1) { // the first rank has one row, some may have none
            how.row_weights.resize(grid.height, 1);
            how.row_weights.front() = grid.height;
        }
        auto const mk2 = size_of_machine<Mk2>();
        auto const slots = splat::pose::sizes_on<Tracked>(mk2, tile.width * tile.height);
        MpiMesh<Program, Mk2> ranks(MPI_COMM_WORLD, Program{}, grid,
                                    engine::plain_sizes<Program>(mk2, slots, machine::Needs<Program>::States{}, machine::Needs<Program>::Links{}), how);
        load(ranks, c, one);
        auto camera = c.camera;
        for (auto const& o : all) {
            CAPTURE(o.level.cell);
            CAPTURE(static_cast<int>(o.level.jacobian));
            auto const expected = one.evaluate(camera, o);
            CHECK(expected.pixels > 0);
            ranks.broadcast<Parameters>() = one.mesh().broadcast<Parameters>();
            ranks.broadcast<Parameters>().view_changed = 1;
            ranks.broadcast<splat::pose::Tracking>() = one.mesh().broadcast<splat::pose::Tracking>();
            ranks.run();
            ranks.gather<Totals>(); // rank 0 need not have a tile
            for (TileId const t : grid.tiles())
                if (ranks.owns(t)) CHECK(same_bits(ranks.state<splat::pose::TileTotals>(t), one.mesh().state<splat::pose::TileTotals>(t)));
            if (rank() == 0) CHECK(same_bits(ranks.state<Totals>(TileId::at(0, 0)), one.mesh().state<Totals>(TileId::at(0, 0))));
            camera.position[0] += 0.01f; // records move
        }
        delay(0);
    }
}
} // namespace

TEST_CASE("tracking over ranks: the sums of a pose have the bits of one process")
{
    using support::pose::sums_options;
    auto const c = support::pose::sums_case(64, 48, support::fast() ? 60 : 150, 51);
    compare(c, {16, 8}, {sums_options(Jacobian::forward, 1), sums_options(Jacobian::esm, 1), sums_options(Jacobian::forward, 4), sums_options(Jacobian::gradient, 8)});
    compare(c, {24, 24}, {sums_options(Jacobian::esm, 2), sums_options(Jacobian::forward, 8), sums_options(Jacobian::forward, 2)});
    compare(c, {64, 48}, {sums_options(Jacobian::gradient, 1), sums_options(Jacobian::forward, 1)}); // all ranks but one have no tile
}
