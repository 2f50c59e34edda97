// A part of tilemesh::compiled: the program of homes.
#include <tilemesh/render/homes_renderer.hpp>

namespace tilemesh { inline namespace v0_2 { namespace render {
template std::unique_ptr<AnyRenderer> make_homes_renderer<splat::FloatPixel>(scene::Map const&, HomesChoice const&, RendererOptions const&);
}}} // namespace tilemesh::render
