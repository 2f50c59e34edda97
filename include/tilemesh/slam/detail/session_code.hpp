#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/mapping/refiner.hpp>
#include <tilemesh/mapping/view_sums.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/slam/mapper.hpp>
#include <tilemesh/slam/session.hpp>
#include <tilemesh/slam/state_bytes.hpp>
#include <tilemesh/track/normal_equations.hpp>
#include <tilemesh/track/pose_evaluator.hpp>
#include <tilemesh/track/tracker.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace slam {

TILEMESH_HOST track::TrackerOptions tracker_options()
{
    track::TrackerOptions o;
    o.method = track::Method::forward;
    o.rows_per_pixel = 4;
    o.harmless_cost = 2.4e-3;
    return o;
}

struct Session::Work {
    SessionOptions options;
    scene::Intrinsics lens;
    float scene_depth;
    scene::Pose start;
    Mapper mapper;
    track::Tracker tracker;
    std::unique_ptr<track::PoseEvaluator> evaluator; ///< of the map since the last keyframe; made when a frame asks for it
    std::size_t frames = 0, last_keyframe = 0;
    /// What is kept of a keyframe besides its view.
    struct Kept {
        std::uint64_t frame;
        scene::Pose pose;
        track::Exposure exposure;
    };
    std::vector<Kept> keyframes;

    /// The picture as the map's colours would be: without the exposure that the tracker found.
    mapping::Target target_of(Frame const& frame, track::Exposure const& exposure) const
    {
        auto target = mapping::make_target(frame.colour, frame.depth);
        if (!options.with_exposure) return target;
        auto const per_gain = static_cast<float>(std::exp(-exposure.log_gain)), offset = static_cast<float>(exposure.offset);
        for (auto& p : target.pixels)
            for (float& v : p.rgb) v = (v - offset) * per_gain;
        return target;
    }
    track::TrackedFrame track(Frame const& frame)
    {
        if (!evaluator) {
            track::EvaluatorOptions how;
            how.threads = options.mapper.threads;
            how.tile = {options.tile.tile_width, options.tile.tile_height};
            evaluator = std::make_unique<track::PoseEvaluator>(mapper.map(), Extent2{lens.width, lens.height}, how);
            auto& rules = evaluator->rules();
            rules.coverage = options.mapper.coverage;
            rules.alpha_max = mapping::refining_rules().alpha_max;
            rules.transmittance_min = mapping::refining_rules().transmittance_min;
            evaluator->options().with_exposure = options.with_exposure;
            evaluator->options().scene_depth = scene_depth;
        }
        evaluator->set_target({frame.colour, frame.depth});
        return tracker.track_at(*evaluator, frame.seconds);
    }
};

TILEMESH_HOST Session::Session(scene::Map map, scene::Intrinsics const& lens, double scene_depth, scene::Pose const& start,
                               SessionOptions const& options)
{
    if (options.keyframe_every == 0 || !(options.most_open >= 0))
        throw Error("a session cannot have keyframes every " + std::to_string(options.keyframe_every) + " frames and where more than " +
                    std::to_string(options.most_open) + " of a picture is open (1 frame or more, and a share); change them");
    if (options.tracker.readout > 0.0)
        throw Error("a session cannot map by a rolling shutter (its maps take a picture as seen at once); leave `tracker.readout` 0");
    work_ = std::unique_ptr<Work>(new Work{options, lens, static_cast<float>(scene_depth), start,
                                           Mapper(std::move(map), static_cast<float>(scene_depth), options.mapper),
                                           track::Tracker(lens, scene_depth, start, options.tracker), nullptr, 0, 0, {}});
}
TILEMESH_HOST Session::~Session() = default;
TILEMESH_HOST Session::Session(Session&&) noexcept = default;
TILEMESH_HOST Session& Session::operator=(Session&&) noexcept = default;

TILEMESH_HOST FrameResult Session::add(Frame frame)
{
    auto& w = *work_;
    auto const size = [](auto const& picture) { return std::to_string(picture.width) + " x " + std::to_string(picture.height); };
    auto const fits = [&](auto const& picture) { return picture.width == w.lens.width && picture.height == w.lens.height; };
    if (!fits(frame.colour) || !fits(frame.depth))
        throw Error("a frame with a picture of " + size(frame.colour) + " and depths of " + size(frame.depth) +
                    " pixels cannot be mapped (the lens has " + size(w.lens) + "); give both in its size");
    FrameResult out;
    bool const begins = w.mapper.map().gaussians.empty() && w.mapper.keyframes() == 0;
    if (begins) {
        out.tracked.verdict = track::Verdict::converged;
        out.tracked.pose = out.tracked.start = w.start;
    } else {
        out.tracked = w.track(frame);
    }
    bool const lost = out.tracked.verdict == track::Verdict::lost;
    auto const number = w.frames++;
    if (lost) return out;
    auto const camera = scene::make_camera(out.tracked.pose, w.lens);
    auto target = w.target_of(frame, out.tracked.exposure);
    bool is_keyframe = w.mapper.keyframes() == 0 || number - w.last_keyframe >= w.options.keyframe_every;
    if (!is_keyframe) {
        out.open_share = w.mapper.open_share(camera, target);
        is_keyframe = out.open_share > w.options.most_open;
    }
    if (!is_keyframe) return out;
    out.keyframe = w.mapper.add(camera, std::move(target));
    w.last_keyframe = number;
    w.keyframes.push_back({number, out.tracked.pose, out.tracked.exposure});
    w.evaluator.reset(); // its map is an older one now
    // The tracker has seen no frame yet: it would take any picture for the next one. The pose stays what the caller said.
    if (begins) static_cast<void>(w.track(frame));
    return out;
}

TILEMESH_HOST std::string Session::save() const
{
    StateWriter out;
    out.put(std::uint64_t{work_->frames});
    out.put(std::uint64_t{work_->last_keyframe});
    out.put_all(work_->keyframes);
    out.put(work_->tracker.state());
    out.put_text(work_->mapper.save());
    return out.take();
}
TILEMESH_HOST void Session::load(std::string_view state, std::function<Frame(std::size_t)> const& frame)
{
    auto& w = *work_;
    StateReader in(state);
    auto const frames = in.get<std::uint64_t>(), last_keyframe = in.get<std::uint64_t>();
    auto keyframes = in.all<Work::Kept>();
    auto const tracker = in.get<track::Tracker::State>();
    auto const mapper = in.text();
    in.finish();
    std::vector<KeyframeView> views;
    for (auto const& k : keyframes) {
        if (k.frame >= frames) StateReader::fail();
        views.push_back({scene::make_camera(k.pose, w.lens), w.target_of(frame(static_cast<std::size_t>(k.frame)), k.exposure)});
    }
    w.mapper.load(mapper, std::move(views));
    w.frames = static_cast<std::size_t>(frames);
    w.last_keyframe = static_cast<std::size_t>(last_keyframe);
    w.keyframes = std::move(keyframes);
    w.tracker.restore(tracker);
    w.evaluator.reset();
}

TILEMESH_HOST Mapper& Session::mapper() noexcept { return work_->mapper; }
TILEMESH_HOST scene::Map const& Session::map() const noexcept { return work_->mapper.map(); }
TILEMESH_HOST std::size_t Session::frames() const noexcept { return work_->frames; }

}}} // namespace tilemesh::slam
