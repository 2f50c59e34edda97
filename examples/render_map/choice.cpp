#include "choice.hpp"
#include "exact_rays.hpp"
#include "ranks.hpp"
#include <tilemesh/splat/setup_types.hpp>
#include <utility>

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

std::unique_ptr<tilemesh::Renderer> make_renderer(Choice const& choice, tilemesh::scene::Map const& map, tilemesh::scene::Demand const& demand,
                                                  tilemesh::RendererOptions options)
{
    using tilemesh::report::Program;
    std::unique_ptr<tilemesh::Renderer> renderer;
    if (choice.exact_rays) return std::make_unique<tilemesh::Renderer>(make_exact_rays(choice, map, options));
    if (ranks::number() > 1) {
        auto const within = options.program == Program::homes ? options : render::within(homes_of(choice, demand.sh_degree), options);
        auto const homes = [&choice, &demand, within](tilemesh::scene::Map const&) {
            return ranks::parts().make(Program::homes, choice, demand, within);
        };
        auto core = options.program == Program::homes ? homes(map) : ranks::parts().make(options.program, choice, demand, options);
        auto const may_fit = render::may_fit_anchored(demand.gaussians - demand.culled, core->setup(), options);
        renderer = choice.stays_anchored || options.program == Program::homes
                       ? std::make_unique<tilemesh::Renderer>(std::move(core))
                       : std::make_unique<tilemesh::Renderer>(std::move(core), homes, may_fit);
    } else {
        if (choice.engine == EngineKind::sequential) options.engine = render::EngineKind::checked;
        options.trace = choice.trace;
        if (choice.stays_anchored) options.program = Program::anchored;
        renderer = std::make_unique<tilemesh::Renderer>(tilemesh::scene::needed(map, demand), setup_for(choice, demand), options,
                                                        homes_of(choice, std::min(demand.sh_degree, map.sh_degree)));
    }
    renderer->hold_to(demand);
    return renderer;
}

} // namespace render_map
