#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/mapping/view_sums.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/map/insert.hpp>
#include <tilemesh/splat/rules.hpp>
#include <tilemesh/splat/view.hpp>
#include <vector>

/// A map that grows from pictures with depth, on the host: keyframes, and a camera that is tracked by the map so far.
namespace tilemesh { inline namespace v0_2 { namespace slam {

/// How Gaussians move by their slopes: `splat::map::Adam`, or `splat::map::SecondMomentByKind` with a fifth of its words.
enum class Optimiser { adam, by_kind };

TILEMESH_HOST char const* name_of(Optimiser optimiser) noexcept;

/// How a map grows. The constants were measured over 100 frames of a recorded motion (examples/slam/README.md).
struct MapperOptions {
    Optimiser optimiser = Optimiser::adam;
    splat::map::InsertRules insert{};
    splat::map::RemoveRules remove{};
    std::uint32_t first_steps = 60, steps = 30; ///< after the first keyframe, and after each other one
    std::uint32_t window = 8;   ///< a quarter of the steps takes one of so many last keyframes, a quarter any, and half the newest
    float rate = 2;             ///< times `splat::map::usual_rates`; rates fall to a tenth of that within each keyframe
    float depth_weight = 1;     ///< of the loss; that of colours is 1. With 0.5, poses are 5 % worse
    std::uint32_t threads = 1;
    splat::TileSize tile{32, 20}; ///< changes no bit of the map
    std::uint64_t seed = 1;       ///< of the choice of keyframes
    splat::Coverage coverage = splat::Coverage::of_record; ///< `preserved`: with anti-aliasing; the map must be shown so, too
    /// Asked before each step but a keyframe's first, if it is given: true ends the steps of this keyframe, or of `refine`.
    std::function<bool()> stop{};
};

/// What a keyframe did to the map.
struct Keyframe {
    std::size_t inserted = 0, removed = 0, gaussians = 0; ///< `gaussians`: in the map afterwards
    std::uint32_t steps = 0;
    bool stopped = false; ///< `MapperOptions::stop` ended its steps early
    double psnr_db = 0; ///< of this keyframe's picture, afterwards
};

/// A keyframe's camera, and what it saw.
struct KeyframeView {
    splat::Camera camera;
    mapping::Target target;
};

/// Extends and refines a map by keyframes whose poses are known.
///
/// A keyframe inserts Gaussians where the map does not explain its picture (`splat::map::InsertRules`), then takes steps by it and by
/// earlier keyframes, then removes faint and huge Gaussians. After the same keyframes, the map has the same bits for any number of threads,
/// any tile of whole blocks, and every compiler that fuses multiply_add alike.
///
/// Ids: those of a map to start from are below 2^20; keyframe k, from 1, gives its Gaussians ids from k 2^20 on.
///
/// Throws `Error` as `mapping::Refiner`, for a scene depth or rate that is not positive and finite, for a window or cell of 0, for a map to
/// start from with other ids, for pictures with more than 2^20 - 1 cells, and for more than 4,095 keyframes.
///
/// Memory: 16 bytes a pixel of each keyframe, besides that of `mapping::Refiner`.
class Mapper {
public:
    /// `map`: to start from; it may be empty. `scene_depth`: the median depth of the scene in world units.
    TILEMESH_HOST Mapper(scene::Map map, float scene_depth, MapperOptions const& options = {});
    TILEMESH_HOST ~Mapper();
    TILEMESH_HOST Mapper(Mapper&&) noexcept;
    TILEMESH_HOST Mapper& operator=(Mapper&&) noexcept;

    /// Adds a keyframe. The target's depths say where Gaussians are: a cell without a known depth gets none.
    TILEMESH_HOST Keyframe add(splat::Camera const& camera, mapping::Target target);
    /// Takes steps by all keyframes, each once in a round and each round in another order, as after the last frame. Rates fall to a tenth
    /// over these steps. Nothing is inserted or removed; without a keyframe, nothing happens. Returns the steps that were taken: fewer if
    /// `MapperOptions::stop` says so.
    TILEMESH_HOST std::uint32_t refine(std::uint32_t steps);
    /// The share of a target's pixels that have a known depth and are at most half covered by the map: a large share wants a keyframe.
    TILEMESH_HOST double open_share(splat::Camera const& camera, mapping::Target const& target);
    /// How well a view of the map agrees with a target.
    TILEMESH_HOST mapping::Fit measure(splat::Camera const& camera, mapping::Target const& target);
    /// A view of the map.
    TILEMESH_HOST mapping::Seen render(splat::Camera const& camera);

    /// The records and the optimiser's states, as bytes for `load`. The keyframes are not among them.
    TILEMESH_HOST std::string save() const;
    /// Goes on where another mapper with the same options and a map to start from of the same degree was saved: its bytes, and its
    /// keyframes in their order. The map gets the bits that the other would get. Throws `Error` for bytes that do not fit, and changes
    /// nothing then.
    TILEMESH_HOST void load(std::string_view state, std::vector<KeyframeView> keyframes);

    TILEMESH_HOST scene::Map const& map() const noexcept;
    TILEMESH_HOST std::size_t keyframes() const noexcept;
    TILEMESH_HOST MapperOptions const& options() const noexcept;

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

/// The keyframe that step `step` after keyframe `newest` takes, both from 0: `newest` in even steps, one of the last `window` in steps 1,
/// 5, 9, and any in steps 3, 7, 11. A function of its arguments alone.
TILEMESH_HOST std::size_t keyframe_of_step(std::size_t newest, std::uint32_t step, std::uint32_t window, std::uint64_t seed) noexcept;

/// The keyframe of `count` that a step of `Mapper::refine` takes. A function of its arguments alone.
TILEMESH_HOST std::size_t keyframe_of_round(std::size_t count, std::uint32_t step, std::uint64_t seed);

}}} // namespace tilemesh::slam

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/slam/detail/mapper_code.hpp>
#endif
