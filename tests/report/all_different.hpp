#pragma once
#include <cstdint>
#include <tilemesh/report/frame_report.hpp>

/// A report of which all exact numbers differ, and all times. A number is its field's place in `report_fields` and 10.
inline tilemesh::report::FrameReport all_different()
{
    using namespace tilemesh::report;
    using tilemesh::splat::GaussianId;
    FrameReport r;
    r.camera = "sloth/front";
    std::uint64_t n = 9;
    for (auto const& field : report_fields) {
        ++n;
        if (field.set_count != nullptr) field.set_count(r, n);
        if (field.set_milliseconds != nullptr) field.set_milliseconds(r, 0.5 + static_cast<double>(n));
    }
    r.exchanged_capacity_bytes = 0xffffffffffffffffu;
    r.lost = {{GaussianId{7}, Loss::whole, Cause::unplaced, 1000}, {GaussianId{8}, 1439, Cause::storage_full},
              {GaussianId{9}, 3, Cause::late}, {GaussianId{9}, 4, Cause::late}, {GaussianId{9}, 5, Cause::late}};
    return r;
}
