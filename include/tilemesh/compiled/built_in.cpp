// A part of tilemesh::compiled: the built-in map, and poses of cameras.
#include <tilemesh/scene/detail/built_in_code.hpp>
#include <tilemesh/scene/detail/orbit_code.hpp>
#include <tilemesh/scene/detail/pose_code.hpp>
