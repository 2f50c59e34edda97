// The headers that most test files include; see CMakeLists.txt. Every file still includes what it uses, because planted
// faults compile without this file.
#include "standard.hpp"
#include <tilemesh/any_renderer.hpp>
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/renderer.hpp>
