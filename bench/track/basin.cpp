#include "track.hpp"
#include <algorithm>
#include <cmath>
#include <common/statistics.hpp>
#include <glm/geometric.hpp>
#include <iostream>
#include <tilemesh/report/table.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <tilemesh/track/pose_solver.hpp>
#include <tilemesh/track/pose_update.hpp>
#include <tilemesh/track/spoil.hpp>

namespace track_bench {

namespace {

using bench::fixed;
constexpr double degree = 3.14159265358979323846 / 180.0;

track::Method method_of(std::string const& name)
{
    return name == "hybrid" ? track::Method::hybrid : name == "forward" ? track::Method::forward : name == "gradient" ? track::Method::gradient : track::Method::esm;
}

/// A direction, uniform on the sphere. Number `use` of trial `trial`.
glm::dvec3 direction(std::uint64_t trial, std::uint64_t use)
{
    double const z = 2 * static_cast<double>(track::random_bits(7, trial, use, 0) >> 11) * 0x1p-53 - 1, turn = 2 * 180 * degree * static_cast<double>(track::random_bits(7, trial, use, 1) >> 11) * 0x1p-53;
    double const r = std::sqrt(std::max(0.0, 1 - z * z));
    return {r * std::cos(turn), r * std::sin(turn), z};
}
/// The pose turned by `degrees` about a random axis, and moved by so many percent of the median depth in a random direction.
scene::Pose disturbed(scene::Pose const& pose, double degrees, double scale, std::uint64_t trial)
{
    auto out = track::moved(pose, {{}, degrees * degree * direction(trial, 0)});
    out.position += degrees / 100 * scale * direction(trial, 1);
    return out;
}

/// The results of some starts.
struct Row {
    std::string scene, method;
    bool depth, exposure;
    std::uint32_t coarsest, one_in;
    double degrees; ///< the error of the start; as many percent of the median depth
    std::uint32_t trials = 0, fine = 0, near = 0;
    std::vector<double> evaluations, degrees_off, shift_off; ///< evaluations: of the fine ones, or of all spoilt ones
};

/// Starts off by `row.degrees`, and adds the result to the row.
void try_start(Evaluator& evaluate, View const& view, Asked asked, std::uint32_t trial, Row& row)
{
    auto const truth = scene::pose_of(view.camera);
    asked.seed = trial;
    evaluate.ask(asked);
    auto const found = track::solve_pose(evaluate, disturbed(truth, row.degrees, view.scale, trial), scene::lens_of(view.camera), view.scale,
                                         track::stages_of(method_of(row.method), row.coarsest));
    double const turn = glm::length(track::twist_between(truth, found.pose).phi) / degree;
    double const shift = glm::length(found.pose.position - truth.position) / view.scale;
    bool const fine = turn < 1e-3 && shift < 1e-4;
    row.fine += fine;
    row.near += turn < 0.05 && shift < 1e-3;
    if (fine || row.exposure) row.evaluations.push_back(found.evaluations);
    row.degrees_off.push_back(turn);
    row.shift_off.push_back(shift);
}
Row run(Evaluator& evaluate, View const& view, std::string const& name, std::string const& method, Asked const& asked, std::uint32_t coarsest, double degrees, std::uint32_t trials)
{
    Row row{name, method, asked.depth, asked.exposure, coarsest, asked.one_in, degrees, trials, 0, 0, {}, {}, {}};
    for (std::uint32_t trial = 0; trial < trials; ++trial) try_start(evaluate, view, asked, trial, row);
    return row;
}

std::string most(std::vector<double> const& v)
{
    return v.empty() ? "-" : bench::scientific(*std::max_element(v.begin(), v.end()), 1);
}

class Tables {
public:
    explicit Tables(Options const& options) : options_(options) {}

    void clean(std::string const& name, View const& view, Evaluator& evaluate)
    {
        evaluate.set_target(view.colour, view.depth);
        if (bench::chosen(options_.tables, "basin"))
            for (std::string const method : method_names) {
                if (!bench::chosen(options_.methods, method)) continue;
                for (bool const depth : {true, false})
                    for (std::uint32_t const coarsest : {8u, 1u})
                        for (double const degrees : {0.5, 1.0, 2.0, 5.0, 10.0}) {
                            if (coarsest == 1 && (!depth || method == "hybrid" || options_.quick)) continue; // hybrid on one level is forward
                            if (options_.quick && degrees < 5) continue;
                            add(basin_, run(evaluate, view, name, method, {depth, false, 1, 0}, coarsest, degrees, options_.trials));
                        }
            }
        if (bench::chosen(options_.tables, "subsets"))
            for (std::string const method : {"forward", "hybrid"})
                for (std::uint32_t const one_in : {4u, 10u, 64u})
                    for (double const degrees : {1.0, 5.0}) {
                        if (!bench::chosen(options_.methods, method)) continue;
                        add(basin_, run(evaluate, view, name, method, {true, false, one_in, 0}, degrees < 2 ? 1 : 4, degrees, options_.trials));
                    }
    }
    void spoilt(std::string const& name, View const& view, Evaluator& evaluate)
    {
        if (!bench::chosen(options_.tables, "spoilt")) return;
        for (std::string const method : method_names) {
            if (!bench::chosen(options_.methods, method)) continue;
            for (bool const depth : {true, false}) {
                Row all{name, method, depth, true, 4, 1, 2.0, 0, 0, 0, {}, {}, {}};
                for (std::uint32_t frame = 0; frame < options_.trials; ++frame) {
                    auto colour = view.colour;
                    auto plane = view.depth;
                    track::spoil(colour, plane, frame, {});
                    evaluate.set_target(std::move(colour), std::move(plane));
                    ++all.trials;
                    try_start(evaluate, view, {depth, true, 1, 0}, frame, all);
                }
                std::cerr << name << " " << method << "\n";
                spoilt_.push_back(std::move(all));
            }
        }
    }
    int finish()
    {
        std::vector<std::string> broken;
        if (!basin_.empty()) {
            tilemesh::report::Table table{{"scene", "method", "rows", "cells", "one block in", "start: degrees, % of depth", "to 1e-3 degrees, 1e-4", "to 0.05, 1e-3", "evaluations", "median degrees", "most"}};
            std::string csv = "scene,method,depth,coarsest,one_in,degrees,trials,fine,near,evaluations,worst_degrees\n";
            for (auto const& r : basin_) {
                table.add_row({r.scene, r.method, r.depth ? "RGB+D" : "RGB", std::to_string(r.coarsest) + " to 1",
                               std::to_string(r.one_in), fixed(r.degrees, 1),
                               std::to_string(r.fine) + " of " + std::to_string(r.trials), std::to_string(r.near),
                               r.evaluations.empty() ? "-" : fixed(bench::median(r.evaluations), 0),
                               bench::scientific(bench::median(r.degrees_off), 1), most(r.degrees_off)});
                csv += r.scene + "," + r.method + "," + (r.depth ? "1" : "0") + "," + std::to_string(r.coarsest) + "," + std::to_string(r.one_in) + "," + fixed(r.degrees, 1) + "," + std::to_string(r.trials) + "," + std::to_string(r.fine) + "," +
                       std::to_string(r.near) + "," + fixed(bench::median(r.evaluations), 1) + "," + most(r.degrees_off) + "\n";
                // What the hybrid method is for.
                bool const own_map = r.scene != "built_in"; // from 10 degrees it has other minima: README.md
                std::uint32_t const least = r.degrees > 5 ? (r.depth && own_map ? 18 : 0) : r.degrees == 5 && !r.depth ? 18 : 20;
                if (r.method == "hybrid" && r.coarsest == 8 && r.one_in == 1 && 20 * r.fine < least * r.trials)
                    broken.push_back(r.scene + " from " + fixed(r.degrees, 1) + " degrees, " + (r.depth ? "RGB+D" : "RGB") + ": " + std::to_string(r.fine) + " of " + std::to_string(r.trials));
            }
            std::cout << "Starts off by so many degrees, and as many percent of the median depth\n" << table << "\n";
            if (!options_.csv.empty()) tilemesh::report::write_whole(options_.csv, csv);
        }
        if (!spoilt_.empty()) {
            tilemesh::report::Table table{{"scene", "method", "rows", "evaluations", "degrees, median", "most", "of the depth, median", "most"}};
            for (auto const& r : spoilt_) {
                table.add_row({r.scene, r.method, r.depth ? "RGB+D" : "RGB", fixed(bench::median(r.evaluations), 0),
                               bench::scientific(bench::median(r.degrees_off), 1), most(r.degrees_off),
                               bench::scientific(bench::median(r.shift_off), 1), most(r.shift_off)});
                double const limit = r.depth ? 6e-3 : 9e-3;
                if (r.trials >= 10 && (r.method == "forward" || r.method == "hybrid") && !(bench::median(r.degrees_off) < limit))
                    broken.push_back(r.scene + ", spoilt, " + r.method + ", " + (r.depth ? "RGB+D" : "RGB") + ": " +
                                     bench::scientific(bench::median(r.degrees_off), 1) + " degrees");
            }
            std::cout << "Spoilt targets, starts off by 2 degrees and 2 %, 8 unknowns, cells 4 to 1\n" << table << "\n";
        }
        return bench::verdict(broken, "");
    }

private:
    static void add(std::vector<Row>& rows, Row row)
    {
        std::cerr << row.scene << " " << row.method << (row.depth ? " RGB+D " : " RGB ") << row.coarsest << " 1/" << row.one_in << " " << row.degrees << ": " << row.fine << " of " << row.trials << "\n";
        rows.push_back(std::move(row));
    }
    Options const& options_;
    std::vector<Row> basin_, spoilt_;
};

} // namespace

int basin(Options const& options)
{
    bench::expect_folder_of(options.csv);
    Tables tables(options);
    for (auto const& name : scenes_of(options)) {
        auto view = load_view(name, options.data, {160, 90});
        if (options.spoil) std::reverse(view.colour.rgb.begin(), view.colour.rgb.end()), std::reverse(view.depth.values.begin(), view.depth.values.end());
        auto const evaluate = make_evaluator(view, 1, On::roomy);
        tables.clean(name, view, *evaluate);
        tables.spoilt(name, view, *evaluate);
    }
    return tables.finish();
}

} // namespace track_bench
