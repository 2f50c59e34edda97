#include "summary.hpp"
#include "../shared/text.hpp"
#include "limits.hpp"
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/table.hpp>
#include <vector>

namespace render_map {

namespace {

namespace report = tilemesh::report;
using report::thousands;
using tilemesh::decimals;

std::string by(std::array<std::uint32_t, 2> const& size)
{
    return std::to_string(size[0]) + " x " + std::to_string(size[1]);
}

void print_header(std::ostream& out, report::RunReport const& run)
{
    out << "map " << shared::one_line(run.map.name) << ": " << thousands(run.map.gaussians) << " Gaussians";
    if (run.map.rejected != 0) out << ", " << thousands(run.map.rejected) << " rows rejected";
    out << '\n';
    for (auto const* notes : {&run.map.notes, &run.notes})
        for (auto const& note : *notes) out << "  " << shared::one_line(note) << '\n';
}

void print_frame(std::ostream& out, report::RunReport const& run, report::RunFrame const& frame)
{
    auto const& r = frame.report;
    out << "camera " << shared::one_line(r.camera) << ", " << r.width << " x " << r.height << " pixels on " << by(frame.grid)
        << " tiles of " << by(frame.tile_px) << " (" << run.machine.name << ", preset " << run.preset
        << (r.program == report::Program::homes ? ", program homes, " : ", ") << run.engine
        << (run.ranks > 1 ? ", " + std::to_string(run.ranks) + " ranks" : "") << ", " << run.threads << (run.threads == 1 ? " thread)\n\n" : " threads)\n\n") << r;
    auto const print_error = [&out](char const* name, report::ErrorMeasures const& e) {
        out << name << ": PSNR " << decimals(e.psnr_db, 2) << " dB, at most "
                  << decimals(e.max_levels, 3) << " levels off (99.9 % below "
                  << decimals(e.p999_levels, 3) << "), SSIM " << decimals(e.ssim, 6) << '\n';
    };
    auto const print_compared = [&out](report::Comparison const& other) {
        if (!other.problem.empty()) return; // standard error says so
        auto const& m = other.measures;
        out << "against " << shared::one_line(other.file, 200) << ": PSNR " << decimals(m.psnr_db, 2) << " dB, SSIM " << decimals(m.ssim, 4) << ", L1 "
            << decimals(m.l1, 4) << ", largest difference " << decimals(m.largest, 4) << " at pixel " << m.largest_at[0] << ", " << m.largest_at[1] << '\n';
    };
    if (frame.photograph) print_compared(*frame.photograph);
    if (frame.compared) print_compared(*frame.compared);
    if (frame.error) print_error("against double precision, no cut-offs", *frame.error);
    if (frame.error_same_cuts)
        print_error("against double precision, same cut-offs", *frame.error_same_cuts);
    if (frame.error && r.pairs_contributing == 0) out << "no Gaussian is in this picture, so these errors say nothing: check the camera, and --near\n";
}

/// A counter in the table of frames. Its total is the sum over all frames.
struct Column {
    char const* header;
    std::uint64_t (*count)(report::FrameReport const&);
};
constexpr Column columns[] = {{"passes", [](report::FrameReport const& r) { return r.passes.total(); }},
                              {"exchanges", [](report::FrameReport const& r) { return r.exchanges.total(); }},
                              {"moved", report::report_field("gaussians.moved").count},
                              {"held", report::report_field("gaussians.held").count},
                              {"missing", report::report_field("lost").count},
                              {"messages", report::report_field("messages").count},
                              {"pairs", report::report_field("pairs").count}};

/// Prints one line per frame, then the totals.
void print_sequence(std::ostream& out, report::RunReport const& run)
{
    std::vector<std::string> headers{"frame", "camera"};
    for (auto const& column : columns) headers.emplace_back(column.header);
    bool const homes = std::any_of(run.frames.begin(), run.frames.end(),
                                   [](auto const& frame) { return frame.report.program == report::Program::homes; });
    if (homes) headers.emplace_back("rounds");
    headers.emplace_back("ms");
    bool const reference = run.frames.front().error_same_cuts.has_value();
    if (reference) headers.emplace_back("dB, same cuts");
    report::Table table{headers};

    std::vector<std::uint64_t> sums(std::size(columns), 0);
    std::uint64_t rounds = 0;
    double ms = 0, worst_db = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < run.frames.size(); ++i) {
        auto const& r = run.frames[i].report;
        std::vector<std::string> row{std::to_string(i), shared::one_line(r.camera, 60)};
        for (std::size_t c = 0; c < std::size(columns); ++c) {
            row.push_back(thousands(columns[c].count(r)));
            sums[c] += columns[c].count(r);
        }
        if (homes) row.push_back(thousands(r.homes.rounds));
        rounds += r.homes.rounds;
        row.push_back(decimals(r.host_ms.total, 1));
        ms += r.host_ms.total;
        if (reference) {
            auto const db = run.frames[i].error_same_cuts->psnr_db;
            row.push_back(decimals(db, 2));
            worst_db = std::min(worst_db, db);
        }
        table.add_row(row);
    }
    std::vector<std::string> totals{"all", thousands(run.frames.size()) + " frames"};
    for (auto const sum : sums) totals.push_back(thousands(sum));
    if (homes) totals.push_back(thousands(rounds));
    totals.push_back(decimals(ms, 1));
    if (reference) totals.push_back("worst " + decimals(worst_db, 2));
    table.add_row(totals);
    out << table << '\n';
}

/// Prints one line per photograph, then the means.
void print_photographs(std::ostream& out, report::RunReport const& run)
{
    report::Table table{{"frame", "camera", "PSNR, dB", "SSIM", "L1"}};
    for (std::size_t i = 0; i < run.frames.size(); ++i) {
        if (!run.frames[i].photograph) continue;
        auto const& photograph = *run.frames[i].photograph;
        std::vector<std::string> row{std::to_string(i), shared::one_line(run.frames[i].report.camera, 60)};
        auto const& m = photograph.measures;
        if (photograph.problem.empty()) row.insert(row.end(), {decimals(m.psnr_db, 3), decimals(m.ssim, 5), decimals(m.l1, 5)});
        else row.insert(row.end(), {"not compared", "", ""});
        table.add_row(row);
    }
    auto const means = report::photograph_means(run);
    std::vector<std::string> last{"mean", thousands(means.compared) + (means.compared == 1 ? " frame" : " frames")};
    if (means.compared != 0) last.insert(last.end(), {decimals(means.psnr_db, 3), decimals(means.ssim, 5), decimals(means.l1, 5)});
    else last.insert(last.end(), {"", "", ""});
    table.add_row(last);
    out << table << '\n';
}

} // namespace

std::string advice(Options const& options, Needs const& needs, report::RunReport const& run)
{
    std::uint64_t of[report::causes] = {}, slots = 0;
    std::string fullest; // the fullest tile of all frames, and its frame if there are several
    for (auto const& frame : run.frames) {
        for (std::uint32_t cause = 0; cause < report::causes; ++cause) of[cause] += frame.report.losses(report::Cause{cause});
        if (!frame.report.full_tiles || frame.report.full_tiles->slots_needed <= slots) continue;
        slots = frame.report.full_tiles->slots_needed;
        fullest = "the fullest tile" + (run.frames.size() > 1 ? " of " + frame.image : std::string());
    }
    if (std::any_of(run.frames.begin(), run.frames.end(), [](auto const& frame) { return !frame.report.unfinished.empty(); }))
        return "with --rounds all every tile is finished";
    auto const lost_for = [&](report::Cause cause) { return of[static_cast<std::uint32_t>(cause)] != 0; };
    std::string text;
    auto const add = [&](std::string const& words) { text += (text.empty() ? "" : "; ") + words; };
    if (lost_for(report::Cause::unplaced) || lost_for(report::Cause::storage_full)) {
        if (run.program == report::Program::anchored && run.ranks == 1 && setup_of(options.choice, 0).holds) add("with --program auto nothing is missing");
        auto const room = roomier(options, needs, slots);
        if (room.empty())
            add("no machine has " + thousands(slots) + " slots a tile, which " + fullest + " needs: smaller tiles need fewer (--tile)");
        else if (slots != 0) add(fullest + " needs " + thousands(slots) + " slots, and there is room with " + room);
        else add("tiles were full only while records were on their way; there is more room with " + room);
    }
    if (lost_for(report::Cause::channel_full)) add("with --saturation hold records wait for a free slot in a channel");
    if (lost_for(report::Cause::late)) add("with --hops quiet a frame ends when all have arrived");
    if (lost_for(report::Cause::no_bloom)) add("--fit off keeps bloom");
    return text;
}

void print_summary(std::ostream& out, report::RunReport const& run)
{
    print_header(out, run);
    if (run.frames.size() > 1) {
        print_sequence(out, run);
        if (std::any_of(run.frames.begin(), run.frames.end(), [](auto const& frame) { return frame.photograph.has_value(); }))
            print_photographs(out, run);
    }
    print_frame(out, run, run.frames.back());
}

} // namespace render_map
