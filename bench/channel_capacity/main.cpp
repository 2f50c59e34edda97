// The value of a channel slot: PSNR, exchanges, losses and modelled time for splits of a tile's SRAM between channels and storage. And the
// delay of Gaussians if the hops per frame are bounded.
#include "findings.hpp"
#include "latency.hpp"
#include "options.hpp"
#include "plots.hpp"
#include "sweep.hpp"
#include <common/program.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <map>
#include <mutex>
#include <shared/png.hpp>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/joined_threads.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <vector>

namespace {

using namespace channel_capacity;
using bench::chosen;
using bench::has_motion;
using bench::has_scene;
using bench::load_scene;

/// Runs the jobs in order on `threads` threads. When all are done, it throws the exception of the first job that failed.
void run_all(std::vector<std::function<void()>> const& jobs, std::uint32_t threads)
{
    std::atomic<std::size_t> next{0};
    std::mutex mutex;
    std::exception_ptr failure;
    auto const work = [&] {
        for (std::size_t i; (i = next.fetch_add(1)) < jobs.size();) {
            try {
                jobs[i]();
            } catch (...) {
                std::lock_guard const lock(mutex);
                if (!failure) failure = std::current_exception();
                next = jobs.size();
            }
        }
    };
    tilemesh::JoinedThreads others;
    for (std::uint32_t t = 1; t < std::min<std::size_t>(threads, jobs.size()); ++t) others.start(work);
    work();
    others.join();
    if (failure) std::rethrow_exception(failure);
}

SweepPlan plan_of(std::string const& scene, bool quick)
{
    if (quick) return {{1, 5, 20, 80, 200}, {1000, 350, 1}, 2};
    // Ten times as many records: fewer settings and frames.
    if (scene == "playbot_250k") return {{1, 4, 15, 50, 120, 200}, {1500, 1000, 400, 50, 1}, 3};
    return {{1, 2, 4, 8, 15, 30, 50, 80, 120, 200, 280}, {900, 600, 400, 100, 1}, 4};
}

/// The results of one motion, or of one bound on hops.
struct Part {
    std::string scene, motion;
    std::vector<Row> rows;
    std::vector<std::string> broken;
};
struct LatencyPart {
    std::string scene;
    Latency latency;
    std::vector<std::string> broken;
};

int run(Options const& options)
{
    auto const begin = std::chrono::steady_clock::now();
    tilemesh::scene::Size const size = options.quick ? tilemesh::scene::Size{640, 360} : tilemesh::scene::Size{1280, 720};
    tilemesh::scene::Size const small{320, 180}; // for latency: distances are in tiles, so any size gives the same

    // The measurements. The most expensive motions begin first, so that no thread is left alone with them.
    std::map<std::string, Scene> scenes, small_scenes;
    std::vector<Part> parts;
    std::vector<LatencyPart> latencies;
    for (std::string const name : scene_names) {
        if (!chosen(options.scenes, name)) continue;
        if (options.quick && options.scenes.empty() && name != "sloth" && name != "built_in") continue;
        if (!has_scene(name, options.data)) {
            std::cout << "skipped: " << name << " (its map is not there; name its folder with --data)\n";
            continue;
        }
        scenes.emplace(name, load_scene(name, options.data, size));
        for (std::string const motion : motion_names) {
            if (!chosen(options.motions, motion)) continue;
            if (options.quick && options.motions.empty() && (motion == "orbit0.1" || motion == "orbit2" || motion == "fr2_desk")) continue;
            if (!has_motion(motion, options.data))
                std::cout << "skipped: " << name << " with " << motion << " (its trajectory is not there; name its folder with --data)\n";
            else parts.push_back({name, motion, {}, {}});
        }
        // Not for 250,000 records: to follow them takes minutes, and the rule is the same.
        if (!chosen(options.motions, "teleport") || name == "playbot_250k") continue;
        small_scenes.emplace(name, load_scene(name, options.data, small));
        for (std::uint32_t const hops : {1u, 2u, 4u, 8u})
            if (!options.quick || hops == 1 || hops == 4)
                latencies.push_back({name, {}, {}}), latencies.back().latency.rows.push_back({.scene = name, .hops = hops});
    }
    for (auto const* file : {&options.csv, &options.latency}) bench::expect_folder_of(*file);
    if (!options.plots.empty()) {
        std::error_code why;
        std::filesystem::create_directories(options.plots, why);
        if (!std::filesystem::is_directory(options.plots))
            throw tilemesh::Error("cannot make the folder " + options.plots.string() + " (" + why.message() +
                                  "); name another with --plots");
    }

    std::mutex mutex;
    std::size_t done = 0;
    std::vector<std::function<void()>> jobs;
    auto const add = [&](std::string const& what, std::function<void()> work) {
        jobs.push_back([&, what, work = std::move(work)] {
            work();
            std::lock_guard const lock(mutex);
            auto const seconds = std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now() - begin).count();
            std::cerr << "[" << ++done << "/" << jobs.size() << "] " << what << " (" << seconds << " s)\n";
        });
    };
    std::vector<Part*> order;
    for (auto& part : parts) order.push_back(&part);
    auto const cost = [&](Part const& p) {
        return scenes.at(p.scene).map.gaussians.size() * (p.motion == "teleport" ? 4u : p.motion == "static" ? 1u : 2u);
    };
    std::stable_sort(order.begin(), order.end(), [&](auto const* a, auto const* b) { return cost(*a) > cost(*b); });
    for (auto* part : order)
        add(part->scene + " " + part->motion, [&options, &scenes, part] {
            part->rows = sweep(scenes.at(part->scene), part->motion, plan_of(part->scene, options.quick), options.data, part->broken);
        });
    for (auto& part : latencies)
        add(part.scene + " latency", [&options, &small_scenes, &part] {
            auto const hops = part.latency.rows.front().hops;
            part.latency = follow(small_scenes.at(part.scene), "teleport", hops, options.data, part.broken);
        });
    run_all(jobs, options.threads);

    // The findings.
    std::vector<Row> rows;
    std::vector<LatencyRow> latency;
    std::vector<std::string> broken;
    for (auto& part : parts) {
        rows.insert(rows.end(), part.rows.begin(), part.rows.end());
        broken.insert(broken.end(), part.broken.begin(), part.broken.end());
    }
    for (auto& part : latencies) {
        latency.insert(latency.end(), part.latency.rows.begin(), part.latency.rows.end());
        broken.insert(broken.end(), part.broken.begin(), part.broken.end());
    }
    if (!options.csv.empty()) tilemesh::report::write_whole(options.csv, csv(rows));
    if (!options.latency.empty()) tilemesh::report::write_whole(options.latency, csv(latency));
    if (!options.plots.empty()) {
        write_plots(options.plots, rows, latency);
        for (auto const& [name, scene] : scenes)
            shared::write_png(options.plots / (name + "_saturated.png"), saturated_pair(scene, "static", 8, {384, 288}, options.data));
    }
    for (auto const& [name, scene] : scenes) {
        tilemesh::report::Table table{
            {"motion", "policy", "channel knee", "its storage", "exchanges there", "storage is missing from", "best lacks"}};
        for (auto const* motion : motion_names)
            for (auto const saturation : {Saturation::hold, Saturation::drop, Saturation::homes}) {
                auto const one = select(rows, name, motion, saturation);
                if (one.empty()) continue;
                auto const knee = knee_of(one);
                auto const at = std::find_if(one.begin(), one.end(), [&](Row const& r) { return r.capacity == knee.channel; });
                table.add_row({motion, to_string(saturation), std::to_string(knee.channel),
                               tilemesh::report::thousands(knee.channel_storage), tilemesh::report::thousands(at->exchanges / at->frames),
                               knee.storage == 0 ? "-" : std::to_string(knee.storage),
                               knee.complete ? "nothing"
                                             : std::to_string(at->missing * 1000 / std::max<std::uint64_t>(at->wanted, 1)) + " in 1,000"});
            }
        std::cout << "\n" << name << ": " << tilemesh::report::thousands(scene.map.gaussians.size()) << " Gaussians\n" << table;
        tilemesh::report::Table best{
            {"Pareto front of", "policy", "slots a channel", "storage", "PSNR, dB", "modelled ms", "of it exchange"}};
        for (auto const* motion : motion_names) {
            auto const all = by_time(rows, name, motion);
            auto const front = pareto_front(all);
            for (std::size_t i = 0; i < all.size(); ++i) {
                auto const& r = all[i];
                auto const cycles = std::max<std::uint64_t>(r.cycles_mean(), 1);
                if (front[i])
                    best.add_row({motion, to_string(r.saturation), std::to_string(r.capacity), tilemesh::report::thousands(r.storage),
                                  fixed(r.worst.psnr_db, 1), milliseconds(r.cycles_most(), 2),
                                  std::to_string((100 * r.exchange_mean() + cycles / 2) / cycles) + " %"});
            }
        }
        std::cout << best;
        for (auto const& sentence : knee_sentences(rows, name)) std::cout << sentence << "\n";
        for (auto const& sentence : homes_sentences(rows, name)) std::cout << sentence << "\n";
        for (auto const& sentence : paper_sentences(rows, name)) std::cout << sentence << "\n";
    }
    std::cout << "\n";
    for (auto const& sentence : latency_sentences(latency)) std::cout << sentence << "\n";
    for (auto const& what : broken) std::cout << "BROKEN: " << what << "\n";
    std::cout << (broken.empty() ? "All that must hold does.\n" : "");
    return broken.empty() ? 0 : 1;
}

} // namespace

int main(int argc, char** argv)
{
    return bench::program(argc, argv, table_of, run,
                          "not enough memory (a motion keeps its pictures, the machines their records); try --threads 1 or --quick");
}
