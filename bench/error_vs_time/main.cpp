// Error against run time: the cost and the error of each setting.
#include "csv.hpp"
#include "findings.hpp"
#include "front.hpp"
#include "measure.hpp"
#include "settings.hpp"
#include <algorithm>
#include <common/program.hpp>
#include <common/statistics.hpp>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <thread>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <tilemesh/scene/records.hpp>
#include <vector>

namespace {

using namespace error_vs_time;
using shared::option;

struct Options : bench::Options {
    std::vector<std::string> scenes;
    std::vector<std::string> settings;      ///< measured in addition to the default; empty: all
    tilemesh::scene::Size size{0, 0};       ///< 0: the size of the quick or the full run
    std::uint32_t threads = std::max(1u, std::thread::hardware_concurrency());
    std::uint32_t rounds = 0; ///< 0: as in the quick or the full run
    std::filesystem::path out, pfm;
    bool single_views = false;
    bool list = false;                      ///< print the names of the settings, and measure nothing

    void finish(shared::OptionTable const& given);
};

/// Mk2 has tiles for 1280 x 720. Below 40 x 36 pixels a picture shows nothing.
void set_size(Options& o, shared::OptionValue const& given)
{
    o.size = {static_cast<std::uint32_t>(given.three[0]), static_cast<std::uint32_t>(given.three[1])};
    if (o.size.width < 40 || o.size.height > 720) throw shared::Misfit{"it takes WxH, 40 to 1280 by 36 to 720"};
}

constexpr auto all_scenes = shared::words_of(bench::scene_names);
constexpr shared::Option<Options> rows_of_options[] = {
    shared::words<&Options::scenes>("scene", "NAME", "{}; may be repeated [all, quick without playbot_250k]", all_scenes),
    option<&Options::settings>("setting", "NAME",
                               "measure this setting beside the default; may be repeated. The front holds measured settings only [all]"),
    option<&Options::list>("list", "", "print the names of all settings"),
    {{"size",
      "WxH",
      "size of a frame, 40x36 to 1280x720 [1280x720, quick 640x360]",
      shared::Form::size,
      36,
      1280,
      {},
      {},
      "640x360",
      "it takes WxH, 40 to 1280 by 36 to 720"},
     set_size},
    option<&Options::rounds>("rounds", "N",
                             "timed rounds; a claim needs 3, and 10 of the default setting, which runs in each batch of 22 settings [15, quick 5]",
                             {1, 1000}),
    option<&Options::single_views>("no-sequences", "", "single views only"),
    option<&Options::out>("out", "DIR", "write plots"),
    option<&Options::pfm>(
        "pfm", "DIR",
        "for default, on_sensor and \"drop 5 slots\", write the pictures of the mesh (MAP_SETTING_mesh.pfm), of the whole frame in float32 "
        "(_whole), in double with the cut-offs (_cut), and of the reference (_reference)"),
    option<&Options::threads>(
        "threads", "N", "threads that compute errors; results do not depend on them; times are always of one thread [all host threads]", {1, 1024})};
void Options::finish(shared::OptionTable const& given)
{
    bench::Options::finish(given);
    auto const all = error_vs_time::settings();
    for (auto const& name : settings)
        if (std::none_of(all.begin(), all.end(), [&](Setting const& s) { return s.name == name; }))
            throw tilemesh::Error("--setting cannot be \"" + name +
                                  "\" (no setting has that name); write for example --setting viewing, or see --list");
}

shared::OptionTable table_of(Options& own)
{
    return bench::table_of({"error_vs_time",
                            "Measures the cost and the error of some 170 settings per map. The error is against the picture in double\n"
                            "precision without cut-offs, split into the parts of the cut-offs, of rounding and of the mesh. Costs are\n"
                            "pairs, modelled time and host time. Prints the Pareto-optimal settings.\n",
                            "smaller frames, fewer rounds, one short sequence a map; below 6 minutes on two cores",
                            "write a line per setting, with everything needed to repeat it"},
                           own, rows_of_options);
}

std::string cpu_name()
{
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.rfind("model name", 0) == 0 && line.find(": ") != std::string::npos) return line.substr(line.find(": ") + 2);
    return "";
}
Provenance provenance(Options const& options, std::uint32_t rounds)
{
    Provenance from;
#if defined(__clang__)
    from.compiler = "Clang " __clang_version__;
#elif defined(__GNUC__)
    from.compiler = "GCC " __VERSION__;
#endif
    from.cpu = cpu_name();
    from.git = TILEMESH_GIT;
    from.build = TILEMESH_BUILD_TYPE;
    from.command = std::string("error_vs_time") + (options.quick ? " --quick" : "") + (options.single_views ? " --no-sequences" : "") +
                   (options.spoil ? " --spoil" : "");
    if (options.size.width != 0)
        from.command += " --size " + std::to_string(options.size.width) + "x" + std::to_string(options.size.height);
    for (auto const& s : options.scenes) from.command += " --scene " + s;
    for (auto const& s : options.settings) from.command += " --setting \"" + s + "\"";
    if (options.rounds != 0) from.command += " --rounds " + std::to_string(options.rounds);
    from.native = TILEMESH_IS_NATIVE != 0;
    from.threads = options.threads;
    from.rounds = rounds;
    return from;
}

/// The motions whose sequences are measured.
std::vector<std::string> motions_of(Options const& options)
{
    if (options.single_views) return {};
    if (options.quick) return {"orbit2"};
    return {"orbit0.5", "orbit2", "teleport", "fr1_xyz", "fr2_desk"};
}

/// The default, which comes first, and the settings that the options name.
std::vector<Setting> chosen_of(std::vector<Setting> const& all, Options const& options)
{
    std::vector<Setting> out;
    for (auto const& s : all)
        if (out.empty() || bench::chosen(options.settings, s.name)) out.push_back(s);
    return out;
}

int run(Options const& options)
{
    if (options.list) {
        for (auto const& s : settings()) std::cout << s.name << "\n";
        return 0;
    }
    bench::expect_folder_of(options.csv);
    bench::make_folder(options.out, "--out");
    bench::make_folder(options.pfm, "--pfm");
    auto size = options.quick ? tilemesh::scene::Size{640, 360} : tilemesh::scene::Size{1280, 720};
    if (options.size.width != 0) size = options.size;
    MeasureOptions measure;
    measure.threads = options.threads;
    measure.rounds = options.rounds != 0 ? options.rounds : options.quick ? 5 : 15;
    measure.pfm = options.pfm;
    measure.spoil = options.spoil;
    bench::Stopwatch watch;
    double seconds = 0;
    measure.progress = [&](std::string const& what) {
        seconds += watch.lap() / 1000;
        std::cerr << bench::fixed(seconds, 0) << " s: " << what << "\n";
    };

    std::vector<Row> rows;
    std::vector<Noise> noise;
    std::vector<std::string> skipped;
    auto const write = [&] {
        if (!options.csv.empty()) tilemesh::report::write_whole(options.csv, csv(rows, noise, provenance(options, measure.rounds)));
    };
    for (std::string const name : bench::scene_names) {
        if (!bench::chosen(options.scenes, name)) continue;
        if (options.scenes.empty() && options.quick && name == "playbot_250k") {
            skipped.push_back("playbot_250k (--quick leaves out the map of 250,000 Gaussians)");
            continue;
        }
        if (!bench::has_scene(name, options.data)) {
            skipped.push_back(name + " (its map is not there; name its folder with --data)");
            continue;
        }
        auto scene = bench::load_scene(name, options.data, size);
        scene.map = tilemesh::scene::at_degree(std::move(scene.map), 0);
        scene.map.name = name;
        noise.emplace_back();
        for (auto& row : measure_view(scene, chosen_of(settings(), options), measure, noise.back())) rows.push_back(std::move(row));
        for (auto const& motion : motions_of(options)) {
            if (!bench::has_motion(motion, options.data)) {
                skipped.push_back(name + " with " + motion + " (its trajectory is not there; name its folder with --data)");
                continue;
            }
            for (auto& row : measure_sequence(scene, motion, options.quick ? 6 : 12, options.data,
                                              chosen_of(settings_of_sequences(), options), measure))
                rows.push_back(std::move(row));
        }
        mark_fronts(rows);
        write(); // so that finished results are not lost: a full run takes an hour
    }
    if (rows.empty()) write();
    std::vector<std::string> const standing = {
        "One view a map decides the fronts, 2 degrees after the scene's own camera; the first view's records stand when it begins.",
        "Records keep one colour: harmonics above degree 0 are left out of maps that have them.",
        "Modelled time is of no machine: `mk2()` charges a pair as a pair, whatever the arithmetic, the shape or the key; what records in "
        "half precision would save of storage is not modelled.",
        "Error is against the model's own formula (EWA, +0.3, the clamp of the Jacobian), not against a photograph.",
    };
    print_tables(std::cout, rows, noise, skipped, standing);
    if (rows.empty())
        throw tilemesh::Error("nothing was measured (no map that was asked for is there); name the folder of the maps with --data");
    if (!options.out.empty())
        for (auto const& sentence : write_plots(options.out, rows)) std::cout << sentence << "\n";
    auto const verdict = verdict_of(rows);
    std::cout << verdict;
    return verdict.holds() ? 0 : 1;
}

} // namespace

int main(int argc, char** argv)
{
    return bench::program(argc, argv, table_of, run, "not enough memory (24 machines take turns); try --quick, or a smaller --size");
}
