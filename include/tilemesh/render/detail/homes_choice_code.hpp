#pragma once
// The definition of make_homes_renderer: it stands behind homes_choice.hpp, also in the library as one file.
#include <tilemesh/render/homes_renderer.hpp>

namespace tilemesh { inline namespace v0_2 { namespace render {
}}} // namespace tilemesh::render
