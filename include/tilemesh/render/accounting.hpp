#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/render/tile_sums.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/splat/frame_program.hpp>

/// Pure functions that make a frame's report from counters.
namespace tilemesh { inline namespace v0_2 { namespace render {

using AnchoredSums = TileSums<splat::Counts, splat::Work>;

/// The report of one run of the frame program `Frame<P>`, without the list of losses. `holds`: full channels held records back (`Hold`).
template <class P>
report::FrameReport account(RunCounters const& run, AnchoredSums const& sums, bool holds)
{
    using Steps = splat::FrameSteps<P>;
    report::FrameReport r;
    sums.add_to(r);
    add_traffic(run, r);
    r.gaussians.held = holds ? r.refused.by_channels() : 0;
    // A step that the setup leaves out counts 0.
    auto const passes = [&](std::uint32_t step) { return step == Steps::none ? 0u : run.steps[step].passes; };
    auto const exchanges = [&](std::uint32_t step) { return step == Steps::none ? 0u : run.steps[step].exchanges; };
    auto const milliseconds = [&](std::uint32_t step) { return step == Steps::none ? 0.0 : run.steps[step].milliseconds; };
    r.passes = {passes(Steps::project), passes(Steps::route), passes(Steps::bloom_first) + passes(Steps::bloom),
                passes(Steps::depth_sort) + passes(Steps::composite)};
    r.exchanges = {exchanges(Steps::project), exchanges(Steps::route), exchanges(Steps::bloom_first) + exchanges(Steps::bloom),
                   exchanges(Steps::composite)};
    r.host_ms = {milliseconds(Steps::project), milliseconds(Steps::route), milliseconds(Steps::bloom_first) + milliseconds(Steps::bloom),
                 milliseconds(Steps::depth_sort) + milliseconds(Steps::composite), 0, 0};
    for (auto const& p : run.peaks) {
        if (p.region == splat::Storage<P>::name) r.peak_storage = p.items;
        if (p.region == splat::Road<P>::name || p.region == splat::Beam<P>::name)
            r.peak_channel = std::max(r.peak_channel, p.items);
    }
    return r;
}

/// Adds the second run to the report of a frame that ran twice (`report::Rerun`). The second run moved no record.
inline void add_second_run(report::FrameReport& r, report::FrameReport const& again)
{
    for (auto const& field : report::report_fields) {
        if (field.rerun == report::Rerun::first) continue;
        bool const sum = field.rerun == report::Rerun::sum;
        if (field.exact()) field.set_count(r, (sum ? field.count(r) : 0) + field.count(again));
        else field.set_milliseconds(r, (sum ? field.milliseconds(r) : 0.0) + field.milliseconds(again));
    }
    r.lost = again.lost;
    r.full_tiles = again.full_tiles;
    r.digests.insert(r.digests.end(), again.digests.begin(), again.digests.end());
}

/// Checks the sums in the report of a frame. Returns null if all sums hold, otherwise a sentence about the first sum that does not hold.
/// `records`: number of records in the map. `gone`: number of records that the machine lost for good in earlier frames. Cost: one pass over
/// `lost`.
inline char const* wrong_sum(report::FrameReport const& r, std::uint64_t records, std::uint64_t gone) noexcept
{
    std::uint64_t lost_copies = 0, late_copies = 0, unplaced = 0;
    auto last = splat::GaussianId::none;
    for (auto const& l : r.lost) { // the entries of a record that no tile owns are adjacent
        if (l.tile != report::Loss::whole) ++(l.cause == report::Cause::late ? late_copies : lost_copies);
        if (l.cause == report::Cause::unplaced && l.id != last) ++unplaced;
        last = l.id;
    }
    auto const& n = r.gaussians;
    if (n.visible + n.parked + gone != records) return "visible, parked and earlier lost records are not the records of the map";
    if (n.unplaced > n.visible) return "there are unplaced records that are not visible";
    // With bounded hops, an unplaced record that left a copy on each of its tiles has no entry in `lost`.
    if (unplaced > n.unplaced) return "the list of losses has more unplaced records than there are";
    if (n.dropped < gone) return "records that were lost before are not among the dropped";
    if (r.lost_copies != lost_copies) return "copies_lost is not the number of copies in the list of losses";
    if (r.late_copies != late_copies) return "copies_late is not the number of late copies in the list of losses";
    return nullptr;
}

/// Throws Error if a sum in the report does not hold (see `wrong_sum`). The renderer calls it for every frame, also with NDEBUG.
[[gnu::noinline]] inline void check_sums(report::FrameReport const& r, std::uint64_t records, std::uint64_t gone)
{
    if (auto const* const why = wrong_sum(r, records, gone))
        throw Error(std::string("a report whose sums do not hold (") + why + "); report this, and do not use the frame");
}

}}} // namespace tilemesh::render
