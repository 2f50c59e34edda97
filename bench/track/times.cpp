#include "track.hpp"
#include <cmath>
#include <common/machine.hpp>
#include <common/statistics.hpp>
#include <iostream>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/cost_table.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/splat/setup_types.hpp>
#include <tilemesh/track/pose_solver.hpp>
#include <tilemesh/track/pose_update.hpp>
#include <utility>
#include <vector>

namespace track_bench {

namespace {

using bench::fixed;
using tilemesh::report::thousands;

scene::Size size_of(Options const& options)
{
    return options.quick ? scene::Size{320, 240} : scene::Size{640, 480};
}

/// The k-th of some poses within 0.2 degrees and 0.2 % of the depth: the steps of a solver that is near.
splat::Camera near(View const& view, std::uint32_t k)
{
    double const a = 2.4 * k, small = 0.0035;
    return scene::make_camera(track::moved(scene::pose_of(view.camera), {0.002 * view.scale * glm::dvec3{std::sin(a), std::cos(a), std::sin(2 * a)}, small * glm::dvec3{std::cos(2 * a), std::sin(3 * a), std::cos(a)}}),
                              scene::lens_of(view.camera));
}
/// The two cameras of a central difference by motion `j`.
std::pair<splat::Camera, splat::Camera> beside(View const& view, splat::Camera const& camera, std::uint32_t j)
{
    auto const moved = [&](double step) {
        track::Twist twist{};
        (j < 3 ? twist.rho : twist.phi)[static_cast<int>(j % 3)] = step * (j < 3 ? view.scale : 1.0);
        return scene::make_camera(track::moved(scene::pose_of(camera), twist), scene::lens_of(camera));
    };
    return {moved(1e-4), moved(-1e-4)};
}

struct Kind {
    char const* name;
    track::Level level;
    Asked asked;
};
Kind const kinds[] = {
    {"forward", {1, track::Jacobian::forward, {}}, {false, false, 1, 0}},
    {"forward, depth", {1, track::Jacobian::forward, {}}, {true, false, 1, 0}},
    {"forward, depth, one block in 10", {1, track::Jacobian::forward, {}}, {true, false, 10, 0}},
    {"forward, depth, cells of 4", {4, track::Jacobian::forward, {}}, {true, false, 1, 0}},
    {"gradient, depth", {1, track::Jacobian::gradient, {}}, {true, false, 1, 0}},
    {"ESM, depth", {1, track::Jacobian::esm, {}}, {true, false, 1, 0}},
};

} // namespace

void times(Options const& options)
{
    tilemesh::report::Table table{{"scene", "threads", "what", "ms", "over a plain frame", "13 renders over it"}};
    for (auto const& name : scenes_of(options)) {
        auto const view = load_view(name, options.data, size_of(options));
        for (std::uint32_t const threads : {1u, 2u}) {
            auto const evaluate = make_evaluator(view, threads, On::mk2);
            evaluate->set_target(view.colour, view.depth);
            auto const setup = tilemesh::splat::setup_of<splat::Lossless>();
            tilemesh::RendererOptions renders;
            renders.threads = threads;
            renders.tile = evaluate->tile();
            renders.arithmetic = splat::Arithmetic::precise; // as forward mode
            auto const machine = bench::make_machine(view.map, setup, renders);
            constexpr std::size_t n = std::size(kinds);
            std::vector<double> plain, differences, ms[n], over[n], gain[n], frame_ms[2], evaluations[2];
            for (std::uint32_t round = 0; round < options.rounds + 1; ++round) {
                auto const camera = near(view, round);
                bench::Stopwatch watch;
                machine->render(camera);
                double const one = watch.lap();
                for (std::uint32_t j = 0; j < 6; ++j) {
                    auto const [up, down] = beside(view, camera, j);
                    machine->render(up);
                    machine->render(down);
                }
                double const thirteen = one + watch.lap();
                if (round != 0) plain.push_back(one), differences.push_back(thirteen);
                for (std::size_t k = 0; k < n; ++k) {
                    evaluate->ask(kinds[k].asked);
                    (void)(*evaluate)(near(view, round + 5), kinds[k].level); // so that the view changes
                    watch.lap();
                    (void)(*evaluate)(camera, kinds[k].level);
                    double const t = watch.lap();
                    if (round != 0) ms[k].push_back(t), over[k].push_back(t / one), gain[k].push_back(thirteen / t);
                }
                for (int k = 0; k < 2; ++k) { // a frame: from a pose nearby to the view's own
                    evaluate->ask({true, false, 1, 0});
                    watch.lap();
                    auto const found = track::solve_pose(*evaluate, scene::pose_of(camera), scene::lens_of(view.camera), view.scale,
                                                         track::stages_of(k == 0 ? track::Method::hybrid : track::Method::esm, 4));
                    if (round != 0) frame_ms[k].push_back(watch.lap()), evaluations[k].push_back(found.evaluations);
                }
            }
            auto const row = [&](std::string const& what, std::vector<double> const& t, std::string const& ratio, std::string const& faster) {
                table.add_row({name, std::to_string(threads), what, fixed(bench::median(t), 1), ratio, faster});
            };
            row("a plain frame", plain, "1", "");
            row("13 renders", differences, fixed(bench::median(differences) / bench::median(plain), 1), "1");
            for (std::size_t k = 0; k < n; ++k) row(kinds[k].name, ms[k], fixed(bench::median(over[k]), 1), fixed(bench::median(gain[k]), 1));
            row("a frame by hybrid, " + fixed(bench::median(evaluations[0]), 0) + " evaluations", frame_ms[0], "", "");
            row("a frame by ESM, " + fixed(bench::median(evaluations[1]), 0) + " evaluations", frame_ms[1], "", "");
            std::cerr << name << " " << threads << "\n";
        }
    }
    auto const size = size_of(options);
    std::cout << "Host times at " << size.width << " x " << size.height << ", medians of " << options.rounds << " rounds in which all take turns\n" << table << "\n";
}

void modelled(Options const& options)
{
    auto const model = tilemesh::mk2();
    for (auto const& name : scenes_of(options)) {
        auto const view = load_view(name, options.data, size_of(options));
        auto const evaluate = make_evaluator(view, 1, On::mk2_traced);
        evaluate->set_target(view.colour, view.depth);
        for (auto const& kind : kinds) {
            evaluate->ask(kind.asked);
            (void)(*evaluate)(near(view, 1), kind.level);
            (void)(*evaluate)(near(view, 2), kind.level);
            std::cout << "Modelled on Mk2: " << name << ", " << view.camera.width << " x " << view.camera.height << ", " << kind.name << ", a step of 0.3 degrees; at most " << thousands(evaluate->most_stored()) << " of " << thousands(evaluate->slots()) << " slots of a tile are in use\n"
                      << tilemesh::cost_table(model, evaluate->trace(), tilemesh::model_cost(model, evaluate->trace(), evaluate->grid())) << "\n";
        }
    }
}

} // namespace track_bench
