// A part of tilemesh::compiled: what is written of a trace: tables, diagrams, a page; and fronts of studies.
#include <tilemesh/model/detail/explore_code.hpp>
#include <tilemesh/model/detail/trace_diagrams_code.hpp>
#include <tilemesh/model/detail/trace_files_code.hpp>
#include <tilemesh/model/detail/trace_maps_code.hpp>
#include <tilemesh/model/detail/trace_page_code.hpp>
#include <tilemesh/model/detail/trace_section_code.hpp>
