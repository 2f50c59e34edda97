// Makes a map agree better with photographs, on the host.
#include "../shared/output_files.hpp"
#include "../shared/printer.hpp"
#include "../shared/process.hpp"
#include "../shared/sha256.hpp"
#include "../shared/text.hpp"
#include "options.hpp"
#include "views.hpp"
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <numeric>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/mapping/refiner.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/distinct_files.hpp>
#include <tilemesh/report/json_text.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <tilemesh/scene/ply_output.hpp>
#include <tilemesh/track/depth_misfit.hpp>
#include <unistd.h>
#include <utility>
#include <vector>

namespace {

namespace mapping = tilemesh::mapping;
namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;
using refine::Options;
using refine::View;
using shared::Printer;
using tilemesh::Error;

/// A number for readers: two decimals.
std::string rounded(double value)
{
    return std::isfinite(value) ? tilemesh::decimals(value, 2) : "infinite";
}

/// The PSNR of each view.
template <class Refiner>
std::vector<double> compare(Refiner& refiner, std::vector<View> const& views)
{
    std::vector<double> out;
    for (auto const& view : views) out.push_back(refiner.measure(view.camera, view.target()).psnr_db());
    return out;
}
double mean(std::vector<double> const& values)
{
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// The median depth of what the first view shows that shows something. Throws `Error` if none does.
template <class Refiner>
float median_depth(Refiner& refiner, std::vector<View> const& views)
{
    for (auto const& view : views) {
        if (auto const depth = tilemesh::track::median_depth(refiner.render(view.camera).depth); depth > 0) return static_cast<float>(depth);
    }
    throw Error("no camera shows anything of the map (no pixel is half covered); name the cameras of this map");
}

/// The step between views of which depths are compared: at most 16 of them.
std::size_t stride(std::vector<View> const& views)
{
    return views.size() / 16 + 1;
}
template <class Refiner>
std::vector<std::vector<float>> depths_of(Refiner& refiner, std::vector<View> const& views)
{
    std::vector<std::vector<float>> out;
    for (std::size_t i = 0; i < views.size(); i += stride(views)) out.push_back(refiner.render(views[i].camera).depth.values);
    return out;
}
/// The median difference of depths, as a share of the second ones, where both are known; NaN if no pixel has both. `other(i)`: those of the i-th
/// of these views.
template <class Other>
double depth_difference(std::vector<std::vector<float>> const& depths, Other const& other)
{
    std::vector<float> all;
    for (std::size_t i = 0; i < depths.size(); ++i) {
        std::vector<float> const& others = other(i);
        for (std::size_t k = 0; k < others.size(); ++k)
            if (depths[i][k] > 0 && others[k] > 0) all.push_back(std::fabs(depths[i][k] - others[k]) / others[k]);
    }
    if (all.empty()) return std::numeric_limits<double>::quiet_NaN();
    std::nth_element(all.begin(), all.begin() + std::ssize(all) / 2, all.end());
    return double{all[all.size() / 2]};
}

/// The order of the views: each once in a round, and each round in another order (SplitMix64, Fisher and Yates).
class Order {
public:
    explicit Order(std::uint32_t count) : views_(count) { std::iota(views_.begin(), views_.end(), 0u); }
    std::uint32_t next()
    {
        if (left_ == 0) {
            left_ = views_.size();
            for (auto i = static_cast<std::uint32_t>(left_); i > 1; --i) std::swap(views_[i - 1], views_[below(i)]);
        }
        return views_[--left_];
    }

private:
    std::uint32_t below(std::uint32_t n)
    {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return static_cast<std::uint32_t>(((z ^ (z >> 31)) >> 32) * n >> 32);
    }
    std::uint64_t state_ = 1;
    std::vector<std::uint32_t> views_;
    std::size_t left_ = 0;
};

/// Refuses outputs that cannot be written, that would overwrite a file that the run reads, or whose name says another format.
void check_outputs(Options const& o, std::vector<std::filesystem::path> const& read)
{
    constexpr char const *map_remedy = "name another file with --out", *report_remedy = "name another file with --report";
    shared::check_file(o.out, "the map", map_remedy);
    if (o.report) shared::check_file(*o.report, "the report", report_remedy);
    report::DistinctFiles files;
    for (auto const& file : read) files.read(file);
    if (!o.quiet) files.write_stream(STDOUT_FILENO, "standard output", "send it to another file, or use --quiet");
    files.write_stream(STDERR_FILENO, "standard error", "send it to another file");
    files.write(o.out, "the map", map_remedy);
    if (o.report) files.write(*o.report, "the report", report_remedy);
    auto const extension = o.out.extension();
    if (!extension.empty() && extension != ".ply" && extension != ".PLY")
        throw Error("--out cannot be " + shared::one_line(o.out.string()) + " (the map is written as a PLY, and the name says " +
                    shared::one_line(extension.string()) + "); write for example --out " +
                    shared::one_line(std::filesystem::path(o.out).replace_extension(".ply").string()));
}

/// What the report says besides the measures.
struct Facts {
    std::uint32_t steps, done;
    std::size_t gaussians;
    double median_depth, ms, depth_change, depth_error_before, depth_error_after;
    std::string optimiser, sha256;
};
std::string report_of(Facts const& f, refine::Views const& views, std::vector<double> const& before, std::vector<double> const& after)
{
    std::string held_out;
    for (std::size_t i = 0; i < before.size(); ++i)
        held_out += (i == 0 ? "\n    " : ",\n    ") + report::json_line([&](auto& json) {
                        json.member("camera", shared::one_line(views.held_out[i].name));
                        json.member("before_psnr_db", before[i]);
                        json.member("after_psnr_db", after[i]);
                    });
    auto const psnr = [](double db) { return report::json_line([&](auto& json) { json.member("psnr_db", db); }); };
    report::JsonText json(2);
    json.object([&] {
        json.member_as_is("before", psnr(mean(before)));
        json.member_as_is("after", psnr(mean(after)));
        json.member_as_is("held_out", "[" + held_out + "\n  ]");
        json.member("photographs", views.used.size());
        json.member("gaussians", f.gaussians);
        json.member("optimiser", f.optimiser);
        json.member("steps", f.done);
        json.member("steps_asked", f.steps);
        json.member("median_depth", f.median_depth);
        json.member("depth_change", f.depth_change);
        json.member("depth_error_before", f.depth_error_before);
        json.member("depth_error_after", f.depth_error_after);
        json.member("host_ms_per_step", f.ms / std::max(1u, f.done));
        json.member("map_sha256", f.sha256);
    });
    return json.text() + "\n";
}

template <class Optimiser>
int run_with(Options const& o, scene::Map map, refine::Views const& views, Printer& printer)
{
    mapping::RefineOptions how;
    how.view.threads = o.threads;
    how.rules.coverage = o.coverage();
    if (o.depths) how.view.loss.depth = 1; // as much as slam gives them
    for (std::size_t c = 0; c < 3; ++c) how.rules.background[c] = o.background ? (*o.background)[c] : 0.0f;
    mapping::Refiner<Optimiser> refiner(std::move(map), how);
    float const depth = median_depth(refiner, views.used), times = static_cast<float>(o.rate);
    auto const rates = splat::map::usual_rates(depth) * times;

    auto const before = compare(refiner, views.held_out);
    auto const shape = depths_of(refiner, views.used);
    auto const given = [&](std::size_t i) -> std::vector<float> const& { return views.used[i * stride(views.used)].depths; };
    auto const count = static_cast<std::uint32_t>(views.used.size());
    std::uint32_t const steps = o.steps.value_or(20 * count), tenth = std::max(1u, steps / 10);
    printer.say(std::to_string(refiner.map().gaussians.size()) + " Gaussians, " + std::to_string(count) + " photographs, " +
                std::to_string(before.size()) + " held out; before: " + rounded(mean(before)) + " dB\n");
    Order order(count);
    double ms = 0;
    std::uint32_t done = 0;
    shared::Pace const pace(0, steps);
    for (; done < steps && shared::interrupt() == 0; ++done) {
        auto const& view = views.used[order.next()];
        auto const target = view.target();
        auto const begin = std::chrono::steady_clock::now();
        auto const fit = refiner.step(view.camera, target, splat::map::faded(rates, static_cast<float>(done) / static_cast<float>(steps)));
        ms += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
        if ((done + 1) % tenth == 0)
            printer.say("step " + std::to_string(done + 1) + ": " + rounded(fit.psnr_db()) + " dB in " + shared::one_line(view.name, 200) + ", " +
                        rounded(ms / (done + 1)) + " ms a step" + pace.after(done + 1) + "\n");
    }
    auto const after = compare(refiner, views.held_out);
    auto const bytes = scene::ply_bytes(refiner.map(), o.coverage());
    report::write_whole(o.out, bytes);
    auto const now = depths_of(refiner, views.used);
    double const change = depth_difference(now, [&](std::size_t i) -> std::vector<float> const& { return shape[i]; });
    double const off_before = depth_difference(shape, given), off_after = depth_difference(now, given);
    if (o.report) {
        Facts const facts{
            steps, done, refiner.map().gaussians.size(), double{depth}, ms, change, off_before, off_after, Optimiser::name, shared::sha256(bytes)};
        report::write_whole(*o.report, report_of(facts, views, before, after));
    }
    printer.say("depths of the map changed by " + rounded(100 * change) + " % (median of " + std::to_string(now.size()) + " views)" +
                (o.depths ? "; off the given ones by " + rounded(100 * off_after) + " %, before by " + rounded(100 * off_before) + " %\n"
                          : "; no depths are given, so colours alone moved it (--depths keeps them)\n"));
    printer.say("after " + std::to_string(done) + " steps: " + rounded(mean(after)) + " dB; " + shared::one_line(o.out.string()) +
                " has the map\n");
    auto const signal = shared::interrupt();
    if (printer.problem) std::cerr << shared::one_line(*printer.problem) << std::endl;
    if (signal != 0 && done < steps) {
        auto const when = "interrupted after step " + std::to_string(done) + " of " + std::to_string(steps);
        std::cerr << when << " (" << shared::signal_name(signal) << "); " << shared::one_line(o.out.string())
                  << " has the map so far, start again for the rest" << std::endl;
        return 128 + signal;
    }
    return printer.problem ? 2 : 0;
}

int run(Options const& o)
{
    Printer printer(o.quiet, "the map is written; --quiet prints errors only");
    std::vector<std::string> notes;
    auto map = shared::load_map(o.map, o, notes);
    if (map.gaussians.empty())
        throw Error(shared::one_line(o.map.string()) + " has no Gaussian (there is nothing to refine); name another map");
    auto views = refine::find_views(o, map);
    check_outputs(o, views.read);
    refine::read_photographs(o, views.held_out);
    refine::read_photographs(o, views.used);
    for (auto const& note : notes) printer.say("note: " + shared::one_line(note) + "\n");
    for (auto const& note : views.notes) printer.say("note: " + shared::one_line(note) + "\n");
    return o.optimiser == refine::Optimiser::adam ? run_with<splat::map::Adam>(o, std::move(map), views, printer)
                                                  : run_with<splat::map::SecondMomentByKind>(o, std::move(map), views, printer);
}

} // namespace

int main(int argc, char** argv)
{
    return shared::run_program("refine", refine::options_of, run, argc, argv);
}
