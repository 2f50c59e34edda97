#pragma once
#include "machine.hpp"
#include <tilemesh/render/frame_renderer.hpp>

namespace bench {

/// Implements `Base`, a kind of Machine, with a renderer.
template <class Base, class Renderer>
class MachineOver : public Base {
public:
    MachineOver(tilemesh::scene::Map const& map, tilemesh::render::Setup const& setup,
                tilemesh::RendererOptions const& options, typename Renderer::EngineOptions engine = {})
        : renderer_(map, setup, options, engine)
    {
    }
    void wake(tilemesh::splat::Camera const& camera) override
    {
        renderer_.prepare(camera.width, camera.height);
        renderer_.mesh().on_threads([](std::uint32_t, std::uint32_t) {});
    }
    void render(tilemesh::splat::Camera const& camera) override { renderer_.render_into(camera, frame_); }
    tilemesh::report::Image const& image() const override { return frame_.image; }
    tilemesh::report::FrameReport const& report() const override { return frame_.report; }

protected:
    Renderer renderer_;
    tilemesh::RenderedFrame frame_;
};

} // namespace bench
