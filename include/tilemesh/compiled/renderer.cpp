// A part of tilemesh::compiled: the renderer of the anchored program, for all setups by reference and all engines of one process.
#include <tilemesh/renderer.hpp>

template class tilemesh::render::FrameRenderer<tilemesh::render::HostPolicies, tilemesh::PortMesh, tilemesh::Traced<tilemesh::AnyMachine>>;
template tilemesh::render::Prefetched
tilemesh::render::FrameRenderer<tilemesh::render::HostPolicies, tilemesh::PortMesh, tilemesh::Traced<tilemesh::AnyMachine>>::prefetch<
    tilemesh::render::HostPolicies>(tilemesh::splat::Camera const&);
