#pragma once
#include "rows.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <common/statistics.hpp>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <ostream>
#include <set>
#include <string>
#include <string_view>
#include <tilemesh/number_text.hpp>
#include <vector>

namespace error_vs_time {

/// The settings that a user can select by name, in order of error.
inline constexpr std::array<std::string_view, 4> named_settings = {"evaluation", "default", "viewing", "on_sensor"};

using bench::fixed;
using bench::scientific;

/// The error by which settings are compared: the RMSE as the tables print it, with 4 significant digits. Sums of a million squares in
/// another order differ in the ninth digit; a difference that no reader can see must not decide.
inline double printed_error(Row const& row)
{
    return tilemesh::number_of<double>(scientific(row.total.rmse, 3)).value_or(NAN);
}
/// Modelled time in units of 1e-4 ms, as the tables and the CSV print it.
inline double printed_modelled(Row const& row)
{
    return std::round(1e4 * row.modelled_ms);
}
/// Is there a result to compare?
inline bool ran(Row const& row)
{
    return row.failed.empty() && !std::isnan(row.total.rmse);
}

/// The rows of one scene and camera, in the order given.
using Group = std::vector<Row const*>;
/// All groups, in the order in which they begin.
inline std::vector<Group> groups_of(std::vector<Row> const& rows)
{
    std::vector<Group> out;
    for (auto const& row : rows) {
        auto const same = [&](Group const& g) { return g.front()->scene == row.scene && g.front()->camera == row.camera; };
        auto const at = std::find_if(out.begin(), out.end(), same);
        if (at == out.end()) out.push_back({&row});
        else at->push_back(&row);
    }
    return out;
}
/// The first row with this setting, or null.
inline Row const* find(Group const& group, std::string_view setting)
{
    auto const at = std::find_if(group.begin(), group.end(), [&](Row const* r) { return r->setting.name == setting; });
    return at == group.end() ? nullptr : *at;
}
inline bool is_named(Row const& row)
{
    return std::find(named_settings.begin(), named_settings.end(), row.setting.name) != named_settings.end();
}
inline bool is_sequence(Group const& group)
{
    return group.front()->frames > 1;
}

/// Sets on_front, on_front_modelled and front_pairs of every row. A row is Pareto-optimal (on a front) unless another row of its scene and
/// camera, rendered by the same program, costs less and has no larger error, or costs the same and has a smaller error. Costs are pairs and modelled time; the error is
/// `printed_error`. Equal rows are on the front together. front_pairs: the fewest pairs of a row whose error is not larger, divided by this
/// row's pairs. A row that failed is on no front and keeps no other row off it. Cost: n^2 comparisons per group.
inline void mark_fronts(std::vector<Row>& rows)
{
    struct Point {
        double error, pairs, modelled;
    };
    std::vector<Point> points;
    for (auto const& r : rows) points.push_back({printed_error(r), static_cast<double>(r.counters.pairs), printed_modelled(r)});
    auto const index = [&](Row const* r) { return static_cast<std::size_t>(r - rows.data()); };
    auto const comparable = [](Row const& a, Row const& b) { return ran(a) && ran(b) && a.setting.limits.homes == b.setting.limits.homes; };
    for (auto const& group : groups_of(rows)) {
        for (auto const* member : group) {
            auto& row = rows[index(member)];
            row.on_front = row.on_front_modelled = false;
            row.front_pairs = 1;
            if (!ran(row)) continue;
            auto const& mine = points[index(member)];
            auto const beaten = [&](double Point::*cost) {
                return std::any_of(group.begin(), group.end(), [&](Row const* other) {
                    auto const& its = points[index(other)];
                    return comparable(row, *other) && ((its.*cost < mine.*cost && its.error <= mine.error) ||
                                           (its.*cost == mine.*cost && its.error < mine.error));
                });
            };
            row.on_front = !beaten(&Point::pairs);
            row.on_front_modelled = !beaten(&Point::modelled);
            double fewest = mine.pairs;
            for (auto const* other : group)
                if (comparable(row, *other) && points[index(other)].error <= mine.error) fewest = std::min(fewest, points[index(other)].pairs);
            if (mine.pairs > 0) row.front_pairs = fewest / mine.pairs;
        }
    }
}

/// A median, and the band that leaves out equally many values at both ends.
struct Band {
    double median, low, high; ///< NaN if there are no values
};
/// The band from `quantile` (0 to 0.5) to 1 - quantile by nearest rank, rounded outward: the ceil(quantile n)-th value from either end.
inline Band band_of(std::vector<double> values, double quantile)
{
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    if (values.empty()) return {none, none, none};
    std::sort(values.begin(), values.end());
    auto const n = values.size();
    auto const from_end = std::max<std::size_t>(static_cast<std::size_t>(std::ceil(quantile * static_cast<double>(n) - 1e-9)), 1) - 1;
    return {(values[(n - 1) / 2] + values[n / 2]) / 2, values[from_end], values[n - 1 - from_end]};
}

/// With fewer rounds there is no claim. If rounds are independent, three ratios of equal settings are all farther from 1 than ten others,
/// and on the same side, once in 4 C(13, 3) = 1,144 times. A map has about a hundred settings.
inline constexpr std::size_t fewest_rounds_of_a_claim = 3, fewest_rounds_of_noise = 10;

/// The noise of a scene: the largest distance from 1 in the middle 90 % of its default's time over itself. Infinite if there are too few
/// rounds.
inline double noise_of(std::vector<Noise> const& noise, std::string_view scene)
{
    double most = -1;
    for (auto const& n : noise) {
        if (n.scene != scene || n.ratios.size() < fewest_rounds_of_noise) continue;
        auto const band = band_of(n.ratios, 0.05);
        most = std::max({most, std::fabs(band.low - 1), std::fabs(band.high - 1)});
    }
    return most < 0 ? std::numeric_limits<double>::infinity() : most;
}

/// The claim about a setting's host time relative to the default's.
struct Claim {
    double ratio, low, high; ///< median and the middle 60 %; NaN if there are no times
    bool faster, slower;     ///< both false: no claim
};
/// Claims "faster" or "slower" only if the whole middle 60 % of the ratios lie beyond 1 -+ noise.
inline Claim claim_of(std::vector<double> const& over_default, double noise)
{
    auto const band = band_of(over_default, 0.2);
    bool const enough = over_default.size() >= fewest_rounds_of_a_claim;
    return {band.median, band.low, band.high, enough && band.high < 1 - noise, enough && band.low > 1 + noise};
}
inline Claim claim_of(Row const& row, std::vector<Noise> const& noise)
{
    return claim_of(row.failed.empty() ? row.over_default : std::vector<double>{}, noise_of(noise, row.scene));
}
inline char const* to_string(Claim const& claim)
{
    return claim.faster ? "faster" : claim.slower ? "slower" : "no claim";
}

/// The conditions that must hold of a report.
struct Verdict {
    std::vector<std::string> broken; ///< conditions that do not hold
    std::vector<std::string> notes;  ///< the same for sequences, for which nothing is promised
    bool holds() const noexcept { return broken.empty(); }

    /// "BROKEN: ..." and "note: ...", one line each; "All that must hold does." if nothing is broken.
    friend std::ostream& operator<<(std::ostream& out, Verdict const& verdict)
    {
        for (auto const& text : verdict.notes) out << "note: " << text << "\n";
        for (auto const& text : verdict.broken) out << "BROKEN: " << text << "\n";
        return out << (verdict.holds() ? "All that must hold does.\n" : "");
    }
};

namespace detail {

inline std::string called(Row const& row)
{
    return row.scene + ", " + row.camera + ", " + row.setting.name;
}
/// The name of a number that is not finite, or null. A PSNR may be infinite: the pictures are equal.
inline char const* not_finite(Row const& r)
{
    for (auto const* m : {&r.total, &r.cut, &r.round, &r.mesh}) {
        for (auto const v : {m->rmse, m->max_levels, m->p999_levels, m->ssim, m->mae, m->share_over_one_level})
            if (!std::isfinite(v)) return "an error measure";
        if (std::isnan(m->psnr_db) || m->psnr_db == -std::numeric_limits<double>::infinity()) return "a PSNR";
    }
    for (auto const v : {r.twice_products, r.split_off})
        if (!std::isfinite(v)) return "the split of the error";
    if (!std::isfinite(r.certified_levels)) return "the certificate";
    if (!std::isfinite(r.popping)) return "the popping";
    if (!std::isfinite(r.modelled_ms)) return "the modelled time";
    for (auto const* times : {&r.host_ms, &r.over_default})
        for (auto const v : *times)
            if (!std::isfinite(v)) return "a host time";
    return std::isfinite(r.front_pairs) ? nullptr : "front_pairs";
}

} // namespace detail

/// Checks the conditions that must hold. Call `mark_fronts(rows)` first.
/// 1. If nothing is lost, late or unplaced, the mesh's picture is that of the whole frame, bit for bit.
/// 2. The parts of the error add up to 1e-9 of its square. A sum of millions of terms in double is accurate to 1e-12 or better.
/// 3. No setting of the same view and program has at most 90 % of the default's pairs and no larger error.
/// 4. The default and the named settings are within 2 % of the front by pairs.
/// 5. Every group has a default, and no setting twice.
/// 6. All numbers are finite, except the PSNR of equal pictures.
/// For sequences, violations of 3 and 4 are notes, because their error is the worst frame's and their pairs are the last frame's.
inline Verdict verdict_of(std::vector<Row> const& rows)
{
    using detail::called;
    Verdict out;
    for (auto const& r : rows) {
        if (!r.failed.empty()) continue;
        if (r.mesh_wrong || (r.complete() && r.mesh.max_levels != 0))
            out.broken.push_back(called(r) + ": nothing is missing, but the mesh's picture is not the whole frame's (off by " +
                                 scientific(r.mesh.max_levels, 3) + " levels in the worst)");
        if (!(r.split_off <= 1e-9))
            out.broken.push_back(called(r) + ": the split does not add up (off by " + scientific(r.split_off, 3) +
                                 " of the squared error)");
        if (auto const* what = detail::not_finite(r)) out.broken.push_back(called(r) + ": " + what + " is not finite");
    }
    for (auto const& group : groups_of(rows)) {
        auto const where = group.front()->scene + ", " + group.front()->camera;
        std::set<std::string> names;
        for (auto const* r : group)
            if (!names.insert(r->setting.name).second) out.broken.push_back(called(*r) + ": the name is there twice");
        auto& said = is_sequence(group) ? out.notes : out.broken;
        for (auto const name : named_settings) {
            auto const* r = find(group, name);
            if (r == nullptr) continue;
            if (!ran(*r)) {
                out.broken.push_back(called(*r) + ": a named setting has no result (" + r->failed + ")");
            } else if (!(r->front_pairs >= 0.98)) {
                said.push_back(called(*r) + ": " + fixed(100 * r->front_pairs, 1) +
                               " % of its pairs reach its error; a named setting is to be within 2 % of the front");
            }
        }
        auto const* standard = find(group, "default");
        if (standard == nullptr) out.broken.push_back(where + ": there is no default to compare with");
        if (standard == nullptr || !ran(*standard)) continue;
        for (auto const* r : group)
            if (ran(*r) && !r->setting.limits.homes && standard->counters.pairs > 0 && 10 * r->counters.pairs <= 9 * standard->counters.pairs &&
                printed_error(*r) <= printed_error(*standard))
                said.push_back(called(*r) + ": has " +
                               fixed(100 * static_cast<double>(r->counters.pairs) / static_cast<double>(standard->counters.pairs), 1) +
                               " % of the default's pairs and no larger error (" + scientific(r->total.rmse, 3) + " against " +
                               scientific(standard->total.rmse, 3) + "): the default has to change");
    }
    return out;
}

} // namespace error_vs_time
