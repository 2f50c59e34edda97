#pragma once
#include "machine.hpp"
#include "with_knobs.hpp"
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/renderer.hpp>

namespace error_vs_time {

/// Lossless' policies on a machine with room for every setting, so that a setting's error is its own: storage and channels are
/// limited while it runs. What a setting needs of Mk2 is counted (peak_storage).
template <class Policy>
struct Roomy : splat::Lossless {
    static constexpr char const* name = "lossless, with room";
    using Machine = tilemesh::Traced<tilemesh::TestMachine<64u << 20>>;
    using Saturation = Policy;
    static constexpr std::uint32_t storage_slots = 100'000; ///< a tile has never held half of it
    static constexpr std::uint32_t most_slots = 8'192;      ///< the cold start of 250,000 records puts fewer into one channel
    static constexpr std::uint32_t road_bytes = most_slots * sizeof(splat::Addressed);
    static constexpr std::uint32_t beam_bytes = most_slots * sizeof(splat::Gaussian);
    static constexpr std::uint32_t waiting_bytes = Policy::holds ? road_bytes : 0;
};

template <class Policy>
class MachineOf final : public Machine {
    using S = WithKnobs<Roomy<Policy>>;

public:
    MachineOf(scene::Map const& map, Setting const& setting, std::uint32_t threads)
        : setting_(setting), renderer_(map, {.threads = threads,
                                             .tile = {tile_width, tile_height},
                                             .hops = setting.limits.hops == 0 ? 0 : unbounded,
                                             .storage_slots = setting.limits.storage_slots})
    {
        renderer_.model() = setting.model;
    }
    void settle(splat::Camera const& first, splat::Camera const& second) override
    {
        renderer_.prepare(first.width, first.height);
        renderer_.mesh().template broadcast<ParametersWithKnobs>().knobs = setting_.knobs;
        for (auto const* camera : {&first, &second, &first}) render(*camera);
        auto const n = setting_.limits.channel_slots;
        auto& mesh = renderer_.mesh();
        mesh.template limit<splat::Road<S>>(n);
        mesh.template limit<splat::Beam<S>>(n);
        if constexpr (Policy::holds) {
            mesh.template limit<splat::Waiting<S, 0>>(n);
            mesh.template limit<splat::Waiting<S, 1>>(n);
        }
        if (setting_.limits.hops != 0) mesh.program() = splat::frame_program<S>(setting_.limits.hops);
    }
    void render(splat::Camera const& camera) override { renderer_.render_into(camera, frame_); }
    report::Image const& image() const override { return frame_.image; }
    report::FrameReport const& counters() const override { return frame_.report; }
    double modelled_ms() override
    {
        static tilemesh::CostModel const model = tilemesh::mk2();
        return tilemesh::milliseconds(
            model, tilemesh::model_cost(model, renderer_.trace(), renderer_.mesh().grid()).cycles);
    }
    double host_ms() const override // without the list of what is missing, which is the report's work
    {
        auto const& ms = frame_.report.host_ms;
        return ms.project + ms.route + ms.bloom + ms.composite + ms.picture;
    }

private:
    /// More hops than any frame takes, as a bound that can be changed: a renderer without one does not look for late records.
    static constexpr std::uint32_t unbounded = 1u << 30;

    Setting setting_;
    tilemesh::BasicRenderer<S> renderer_;
    tilemesh::RenderedFrame frame_;
};

} // namespace error_vs_time
