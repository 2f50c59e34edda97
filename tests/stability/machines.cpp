// test: optimised
#include "machines.hpp"
#include "../splat/support.hpp"
#include <algorithm>
#include <utility>

using namespace tilemesh;
using namespace tilemesh::splat;

namespace stability {
namespace {

struct RoomyBase : Lossless {
    using Pixel = WithAlpha<WithDepth<FloatPixel>>;
};
struct DropBase : Lossless {
    using Saturation = Drop;
};
template <class Base>
struct Large : support::Small<400, 25'000, Base> {
    static constexpr std::uint32_t tile_pixels = 1u << 16;
};

template <class S>
class RunnerOf final : public Runner {
public:
    RunnerOf(scene::Map const& map, RendererOptions options)
        : gaussians_(map.gaussians), options_(options), renderer_(map, options)
    {
        renderer_.model().arithmetic = Arithmetic::precise; // compared with the naive loop
    }
    RenderedFrame render(Camera const& camera) override { return renderer_.render(camera); }
    Model& model() override { return renderer_.model(); }
    Tiling tiling() override { return renderer_.tiling(); }
    Grid grid() override { return renderer_.mesh().grid(); }
    void observe(Observer observer) override { renderer_.observe(std::move(observer)); }
    std::vector<std::uint32_t> owned_ids() override { return support::owned_ids<S>(renderer_.mesh()); }
    std::vector<std::pair<std::uint32_t, std::uint32_t>> owners() override
    {
        std::vector<std::pair<std::uint32_t, std::uint32_t>> found;
        for (std::uint32_t i = 0; i < grid().size(); ++i)
            for (auto const& m : renderer_.mesh().template state<Marks<S>>(grid().tile(i)))
                if (!m.is(Mark::copy)) found.emplace_back(static_cast<std::uint32_t>(m.id), i);
        std::sort(found.begin(), found.end());
        return found;
    }
    std::uint32_t wrong_tiles(Camera const& camera) override
    {
        return support::wrong_tiles<S>(renderer_.mesh(), gaussians_, make_view(camera, rules()), tiling());
    }
    std::uint64_t differing_pixels(RenderedFrame const& frame, Camera const& camera) override
    {
        support::Missing const missing(frame.report, tiling(), grid());
        return support::differing_pixels(frame.image, report::render_naive(gaussians_, camera, rules(), missing));
    }

private:
    Model rules()
    {
        auto m = renderer_.model();
        if (options_.footprint) m.footprint = *options_.footprint;
        return m;
    }

    std::vector<Gaussian> gaussians_;
    RendererOptions options_;
    BasicRenderer<S> renderer_;
};

} // namespace

std::unique_ptr<Runner> make_runner(Kind kind, scene::Map const& map, RendererOptions options)
{
    if (kind == Kind::drop) return std::make_unique<RunnerOf<Large<DropBase>>>(map, options);
    if (kind == Kind::mk2) return std::make_unique<RunnerOf<Lossless>>(map, options);
    return std::make_unique<RunnerOf<Large<RoomyBase>>>(map, options);
}

RenderedFrame render(Kind kind, scene::Map const& map, Camera const& camera, RendererOptions options, Model const* model)
{
    auto const runner = make_runner(kind, map, options);
    if (model != nullptr) runner->model() = *model;
    return runner->render(camera);
}

} // namespace stability
