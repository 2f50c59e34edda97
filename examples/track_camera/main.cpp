// Finds the poses of a camera on the mesh, from real pictures or from rendered ones that it spoils as a camera would.
#include "../shared/camera_file.hpp"
#include "../shared/near_note.hpp"
#include "../shared/png.hpp"
#include "../shared/printer.hpp"
#include "../shared/process.hpp"
#include "../shared/rgbd_photo.hpp"
#include "../shared/sequence.hpp"
#include "../shared/text.hpp"
#include "options.hpp"
#include "outputs.hpp"
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <iostream>
#include <optional>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/json_text.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/scene/near_plane.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <tilemesh/splat/rules.hpp>
#include <tilemesh/splat/setup_types.hpp>
#include <tilemesh/splat/view.hpp>
#include <tilemesh/track/depth_misfit.hpp>
#include <tilemesh/track/pose_evaluator.hpp>
#include <tilemesh/track/pose_solver.hpp>
#include <tilemesh/track/tracker.hpp>
#include <tilemesh/track/trajectory_error.hpp>
#include <unistd.h>
#include <utility>
#include <vector>

namespace {

namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;
namespace track = tilemesh::track;
using shared::Printer;
using shared::rounded;
using tilemesh::Error;
using track_camera::Options;

/// The frames so far.
struct Outcome {
    std::vector<scene::StampedPose> estimated, truth;
    std::vector<bool> is_lost;                  ///< of each of `estimated`
    std::vector<scene::Pose> estimates, truths; ///< of the tracked frames with a known truth
    tilemesh::splat::Shutter shutter{};         ///< of the last frame
    std::string frames;                         ///< of the report
    double all_ms = 0.0;
    std::uint64_t evaluations = 0;
    std::size_t lost = 0, retried = 0;
    std::string first_loss; ///< why the first lost frame is lost
};

/// Tracks frame k. A frame that a part of the blocks lost is tracked again with all of them, from the same start.
void track_one(Options const& o, std::size_t k, shared::SeenFrame seen, track::Tracker& tracker, track::PoseEvaluator& evaluate, Outcome& out,
               shared::Pace const& pace, Printer& printer)
{
    auto& settings = evaluate.options();
    auto const begin = std::chrono::steady_clock::now();
    settings.seed = static_cast<std::uint32_t>(k);
    settings.one_in = o.one_in;
    evaluate.set_target({std::move(seen.colour), o.depth ? std::move(seen.depth) : report::Plane{}});
    auto const before = tracker;
    auto f = tracker.track_at(evaluate, seen.seconds, 1.0 / o.one_in);
    auto evaluations = f.solution.evaluations;
    bool const again = f.verdict == track::Verdict::lost && o.one_in > 1;
    if (again) {
        tracker = before;
        settings.one_in = 1;
        f = tracker.track_at(evaluate, seen.seconds);
        evaluations += f.solution.evaluations;
    }
    double const ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    out.all_ms += ms;
    out.evaluations += evaluations;
    bool const lost = f.verdict == track::Verdict::lost;
    if (lost && out.lost++ == 0) out.first_loss = f.why;
    out.is_lost.push_back(lost);
    out.retried += again;
    out.estimated.push_back({seen.seconds, f.pose});
    out.shutter = f.shutter;
    double degrees = NAN, off = NAN;
    std::string off_by;
    if (seen.truth) {
        if (!lost) out.truths.push_back(*seen.truth), out.estimates.push_back(f.pose);
        out.truth.push_back({seen.seconds, *seen.truth});
        degrees = glm::length(track::twist_between(*seen.truth, f.pose).phi) * 180.0 / 3.14159265358979323846;
        off = glm::length(f.pose.position - seen.truth->position);
        off_by = ", off by " + rounded(degrees) + " degrees and " + rounded(off) + " world units";
    }
    printer.say("frame " + std::to_string(k) + ": " + track::name_of(f.verdict) + (f.why.empty() ? "" : ", ") + f.why +
                (again ? ", tried again with all blocks" : "") + ", " + std::to_string(evaluations) + " evaluations, " + rounded(ms) + " ms" +
                off_by + pace.after(k + 1) + "\n");
    out.frames += (k == 0 ? "    " : ",\n    ") + report::json_line([&](auto& json) {
                      json.member("status", track::name_of(f.verdict));
                      json.member("why", f.why);
                      json.member("seconds", seen.seconds);
                      json.member("iterations", evaluations);
                      json.member("tried_again", again);
                      json.member("mean_cost", f.mean_cost);
                      json.member("host_ms", ms);
                      json.member("rotation_error_deg", degrees);
                      json.member("translation_error", off);
                  });
}

/// Writes the trajectories, the plot and the report, and prints the summary.
template <class Source>
void write_all(Options const& o, Source const& source, scene::Intrinsics const& lens, track_camera::PhotoWriter const* photos, Outcome const& out,
               double scale, std::array<double, 3> const& origin, Printer& printer)
{
    auto const estimated = shared::in_file_coordinates(out.estimated, origin), truth = shared::in_file_coordinates(out.truth, origin);
    report::write_whole(o.out / "estimated.tum", scene::tum_text(estimated, out.is_lost));
    if (!truth.empty()) report::write_whole(o.out / "truth.tum", scene::tum_text(truth));
    std::vector<shared::FoundCamera> found;
    for (std::size_t k = 0; k < estimated.size(); ++k)
        if (!out.is_lost[k]) found.push_back({source.name(k), estimated[k].pose});
    report::write_whole(o.out / "cameras.json", shared::camera_file_text(found, lens));
    report::write_whole(o.out / "paths.svg", shared::path_plot(estimated, out.is_lost, truth));
    if (photos) photos->finish(scene::tum_text(truth));
    auto const count = static_cast<double>(out.estimated.size());
    std::optional<track::TrajectoryErrors> errors;
    if (!out.truths.empty())
        printer.say(shared::error_lines(errors.emplace(track::trajectory_errors(out.estimates, out.truths)), scale, out.estimated.size()));
    if (o.report) {
        report::JsonText file(2);
        file.object([&] {
            file.member_as_is("frames", "[\n" + out.frames + "\n  ]");
            file.member_as_is("summary", report::json_line([&](auto& json) {
                if (errors) shared::add_errors(json, *errors);
                json.member("median_depth", scale);
                json.member("frames_lost", out.lost);
                json.member("frames_tried_again", out.retried);
                json.member("evaluations", out.evaluations);
                json.member("host_ms_per_frame", out.all_ms / count);
            }));
        });
        report::write_whole(*o.report, file.text() + "\n");
    }
    printer.say(std::to_string(out.estimated.size()) + " frames, " + std::to_string(out.lost) + " lost, " + std::to_string(out.retried) + " tried again; median depth " + rounded(scale) + " world units; " +
                rounded(static_cast<double>(out.evaluations) / count) + " evaluations and " + rounded(out.all_ms / count) + " ms a frame\n");
}

/// Says on standard error how a run ended that is not as it was asked for, and returns the exit status: 128 and the signal after an
/// interrupt, 2 if something could not be printed, 1 if every frame is lost.
int end_of(Options const& o, Outcome const& out, std::size_t frames, Printer const& printer)
{
    auto const tracked = out.estimated.size();
    auto const signal = shared::interrupt();
    auto const say = [](std::string const& text) { std::cerr << shared::one_line(text) << std::endl; };
    if (tracked != 0 && out.lost == tracked) {
        auto const end = out.first_loss.find("; "); // the reason may name a remedy of its own
        say((tracked == 1 ? std::string("the only frame is lost") : "all " + std::to_string(tracked) + " frames are lost") + " (the first: " + out.first_loss.substr(0, end) + "); " +
            (end == std::string::npos ? "start nearer to the first picture, or track larger pictures" : out.first_loss.substr(end + 2)));
    }
    if (printer.problem) say(*printer.problem);
    if (signal != 0 && tracked < frames) {
        auto const of = " of " + std::to_string(frames) + " (" + shared::signal_name(signal) + "); ";
        say(tracked == 0 ? "interrupted before frame 1" + of + "nothing is written, start again"
                         : "interrupted after frame " + std::to_string(tracked) + of + (o.out / "estimated.tum").string() + " has the poses of these frames, start again for the rest");
        return 128 + signal;
    }
    return printer.problem ? 2 : tracked != 0 && out.lost == tracked ? 1 : 0;
}

/// Tracks the frames of `source`, from `start`, and writes what the command line asks for. After an interrupt, and if a picture cannot be
/// read, it writes everything about the frames before; then it throws the picture's error. Returns the exit status.
template <class Source>
int track_all(Options const& o, Source const& source, tilemesh::Renderer& renderer, scene::Map const& map, scene::Intrinsics const& lens, scene::Size size, scene::Pose const& start, Printer& printer)
{
    track::PoseEvaluator evaluate{map, {size.width, size.height}, {.threads = o.threads, .tile = {o.tile.width, o.tile.height}}};
    auto const shown = renderer.render(scene::make_camera(start, lens));
    double const scale = track::median_depth(shown.depth, shown.alpha);
    if (!(scale > 0)) throw Error("the first view shows nothing of the map (no pixel is half covered); choose another camera or trajectory");
    evaluate.rules().coverage = o.coverage();
    auto& settings = evaluate.options();
    settings.with_depth = o.depth;
    settings.with_exposure = o.photos || o.noise > 0.0;
    settings.scene_depth = static_cast<float>(scale);
    track::TrackerOptions how;
    how.method = o.method;
    how.rows_per_pixel = o.depth ? 4.0 : 3.0;
    how.readout = o.rolling_shutter.value_or(0.0);
    track::Tracker tracker{lens, scale, start, how};

    std::optional<track_camera::PhotoWriter> photos;
    if (o.save_photos) photos.emplace(*o.save_photos, o.depth_levels);
    Outcome out;
    report::Image last;
    auto const write = [&] {
        write_all(o, source, lens, photos ? &*photos : nullptr, out, scale, map.origin, printer);
        auto shown_last = scene::make_camera(out.estimated.back().pose, lens);
        shown_last.shutter = out.shutter;
        shared::write_png(o.out / "residual.png", report::error_picture(renderer.render(shown_last).image, last));
    };
    auto const count = std::min<std::size_t>(source.count(), o.frames);
    shared::Pace const pace(0, count);
    try {
        for (std::size_t k = 0; k < count && shared::interrupt() == 0; ++k) {
            auto seen = source.take(k); // whole, or not at all
            if (photos) photos->write(seen.seconds, seen.colour, seen.depth);
            auto colour = seen.colour;
            if (k == 0 && o.depth) printer.say(shared::depth_note(seen.depth, scale));
            track_one(o, k, std::move(seen), tracker, evaluate, out, pace, printer);
            last = std::move(colour);
        }
    } catch (...) {
        if (out.estimated.empty()) throw;
        try {
            write();
        } catch (...) { // the first error is the one to report
        }
        throw;
    }
    if (!out.estimated.empty()) write();
    return end_of(o, out, count, printer);
}

int run(Options const& o)
{
    Printer printer(o.quiet, "the trajectory is written; --quiet prints errors only");
    std::vector<std::string> notes;
    auto list = shared::recording_of(o, notes);
    auto const size = o.photos ? shared::size_of(list.front()) : o.size.value_or(scene::Size{640, 480});
    auto const map = shared::load_map(o.map, o, notes);
    auto const first = shared::first_camera(o, list, shared::shape_of(map), size, !o.map, notes);
    auto const& camera = first.camera;
    auto lens = scene::lens_of(camera);
    auto poses = shared::poses_of(o, first, map.origin, list, notes);
    auto const first_view = [&] { return scene::make_camera(poses.empty() ? scene::pose_of(camera) : poses.front().pose, lens); };
    if (o.near_depth) lens.near_depth = *o.near_depth;
    else if (!first.names_near) lens.near_depth = scene::near_for(map, first_view());
    shared::add_near_note(map, {first_view()}, notes);
    shared::add_masks(o, size, list, notes);
    auto const rendered = o.trajectory ? std::uint64_t{poses.size()} : std::uint64_t{o.frames} * o.step();
    auto const frames = std::min<std::uint64_t>(((o.photos ? list.size() : rendered) + o.step() - 1) / o.step(), o.frames);
    track_camera::prepare_outputs(o, shared::files_read(o, {o.map}, list, first.sized_by), static_cast<std::size_t>(frames));
    for (auto const& note : notes) printer.say("note: " + shared::one_line(note) + "\n");
    printer.say(shared::lens_line(lens));

    tilemesh::Renderer renderer{map, splat::with_planes(splat::lossless, true, true), {.threads = o.threads, .coverage = o.coverage()}};
    if (o.photos) {
        shared::Photos const source{o, std::move(list), std::move(poses), size};
        return track_all(o, source, renderer, map, lens, size, source.truth(0).value_or(scene::pose_of(camera)), printer);
    }
    auto const seen_from = [&](splat::Camera const& at) {
        auto shown = renderer.render(at);
        for (std::size_t i = 0; i < shown.depth.values.size(); ++i) // no sensor measures what is half covered
            if (shown.alpha.values[i] < 0.5f) shown.depth.values[i] = 0.0f;
        return shared::RgbdPhoto{std::move(shown.image), std::move(shown.depth)};
    };
    auto path = o.trajectory ? shared::CameraPath{std::move(poses)} : shared::CameraPath{scene::pose_of(camera), rendered};
    shared::Renderings const source{o, seen_from, std::move(path), lens};
    return track_all(o, source, renderer, map, lens, size, source.truth(0), printer);
}

} // namespace

int main(int argc, char** argv)
{
    return shared::run_program("track_camera", track_camera::options_of, run, argc, argv);
}
