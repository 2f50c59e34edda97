// A part of tilemesh::compiled: poses on the mesh.
#include <tilemesh/track/pose_evaluator.hpp>

template class tilemesh::track::BasicPoseEvaluator<tilemesh::track::TrackedByReference<tilemesh::splat::Lossless>, tilemesh::Mesh>;
