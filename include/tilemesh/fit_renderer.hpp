#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <tilemesh/renderer.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/splat/fitted.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh {

/// A BasicRenderer whose setup was chosen at run time.
class AnyRenderer {
public:
    virtual ~AnyRenderer() = default;
    virtual RenderedFrame render(splat::Camera const& camera) = 0;
    virtual splat::Model& model() = 0;
    /// Says what demand the map was cut to: from now on a view that the demand was not made for throws Error, and what was not
    /// loaded counts as parked.
    virtual void hold_to(scene::Demand const& demand) = 0;
    virtual Extent2 grid() = 0;                           ///< tiles; of the last frame, which there must be
    virtual Extent2 tile() = 0;                           ///< pixels; of the last frame

    virtual std::uint32_t sh_degree() const = 0;          ///< of a record
    virtual bool routes() const = 0;
    virtual bool blooms() const = 0;
    virtual bool has_depth() const = 0;                   ///< planes beside the picture
    virtual bool has_alpha() const = 0;
    virtual std::uint32_t record_bytes() const = 0;
    virtual std::uint32_t storage_slots() const = 0;
    virtual std::uint32_t channel_slots() const = 0;      ///< of a channel that bloom or routing has; 0: none
    virtual std::vector<Region> ledger() const = 0;
};

namespace detail {
/// What renders setup S: on host threads by reference, on the engine that checks by value, so that it is the other's oracle.
template <class S, template <class, class> class Engine>
struct Renders {
    using type = BasicRenderer<S, Engine>;
};
template <class S>
struct Renders<S, Mesh> {
    using type = BasicRenderer<std::conditional_t<has_dynamic_channel<S>(), S, splat::Referenced<S>>, Mesh>;
};
} // namespace detail

/// AnyRenderer over one setup and engine; a program derives from it where it wants more of the renderer.
template <class S, template <class, class> class Engine = Mesh>
class RendererOf : public AnyRenderer {
public:
    using Renderer = typename detail::Renders<S, Engine>::type;

    RendererOf(scene::Map const& map, RendererOptions const& options, typename Renderer::EngineOptions engine = {})
        : renderer_(map, options, std::move(engine))
    {
        if (options.footprint) renderer_.model().footprint = *options.footprint;
    }

    Renderer& renderer() noexcept { return renderer_; }

    RenderedFrame render(splat::Camera const& camera) override
    {
        if (!demand_.holds_for(splat::make_view(camera, renderer_.model())))
            throw Error("a view that the demand was not made for (" + std::to_string(demand_.culled) +
                        " records that its path does not show are not loaded); make the demand of all views, with the model");
        auto frame = renderer_.render(camera);
        frame.report.gaussians.parked += demand_.culled;
        return frame;
    }
    splat::Model& model() override { return renderer_.model(); }
    void hold_to(scene::Demand const& demand) override
    {
        demand_.culled = demand.culled;
        demand_.scanned = demand.scanned;
    }
    Extent2 grid() override
    {
        auto const grid = renderer_.mesh().grid();
        return {grid.width, grid.height};
    }
    Extent2 tile() override { return {renderer_.tiling().tile_width, renderer_.tiling().tile_height}; }

    std::uint32_t sh_degree() const override { return S::Record::sh_degree; }
    bool routes() const override { return S::routes; }
    bool blooms() const override { return S::blooms; }
    bool has_depth() const override { return S::Pixel::has_depth; }
    bool has_alpha() const override { return S::Pixel::has_alpha; }
    std::uint32_t record_bytes() const override { return sizeof(typename S::Record); }
    std::uint32_t storage_slots() const override { return S::storage_slots; }
    std::uint32_t channel_slots() const override
    {
        if constexpr (S::blooms) return splat::Beam<S>::static_capacity;
        else return S::routes ? splat::Road<S>::static_capacity : 0;
    }
    std::vector<Region> ledger() const override
    {
        auto const regions = Renderer::Layout::ledger();
        return {regions.begin(), regions.end()};
    }

private:
    Renderer renderer_;
    scene::Demand demand_; ///< what it says of the views
};

/// Does setup S do all that a scene demands?
template <class S>
bool meets(scene::Demand const& demand) noexcept
{
    return S::Record::sh_degree >= demand.sh_degree && (S::routes || !demand.moves) && (S::blooms || !demand.spans);
}

/// The renderer of the first of `Setups` that does all that the scene demands, on host threads; name the smallest first. Each
/// costs seconds of compile time. Throws Error where none does. The records that no view shows are not loaded (scene::needed).
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

/// A renderer for a map of any degree and any cameras, with records that hold just its degree.
template <class Base = splat::Lossless>
std::unique_ptr<AnyRenderer> fit_to_map(scene::Map const& map, RendererOptions const& options = {})
{
    using splat::Fitted;
    return fit_renderer<Base, Fitted<Base, 1>, Fitted<Base, 2>, Fitted<Base, 3>>(map, scene::demand_of(map), options);
}

} // namespace tilemesh
