#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/slam/mapper.hpp>
#include <tilemesh/track/depth_misfit.hpp>
#include <tilemesh/track/tracker.hpp>

namespace tilemesh { inline namespace v0_2 { namespace slam {

/// The options of a tracker that follows a map which grows: forward mode, colours and depth. The map explains its newest keyframe far better
/// than the frame after it. So a mean cost never makes a frame lost up to that of three channels that are off by 0.04 each; over 100 frames
/// of Sloth along fr1_xyz, the largest was 2.1e-3.
TILEMESH_HOST track::TrackerOptions tracker_options();

/// How a session tracks and maps.
struct SessionOptions {
    MapperOptions mapper{};       ///< its threads are the session's
    track::TrackerOptions tracker = tracker_options();
    std::uint32_t keyframe_every = 5; ///< a frame this many frames after the last keyframe is one
    double most_open = 0.08;          ///< so is a frame of which more than this share is not covered (`Mapper::open_share`)
    bool with_exposure = false;       ///< the gain and the offset of each picture are unknown, against those of the first
    splat::TileSize tile{0, 0};       ///< of the tracker's mesh; 0: `track::tracking_tile`
};

/// A picture with depth. A depth of 0 or NaN is not known.
struct Frame {
    double seconds = 0;
    report::Image colour;
    report::Plane depth;
};

/// What a session found for a frame.
struct FrameResult {
    track::TrackedFrame tracked;        ///< the first frame of a session without a map: the start, without a solution
    double open_share = 0;              ///< 0 where nobody asked: a lost frame, or a keyframe by count
    std::optional<Keyframe> keyframe;   ///< if the frame is one
};

/// Simultaneous localisation and mapping with one camera: each frame is tracked by the map so far, and keyframes extend and refine the map.
///
/// The first frame of a session without a map is at `start` by definition, and a keyframe. A lost frame is never a keyframe: it would
/// destroy the map. There is no loop closure and no relocalisation over the whole map.
///
/// After the same frames, the map and the poses have the same bits for any number of threads and any tiling.
///
/// Throws `Error` as `Mapper`, `track::Tracker` and `track::PoseEvaluator`, and for a frame without depths or of another size than the
/// lens.
class Session {
public:
    /// `map`: to start from; it may be empty. `scene_depth`: `median_depth` of the first frame.
    TILEMESH_HOST Session(scene::Map map, scene::Intrinsics const& lens, double scene_depth, scene::Pose const& start,
                          SessionOptions const& options = {});
    TILEMESH_HOST ~Session();
    TILEMESH_HOST Session(Session&&) noexcept;
    TILEMESH_HOST Session& operator=(Session&&) noexcept;

    /// Tracks a frame, and makes it a keyframe where the rules say so. Stamps may have gaps (`track::Tracker::track_at`).
    TILEMESH_HOST FrameResult add(Frame frame);

    /// What the session needs to go on, as bytes for `load`: the map with the optimiser's states, the tracker, and the number, pose and
    /// exposure of each keyframe. No picture is among them.
    TILEMESH_HOST std::string save() const;
    /// Goes on where another session with the same map to start from, lens, depth, start and options was saved, with the same bits.
    /// `frame(k)` must give frame k, from 0, as `add` got it; it is called for each keyframe, and may throw. Throws `Error` for bytes that
    /// do not fit. After a throw, the session is as it was.
    TILEMESH_HOST void load(std::string_view state, std::function<Frame(std::size_t)> const& frame);

    TILEMESH_HOST Mapper& mapper() noexcept;
    TILEMESH_HOST scene::Map const& map() const noexcept;
    TILEMESH_HOST std::size_t frames() const noexcept;

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

using track::median_depth;

}}} // namespace tilemesh::slam

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/slam/detail/session_code.hpp>
#endif
