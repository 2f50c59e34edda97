#include "renderer_of.hpp"
#include "setups.hpp"

std::unique_ptr<render_map::AnyRenderer> render_map::paper_shaded(Choice const& choice, tilemesh::scene::Map const& map,
                                                                  tilemesh::RendererOptions const& options)
{
    using namespace tilemesh::splat;
    auto const demand = tilemesh::scene::demand_of(map);
    if (choice.machine == MachineKind::test)
        return tilemesh::fit_renderer<Roomy<Fitted<Paper, 3>>>(map, demand, options);
    return tilemesh::fit_renderer<Fitted<Paper, 1>, Fitted<Paper, 2>, Fitted<Paper, 3>>(map, demand, options);
}
