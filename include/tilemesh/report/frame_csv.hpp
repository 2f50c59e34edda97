#pragma once
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/report/frame_report.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// The header of a CSV of frames: "camera", then the name of every exact field, in the order of report_fields. It has no line break.
TILEMESH_HOST std::string csv_header();

/// A frame's line under `csv_header()`, after RFC 4180: the camera's name is quoted. Host times are left out, so that every engine and
/// every run give the same line. It has no line break.
TILEMESH_HOST std::string csv_row(FrameReport const& r);

}}} // namespace tilemesh::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/frame_csv_code.hpp>
#endif
