#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <tilemesh/any_renderer.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/splat/fitted.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// AnyRenderer over a renderer of one set of policies (render::FrameRenderer). A program that needs more of the renderer than AnyRenderer
/// offers derives from this class.
template <class R>
class RendererOver : public AnyRenderer {
public:
    using Renderer = R;

    RendererOver(scene::Map map, render::Setup const& setup, RendererOptions const& options, typename R::EngineOptions engine = {})
        : renderer_(std::move(map), setup, options, std::move(engine))
    {
    }

    R& renderer() noexcept { return renderer_; }

    RenderedFrame render(splat::Camera const& camera) override
    {
        views_.require(splat::make_view(camera, renderer_.rules()));
        auto frame = renderer_.render(camera);
        frame.report.gaussians.parked += views_.culled();
        return frame;
    }
    splat::Rules& rules() override { return renderer_.rules(); }
    void hold_to(scene::Demand const& demand) override { views_ = scene::LoadedViews(demand); }
    Extent2 grid() override
    {
        auto const grid = renderer_.mesh().grid();
        return {grid.width, grid.height};
    }
    Extent2 tile() override { return {renderer_.tiling().tile_width, renderer_.tiling().tile_height}; }
    scene::Map const& map() const override { return renderer_.map(); }
    render::Setup const& setup() const override { return renderer_.setup(); }

private:
    R renderer_;
    scene::LoadedViews views_;
};

namespace detail {
/// The renderer of setup S: by reference on host threads, by value on other engines. So each form checks the other one.
template <class S, template <class, class> class Engine>
struct Renders {
    using type = BasicRenderer<S, Engine>;
};
template <class S>
struct Renders<S, Mesh> {
    using type = BasicRenderer<splat::Referenced<S>, Mesh>;
};
template <class S>
struct Renders<S, PortMesh> {
    using type = BasicRenderer<splat::Referenced<S>, PortMesh>;
};
} // namespace detail

/// RendererOver for a setup. The default engine is that of BasicRenderer.
#if defined(TILEMESH_COMPILED)
template <class S, template <class, class> class Engine = PortMesh>
#else
template <class S, template <class, class> class Engine = Mesh>
#endif
class RendererOf : public RendererOver<typename detail::Renders<S, Engine>::type::Core> {
    using Base = RendererOver<typename detail::Renders<S, Engine>::type::Core>;

public:
    RendererOf(scene::Map map, RendererOptions const& options, typename Base::Renderer::EngineOptions engine = {})
        : Base(std::move(map), render::setup_for<S>(options), options, std::move(engine))
    {
    }
};

/// Does setup S have everything that a scene needs?
template <class S>
bool meets(scene::Demand const& demand) noexcept
{
    return S::Record::sh_degree >= demand.sh_degree && (S::routes || !demand.moves) && (S::blooms || !demand.spans);
}

/// Returns the renderer, on host threads, of the first of `Setups` that has everything the scene needs. Name the smallest setup first.
/// Throws Error if none has it. Records that no view shows are not loaded (scene::needed). Compile time: setups that differ in machine,
/// sizes, degree or saturation share one renderer; a setup without routing or bloom costs several seconds more.
template <class... Setups>
std::unique_ptr<AnyRenderer> fit_renderer(scene::Map const& map, scene::Demand const& demand, RendererOptions const& options = {})
{
    static_assert(sizeof...(Setups) != 0, "no setup is named (fit_renderer<A, B>(map, demand) chooses among A and B); name them, "
                                          "the smallest first, or call fit_to_map");
    std::unique_ptr<AnyRenderer> renderer;
    auto const try_one = [&]<class S>(std::type_identity<S>) {
        if (renderer || !meets<S>(demand)) return;
        renderer = std::make_unique<RendererOf<S>>(scene::needed(map, demand), options);
        renderer->hold_to(demand);
    };
    (try_one(std::type_identity<Setups>{}), ...);
    if (!renderer)
        throw Error("a scene that none of the setups named can render (it needs degree " + std::to_string(demand.sh_degree) +
                    (demand.moves ? ", routing" : "") + (demand.spans ? ", bloom" : "") +
                    "); name a Fitted setup that has these too");
    return renderer;
}

/// Returns a renderer for a map of any degree and for any cameras. Its records hold exactly the map's degree.
template <class Base = splat::Lossless>
std::unique_ptr<AnyRenderer> fit_to_map(scene::Map const& map, RendererOptions const& options = {})
{
    using splat::Fitted;
    return fit_renderer<Base, Fitted<Base, 1>, Fitted<Base, 2>, Fitted<Base, 3>>(map, scene::demand_of(map), options);
}

}} // namespace tilemesh
