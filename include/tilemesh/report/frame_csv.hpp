#pragma once
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/report/frame_report.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// The header of a CSV of frames: "camera", then the name of every exact field, in the order of report_fields. It has no line break.
inline std::string csv_header()
{
    std::string out = "camera";
    for (auto const& field : report_fields)
        if (field.exact()) out.append(",").append(field.name);
    return out;
}

/// A frame's line under `csv_header()`, after RFC 4180: the camera's name is quoted. Host times are left out, so that every engine and
/// every run give the same line. It has no line break.
inline std::string csv_row(FrameReport const& r)
{
    std::string out = "\"";
    for (char const c : r.camera) out.append(c == '"' ? 2 : 1, c);
    out += '"';
    for (auto const& field : report_fields)
        if (field.exact()) out.append(",").append(std::to_string(field.count(r)));
    return out;
}

}}} // namespace tilemesh::report
