#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/engine/mesh_sizes.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/spec.hpp>
#include <tilemesh/mapping/refiner.hpp>
#include <tilemesh/mapping/view_sums.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/map/grow.hpp>
#include <tilemesh/splat/map/insert.hpp>
#include <tilemesh/splat/map/optimise.hpp>
#include <tilemesh/splat/map/program.hpp>
#include <tilemesh/splat/view.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace mapping {

/// How a map is refined on a mesh. The members of `refine` mean what they mean for a `Refiner`.
struct MeshRefineOptions {
    RefineOptions refine{};
    Grid grid{0, 0};                                ///< 0 x 0: as many tiles as the reference view needs
    MachineSize machine = size_of_machine<Mk2>();
    std::uint32_t channel_slots = 100;              ///< messages in one end of a channel, at least 1
    std::uint32_t entry_slots = 0;                  ///< a limit of the splats that a tile holds; 0: all that fit
    std::uint32_t record_slots = 0;                 ///< records that a tile has room for, at least as many as rest on the fullest; 0: those
    splat::map::InsertRules insert{};               ///< of a map that grows, as `remove`
    splat::map::RemoveRules remove{};
};

/// What a step lacked, because tiles were full: it is counted, and the step goes on without it.
struct MapLosses {
    std::uint64_t records = 0; ///< that the view may show, and that found no slot on their own tile
    std::uint64_t copies = 0;  ///< that found no slot: tiles of the picture lack them, also those behind in the tree
};

/// What an insertion did.
struct Growth {
    std::size_t inserted = 0;
    std::size_t refused = 0; ///< cells that want a Gaussian, on tiles without a free slot: the map lacks these Gaussians
};

namespace detail {
/// Where the records of a map rest: record k of the list on tile `tile[k]`, in the order of the list.
struct Resting {
    std::vector<std::uint32_t> tile;
    std::uint32_t most_records = 0; ///< on one tile
    std::uint32_t most_entries = 0; ///< on one tile: records, and copies in the reference view
};
/// Records that a view shows rest on the tiles of their means; the others go where the fewest rest.
Resting rest(std::vector<splat::Gaussian> const& records, splat::View const& view, splat::Tiling const& tiling, Grid grid);
void expect_tiles(splat::Camera const& camera, splat::Tiling const& tiling, Grid grid);
void expect_room(MachineSize const& machine, std::size_t records, Resting const& resting, splat::map::MapSizes const& sizes,
                 std::uint32_t record_bytes);
/// Throws `Error` where a map cannot grow on these tiles.
void expect_growable(MeshRefineOptions const& options);
/// Throws `Error` for a keyframe that gives no new ids.
void expect_keyframe(splat::Camera const& camera, std::uint32_t cell, std::uint32_t keyframe, std::uint32_t last);
/// The rows of the map in the order of their ids. Throws `Error` for harmonics of another degree, and for an id that two records have.
std::vector<std::uint32_t> rows_by_id(scene::Map const& map, std::uint32_t degree);
/// Puts row `rows[k]` of the map, a record with its harmonics, in place k.
void put_in_order(scene::Map& map, std::vector<std::uint32_t> const& rows);
} // namespace detail

/// A `Refiner` whose map lies on the tiles of a mesh: `splat::map::MapStep` is the program. The map has the bits of a `Refiner`'s after the
/// same steps, as long as `lost()` was 0 in each, over tiles of whole blocks, grids, threads, engines and capacities of channels.
///
/// `reference` is the view by which the host lays the records on the tiles. Other views cost more hops, and change no bit; `rest` moves
/// the records to the tiles of another view. `MeshOf` is `Mesh`, `CheckedMesh` or `PoplarMesh`; `Machine` is `AnyMachine`,
/// `Traced<AnyMachine>` or a machine. For a map with harmonics, `Optimiser` is a `splat::map::Shaded` of the map's degree. Throws `Error`
/// as `Refiner`, for a map of another degree or with an id twice, for a view with more tiles than the grid, and for a map that does not
/// fit the tiles.
///
/// With `splat::map::GrowStep` for `ProgramOf`, the map also grows: `insert` and `remove` do what a keyframe of `slam::Mapper` does. It may
/// begin empty. `record_slots` must say how many records a tile may hold.
///
/// Memory: as much of each tile as is in use, besides the map.
template <class Optimiser = splat::map::SecondMomentByKind, template <class, class> class MeshOf = Mesh, class Machine = AnyMachine,
          template <class> class ProgramOf = splat::map::MapStep>
class MeshRefiner {
public:
    using Program = ProgramOf<Optimiser>;
    static constexpr std::uint32_t degree = splat::map::degree_of<Optimiser>;
    static constexpr bool grows = std::is_same_v<Program, splat::map::GrowStep<Optimiser>>;
    using MeshType = MeshOf<Program, Machine>;

    /// `mesh_options`: what the engine needs besides, as the device of a PoplarMesh. The threads are those of `options.refine.view`.
    MeshRefiner(scene::Map map, splat::Camera const& reference, MeshRefineOptions const& options = {},
                typename MeshType::Options mesh_options = {})
        : MeshRefiner(plan_of(std::move(map), reference, options), std::move(mesh_options))
    {
    }

    /// One step by one view. Returns how well the picture agreed before the step.
    Fit step(splat::Camera const& camera, Target const& target, splat::map::Rates const& rates)
    {
        auto const tiling = show(camera, target, rates, Task::step);
        run_ = mesh_.run();
        return fit_of(camera, tiling);
    }

    /// Moves the records on the mesh to the tiles of their means in a view. A record stays on its way where tiles are full. The map does
    /// not change, and no later step changes a bit; steps by views near this one cost fewer messages.
    void rest(splat::Camera const& camera)
    {
        tell(camera, {}, Task::rest);
        run_ = mesh_.run();
    }

    /// Inserts Gaussians where the map does not explain the target, as `slam::Mapper` does at a keyframe. Numbers of keyframes ascend, from
    /// 1, above those in the ids of the map. Each Gaussian rests on the tile of its cell. A tile without a free slot refuses further ones,
    /// which are counted; `rest` may make room. Throws `Error` for a number that does not ascend or is above 4,095.
    Growth insert(splat::Camera const& camera, Target const& target, std::uint32_t keyframe)
    {
        static_assert(grows, "MapStep inserts nothing (a mesh that does not grow has no memory for it); take GrowStep for ProgramOf");
        detail::expect_keyframe(camera, options_.insert.cell, keyframe, last_keyframe_);
        show(camera, target, {}, Task::insert, keyframe);
        last_keyframe_ = keyframe;
        run_ = mesh_.run();
        Growth out;
        for (auto [tile, c] : mesh_.template states<splat::map::GrowCounts>()) out.inserted += c.inserted, out.refused += c.refused;
        return out;
    }
    /// Removes faint and huge Gaussians. `scene_depth`: the median depth of the scene, above 0. Returns how many went.
    std::size_t remove(float scene_depth)
    {
        static_assert(grows, "MapStep removes nothing; take GrowStep for ProgramOf");
        mesh_.template broadcast<splat::map::StepParameters>().rests = 0;
        mesh_.template broadcast<splat::map::StepParameters>().steps = 0;
        mesh_.template broadcast<splat::map::GrowParameters>() = {options_.insert, options_.remove, scene_depth, 0, 0, 0, 1};
        run_ = mesh_.run();
        std::size_t out = 0;
        for (auto [tile, c] : mesh_.template states<splat::map::GrowCounts>()) out += c.removed;
        return out;
    }

    /// The map, with the records in the order of their ids.
    scene::Map map()
    {
        scene::Map out = facts_;
        for (auto [tile, records] : mesh_.template states<splat::map::Records>())
            out.gaussians.insert(out.gaussians.end(), records.begin(), records.end());
        if constexpr (degree != 0)
            for (auto [tile, states] : mesh_.template states<splat::map::OptimiserStates<Optimiser>>())
                for (auto const& s : states) out.harmonics.insert(out.harmonics.end(), std::begin(s.harmonics), std::end(s.harmonics));
        detail::put_in_order(out, detail::rows_by_id(out, degree));
        return out;
    }
    /// What the last step lacked.
    MapLosses lost()
    {
        MapLosses out;
        for (auto [tile, c] : mesh_.template states<splat::map::MapCounts>()) out.records += c.no_entry, out.copies += c.copies_full;
        return out;
    }
    /// The counters of the last step, or of the last `rest`.
    RunCounters const& run() const noexcept { return run_; }
    splat::map::MapSizes const& sizes() const noexcept { return sizes_; }
    MeshType& mesh() noexcept { return mesh_; }

private:
    enum class Task { step, rest, insert };
    /// Tells the tiles the view, and what to do with it.
    splat::Tiling tell(splat::Camera const& camera, splat::map::Rates const& rates, Task task,
                       [[maybe_unused]] std::uint32_t keyframe = 0)
    {
        auto const& o = options_.refine;
        scene::check_no_panorama(camera, "an insertion");
        scene::check_no_shutter(camera, "an insertion");
        auto const tiling = splat::make_tiling(camera.width, camera.height, o.view.tile.tile_width, o.view.tile.tile_height);
        detail::expect_tiles(camera, tiling, mesh_.grid());
        mesh_.template broadcast<splat::map::StepParameters>() = {splat::make_view(camera, o.rules), tiling, o.view.loss, rates, o.decays,
                                                                  sizes_.walkers, task == Task::rest, task == Task::step};
        if constexpr (grows)
            mesh_.template broadcast<splat::map::GrowParameters>() = {options_.insert, options_.remove, 0, keyframe,
                                                                      task != Task::rest, task == Task::insert, 0};
        return tiling;
    }
    /// `tell`, and each tile's part of the target.
    splat::Tiling show(splat::Camera const& camera, Target const& target, splat::map::Rates const& rates, Task task,
                       std::uint32_t keyframe = 0)
    {
        detail::expect_target(target, camera);
        auto const tiling = tell(camera, rates, task, keyframe);
        for (auto [tile, pixels] : mesh_.template states<splat::map::TargetPixels>()) {
            auto const r = splat::pixels_of(tiling, camera, tile);
            pixels.resize((r.x1 - r.x0) * (r.y1 - r.y0));
            auto* to = pixels.begin();
            for (std::uint32_t y = r.y0; y < r.y1; ++y) {
                auto const* const from = target.pixels.data() + std::size_t{y} * camera.width;
                to = std::copy(from + r.x0, from + r.x1, to);
            }
        }
        return tiling;
    }

    /// What must be known before the mesh is built.
    struct Plan {
        MeshRefineOptions options;
        scene::Map facts; ///< the map without its records
        std::vector<splat::Gaussian> records; ///< by their ids
        std::vector<float> harmonics;         ///< of each
        Grid grid;
        detail::Resting resting;
        splat::map::MapSizes sizes;
    };
    static Plan plan_of(scene::Map map, splat::Camera const& reference, MeshRefineOptions const& options)
    {
        auto const& o = options.refine;
        ViewSums const checked(o.view);
        if (options.channel_slots == 0) throw Error("a channel without a slot carries nothing (channel_slots is 0); take 1 or more");
        if constexpr (grows) detail::expect_growable(options);
        detail::put_in_order(map, detail::rows_by_id(map, degree));
        Plan plan{options, {}, std::move(map.gaussians), std::move(map.harmonics), options.grid, {}, {}};
        auto const tiling = splat::make_tiling(reference.width, reference.height, o.view.tile.tile_width, o.view.tile.tile_height);
        if (plan.grid.size() == 0) plan.grid = {tiling.columns, tiling.rows};
        detail::expect_tiles(reference, tiling, plan.grid);
        plan.resting = detail::rest(plan.records, splat::make_view(reference, o.rules), tiling, plan.grid);
        auto const slots = std::max(options.record_slots, plan.resting.most_records);
        plan.sizes = splat::map::sizes_on<Optimiser, ProgramOf>(options.machine, o.view.tile, slots, options.channel_slots,
                                                                grows ? options.insert.cell : 0);
        if (options.entry_slots == 0)
            detail::expect_room(options.machine, plan.records.size(), plan.resting, plan.sizes, splat::map::record_bytes<Optimiser>);
        else if (options.entry_slots < plan.sizes.entries)
            plan.sizes.entries = options.entry_slots, plan.sizes.sums = plan.sizes.entries * plan.sizes.walkers;
        map.gaussians.clear(), map.harmonics.clear();
        plan.facts = std::move(map);
        return plan;
    }
    static MeshSizes<Program> mesh_sizes_of(Plan const& plan)
    {
        auto sizes = mesh_sizes<Program>(plan.options.machine, plan.sizes);
        sizes.template undigested_of<splat::map::WalkSpaces>() = sizes.no_digest;
        return sizes;
    }
    static typename MeshType::Options with_threads(typename MeshType::Options options, [[maybe_unused]] std::uint32_t threads)
    {
        if constexpr (requires { options.threads; }) options.threads = threads;
        return options;
    }
    MeshRefiner(Plan plan, typename MeshType::Options mesh_options)
        : options_(plan.options), facts_(std::move(plan.facts)), sizes_(plan.sizes),
          mesh_(Program{}, plan.grid, mesh_sizes_of(plan), with_threads(std::move(mesh_options), plan.options.refine.view.threads))
    {
        for (std::size_t k = 0; k < plan.records.size(); ++k) {
            auto const tile = plan.grid.tile(plan.resting.tile[k]);
            mesh_.template state<splat::map::Records>(tile).push(plan.records[k]);
            typename Optimiser::State state{};
            if constexpr (degree != 0) std::copy_n(plan.harmonics.data() + Optimiser::words * k, Optimiser::words, state.harmonics);
            mesh_.template state<splat::map::OptimiserStates<Optimiser>>(tile).push(state);
            last_keyframe_ = std::max(last_keyframe_, static_cast<std::uint32_t>(plan.records[k].id) >> 20);
        }
    }
    /// The losses of the blocks, added up row by row of the frame, as `ViewSums` adds them.
    Fit fit_of(splat::Camera const& camera, splat::Tiling const& tiling)
    {
        Fit fit;
        std::uint32_t const across = tiling.tile_width / splat::block_width, down = tiling.tile_height / splat::block_height;
        for (std::uint32_t y = 0; y * splat::block_height < camera.height; ++y)
            for (std::uint32_t x = 0; x * splat::block_width < camera.width; ++x) {
                auto const losses = mesh_.template state<splat::map::BlockLosses>(TileId::at(x / across, y / down));
                auto const& one = losses[y % down * across + x % across];
                fit.loss += double{one.loss}, fit.squares += double{one.squares}, fit.pixels += one.pixels;
            }
        return fit;
    }

    MeshRefineOptions options_;
    scene::Map facts_;
    splat::map::MapSizes sizes_;
    MeshType mesh_;
    RunCounters run_;
    std::uint32_t last_keyframe_ = 0;
};

}}} // namespace tilemesh::mapping

#include <tilemesh/mapping/detail/mesh_refiner_code.hpp>
