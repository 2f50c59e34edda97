#include "machine_over.hpp"
#include <optional>
#include <tilemesh/renderer.hpp>
#include <utility>

namespace bench {

namespace {

namespace splat = tilemesh::splat;

using Renderer = tilemesh::render::HostRenderer;

class MachineWithTrace final : public MachineOver<TracedMachine, Renderer> {
    using P = Renderer::Policies;

public:
    MachineWithTrace(tilemesh::scene::Map const& map, tilemesh::render::Setup facts, tilemesh::RendererOptions const& options)
        : MachineOver(map, std::move(facts), options, traced())
    {
    }

    void render(splat::Camera const& camera) override
    {
        renderer_.prepare(camera.width, camera.height);
        if (slots_) set_limits();
        MachineOver::render(camera);
    }
    void limit_channels(std::uint32_t slots) override { slots_ = slots; }
    void limit_hops(std::uint32_t hops) override { renderer_.mesh().program() = splat::frame_program<P>(hops); }
    tilemesh::render::Prefetched prefetch(splat::Camera const& camera) override { return renderer_.prefetch(camera); }
    std::vector<Stored> stored() override
    {
        std::vector<Stored> out;
        auto const& mesh = std::as_const(renderer_.mesh());
        for (std::uint32_t t = 0; t < mesh.grid().size(); ++t)
            for (auto const& m : mesh.state<splat::Marks<P>>(mesh.grid().tile(t)))
                out.push_back({m.id, t, !m.is(splat::Mark::copy) && !m.is(splat::Mark::leaving)});
        return out;
    }
    splat::Rules const& rules() const override { return renderer_.rules(); }
    tilemesh::Trace const& trace() const override { return renderer_.trace(); }
    tilemesh::Grid grid() override { return renderer_.mesh().grid(); }

private:
    static Renderer::EngineOptions traced()
    {
        Renderer::EngineOptions engine;
        engine.trace = true;
        return engine;
    }
    void set_limits()
    {
        auto const& sizes = renderer_.setup().sizes;
        auto& mesh = renderer_.mesh();
        auto const at_most = [&](std::uint32_t most) { return *slots_ == 0 ? most : *slots_; };
        mesh.limit<splat::Road<P>>(at_most(sizes.road));
        mesh.limit<splat::Beam<P>>(at_most(sizes.beam));
        if (renderer_.setup().holds) {
            mesh.limit<splat::Waiting<P, 0>>(at_most(sizes.waiting));
            mesh.limit<splat::Waiting<P, 1>>(at_most(sizes.waiting));
        }
        slots_.reset();
    }

    std::optional<std::uint32_t> slots_; ///< a limit that the mesh does not have yet
};

} // namespace

std::unique_ptr<TracedMachine> make_traced_machine(tilemesh::scene::Map const& map, tilemesh::render::Setup const& setup,
                                                   tilemesh::RendererOptions const& options)
{
    return std::make_unique<MachineWithTrace>(map, setup, options);
}

} // namespace bench
