// The headers that most test files include; see CMakeLists.txt. Every file still includes what it uses, because planted
// faults compile without this file.
#include <doctest/doctest.h>
#include <tilemesh/any_renderer.hpp>
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/renderer.hpp>
#include <vector>
