#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/splat/frame_program.hpp>

/// Pure functions that make a frame's report from counters.
namespace tilemesh { inline namespace v0_2 { namespace render {

/// The sums of the tiles' counters in a frame.
struct TileSums {
    std::uint64_t visible = 0, parked = 0, moved = 0, hops = 0, copies = 0;
    std::uint64_t channel_full = 0, no_credit = 0, storage_full = 0, copies_full = 0, copies_refused = 0;
    std::uint64_t evaluated = 0, contributing = 0;
    static constexpr std::size_t words = 12; ///< all members are words of 8 bytes

    void add(splat::Counts const& c, splat::Work const& w) noexcept
    {
        visible += c.visible;
        parked += c.parked;
        moved += c.moved;
        hops += c.hops;
        copies += c.copies;
        channel_full += c.channel_full;
        no_credit += c.no_credit;
        storage_full += c.storage_full;
        copies_full += c.copies_full;
        copies_refused += c.copies_refused;
        for (std::uint32_t i = 0; i < splat::Work::max_workers; ++i) {
            evaluated += w.evaluated[i];
            contributing += w.contributing[i];
        }
    }
};

static_assert(sizeof(TileSums) == 8 * TileSums::words, "processes add up all words of the sums");

/// The report of one run of the frame program `Frame<P>`, without the list of losses. `holds`: full channels held records back (`Hold`).
template <class P>
report::FrameReport account(RunCounters const& run, TileSums const& sums, bool holds)
{
    using Steps = splat::FrameSteps<P>;
    report::FrameReport r;
    r.gaussians.visible = sums.visible;
    r.gaussians.parked = sums.parked;
    r.gaussians.moved = sums.moved;
    r.gaussians.held = holds ? sums.channel_full + sums.no_credit : 0;
    r.hops = sums.hops;
    r.copies = sums.copies;
    r.refused = {sums.channel_full, sums.no_credit, sums.storage_full, sums.copies_full, sums.copies_refused};
    r.pairs = sums.evaluated * splat::pairs_a_count;
    r.pairs_contributing = sums.contributing;
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
    r.messages = run.messages();
    for (auto const& s : run.steps) {
        r.exchanged_live_bytes += s.live_bytes;
        r.exchanged_capacity_bytes += s.capacity_bytes;
    }
    for (auto const& p : run.peaks) {
        if (p.region == splat::Storage<P>::name) r.peak_storage = p.items;
        if (p.region == splat::Road<P>::name || p.region == splat::Beam<P>::name)
            r.peak_channel = std::max(r.peak_channel, p.items);
    }
    r.digests = run.digests;
    return r;
}

/// Adds the second run to the report of a frame that ran twice. A frame runs twice if the host recalled copies of missing records. The
/// result is the first run's report with the final state of the second run, which moved no record. Its passes are those
/// of both runs.
inline void add_second_run(report::FrameReport& r, report::FrameReport const& again)
{
    r.copies = again.copies;
    r.pairs = again.pairs;
    r.pairs_contributing = again.pairs_contributing;
    for (auto const stage : {&report::FrameReport::ByStage::project, &report::FrameReport::ByStage::route,
                             &report::FrameReport::ByStage::bloom, &report::FrameReport::ByStage::composite})
        r.passes.*stage += again.passes.*stage;
    r.lost = again.lost;
    r.full_tiles = again.full_tiles;
    r.lost_copies = again.lost_copies;
    r.late_copies = again.late_copies;
    r.host_ms.composite += again.host_ms.composite;
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
