// How well, how fast and over which ways does a map follow pictures?
#include <algorithm>
#include <array>
#include <cmath>
#include <common/options.hpp>
#include <common/program.hpp>
#include <common/statistics.hpp>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/spec.hpp>
#include <tilemesh/mapping/mesh_refiner.hpp>
#include <tilemesh/mapping/refiner.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/step_costs.hpp>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <tilemesh/splat/map/grow.hpp>
#include <utility>
#include <vector>

namespace {

using namespace tilemesh;
using bench::fixed;
using report::thousands;

constexpr char const* scene_names[] = {"built_in", "sloth", "salad"};
constexpr char const* table_names[] = {"psnr", "times", "mesh"};

struct Options : bench::Options {
    std::vector<std::string> scenes, tables; ///< empty: all
    std::uint32_t steps = 160, rounds = 9;

    void finish(shared::OptionTable const& given)
    {
        bench::Options::finish(given);
        bench::expect_folder_of(csv);
        if (!quick) return;
        rounds = std::min(rounds, 3u);
        if (scenes.empty()) scenes = {"built_in"};
    }
};
constexpr auto all_scenes = shared::words_of(scene_names);
constexpr auto all_tables = shared::words_of(table_names);
constexpr shared::Option<Options> rows[] = {
    shared::words<&Options::tables>(
        "table", "NAME",
        "psnr (PSNR by steps and optimiser: 8 views of 160 x 90, all parameters off) | times (ms of a picture and of a step at 640 x "
        "480, by threads) | mesh (a step as a program on the mesh: messages, supersteps, modelled ms on Mk2); may be repeated [all]",
        all_tables),
    shared::words<&Options::scenes>("scene", "NAME", "{}; may be repeated [all]", all_scenes),
    shared::option<&Options::steps>("steps", "N", "steps of psnr [160]", {1, 100'000}),
    shared::option<&Options::rounds>("rounds", "N", "measured rounds of times [9]", {1, 10'000})};
shared::OptionTable table_of(Options& own)
{
    return bench::table_of({"mapping", "Refines spoilt maps by pictures of the true map: how well, how fast, and over which ways slopes go back.\n",
                            "the built-in map unless a scene is named; at most 3 rounds",
                            "write psnr: scene,optimiser,start,at_8,at_40,at_80,end,held_out_start,held_out_end", false},
                           own, rows);
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
            bench::say_skipped(name);
            continue;
        }
        auto const cameras = scene::select_cameras(scene::load_cameras(o.data / "cameras.json"), name + "/front", name);
        Scene s{name, scene::load_map(file), scene::resized(cameras.front().camera, 160, 90), {}};
        auto const poses = scene::relative_to_first(scene::load_trajectory(o.data / "trajectories" / "fr1_xyz.tum"), scene::pose_of(s.camera));
        for (std::size_t k = 0; k < poses.size() && s.path.size() < 16; k += 25)
            s.path.push_back(scene::make_camera(poses[k].pose, scene::lens_of(s.camera)));
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
Views views_of(Scene const& s, std::vector<splat::Camera> cameras)
{
    Views views{std::move(cameras), {}};
    mapping::Refiner<> truth(s.map);
    for (auto const& c : views.cameras) {
        auto const seen = truth.render(c);
        views.targets.push_back(mapping::make_target(seen.colour, seen.depth));
    }
    return views;
}
/// Every second view, each once in a round and each round in another order.
class Deck {
public:
    explicit Deck(std::size_t views) : views_(views) {}
    std::size_t next()
    {
        if (deck_.empty()) {
            for (std::size_t k = 0; k < views_; k += 2) deck_.push_back(k);
            for (std::size_t k = deck_.size(); k > 1; --k) {
                auto const other = static_cast<std::size_t>(random_.uniform() * static_cast<double>(k));
                std::swap(deck_[k - 1], deck_[other]);
            }
        }
        auto const view = deck_.back();
        deck_.pop_back();
        return view;
    }

private:
    std::size_t views_;
    Random random_{9};
    std::vector<std::size_t> deck_;
};
/// A row of `psnr`. Returns the PSNR at the end.
template <class Optimiser>
double refine(Options const& o, Scene const& s, Views const& views, scene::Map const& start, float depth, std::string& csv)
{
    mapping::Refiner<Optimiser> refiner(start, options_for(1));
    double const before = mean_psnr(refiner, views, 0), held_before = mean_psnr(refiner, views, 1);
    std::array<double, 3> at{};
    constexpr std::array<std::uint32_t, 3> stages{8, 40, 80};
    Deck deck(views.cameras.size());
    bench::Stopwatch watch;
    double ms = 0;
    for (std::uint32_t i = 0; i < o.steps; ++i) {
        auto const view = deck.next();
        watch.lap();
        refiner.step(views.cameras[view], views.targets[view],
                     splat::map::faded(splat::map::usual_rates(depth), static_cast<float>(i) / static_cast<float>(o.steps)));
        ms += watch.lap();
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
        auto const views = views_of(s, s.path);
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
        auto const target = std::move(views_of(s, {camera}).targets[0]);
        float const depth = median_depth(target);
        std::vector<std::unique_ptr<mapping::Refiner<>>> refiners;
        std::array<std::vector<double>, 2> picture, step;
        for (std::uint32_t threads : {1u, 2u}) refiners.push_back(std::make_unique<mapping::Refiner<>>(spoilt(s.map, depth), options_for(threads)));
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
            std::cout << "| " << s.name << " | " << i + 1 << " | " << fixed(a, 1) << " | " << fixed(b, 1) << " | " << fixed((b - a) / a, 2) << " |\n";
        }
    }
}

/// `mk2()` with prices of a mapping step: flops, roots and others counted by hand in the kernels.
CostModel priced_mk2()
{
    namespace d = model_detail;
    auto model = mk2();
    std::string const source = "arithmetic: counted by hand in splat/map/, flops at 0.68 a cycle as in a pair";
    set_price(model, "cast_copy", 66 * d::one_worker, source);
    set_price(model, "map_pair", d::millicycles_of(KernelWork::tenth_flops_a_tracked_pair + 20), source); // a pair, and its depth
    set_price(model, "walked_pair", d::slots_of(44, 1, 10) * d::six_workers, source);
    set_price(model, "pixel_slope", d::slots_of(50, 3, 40) * d::six_workers, source);
    set_price(model, "gathered", 44 * d::six_workers, source);
    set_price(model, "returned", 48 * d::one_worker, source);
    set_price(model, "moved_record", 90 * d::one_worker, source);
    set_price(model, "cell_pixel", d::slots_of(16, 0, 24) * d::one_worker, source);
    set_price(model, "moved_cell", 40 * d::one_worker, source);
    set_price(model, "new_record", d::slots_of(40, 7, 120) * d::one_worker, source);
    set_price(model, "harmonic", d::slots_of(10, 0, 9) * d::six_workers, source);
    set_price(model, "judged", 24 * d::one_worker, source);
    set_price(model, "chain", d::slots_of(500, 20, 150) * d::six_workers, source);
    return model;
}

/// Moves the records to the tiles of another view, and says what that costs.
template <class Refiner>
void rest(Refiner& on_mesh, splat::Camera const& camera, CostModel const& model)
{
    on_mesh.rest(camera);
    auto const cost = model_cost(model, on_mesh.mesh().trace(), on_mesh.mesh().grid());
    std::uint64_t bytes = 0, passes = 0;
    for (auto const& step : on_mesh.run().steps) bytes += step.live_bytes, passes += step.passes;
    std::cout << "(records move: " << thousands(on_mesh.run().messages()) << " hops, " << fixed(static_cast<double>(bytes) * 1e-6, 1) << " MB, "
              << passes << " supersteps, " << fixed(milliseconds(model, cost.cycles), 2) << " ms)\n";
}

/// Two keyframes of a map that grows from nothing, without a step: what the second one costs.
void keyframe(std::vector<splat::Camera> const& cameras, std::vector<mapping::Target> const& targets, float depth, mapping::MeshRefineOptions o,
              CostModel const& model)
{
    o.record_slots = 400;
    mapping::MeshRefiner<splat::map::SecondMomentByKind, Mesh, Traced<AnyMachine>, splat::map::GrowStep> grown({}, cameras[0], o);
    auto const first = grown.insert(cameras[0], targets[0], 1), second = grown.insert(cameras[1], targets[1], 2);
    auto const cycles_of = [&](char const* part) {
        auto const costs = step_costs(grown.mesh().trace(), model_cost(model, grown.mesh().trace(), grown.mesh().grid()));
        auto const& steps = grown.run().steps;
        std::uint64_t cycles = 0;
        for (std::size_t k = 0; k < steps.size(); ++k) cycles += *part == 0 || steps[k].kernel == part ? costs[k].total() : 0;
        return fixed(milliseconds(model, cycles), 2);
    };
    std::uint64_t passed = 0;
    for (auto const& step : grown.run().steps) passed += step.kernel == "pass cells" ? step.messages : 0;
    auto const lost = grown.lost();
    std::cout << "(keyframes: " << thousands(first.inserted) << " and " << thousands(second.inserted) << " Gaussians, "
              << thousands(first.refused + second.refused) << " refused, " << thousands(lost.copies + lost.records)
              << " copies lost; the second takes " << cycles_of("") << " ms: look " << cycles_of("look") << ", pass " << cycles_of("pass cells")
              << " with " << thousands(passed) << " messages, insert " << cycles_of("insert cells");
    grown.remove(depth);
    std::cout << "; remove " << cycles_of("") << " ms)\n";
}

/// A step as a program on the mesh, in the view by which the records rest, and in another one. Returns 1 if a bit differs from the host's.
int mesh(std::vector<Scene> const& scenes)
{
    std::cout << "\nA step on a mesh of Mk2's tiles, channels of 100 slots: counted, and ms by the model of Mk2. `turned`: the third view\n"
                 "of the path, with the records where they rest by the first; `rested`: after they have moved\n\n"
                 "| map | view | pixels | tile | messages out = back | MB out | back | supersteps of both | splats of the fullest tile "
                 "| room | lost copies | project | cast | sort | walk | return | step | all ms | steps a second |\n"
                 "|---|---|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    auto const model = priced_mk2();
    int status = 0;
    struct Size {
        std::uint32_t width, height;
        splat::TileSize tile;
    };
    for (auto const& s : scenes)
        for (Size const size : {Size{1280, 720, {32, 20}}, Size{640, 480, {16, 15}}}) {
            auto const [cameras, targets] =
                views_of(s, {scene::resized(s.path[0], size.width, size.height), scene::resized(s.path[2], size.width, size.height)});
            float const depth = median_depth(targets[0]);
            auto const start = spoilt(s.map, depth);
            mapping::MeshRefineOptions o;
            o.refine = options_for(1);
            o.refine.view.tile = size.tile;
            mapping::MeshRefiner<splat::map::SecondMomentByKind, Mesh, Traced<AnyMachine>> on_mesh(start, cameras[0], o);
            mapping::Refiner<> host(start, o.refine);
            bool whole = true;
            for (std::size_t row = 0; row < 3; ++row) {
                std::size_t const i = row == 0 ? 0 : 1;
                if (row == 2) rest(on_mesh, cameras[i], model);
                on_mesh.step(cameras[i], targets[i], splat::map::usual_rates(depth));
                host.step(cameras[i], targets[i], splat::map::usual_rates(depth));
                auto const lost = on_mesh.lost();
                whole = whole && lost.copies + lost.records == 0;
                auto const costs = step_costs(on_mesh.mesh().trace(), model_cost(model, on_mesh.mesh().trace(), on_mesh.mesh().grid()));
                auto const& run = on_mesh.run();
                std::uint64_t out = 0, back = 0, passes = 0, out_bytes = 0, back_bytes = 0, all = 0, most = 0;
                std::array<std::uint64_t, 6> cycles{};
                for (std::size_t k = 0; k < run.steps.size(); ++k) {
                    auto const& step = run.steps[k];
                    auto const is = [&](char const* name) { return step.kernel == name; };
                    bool const casts = is("cast"), returns = is("return");
                    if (casts) out += step.messages, out_bytes += step.live_bytes; // with the answers of full tiles
                    if (returns) back += step.messages, back_bytes += step.live_bytes;
                    passes += casts || returns ? step.passes : 0;
                    std::size_t const column = is("begin view") || is("project records") ? 0
                                               : casts                                   ? 1
                                               : is("sort entries")                      ? 2
                                               : is("walk") || is("add up")              ? 3
                                               : returns                                 ? 4
                                                                                         : 5;
                    cycles[column] += costs[k].total(), all += costs[k].total();
                }
                for (auto const& peak : run.peaks)
                    if (peak.region == splat::map::Entries::name) most = peak.items;
                out -= lost.copies; // its message was answered at once
                if (out != back + lost.copies)
                    throw Error("a copy did not answer (" + std::to_string(out) + " out, " + std::to_string(back) + " back); mend the program");
                std::cout << "| " << s.name << " | "
                          << (row == 0   ? "own"
                              : row == 1 ? "turned"
                                         : "rested")
                          << " | " << size.width << " x " << size.height << " | " << size.tile.tile_width << " x " << size.tile.tile_height << " | "
                          << thousands(out) << " | " << fixed(static_cast<double>(out_bytes) * 1e-6, 1) << " | "
                          << fixed(static_cast<double>(back_bytes) * 1e-6, 1) << " | " << passes << " | " << thousands(most) << " | "
                          << thousands(on_mesh.sizes().entries) << " | " << thousands(lost.copies + lost.records);
                for (auto const c : cycles) std::cout << " | " << fixed(milliseconds(model, c), 2);
                std::cout << " | " << fixed(milliseconds(model, all), 2) << " | " << fixed(1000 / milliseconds(model, all), 0) << " |\n";
            }
            keyframe(cameras, targets, depth, o, model);
            auto const a = on_mesh.map().gaussians, b = host.map().gaussians; // both in the order of ids
            if (!whole) {
                std::cout << "(tiles were full: the next step of " << s.name << " has another picture than the host's)\n";
            } else if (std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) != 0) {
                std::cout << "FAILED: the map of " << s.name << " on the mesh is not that of the host\n";
                status = 1;
            }
        }
    return status;
}

int run(Options const& o)
{
    auto const scenes = scenes_of(o);
    auto const wants = [&](char const* table) { return bench::chosen(o.tables, table); };
    int status = 0;
    if (wants("psnr")) status = psnr(o, scenes);
    if (wants("times")) times(o, scenes);
    if (wants("mesh")) status = std::max(status, mesh(scenes));
    return status;
}

} // namespace

int main(int argc, char** argv)
{
    return bench::program(argc, argv, table_of, run, "not enough memory (each scene has a map and its views); name one --scene");
}
