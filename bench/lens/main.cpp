// Lenses that bend: how far the conic of the lens's Jacobian is from exact rays, and what projection through a lens costs.
#include "sequence.hpp"
#include "tables.hpp"
#include <algorithm>
#include <cmath>
#include <common/program.hpp>
#include <common/scenes.hpp>
#include <common/statistics.hpp>
#include <cstdint>
#include <iostream>
#include <string>
#include <tilemesh/report/exact_rays.hpp>
#include <tilemesh/report/naive.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <tilemesh/scene/lens.hpp>
#include <tilemesh/splat/project_all.hpp>
#include <vector>

namespace {

using namespace tilemesh;
using bench::fixed;

struct Options : bench::Options {
    std::vector<std::string> scenes;
    std::uint32_t rounds = 15, threads = 2;
    bool sequences = false, frames = false, moments = false, shutters = false;
};
constexpr auto scene_words = shared::words_of(bench::scene_names);
constexpr shared::Option<Options> rows[] = {
    shared::words<&Options::scenes>("scene", "NAME", "{}; may be repeated [sloth, salad and the built-in map]", scene_words),
    shared::option<&Options::rounds>("rounds", "N", "measured rounds of projection [15]", {1, 10'000}),
    shared::option<&Options::sequences>("sequences", "",
                                        "another table instead: 60 frames of 160 x 90 along fr1_xyz, as exact rays through a pinhole and the first "
                                        "lenses, tracked and mapped from nothing"),
    shared::option<&Options::frames>("frames", "", "another table instead: frames through each lens, and by exact rays, over a frame through a pinhole"),
    shared::option<&Options::moments>("moments", "", "another table instead: J's mean and covariance against 4,000 samples of each Gaussian"),
    shared::option<&Options::shutters>("shutters", "", "another table instead: pictures of a rolling shutter, read in 30 ms, against exact rays from each row's pose"),
    shared::option<&Options::threads>("threads", "N", "threads of the exact rays [2]", {1, 64})};
shared::OptionTable table_of(Options& own)
{
    return bench::table_of({"lens",
                            "Renders a scene through lenses: the conic that the kernels blend (J), and exact rays in double (E), both from the first pose of\n"
                            "the recording (the built-in map: from its camera). PSNR is that of J against E over the pixels with a ray, for a peak of 1. Times\n"
                            "are medians over rounds in which a pinhole of the same focal lengths and all lenses take turns.\n",
                            "the built-in map unless scenes are named, pictures of 320 x 240, 3 rounds", "write the rows", false},
                           own, rows);
}

struct Lens {
    char const* name;
    std::uint32_t width, height;
    float fx, fy, cx, cy;
    char const* text;
};
/// TUM's fr1, EuRoC's cam0 and TUM-VI's cam0 with their own calibrations; the others as a study of lenses takes them.
constexpr Lens lenses[] = {
    {"pinhole", 640, 480, 517.306408f, 516.469215f, 318.643040f, 255.313989f, "pinhole"},
    {"TUM fr1", 640, 480, 517.306408f, 516.469215f, 318.643040f, 255.313989f, "opencv,0.262383,-0.953104,-0.005358,0.002628,1.163314"},
    {"EuRoC", 752, 480, 458.654f, 457.296f, 367.215f, 248.375f, "opencv,-0.28340811,0.07395907,0.00019359,1.76187114e-05"},
    {"FOV .93", 640, 480, 302, 302, 320, 240, "fov,0.93"},
    {"fisheye 120", 640, 480, 305.577f, 305.577f, 320, 240, "fisheye"},
    {"fisheye 180", 640, 480, 203.718f, 203.718f, 320, 240, "fisheye"},
    {"TUM-VI 195", 512, 512, 190.978f, 190.973f, 254.932f, 256.897f, "fisheye,0.00348238940225,0.000715034845216,-0.00205323614187,0.000202936735918"}};

splat::Camera through(Lens const& lens, splat::Camera camera, bool quick)
{
    float const by = quick ? 0.5f : 1;
    camera.width = lens.width / (quick ? 2 : 1), camera.height = lens.height / (quick ? 2 : 1);
    camera.fx = by * lens.fx, camera.fy = by * lens.fy, camera.cx = by * lens.cx, camera.cy = by * lens.cy;
    camera.lens = scene::lens_of_text(lens.text);
    return camera;
}

struct Row {
    std::string scene, lens;
    double psnr = 0, largest = 0, not_finite = 0, ns = 0, ratio = 0;
};

splat::Camera at_the_start(std::string const& name, splat::Camera camera)
{
    if (name != "sloth" && name != "salad") return camera;
    for (int i = 0; i < 3; ++i) // the first pose of the recording is the world's
        for (int j = 0; j < 3; ++j) camera.rotation[i][j] = i == j ? 1.0f : 0.0f;
    camera.position[0] = camera.position[1] = camera.position[2] = 0;
    camera.near_depth = 0.2f;
    return camera;
}

double psnr_of(report::Image const& picture, report::Image const& exact)
{
    double squares = 0, count = 0;
    for (std::size_t i = 0; i < exact.rgb.size(); ++i) {
        if (std::isnan(exact.rgb[i])) continue;
        double const error = std::clamp(double{picture.rgb[i]}, 0.0, 1.0) - std::clamp(double{exact.rgb[i]}, 0.0, 1.0);
        squares += error * error, ++count;
    }
    return 10 * std::log10(count / squares);
}

int run_shutters(Options const& options)
{
    report::Table table{{"scene", "lens", "rad/s", "units/s", "one pose, dB", "rolling shutter, dB", "at rest, dB"}};
    std::string csv = "scene,lens,rad_s,units_s,one_pose_db,rolling_db,at_rest_db\n";
    splat::Rules const rules;
    for (auto const& name : options.scenes) {
        if (!bench::has_scene(name, options.data)) {
            bench::say_skipped(name);
            continue;
        }
        auto const scene = bench::load_scene(name, options.data, {640, 480});
        auto const& gaussians = scene.map.gaussians;
        auto const exact = [&](splat::Camera const& camera) { return report::render_exact_rays(gaussians, camera, rules, options.threads); };
        for (std::size_t const i : {0u, 1u, 5u}) { // a pinhole, TUM fr1, a fisheye of 180 degrees
            auto const camera = through(lenses[i], at_the_start(name, scene.camera), options.quick);
            auto const conics = report::render_naive(gaussians, camera, rules);
            double const rest = psnr_of(conics, exact(camera));
            for (float const rate : {0.3f, 1.0f, 3.0f}) {
                auto rolling = camera;
                float const turn[3] = {0.3f, 1.0f, 0.2f}, move[3] = {0.3f, 0.1f, 0.2f}, per_row = 0.03f * rate * camera.fy / static_cast<float>(camera.height);
                for (int k = 0; k < 3; ++k) rolling.shutter.turn[k] = per_row * turn[k], rolling.shutter.move[k] = per_row * move[k];
                auto const truth = exact(rolling);
                std::vector<std::string> row{name, lenses[i].name, fixed(rate * std::hypot(0.3, 1.0, 0.2), 2), fixed(rate * std::hypot(0.3, 0.1, 0.2), 2)};
                for (double const db : {psnr_of(conics, truth), psnr_of(report::render_naive(gaussians, rolling, rules), truth), rest}) row.push_back(fixed(db, 1));
                for (std::size_t k = 0; k < row.size(); ++k) csv += row[k] + (k + 1 < row.size() ? "," : "\n");
                table.add_row(row);
            }
        }
    }
    std::cout << table;
    if (!options.csv.empty()) report::write_whole(options.csv, csv);
    return 0;
}

int run_sequences(Options const& options)
{
    report::Table table{{"scene", "lens", "frames", "lost", "ATE, world units", "over a pinhole", "PSNR of the map, dB"}};
    std::string csv = "scene,lens,frames,lost,ate,over_pinhole,psnr_db\n";
    for (auto const& name : options.scenes) {
        if (!bench::has_scene(name, options.data) || !bench::has_motion("fr1_xyz", options.data)) {
            std::cout << "skipped: " << name << " (its map or fr1_xyz is not there; name the folder with --data)\n";
            continue;
        }
        auto scene = bench::load_scene(name, options.data, {160, 90});
        double pinhole = 0;
        for (auto const& lens : lenses) {
            auto camera = scene::resized(through(lens, at_the_start(name, scene.camera), false), 160, 90);
            auto row = map_sequence({scene.map, camera}, options.data, options.quick ? 8 : 60, options.threads);
            if (pinhole == 0) pinhole = row.ate;
            table.add_row({name, lens.name, std::to_string(row.frames), std::to_string(row.lost), bench::scientific(row.ate, 2), fixed(row.ate / pinhole, 2),
                           fixed(row.psnr, 1)});
            csv += name + "," + lens.name + "," + std::to_string(row.frames) + "," + std::to_string(row.lost) + "," + bench::scientific(row.ate, 4) + "," +
                   fixed(row.ate / pinhole, 3) + "," + fixed(row.psnr, 2) + "\n";
        }
    }
    std::cout << table;
    if (!options.csv.empty()) report::write_whole(options.csv, csv);
    return 0;
}

/// The tables that have a row for each scene and lens.
int run_scenes(Options const& options)
{
    report::Table table = options.frames ? report::Table{{"scene", "lens", "pinhole, ms", "lens / pinhole", "exact rays / pinhole", "exact rays, lens / pinhole"}}
                                         : report::Table{{"scene", "lens", "Gaussians", "centre p99, px", "covariance p99"}};
    std::string csv = options.frames ? "scene,lens,pinhole_ms,lens,exact_pinhole,exact_lens\n" : "scene,lens,gaussians,centre_p99_px,covariance_p99\n";
    for (auto const& name : options.scenes) {
        if (!bench::has_scene(name, options.data)) {
            bench::say_skipped(name);
            continue;
        }
        auto const scene = bench::load_scene(name, options.data, {640, 480});
        for (auto const& lens : lenses) {
            auto const camera = through(lens, at_the_start(name, scene.camera), options.quick);
            std::vector<std::string> row{name, lens.name};
            if (options.frames) {
                auto const t = time_frames(scene.map, camera, options.rounds, options.threads);
                for (double const v : {t.pinhole_ms, t.lens, t.exact_pinhole, t.exact_lens}) row.push_back(fixed(v, 3));
            } else {
                auto const m = sample_moments(scene.map.gaussians, camera, options.quick ? 400 : 4000);
                row.push_back(std::to_string(m.gaussians)), row.push_back(fixed(m.centre_px, 4)), row.push_back(fixed(m.covariance, 5));
            }
            for (std::size_t i = 0; i < row.size(); ++i) csv += row[i] + (i + 1 < row.size() ? "," : "\n");
            table.add_row(row);
        }
    }
    std::cout << table;
    if (!options.csv.empty()) report::write_whole(options.csv, csv);
    return 0;
}

int run(Options options)
{
    bench::expect_folder_of(options.csv);
    if (options.quick) options.rounds = std::min(options.rounds, 3u);
    if (options.scenes.empty()) options.scenes = options.quick ? std::vector<std::string>{"built_in"} : std::vector<std::string>{"sloth", "salad", "built_in"};
    if (options.sequences) return run_sequences(options);
    if (options.shutters) return run_shutters(options);
    if (options.frames || options.moments) return run_scenes(options);
    std::vector<Row> out;
    bool broken = false;
    for (auto const& name : options.scenes) {
        if (!bench::has_scene(name, options.data)) {
            bench::say_skipped(name);
            continue;
        }
        auto const scene = bench::load_scene(name, options.data, {640, 480});
        auto const start = at_the_start(name, scene.camera);
        auto const& gaussians = scene.map.gaussians;
        auto const n = static_cast<std::uint32_t>(gaussians.size());
        splat::Rules const rules;
        std::vector<splat::View> views;
        std::vector<std::vector<double>> ns(std::size(lenses)), ratios(std::size(lenses));
        for (auto const& lens : lenses) {
            auto const camera = through(lens, start, options.quick);
            views.push_back(splat::make_view(camera, rules));
            Row row{name, lens.name};
            auto const conics = report::render_naive(gaussians, camera, rules);
            auto const exact = report::render_exact_rays(gaussians, camera, rules, options.threads);
            double squares = 0, count = 0;
            for (std::size_t i = 0; i < exact.rgb.size(); ++i) {
                if (!std::isfinite(conics.rgb[i])) ++row.not_finite;
                if (std::isnan(exact.rgb[i])) continue;
                double const error = std::fabs(std::clamp(double{conics.rgb[i]}, 0.0, 1.0) - std::clamp(double{exact.rgb[i]}, 0.0, 1.0));
                squares += error * error, ++count;
                row.largest = std::max(row.largest, error);
            }
            row.psnr = 10 * std::log10(count / squares);
            broken = broken || row.not_finite != 0;
            out.push_back(row);
        }
        std::vector<splat::Splat> splats(n);
        auto const tiling = splat::make_tiling(640, 480, 16, 16);
        auto const time = [&](splat::View const& view) {
            bench::Stopwatch watch;
            for (int k = 0; k < 4; ++k) splat::project_all(gaussians.data(), n, view, tiling, splats.data());
            return watch.lap() * 1e6 / (4.0 * n);
        };
        for (std::uint32_t round = 0; round < options.rounds + 2; ++round)
            for (std::size_t i = 0; i < std::size(lenses); ++i) {
                auto straight = views[i]; // a pinhole of the same focal lengths: it shows about as many records
                straight.camera.lens = {};
                double const bent = time(views[i]), pinhole = time(straight);
                if (round >= 2) ns[i].push_back(bent), ratios[i].push_back(bent / pinhole);
            }
        for (std::size_t i = 0; i < std::size(lenses); ++i) {
            auto& row = out[out.size() - std::size(lenses) + i];
            row.ns = bench::median(ns[i]), row.ratio = bench::median(ratios[i]);
        }
    }
    report::Table table{{"scene", "lens", "PSNR of J against E, dB", "largest", "not finite", "ns a record", "over a pinhole"}};
    std::string csv = "scene,lens,psnr_db,largest,not_finite,ns_a_record,over_pinhole\n";
    for (auto const& r : out) {
        table.add_row({r.scene, r.lens, fixed(r.psnr, 1), fixed(r.largest, 3), fixed(r.not_finite, 0), fixed(r.ns, 2), fixed(r.ratio, 3)});
        csv += r.scene + "," + r.lens + "," + fixed(r.psnr, 3) + "," + fixed(r.largest, 5) + "," + fixed(r.not_finite, 0) + "," + fixed(r.ns, 3) + "," +
               fixed(r.ratio, 4) + "\n";
    }
    std::cout << table;
    if (!options.csv.empty()) report::write_whole(options.csv, csv);
    if (broken) throw Error("a picture with values that are not finite (a lens breaks the projection); report it");
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    return bench::program<Options>(argc, argv, table_of, run, "the scenes do not fit into memory (a map and its pictures are held); name one with --scene");
}
