#pragma once
#include "choice.hpp"
#include "followed_facts.hpp"
#include "instruments.hpp"
#include <cstddef>
#include <memory>
#include <tilemesh/fit_renderer.hpp>
#include <utility>
#include <vector>

namespace render_map {

/// A renderer on a machine that keeps a trace, with instruments.
template <class R>
class TracedRenderer final : public tilemesh::RendererOver<R>, public Instruments {
    using Base = tilemesh::RendererOver<R>;
    using Setup = typename R::Policies;
    using Steps = typename R::Steps;

public:
    TracedRenderer(tilemesh::scene::Map map, tilemesh::render::Setup facts, tilemesh::RendererOptions const& options,
                   typename R::EngineOptions engine)
        : Base(std::move(map), std::move(facts), options, std::move(engine))
    {
        this->renderer().observe([this](tilemesh::SuperstepEvent const& event) { look(event); });
    }

    tilemesh::RenderedFrame render(tilemesh::splat::Camera const& camera) override
    {
        supersteps_ = 0;
        tiles_.clear();
        follower_.begin_frame();
        return Base::render(camera);
    }

    tilemesh::Trace take_trace() override { return this->renderer().trace(); }
    std::vector<TileState> tiles() override { return tiles_; }
    void follow(tilemesh::splat::GaussianId id) override { followed_ = id; }
    Life life() override { return follower_.life(); }

private:
    /// Called after each superstep. A frame may run the program a second time; these supersteps follow those of the first run.
    void look(tilemesh::SuperstepEvent const& event)
    {
        ++supersteps_;
        if (event.step == Steps::composite) look_at_tiles();
        if (followed_ != tilemesh::splat::GaussianId::none) facts_.read(this->renderer(), event, supersteps_ - 1, followed_, follower_);
    }

    /// Records are those of the last run; refusals are those of all runs.
    void look_at_tiles()
    {
        namespace splat = tilemesh::splat;
        auto const& mesh = std::as_const(this->renderer().mesh());
        tiles_.resize(mesh.grid().size());
        for (std::uint32_t t = 0; t < mesh.grid().size(); ++t) {
            auto const tile = mesh.grid().tile(t);
            auto const& counts = mesh.template state<splat::Counts>(tile);
            auto& to = tiles_[t];
            to.records = to.copies = 0;
            to.pairs = 0;
            for (auto const& mark : mesh.template state<splat::Marks<Setup>>(tile)) {
                ++to.records;
                to.copies += mark.is(splat::Mark::copy) ? 1u : 0u;
            }
            auto const& work = mesh.template state<splat::Work>(tile);
            for (auto const evaluated : work.evaluated) to.pairs += std::uint64_t{evaluated} * splat::pairs_a_count;
            to.refusals += counts.by_channels();
            to.drops += counts.by_storage() + counts.copies_refused;
        }
    }

    std::size_t supersteps_ = 0; ///< of the frame
    std::vector<TileState> tiles_;
    tilemesh::splat::GaussianId followed_ = tilemesh::splat::GaussianId::none;
    FollowedFacts<R> facts_;
    Follower follower_;
};

} // namespace render_map
