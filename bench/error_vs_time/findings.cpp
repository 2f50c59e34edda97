#include "findings.hpp"
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <ostream>
#include <tilemesh/report/table.hpp>

namespace error_vs_time {

namespace {

using report::Table;
using report::thousands;

double over(double value, double standard)
{
    return standard > 0 ? value / standard : std::numeric_limits<double>::quiet_NaN();
}
double pairs_of(Row const& row)
{
    return static_cast<double>(row.counters.pairs);
}
std::string ratio(double value)
{
    return std::isnan(value) ? "-" : fixed(value, value < 10 ? 3 : 1);
}
std::string percent(double share)
{
    return share == 0 ? "0" : share < 0.00005 ? "< 0.01 %" : fixed(100 * share, 2) + " %";
}
/// Shows 0 as "0": the pictures are equal.
std::string error_of(double rmse)
{
    return rmse == 0 ? "0" : scientific(rmse, 3);
}
/// The median of host time relative to the default's, its band, and the claim that they allow.
std::string host(Row const& row, std::vector<Noise> const& noise)
{
    auto const claim = claim_of(row, noise);
    if (std::isnan(claim.ratio)) return "-";
    if (row.setting.name == "default") return "1";
    return to_string(claim) + std::string(" ") + fixed(claim.ratio, 2) + " (" + fixed(claim.low, 2) + "-" + fixed(claim.high, 2) + ")";
}

/// The rows that ran and are named or on the front by pairs, by number of pairs. Of equal numbers, the row with the smaller error comes
/// first.
Group shown(Group const& group)
{
    Group out;
    for (auto const* r : group)
        if (ran(*r) && (r->on_front || is_named(*r))) out.push_back(r);
    std::stable_sort(out.begin(), out.end(), [](Row const* a, Row const* b) {
        return a->counters.pairs != b->counters.pairs ? a->counters.pairs < b->counters.pairs : printed_error(*a) < printed_error(*b);
    });
    return out;
}

std::string title_of(Group const& group)
{
    auto const& r = *group.front();
    auto const have = std::count_if(group.begin(), group.end(), [](Row const* row) { return ran(*row); });
    return r.scene + ", " + r.camera + ": " + thousands(r.gaussians) + " Gaussians, " + std::to_string(r.size.width) + " x " +
           std::to_string(r.size.height) + (r.frames > 1 ? ", " + std::to_string(r.frames) + " frames (errors of the worst)" : "") + "; " +
           std::to_string(have) + " of " + std::to_string(group.size()) + " settings have a result";
}

void print_group(std::ostream& out, Group const& group, std::vector<Noise> const& noise)
{
    out << "\n" << title_of(group) << "\n"
        << "front: yes where no other of these settings has fewer pairs and no larger error; else the share of the pairs that does it\n";
    auto const* standard = find(group, "default");
    bool const sequence = is_sequence(group);
    Table table{{"setting", "front", "pairs", "over default", "RMSE", "PSNR, dB", "max levels", "certified", "p99.9", "> 1 level", "E_cut", "E_round",
                 "E_mesh max", "modelled ms", sequence ? "popping" : "host over default"}};
    for (auto const* r : shown(group))
        table.add_row({r->setting.name, r->on_front ? "yes" : fixed(r->front_pairs, 3), thousands(r->counters.pairs),
                       standard != nullptr && ran(*standard) ? ratio(over(pairs_of(*r), pairs_of(*standard))) : "-",
                       error_of(r->total.rmse),
                       fixed(r->total.psnr_db, 2), fixed(r->total.max_levels, 2), sequence ? "-" : fixed(r->certified_levels + 0.005, 2), fixed(r->total.p999_levels, 2),
                       percent(r->total.share_over_one_level), error_of(r->cut.rmse), error_of(r->round.rmse),
                       r->mesh.max_levels == 0 ? "0" : fixed(r->mesh.max_levels, 2), fixed(r->modelled_ms, 4),
                       sequence ? error_of(r->popping) : host(*r, noise)});
    out << table;
    if (sequence) return;
    auto const band = noise_of(noise, group.front()->scene);
    if (std::isinf(band))
        out << "Host time: the default was not measured against itself " << fewest_rounds_of_noise
            << " times or more, so nothing is claimed.\n";
    else
        out << "Host time: the default against itself is off by up to " << fixed(100 * band, 1)
            << " % (middle 90 % of the rounds); a claim needs the middle 60 % of a setting's rounds beyond that.\n";
}

void print_missing(std::ostream& out, std::vector<Row> const& rows)
{
    for (auto const& r : rows) {
        if (!r.failed.empty()) out << "failed: " << detail::called(r) << ": " << r.failed << "\n";
        else if (!ran(r)) out << "failed: " << detail::called(r) << ": the error is not a number\n";
    }
    for (auto const& r : rows) {
        if (!r.failed.empty() || r.complete()) continue;
        std::string what;
        auto const add = [&](std::uint64_t n, char const* name) {
            if (n != 0) what += (what.empty() ? "" : ", ") + thousands(n) + " " + name;
        };
        add(r.lost, "lost"), add(r.late, "late"), add(r.unplaced, "unplaced");
        out << "incomplete: " << detail::called(r) << ": " << what << " (E_mesh " << error_of(r.mesh.rmse) << " RMSE, "
            << fixed(r.mesh.max_levels, 2) << " levels)\n";
    }
}

} // namespace

void print_tables(std::ostream& out, std::vector<Row> const& rows, std::vector<Noise> const& noise,
                  std::vector<std::string> const& skipped, std::vector<std::string> const& standing)
{
    for (auto const& group : groups_of(rows)) print_group(out, group, noise);
    out << "\nOmissions and failures\n";
    print_missing(out, rows);
    for (auto const& text : skipped) out << "skipped: " << text << "\n";
    for (auto const& text : standing) out << "left out: " << text << "\n";
    bool const all = std::all_of(rows.begin(), rows.end(), [](Row const& r) { return ran(r) && r.complete(); });
    if (all && skipped.empty() && standing.empty()) out << "none\n";
}

} // namespace error_vs_time
