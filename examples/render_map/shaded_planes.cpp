#include "renderer_of.hpp"
#include "setups.hpp"

// Records of degree 3 and both planes, whatever less is asked for: one setup a machine instead of nine.
std::unique_ptr<render_map::AnyRenderer> render_map::shaded_planes(Choice const& choice, tilemesh::scene::Map const& map,
                                                                   tilemesh::RendererOptions const& options)
{
    using namespace tilemesh::splat;
    using Shaded = Fitted<Lossless, 3>;
    using Planes = WithAlpha<WithDepth<FloatPixel>>;
    if (choice.machine == MachineKind::mk2) return std::make_unique<tilemesh::RendererOf<WithPixel<Shaded, Planes>>>(map, options);
    return std::make_unique<tilemesh::RendererOf<WithPixel<Roomy<Shaded>, Planes>>>(map, options);
}
