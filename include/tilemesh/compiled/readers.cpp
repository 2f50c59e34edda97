// A part of tilemesh::compiled: maps.
#include <tilemesh/scene/detail/built_in_code.hpp>
#include <tilemesh/scene/detail/map_file_code.hpp>
#include <tilemesh/scene/detail/ply_code.hpp>
#include <tilemesh/scene/detail/sog_code.hpp>
#include <tilemesh/scene/detail/splat_file_code.hpp>
#include <tilemesh/scene/detail/spz_code.hpp>
