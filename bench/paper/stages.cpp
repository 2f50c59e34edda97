#include "prototype_parameters.hpp"
#include "prototype_run.hpp"
#include "tables.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <common/scenes.hpp>
#include <filesystem>
#include <sstream>
#include <string>
#include <tilemesh/report/whole_file.hpp>
#include <vector>

namespace paper {

namespace {

using tilemesh::CostModel;

/// A line of the paper's stage table, in milliseconds. It has no minimum and mean of Blend: that is the slowest tile by the host's clock.
struct Timed {
    char const* scene;
    double blend;
    OverTiles route, projection, sort;
    double total;
};
constexpr Timed paper_salad = {"Salad", 16.66, {1.48, 4.14, 14.22}, {3.07, 3.95, 11.61}, {0.00, 0.26, 3.37}, 45.86};
constexpr Timed paper_sloth = {"Sloth", 16.15, {1.48, 2.71, 13.70}, {3.04, 3.41, 11.15}, {0.00, 0.12, 3.40}, 44.40};
constexpr Timed paper_chairs = {"Chairs", 15.76, {1.60, 6.82, 16.06}, {3.10, 4.41, 11.73}, {0.00, 0.40, 3.86}, 47.41};
constexpr Timed paper_pringles = {"Pringles", 17.16, {1.48, 3.72, 14.11}, {3.06, 3.81, 11.57}, {0.00, 0.24, 3.75}, 46.59};
constexpr double paper_exchange_ms = 0.07;
constexpr double within = 0.25; ///< a hit is within this share of the paper's figure

/// The data that a price must explain: paper = fixed + price * count, in milliseconds.
struct Explained {
    double paper, fixed, count;
};
/// The price that minimises the sum of the squared logarithms of model over paper. A model that is too high by a factor weighs as much as
/// one that is too low by it. The sum has one minimum, between the prices that explain the single figures.
double fitted_price(std::vector<Explained> const& figures)
{
    double low = INFINITY, high = 0;
    for (auto const& f : figures) {
        double const alone = (f.paper - f.fixed) / f.count;
        low = std::min(low, alone);
        high = std::max(high, alone);
    }
    auto const slope = [&](double price) {
        double sum = 0;
        for (auto const& f : figures) {
            double const model = f.fixed + price * f.count;
            sum += std::log(model / f.paper) * f.count / model;
        }
        return sum;
    };
    for (int i = 0; i < 200; ++i) {
        double const middle = 0.5 * (low + high);
        (slope(middle) > 0 ? high : low) = middle;
    }
    return 0.5 * (low + high);
}

/// Milliseconds per operation, for the kinds that `mk2_prototype` prices.
struct Prices {
    double slot, routed, projection, waiting, comparison, pair;
};

/// The mean and the slowest tile of a stage, averaged over frames, at a price of what it counts and one of a waiting record.
OverTiles over_tiles(PrototypeRun const& run, std::size_t stage, double fixed, double price, double waiting)
{
    auto const& counted = run.counted_each[stage];
    auto const& looked = run.waiting_each[stage];
    OverTiles out;
    double frames = 0;
    for (std::size_t at = 0; at < counted.size(); at += run.tiles, ++frames) {
        double sum = 0, most = 0;
        for (std::size_t i = at; i < at + run.tiles; ++i) {
            double const time = fixed + price * static_cast<double>(counted[i]) + waiting * static_cast<double>(looked[i]);
            sum += time;
            most = std::max(most, time);
        }
        out.mean += sum / run.tiles;
        out.most += most;
    }
    out.mean /= frames;
    out.most /= frames;
    return out;
}
/// The prices of an arrival, a projection and a waiting record that minimise the sum of the squared logarithms of model over paper of four
/// figures: mean and slowest tile of Route and of Projection. A search by halved steps, from prices of some thousand cycles.
std::array<double, 3> fitted_with_waiting(Timed const& p, PrototypeRun const& run, double slot)
{
    auto const square = [](double model, double paper) { return std::log(model / paper) * std::log(model / paper); };
    auto const loss = [&](std::array<double, 3> const& logs) {
        double const waiting = std::exp(logs[2]);
        auto const route = over_tiles(run, 0, slot * run.slots[0], std::exp(logs[0]), waiting);
        auto const projection = over_tiles(run, 1, slot * run.slots[1], std::exp(logs[1]), waiting);
        return square(route.mean, p.route.mean) + square(route.most, p.route.most) + square(projection.mean, p.projection.mean) +
               square(projection.most, p.projection.most);
    };
    std::array<double, 3> best = {std::log(slot * 4), std::log(slot * 2), std::log(slot / 100)};
    double least = loss(best);
    for (double step = 0.5; step > 1e-3;) {
        bool moved = false;
        for (std::size_t i = 0; i < best.size(); ++i)
            for (double const by : {-step, step}) {
                auto next = best;
                next[i] += by;
                if (auto const l = loss(next); l < least - 1e-12) {
                    least = l;
                    best = next;
                    moved = true;
                }
            }
        if (!moved) step /= 2;
    }
    return {std::exp(best[0]), std::exp(best[1]), std::exp(best[2])};
}

Prices fit(Timed const& p, PrototypeRun const& run)
{
    auto const& count = run.count;
    auto const slots = [&](Stage s) { return run.slots[index(s)]; };
    auto const at = [&](Stage s) { return count[index(s)]; };
    Prices out{};
    out.slot = fitted_price({{p.route.least, 0, slots(Stage::route)}, {p.projection.least, 0, slots(Stage::projection)}});
    auto const two = [](OverTiles const& paper, double fixed, OverTiles const& n) {
        return fitted_price({{paper.mean, fixed, n.mean}, {paper.most, fixed, n.most}});
    };
    auto const [routed, projection, waiting] = fitted_with_waiting(p, run, out.slot);
    out.routed = routed, out.projection = projection, out.waiting = waiting;
    out.comparison = two(p.sort, 0, at(Stage::sort));
    out.pair = fitted_price({{p.blend, 0, at(Stage::blend).most}});
    return out;
}

/// Compares figure by figure: ours, the paper's, and the prediction of a reader who only knows Salad's.
class Comparison {
public:
    Comparison(Rows& rows, Timed const& timed, bool fitted) : rows_(rows), scene_(timed.scene), fitted_(fitted) {}

    void add(std::string const& quantity, double paper, double ours, double null, bool counts, std::string note = {})
    {
        auto const off = [](double a, double b) { return std::fabs(a / b - 1); };
        bool const hit = off(ours, paper) <= within, null_hit = off(null, paper) <= within;
        if (!fitted_ && counts) {
            note = std::string(hit ? "hit" : "miss") + (note.empty() ? "" : "; " + note);
            ++wanted_;
            hits_ += hit ? 1 : 0;
            nearer_ += off(ours, paper) < off(null, paper) ? 1 : 0;
            if (!null_hit) {
                ++null_misses_;
                beaten_ += off(ours, paper) < off(null, paper) ? 1 : 0;
            }
        }
        rows_.push_back({"stage", scene_, quantity + " (ms)", paper, ours, fitted_ ? "fitted" : "predicted", std::move(note)});
        if (!fitted_ && counts)
            rows_.push_back({"stage", scene_, quantity + " (ms)", paper, null, "null model",
                             std::string(null_hit ? "hit" : "miss") + ": Sloth as Salad"});
    }
    /// `whole`: the run has so many frames that the verdict must be the one in the README.
    void verdict(bool whole)
    {
        rows_.push_back({"stage", scene_, "figures within 25 %, of " + std::to_string(wanted_), {}, static_cast<double>(hits_), "counted",
                         "Route, Projection and Sort: mean and max; Blend and Total: max", whole && hits_ != wanted_});
        rows_.push_back({"stage", scene_, "figures nearer than those of the null model, of " + std::to_string(wanted_), {}, static_cast<double>(nearer_),
                         "counted", {}, whole && nearer_ < 6});
        rows_.push_back({"stage", scene_, "misses of the null model where the prediction is nearer, of " + std::to_string(null_misses_), {},
                         static_cast<double>(beaten_), "counted", {}, whole && beaten_ != null_misses_});
    }

private:
    Rows& rows_;
    std::string scene_;
    bool fitted_;
    int wanted_ = 0, hits_ = 0, nearer_ = 0, null_misses_ = 0, beaten_ = 0;
};

void compare(Timed const& p, PrototypeRun const& run, bool fitted, bool whole, Rows& rows)
{
    Comparison out(rows, p, fitted);
    auto const of = [&](Stage s) { return run.milliseconds[index(s)]; };
    auto const ours = [&](std::string const& quantity, double ms, std::string note = {}) {
        rows.push_back({"stage", p.scene, quantity + " (ms)", {}, ms, fitted ? "fitted" : "predicted", std::move(note)});
    };
    auto const stage = [&](std::string const& name, OverTiles const& paper, OverTiles const& over, OverTiles const& null) {
        out.add(name + ", min", paper.least, over.least, null.least, false);
        out.add(name + ", mean", paper.mean, over.mean, null.mean, true);
        out.add(name + ", max", paper.most, over.most, null.most, true);
    };
    auto const& null = paper_salad;
    stage("Route", p.route, of(Stage::route), null.route);
    stage("Projection", p.projection, of(Stage::projection), null.projection);
    stage("Sort", p.sort, of(Stage::sort), null.sort);
    ours("Blend, min", of(Stage::blend).least);
    ours("Blend, mean", of(Stage::blend).mean);
    out.add("Blend, max", p.blend, of(Stage::blend).most, null.blend, true);
    OverTiles total;
    for (auto const& over : run.milliseconds) {
        total.least += over.least;
        total.mean += over.mean;
        total.most += over.most;
    }
    ours("Total, min", total.least, "sum of the stages' minima");
    ours("Total, mean", total.mean, "sum of the stages' means");
    out.add("Total, max", p.total, total.most, null.total, true, "sum of the stages' slowest tiles; a frame of the power table takes 50.55");
    rows.push_back({"stage", p.scene, "Total, max, if Route, Projection and Sort were converted at 1.85 GHz (ms)",
                    p.blend + (p.total - p.blend) * 1.85 / 1.325, p.blend + (total.most - of(Stage::blend).most) * 1.85 / 1.325, "arithmetic",
                    "the authors' code divides cycles by 1.85 GHz, and the paper states 1.325 GHz; Blend is timed on the host"});
    if (!fitted) out.verdict(whole);
    // Equal on every tile, because whole channel ends move.
    for (auto const* which : {"min", "mean"}) ours(std::string("Exchange, ") + which, run.exchange_ms);
    rows.push_back({"stage", p.scene, "Exchange, max (ms)", paper_exchange_ms, run.exchange_ms, "modelled",
                    "24,000 bytes from each side at 4 bytes a cycle; the paper timed a launch on the host, which is an upper bound, and "
                    "leaves it out of its Total"});
}

void counts(char const* scene, PrototypeRun const& run, Rows& rows)
{
    auto const add = [&](std::string const& what, double value) { rows.push_back({"stage", scene, what, {}, value, "counted"}); };
    static constexpr char const* names[stages_timed] = {"arrivals", "records projected", "comparisons", "pairs, six times the busiest worker's"};
    for (std::uint32_t s = 0; s < stages_timed; ++s) {
        add(std::string(names[s]) + " a tile, mean", run.count[s].mean);
        add(std::string(names[s]) + " a tile, most", run.count[s].most);
    }
    for (std::size_t s = 0; s < run.waiting.size(); ++s) {
        std::string const what = s == 0 ? "waiting records looked at, Route" : "waiting records looked at, Projection";
        add(what + ", a tile, mean", run.waiting[s].mean);
        add(what + ", a tile, most", run.waiting[s].most);
    }
    add("frames", run.frames);
    add("sends into a full channel, a frame", static_cast<double>(run.refused) / run.frames);
    add("arrivals without a free slot of storage, a frame", static_cast<double>(run.lost) / run.frames);
}

/// Do the model's numbers follow from this run of Salad? 1 % is allowed for the mathematics of other compilers.
void compare_parameters(Prices const& prices, CostModel const& model, bool whole, Rows& rows)
{
    auto const add = [&](char const* name, double price) {
        auto const stored = price_of(model, name);
        double const now = price * static_cast<double>(model.clock_khz) * 1000;
        rows.push_back({"stage", "parameters", std::string(name) + ", millicycles fitted to Salad", {}, now, "fitted",
                        "mk2_prototype has " + std::to_string(stored) + (whole ? "" : ", fitted to more frames than --quick runs"),
                        whole && !(std::fabs(now / static_cast<double>(stored) - 1) < 0.01)});
    };
    add("slot", prices.slot);
    add("routed", prices.routed);
    add("projection", prices.projection);
    add("waiting", prices.waiting);
    add("comparison", prices.comparison);
    add("pair", prices.pair);
}

/// Adds the paper's figures without ours.
void skip(Timed const& p, std::string const& why, Rows& rows)
{
    auto const add = [&](std::string const& quantity, double paper) {
        rows.push_back({"stage", p.scene, quantity + " (ms)", paper, {}, "predicted", "skipped: " + why});
    };
    auto const stage = [&](std::string const& name, OverTiles const& over) {
        add(name + ", min", over.least);
        add(name + ", mean", over.mean);
        add(name + ", max", over.most);
    };
    stage("Route", p.route);
    stage("Projection", p.projection);
    stage("Sort", p.sort);
    add("Blend, max", p.blend);
    add("Total, max", p.total);
}

bool has_stages_of(std::string const& scene, std::filesystem::path const& data)
{
    return bench::has_scene(scene, data) && std::filesystem::exists(data / "trajectories" / (scene + "_orbit.tum"));
}

} // namespace

void stages(Context const& context, Rows& rows)
{
    for (auto const* p : {&paper_chairs, &paper_pringles}) skip(*p, "its map is not public", rows);
    if (!has_stages_of("salad", context.data) || !has_stages_of("sloth", context.data)) {
        for (auto const* p : {&paper_salad, &paper_sloth}) skip(*p, "map, cameras or orbit of Salad and Sloth are not in --data", rows);
        return;
    }
    // Two orbits of 720 frames, over which the paper averages; quick: the first sixth of one orbit.
    PrototypePlan const plan{context.quick ? 120u : 1440u, 20, context.threads};
    auto const model = mk2_prototype();
    if (!context.out.empty())
        for (auto const& set : {tilemesh::mk2(), model}) {
            std::ostringstream text;
            tilemesh::write_cost_model(text, set);
            tilemesh::report::write_whole(context.out / (set.name + ".txt"), text.str());
        }
    auto const salad = run_prototype("salad", context.data, plan, model);
    compare_parameters(fit(paper_salad, salad), model, !context.quick, rows);
    compare(paper_salad, salad, true, !context.quick, rows);
    counts("Salad", salad, rows);
    auto const sloth = run_prototype("sloth", context.data, plan, model);
    compare(paper_sloth, sloth, false, !context.quick, rows);
    counts("Sloth", sloth, rows);
    rows.push_back({"stage", "Sloth", "Projection over Route, min", paper_sloth.projection.least / paper_sloth.route.least, 818.0 / 400, "arithmetic",
                    "scanned slots: 818 of storage over 400 of channels; with the paper's numbers of slots 3,218 / 1,600 = 2.01"});
}

} // namespace paper
