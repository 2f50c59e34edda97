// A part of tilemesh::compiled: pictures in files, reports, errors, and why a run makes no progress.
#include <tilemesh/model/detail/no_progress_code.hpp>
#include <tilemesh/report/detail/error_measures_code.hpp>
#include <tilemesh/report/detail/frame_report_code.hpp>
#include <tilemesh/report/detail/image_file_code.hpp>
