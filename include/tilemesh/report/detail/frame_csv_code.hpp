#pragma once
#include <tilemesh/report/frame_csv.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

TILEMESH_HOST std::string csv_header()
{
    std::string out = "camera";
    for (auto const& field : report_fields)
        if (field.exact()) out.append(",").append(field.name);
    return out;
}

TILEMESH_HOST std::string csv_row(FrameReport const& r)
{
    std::string out = "\"";
    for (char const c : r.camera) out.append(c == '"' ? 2 : 1, c);
    out += '"';
    for (auto const& field : report_fields)
        if (field.exact()) out.append(",").append(std::to_string(field.count(r)));
    return out;
}

}}} // namespace tilemesh::report
