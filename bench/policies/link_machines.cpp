#include "links.hpp"
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/splat/topologies.hpp>

namespace policies {

namespace {

namespace splat = tilemesh::splat;

template <class Rule>
struct Setup : splat::WithLinks<splat::Lossless, Rule> {
    static constexpr char const* name = "lossless, other links";
    using Machine = tilemesh::Traced<tilemesh::Mk2>;
};

template <class Rule>
class MachineOf final : public LinkMachine {
    using Renderer = tilemesh::BasicRenderer<splat::Referenced<Setup<Rule>>, tilemesh::Mesh>;

public:
    MachineOf(tilemesh::scene::Map const& map, tilemesh::RendererOptions const& options) : renderer_(map, options) {}
    void render(splat::Camera const& camera) override { renderer_.render_into(camera, frame_); }
    tilemesh::report::Image const& image() const override { return frame_.image; }
    tilemesh::report::FrameReport const& report() const override { return frame_.report; }
    tilemesh::Trace const& trace() const override { return renderer_.trace(); }
    std::uint64_t sram_bytes() const override { return tilemesh::render::sram_bytes_of(renderer_.setup()); }

private:
    Renderer renderer_;
    tilemesh::RenderedFrame frame_;
};

} // namespace

std::unique_ptr<LinkMachine> make_link_machine(Links links, tilemesh::scene::Map const& map, std::uint32_t threads, tilemesh::Grid grid)
{
    tilemesh::RendererOptions options{.threads = threads, .grid = {grid.width, grid.height}, .keep_pixels = false};
    options.arithmetic = splat::Arithmetic::precise;
    switch (links) {
    case Links::torus: return std::make_unique<MachineOf<splat::Torus>>(map, options);
    case Links::express4: return std::make_unique<MachineOf<splat::ExpressLinks<4>>>(map, options);
    case Links::express8: return std::make_unique<MachineOf<splat::ExpressLinks<8>>>(map, options);
    case Links::mesh: break;
    }
    throw tilemesh::Error("the mesh as other links (it has no setup of its own); name a torus or express links");
}

} // namespace policies
