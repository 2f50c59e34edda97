#include "setups.hpp"
#include "traced.hpp"
#include "variant.hpp"

namespace {
/// A build for the compiler's sake has the other preset's alone, and parse_options refuses this one.
template <class S, bool Compiled = !render_map::own_policies_only>
std::unique_ptr<render_map::AnyRenderer> traced(tilemesh::scene::Map const& map, tilemesh::RendererOptions const& options)
{
    if constexpr (Compiled) return std::make_unique<render_map::TracedRendererOf<render_map::OnTraced<S>>>(map, options);
    else
        throw tilemesh::Error("--trace with another preset than lossless (this build was made with "
                              "TILEMESH_RENDER_MAP_POLICIES=OFF); leave out --preset, or build with ON");
}
} // namespace

std::unique_ptr<render_map::AnyRenderer> render_map::paper_traced(Choice const&, tilemesh::scene::Map const& map,
                                                                  tilemesh::RendererOptions const& options)
{
    return traced<tilemesh::splat::Paper>(map, options);
}
