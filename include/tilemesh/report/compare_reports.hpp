#pragma once
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/report/frame_report.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// Returns the first exact field in which two reports differ, with both values: "gaussians.moved: 3 and 4". Returns an empty string if the
/// reports agree. It compares the camera's name, every exact field, each loss, the full tiles, the unfinished tiles, and the
/// digests if both frames have them.
///
/// `ignored` names fields or groups of fields ("exchanged_bytes") that may differ. "lost" covers the number of losses, their list and
/// the full tiles. Throws `tilemesh::Error` for a name that no field has.
TILEMESH_HOST std::string first_difference(FrameReport const& a, FrameReport const& b,
                                           std::initializer_list<std::string_view> ignored = {});

/// Do two reports agree in all exact fields? They do for one frame on two engines, or with two numbers of threads.
TILEMESH_HOST bool same_report(FrameReport const& a, FrameReport const& b);

}}} // namespace tilemesh::report

#if !defined(TILEMESH_COMPILED)
#    include <tilemesh/report/detail/compare_reports_code.hpp>
#endif
