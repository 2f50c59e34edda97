// A part of tilemesh::compiled: maps in PLY files.
#include <tilemesh/scene/detail/ply_code.hpp>
