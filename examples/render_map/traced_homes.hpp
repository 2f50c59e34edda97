#pragma once
#include "instruments.hpp"
#include "renderers.hpp"
#include <memory>
#include <tilemesh/render/homes_renderer.hpp>
#include <utility>
#include <vector>

namespace render_map {

/// The program of homes on a machine that keeps a trace, with instruments. It follows no Gaussian: records of homes never move.
template <template <class, class> class Engine>
class TracedHomes final
    : public tilemesh::render::HomesRenderer<tilemesh::splat::homes::HostPolicies<tilemesh::render::HomesPlanes>, Engine,
                                             tilemesh::Traced<tilemesh::AnyMachine>>,
      public Instruments {
    using Policies = tilemesh::splat::homes::HostPolicies<tilemesh::render::HomesPlanes>;
    using Base = tilemesh::render::HomesRenderer<Policies, Engine, tilemesh::Traced<tilemesh::AnyMachine>>;

public:
    using Base::Base;

    tilemesh::Trace take_trace() override { return this->trace(); }
    void follow(tilemesh::splat::GaussianId) override {}
    Life life() override { return {}; }
    /// Of a map in chapters, the state is that of the last chapter.
    std::vector<TileState> tiles() override
    {
        namespace homes = tilemesh::splat::homes;
        auto const& mesh = std::as_const(this->mesh());
        std::vector<TileState> out;
        for (auto const tile : mesh.grid().tiles()) {
            auto const& counts = mesh.template state<homes::Counts>(tile);
            auto& to = out.emplace_back();
            to.records = mesh.template state<homes::Home<Policies>>(tile).size();
            for (auto const strips : mesh.template state<homes::Work>(tile).strips) to.pairs += std::uint64_t{strips} * homes::strip_pairs;
            to.channel_full = counts.channel_full;
            to.no_credit = counts.no_credit;
            to.rounds = counts.rounds;
            to.entries = counts.arrived;
        }
        return out;
    }
};

template <template <class, class> class Engine>
std::unique_ptr<AnyRenderer> make_traced_homes(tilemesh::scene::Map const& map, tilemesh::render::HomesChoice const& choice,
                                               tilemesh::RendererOptions const& options)
{
    return std::make_unique<TracedHomes<Engine>>(map, choice, options);
}

} // namespace render_map
