// A part of tilemesh::compiled: the host code of every renderer, and what a map needs.
#include <tilemesh/render/detail/describe_code.hpp>
#include <tilemesh/render/detail/frame_layout_code.hpp>
#include <tilemesh/render/detail/homes_layout_code.hpp>
#include <tilemesh/render/detail/losses_code.hpp>
#include <tilemesh/render/detail/project_records_code.hpp>
#include <tilemesh/render/detail/record_table_code.hpp>
#include <tilemesh/render/detail/setup_code.hpp>
#include <tilemesh/render/detail/setup_fields_code.hpp>
#include <tilemesh/scene/detail/demand_code.hpp>
