// A part of tilemesh::compiled: maps in PLY files, and the text of files.
#include <tilemesh/scene/detail/far_means_code.hpp>
#include <tilemesh/scene/detail/map_sink_code.hpp>
#include <tilemesh/scene/detail/ply_code.hpp>
#include <tilemesh/scene/detail/ply_compressed_code.hpp>
#include <tilemesh/scene/detail/ply_gaussian_code.hpp>
#include <tilemesh/scene/detail/ply_header_code.hpp>
#include <tilemesh/scene/detail/ply_kind_code.hpp>
#include <tilemesh/scene/detail/ply_output_code.hpp>
#include <tilemesh/scene/detail/ply_rows_code.hpp>
#include <tilemesh/scene/detail/ply_source_code.hpp>
#include <tilemesh/scene/detail/records_code.hpp>
#include <tilemesh/scene/detail/text_input_code.hpp>
