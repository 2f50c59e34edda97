#include "followed_facts.hpp"
#include "instruments.hpp"
#include <algorithm>
#include <cstdint>
#include <memory>
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/render/homes_renderer.hpp>
#include <utility>
#include <vector>

namespace render_map {

namespace splat = tilemesh::splat;
namespace homes = tilemesh::splat::homes;
using tilemesh::SuperstepEvent;
using Anchored = tilemesh::render::HostRenderer;
using Homes = tilemesh::render::HostHomesRenderer;

struct Instruments::Watch {
    std::vector<TileState> tiles;
    std::vector<TileRound> rounds;
    splat::GaussianId followed = splat::GaussianId::none;
    Follower follower;

    void begin_frame()
    {
        supersteps = 0;
        tiles.clear();
        rounds.clear();
        follower.begin_frame();
        begins = true;
    }
    /// Called after each superstep. A frame may run the anchored program a second time; these supersteps follow those of the first run.
    void look(tilemesh::render::Core& core, SuperstepEvent const& event)
    {
        if (auto* const of_homes = dynamic_cast<Homes*>(&core)) return look_at_homes(std::as_const(of_homes->mesh()), event);
        auto& renderer = dynamic_cast<Anchored&>(core);
        ++supersteps;
        if (event.step == Anchored::Steps::composite) look_at_tiles(std::as_const(renderer.mesh()));
        if (followed != splat::GaussianId::none) facts.read(renderer, event, supersteps - 1, followed, follower);
    }

private:
    /// What a tile held in this round, and what it had refused before.
    struct Before {
        std::uint32_t rounds, refused, held, farthest;
    };

    /// Records are those of the last run; refusals are those of all runs.
    void look_at_tiles(Anchored::MeshType const& mesh)
    {
        tiles.resize(mesh.grid().size());
        for (std::uint32_t t = 0; t < mesh.grid().size(); ++t) {
            auto const tile = mesh.grid().tile(t);
            auto const& counts = mesh.state<splat::Counts>(tile);
            auto& to = tiles[t];
            to.records = to.copies = 0;
            to.pairs = 0;
            for (auto const& mark : mesh.state<splat::Marks<Anchored::Policies>>(tile)) {
                ++to.records;
                to.copies += mark.is(splat::Mark::copy) ? 1u : 0u;
            }
            auto const& work = mesh.state<splat::Work>(tile);
            for (auto const evaluated : work.evaluated) to.pairs += std::uint64_t{evaluated} * splat::pairs_a_count;
            to.refusals += counts.by_channels();
            to.drops += counts.by_storage() + counts.copies_refused;
        }
    }
    void look_at_homes(Homes::MeshType const& mesh, SuperstepEvent const& event)
    {
        using Policies = splat::homes::AnyHostPolicies;
        if (event.kernel == homes::Begin<Policies>::name) {
            if (begins) {
                tiles.assign(mesh.grid().size(), {});
                chapter = round = 0;
                begins = false;
            }
            before.assign(mesh.grid().size(), {});
            ++chapter;
        } else if (event.kernel == homes::Merge<Policies>::name) {
            ++round;
            for (std::uint32_t t = 0; t < before.size(); ++t) {
                auto const tile = mesh.grid().tile(t);
                auto const order = mesh.state<homes::Order>(tile);
                before[t].held = order.size();
                if (!order.empty()) before[t].farthest = mesh.state<homes::Keys>(tile)[order[order.size() - 1]].depth_key;
            }
        } else if (event.kernel == homes::Advance<Policies>::name) {
            for (std::uint32_t t = 0; t < before.size(); ++t) look_at_round(mesh, t);
        } else if (event.kernel == homes::Finish<Policies>::name) {
            for (std::uint32_t t = 0; t < before.size(); ++t) {
                auto const tile = mesh.grid().tile(t);
                auto const& counts = mesh.state<homes::Counts>(tile);
                auto& to = tiles[t];
                to.records = mesh.state<homes::Home<Policies>>(tile).size();
                for (auto const evaluated : mesh.state<homes::Work>(tile).evaluated) to.pairs += std::uint64_t{evaluated} * homes::pairs_a_count;
                to.refusals += counts.by_channels();
                to.rounds += counts.rounds;
                to.entries += counts.arrived;
            }
        }
    }
    void look_at_round(Homes::MeshType const& mesh, std::uint32_t t)
    {
        auto const tile = mesh.grid().tile(t);
        auto const& counts = mesh.state<homes::Counts>(tile);
        auto const& window = mesh.state<homes::Window>(tile);
        auto& was = before[t];
        if (counts.rounds == was.rounds) return; // it was done
        auto frontier = window.done() ? window.frontier_depth : window.lo_depth;
        if (frontier == homes::infinite_depth) frontier = was.farthest;
        // A chapter's last window has no end, so that its farthest splat may be nearer than the frontier of a round before.
        tiles[t].frontier = std::max(tiles[t].frontier, tilemesh::splat::depth_of_key(frontier));
        rounds.push_back({round, chapter, t, was.held, counts.refused - was.refused, tiles[t].frontier, window.done()});
        was.rounds = counts.rounds;
        was.refused = counts.refused;
    }

    std::vector<Before> before;
    std::uint64_t supersteps = 0; ///< of the frame
    std::uint32_t round = 0, chapter = 0;
    bool begins = true; ///< no superstep of homes has run in the frame
    FollowedFacts<Anchored> facts;
};

Instruments::Instruments(tilemesh::Renderer& renderer) : renderer_(renderer), watch_(std::make_unique<Watch>())
{
    renderer_.observe([this](SuperstepEvent const& event) { watch_->look(renderer_.core(), event); });
}
Instruments::~Instruments()
{
    renderer_.observe({});
}
tilemesh::RenderedFrame Instruments::render(splat::Camera const& camera)
{
    watch_->begin_frame();
    return renderer_.render(camera);
}
std::vector<TileState> const& Instruments::tiles() const noexcept
{
    return watch_->tiles;
}
std::vector<TileRound> const& Instruments::rounds() const noexcept
{
    return watch_->rounds;
}
void Instruments::follow(splat::GaussianId id)
{
    watch_->followed = id;
}
Life Instruments::life() const
{
    return renderer_.setup().program == splat::Program::homes ? Life{} : watch_->follower.life();
}

} // namespace render_map
