// A part of tilemesh::compiled: files of cameras, trajectories and lists of pictures.
#include <tilemesh/scene/detail/camera_json_code.hpp>
#include <tilemesh/scene/detail/colmap_code.hpp>
#include <tilemesh/scene/detail/named_camera_code.hpp>
#include <tilemesh/scene/detail/rgbd_list_code.hpp>
#include <tilemesh/scene/detail/trajectory_code.hpp>
