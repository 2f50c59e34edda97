// A part of tilemesh::compiled: maps.
#include <tilemesh/scene/detail/built_in_code.hpp>
#include <tilemesh/scene/detail/ply_code.hpp>
