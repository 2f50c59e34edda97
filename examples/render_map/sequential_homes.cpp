#include "traced_homes.hpp"
#include <tilemesh/engine/checked_mesh.hpp>

render_map::MakeHomesRenderer& render_map::homes_sequential = make_traced_homes<tilemesh::CheckedMesh>;
