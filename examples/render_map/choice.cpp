#include "choice.hpp"
#include "renderers.hpp"
#include <tilemesh/splat/setup.hpp>

namespace render_map {

namespace {

namespace splat = tilemesh::splat;
namespace render = tilemesh::render;

render::SetupChoice preset_of(Choice const& choice)
{
    switch (choice.preset) {
    case Preset::lossless:
        return render::choice_of<splat::Lossless>();
    case Preset::paper:
        return render::choice_of<splat::Paper>();
    case Preset::prototype:
        break;
    }
    return render::choice_of<splat::Prototype>();
}

/// May the demand choose the parts of the machine? Only for an unchanged `lossless` on host threads.
bool may_be_fitted(Choice const& choice)
{
    auto const own = preset_of(choice), asked = setup_of(choice, 0);
    return choice.preset == Preset::lossless && choice.engine == EngineKind::threads && !choice.planes() && !choice.trace &&
           asked.holds == own.holds && asked.reusable == own.reusable && asked.colour == own.colour;
}

MakeRenderer& maker_of(Choice const& choice, render::SetupChoice const& setup)
{
    if (!setup.routes) return setup.blooms ? threads_placed : threads_placed_unspread;
    if (choice.engine == EngineKind::threads) {
        if (choice.trace) return choice.planes() ? threads_planes_traced : threads_traced;
        return choice.planes() ? threads_planes : threads;
    }
    if (choice.trace) return choice.planes() ? sequential_planes_traced : sequential_traced;
    return choice.planes() ? sequential_planes : sequential;
}

} // namespace

render::SetupChoice setup_of(Choice const& choice, std::uint32_t sh_degree)
{
    auto setup = preset_of(choice);
    if (choice.saturation) setup.holds = *choice.saturation == SaturationKind::hold;
    if (choice.copies) setup.reusable = *choice.copies == CopiesKind::world;
    if (choice.pixels)
        setup.colour = *choice.pixels == PixelKind::float32 ? render::ColourFormat::float32 : render::ColourFormat::rgbx8;
    // A preset that drops has no FIFOs. If it is told to hold, it gets those of `lossless`, and the ledger lists them.
    if (setup.holds && setup.sizes.waiting == 0) setup.sizes.waiting = splat::Lossless::sizes.waiting;
    setup = render::fitted(setup, sh_degree, true, true);
    if (choice.machine == MachineKind::test) {
        setup.machine = tilemesh::size_of_machine<splat::RoomyMachine>();
        setup.sizes = splat::roomy(setup.sizes);
    }
    return choice.planes() ? render::with_planes(setup, choice.depth, choice.alpha) : setup;
}

render::SetupChoice setup_for(Choice const& choice, tilemesh::scene::Demand const& demand)
{
    if (!may_be_fitted(choice) || demand.moves) return setup_of(choice, demand.sh_degree);
    // Records with harmonics always bloom.
    bool const blooms = demand.spans || demand.sh_degree != 0;
    auto setup = render::fitted(preset_of(choice), demand.sh_degree, false, blooms);
    if (choice.machine == MachineKind::test) {
        setup.machine = tilemesh::size_of_machine<splat::RoomyMachine>();
        setup.sizes = splat::roomy(setup.sizes);
    }
    return setup;
}

std::unique_ptr<AnyRenderer> make_renderer(Choice const& choice, tilemesh::scene::Map const& map,
                                           tilemesh::scene::Demand const& demand, tilemesh::RendererOptions options)
{
    auto const setup = setup_for(choice, demand);
    auto renderer = maker_of(choice, setup)(tilemesh::scene::needed(map, demand), render::facts_of(setup), options);
    renderer->hold_to(demand);
    return renderer;
}

} // namespace render_map
