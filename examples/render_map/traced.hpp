#pragma once
#include "choice.hpp"
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
    TracedRenderer(tilemesh::scene::Map const& map, tilemesh::render::SetupFacts facts, tilemesh::RendererOptions const& options)
        : Base(map, std::move(facts), options)
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
        if (followed_ != tilemesh::splat::GaussianId::none) look_for_followed(event);
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
            for (auto const blocks : work.blocks)
                to.pairs += std::uint64_t{blocks} * splat::block_width * splat::block_height;
            to.channel_full += counts.channel_full;
            to.no_credit += counts.no_credit;
            to.storage_full += counts.storage_full;
            to.copies_full += counts.copies_full;
            to.copies_refused += counts.copies_refused;
        }
    }

    void look_for_followed(tilemesh::SuperstepEvent const& event)
    {
        namespace splat = tilemesh::splat;
        using tilemesh::Direction;
        auto& mesh = this->renderer().mesh();
        auto const& frame = mesh.template broadcast<typename Setup::Parameters>();
        bool const routes = event.step == Steps::route,
                   blooms = event.step == Steps::bloom_first || event.step == Steps::bloom;
        std::vector<Follower::Fact> facts;
        std::vector<tilemesh::TileId> full;
        no_room_.resize(mesh.grid().size(), 0);
        auto const record_id = [](auto const& message) { return Setup::Addressing::record(message).id; };
        for (std::uint32_t t = 0; t < mesh.grid().size(); ++t) {
            auto const tile = mesh.grid().tile(t);
            auto const add = [&](Seen what, std::optional<Direction> side = {}, bool refusal = false) {
                facts.push_back({tile, what, side, refusal});
            };
            auto const& counts = std::as_const(mesh).template state<splat::Counts>(tile);
            auto const no_room = std::exchange(no_room_[t], counts.storage_full + counts.copies_full);
            if (no_room_[t] > no_room) full.push_back(tile);
            auto const marks = std::as_const(mesh).template state<splat::Marks<Setup>>(tile);
            auto const slot = splat::find(marks, followed_);
            if (slot != splat::no_slot) {
                auto const mark = marks[slot];
                // Route tries in each superstep to send the records that leave.
                if (mark.is(splat::Mark::copy)) add(Seen::copy);
                else if (mark.is(splat::Mark::leaving)) add(Seen::leaving, {}, routes);
                else add(Seen::anchored);
                std::uint32_t owed = 0; // Bloom tries in each superstep too
                if (blooms && mark.is(splat::Mark::owes)) {
                    auto const& entry = std::as_const(mesh).template state<splat::Splats<Setup>>(tile)[slot];
                    auto const reach = splat::AccessOf<Setup>::reach(tilemesh::Here{tile, mesh.grid()}, frame, entry);
                    owed = reach.sides & splat::child_sides(reach.anchor, tile) & ~mark.bits;
                }
                for (Direction d : tilemesh::news) {
                    if (mark.is(splat::Mark::refused(d))) add(Seen::refused, d);
                    if ((owed & splat::Mark::shared(d)) != 0) add(Seen::owed, d, true);
                }
            }
            if constexpr (Setup::Saturation::may_hold) {
                for (auto const& m : std::as_const(mesh).template state<splat::Waiting<Setup, 0>>(tile))
                    if (record_id(m) == followed_) add(Seen::waiting, Setup::Routing::first_leg[0], routes);
                for (auto const& m : std::as_const(mesh).template state<splat::Waiting<Setup, 1>>(tile))
                    if (record_id(m) == followed_) add(Seen::waiting, Setup::Routing::first_leg[1], routes);
            }
            // Road and beam may share their memory, so only messages of this superstep are read.
            for (Direction d : tilemesh::news) {
                if (routes)
                    for (auto const& m : mesh.template incoming<splat::Road<Setup>>(tile, d))
                        if (record_id(m) == followed_) add(Seen::road, d);
                if (blooms)
                    for (auto const& m : mesh.template incoming<splat::Beam<Setup>>(tile, d))
                        if (m.id == followed_) add(Seen::beam, d);
            }
        }
        follower_.superstep({supersteps_ - 1, event.kernel, mesh.grid(), routes, blooms, std::move(full)}, std::move(facts));
    }

    std::size_t supersteps_ = 0; ///< of the frame
    std::vector<TileState> tiles_;
    tilemesh::splat::GaussianId followed_ = tilemesh::splat::GaussianId::none;
    std::vector<std::uint32_t> no_room_; ///< of each tile, what it counted after the superstep before
    Follower follower_;
};

} // namespace render_map
