// The growth of a frame's time and memory with Gaussians, pixels and tiles.
#include "scaling.hpp"
#include <common/direct.hpp>
#include <common/machine.hpp>
#include <common/program.hpp>
#include <common/statistics.hpp>
#include <fstream>
#include <iostream>
#include <malloc.h>
#include <memory>
#include <span>
#include <string>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <tilemesh/splat/setup_types.hpp>
#include <unistd.h>

namespace {

using namespace scaling;
using shared::option;
using tilemesh::Extent2;
using tilemesh::scene::Size;

constexpr char const* axis_names[] = {"gaussians", "pixels", "tiles", "idle_tiles"};
/// "LATENCY,OVERHEAD,BANDWIDTH" in microseconds, microseconds and GB/s.
void set_network(Options& o, shared::OptionValue const& given)
{
    if (given.three[2] == 0) throw shared::Misfit{"its bandwidth is above 0"};
    o.network = {"your network", given.three[0], given.three[1], 1000 * given.three[2], "Option --network"};
}

constexpr auto all_axes = shared::words_of(axis_names);
constexpr auto motions = shared::words_of(bench::motion_names);
constexpr shared::Option<Options> rows_of_options[] = {
    shared::words<&Options::axes>("axis", "NAME", "{}; may be repeated [all]", all_axes),
    shared::words<&Options::motion>("motion", "NAME", "{} [orbit0.5]", std::span(motions).first(5)), // without recorded ones
    option<&Options::threads>("threads", "N", "threads of rasteriser and mesh; may be repeated [1 and 2]", {1, 64}),
    option<&Options::ranks>("ranks", "", "measure the engine over the ranks of MPI instead: mpirun -n N scaling --ranks. Only rank 0 prints"),
    option<&Options::frames>("frames", "", "with --ranks: measure whole frames instead, one rank's threads against as many ranks"),
    option<&Options::predict>("predict", "", "predict a frame over 1 to 1,024 hosts instead"),
    option<&Options::chips>("chips", "", "model arrays of Mk2 chips against one chip of as many tiles instead"),
    {{"network",
      "L,O,B",
      "with --predict: one more network, of L us latency, O us overhead a message, B GB/s",
      shared::Form::three,
      0,
      1e6,
      {},
      {},
      "1.5,0.5,12"},
     set_network}};
constexpr shared::Pairing pairings[] = {{shared::Pairing::excludes, "ranks", "predict", "one measures, the other predicts"},
                                        {shared::Pairing::excludes, "chips", "ranks", "each prints a table of its own"},
                                        {shared::Pairing::excludes, "chips", "predict", "each prints a table of its own"},
                                        {shared::Pairing::needs, "network", "predict", "only a prediction needs a network"},
                                        {shared::Pairing::needs, "frames", "ranks", "frames are measured over the ranks of MPI"}};

shared::OptionTable table_of(Options& own)
{
    return bench::table_of({"scaling",
                            "Measures how a frame's host time and the machine's host memory grow, beside the time of a bare rasteriser:\n"
                            "  gaussians   1,000 to 1,000,000 of one made-up distribution, 1280 x 720 pixels, 40 x 36 tiles\n"
                            "  pixels      320 x 180 to 3840 x 2160, one map, 40 x 36 tiles\n"
                            "  tiles       the same frame of 1280 x 720 on 10 x 9 to 160 x 144 tiles\n"
                            "  idle_tiles  the same frame on 40 x 36 tiles of grids up to 400 x 250\n"
                            "Prints the exponents of power laws (least squares of logarithms), and the bytes per Gaussian and per idle\n"
                            "tile. The last three axes use Sloth if it is there, or else the built-in map. Times are medians of rounds\n"
                            "that measure both in turn; the pictures must be equal in each round. Bytes are the growth of the process\n"
                            "in the machine's first frame.\n",
                            "measure few and small values, 2 rounds; write no file", "write a row per value and number of threads"},
                           own, rows_of_options);
}

/// The bytes of the process that are in memory.
double resident_bytes()
{
    ::malloc_trim(0);
    std::ifstream file("/proc/self/statm");
    double all = 0, resident = 0;
    file >> all >> resident;
    return resident * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

/// One value of an axis.
struct Point {
    std::string axis;
    std::uint64_t value = 0;
    Size size{1280, 720};
    Extent2 grid{40, 36}, tile{}; ///< tile 0 x 0: the frame is spread over the grid
    std::uint32_t gaussians = 0;  ///< of the synthetic map; 0: the other map
};

struct Row {
    std::string axis;
    std::uint64_t value = 0;
    std::uint32_t threads = 0;
    std::vector<double> direct, mesh;
    double bytes = 0, pairs = 0, messages = 0;
    double bytes_empty = 0; ///< idle_tiles: with a map of one record, so that no idle tile has ever held a record
};

std::vector<Point> points_of(std::string const& axis, bool quick)
{
    std::vector<Point> points;
    auto const add = [&](std::uint64_t value) -> Point& {
        points.push_back({});
        points.back().axis = axis;
        points.back().value = value;
        if (quick) points.back().size = {320, 180};
        return points.back();
    };
    if (axis == "gaussians") {
        for (std::uint32_t const n : {1'000u, 4'000u, 16'000u, 64'000u, 250'000u, 1'000'000u})
            if (!quick || n <= 4'000) add(n).gaussians = n;
    } else if (axis == "pixels") {
        for (Size const s : {Size{320, 180}, Size{640, 360}, Size{1280, 720}, Size{1920, 1080}, Size{2560, 1440}, Size{3840, 2160}})
            if (!quick || s.width <= 640) add(std::uint64_t{s.width} * s.height).size = s;
    } else if (axis == "tiles") {
        for (Extent2 const g : {Extent2{10, 9}, Extent2{20, 18}, Extent2{40, 36}, Extent2{80, 72}, Extent2{160, 144}})
            if (!quick || g.width <= 20) add(std::uint64_t{g.width} * g.height).grid = g;
    } else {
        for (Extent2 const g : {Extent2{40, 36}, Extent2{100, 60}, Extent2{200, 125}, Extent2{400, 250}})
            if (!quick || g.width <= 100) {
                auto& p = add(std::uint64_t{g.width} * g.height);
                p.grid = g;
                p.tile = {p.size.width / 40, p.size.height / 36};
            }
    }
    return points;
}

/// Measures one point with each number of threads.
std::vector<Row> measure(Point const& point, Options const& options, std::vector<std::string>& broken)
{
    auto const other_map = [&] {
        if (options.quick) return synthetic(4'000, point.size);
        bool const sloth = bench::has_scene("sloth", options.data);
        return bench::load_scene(sloth ? "sloth" : "built_in", options.data, point.size);
    };
    auto const scene = point.gaussians != 0 ? synthetic(point.gaussians, point.size) : other_map();
    std::uint32_t const rounds = options.quick ? 2 : 9, warm_up = options.quick ? 1 : 2;
    auto const cameras = bench::cameras_of(options.motion, scene, warm_up + rounds, options.data);

    struct Contest {
        explicit Contest(std::uint32_t threads) : team(threads) {}
        bench::Team team;
        std::unique_ptr<bench::Machine> machine;
        Row row;
    };
    bench::Direct direct(scene.map.gaussians);
    tilemesh::splat::Rules rules;
    rules.arithmetic = tilemesh::splat::Lossless::arithmetic;
    if (options.spoil) rules.alpha_max = bench::spoilt_alpha_max;
    std::vector<std::unique_ptr<Contest>> contests;
    for (auto const threads : options.threads) {
        auto contest = std::make_unique<Contest>(threads);
        contest->row.axis = point.axis;
        contest->row.value = point.value;
        contest->row.threads = threads;
        auto const bytes_of = [&](std::unique_ptr<bench::Machine>& machine, tilemesh::scene::Map const& map) {
            auto const before = resident_bytes();
            machine = bench::make_machine(map, roomy_setup(), {.threads = threads, .grid = point.grid, .tile = point.tile, .keep_pixels = false});
            machine->render(scene.camera);
            return resident_bytes() - before;
        };
        if (point.axis == "idle_tiles") {
            contest->row.bytes_empty = bytes_of(contest->machine, synthetic(1, point.size).map);
            contest->machine.reset();
        }
        contest->row.bytes = bytes_of(contest->machine, scene.map);
        contests.push_back(std::move(contest));
    }
    for (std::size_t i = 1; i < cameras.size(); ++i)
        for (auto& c : contests) {
            direct.render(cameras[i], rules, c->team);
            c->team.rest();
            c->machine->wake(cameras[i]);
            c->machine->render(cameras[i]);
            auto const& r = c->machine->report();
            if (!direct.equals(c->machine->image()))
                broken.push_back(point.axis + " " + std::to_string(point.value) + ", " + std::to_string(c->row.threads) +
                                 " threads: the mesh's picture is not the rasteriser's");
            if (i <= warm_up) continue;
            c->row.direct.push_back(direct.stages().total);
            c->row.mesh.push_back(r.host_ms.total - r.host_ms.picture);
            c->row.pairs += static_cast<double>(direct.pairs()) / rounds;
            c->row.messages += static_cast<double>(r.messages) / rounds;
        }
    std::vector<Row> rows;
    for (auto& c : contests) rows.push_back(std::move(c->row));
    return rows;
}

/// Prints the conclusions from the rows of one axis.
void conclude(std::string const& axis, std::vector<Row> const& rows, Options const& options)
{
    for (auto const threads : options.threads) {
        std::vector<double> x, direct, mesh, pairs, bytes, bytes_empty;
        for (auto const& r : rows) {
            if (r.axis != axis || r.threads != threads) continue;
            x.push_back(static_cast<double>(r.value));
            direct.push_back(bench::median(r.direct));
            mesh.push_back(bench::median(r.mesh));
            pairs.push_back(r.pairs);
            bytes.push_back(r.bytes);
            bytes_empty.push_back(r.bytes_empty);
        }
        if (x.size() < 2) continue;
        std::cout << axis << ", " << threads << (threads == 1 ? " thread" : " threads") << ": direct ~ n^"
                  << bench::fixed(bench::fit_power(x, direct).exponent, 2) << ", mesh ~ n^" << bench::fixed(bench::fit_power(x, mesh).exponent, 2)
                  << ", evaluated pairs ~ n^" << bench::fixed(bench::fit_power(x, pairs).exponent, 2);
        auto const slope = bench::fit_slope(x, bytes);
        if (axis == "gaussians") std::cout << "; " << bench::fixed(slope, 0) << " bytes a Gaussian";
        else if (axis == "pixels") std::cout << "; " << bench::fixed(slope, 1) << " bytes a pixel";
        else if (axis == "tiles") std::cout << "; " << bench::fixed(slope, 0) << " bytes a tile";
        else
            std::cout << "; " << bench::fixed(slope, 0) << " bytes an idle tile, " << bench::fixed(bench::fit_slope(x, bytes_empty), 0)
                      << " where it has never held a record";
        std::cout << "\n";
    }
}

std::string csv(std::vector<Row> const& rows)
{
    std::string out = "axis,value,threads,direct_ms,mesh_ms,bytes,direct_ms_low,direct_ms_high,mesh_ms_low,mesh_ms_high,pairs,messages,bytes_empty\n";
    for (auto const& r : rows) {
        out += r.axis + "," + std::to_string(r.value) + "," + std::to_string(r.threads) + "," + bench::fixed(bench::median(r.direct), 4) + "," +
               bench::fixed(bench::median(r.mesh), 4) + "," + bench::fixed(r.bytes, 0);
        for (auto const* samples : {&r.direct, &r.mesh})
            for (double const share : {0.2, 0.8}) out += "," + bench::fixed(bench::quantile(*samples, share), 4);
        out += "," + bench::fixed(r.pairs, 0) + "," + bench::fixed(r.messages, 0) + "," +
               (r.axis == "idle_tiles" ? bench::fixed(r.bytes_empty, 0) : std::string{}) + "\n";
    }
    return out;
}

int run(Options const& options)
{
    if (options.ranks) return run_on_ranks(options);
    if (options.predict) return predict(options);
    if (options.chips) return chips(options);
    bench::expect_folder_of(options.csv);
    // Large blocks go back to the system when they are freed, so that the process grows by the memory of each machine.
    ::mallopt(M_MMAP_THRESHOLD, 1 << 18);
    std::vector<Row> rows;
    std::vector<std::string> broken;
    for (std::string const axis : axis_names) {
        if (!bench::chosen(options.axes, axis)) continue;
        for (auto const& point : points_of(axis, options.quick)) {
            for (auto& row : measure(point, options, broken)) rows.push_back(std::move(row));
            std::cerr << axis << " " << tilemesh::report::thousands(point.value) << "\n";
        }
    }
    tilemesh::report::Table table{{"axis", "value", "threads", "direct ms", "mesh ms", "mesh / direct", "MB", "pairs", "messages"}};
    for (auto const& r : rows)
        table.add_row({r.axis, tilemesh::report::thousands(r.value), std::to_string(r.threads), bench::fixed(bench::median(r.direct), 2),
                       bench::fixed(bench::median(r.mesh), 2), bench::fixed(bench::median(r.mesh) / bench::median(r.direct), 2),
                       bench::fixed(r.bytes / 1e6, 1), bench::fixed(r.pairs, 0), bench::fixed(r.messages, 0)});
    std::cout << table << "\n";
    for (auto const* axis : axis_names) conclude(axis, rows, options);
    if (!options.csv.empty()) tilemesh::report::write_whole(options.csv, csv(rows));
    return bench::verdict(broken, "All pictures are the same, bit for bit.");
}

} // namespace

void scaling::Options::finish(shared::OptionTable const& given)
{
    bench::Options::finish(given);
    for (auto const& pairing : pairings) given.require(pairing);
    if (threads.empty()) threads = {1, 2};
}

int main(int argc, char** argv)
{
    OnRanks const on_ranks(argc, argv); // with --ranks, MPI runs until the end of main
    return bench::program(argc, argv, table_of, run,
                          "not enough memory (a million Gaussians take gigabytes); name other axes, one --threads or --quick");
}
