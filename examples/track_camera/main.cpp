// Finds the poses of a camera on the mesh, from real pictures or from rendered ones that it spoils as a camera would.
#include "../shared/codecs.hpp"
#include "../shared/near_note.hpp"
#include "../shared/output_files.hpp"
#include "../shared/printer.hpp"
#include "../shared/process.hpp"
#include "../shared/text.hpp"
#include "options.hpp"
#include "outputs.hpp"
#include "path.hpp"
#include "pictures.hpp"
#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <iostream>
#include <optional>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/heat_image.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/image_file.hpp>
#include <tilemesh/report/plot.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/near_plane.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/rgbd_list.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <tilemesh/splat/rules.hpp>
#include <tilemesh/splat/setup.hpp>
#include <tilemesh/splat/view.hpp>
#include <tilemesh/track/pose_evaluator.hpp>
#include <tilemesh/track/pose_solver.hpp>
#include <tilemesh/track/spoil.hpp>
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
using tilemesh::Error;
using track_camera::Options;
using WithPlanes = splat::WithPixel<splat::Lossless, splat::WithAlpha<splat::WithDepth<splat::FloatPixel>>>;

/// A number as JSON has it: the shortest text that reads back as this number. JSON has no number that is not finite.
std::string number(double value)
{
    if (!std::isfinite(value)) return "null";
    std::array<char, 32> text{};
    auto const end = std::to_chars(text.data(), text.data() + text.size(), value);
    return {text.data(), end.ptr};
}

/// A number for readers: three significant digits. No printed measure is known better, and each has a unit behind it.
std::string rounded(double value)
{
    if (!std::isfinite(value)) return "unknown";
    std::array<char, 32> text{};
    bool const large = value >= 999.5 && value < 1e15; // whole, not 1.02e+03
    auto const end = large ? std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, 0)
                           : std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 3);
    return {text.data(), end.ptr};
}

/// What the readers say about their files, each note with the name of its file.
void add_notes(std::vector<std::string>& to, std::filesystem::path const& file, std::vector<std::string> const& notes)
{
    for (auto const& note : notes) to.push_back(file.filename().string() + ": " + note);
}

/// The poses of --trajectory for a map from which its reader subtracted `origin`; empty without the option.
scene::Trajectory poses_of(Options const& o, scene::Pose const& first, std::array<double, 3> const& origin, std::vector<std::string>& notes)
{
    if (!o.trajectory) return {};
    auto poses = scene::load_trajectory(*o.trajectory, scene::most_poses, o.trajectory_format);
    add_notes(notes, *o.trajectory, scene::trajectory_notes(poses));
    return o.relative ? scene::relative_to_first(std::move(poses), first) : scene::relative_to_origin(std::move(poses), origin);
}

/// Poses of a map with an origin, in the coordinates of its file.
std::vector<scene::StampedPose> in_file_coordinates(std::vector<scene::StampedPose> poses, std::array<double, 3> const& origin)
{
    if (origin == std::array<double, 3>{}) return poses;
    for (auto& each : poses) each.pose.position += glm::dvec3{origin[0], origin[1], origin[2]};
    return poses;
}

/// A picture to track, and the pose that it was taken from, if that is known.
struct Seen {
    double seconds = 0.0;
    report::Image colour;
    report::Plane depth;
    std::optional<scene::Pose> truth;
};

/// Real pictures, with the poses of a trajectory that are at most 20 ms away as the truth.
class Photos {
public:
    Photos(Options const& o, std::vector<scene::RgbdFrame> list, scene::Trajectory poses, scene::Size size)
        : options_(o), list_(std::move(list)), poses_(std::move(poses)), size_(size)
    {
        std::vector<double> times;
        for (std::size_t k = 0; k < list_.size(); k += options_.every) times.push_back(list_[k].colour.seconds);
        nearest_ = track_camera::nearest_poses(times, poses_, scene::most_seconds_apart).of_picture;
    }
    std::size_t count() const { return nearest_.size(); }
    std::optional<scene::Pose> truth(std::size_t k) const { return nearest_[k] ? std::optional(poses_[*nearest_[k]].pose) : std::nullopt; }
    Seen take(std::size_t k) const
    {
        auto frame = list_[k * options_.every];
        if (!options_.depth) frame.depth.file.clear();
        auto photo = track_camera::read_photo(frame, size_, options_.depth_levels);
        return {frame.colour.seconds, std::move(photo.colour), std::move(photo.depth), truth(k)};
    }

private:
    Options const& options_;
    std::vector<scene::RgbdFrame> list_;
    scene::Trajectory poses_;
    scene::Size size_;
    std::vector<std::optional<std::size_t>> nearest_; ///< the pose of each picture
};

/// Pictures that are rendered from the map and spoilt. With an open shutter, a picture is the mean of three poses.
template <class Renderer>
class Renderings {
public:
    Renderings(Options const& o, Renderer& renderer, track_camera::Path path, scene::Intrinsics const& lens)
        : options_(o), renderer_(renderer), path_(std::move(path)), lens_(lens)
    {
        spoiling_.noise = o.noise;
        spoiling_.shutter = o.shutter;
        if (!(o.noise > 0.0)) spoiling_ = {0.0, false, 0.0, 0.0, 0.0, 0.0, 1};
    }
    std::size_t count() const { return static_cast<std::size_t>((path_.size() + options_.every - 1) / options_.every); }
    scene::Pose truth(std::size_t k) const { return scene::pose_of(scene::make_camera(path_[std::uint64_t{k} * options_.every].pose, lens_)); }
    Seen take(std::size_t k) const
    {
        auto const at = std::uint64_t{k} * options_.every;
        auto const [seconds, pose] = path_[at];
        auto target = renderer_.render(scene::make_camera(pose, lens_));
        for (std::size_t i = 0; i < target.depth.values.size(); ++i) // no sensor measures what is half covered
            if (target.alpha.values[i] < 0.5f) target.depth.values[i] = 0.0f;
        if (spoiling_.shutter > 0.0) {
            auto const step = velocity(at);
            auto const three = track::shutter_poses(track::moved(pose, {-step.rho, -step.phi}), pose, track::moved(pose, step), spoiling_.shutter);
            std::vector<report::Image> pictures{renderer_.render(scene::make_camera(three[0], lens_)).image, std::move(target.image), renderer_.render(scene::make_camera(three[2], lens_)).image};
            target.image = track::mean_of(pictures);
        }
        track::spoil(target.image, target.depth, k, spoiling_, options_.threads);
        return {seconds, std::move(target.image), std::move(target.depth), truth(k)};
    }

private:
    /// The camera's motion in a frame's time: the mean of the steps to pose i and from it. So the middle of the exposure is the pose itself,
    /// also where the steps jitter.
    track::Twist velocity(std::uint64_t i) const
    {
        track::Twist sum;
        double steps = 0.0;
        auto const add = [&](scene::Pose const& to, double sign) {
            auto const way = track::twist_between(path_[i].pose, to);
            sum.rho += sign * way.rho;
            sum.phi += sign * way.phi;
            steps += 1.0;
        };
        if (i > 0) add(path_[i - 1].pose, -1.0);
        if (i + 1 < path_.size()) add(path_[i + 1].pose, 1.0);
        if (steps > 0.0) sum.rho /= steps, sum.phi /= steps;
        return sum;
    }

    Options const& options_;
    Renderer& renderer_;
    track_camera::Path path_;
    scene::Intrinsics lens_;
    track::Spoiling spoiling_;
};

/// The median depth of what the picture shows. Throws `Error` if it shows nothing.
double median_depth(tilemesh::RenderedFrame const& frame)
{
    std::vector<float> depths;
    for (std::size_t i = 0; i < frame.depth.values.size(); ++i)
        if (frame.alpha.values[i] > 0.5f) depths.push_back(frame.depth.values[i]);
    if (depths.empty()) throw Error("the first view shows nothing of the map (no pixel is half covered); choose another camera or trajectory");
    std::nth_element(depths.begin(), depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2), depths.end());
    return double{depths[depths.size() / 2]};
}

/// Seen from above: x to the right, z forward.
std::string paths(std::vector<scene::StampedPose> const& estimated, std::vector<scene::StampedPose> const& truth)
{
    report::Plot plot{"camera path, seen from above", {"x (world units)"}, {"z (world units)"}, {}};
    for (auto const& [name, poses] : {std::pair{"truth", &truth}, std::pair{"estimated", &estimated}}) {
        if (poses->empty()) continue;
        report::PlotSeries series{name, {}};
        series.colour = static_cast<std::uint32_t>(plot.series.size());
        for (auto const& p : *poses) series.points.emplace_back(p.pose.position.x, p.pose.position.z);
        plot.series.push_back(series);
    }
    return report::svg(plot);
}

/// A text as JSON has it.
std::string json_text(std::string const& text)
{
    std::string out = "\"";
    for (char const c : text) {
        if (c == '"' || c == '\\') out += '\\';
        out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
    return out + '"';
}

/// The frames so far.
struct Outcome {
    std::vector<scene::StampedPose> estimated, truth;
    std::vector<scene::Pose> estimates, truths; ///< of the frames with a known truth
    std::string frames;                         ///< of the report
    double all_ms = 0.0;
    std::uint64_t evaluations = 0;
    std::size_t lost = 0, retried = 0;
    std::string first_loss; ///< why the first lost frame is lost
};

/// Tracks frame k. A frame that a part of the blocks lost is tracked again with all of them, from the same start.
void track_one(Options const& o, std::size_t k, Seen seen, track::Tracker& tracker, track::PoseEvaluator& evaluate, Outcome& out, Printer& printer)
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
    if (f.verdict == track::Verdict::lost && out.lost++ == 0) out.first_loss = f.why;
    out.retried += again;
    out.estimated.push_back({seen.seconds, f.pose});
    std::string errors = "null, \"translation_error\": null", off_by;
    if (seen.truth) {
        out.truths.push_back(*seen.truth);
        out.estimates.push_back(f.pose);
        out.truth.push_back({seen.seconds, *seen.truth});
        double const degrees = glm::length(track::twist_between(*seen.truth, f.pose).phi) * 180.0 / 3.14159265358979323846, off = glm::length(f.pose.position - seen.truth->position);
        errors = number(degrees) + ", \"translation_error\": " + number(off);
        off_by = ", off by " + rounded(degrees) + " degrees and " + rounded(off) + " world units";
    }
    printer.say("frame " + std::to_string(k) + ": " + track::name_of(f.verdict) + (f.why.empty() ? "" : ", ") + f.why + (again ? ", tried again with all blocks" : "") + ", " + std::to_string(evaluations) + " evaluations, " +
                rounded(ms) + " ms" + off_by + "\n");
    out.frames += std::string(k == 0 ? "" : ",\n") + "    {\"status\": \"" + track::name_of(f.verdict) + "\", \"why\": " + json_text(f.why) + ", \"seconds\": " + number(seen.seconds) + ", \"iterations\": " + std::to_string(evaluations) +
                  ", \"tried_again\": " + (again ? "true" : "false") + ", \"mean_cost\": " + number(f.mean_cost) + ", \"host_ms\": " + number(ms) + ", \"rotation_error_deg\": " + errors + "}";
}

/// Writes the trajectories, the plot and the report, and prints the summary.
void write_all(Options const& o, track_camera::PhotoWriter const* photos, Outcome const& out, double scale, std::array<double, 3> const& origin, Printer& printer)
{
    auto const estimated = in_file_coordinates(out.estimated, origin), truth = in_file_coordinates(out.truth, origin);
    report::write_whole(o.out / "estimated.tum", scene::tum_text(estimated));
    if (!truth.empty()) report::write_whole(o.out / "truth.tum", scene::tum_text(truth));
    report::write_whole(o.out / "paths.svg", paths(estimated, truth));
    if (photos) photos->finish(scene::tum_text(truth));
    auto const count = static_cast<double>(out.estimated.size());
    std::string summary;
    if (!out.truths.empty()) {
        auto const e = track::trajectory_errors(out.estimates, out.truths);
        summary = "\"ate_rmse\": " + number(e.ate.rmse) + ", \"ate_aligned_rmse\": " + number(e.ate_aligned.rmse) + ", \"rpe_rmse\": " + number(e.rpe.rmse) + ", \"rpe_deg_rmse\": " + number(e.rpe_deg.rmse) +
                  ", \"rotation_rmse_deg\": " + number(e.rotation_deg.rmse) + ", ";
        printer.say("ATE " + rounded(e.ate.rmse) + " world units (aligned " + rounded(e.ate_aligned.rmse) + "; " + rounded(e.ate.rmse / scale) + " of the median depth), " + rounded(e.rotation_deg.rmse) + " degrees; RPE " +
                    rounded(e.rpe.rmse) + " world units and " + rounded(e.rpe_deg.rmse) + " degrees a frame\n");
    }
    if (o.report)
        report::write_whole(*o.report, "{\n  \"frames\": [\n" + out.frames + "\n  ],\n  \"summary\": {" + summary + "\"median_depth\": " + number(scale) + ", \"frames_lost\": " + std::to_string(out.lost) + ", \"frames_tried_again\": " +
                                           std::to_string(out.retried) + ", \"evaluations\": " + std::to_string(out.evaluations) + ", \"host_ms_per_frame\": " + number(out.all_ms / count) + "}\n}\n");
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
template <class Source, class Renderer>
int track_all(Options const& o, Source const& source, Renderer& renderer, scene::Map const& map, scene::Intrinsics const& lens, scene::Size size, scene::Pose const& start, Printer& printer)
{
    track::PoseEvaluator evaluate{map, {size.width, size.height}, {.threads = o.threads, .tile = {o.tile.width, o.tile.height}}};
    double const scale = median_depth(renderer.render(scene::make_camera(start, lens)));
    auto& settings = evaluate.options();
    settings.with_depth = o.depth;
    settings.with_exposure = o.photos || o.noise > 0.0;
    settings.scene_depth = static_cast<float>(scale);
    track::TrackerOptions how;
    how.method = o.method;
    how.rows_per_pixel = o.depth ? 4.0 : 3.0;
    track::Tracker tracker{lens, scale, start, how};

    std::optional<track_camera::PhotoWriter> photos;
    if (o.save_photos) photos.emplace(*o.save_photos, o.depth_levels);
    Outcome out;
    report::Image last;
    auto const write = [&] {
        write_all(o, photos ? &*photos : nullptr, out, scale, map.origin, printer);
        report::write_ppm(o.out / "residual.ppm", report::error_picture(renderer.render(scene::make_camera(out.estimated.back().pose, lens)).image, last));
    };
    auto const count = std::min<std::size_t>(source.count(), o.frames);
    try {
        for (std::size_t k = 0; k < count && shared::interrupt() == 0; ++k) {
            auto seen = source.take(k); // whole, or not at all
            if (photos) photos->write(seen.seconds, seen.colour, seen.depth);
            auto colour = seen.colour;
            track_one(o, k, std::move(seen), tracker, evaluate, out, printer);
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
    std::vector<scene::RgbdFrame> list;
    if (o.photos) list = scene::load_rgbd(*o.photos);
    auto const size = o.photos ? track_camera::size_of(list.front()) : o.size.value_or(scene::Size{640, 480});
    auto const map = o.map ? scene::load_map(*o.map, shared::codecs(), scene::FarMeans::moved) : scene::built_in_map();
    auto notes = map.notes;
    auto camera = o.map ? scene::frame_whole(map, size) : scene::built_in_camera(size);
    std::vector<std::filesystem::path> sized_by;
    bool names_near = true;
    if (o.cameras) {
        std::vector<std::string> of_file;
        auto const cameras = scene::load_cameras(*o.cameras, &of_file, scene::DistortedLens::refused, size, &sized_by);
        add_notes(notes, *o.cameras, of_file);
        auto const chosen = scene::relative_to_origin(scene::select_cameras(cameras, o.camera, o.map ? o.map->stem().string() : "built-in"), map.origin);
        camera = scene::resized(chosen.front().camera, size.width, size.height);
        names_near = chosen.front().names_near;
    }
    auto lens = scene::lens_of(camera);
    auto poses = poses_of(o, scene::pose_of(camera), map.origin, notes);
    auto const first_view = [&] { return scene::make_camera(poses.empty() ? scene::pose_of(camera) : poses.front().pose, lens); };
    if (o.near_depth) lens.near_depth = *o.near_depth;
    else if (!names_near) lens.near_depth = scene::near_for(map, first_view());
    auto const view = splat::make_view(first_view(), {});
    auto const hides = [&](auto const& g) { return scene::only_near_hides(g, view); };
    if (auto const hidden = std::count_if(map.gaussians.begin(), map.gaussians.end(), hides); hidden != 0)
        notes.push_back(shared::near_note(static_cast<std::uint64_t>(hidden), {view.camera}));
    if (o.photos) add_notes(notes, *o.photos, scene::rgbd_notes(list));
    auto const rendered = o.trajectory ? std::uint64_t{poses.size()} : std::uint64_t{o.frames} * o.every;
    auto const frames = std::min<std::uint64_t>(((o.photos ? list.size() : rendered) + o.every - 1) / o.every, o.frames);
    track_camera::prepare_outputs(o, track_camera::files_read(o, list, sized_by), static_cast<std::size_t>(frames));
    for (auto const& note : notes) printer.say("note: " + shared::one_line(note) + "\n");

    tilemesh::BasicRenderer<splat::Referenced<WithPlanes>> renderer{map, {.threads = o.threads}};
    if (o.photos) {
        bool const has_truth = !poses.empty();
        Photos const source{o, std::move(list), std::move(poses), size};
        std::size_t known = 0;
        for (std::size_t k = 0; k < source.count(); ++k) known += source.truth(k) ? 1 : 0;
        if (has_truth && known == 0)
            throw Error(o.trajectory->string() + " is not the path of these pictures (no pose is within 20 ms of a picture); name another trajectory, or none");
        return track_all(o, source, renderer, map, lens, size, source.truth(0).value_or(scene::pose_of(camera)), printer);
    }
    Renderings const source{o, renderer, o.trajectory ? track_camera::Path{std::move(poses)} : track_camera::Path{scene::pose_of(camera), rendered}, lens};
    return track_all(o, source, renderer, map, lens, size, source.truth(0), printer);
}

} // namespace

int main(int argc, char** argv)
{
    return shared::run_softly("track_camera", [&] {
        auto const options = track_camera::options_of(argc, argv);
        if (!options) return 0;
        shared::note_interrupts(!options->quiet && isatty(STDERR_FILENO) == 1);
        return run(*options);
    });
}
