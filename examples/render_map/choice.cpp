#include "choice.hpp"
#include "instruments.hpp"
#include "ranks.hpp"
#include "renderers.hpp"
#include <algorithm>
#include <tilemesh/auto_renderer.hpp>
#include <tilemesh/render/homes_renderer.hpp>
#include <tilemesh/splat/setup_types.hpp>
#include <utility>
#include <vector>

namespace render_map {

namespace {

namespace splat = tilemesh::splat;
namespace render = tilemesh::render;

/// May the demand choose the parts of the machine? Only for an unchanged `lossless` on host threads.
bool may_be_fitted(Choice const& choice)
{
    auto const own = splat::lossless, asked = setup_of(choice, 0);
    return asked.name == std::string_view(own.name) && choice.engine == EngineKind::threads && !choice.planes() && !choice.trace &&
           asked.holds == own.holds && !asked.ranks && asked.reusable == own.reusable && asked.colour == own.colour;
}

/// The setup on the choice's machine, with the planes that it asks for.
render::Setup on_machine(render::Setup setup, Choice const& choice)
{
    if (choice.machine == MachineKind::test) {
        setup.machine = tilemesh::size_of_machine<splat::RoomyMachine>();
        setup.sizes = splat::roomy(setup.sizes);
    }
    if (choice.planes()) setup = render::with_planes(setup, choice.depth, choice.alpha);
    if (choice.machine == MachineKind::file && choice.file.name != nullptr)
        setup = render::on_machine(setup, choice.file, choice.tile_pixels, choice.channel_slots);
    return setup;
}

} // namespace

render::Setup setup_of(Choice const& choice, std::uint32_t sh_degree)
{
    return on_machine(render::fitted(with(splat::lossless, choice.fields), sh_degree, true, true), choice);
}

render::Setup setup_for(Choice const& choice, tilemesh::scene::Demand const& demand)
{
    if (!may_be_fitted(choice) || demand.moves) return setup_of(choice, demand.sh_degree);
    // Records with harmonics always bloom.
    bool const blooms = demand.spans || demand.sh_degree != 0;
    return on_machine(render::fitted(splat::lossless, demand.sh_degree, false, blooms), choice);
}

tilemesh::render::Setup homes_of(Choice const& choice, std::uint32_t sh_degree)
{
    auto const setup = setup_of(choice, sh_degree);
    auto homes = splat::as_homes(setup);
    homes.machine = splat::homes_setup.machine;
    if (choice.machine == MachineKind::file && choice.file.name != nullptr && !choice.keeps_homes)
        homes = render::on_machine(homes, choice.file, 0, choice.channel_slots);
    else homes.machine = setup.machine;
    if (choice.machine == MachineKind::test) homes.sizes.storage = setup.sizes.storage;
    return homes;
}

namespace {

std::unique_ptr<AnyRenderer> make_homes(Choice const& choice, tilemesh::scene::Map const& map, tilemesh::scene::Demand const& demand,
                                        tilemesh::RendererOptions const& options)
{
    auto const homes = homes_of(choice, std::min(demand.sh_degree, map.sh_degree));
    auto needed = tilemesh::scene::needed(map, demand);
    // Sequentially, a trace beside the checks costs little.
    if (choice.engine == EngineKind::sequential || choice.trace) return make_homes_traced(std::move(needed), homes, options, choice.engine);
    return render::make_homes_renderer(std::move(needed), homes, options);
}

/// The instruments of whichever program renders.
class AutoInstruments final : public tilemesh::AutoRenderer, public Instruments {
public:
    using AutoRenderer::AutoRenderer;
    tilemesh::Trace take_trace() override { return now().take_trace(); }
    std::vector<TileState> tiles() override { return now().tiles(); }
    std::vector<TileRound> rounds() override { return now().rounds(); }
    void follow(tilemesh::splat::GaussianId id) override { now().follow(id); }
    Life life() override { return now().life(); }

private:
    Instruments& now() { return dynamic_cast<Instruments&>(current()); }
};

} // namespace

std::unique_ptr<AnyRenderer> make_renderer(Choice const& choice, tilemesh::scene::Map const& map,
                                           tilemesh::scene::Demand const& demand, tilemesh::RendererOptions options)
{
    bool const over_ranks = ranks::number() > 1;
    auto for_homes = options;
    if (options.program != tilemesh::report::Program::homes) for_homes = render::within(homes_of(choice, demand.sh_degree), options);
    auto const with_homes = [&choice, &map, &demand, options = for_homes, over_ranks](tilemesh::scene::Map const&) {
        return over_ranks ? ranks::make_homes(choice, demand, options) : make_homes(choice, map, demand, options);
    };
    std::unique_ptr<AnyRenderer> renderer;
    if (options.program == tilemesh::report::Program::homes) {
        renderer = with_homes(map);
    } else if (over_ranks) {
        renderer = ranks::make(choice, demand, options);
        auto const may_fit = render::may_fit_anchored(demand.gaussians - demand.culled, renderer->setup(), options);
        if (!choice.stays_anchored) renderer = std::make_unique<tilemesh::AutoRenderer>(std::move(renderer), with_homes, may_fit);
    } else {
        auto const setup = setup_for(choice, demand);
        auto needed = tilemesh::scene::needed(map, demand);
        auto const records = needed.gaussians.size();
        auto const make = choice.trace ? make_anchored_traced : make_anchored;
        renderer = make(std::move(needed), render::checked(setup), options, choice.engine);
        auto const may_fit = render::may_fit_anchored(records, renderer->setup(), options);
        if (!choice.stays_anchored && choice.trace) renderer = std::make_unique<AutoInstruments>(std::move(renderer), with_homes, may_fit);
        else if (!choice.stays_anchored) renderer = std::make_unique<tilemesh::AutoRenderer>(std::move(renderer), with_homes, may_fit);
    }
    renderer->hold_to(demand);
    return renderer;
}

} // namespace render_map
