// A part of tilemesh::compiled: the built-in map.
#include <tilemesh/scene/detail/built_in_code.hpp>
