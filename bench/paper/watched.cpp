#include "machines.hpp"
#include <tilemesh/machine/operations.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/renderer.hpp>

namespace paper {

namespace {

/// With room for the paper's channels and for most of a map on one tile, to be limited: modelled cycles do not depend on what
/// is not used.
struct Traced : splat::Lossless {
    using Machine = tilemesh::Traced<tilemesh::TestMachine<64u << 20>>;
    static constexpr std::uint32_t storage_slots = 20'000;
    static constexpr std::uint32_t road_bytes = 400 * sizeof(splat::Addressed);
    static constexpr std::uint32_t beam_bytes = 400 * sizeof(splat::Gaussian);
};

class WatchedRenderer final : public Watched {
public:
    WatchedRenderer(scene::Map const& map, Options const& options)
        : renderer_(map, {.threads = options.threads,
                          .grid = {grid_columns, grid_rows},
                          .channel_slots = options.channel_slots,
                          .storage_slots = options.storage == Storage::roomy ? 0 : splat::Lossless::storage_slots,
                          .footprint = options.footprint})
    {}
    ModelledFrame render(splat::Camera const& camera) override
    {
        renderer_.render_into(camera, frame_);
        auto const cost = tilemesh::model_cost(model_, renderer_.trace(), renderer_.mesh().grid());
        return {frame_.report, tilemesh::milliseconds(model_, cost.cycles)};
    }

private:
    tilemesh::BasicRenderer<splat::Referenced<Traced>> renderer_;
    tilemesh::RenderedFrame frame_;
    tilemesh::CostModel model_ = tilemesh::mk2();
};

} // namespace

std::unique_ptr<Watched> make_watched(scene::Map const& map, Watched::Options options)
{
    return std::make_unique<WatchedRenderer>(map, options);
}

} // namespace paper
