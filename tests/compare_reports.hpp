#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/report/frame_report.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report { // `report::first_difference` reads like the rest of a test

/// Returns the first exact field in which two reports differ, with both values: "gaussians.moved: 3 and 4". Returns an empty string if the
/// reports agree. It compares the camera's name, every exact field, each loss, the full tiles, the unfinished tiles, and the
/// digests if both frames have them.
///
/// `ignored` names fields or groups of fields ("exchanged_bytes") that may differ. "lost" covers the number of losses, their list and
/// the full tiles. Throws `tilemesh::Error` for a name that no field has.
inline std::string first_difference(FrameReport const& a, FrameReport const& b, std::initializer_list<std::string_view> ignored = {})
{
    for (auto const name : ignored)
        if (std::none_of(std::begin(report_fields), std::end(report_fields),
                         [name](ReportField const& field) { return field.is_in(name); }))
            throw Error("cannot ignore " + std::string(name) +
                        " (a report has no such field); take a name or a group of report_fields");
    auto const differs = [](std::string const& name, std::string const& in_a, std::string const& in_b) {
        return name + ": " + in_a + " and " + in_b;
    };
    if (a.camera != b.camera) return differs("camera", a.camera, b.camera);
    for (auto const& field : report_fields) {
        if (!field.exact() || field.group() == "losses" || field.count(a) == field.count(b)) continue; // sums over the list, below
        if (std::any_of(ignored.begin(), ignored.end(), [&field](auto name) { return field.is_in(name); })) continue;
        return differs(std::string(field.name), std::to_string(field.count(a)), std::to_string(field.count(b)));
    }
    if (std::find(ignored.begin(), ignored.end(), "lost") == ignored.end()) {
        auto const text_of = [](Loss const& loss) {
            return "Gaussian " + std::to_string(static_cast<std::uint32_t>(loss.id)) +
                   (loss.tile == Loss::whole ? "" : " on tile " + std::to_string(loss.tile)) + " (" + to_string(loss.cause) +
                   (loss.full_tile == Loss::whole ? "" : ", tile " + std::to_string(loss.full_tile) + " is full") + ")";
        };
        for (std::size_t i = 0; i < a.lost.size(); ++i)
            if (a.lost[i] != b.lost[i])
                return differs("lost[" + std::to_string(i) + "]", text_of(a.lost[i]), text_of(b.lost[i]));
        auto const text_of_full = [](std::optional<FullTiles> const& full) {
            return !full ? std::string("none")
                         : std::to_string(full->count) + " with tile " + std::to_string(full->fullest) + ", which needs " +
                               std::to_string(full->slots_needed) + " of " + std::to_string(full->slots_available) + " slots";
        };
        if (a.full_tiles != b.full_tiles) return differs("full_tiles", text_of_full(a.full_tiles), text_of_full(b.full_tiles));
    }
    if (a.unfinished != b.unfinished &&
        std::none_of(ignored.begin(), ignored.end(), [](auto name) { return report_field("homes.unfinished_tiles").is_in(name); }))
        return differs("unfinished", "other tiles", "other depths");
    if (a.digests.empty() || b.digests.empty()) return {};
    if (a.digests.size() != b.digests.size())
        return differs("digests", std::to_string(a.digests.size()), std::to_string(b.digests.size()));
    for (std::size_t i = 0; i < a.digests.size(); ++i)
        if (a.digests[i] != b.digests[i])
            return differs("digests[" + std::to_string(i) + "]", std::to_string(a.digests[i]), std::to_string(b.digests[i]));
    return {};
}

/// Do two reports agree in all exact fields? They do for one frame on two engines, or with two numbers of threads.
inline bool same_report(FrameReport const& a, FrameReport const& b)
{
    return first_difference(a, b).empty();
}

}}} // namespace tilemesh::report
