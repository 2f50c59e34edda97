#include "prototype_run.hpp"
#include "prototype.hpp"
#include <algorithm>
#include <common/scenes.hpp>
#include <limits>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/trajectory.hpp>

namespace paper {

namespace {

using Machine = Traced<TestMachine<4u << 20>>; // room for the paper's slots, and for the data that the mesh keeps twice
using PrototypeMesh = Mesh<Prototype, Machine>;
constexpr std::uint32_t columns = 40, rows = 36, tile_width = 32, tile_height = 20;

void limit_slots(PrototypeMesh& mesh, std::uint32_t channel, std::uint32_t storage)
{
    mesh.limit<Wire>(channel);
    mesh.limit<Staged<0>>(channel);
    mesh.limit<Staged<1>>(channel);
    mesh.limit<Staged<2>>(channel);
    mesh.limit<Staged<3>>(channel);
    mesh.limit<Stored>(storage);
    mesh.limit<StoredIds>(storage);
    mesh.limit<ToDraw>(storage);
}

/// Loads the map in the file's order, with an even share per tile. All other slots are free.
void load(PrototypeMesh& mesh, scene::Map const& map, std::uint32_t share, std::uint32_t storage)
{
    std::size_t next = 0;
    for (std::uint32_t t = 0; t < columns * rows; ++t) {
        auto stored = mesh.state<Stored>(mesh.grid().tile(t));
        auto ids = mesh.state<StoredIds>(mesh.grid().tile(t));
        stored.resize(storage);
        ids.resize(storage);
        for (std::uint32_t i = 0; i < storage; ++i) {
            bool const has = i < share && next < map.gaussians.size();
            stored[i] = has ? map.gaussians[next++] : Gaussian{};
            ids[i] = stored[i].id;
        }
    }
}

/// Adds `value` of each tile that ran.
template <class Value>
void add(OverTiles& sum, std::vector<TileSample> const& tiles, Value const& value)
{
    double least = std::numeric_limits<double>::infinity(), all = 0, most = 0;
    for (auto const& t : tiles) {
        double const v = value(t);
        least = std::min(least, v);
        all += v;
        most = std::max(most, v);
    }
    sum.least += least;
    sum.mean += all / static_cast<double>(tiles.size());
    sum.most += most;
}

} // namespace

PrototypeRun run_prototype(std::string const& name, std::filesystem::path const& data, PrototypePlan plan, CostModel const& model)
{
    constexpr std::array<Operation::Kind, stages_timed> counted = {Operation::routed, Operation::projection, Operation::comparison,
                                                             Operation::pair};
    auto const scene = bench::load_scene(name, data, {columns * tile_width, rows * tile_height});
    auto const poses = tilemesh::scene::load_tum(data / "trajectories" / (name + "_orbit.tum"));
    auto const share = static_cast<std::uint32_t>((scene.map.gaussians.size() + columns * rows - 1) / (columns * rows));
    auto const storage = coded_storage_slots + share;

    PrototypeMesh mesh{{}, {columns, rows}, {.threads = plan.threads}};
    limit_slots(mesh, coded_channel_slots, storage);
    load(mesh, scene.map, share, storage);
    PrototypeRun run;
    run.tiles = columns * rows;
    for (; run.frames < plan.frames; ++run.frames) {
        bool const draws = run.frames % plan.draw_every == plan.draw_every - 1;
        auto const camera =
            tilemesh::scene::make_camera(poses[run.frames % poses.size()].pose, tilemesh::scene::lens_of(scene.camera));
        mesh.broadcast<PrototypeFrame>() = {camera, tile_width, tile_height, columns, rows, draws ? 1u : 0u};
        mesh.run();
        run.drawn += draws ? 1 : 0;
        auto const cost = model_cost(model, mesh.trace(), mesh.grid());
        for (auto const& s : mesh.trace().supersteps) {
            auto const stage = s.step;
            if (stage >= index(Stage::sort) && !draws) continue;
            add(run.count[stage], s.tiles, [&](TileSample const& t) { return static_cast<double>(t.operations[counted[stage]]); });
            add(run.milliseconds[stage], s.tiles,
                [&](TileSample const& t) { return milliseconds(model, cost.busy[stage][t.tile]); });
            if (stage < run.waiting.size()) {
                add(run.waiting[stage], s.tiles, [](TileSample const& t) { return static_cast<double>(t.operations[Operation::waiting]); });
                for (auto const& t : s.tiles) {
                    run.counted_each[stage].push_back(static_cast<float>(t.operations[counted[stage]]));
                    run.waiting_each[stage].push_back(static_cast<float>(t.operations[Operation::waiting]));
                }
            }
            run.slots[stage] = s.tiles.front().operations[Operation::slot]; // on every tile, in every frame
        }
        run.exchange_ms += milliseconds(model, cost.supersteps[index(Stage::projection)].exchange);
        for (std::uint32_t t = 0; t < columns * rows; ++t) {
            auto const& happened = mesh.state<Happened>(mesh.grid().tile(t));
            run.lost += happened.lost;
            run.refused += happened.refused;
        }
    }
    auto const averaged = [&](OverTiles& sum, std::uint32_t frames) {
        double const n = std::max(frames, 1u);
        sum = {sum.least / n, sum.mean / n, sum.most / n};
    };
    for (std::uint32_t stage = 0; stage < stages_timed; ++stage) {
        auto const frames = stage >= index(Stage::sort) ? run.drawn : run.frames;
        averaged(run.count[stage], frames);
        averaged(run.milliseconds[stage], frames);
        if (stage < run.waiting.size()) averaged(run.waiting[stage], frames);
    }
    run.exchange_ms /= std::max(run.frames, 1u);
    return run;
}

} // namespace paper
