#pragma once
#include "machine.hpp"
#include <tilemesh/renderer.hpp>

namespace bench {

/// On the host by reference, as `tilemesh::Renderer`: the pictures and counters of S.
template <class S>
class MachineOf final : public Machine {
public:
    MachineOf(tilemesh::scene::Map const& map, tilemesh::splat::Arithmetic arithmetic,
              tilemesh::RendererOptions const& options)
        : renderer_(map, options)
    {
        renderer_.model().arithmetic = arithmetic;
    }
    void wake(tilemesh::splat::Camera const& camera) override
    {
        renderer_.prepare(camera.width, camera.height);
        renderer_.mesh().on_threads([](std::uint32_t, std::uint32_t) {});
    }
    void render(tilemesh::splat::Camera const& camera) override { renderer_.render_into(camera, frame_); }
    tilemesh::report::Image const& image() const override { return frame_.image; }
    tilemesh::report::FrameReport const& report() const override { return frame_.report; }

private:
    tilemesh::BasicRenderer<tilemesh::splat::Referenced<S>> renderer_;
    tilemesh::RenderedFrame frame_;
};

} // namespace bench
