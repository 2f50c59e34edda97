// A part of tilemesh::compiled: maps that grow.
#include <tilemesh/slam/detail/mapper_code.hpp>
#include <tilemesh/slam/detail/session_code.hpp>
