#pragma once
// What homes_choice.hpp declares and does not define: it stands behind that header, also in the library as one file.
#include <tilemesh/render/homes_renderer.hpp>

namespace tilemesh { inline namespace v0_2 { namespace render {
}}} // namespace tilemesh::render
