// A part of tilemesh::compiled: maps in PLY files, and the text of files.
#include <tilemesh/scene/detail/ply_code.hpp>
#include <tilemesh/scene/detail/ply_output_code.hpp>
#include <tilemesh/scene/detail/records_code.hpp>
#include <tilemesh/scene/detail/text_input_code.hpp>
