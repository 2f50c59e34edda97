#include "traced_homes.hpp"
#include <tilemesh/engine/mesh.hpp>

render_map::MakeHomesRenderer& render_map::homes_traced = make_traced_homes<tilemesh::Mesh>;
