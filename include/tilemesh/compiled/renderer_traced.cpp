// A part of tilemesh::compiled: the renderers on machines that keep a trace.
#include <tilemesh/renderer.hpp>

template class tilemesh::render::FrameRenderer<tilemesh::render::HostPolicies, tilemesh::Mesh, tilemesh::Traced<tilemesh::AnyMachine>>;
