#include "scaling.hpp"
#include <cmath>
#include <common/machine.hpp>
#include <common/statistics.hpp>
#include <iostream>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/hosts.hpp>
#include <tilemesh/mpi/bands.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/report/whole_file.hpp>

namespace scaling {

namespace {

using tilemesh::Grid;
using tilemesh::HostNetwork;
using tilemesh::HostSuperstep;
using tilemesh::scene::Size;

/// The vendor's limits: 200 Gb/s, and a latency below 0.6 us. A message's latency contains the overheads of both ends, so half of it is the
/// largest overhead that is possible.
HostNetwork hdr()
{
    return {"HDR InfiniBand", 0.6, 0.3, 25'000, "NVIDIA ConnectX-6, User Manual, Introduction: 200 Gb/s, latency below 600 ns"};
}
/// Over TCP. The bandwidth is that of the link; the measured throughput of the source was 0.5 GB/s.
HostNetwork ethernet()
{
    return {"10 Gb Ethernet", 20, 10, 1'250,
            "Hurwitz and Feng, Initial End-to-End Performance Evaluation of 10-Gigabit Ethernet, Hot Interconnects 11, 2003: 20 us between "
            "two applications; IEEE 802.3ae: 10 Gb/s"};
}

/// Words of an agreement of the frame's program: seven, and one for each of its two channels (include/tilemesh/mpi/README.md).
constexpr double agreement_bytes = 8 * (7 + 2);

/// A machine, and the smaller one that is measured in its place: both edges of its grid and of its frame are `times` smaller, and tiles,
/// footprints and records per tile are equal.
struct Case {
    char const* name;
    std::uint32_t gaussians; ///< of the synthetic map that is measured; 0: the built-in map
    Size size;               ///< of the frame that is measured
    Grid grid;
    std::uint32_t times;
};
Case const cases[] = {
    {"the paper's machine: 40 x 36 tiles, the built-in map of 35,732 Gaussians", 0, {1280, 720}, {40, 36}, 1},
    {"a wafer: 1,000 x 850 tiles, 1,000,000 Gaussians", 10'000, {400, 255}, {100, 85}, 10},
    {"64 chips as one grid: 320 x 288 tiles, 10,000,000 Gaussians", 156'250, {1280, 720}, {40, 36}, 8},
};

/// A frame on one host.
struct Frame {
    std::vector<HostSuperstep> supersteps;
    std::vector<bool> travels; ///< of each superstep: do records cross the grid?
    std::uint64_t messages = 0;
};

/// The stage of FrameReport::host_ms to which a kernel's time goes.
std::size_t stage_of(std::string const& kernel)
{
    return kernel == "project" ? 0 : kernel == "route" ? 1 : kernel == "bloom" ? 2 : 3;
}

/// Renders a view, then views 0.5 degrees apart, on one thread. Times are medians over the frames after the second; the trace is of the last
/// of them.
Frame measure(Case const& c, Options const& options)
{
    auto const scene = c.gaussians == 0 ? bench::load_scene("built_in", options.data, c.size) : synthetic(c.gaussians, c.size, c.size.width);
    std::uint32_t const frames = options.quick ? 3 : 9;
    auto const cameras = bench::cameras_of("orbit0.5", scene, frames, options.data);
    tilemesh::RendererOptions const on{.threads = 1, .grid = {c.grid.width, c.grid.height}};
    std::vector<double> ms[4];
    auto const machine = bench::make_machine(scene.map, roomy_setup(), on);
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        machine->render(cameras[i]);
        auto const& t = machine->report().host_ms;
        double const stages[] = {t.project, t.route, t.bloom, t.composite};
        for (std::size_t s = 0; s < 4 && i > 1; ++s) ms[s].push_back(stages[s]);
    }
    auto const traced = bench::make_traced_machine(scene.map, roomy_setup(), on);
    for (auto const& camera : cameras) traced->render(camera);

    auto const model = tilemesh::mk2();
    auto const& trace = traced->trace();
    auto const cost = tilemesh::model_cost(model, trace, c.grid);
    std::vector<double> cycles, of_stage(4, 0), step_us;
    for (std::size_t step = 0; step < trace.kernels.size(); ++step) {
        double sum = 0;
        for (auto const n : cost.busy[step]) sum += static_cast<double>(n);
        cycles.push_back(sum);
        of_stage[stage_of(trace.kernels[step])] += sum;
    }
    for (std::size_t step = 0; step < trace.kernels.size(); ++step) {
        auto const s = stage_of(trace.kernels[step]);
        step_us.push_back(of_stage[s] > 0 ? 1000 * bench::median(ms[s]) * cycles[step] / of_stage[s] : 0);
    }
    Frame frame{tilemesh::host_supersteps(trace, c.grid, model, step_us), {}, traced->report().messages};
    for (auto const& s : trace.supersteps) frame.travels.push_back(trace.kernels[s.step] == "route");
    return frame;
}

/// The time in ms on one host, and the number of supersteps.
std::pair<double, double> sums_of(std::vector<HostSuperstep> const& supersteps)
{
    double us = 0, n = 0;
    for (auto const& s : supersteps) {
        n += s.times;
        for (auto const row : s.row_us) us += s.times * row;
    }
    return {us / 1000, n};
}
std::string text_of(std::vector<HostSuperstep> const& supersteps)
{
    auto const [ms, n] = sums_of(supersteps);
    return bench::fixed(ms, 1) + " ms on one host, " + bench::fixed(n, 0) + " supersteps";
}

/// Bands of equal work, as MpiMesh makes them from row weights.
std::vector<std::uint32_t> bands_of(std::vector<HostSuperstep> const& supersteps, std::uint32_t hosts)
{
    std::vector<double> rows(supersteps.front().row_us.size(), 0);
    for (auto const& s : supersteps)
        for (std::size_t y = 0; y < rows.size(); ++y) rows[y] += s.times * s.row_us[y];
    std::vector<std::uint32_t> weights;
    for (auto const us : rows) weights.push_back(static_cast<std::uint32_t>(std::lround(us))); // a row of a frame takes less than an hour
    tilemesh::mpi::Bands const bands{static_cast<std::uint32_t>(rows.size()), hosts, weights};
    std::vector<std::uint32_t> first;
    for (std::uint32_t h = 0; h < hosts; ++h) first.push_back(bands.first(h));
    first.push_back(bands.height());
    return first;
}

} // namespace

int predict(Options const& options)
{
    bench::expect_folder_of(options.csv);
    std::vector<HostNetwork> networks{{"no network", 0, 0, INFINITY, "the limit: only the slowest band counts"}, hdr(), ethernet()};
    if (options.network) networks.push_back(*options.network);
    std::string csv = "case,network,hosts,frame_ms,efficiency,slowest_ms,bytes,messages,supersteps\n";
    std::cout << "Predicted, not measured: a frame 0.5 degrees after the one before, over hosts of one thread of this CPU.\n\n";
    for (auto const& c : cases) {
        auto const frame = measure(c, options);
        std::cout << "Predicted for " << c.name << ".\nMeasured and counted on " << c.grid.width << " x " << c.grid.height << " tiles: "
                  << text_of(frame.supersteps) << ", " << tilemesh::report::thousands(frame.messages) << " messages.\n";
        if (c.times > 1 && !options.quick) { // how far enlarging is from measuring, at the largest size that is quick to measure
            auto const large = measure({c.name, 4 * c.gaussians, {2 * c.size.width, 2 * c.size.height}, {2 * c.grid.width, 2 * c.grid.height}, 1},
                                       options);
            std::cout << "Both edges enlarged by 2: " << text_of(tilemesh::enlarged(frame.supersteps, 2, frame.travels))
                      << ". Measured at this size: " << text_of(large.supersteps) << ".\n";
        }
        auto const supersteps = tilemesh::enlarged(frame.supersteps, c.times, frame.travels);
        if (c.times > 1) std::cout << "Both edges enlarged by " << c.times << ": " << text_of(supersteps) << ".\n";
        std::vector<std::string> head{"hosts"};
        for (auto const& net : networks) {
            head.push_back(net.name + ", ms");
            head.push_back("efficiency, %");
        }
        tilemesh::report::Table table{head};
        for (std::uint32_t hosts = 1; hosts <= 1024; hosts *= 2) {
            std::vector<std::string> row{std::to_string(hosts)};
            auto const bands = bands_of(supersteps, hosts);
            for (auto const& net : networks) {
                auto const p = tilemesh::predict_hosts(net, supersteps, bands, agreement_bytes);
                row.push_back(bench::fixed(p.frame_us / 1000, 2));
                row.push_back(bench::fixed(100 * p.efficiency, p.efficiency < 0.1 ? 1 : 0));
                csv += '"' + std::string(c.name) + "\"," + net.name + "," + std::to_string(hosts) + "," + bench::fixed(p.frame_us / 1000, 4) +
                       "," + bench::fixed(p.efficiency, 4) + "," + bench::fixed(p.slowest_us / 1000, 4) + "," + bench::fixed(p.bytes, 0) + "," +
                       bench::fixed(p.messages, 0) + "," + bench::fixed(sums_of(supersteps).second, 0) + "\n";
            }
            table.add_row(row);
        }
        std::cout << table << "\n";
    }
    for (auto const& net : networks)
        std::cout << net.name << ": " << bench::fixed(net.latency_us, 2) << " us latency, " << bench::fixed(net.overhead_us, 2)
                  << " us overhead, " << bench::fixed(net.bytes_per_us / 1000, 2) << " GB/s. " << net.source << ".\n";
    if (!options.csv.empty()) tilemesh::report::write_whole(options.csv, csv);
    return 0;
}

} // namespace scaling
