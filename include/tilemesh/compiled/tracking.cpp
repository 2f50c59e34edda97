// A part of tilemesh::compiled: poses and errors of paths.
#include <tilemesh/track/detail/pose_accuracy_code.hpp>
#include <tilemesh/track/detail/pose_evaluator_code.hpp>
#include <tilemesh/track/detail/pose_solver_code.hpp>
#include <tilemesh/track/detail/pose_update_code.hpp>
#include <tilemesh/track/detail/small_system_code.hpp>
#include <tilemesh/track/detail/spoil_code.hpp>
#include <tilemesh/track/detail/tracker_code.hpp>
#include <tilemesh/track/detail/trajectory_error_code.hpp>
