// A part of tilemesh::compiled: the renderer with planes.
#include <tilemesh/renderer.hpp>

template class tilemesh::render::FrameRenderer<tilemesh::render::HostPoliciesWithPlanes, tilemesh::Mesh, tilemesh::AnyMachine>;
