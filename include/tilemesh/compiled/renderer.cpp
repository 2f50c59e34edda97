// A part of tilemesh::compiled: the renderer that serves all presets.
#include <tilemesh/renderer.hpp>

template class tilemesh::render::FrameRenderer<tilemesh::render::HostPolicies, tilemesh::Mesh, tilemesh::AnyMachine>;
