#pragma once
#include "../runner.hpp"

namespace support {

/// `Core` is a render::FrameRenderer: setups of the same policies share one.
template <class Core>
class RunnerOf final : public Runner {
    using P = typename Core::Policies;

public:
    RunnerOf(scene::Map const& map, render::Setup facts, RendererOptions const& options)
        : renderer_(map, std::move(facts), options, {})
    {
    }
    void render_into(splat::Camera const& camera, RenderedFrame& frame) override { renderer_.render_into(camera, frame); }
    splat::Rules& rules() override { return renderer_.rules(); }
    splat::Tiling const& tiling() override { return renderer_.tiling(); }
    Grid grid() override { return renderer_.mesh().grid(); }
    render::Setup const& facts() override { return renderer_.setup(); }
    void observe(Observer observer) override { renderer_.observe(std::move(observer)); }

    std::vector<splat::Mark> marks(TileId tile) override
    {
        std::vector<splat::Mark> out;
        for (auto const& m : std::as_const(renderer_.mesh()).template state<splat::Marks<P>>(tile)) out.push_back({m.id, m.bits});
        return out;
    }
    std::vector<std::uint32_t> owned_ids() override { return support::owned_ids<P>(renderer_.mesh()); }
    std::vector<std::uint64_t> on_tiles() override
    {
        std::vector<std::uint64_t> out;
        auto const& mesh = std::as_const(renderer_.mesh());
        for (std::uint32_t t = 0; t < grid().size(); ++t) {
            auto const tile = grid().tile(t);
            auto const& c = mesh.template state<splat::Counts>(tile);
            out.insert(out.end(), {c.projected, c.visible, c.parked, c.copies, c.changes});
            for (auto const& m : marks(tile)) out.push_back(std::uint64_t{static_cast<std::uint32_t>(m.id)} << 32 | m.bits);
            for (auto const& k : mesh.template state<splat::Order<P>>(tile)) out.push_back(std::uint64_t{k.depth_key} << 32 | k.slot);
        }
        return out;
    }

private:
    Core renderer_;
};

template <class S, template <class, class> class Engine>
std::unique_ptr<Runner> make_runner(scene::Map const& map, RendererOptions const& options)
{
    using R = BasicRenderer<S, Engine>;
    return std::make_unique<RunnerOf<typename R::Core>>(map, render::setup_for<typename R::Value>(options), options);
}

} // namespace support

/// The renderer of a setup on an engine.
#define SUPPORT_SHARED(...) \
    template std::unique_ptr<support::Runner> support::make_runner<__VA_ARGS__>(tilemesh::scene::Map const&, tilemesh::RendererOptions const&)
