#pragma once
#include <tilemesh/machine/reduce.hpp>
#include <tilemesh/machine/superstep.hpp>
#include <tilemesh/splat/fitted.hpp>
#include <tilemesh/splat/frame_program.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/pose/gradients.hpp>
#include <tilemesh/splat/pose/operations.hpp>
#include <tilemesh/splat/pose/regions.hpp>
#include <tilemesh/splat/pose/tile.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

namespace pose {

/// The frame's parameters of a program that tracks by value: its tiles project records to PoseSplats.
struct PoseParameters : FrameParameters {
    static constexpr char const* name = "frame parameters (tracking)";
    static constexpr bool bends = true;
};
} // namespace pose

template <>
struct Access<pose::PoseParameters> : Access<FrameParameters> {
    template <class Record>
    static pose::PoseSplat project(Record const& record, FrameParameters const& frame) noexcept
    {
        return pose::PoseSplat(splat::project(record, frame.view, frame.tiling), pose::terms_of(record, frame.view, frame.tiling));
    }
    TILEMESH_KERNEL static pose::Terms const& terms_of(FrameParameters const&, pose::PoseSplat const& s) noexcept { return s.terms; }
};

namespace pose {

/// A setup that tracks: splats of 64 bytes, and room for the targets and the workers' memory instead of some records. Its sizes are those of
/// a tile of 640 pixels. Channels have half the slots of `Lossless`: a full one costs a pass, and no record. `sizes_on` gives other tiles.
template <class S>
struct Tracked : S {
    static constexpr char const* name = "tracking";
    using Projected = PoseSplat;
    using Parameters = PoseParameters;
    using Pixel = WithAlpha<WithDepth<FloatPixel>>; ///< for gradients; forward mode keeps no picture
    static constexpr Sizes sizes{/*storage*/ 1800, S::sizes.road / 2, S::sizes.beam / 2, S::sizes.waiting / 2, S::sizes.tile_pixels};
};

/// The value that a tile contributes to the reduction.
struct TileTotal {
    static constexpr char const* name = "sums of a tile";
    Totals operator()(TileTotals const& by_workers) const noexcept
    {
        Totals all{};
        for (auto const& one : by_workers.of) all = all + one;
        return all;
    }
};

namespace kernel {
template <class S>
struct CompositeWithPose {
    static constexpr char const* name = "composite with pose";
    static constexpr std::uint32_t most_workers = Work::max_workers;
    static constexpr bool has_region = !has_host_stack<typename S::Parameters>;

    void operator()(Here here, Broadcast<typename S::Parameters> frame, Broadcast<Tracking> tracking, Splats<S> const& splats,
                    Order<S> const& order, Target<S> const& target, [[maybe_unused]] OnlyIf<has_region, Workspaces&> workspaces, TileTotals& totals,
                    Work& work, Worker worker) const noexcept
    {
        if constexpr (has_region) {
            share(here, *frame, *tracking, splats, order, target, workspaces.of[worker.index], totals, work, worker);
        } else {
            Workspace<1, 1> workspace;
            share(here, *frame, *tracking, splats, order, target, workspace, totals, work, worker);
        }
    }

    /// For a cost model.
    static Operations operations(Here here, Broadcast<typename S::Parameters> frame, Broadcast<Tracking> tracking, Order<S> const& order,
                                 Work const& work, Worker worker) noexcept
    {
        return forward_operations(pixels_of(frame->tiling, frame->view.camera, here.tile), *tracking, order.size(), work.contributing, worker.count);
    }

    /// Computes the shares of all workers at once, for a host thread.
    struct AllWorkers {
        static constexpr char const* name = CompositeWithPose::name;
        void operator()(Here here, Broadcast<typename S::Parameters> frame, Broadcast<Tracking> tracking, Splats<S> const& splats,
                        Order<S> const& order, Target<S> const& target, OnlyIf<has_region, Workspaces&>, TileTotals& totals, Work& work,
                        Worker worker) const noexcept
        {
            auto const tile = pixels_of(frame->tiling, frame->view.camera, here.tile);
            for (std::uint32_t w = 0; w < worker.count; ++w) totals.of[w] = {}, work.contributing[w] = 0;
            Workspace<8, block_height> workspace;
            evaluate_tile<splat::detail::lanes_in_use, 64>(
                tile, frame->view, *tracking, order.size(),
                [&](std::uint32_t i) noexcept -> Splat const& { return AccessOf<S>::splat_of(*frame, splats[order[i].slot]); },
                [&](std::uint32_t i) noexcept -> Terms const& { return AccessOf<S>::terms_of(*frame, splats[order[i].slot]); }, target.begin(),
                workspace, WorkerSums{totals.of, work.contributing, worker.count}, Worker{0, 1});
            for (std::uint32_t w = 0; w < worker.count; ++w) work.evaluated[w] = evaluated_of(work.contributing[w]);
        }
    };

private:
    /// Blocks that hold the contributing pairs. Pairs that were looked at in vain depend on the number of rows that are blended at once.
    static std::uint32_t evaluated_of(std::uint32_t pairs) noexcept
    {
        constexpr std::uint32_t a_block = block_width * block_height;
        return (pairs + a_block - 1) / a_block * (a_block / pairs_a_count);
    }
    template <class Memory>
    static void share(Here const& here, typename S::Parameters const& frame, Tracking const& tracking, Splats<S> const& splats, Order<S> const& order,
                      Target<S> const& target, Memory& memory, TileTotals& totals, Work& work, Worker worker) noexcept
    {
        auto const tile = pixels_of(frame.tiling, frame.view.camera, here.tile);
        totals.of[worker.index] = {};
        work.contributing[worker.index] = 0;
        evaluate_tile<splat::detail::native_lanes, 16>(
            tile, frame.view, tracking, order.size(),
            [&](std::uint32_t i) noexcept -> Splat const& { return AccessOf<S>::splat_of(frame, splats[order[i].slot]); },
            [&](std::uint32_t i) noexcept -> Terms const& { return AccessOf<S>::terms_of(frame, splats[order[i].slot]); }, target.begin(), memory,
            WorkerSums{totals.of + worker.index, work.contributing + worker.index, 1}, worker);
        work.evaluated[worker.index] = evaluated_of(work.contributing[worker.index]);
    }
};
} // namespace kernel

/// Blends the tile's pixels with their derivatives by the pose, and adds up the rows of their least-squares problem (tile.hpp), in the
/// order that DepthSort made. Nothing of a picture is kept. It runs on all workers. Cost: no exchange.
template <class S>
using CompositeWithPose = kernel::CompositeWithPose<PoliciesOf<S>>;

/// One evaluation of a pose: the steps of a frame up to the order of the splats; forward mode, or the picture and its gradients; and a
/// reduction along the rows and then along column 0. Tile (0, 0) has the sums of the frame in `Reduced<TileTotal, Sum>`.
template <class S>
using PoseFrame =
    Sequence<Superstep<Project<S>>, StepIf<S::routes, UntilQuiet<Route<S>>>, StepIf<S::blooms, Superstep<Bloom<S>>>,
             StepIf<S::blooms, UntilQuiet<Bloom<S>>>, Superstep<DepthSort<S>>, If<&Tracking::forward, Superstep<CompositeWithPose<S>>>,
             If<&Tracking::gradients, Superstep<Composite<S>>, Superstep<SendCells<S>>, Superstep<AddGradients<S>>>, Reduce<TileTotal, Sum>>;

/// The sizes of a program that tracks, for tiles of `tile_pixels` pixels: storage gets all SRAM that the other regions leave, 0 slots if
/// they leave none. `S` is a setup by value. Records have harmonics up to `degree`, at least those of the setup; channels keep their bytes.
template <class S>
constexpr Sizes sizes_on(MachineSize const& machine, std::uint32_t tile_pixels, std::uint32_t degree = S::Record::sh_degree) noexcept
{
    auto const bytes = [&](Setup setup, std::uint32_t storage) {
        setup.sizes.storage = storage;
        return SramLedger<PoseFrame<S>>::bytes(machine, setup);
    };
    Setup setup = setup_of<S>();
    setup.sizes.tile_pixels = tile_pixels;
    auto const used = bytes(setup, 0);
    Setup shaded = setup;
    shaded.sh_degree = degree;
    auto sizes = refitted(shaded, setup).sizes;
    sizes.storage = slots_in(used < machine.sram_bytes ? machine.sram_bytes - used : 0,
                             static_cast<std::uint32_t>(bytes(shaded, 1) - bytes(shaded, 0)));
    return sizes;
}

} // namespace pose
}}} // namespace tilemesh::splat
