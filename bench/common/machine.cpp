#include "machine.hpp"
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <utility>

namespace bench {

namespace {

namespace splat = tilemesh::splat;

class OverRenderer final : public Machine {
    using Renderer = tilemesh::render::HostRenderer;
    using P = Renderer::Policies;

public:
    OverRenderer(tilemesh::scene::Map const& map, tilemesh::render::Setup const& setup, tilemesh::RendererOptions const& options,
                 Renderer::EngineOptions const& engine)
        : renderer_(map, setup, options, engine)
    {}
    void wake(splat::Camera const& camera) override
    {
        renderer_.prepare(camera.width, camera.height);
        renderer_.mesh().on_threads([](std::uint32_t, std::uint32_t) {});
    }
    void render(splat::Camera const& camera) override { renderer_.render_into(camera, frame_); }
    tilemesh::report::Image const& image() const override { return frame_.image; }
    tilemesh::report::FrameReport const& report() const override { return frame_.report; }
    void limit_hops(std::uint32_t hops) override { renderer_.mesh().program() = splat::frame_program<P>(hops); }
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

private:
    Renderer renderer_;
    tilemesh::RenderedFrame frame_;
};

std::unique_ptr<Machine> make(tilemesh::scene::Map const& map, tilemesh::render::Setup const& setup, tilemesh::RendererOptions const& options,
                              bool traced)
{
    tilemesh::render::HostRenderer::EngineOptions engine;
    engine.trace = traced;
    return std::make_unique<OverRenderer>(map, setup, options, engine);
}

} // namespace

std::unique_ptr<Machine> make_machine(tilemesh::scene::Map const& map, tilemesh::render::Setup const& setup, tilemesh::RendererOptions const& options)
{
    return make(map, setup, options, false);
}
std::unique_ptr<Machine> make_traced_machine(tilemesh::scene::Map const& map, tilemesh::render::Setup const& setup,
                                             tilemesh::RendererOptions const& options)
{
    return make(map, setup, options, true);
}

tilemesh::CostModel const& mk2_model()
{
    static tilemesh::CostModel const model = tilemesh::mk2();
    return model;
}
double modelled_ms(tilemesh::Trace const& trace, tilemesh::Grid grid)
{
    return tilemesh::milliseconds(mk2_model(), tilemesh::model_cost(mk2_model(), trace, grid).cycles);
}

} // namespace bench
