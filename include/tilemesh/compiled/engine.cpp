// A part of tilemesh::compiled: the host code of every mesh.
#include <tilemesh/engine/detail/checker_code.hpp>
#include <tilemesh/engine/detail/mesh_core_code.hpp>
#include <tilemesh/engine/detail/not_quiet_code.hpp>
#include <tilemesh/engine/detail/quiet_change_code.hpp>
#include <tilemesh/engine/detail/rectangle_code.hpp>
#include <tilemesh/engine/detail/run_code.hpp>
#include <tilemesh/engine/detail/store_view_code.hpp>
#include <tilemesh/engine/detail/team_code.hpp>
