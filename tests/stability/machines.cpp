// test: optimised
#include "machines.hpp"
#include "../splat/runner.hpp"

using namespace tilemesh;
using namespace tilemesh::splat;

namespace stability {
namespace {

/// Uses the renderers of the tests of splat/.
class RunnerOf final : public Runner {
public:
    RunnerOf(std::unique_ptr<support::Runner> runner, scene::Map const& map) : gaussians_(map.gaussians), runner_(std::move(runner))
    {
        runner_->rules().arithmetic = Arithmetic::precise; // because it is compared with the naive loop
    }
    RenderedFrame render(Camera const& camera) override { return runner_->render(camera); }
    Rules& rules() override { return runner_->rules(); }
    Tiling tiling() override { return runner_->tiling(); }
    Grid grid() override { return runner_->grid(); }
    void observe(Observer observer) override { runner_->observe(std::move(observer)); }
    std::vector<std::uint32_t> owned_ids() override { return runner_->owned_ids(); }
    std::vector<std::pair<std::uint32_t, std::uint32_t>> owners() override
    {
        std::vector<std::pair<std::uint32_t, std::uint32_t>> found;
        for (std::uint32_t i = 0; i < grid().size(); ++i)
            for (auto const& m : runner_->marks(grid().tile(i)))
                if (!m.is(Mark::copy)) found.emplace_back(static_cast<std::uint32_t>(m.id), i);
        std::sort(found.begin(), found.end());
        return found;
    }
    std::uint32_t wrong_tiles(Camera const& camera) override { return runner_->wrong_tiles(gaussians_, make_view(camera, rules())); }
    std::uint64_t differing_pixels(RenderedFrame const& frame, Camera const& camera) override
    {
        return support::differing_pixels(frame.image,
                                         report::render_naive(gaussians_, camera, rules(), runner_->missing(frame.report)));
    }

private:
    std::vector<Gaussian> gaussians_;
    std::unique_ptr<support::Runner> runner_;
};

} // namespace

std::unique_ptr<Runner> make_runner(Kind kind, scene::Map const& map, RendererOptions options)
{
    if (kind == Kind::mk2) return std::make_unique<RunnerOf>(support::make_runner<Lossless>(map, options), map);
    auto sizes = support::sized<support::Whole>(400, 25'000);
    sizes.tile_pixels = 1u << 16;
    options.sizes = sizes;
    return std::make_unique<RunnerOf>(kind == Kind::drop ? support::make_runner<support::Room<support::DropBase>>(map, options)
                                                         : support::make_runner<support::Planes>(map, options),
                                      map);
}

RenderedFrame render(Kind kind, scene::Map const& map, Camera const& camera, RendererOptions options, Rules const* rules)
{
    auto const runner = make_runner(kind, map, options);
    if (rules != nullptr) runner->rules() = *rules;
    return runner->render(camera);
}

} // namespace stability
