// A part of tilemesh::compiled: what every mesh does on the host, whatever its program.
#include <tilemesh/engine/detail/not_quiet_code.hpp>
#include <tilemesh/engine/detail/rectangle_code.hpp>
#include <tilemesh/engine/detail/team_code.hpp>
