#pragma once
#include <cstdint>
#include <ostream>
#include <string>
#include <tilemesh/report/table.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <vector>

namespace tilemesh::report {

/// Why a record, or its copy on some tile, is not in the picture.
enum class Cause : std::uint32_t {
    unplaced,      ///< its anchor tile has no storage left (`hold`): the host has it
    storage_full,  ///< it, or the copy, found no storage slot: gone
    channel_full,  ///< the copy found no slot in the channel (`drop`)
    late,          ///< under way: the frame's hops are bounded
    no_bloom       ///< the setup does not bloom, and the footprint leaves the anchor tile
};
inline char const* to_string(Cause cause) noexcept
{
    constexpr char const* names[] = {"unplaced", "storage_full", "channel_full", "late", "no_bloom"};
    return names[static_cast<std::uint32_t>(cause)];
}

struct Loss {
    static constexpr std::uint32_t whole = 0xffffffffu;
    splat::GaussianId id;
    std::uint32_t tile; ///< index of the tile that lacks the copy; `whole`: the record itself
    Cause cause;
};

/// What one frame took. Exact and the same on every engine and any number of threads, but for host_ms.
struct FrameReport {
    std::string camera;
    std::uint32_t width = 0, height = 0;
    struct Supersteps {
        std::uint64_t project = 0, route = 0, bloom = 0, composite = 0;
        std::uint64_t total() const noexcept { return project + route + bloom + composite; }
    } supersteps;                              ///< exchanges that carried something
    struct {
        std::uint64_t visible = 0;             ///< something on screen when the frame begins; the unplaced are among them
        std::uint64_t moved = 0;               ///< whose anchor changed
        std::uint64_t held = 0;                ///< refusals of a full channel or missing credit: three waits count three
        std::uint64_t dropped = 0;             ///< gone for good (`drop`)
        std::uint64_t unplaced = 0;            ///< anchor tile full (`hold`)
        std::uint64_t parked = 0;              ///< nothing on screen
        std::uint64_t under_way = 0;           ///< in a channel or FIFO at the end (bounded hops)
    } gaussians;
    struct {
        std::uint64_t channel_full = 0, no_credit = 0, storage_full = 0, copies_full = 0, copies_refused = 0;
    } refused;                                 ///< refusals by cause
    std::vector<Loss> lost;                    ///< every record and copy that the picture lacks
    std::uint64_t copies = 0;                  ///< on the tiles when the frame ends
    std::uint64_t lost_copies = 0, late_copies = 0;
    std::uint64_t messages = 0;                ///< of routing and bloom
    std::uint64_t hops = 0;                    ///< of routing
    std::uint64_t exchanged_live_bytes = 0, exchanged_capacity_bytes = 0;
    std::uint64_t pairs = 0;                   ///< Gaussian-pixel pairs evaluated
    std::uint64_t pairs_contributing = 0;      ///< with alpha >= alpha_min in a pixel that was not finished
    std::uint32_t peak_storage = 0;            ///< records on one tile
    std::uint32_t peak_channel = 0;            ///< records in one channel
    struct {
        double project = 0, route = 0, bloom = 0, composite = 0;
        double picture = 0;                    ///< framebuffers of the tiles to one image, which is no work of the machine
        double total = 0;                      ///< all of it
    } host_ms;                                 ///< composite includes the depth sort
    std::vector<std::uint64_t> digests;
};

/// A short table for a terminal.
inline std::ostream& operator<<(std::ostream& out, FrameReport const& r)
{
    auto const ms = [](double v) {
        auto const hundredths = static_cast<std::uint64_t>(v * 100 + 0.5);
        auto const fraction = hundredths % 100;
        return std::to_string(hundredths / 100) + (fraction < 10 ? ".0" : ".") + std::to_string(fraction);
    };
    Table stages{{"stage", "supersteps", "host ms"}};
    stages.add_row({"project", thousands(r.supersteps.project), ms(r.host_ms.project)});
    stages.add_row({"route", thousands(r.supersteps.route), ms(r.host_ms.route)});
    stages.add_row({"bloom", thousands(r.supersteps.bloom), ms(r.host_ms.bloom)});
    stages.add_row({"composite", thousands(r.supersteps.composite), ms(r.host_ms.composite)});
    stages.add_row({"picture", "0", ms(r.host_ms.picture)});
    stages.add_row({"frame", thousands(r.supersteps.total()), ms(r.host_ms.total)});
    out << stages << "Gaussians: " << thousands(r.gaussians.visible) << " visible, " << thousands(r.gaussians.parked)
        << " parked, " << thousands(r.gaussians.moved) << " moved, " << thousands(r.gaussians.held) << " held, "
        << thousands(r.gaussians.dropped) << " dropped, " << thousands(r.gaussians.unplaced) << " unplaced\n"
        << "copies: " << thousands(r.copies) << " on tiles, " << thousands(r.lost_copies) << " lost, "
        << thousands(r.late_copies) << " late\n"
        << "messages: " << thousands(r.messages) << " (" << thousands(r.hops) << " hops of routing), "
        << thousands(r.exchanged_live_bytes) << " bytes live, " << thousands(r.exchanged_capacity_bytes)
        << " bytes of capacity\n"
        << "pairs: " << thousands(r.pairs) << " evaluated, " << thousands(r.pairs_contributing) << " contributing\n"
        << "peaks: " << thousands(r.peak_storage) << " records on a tile, " << thousands(r.peak_channel)
        << " in a channel\n";
    return out;
}

} // namespace tilemesh::report
