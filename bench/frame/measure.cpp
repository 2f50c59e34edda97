#include "frame.hpp"
#include <algorithm>
#include <cmath>
#include <common/fma_peak.hpp>
#include <common/machine.hpp>
#include <common/statistics.hpp>
#include <memory>
#include <numeric>
#include <thread>
#include <tilemesh/renderer.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/naive.hpp>
#include <tilemesh/report/reference_double.hpp>

namespace frame {

namespace {

namespace splat = tilemesh::splat;

using bench::Machine;

/// The stop of every machine here, and of the rasteriser: that of 3D Gaussian Splatting, so that other programs can be compared with this
/// bench's results.
constexpr float stop_of_3dgs = 1e-4f;

/// The preset lossless with that stop.
enum class Kind {
    paper, ///< on Mk2, 40 x 36 tiles
    large, ///< on a test machine with storage for a twelfth of the map on each of 40 x 36 tiles
    wide   ///< on 400 x 250 tiles, of which the frame occupies 40 x 36
};

/// Do tiles whose splats and view did not change keep their pixels?
enum class Pixels { composited, kept };

std::unique_ptr<Machine> make_machine(Kind kind, Pixels pixels, tilemesh::scene::Map const& map, splat::Arithmetic arithmetic, std::uint32_t threads,
                                      splat::Camera const& camera)
{
    auto setup = splat::setup_of<splat::Lossless>();
    setup.rules.transmittance_min = stop_of_3dgs;
    setup.rules.arithmetic = arithmetic;
    tilemesh::RendererOptions options{.threads = threads, .keep_pixels = pixels == Pixels::kept};
    if (kind == Kind::large) {
        setup.machine = tilemesh::size_of_machine<splat::RoomyMachine>();
        // An object capture has most of its records, and their copies, on a few tiles.
        setup.sizes.storage = std::max(20'000u, static_cast<std::uint32_t>(map.gaussians.size() / 12));
    }
    if (kind == Kind::wide) {
        auto const part = [](std::uint32_t size, std::uint32_t tiles) { return (size + tiles - 1) / tiles; };
        setup.machine = tilemesh::size_of_machine<tilemesh::TestMachine<tilemesh::Mk2::sram_bytes, 100'000>>();
        options.grid = {400, 250};
        options.tile = {part(camera.width, 40), part(camera.height, 36)};
    }
    return bench::make_machine(map, setup, options);
}

/// The program of homes on Mk2, with that stop.
std::unique_ptr<tilemesh::Renderer> make_homes(tilemesh::scene::Map const& map, splat::Arithmetic arithmetic, std::uint32_t threads)
{
    auto choice = splat::homes_setup;
    choice.fit = true;
    choice.rules.transmittance_min = stop_of_3dgs;
    choice.rules.arithmetic = arithmetic;
    return std::make_unique<tilemesh::Renderer>(map, choice, tilemesh::RendererOptions{.threads = threads});
}

/// The operations of one evaluated pair: additions, compares, minima and roundings count 1, an FMA counts 2.
constexpr double operations_per_pair = 21;
constexpr double pairs_a_block = splat::block_width * splat::block_height;

/// One number of threads: a team for the rasteriser, and the meshes that render in turn with it.
struct Contest {
    std::uint32_t threads;
    std::unique_ptr<bench::Team> team;
    std::unique_ptr<bench::Direct> direct;
    struct Entry {
        std::unique_ptr<Machine> machine;
        Row row;
    };
    std::vector<Entry> entries;
    std::unique_ptr<tilemesh::Renderer> homes; ///< in a moving view
    std::unique_ptr<Machine> kept;             ///< in a static view: the first entry's machine, whose tiles keep their pixels
};

/// The default model with the stop of 3D Gaussian Splatting.
splat::Rules rules_with_stop() noexcept
{
    splat::Rules rules;
    rules.transmittance_min = stop_of_3dgs;
    return rules;
}

splat::Rules rules_of(Options const& options)
{
    auto rules = rules_with_stop();
    rules.arithmetic = options.arithmetic;
    if (options.spoil) rules.alpha_max = bench::spoilt_alpha_max;
    return rules;
}

/// A map that is larger than this does not fit the preset's own machine.
constexpr std::size_t most_on_mk2 = 100'000;
/// Larger maps are measured in fewer rounds: after a jump of the camera, a frame of a million Gaussians takes seconds.
constexpr std::size_t most_in_many_rounds = 500'000;

std::uint32_t rounds_of(Options const& options, tilemesh::scene::Map const& map)
{
    if (options.rounds != 0) return options.rounds;
    return options.quick ? 3 : map.gaussians.size() > most_in_many_rounds ? 7 : 25;
}

/// One round of one contest. `measured`: false while the machine warms up.
void run_round(Contest& contest, splat::Camera const& camera, splat::Rules const& rules, bool measured, std::vector<std::string>& broken)
{
    auto& direct = *contest.direct;
    auto const gflops = bench::FmaPeak::gflops(*contest.team);
    auto const ghz = bench::FmaPeak::clock_ghz(*contest.team);
    direct.render(camera, rules, *contest.team);
    contest.team->rest();
    auto const stages = direct.stages();
    for (auto& [machine, row] : contest.entries) {
        machine->wake(camera);
        machine->render(camera);
        auto const& r = machine->report();
        if (!direct.equals(machine->image())) broken.push_back("the mesh's picture is not the rasteriser's");
        if (r.pairs_contributing != direct.pairs_contributing())
            broken.push_back("the mesh counts " + std::to_string(r.pairs_contributing) + " contributing pairs, the rasteriser " +
                             std::to_string(direct.pairs_contributing()));
        if (!measured) continue;
        auto const mesh = r.host_ms.total - r.host_ms.picture;
        auto const pairs = static_cast<double>(direct.pairs());
        row.direct.push_back(stages.total);
        row.mesh.push_back(mesh);
        row.mesh_over_direct.push_back(mesh / stages.total);
        if (gflops > 0) {
            row.gflops.push_back(gflops);
            row.direct_over_roofline.push_back(pairs * operations_per_pair / (gflops * 1e6) / stages.total);
        }
        if (ghz > 0 && pairs > 0) {
            row.clock_ghz.push_back(ghz);
            row.cycles_per_block_splat.push_back(stages.blend * 1e6 * ghz * contest.threads * pairs_a_block / pairs);
        }
        row.direct_project.push_back(stages.project);
        row.direct_sort.push_back(stages.sort);
        row.direct_bin.push_back(stages.bin);
        row.direct_blend.push_back(stages.blend);
        row.mesh_project.push_back(r.host_ms.project);
        row.mesh_route.push_back(r.host_ms.route);
        row.mesh_bloom.push_back(r.host_ms.bloom);
        row.mesh_composite.push_back(r.host_ms.composite);
        row.picture.push_back(r.host_ms.picture);
        row.pairs.push_back(pairs);
        row.contributing.push_back(static_cast<double>(r.pairs_contributing));
        row.messages.push_back(static_cast<double>(r.messages));
        row.exchanges.push_back(static_cast<double>(r.exchanges.total()));
        row.moved.push_back(static_cast<double>(r.gaussians.moved));
        row.visible = direct.visible();
        row.entries = direct.entries();
        row.over_narrow.push_back(mesh / contest.entries.front().row.mesh.back());
    }
    if (contest.homes != nullptr) {
        auto const frame = contest.homes->render(camera);
        if (!direct.equals(frame.image)) broken.push_back("the picture of homes is not the rasteriser's");
        auto const& r = frame.report;
        if (r.pairs_contributing != direct.pairs_contributing())
            broken.push_back("homes count " + std::to_string(r.pairs_contributing) + " contributing pairs, the rasteriser " +
                             std::to_string(direct.pairs_contributing()));
        auto& row = contest.entries.front().row;
        auto const homes = r.host_ms.total - r.host_ms.picture;
        if (measured) row.homes.push_back(homes), row.homes_over_direct.push_back(homes / stages.total);
    }
    if (contest.kept == nullptr) return;
    contest.kept->wake(camera);
    contest.kept->render(camera);
    auto const& r = contest.kept->report();
    if (!direct.equals(contest.kept->image()) || r.pairs != contest.entries.front().machine->report().pairs)
        broken.push_back("pictures or pairs differ if tiles keep their pixels");
    if (measured) contest.entries.front().row.kept.push_back(r.host_ms.total - r.host_ms.picture);
}

Samples ratios(Samples const& of, Samples const& over)
{
    Samples out;
    for (std::size_t i = 0; i < of.size(); ++i) out.push_back(of[i] / over[i]);
    return out;
}

std::uint32_t byte_of(float v)
{
    return v > 0.0f ? v < 1.0f ? static_cast<std::uint32_t>(v * 255.0f + 0.5f) : 255u : 0u;
}

double mean(Samples const& s)
{
    return s.empty() ? 0 : std::accumulate(s.begin(), s.end(), 0.0) / static_cast<double>(s.size());
}

} // namespace

std::vector<Row> measure(bench::Scene const& scene, std::string const& motion, Options const& options, std::vector<std::string>& broken)
{
    auto const rounds = rounds_of(options, scene.map);
    std::uint32_t const warm_up = options.quick ? 1 : 3;
    auto cameras = bench::cameras_of(motion, scene, warm_up + rounds, options.data);
    auto const rules = rules_of(options);
    std::vector<Contest> contests;
    for (auto const threads : options.threads) {
        Contest c{threads, std::make_unique<bench::Team>(threads), std::make_unique<bench::Direct>(scene.map.gaussians), {}, {}, {}};
        auto const machine = [&](Kind kind, Pixels pixels) {
            return make_machine(kind, pixels, scene.map, options.arithmetic, threads, scene.camera);
        };
        auto const add = [&](Kind kind, char const* grid) {
            Row row;
            row.scene = scene.map.name;
            row.motion = motion;
            row.grid = grid;
            row.threads = threads;
            c.entries.push_back({machine(kind, Pixels::composited), std::move(row)});
        };
        bool const large = scene.map.gaussians.size() > most_on_mk2;
        auto const kind = large ? Kind::large : Kind::paper;
        add(kind, "40x36");
        if (motion == "static") c.kept = machine(kind, Pixels::kept);
        if (options.homes && motion != "static") c.homes = make_homes(scene.map, options.arithmetic, threads);
        if (options.wide && !large) add(Kind::wide, "400x250");
        contests.push_back(std::move(c));
    }

    std::vector<std::string> found;
    std::size_t round = 0;
    for (; round < cameras.size(); ++round)
        for (auto& c : contests) run_round(c, cameras[round], rules, round > warm_up, found);
    if (options.arithmetic == splat::Arithmetic::precise &&
        !contests.front().direct->equals(tilemesh::report::render_naive(scene.map.gaussians, cameras.back(), rules_with_stop())))
        found.push_back("the last picture is not the naive one");
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    for (auto const& what : found) broken.push_back(scene.map.name + " " + motion + ": " + what);

    std::vector<Row> rows;
    auto const one = std::find_if(contests.begin(), contests.end(), [](auto const& c) { return c.threads == 1; });
    for (auto& c : contests)
        for (std::size_t i = 0; i < c.entries.size(); ++i) {
            auto& row = c.entries[i].row;
            if (one != contests.end()) {
                row.direct_speedup = ratios(one->entries[i].row.direct, row.direct);
                row.mesh_speedup = ratios(one->entries[i].row.mesh, row.mesh);
            }
            rows.push_back(row);
        }
    return rows;
}

std::vector<ErrorRow> measure_arithmetics(bench::Scene const& scene, Options const& options)
{
    auto const ways = blend_ways();
    auto const threads = *std::max_element(options.threads.begin(), options.threads.end());
    std::vector<ErrorRow> rows;
    for (auto const& way : ways) {
        rows.push_back({});
        rows.back().scene = scene.map.name;
        rows.back().exponential = way.exponential;
        rows.back().stop = way.stop;
        rows.back().threads = threads;
    }
    auto const rules = rules_with_stop();
    auto const reference = tilemesh::report::render_double(scene.map.gaussians, scene.camera, rules, tilemesh::report::Cuts::same,
                                                           std::max(1u, std::thread::hardware_concurrency()));
    bench::Direct direct(scene.map.gaussians);
    bench::Team team(threads);
    std::uint32_t const warm_up = options.quick ? 1 : 3, rounds = rounds_of(options, scene.map);
    for (std::uint32_t round = 1; round <= warm_up + rounds; ++round)
        for (std::size_t i = 0; i < ways.size(); ++i) {
            direct.render(scene.camera, rules, team, ways[i].blend_tile);
            if (round <= warm_up) continue;
            auto& row = rows[i];
            row.direct.push_back(direct.stages().total);
            if (round != warm_up + rounds) continue;
            auto const image = direct.image();
            auto const error = tilemesh::report::compare(image, reference);
            row.rms = error.rmse;
            row.psnr_db = error.psnr_db;
            for (std::size_t k = 0; k < image.rgb.size(); ++k) {
                auto const a = byte_of(image.rgb[k]), b = byte_of(reference.rgb[k]);
                row.differing_bytes += a != b ? 1 : 0;
                row.largest_byte = std::max(row.largest_byte, a > b ? a - b : b - a);
            }
        }
    for (auto& row : rows)
        for (std::size_t k = 0; k < row.direct.size(); ++k) row.over_first.push_back(row.direct[k] / rows.front().direct[k]);
    return rows;
}

std::string csv(std::vector<Row> const& rows, tilemesh::splat::Arithmetic arithmetic)
{
    struct Column {
        char const* name;
        Samples Row::*samples;
        int places;
    };
    // Columns with a band.
    static constexpr Column banded[] = {
        {"fma_gflops", &Row::gflops, 1},
        {"direct_ms", &Row::direct, 4},
        {"mesh_ms", &Row::mesh, 4},
        {"mesh_over_direct", &Row::mesh_over_direct, 4},
        {"direct_over_roofline", &Row::direct_over_roofline, 4},
        {"direct_project_ms", &Row::direct_project, 4},
        {"direct_sort_ms", &Row::direct_sort, 4},
        {"direct_bin_ms", &Row::direct_bin, 4},
        {"direct_blend_ms", &Row::direct_blend, 4},
        {"mesh_project_ms", &Row::mesh_project, 4},
        {"mesh_route_ms", &Row::mesh_route, 4},
        {"mesh_bloom_ms", &Row::mesh_bloom, 4},
        {"mesh_composite_ms", &Row::mesh_composite, 4},
        {"picture_ms", &Row::picture, 4},
        {"direct_speedup", &Row::direct_speedup, 3},
        {"mesh_speedup", &Row::mesh_speedup, 3},
        {"mesh_over_narrow", &Row::over_narrow, 3},
        {"clock_ghz", &Row::clock_ghz, 3},
        {"cycles_per_block_splat", &Row::cycles_per_block_splat, 1},
        {"mesh_kept_ms", &Row::kept, 4},
        {"homes_ms", &Row::homes, 4},
        {"homes_over_direct", &Row::homes_over_direct, 4},
    };
    auto const middle = [](Samples const& s, int places) { return s.empty() ? std::string{} : bench::fixed(bench::median(s), places); };
    std::string out = "scene,motion,threads,fma_gflops,direct_ms,mesh_ms,mesh_over_direct,direct_over_roofline,pairs_evaluated,"
                      "pairs_contributing,messages,exchanges,grid,arithmetic,compiler,instructions,rounds,visible,entries,moved";
    for (std::size_t i = 0; i < std::size(banded); ++i) {
        std::string const name = banded[i].name;
        if (i >= 5) out += "," + name; // the first five come before the counters
        out += "," + name + "_low," + name + "_high";
    }
    out += "\n";
    for (auto const& r : rows) {
        out += r.scene + "," + r.motion + "," + std::to_string(r.threads);
        for (std::size_t i = 0; i < 5; ++i) out += "," + middle(r.*banded[i].samples, banded[i].places);
        out += "," + bench::fixed(mean(r.pairs), 0) + "," + bench::fixed(mean(r.contributing), 0) + "," + bench::fixed(mean(r.messages), 1) + "," +
               bench::fixed(mean(r.exchanges), 2) + "," + r.grid + "," + to_string(arithmetic);
#if defined(__clang__)
        out += ",clang " + std::to_string(__clang_major__);
#else
        out += ",gcc " + std::to_string(__GNUC__);
#endif
        out += std::string(",") + bench::FmaPeak::instructions + "," + std::to_string(r.direct.size()) + "," + std::to_string(r.visible) + "," +
               std::to_string(r.entries) + "," + bench::fixed(mean(r.moved), 1);
        for (std::size_t i = 0; i < std::size(banded); ++i) {
            auto const& samples = r.*banded[i].samples;
            if (i >= 5) out += "," + middle(samples, banded[i].places);
            for (double const share : {0.2, 0.8})
                out += "," + (samples.empty() ? std::string{} : bench::fixed(bench::quantile(samples, share), banded[i].places));
        }
        out += "\n";
    }
    return out;
}

std::string csv(std::vector<ErrorRow> const& rows)
{
    std::string out = "scene,exponential,stop,threads,direct_ms,direct_ms_low,direct_ms_high,over_first,rms,psnr_db,differing_bytes,"
                      "largest_byte\n";
    for (auto const& r : rows) {
        auto const rms = bench::scientific(r.rms, 3);
        out += r.scene + "," + r.exponential + "," + r.stop + "," + std::to_string(r.threads) + "," + bench::fixed(bench::median(r.direct), 4) + "," +
               bench::fixed(bench::quantile(r.direct, 0.2), 4) + "," + bench::fixed(bench::quantile(r.direct, 0.8), 4) + "," +
               bench::fixed(bench::median(r.over_first), 4) + "," + rms + "," + bench::fixed(r.psnr_db, 2) + "," + std::to_string(r.differing_bytes) +
               "," + std::to_string(r.largest_byte) + "\n";
    }
    return out;
}

} // namespace frame
