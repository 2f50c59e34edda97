#include "prefetch.hpp"
#include <algorithm>
#include <cmath>
#include <common/machine.hpp>
#include <common/statistics.hpp>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <numeric>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/naive.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/splat/setup_types.hpp>
#include <tilemesh/track/pose_update.hpp>
#include <utility>

namespace policies {

namespace {

namespace splat = tilemesh::splat;
namespace render = tilemesh::render;
using bench::fixed;
using tilemesh::report::thousands;
using tilemesh::report::Image;

bool same_bits(Image const& a, Image const& b)
{
    return a.rgb.size() == b.rgb.size() && std::memcmp(a.rgb.data(), b.rgb.data(), a.rgb.size() * sizeof(float)) == 0;
}

/// From a motion that is as expected to motions of which none is: a turn at constant velocity, a hand, a turn that always goes back, jumps.
constexpr char const* motion_names[] = {"orbit0.5", "fr1_xyz", "to and fro", "teleport"};
/// The cameras of one of these motions; none if there is no such file.
std::vector<splat::Camera> path_of(std::string const& motion, bench::Scene const& scene, std::uint32_t frames,
                                   std::filesystem::path const& data)
{
    if (motion == "to and fro") {
        auto cameras = bench::cameras_of("orbit0.5", scene, frames, data);
        for (std::size_t i = 2; i < cameras.size(); ++i) cameras[i] = cameras[i - 2];
        return cameras;
    }
    // On other maps `teleport` is an orbit in large steps, of constant velocity.
    bool const recorded = std::filesystem::exists(data / "trajectories" / (scene.map.name + "_teleport.tum"));
    if (!bench::has_motion(motion, data) || (motion == "teleport" && !recorded)) return {};
    return bench::cameras_of(motion, scene, frames, data);
}

/// The modelled time of a trace, and how even it is.
struct Modelled {
    double ms = 0, slowest_over_mean = 1;
};
Modelled modelled(tilemesh::Trace const& trace, tilemesh::Grid grid)
{
    static tilemesh::CostModel const model = tilemesh::mk2();
    Modelled m;
    if (trace.supersteps.empty()) return m;
    auto const cost = tilemesh::model_cost(model, trace, grid);
    std::uint64_t cycles = 0;
    for (auto const& s : cost.supersteps) cycles += s.total();
    m.ms = tilemesh::milliseconds(model, cycles);
    std::vector<std::uint64_t> busy(grid.size(), 0);
    for (auto const& step : cost.busy)
        for (std::size_t t = 0; t < step.size(); ++t) busy[t] += step[t];
    auto const sum = std::accumulate(busy.begin(), busy.end(), std::uint64_t{0});
    auto const slowest = static_cast<double>(*std::max_element(busy.begin(), busy.end()));
    if (sum != 0) m.slowest_over_mean = slowest * grid.size() / static_cast<double>(sum);
    return m;
}

/// One machine on its way along a motion.
struct Run {
    Motion row;
    std::unique_ptr<bench::TracedMachine> machine;

    void prefetch(splat::Camera const& camera, tilemesh::Grid grid)
    {
        auto const p = machine->prefetch(camera);
        row.early_exchanges += static_cast<double>(p.exchanges);
        row.early_mb += static_cast<double>(p.exchanged_live_bytes) * 1e-6;
        row.early_host_ms += p.host_ms;
        row.early_ms += modelled(machine->trace(), grid).ms;
    }
    void count(tilemesh::Grid grid)
    {
        auto const& r = machine->report();
        auto const m = modelled(machine->trace(), grid);
        row.exchanges += static_cast<double>(r.exchanges.total());
        row.exchanged_mb += static_cast<double>(r.exchanged_live_bytes) * 1e-6;
        row.host_ms += r.host_ms.total - r.host_ms.picture;
        row.modelled_ms += m.ms;
        row.slowest_over_mean += m.slowest_over_mean;
        row.missing += r.lost.size();
        ++row.frames;
    }
    void divide()
    {
        for (double* sum : {&row.exchanges, &row.modelled_ms, &row.exchanged_mb, &row.host_ms, &row.slowest_over_mean, &row.early_exchanges,
                            &row.early_ms, &row.early_mb, &row.early_host_ms})
            *sum /= row.frames;
    }
};

std::string table(std::vector<Motion> const& rows)
{
    std::string text = "| map | motion | prefetch | PSNR, dB | missing | exchanges | modelled ms | slowest / mean | SRAM, bytes "
                       "| exchanged, MB | host ms | early exchanges | early modelled ms | early MB | early host ms |\n"
                       "|---|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    for (auto const& r : rows) {
        text += "| " + r.map + " | " + r.motion + " | " + (r.early ? "yes" : "no") + " | " +
                (std::isinf(r.psnr_db) ? "exact" : fixed(r.psnr_db, 1)) + " | " + thousands(r.missing) + " | " + fixed(r.exchanges, 1) +
                " | " + fixed(r.modelled_ms, 2) + " | " + fixed(r.slowest_over_mean, 2) + " | " + thousands(r.sram_bytes) + " | " +
                fixed(r.exchanged_mb, 2) + " | " + fixed(r.host_ms, 0);
        text += r.early ? " | " + fixed(r.early_exchanges, 1) + " | " + fixed(r.early_ms, 2) + " | " + fixed(r.early_mb, 2) + " | " +
                              fixed(r.early_host_ms, 0) + " |\n"
                        : " | | | | |\n";
    }
    return text;
}

std::string findings(std::vector<Motion> const& rows)
{
    std::string text;
    for (std::size_t i = 0; i + 1 < rows.size(); i += 2) {
        auto const &without = rows[i], &with = rows[i + 1];
        double const frame = with.modelled_ms / without.modelled_ms;
        double const both = (with.modelled_ms + with.early_ms) / without.modelled_ms;
        text += "- " + with.map + ", " + with.motion + ": **prefetch by motion**, " + fixed(with.exchanges, 1) + " exchanges a frame for " +
                fixed(without.exchanges, 1) + ",\n  in " + fixed(frame, 2) + " times the modelled time; with the prefetch " +
                fixed(both, 2) + " times. " +
                (with.missing + without.missing != 0 ? "Both are lossy.\n"
                 : both < 1                          ? "It pays.\n"
                 : frame < 1                         ? "It pays only if tiles are idle between frames.\n"
                                                     : "It does not pay here.\n");
    }
    return text;
}

} // namespace

void measure_prefetch(bench::Scene const& scene, Options const& options, std::vector<Motion>& rows, std::vector<std::string>& broken)
{
    tilemesh::Grid const grid = options.quick ? tilemesh::Grid{10, 9} : tilemesh::Grid{40, 36};
    auto setup = splat::setup_of<splat::Lossless>();
    setup.rules.arithmetic = splat::Arithmetic::precise;
    auto rules = setup.rules;
    if (options.spoil) rules.alpha_max = bench::spoilt_alpha_max;
    for (std::string const motion : motion_names) {
        auto const cameras = path_of(motion, scene, options.quick ? 4 : 10, options.data);
        if (cameras.empty()) continue;
        Run plain, early;
        for (Run* run : {&plain, &early}) {
            tilemesh::RendererOptions const o{.threads = options.threads, .grid = {grid.width, grid.height}, .keep_pixels = false};
            run->row.map = scene.map.name;
            run->row.motion = motion;
            run->row.early = run == &early;
            run->row.sram_bytes = render::sram_bytes_of(setup);
            run->machine = bench::make_traced_machine(scene.map, setup, o);
        }
        for (std::size_t i = 0; i < cameras.size(); ++i) {
            if (i >= 2) early.prefetch(tilemesh::track::predicted(cameras[i - 2], cameras[i - 1]), grid);
            for (Run* run : {&plain, &early}) {
                run->machine->render(cameras[i]);
                if (i >= 2) run->count(grid);
            }
            bool const complete = plain.machine->report().lost.empty() && early.machine->report().lost.empty();
            if (complete && !same_bits(plain.machine->image(), early.machine->image())) ++early.row.other_bits;
        }
        auto const exact = tilemesh::report::render_naive(scene.map.gaussians, cameras.back(), rules);
        for (Run* run : {&plain, &early}) {
            auto const& image = run->machine->image();
            run->row.psnr_db = same_bits(image, exact) ? std::numeric_limits<double>::infinity()
                                                       : tilemesh::report::compare(image, exact).psnr_db;
            run->divide();
            auto const complain = [&](std::string const& what) {
                broken.push_back(scene.map.name + ", " + motion + ", prefetch: " + what);
            };
            if (run->row.other_bits != 0) complain(std::to_string(run->row.other_bits) + " pictures have other bits than without it");
            if (run->row.missing == 0 && !std::isinf(run->row.psnr_db)) complain("nothing is missing and the picture is not the naive one");
            rows.push_back(run->row);
            std::cerr << scene.map.name << ", " << motion << (run->row.early ? ", with prefetch\n" : ", without prefetch\n");
        }
    }
}

std::string section(std::vector<Motion> const& rows)
{
    return "## Prefetch by motion\n"
           "Between two frames, records and copies move to the tiles that want them where constant velocity leads the camera\n"
           "(`track::predicted`, `renderer.prefetch`): the steps project, route and bloom of a frame, without a picture. The next\n"
           "frame then moves what the guess got wrong. Pictures have the bits of those without it, if none lacks a record; the bench\n"
           "checks it.\n"
           "\n"
           "- The motions: `orbit0.5` has constant velocity, `fr1_xyz` is a recorded hand, \"to and fro\" turns back in every frame,\n"
           "  and `teleport` has jumps. Numbers are means over frames 3 to 11. PSNR is that of the last picture, and missing records\n"
           "  add up.\n"
           "- \"Early\" is the work of the prefetch. No frame's numbers have it. It costs each tile a projection of its records, and\n"
           "  what it exchanges. If tiles are not idle between frames, it is a part of the time of a frame.\n"
           "- The slots, and so the SRAM, are those without it.\n"
           "\n" +
           findings(rows) + "\n" + table(rows);
}

} // namespace policies
