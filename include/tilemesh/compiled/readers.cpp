// A part of tilemesh::compiled: maps in other formats than PLY, and what chooses the reader.
#include <tilemesh/scene/detail/map_file_code.hpp>
#include <tilemesh/scene/detail/sog_code.hpp>
#include <tilemesh/scene/detail/splat_file_code.hpp>
#include <tilemesh/scene/detail/spz_code.hpp>
