#pragma once
/// The whole library, for users; nothing in include/ includes this. `scene/camera_json.hpp` is left out because it needs
/// nlohmann-json: include it beside this one.
#if __cplusplus < 202002L
#error "tilemesh: the host side needs C++20; build with -std=c++20"
#endif
#include <tilemesh/config.hpp>
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/engine/contract.hpp>
#include <tilemesh/engine/cost_model.hpp>
#include <tilemesh/engine/cost_parameters.hpp>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/engine/trace_files.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/fit_renderer.hpp>
#include <tilemesh/machine/buffer.hpp>
#include <tilemesh/machine/channel.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/machine/name.hpp>
#include <tilemesh/machine/operations.hpp>
#include <tilemesh/machine/spec.hpp>
#include <tilemesh/machine/superstep.hpp>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/image_file.hpp>
#include <tilemesh/report/losses.hpp>
#include <tilemesh/report/naive.hpp>
#include <tilemesh/report/plot.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/colmap.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/scene/ply.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/records.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <tilemesh/screen_cache.hpp>
#include <tilemesh/splat/fitted.hpp>
#include <tilemesh/splat/frame_program.hpp>
#include <tilemesh/splat/with_pixel.hpp>
