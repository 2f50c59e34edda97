#pragma once
#include "machine.hpp"
#include "setups.hpp"
#include <tilemesh/renderer.hpp>
#include <utility>

namespace channel_capacity {

template <class S>
class MachineOf final : public Machine {
public:
    MachineOf(scene::Map const& map, Options options)
        : renderer_(map, {.grid = {grid_columns, grid_rows}, .hops = options.hops, .storage_slots = options.storage_slots})
    {}
    Frame render(splat::Camera const& camera) override
    {
        renderer_.prepare(camera.width, camera.height);
        if (pending_) limit_channels(slots_);
        auto frame = renderer_.render(camera);
        return {std::move(frame.image), std::move(frame.report)};
    }
    void limit_channels(std::uint32_t slots) override
    {
        slots_ = slots;
        pending_ = !prepared();
        if (pending_) return;
        auto const n = slots == 0 ? Sweep<S>::most_slots : slots;
        auto& mesh = renderer_.mesh();
        mesh.template limit<splat::Road<Sweep<S>>>(n);
        mesh.template limit<splat::Beam<Sweep<S>>>(n);
        if constexpr (S::Saturation::holds) {
            mesh.template limit<splat::Waiting<Sweep<S>, 0>>(n);
            mesh.template limit<splat::Waiting<Sweep<S>, 1>>(n);
        }
    }
    void limit_hops(std::uint32_t hops) override { renderer_.mesh().program() = splat::frame_program<Sweep<S>>(hops); }
    std::vector<Stored> stored() override
    {
        std::vector<Stored> out;
        auto& mesh = renderer_.mesh();
        for (std::uint32_t t = 0; t < tiles; ++t) {
            auto const tile = mesh.grid().tile(t);
            auto const marks = mesh.template state<splat::Marks<Sweep<S>>>(tile);
            for (auto const& m : marks) out.push_back({m.id, t, !m.is(splat::Mark::copy) && !m.is(splat::Mark::leaving)});
        }
        return out;
    }
    splat::Model model() const override { return renderer_.model(); }
    tilemesh::Trace const& trace() const override { return renderer_.trace(); }

private:
    bool prepared() const noexcept { return renderer_.tiling().columns != 0; }

    tilemesh::BasicRenderer<Sweep<S>> renderer_;
    std::uint32_t slots_ = 0;
    bool pending_ = true;
};

} // namespace channel_capacity
