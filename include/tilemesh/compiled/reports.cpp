// A part of tilemesh::compiled: pictures in files, reports, errors, references, and why a run makes no progress.
#include <tilemesh/model/detail/no_progress_code.hpp>
#include <tilemesh/report/detail/causes_code.hpp>
#include <tilemesh/report/detail/distinct_files_code.hpp>
#include <tilemesh/report/detail/enclosure_code.hpp>
#include <tilemesh/report/detail/error_measures_code.hpp>
#include <tilemesh/report/detail/frame_report_code.hpp>
#include <tilemesh/report/detail/image_file_code.hpp>
#include <tilemesh/report/detail/json_text_code.hpp>
#include <tilemesh/report/detail/reference_double_code.hpp>
#include <tilemesh/report/detail/whole_file_code.hpp>
