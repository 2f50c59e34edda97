// A part of tilemesh::compiled: Renderer, and the anchored program for all setups by reference and all engines of one process.
#include <tilemesh/detail/renderer_code.hpp>

template class tilemesh::render::FrameRenderer<tilemesh::render::HostPolicies, tilemesh::PortMesh, tilemesh::Traced<tilemesh::AnyMachine>>;
