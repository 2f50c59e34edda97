// Makes a map from pictures with depth, and finds the camera's pose in each.
#include "../shared/camera_file.hpp"
#include "../shared/camera_path.hpp"
#include "../shared/output_files.hpp"
#include "../shared/printer.hpp"
#include "../shared/process.hpp"
#include "../shared/rgbd_photo.hpp"
#include "../shared/sequence.hpp"
#include "../shared/sha256.hpp"
#include "../shared/text.hpp"
#include "checkpoint.hpp"
#include "options.hpp"
#include "page.hpp"
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/geometric.hpp>
#include <iostream>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/mapping/view_sums.hpp>
#include <tilemesh/report/distinct_files.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/json_text.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <tilemesh/scene/near_plane.hpp>
#include <tilemesh/scene/ply_output.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <tilemesh/slam/session.hpp>
#include <tilemesh/slam/state_bytes.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/track/pose_update.hpp>
#include <tilemesh/track/tracker.hpp>
#include <tilemesh/track/trajectory_error.hpp>
#include <tuple>
#include <type_traits>
#include <unistd.h>
#include <utility>
#include <vector>

namespace {

namespace mapping = tilemesh::mapping;
namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
namespace slam = tilemesh::slam;
namespace splat = tilemesh::splat;
namespace track = tilemesh::track;
using shared::Printer;
using shared::rounded;
using slam_program::Options;
using tilemesh::Error;

/// At most so many frames that are no keyframes are compared with the map in the end, evenly spaced.
constexpr std::size_t most_compared = 100;

/// What the run knows about a frame afterwards.
struct Done {
    double seconds;
    scene::Pose pose;
    track::Exposure exposure;
    bool lost, keyframe;
};
/// The frames so far.
struct Outcome {
    std::vector<Done> done;
    std::vector<scene::StampedPose> truth;
    std::vector<scene::Pose> estimates, truths; ///< of the tracked frames with a known truth
    std::string frames, keyframes;              ///< of the report
    double all_ms = 0.0, keyframe_ms = 0.0;
    std::uint64_t evaluations = 0;
    std::size_t lost = 0, keyframe_count = 0;
    std::string first_loss; ///< why the first lost frame is lost
};

/// The members of an outcome in a checkpoint, in their order.
template <class Of, class Visit>
void each_member(Of& o, Visit const& visit)
{
    auto const members = std::tie(o.done, o.truth, o.estimates, o.truths, o.frames, o.keyframes, o.first_loss, o.all_ms, o.keyframe_ms, o.evaluations,
                                  o.lost, o.keyframe_count);
    std::apply([&](auto&... member) { (visit(member), ...); }, members);
}
void save(Outcome const& out, slam::StateWriter& to)
{
    each_member(out, [&]<class T>(T const& member) {
        if constexpr (std::is_same_v<T, std::string>) to.put_text(member);
        else if constexpr (std::is_arithmetic_v<T>) to.put(member);
        else to.put_all(member);
    });
}
/// Reads what `save` wrote.
Outcome load_outcome(slam::StateReader& in)
{
    Outcome out;
    each_member(out, [&]<class T>(T& member) {
        if constexpr (std::is_same_v<T, std::string>) member = in.text();
        else if constexpr (std::is_arithmetic_v<T>) member = in.get<T>();
        else member = in.all<typename T::value_type>();
    });
    return out;
}

/// Gives frame k to the session. Returns whether an interrupt ended the steps of its keyframe.
bool add_one(std::size_t k, shared::SeenFrame seen, slam::Session& session, Outcome& out, shared::Pace const& pace, Printer& printer)
{
    auto const begin = std::chrono::steady_clock::now();
    auto const f = session.add({seen.seconds, std::move(seen.colour), std::move(seen.depth)});
    double const ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    auto const& t = f.tracked;
    bool const lost = t.verdict == track::Verdict::lost;
    out.all_ms += ms;
    out.evaluations += t.solution.evaluations;
    if (lost && out.lost++ == 0) out.first_loss = t.why;
    out.done.push_back({seen.seconds, t.pose, t.exposure, lost, f.keyframe.has_value()});
    double degrees = NAN, off = NAN;
    std::string off_by, mapped;
    if (seen.truth) {
        if (!lost) out.truths.push_back(*seen.truth), out.estimates.push_back(t.pose);
        out.truth.push_back({seen.seconds, *seen.truth});
        degrees = glm::length(track::twist_between(*seen.truth, t.pose).phi) * 180.0 / 3.14159265358979323846;
        off = glm::length(t.pose.position - seen.truth->position);
        off_by = ", off by " + rounded(degrees) + " degrees and " + rounded(off) + " world units";
    }
    if (f.keyframe) {
        auto const& key = *f.keyframe;
        mapped = ", keyframe: " + std::to_string(key.inserted) + " new, " + std::to_string(key.removed) + " removed, " +
                 std::to_string(key.gaussians) + " Gaussians";
        out.keyframes += (out.keyframe_count++ == 0 ? "    " : ",\n    ") + report::json_line([&](auto& json) {
                             json.member("frame", k);
                             json.member("seconds", seen.seconds);
                             json.member("open_share", f.open_share);
                             json.member("inserted", key.inserted);
                             json.member("removed", key.removed);
                             json.member("gaussians", key.gaussians);
                             json.member("steps", key.steps);
                             json.member("psnr_db", key.psnr_db);
                             json.member("host_ms", ms);
                         });
        out.keyframe_ms += ms;
    }
    printer.say("frame " + std::to_string(k) + ": " + track::name_of(t.verdict) + (t.why.empty() ? "" : ", ") + t.why + ", " +
                std::to_string(t.solution.evaluations) + " evaluations, " + rounded(ms) + " ms" + off_by + mapped + pace.after(k + 1) + "\n");
    out.frames += (k == 0 ? "    " : ",\n    ") + report::json_line([&](auto& json) {
                      json.member("status", track::name_of(t.verdict));
                      json.member("why", t.why);
                      json.member("seconds", seen.seconds);
                      json.member("iterations", t.solution.evaluations);
                      json.member("mean_cost", t.mean_cost);
                      json.member("keyframe", f.keyframe.has_value());
                      json.member("host_ms", ms);
                      json.member("rotation_error_deg", degrees);
                      json.member("translation_error", off);
                  });
    return f.keyframe && f.keyframe->stopped;
}

/// A view to compare the map with, after the last frame.
struct Compared {
    splat::Camera camera;
    mapping::Target target;
};
/// The mean PSNR of frames that are no keyframes. `view(k)` gives nothing for a frame that cannot be compared.
template <class View>
double mean_psnr(slam::Session& session, Outcome const& out, std::size_t& compared, View const& view)
{
    std::vector<std::size_t> others;
    for (std::size_t k = 0; k < out.done.size(); ++k)
        if (!out.done[k].keyframe) others.push_back(k);
    std::size_t const step = others.size() / most_compared + 1;
    double sum = 0;
    for (std::size_t i = 0; i < others.size() && shared::interrupt() == 0; i += step)
        if (auto const one = view(others[i])) {
            sum += session.mapper().measure(one->camera, one->target).psnr_db();
            ++compared;
        }
    return compared != 0 ? sum / static_cast<double>(compared) : std::numeric_limits<double>::quiet_NaN();
}

/// What the results say besides the frames.
struct Facts {
    double scale;
    std::array<double, 3> origin;
    scene::Intrinsics lens;
    std::function<std::string(std::size_t)> name; ///< of a frame's picture
};
/// Writes the map and the trajectories, then compares, and writes the report.
template <class View>
void write_all(Options const& o, slam::Session& session, Outcome const& out, Facts const& facts,
               slam_program::Growth const* growth, View const& view, Printer& printer)
{
    auto const bytes = scene::ply_bytes(session.map(), o.coverage());
    report::write_whole(o.out / "map.ply", bytes);
    std::vector<scene::StampedPose> estimated;
    std::vector<bool> is_lost;
    for (auto const& d : out.done) estimated.push_back({d.seconds, d.pose}), is_lost.push_back(d.lost);
    estimated = shared::in_file_coordinates(std::move(estimated), facts.origin);
    auto const truth = shared::in_file_coordinates(out.truth, facts.origin);
    report::write_whole(o.out / "estimated.tum", scene::tum_text(estimated, is_lost));
    if (!truth.empty()) report::write_whole(o.out / "truth.tum", scene::tum_text(truth));
    std::vector<shared::FoundCamera> found, keyframes; // a lost frame has no pose to look from
    for (std::size_t k = 0; k < out.done.size(); ++k) {
        if (out.done[k].lost) continue;
        found.push_back({facts.name(k), estimated[k].pose});
        if (out.done[k].keyframe) keyframes.push_back(found.back());
    }
    report::write_whole(o.out / "cameras.json", shared::camera_file_text(found, facts.lens));
    report::write_whole(o.out / "keyframes.json", shared::camera_file_text(keyframes, facts.lens));

    std::size_t compared = 0;
    double const psnr = mean_psnr(session, out, compared, view), frames = static_cast<double>(out.done.size());
    std::optional<track::TrajectoryErrors> errors;
    std::vector<std::pair<std::string, std::string>> numbers{{"Gaussians", std::to_string(session.map().gaussians.size())},
                                                             {"frames", std::to_string(out.done.size())},
                                                             {"lost", std::to_string(out.lost)},
                                                             {"PSNR of other frames, dB", rounded(psnr)}};
    if (!out.truths.empty()) {
        auto const& e = errors.emplace(track::trajectory_errors(out.estimates, out.truths));
        numbers.emplace_back("error of positions, share of the median depth (" + std::to_string(e.poses) + " pictures)",
                             rounded(e.ate.rmse / facts.scale));
        printer.say(shared::error_lines(e, facts.scale, out.done.size()));
    }
    auto const gaussians = session.map().gaussians.size();
    if (o.report) {
        report::JsonText file(2);
        file.object([&] {
            file.member_as_is("frames", "[\n" + out.frames + "\n  ]");
            file.member_as_is("keyframes", "[\n" + out.keyframes + "\n  ]");
            file.member_as_is("summary", report::json_line([&](auto& json) {
                if (errors) shared::add_errors(json, *errors);
                json.member("median_depth", facts.scale);
                json.member("frames", out.done.size());
                json.member("frames_lost", out.lost);
                json.member("keyframes", out.keyframe_count);
                json.member("psnr_db", psnr);
                json.member("frames_compared", compared);
                json.member("gaussians", gaussians);
                json.member("optimiser", slam::name_of(o.optimiser));
                json.member("map_sha256", shared::sha256(bytes));
                json.member("evaluations", out.evaluations);
                json.member("keyframe_host_ms",
                            out.keyframe_ms / static_cast<double>(std::max<std::size_t>(1, out.keyframe_count)));
                json.member("host_ms_per_frame", out.all_ms / frames);
            }));
        });
        report::write_whole(*o.report, file.text() + "\n");
    }
    if (growth != nullptr)
        report::write_whole(*o.page, slam_program::page_of(numbers, growth->three(session.mapper(), out.done.size()),
                                                           shared::path_plot(estimated, is_lost, truth)));
    printer.say(std::to_string(out.done.size()) + " frames, " + std::to_string(out.lost) + " lost, " + std::to_string(out.keyframe_count) +
                " keyframes, " + std::to_string(gaussians) + " Gaussians; " + rounded(psnr) + " dB in " + std::to_string(compared) +
                " other frames; " + rounded(out.all_ms / frames) + " ms a frame\n");
    printer.say(shared::one_line((o.out / "map.ply").string()) + " has the map, and " + shared::one_line((o.out / "keyframes.json").string()) +
                " the cameras that see it\n");
}

/// Says on standard error how a run ended that is not as it was asked for, and returns the exit status: 128 and the signal after an
/// interrupt, 2 if something could not be printed, 1 if every frame that was tracked is lost.
int end_of(Options const& o, Outcome const& out, std::size_t frames, bool cut, Printer const& printer)
{
    auto const count = out.done.size();
    auto const say = [](std::string const& text) { std::cerr << shared::one_line(text) << std::endl; };
    // The first frame of an empty map is where the camera says it is.
    auto const tracked = count - (count != 0 && !o.map ? 1 : 0);
    bool const all_lost = tracked != 0 && out.lost == tracked;
    if (all_lost) {
        auto const end = out.first_loss.find("; "); // the reason may name a remedy of its own
        say((tracked == 1 ? std::string("the only frame that was tracked is lost")
                          : "all " + std::to_string(tracked) + " frames that were tracked are lost") +
            " (the first: " + out.first_loss.substr(0, end) + "); " +
            (end == std::string::npos ? "take pictures that are closer together" : out.first_loss.substr(end + 2)));
    }
    if (printer.problem) say(*printer.problem);
    if (auto const signal = shared::interrupt(); signal != 0) {
        auto const of = " of " + std::to_string(frames) + " (" + shared::signal_name(signal) + "); ";
        say(count == 0 ? "interrupted before frame 1" + of + "nothing is written, start again"
                       : std::string("interrupted ") + (cut ? "in the steps after frame " : count == frames ? "in the comparison after frame " : "after frame ") + std::to_string(count) + of +
                             (o.out / "map.ply").string() + " has the map of these frames, " +
                             (!o.resume ? "start again for the rest" : cut ? "the same command goes on" : "the same command goes on from there"));
        return 128 + signal;
    }
    return printer.problem ? 2 : all_lost ? 1 : 0;
}

/// Tracks and maps the frames of `source`, from `start` or from the state in `checkpoint`, and writes what the command line asks for. After
/// an interrupt, and after an error, it writes everything about the frames before; then it throws the error. Returns the exit status.
template <class Source, class View>
int map_all(Options const& o, Source const& source, scene::Map map, scene::Intrinsics const& lens, scene::Pose const& start,
            View const& view, slam_program::Checkpoint const* checkpoint, Printer& printer)
{
    auto const count = std::min<std::size_t>(source.count(), o.frames);
    bool has_depth = true;  // the picture that was taken last
    std::size_t hidden = 0; // its depths that the near plane hides: a Gaussian there would never be drawn
    auto const take = [&](std::size_t k) {
        auto seen = source.take(k); // whole, or not at all
        if (has_depth = !seen.depth.empty(); !has_depth) seen.depth = report::Plane(seen.colour.width, seen.colour.height);
        hidden = 0;
        for (float& depth : seen.depth.values)
            if (depth > 0 && depth <= lens.near_depth) depth = 0, ++hidden;
        return seen;
    };
    auto first = take(0);
    if (hidden != 0) {
        auto const left = std::count_if(first.depth.values.begin(), first.depth.values.end(), [](float depth) { return depth > 0; });
        auto const known = hidden + static_cast<std::size_t>(left);
        auto const text = report::thousands(hidden) + " of " + report::thousands(known) + " known depths of the first picture are not beyond the near plane (" +
                          report::significant(double{lens.near_depth}, 3) + " world units";
        if (2 * hidden > known) throw Error(text + ", so most of the scene would not be drawn); choose a nearer one with --near");
        printer.say("note: " + text + "), and are left out; --near moves it\n");
    }
    Facts const facts{slam::median_depth(first.depth), map.origin, lens, [&](std::size_t k) { return source.name(k); }};
    if (!(facts.scale > 0))
        throw Error(std::string("the first picture has no known depth (") +
                    (has_depth ? "its depth picture has none, and a map needs depths); begin with a picture that has them, or change --depth-scale"
                               : "no depth picture belongs to it, and a map needs depths); begin with a picture that has one, or allow more time "
                                 "between them with --depth-within"));

    slam::SessionOptions how;
    how.mapper.optimiser = o.optimiser;
    how.mapper.steps = o.steps;
    how.mapper.first_steps = 2 * o.steps;
    how.mapper.insert.cell = o.cell;
    how.mapper.threads = o.threads;
    how.mapper.stop = [] { return shared::interrupt() != 0; };
    how.mapper.coverage = o.coverage();
    // Far motions are many pixels of a large picture: there, forward mode lost 4 of 30 frames, and hybrid none (README.md).
    how.tracker.method = o.method.value_or(lens.width < 320 ? track::Method::forward : track::Method::hybrid);
    how.keyframe_every = o.keyframe_every;
    how.most_open = o.most_open;
    how.with_exposure = o.photos || (o.noise > 0.0 && o.gain_drift > 0.0);
    printer.say(shared::lens_line(lens));
    if (o.photos && o.map)
        printer.say(shared::depth_note(first.depth, slam::median_depth(slam::Mapper(map, 1, {.threads = o.threads, .coverage = o.coverage()})
                                                                          .render(scene::make_camera(start, lens))
                                                                          .depth)));
    slam::Session session(std::move(map), lens, facts.scale, start, how);

    Outcome out;
    std::optional<slam_program::Growth> growth;
    if (o.page) growth.emplace(start, lens);
    auto const keep = [&] {
        slam::StateWriter state;
        save(out, state);
        if (growth) growth->save(state);
        state.put_text(session.save());
        checkpoint->write(out.done.size(), state.take());
    };
    if (auto const state = checkpoint ? checkpoint->find(count) : std::nullopt) {
        slam::StateReader in(*state);
        auto before = load_outcome(in);
        if (growth) growth->load(in);
        auto const of_session = in.text();
        in.finish();
        session.load(of_session, [&](std::size_t k) {
            auto seen = take(k);
            return slam::Frame{seen.seconds, std::move(seen.colour), std::move(seen.depth)};
        });
        out = std::move(before);
        printer.say("going on after frame " + std::to_string(out.done.size() - 1) + "\n");
    }
    auto const write = [&] {
        write_all(o, session, out, facts, growth ? &*growth : nullptr, [&](std::size_t k) { return view(k, out.done[k]); }, printer);
    };
    shared::Pace const pace(out.done.size(), count);
    bool cut = false; // an interrupt ended steps: the state before them is the one to go on from
    try {
        for (std::size_t k = out.done.size(); k < count && shared::interrupt() == 0; ++k) {
            cut = add_one(k, k == 0 ? std::move(first) : take(k), session, out, pace, printer);
            bool const is_keyframe = out.done.back().keyframe;
            if (growth && is_keyframe) growth->see(session.mapper(), k);
            if (checkpoint && !cut && (is_keyframe || shared::interrupt() != 0)) keep();
        }
    } catch (...) {
        if (out.done.empty()) throw;
        try {
            write();
        } catch (...) { // the first error is the one to report
        }
        throw;
    }
    if (shared::interrupt() == 0) {
        auto const begin = std::chrono::steady_clock::now();
        auto const steps = std::min<std::uint64_t>(std::uint64_t{o.finish} * out.keyframe_count, 1'000'000'000);
        cut = session.mapper().refine(static_cast<std::uint32_t>(steps)) < steps && out.keyframe_count != 0;
        out.all_ms += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    }
    if (!out.done.empty()) write();
    return end_of(o, out, count, cut, printer);
}

/// The files in the folder of --out, in the order in which they are written.
constexpr char const* out_files[] = {"map.ply", "estimated.tum", "truth.tum", "cameras.json", "keyframes.json"};

/// Makes the folder of --out, and checks that every file can be written. Throws `Error` if a file cannot be written, or would replace another
/// file of the run or a file in `read` (`report::DistinctFiles`). It writes nothing except the folder.
void prepare_outputs(Options const& options, std::vector<std::filesystem::path> const& read)
{
    constexpr char const *out_remedy = "name another directory with --out", *report_remedy = "name another file with --report",
                         *page_remedy = "name another file with --page";
    shared::make_folder(options.out, "--out");
    for (char const* const name : out_files) shared::check_file(options.out / name, "a result", out_remedy);
    if (options.resume)
        for (char const* const name : {slam_program::checkpoint_file, slam_program::set_aside_file})
            shared::check_file(options.out / name, "the checkpoint", out_remedy);
    if (options.report) shared::check_file(*options.report, "the report", report_remedy);
    if (options.page) shared::check_file(*options.page, "the page", page_remedy);
    report::DistinctFiles files;
    for (auto const& file : read) files.read(file);
    if (!options.quiet) files.write_stream(STDOUT_FILENO, "standard output", "send it to another file, or use --quiet");
    files.write_stream(STDERR_FILENO, "standard error", "send it to another file");
    auto const is_result = [&](std::string const& name) {
        if (options.resume && (name == slam_program::checkpoint_file || name == slam_program::set_aside_file)) return true;
        return std::find(std::begin(out_files), std::end(out_files), name) != std::end(out_files);
    };
    files.write_into(options.out, is_result, "a result", out_remedy);
    if (options.report) files.write(*options.report, "the report", report_remedy);
    if (options.page) files.write(*options.page, "the page", page_remedy);
}

int run(Options const& o)
{
    Printer printer(o.quiet, "the map is written; --quiet prints errors only");
    std::vector<std::string> notes;
    auto list = shared::recording_of(o, notes);
    auto const size = o.photos ? shared::size_of(list.front()) : o.size.value_or(scene::Size{320, 240});
    auto world = o.photos ? scene::Map{} : shared::load_map(o.render, o, notes);
    auto map = o.map ? shared::load_map(o.map, o, notes) : scene::Map{};
    if (!o.photos && o.map && map.origin != world.origin)
        throw Error(o.map->string() + " is not where the map to render is (their origins are apart); take maps of one place");
    if (!o.map) map.origin = world.origin;
    auto const& shown = o.photos ? map : world; // what a near plane may hide
    auto const first = shared::first_camera(o, list, shared::shape_of(shown), size, !o.photos && !o.render, notes);
    auto const& camera = first.camera;
    auto lens = scene::lens_of(camera);
    auto poses = shared::poses_of(o, first, map.origin, list, notes);
    if (o.near_depth) lens.near_depth = *o.near_depth;
    else if (!first.names_near)
        lens.near_depth = scene::near_for(shown, scene::make_camera(poses.empty() ? scene::pose_of(camera) : poses.front().pose, lens));
    shared::add_masks(o, size, list, notes);
    auto const read = shared::files_read(o, {o.render, o.map}, list, first.sized_by);
    prepare_outputs(o, read);
    for (auto const& note : notes) printer.say("note: " + shared::one_line(note) + "\n");
    std::optional<slam_program::Checkpoint> kept;
    if (o.resume) kept.emplace(o, read);
    auto const* const checkpoint = kept ? &*kept : nullptr;

    if (o.photos) {
        shared::Photos const source{o, std::move(list), std::move(poses), size};
        if (!o.near_depth && !first.names_near && map.gaussians.empty()) // a near plane as `scene::near_for` gives it where there is a map
            if (auto const depth = slam::median_depth(source.take(0).depth); depth > 0)
                lens.near_depth = std::min(lens.near_depth, static_cast<float>(depth / 10));
        // A photograph is compared at the pose that was found, without the exposure that was found.
        auto const view = [&](std::size_t k, Done const& d) -> std::optional<Compared> {
            if (d.lost) return std::nullopt;
            auto target = mapping::make_target(source.take(k).colour);
            auto const per_gain = static_cast<float>(std::exp(-d.exposure.log_gain)), offset = static_cast<float>(d.exposure.offset);
            for (auto& p : target.pixels)
                for (float& v : p.rgb) v = (v - offset) * per_gain;
            return Compared{scene::make_camera(d.pose, lens), std::move(target)};
        };
        return map_all(o, source, std::move(map), lens, source.truth(0).value_or(scene::pose_of(camera)), view, checkpoint, printer);
    }
    slam::Mapper true_map(std::move(world), 1, {.threads = o.threads, .coverage = o.coverage()}); // it renders
    auto const seen_from = [&](splat::Camera const& at) {
        auto seen = true_map.render(at);
        return shared::RgbdPhoto{std::move(seen.colour), std::move(seen.depth)};
    };
    auto path = o.trajectory ? shared::CameraPath{std::move(poses)}
                             : shared::CameraPath{scene::pose_of(camera), std::uint64_t{o.frames} * o.step()};
    shared::Renderings const source{o, seen_from, std::move(path), lens};
    // A rendered picture is compared at its true pose, before it was spoilt.
    auto const view = [&](std::size_t k, Done const&) -> std::optional<Compared> {
        return Compared{scene::make_camera(source.truth(k), lens), mapping::make_target(source.clean(k).colour)};
    };
    return map_all(o, source, std::move(map), lens, source.truth(0), view, checkpoint, printer);
}

} // namespace

int main(int argc, char** argv)
{
    return shared::run_program("slam", slam_program::options_of, run, argc, argv);
}
