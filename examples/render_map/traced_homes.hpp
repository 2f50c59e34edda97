#pragma once
#include "instruments.hpp"
#include <algorithm>
#include <cstdint>
#include <memory>
#include <tilemesh/render/homes_renderer.hpp>
#include <utility>
#include <vector>

namespace render_map {

/// The program of homes on a machine that keeps a trace, with instruments. It follows no Gaussian: records of homes never move.
class TracedHomes final : public tilemesh::render::HostHomesRenderer, public Instruments {
    using Policies = tilemesh::splat::homes::AnyHostPolicies;
    using Base = tilemesh::render::HostHomesRenderer;

public:
    TracedHomes(tilemesh::scene::Map map, tilemesh::render::Setup const& choice, tilemesh::RendererOptions const& options,
                EngineOptions engine)
        : Base(std::move(map), choice, options, engine)
    {
        this->observe([this](tilemesh::SuperstepEvent const& event) { look(event); });
    }

    tilemesh::RenderedFrame render(tilemesh::splat::Camera const& camera) override
    {
        rounds_.clear();
        begins_ = true;
        return Base::render(camera);
    }

    tilemesh::Trace take_trace() override { return this->trace(); }
    void follow(tilemesh::splat::GaussianId) override {}
    Life life() override { return {}; }
    /// Of a map in chapters, the records are those of the last chapter. Counts are those of all.
    std::vector<TileState> tiles() override { return tiles_; }
    std::vector<TileRound> rounds() override { return rounds_; }

private:
    /// What a tile held in this round, and what it had refused before.
    struct Before {
        std::uint32_t rounds, refused, held, farthest;
    };

    /// Called after each superstep.
    void look(tilemesh::SuperstepEvent const& event)
    {
        namespace homes = tilemesh::splat::homes;
        auto const& mesh = std::as_const(this->mesh());
        if (event.kernel == homes::Begin<Policies>::name) {
            if (begins_) {
                tiles_.assign(mesh.grid().size(), {});
                chapter_ = round_ = 0;
                begins_ = false;
            }
            before_.assign(mesh.grid().size(), {});
            ++chapter_;
        } else if (event.kernel == homes::Merge<Policies>::name) {
            ++round_;
            for (std::uint32_t t = 0; t < before_.size(); ++t) {
                auto const tile = mesh.grid().tile(t);
                auto const order = mesh.state<homes::Order>(tile);
                before_[t].held = order.size();
                if (!order.empty()) before_[t].farthest = mesh.state<homes::Keys>(tile)[order[order.size() - 1]].depth_bits;
            }
        } else if (event.kernel == homes::Advance<Policies>::name) {
            for (std::uint32_t t = 0; t < before_.size(); ++t) look_at_round(t);
        } else if (event.kernel == homes::Finish<Policies>::name) {
            for (std::uint32_t t = 0; t < before_.size(); ++t) {
                auto const tile = mesh.grid().tile(t);
                auto const& counts = mesh.state<homes::Counts>(tile);
                auto& to = tiles_[t];
                to.records = mesh.state<homes::Home<Policies>>(tile).size();
                for (auto const evaluated : mesh.state<homes::Work>(tile).evaluated) to.pairs += std::uint64_t{evaluated} * homes::pairs_a_count;
                to.refusals += counts.by_channels();
                to.rounds += counts.rounds;
                to.entries += counts.arrived;
            }
        }
    }
    void look_at_round(std::uint32_t t)
    {
        namespace homes = tilemesh::splat::homes;
        auto const& mesh = std::as_const(this->mesh());
        auto const tile = mesh.grid().tile(t);
        auto const& counts = mesh.state<homes::Counts>(tile);
        auto const& window = mesh.state<homes::Window>(tile);
        auto& before = before_[t];
        if (counts.rounds == before.rounds) return; // it was done
        auto frontier = window.done() ? window.frontier_depth : window.lo_depth;
        if (frontier == homes::infinite_depth) frontier = before.farthest;
        // A chapter's last window has no end, so that its farthest splat may be nearer than the frontier of a round before.
        tiles_[t].frontier = std::max(tiles_[t].frontier, __builtin_bit_cast(float, frontier));
        rounds_.push_back({round_, chapter_, t, before.held, counts.refused - before.refused, tiles_[t].frontier, window.done()});
        before.rounds = counts.rounds;
        before.refused = counts.refused;
    }

    std::vector<TileState> tiles_;
    std::vector<TileRound> rounds_;
    std::vector<Before> before_;
    std::uint32_t round_ = 0, chapter_ = 0;
    bool begins_ = true; ///< no superstep of the frame has run
};

} // namespace render_map
