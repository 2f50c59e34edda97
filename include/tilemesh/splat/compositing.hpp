#pragma once
#include <tilemesh/splat/blending.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

namespace kernel {
template <class S>
struct Composite {
    static constexpr char const* name = "composite";
    static constexpr std::uint32_t most_workers = Work::max_workers;

    void operator()(Here here, Broadcast<typename S::Parameters> frame, Splats<S> const& splats, Order<S> const& order,
                    Framebuffer<S>& framebuffer, Work& work, Worker worker) const noexcept
    {
        if (AccessOf<S>::keeps_pixels(here, *frame)) return;
        auto const tile = pixels_of(frame->tiling, frame->view.camera, here.tile);
        auto const at = AccessOf<S>::in_order(*frame, splats.begin(), order.begin());
        auto const pairs = S::Blending::tile(tile, *frame, order.size(), at, framebuffer.begin(), tile.x1 - tile.x0, worker);
        work.evaluated[worker.index] = pairs.evaluated;
        work.contributing[worker.index] = pairs.contributing;
    }

    /// For a cost model. All workers wait for the worker with the most pairs.
    static Operations operations(Framebuffer<S> const& framebuffer, Work const& work, Worker worker) noexcept
    {
        std::uint32_t most = 0;
        for (std::uint32_t w = 0; w < worker.count; ++w) most = work.evaluated[w] > most ? work.evaluated[w] : most;
        Operations o;
        o[Operation::pair] = times(most, worker.count * pairs_a_count);
        o[Operation::pixel] = framebuffer.size();
        return o;
    }

    /// Computes the shares of all workers at once, for a host thread.
    struct AllWorkers {
        static constexpr char const* name = Composite::name;
        void operator()(Here here, Broadcast<typename S::Parameters> frame, Splats<S> const& splats, Order<S> const& order,
                        Framebuffer<S>& framebuffer, Work& work, Worker worker) const noexcept
        {
            if (AccessOf<S>::keeps_pixels(here, *frame)) return;
            auto const tile = pixels_of(frame->tiling, frame->view.camera, here.tile);
            auto const at = AccessOf<S>::in_order(*frame, splats.begin(), order.begin());
            PairCount pairs[Work::max_workers] = {};
            S::Blending::whole(tile, *frame, order.size(), at, framebuffer.begin(), tile.x1 - tile.x0, pairs, worker.count);
            for (std::uint32_t w = 0; w < worker.count; ++w) {
                work.evaluated[w] = pairs[w].evaluated;
                work.contributing[w] = pairs[w].contributing;
            }
        }
    };
};
} // namespace kernel

/// Blends the tile's pixels front to back (blending.hpp), in the order that DepthSort made.
///
/// Requires a framebuffer with the tile's pixels; the host sizes it when it sets the tiling. The kernel runs on all workers. Each worker
/// takes whole blocks or cells, so the workers write disjoint pixels. Cost: no exchange; 80 pairs (`precise`) or 32 pairs (`fast`) for each
/// splat that may be visible in a block or cell, until all its pixels have stopped.
///
/// A host that moves references may let a tile keep its pixels and its counters of pairs, if both are known to be those of the last frame
/// (render/kept_pixels.hpp). No word of the tile shows that it did.
template <class S>
using Composite = kernel::Composite<PoliciesOf<S>>;

}}} // namespace tilemesh::splat
