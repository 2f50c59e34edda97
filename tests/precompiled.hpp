// What most test files include; see CMakeLists.txt. Every file still includes what it needs: planted faults are compiled without this.
#include <doctest/doctest.h>
#include <tilemesh/any_renderer.hpp>
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/renderer.hpp>
#include <vector>
