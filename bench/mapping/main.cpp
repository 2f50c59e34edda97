// How well, how fast and over which ways does a map follow pictures?
#include <algorithm>
#include <array>
#include <cmath>
#include <common/options.hpp>
#include <common/program.hpp>
#include <common/statistics.hpp>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <memory>
#include <numeric>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/mapping/refiner.hpp>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <tilemesh/splat/footprint.hpp>
#include <utility>
#include <vector>

namespace {

using namespace tilemesh;
using bench::fixed;
using report::thousands;

inline char const* const scene_names[] = {"built_in", "sloth", "salad"};
inline char const* const table_names[] = {"psnr", "times", "back"};

struct Options : bench::Options {
    std::vector<std::string> scenes, tables; ///< empty: all
    std::uint32_t steps = 160, rounds = 9;
};
Options parse(std::vector<std::string> const& all)
{
    Options o;
    for (bench::Words words(all); words.next();) {
        auto const& option = words.option();
        if (o.take(words)) continue;
        if (option == "--scene") o.scenes.push_back(words.one_of(scene_names));
        else if (option == "--table") o.tables.push_back(words.one_of(table_names));
        else if (option == "--steps") o.steps = words.number(1, 100'000);
        else if (option == "--rounds") o.rounds = words.number(1, 10'000);
        else words.refuse();
    }
    o.finish();
    if (!o.csv.empty()) bench::expect_folder_of(o.csv);
    if (o.quick) {
        o.rounds = std::min(o.rounds, 3u);
        if (o.scenes.empty()) o.scenes = {"built_in"};
    }
    return o;
}
std::string help()
{
    return std::string("Usage: mapping [options]\n"
                       "Refines spoilt maps by pictures of the true map: how well, how fast, and over which ways slopes would go back.\n"
                       "\n"
                       "  --table NAME     psnr   PSNR by steps and optimiser: 8 views of 160 x 90, all parameters off\n"
                       "                   times  ms of a picture and of a step at 640 x 480, by threads\n"
                       "                   back   messages of the way back and their distances, 1280 x 720 on 40 x 36 tiles\n"
                       "                   may be repeated. Default: all\n"
                       "  --scene NAME     built_in, sloth or salad; may be repeated. Default: all\n"
                       "  --steps N        steps of psnr. Default: 160\n"
                       "  --rounds N       measured rounds of times. Default: 9\n"
                       "  --quick          the built-in map unless a scene is named; at most 3 rounds\n"
                       "  --csv FILE       write psnr: scene,optimiser,start,at_8,at_40,at_80,end,held_out_start,held_out_end\n") +
           bench::help_of_data + "  --help           this text\n\n" + bench::help_of_exit;
}

/// A map and views of it: every second one is held out.
struct Scene {
    std::string name;
    scene::Map map;
    splat::Camera camera; ///< 160 x 90
    std::vector<splat::Camera> path;
};
/// The scenes asked for; it says which are not there.
std::vector<Scene> scenes_of(Options const& o)
{
    std::vector<Scene> out;
    for (std::string const name : scene_names) {
        if (!bench::chosen(o.scenes, name)) continue;
        if (name == "built_in") {
            Scene s{name, scene::built_in_map(), scene::built_in_camera({160, 90}), {}};
            for (auto const& c : scene::orbit(s.camera, scene::robust_centre(s.map), 16.0, 16)) s.path.push_back(c);
            out.push_back(std::move(s));
            continue;
        }
        auto const file = o.data / "maps" / (name + ".ply");
        if (o.data.empty() || !std::filesystem::exists(file)) {
            std::cout << "skipped: " << name << " (its map is not there; name its folder with --data)\n";
            continue;
        }
        auto const cameras = scene::select_cameras(scene::load_cameras(o.data / "cameras.json"), name + "/front", name);
        Scene s{name, scene::load_map(file), scene::resized(cameras.front().camera, 160, 90), {}};
        auto const poses = scene::relative_to_first(scene::load_trajectory(o.data / "trajectories" / "fr1_xyz.tum"),
                                                    scene::pose_of(s.camera));
        for (std::size_t k = 0; k < poses.size() && s.path.size() < 16; k += 25) s.path.push_back(scene::make_camera(poses[k].pose,
            scene::lens_of(s.camera)));
        out.push_back(std::move(s));
    }
    return out;
}

/// SplitMix64: the same numbers with every library.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    double uniform()
    {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
    }
    float normal() { return static_cast<float>(std::sqrt(-2 * std::log(1 - uniform())) * std::cos(6.283185307179586 * uniform())); }

private:
    std::uint64_t state_;
};
scene::Map spoilt(scene::Map map, float depth)
{
    Random random(3);
    for (auto& g : map.gaussians) {
        for (int i = 0; i < 3; ++i) {
            g.mean_world[i] += 0.005f * depth * random.normal();
            g.log_scale[i] += 0.3f * random.normal();
            g.colour[i] = std::max(0.0f, g.colour[i] + 0.1f * random.normal());
        }
        for (float& q : g.rotation) q += 0.1f * random.normal();
        float const o = std::clamp(g.opacity, 1e-4f, 0.9999f);
        g.opacity = 1 / (1 + (1 - o) / o * std::exp(0.5f * random.normal()));
    }
    return map;
}
float median_depth(mapping::Target const& target)
{
    std::vector<double> depths;
    for (auto const& p : target.pixels)
        if (p.depth > 0) depths.push_back(double{p.depth});
    if (depths.empty()) throw Error("the first view shows nothing (no pixel is half covered); name another --scene");
    return static_cast<float>(bench::median(depths));
}
mapping::RefineOptions options_for(std::uint32_t threads)
{
    mapping::RefineOptions o;
    o.view.threads = threads;
    o.view.loss.depth = 0.5f;
    return o;
}

struct Views {
    std::vector<splat::Camera> cameras;
    std::vector<mapping::Target> targets;
};
template <class Refiner>
double mean_psnr(Refiner& refiner, Views const& views, std::size_t first)
{
    double sum = 0, n = 0;
    for (std::size_t i = first; i < views.cameras.size(); i += 2, ++n) sum += refiner.measure(views.cameras[i], views.targets[i]).psnr_db();
    return sum / n;
}
/// A row of `psnr`. Returns the PSNR at the end.
template <class Optimiser>
double refine(Options const& o, Scene const& s, Views const& views, scene::Map const& start, float depth, std::string& csv)
{
    mapping::Refiner<Optimiser> refiner(start, options_for(1));
    double const before = mean_psnr(refiner, views, 0), held_before = mean_psnr(refiner, views, 1);
    std::array<double, 3> at{};
    constexpr std::array<std::uint32_t, 3> stages{8, 40, 80};
    Random random(9);
    std::vector<std::size_t> deck;
    bench::Stopwatch watch;
    double ms = 0;
    for (std::uint32_t i = 0; i < o.steps; ++i) {
        if (deck.empty()) {
            for (std::size_t k = 0; k < views.cameras.size(); k += 2) deck.push_back(k);
            for (std::size_t k = deck.size(); k > 1; --k) {
                auto const other = static_cast<std::size_t>(random.uniform() * static_cast<double>(k));
                std::swap(deck[k - 1], deck[other]);
            }
        }
        watch.lap();
        refiner.step(views.cameras[deck.back()], views.targets[deck.back()],
                     splat::map::faded(splat::map::usual_rates(depth), static_cast<float>(i) / static_cast<float>(o.steps)));
        ms += watch.lap();
        deck.pop_back();
        for (std::size_t k = 0; k < stages.size(); ++k)
            if (i + 1 == stages[k]) at[k] = mean_psnr(refiner, views, 0);
    }
    double const after = mean_psnr(refiner, views, 0), held_after = mean_psnr(refiner, views, 1);
    std::cout << "| " << s.name << " | " << Optimiser::name;
    for (double const v : {before, at[0], at[1], at[2], after, held_before, held_after}) std::cout << " | " << fixed(v, 2);
    std::cout << " | " << fixed(ms / o.steps, 1) << " |\n";
    csv += s.name + "," + Optimiser::name;
    for (double const v : {before, at[0], at[1], at[2], after, held_before, held_after}) csv += "," + fixed(v, 4);
    csv += "\n";
    return after;
}
int psnr(Options const& o, std::vector<Scene> const& scenes)
{
    std::cout << "\nPSNR in dB by steps, one view a step; means of 8 views of 160 x 90, and of 8 others that are held out\n\n"
              << "| map | optimiser | start | 8 | 40 | 80 | " << o.steps
                  << " | held out, start | end | host ms a step |\n|---|---|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    int status = 0;
    std::string csv = "scene,optimiser,start,at_8,at_40,at_80,end,held_out_start,held_out_end\n";
    for (auto const& s : scenes) {
        Views views{s.path, {}};
        mapping::Refiner<> truth(s.map);
        for (auto const& c : views.cameras) {
            auto const seen = truth.render(c);
            views.targets.push_back(mapping::make_target(seen.colour, seen.depth));
        }
        float const depth = median_depth(views.targets[0]);
        auto const start = spoilt(s.map, depth);
        double const by_kind = refine<splat::map::SecondMomentByKind>(o, s, views, start, depth, csv);
        refine<splat::map::Adam>(o, s, views, start, depth, csv);
        double const least = s.name == "sloth" ? 39.5 : s.name == "salad" ? 37.8 : 0;
        if (o.steps >= 160 && by_kind < least) {
            std::cout << "FAILED: " << s.name << " is below " << fixed(least, 1) << " dB\n";
            status = 1;
        }
    }
    if (!o.csv.empty()) report::write_whole(o.csv, csv);
    return status;
}

void times(Options const& o, std::vector<Scene> const& scenes)
{
    std::cout << "\nHost ms at 640 x 480, medians of " << o.rounds
        << " rounds: the picture with its loss (projection, sorting, first walk), and a step\n\n"
              << "| map | threads | picture | step | step - picture, over the picture |\n|---|--:|--:|--:|--:|\n";
    for (auto const& s : scenes) {
        auto const camera = scene::resized(s.camera, 640, 480);
        mapping::Refiner<> truth(s.map);
        auto const seen = truth.render(camera);
        auto const target = mapping::make_target(seen.colour, seen.depth);
        float const depth = median_depth(target);
        std::vector<std::unique_ptr<mapping::Refiner<>>> refiners;
        std::array<std::vector<double>, 2> picture, step;
        for (std::uint32_t threads : {1u, 2u}) refiners.push_back(std::make_unique<mapping::Refiner<>>(spoilt(s.map, depth),
            options_for(threads)));
        bench::Stopwatch watch;
        for (std::uint32_t round = 0; round <= o.rounds; ++round)
            for (std::size_t i = 0; i < 2; ++i) {
                watch.lap();
                refiners[i]->measure(camera, target);
                double const first = watch.lap();
                refiners[i]->step(camera, target, splat::map::usual_rates(depth));
                double const all = watch.lap();
                if (round != 0) picture[i].push_back(first), step[i].push_back(all);
            }
        for (std::size_t i = 0; i < 2; ++i) {
            double const a = bench::median(picture[i]), b = bench::median(step[i]);
            std::cout << "| " << s.name << " | " << i + 1 << " | " << fixed(a, 1) << " | " << fixed(b, 1) << " | "
                << fixed((b - a) / a, 2) << " |\n";
        }
    }
}

/// The way back on a mesh: a copy of a splat returns its sums to its parent in the tree of bloom, which adds its own. So each copy sends
/// one message over one hop. Without merging, a copy's message goes all the way.
void back(std::vector<Scene> const& scenes)
{
    std::cout << "\nThe way back, 1280 x 720 on 40 x 36 tiles of 32 x 20. A message is 44 bytes. Shares: copies within so many hops of\n"
                 "their anchor\n\n"
                 "| map | splats | copies = messages | MB | hops if not merged | within 1 | 2 | 4 | 8 | farthest | fullest tile |\n"
                 "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    for (auto const& s : scenes) {
        auto const camera = scene::resized(s.camera, 1280, 720);
        auto const view = splat::make_view(camera, mapping::refining_rules());
        auto const tiling = splat::make_tiling(1280, 720, 32, 20);
        std::uint64_t splats = 0, copies = 0, hops = 0;
        std::uint32_t farthest = 0;
        std::array<std::uint64_t, 4> within{};
        std::vector<std::uint32_t> of_tile(std::size_t{tiling.columns} * tiling.rows, 0);
        for (auto const& g : s.map.gaussians) {
            auto const splat = splat::project(g, view, tiling);
            if (!splat.visible()) continue;
            ++splats;
            auto const box = splat::tiles_of(splat, tiling);
            for (std::uint32_t y = box.first.y(); y <= box.last.y(); ++y)
                for (std::uint32_t x = box.first.x(); x <= box.last.x(); ++x) {
                    auto const apart = [](std::uint32_t a, std::uint32_t b) { return a < b ? b - a : a - b; };
                    std::uint32_t const away = apart(x, splat.anchor.x()) + apart(y, splat.anchor.y());
                    if (away == 0) continue;
                    ++copies, hops += away, ++of_tile[std::size_t{y} * tiling.columns + x];
                    farthest = std::max(farthest, away);
                    for (std::size_t k = 0; k < 4; ++k) within[k] += away <= 1u << k ? 1 : 0;
                }
        }
        double const all = std::max(1.0, static_cast<double>(copies));
        auto const share = [&](std::uint64_t n) { return fixed(100.0 * static_cast<double>(n) / all, 0) + " %"; };
        std::cout << "| " << s.name << " | " << thousands(splats) << " | " << thousands(copies) << " | "
            << fixed(static_cast<double>(copies) * 44e-6, 1) << " | " << thousands(hops);
        for (auto const n : within) std::cout << " | " << share(n);
        std::cout << " | " << farthest << " | " << thousands(*std::max_element(of_tile.begin(), of_tile.end())) << " |\n";
    }
}

int run(Options const& o)
{
    auto const scenes = scenes_of(o);
    auto const wants = [&](char const* table) { return bench::chosen(o.tables, table); };
    int status = 0;
    if (wants("psnr")) status = psnr(o, scenes);
    if (wants("times")) times(o, scenes);
    if (wants("back")) back(scenes);
    return status;
}

} // namespace

int main(int argc, char** argv)
{
    return bench::program(argc, argv, parse, help, run, "not enough memory (each scene has a map and its views); name one --scene");
}
