#pragma once
#include "instruments.hpp"
#include <cstdint>
#include <optional>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/splat/frame_program.hpp>
#include <utility>
#include <vector>

namespace render_map {

/// Reads from the tiles of a renderer R, after a superstep, what they have to do with a Gaussian, and gives it to a Follower. It reads every
/// tile.
template <class R>
class FollowedFacts {
    using Setup = typename R::Policies;
    using Steps = typename R::Steps;

public:
    /// `superstep`: of the frame, from 0.
    void read(R& renderer, tilemesh::SuperstepEvent const& event, std::uint64_t superstep, tilemesh::splat::GaussianId followed,
              Follower& follower)
    {
        namespace splat = tilemesh::splat;
        using tilemesh::Direction;
        auto& mesh = renderer.mesh();
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
            auto const slot = splat::find(marks, followed);
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
                    if (record_id(m) == followed) add(Seen::waiting, Setup::Routing::first_leg[0], routes);
                for (auto const& m : std::as_const(mesh).template state<splat::Waiting<Setup, 1>>(tile))
                    if (record_id(m) == followed) add(Seen::waiting, Setup::Routing::first_leg[1], routes);
            }
            // Road and beam may share their memory, so only messages of this superstep are read.
            for (Direction d : tilemesh::news) {
                if (routes)
                    for (auto const& m : mesh.template incoming<splat::Road<Setup>>(tile, d))
                        if (record_id(m) == followed) add(Seen::road, d);
                if (blooms)
                    for (auto const& m : mesh.template incoming<splat::Beam<Setup>>(tile, d))
                        if (m.id == followed) add(Seen::beam, d);
            }
        }
        follower.superstep({superstep, event.kernel, mesh.grid(), routes, blooms, std::move(full)}, std::move(facts));
    }

private:
    std::vector<std::uint32_t> no_room_; ///< of each tile, what it counted after the superstep before
};

} // namespace render_map
