#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/render/host.hpp>
#include <tilemesh/render/host_form.hpp>
#include <tilemesh/render/picture.hpp>
#include <tilemesh/render/record_keeper.hpp>
#include <tilemesh/render/record_table.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/screen_cache.hpp>
#include <tilemesh/render/setup_on_mesh.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/pose/program.hpp>
#include <tilemesh/splat/pose/terms.hpp>
#include <tilemesh/track/normal_equations.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

namespace track {
/// The parameters of a program that tracks by reference: the tables of this view, with the two words of each splat's derivative.
struct PoseTableParameters : splat::TableParameters {
    static constexpr char const* name = "frame parameters and tables (tracking)";
    splat::HostPointer<splat::pose::Terms const> terms;
};
/// The host's form of a setup that tracks.
template <class S>
struct TrackedByReference : splat::Referenced<splat::pose::Tracked<S>> {
    using Parameters = PoseTableParameters;
};

/// The tile for tracking with pictures of this size: the smallest whose sides are multiples of 8 pixels, so that cells of 2, 4 and 8 pixels
/// divide it, and of which the machine has enough. Of equally small ones the one with the shortest edge, and then the narrowest. Mk2 has
/// 1,440 tiles of 16 x 40 pixels for 1280 x 720, 1,200 of 16 x 16 for 640 x 480, 1,200 of 8 x 8 for 320 x 240, and 240 for 160 x 90.
TILEMESH_HOST Extent2 tracking_tile(Extent2 frame, MachineSize const& machine) noexcept;
} // namespace track

namespace splat {
template <>
struct Access<track::PoseTableParameters> : TableAccess<track::PoseTableParameters> {
    TILEMESH_KERNEL static pose::Terms const& terms_of(track::PoseTableParameters const& frame, SplatRow s) noexcept
    {
        return frame.terms.get()[s.row];
    }
};
namespace pose {
template <>
inline constexpr bool has_host_stack<track::PoseTableParameters> = true;
} // namespace pose
} // namespace splat

namespace track {

/// The picture that the camera saw: linear RGB in [0, 1], and optionally view depths in world units. A depth of 0 or NaN is not known. A
/// pixel with a NaN in its colour does not count.
struct TrackTarget {
    report::Image colour;
    report::Plane depth{}; ///< empty: no depth
};

/// What an evaluation computes, besides its level.
struct TrackOptions {
    Level level{};
    bool with_depth = true;      ///< depth residuals (D - D*) / D*, where the target has a depth
    bool with_exposure = false;  ///< 8 unknowns
    std::uint32_t one_in = 1;    ///< evaluates one in so many blocks of 16 x 5 pixels (with cells, of 16 x 5 `cell`); 1: all
    std::uint32_t seed = 0;      ///< chooses these blocks
    float huber_colour = 0.1f, huber_depth = 0.05f;
    float scene_depth = 1.0f;    ///< S: the unit of translations; take the map's median depth in the first view
};

/// How a mesh evaluates.
struct EvaluatorOptions {
    std::uint32_t threads = 1;
    Extent2 tile{}; ///< pixels; both 0: `tracking_tile`
};

/// Evaluates poses of a camera on a mesh of tiles: the least-squares sums of a picture against a map, by forward mode or by gradients of
/// the picture. It loads the map's records onto the tiles once; records and copies stay there between evaluations, so that a small step moves few
/// records.
///
/// A tile's storage has as many slots as the machine's SRAM leaves for tiles of this size (`splat::pose::sizes_on`).
///
/// The sums are integers on the mesh. So they have the same bits for any tiling, number of threads and engine, as long as no record is
/// lost. View-dependent colour is evaluated, but counts as constant in the derivative. `S` is a setup: TrackedByReference<Lossless>, or
/// splat::pose::Tracked<Lossless> by value. It is a template, and not an option of Renderer, because poses have a program of their own and
/// PoplarMesh and MpiMesh are types. `PoseEvaluator` is the one on host threads.
///
/// Errors: it throws Error if the frame, a cell, a target or an option does not fit, and NoRoom if a record or a copy finds no room on its
/// tile; after that it loads the map again.
template <class S = TrackedByReference<splat::Lossless>, template <class, class> class Engine = Mesh>
class BasicPoseEvaluator {
public:
    using Policies = splat::PoliciesOf<S>;
    using Parameters = typename Policies::Parameters;
    using Program = splat::pose::PoseFrame<Policies>;
    using MeshType = Engine<Program, AnyMachine>;
    using EngineOptions = typename MeshType::Options;
    using HostType = render::Host<MeshType, AnyMachine>;
    static constexpr bool by_reference = std::is_same_v<typename Policies::Record, splat::Reference>;

    /// `frame`: the size of the pictures, in pixels.
    BasicPoseEvaluator(scene::Map map, Extent2 frame, EvaluatorOptions options = {}, EngineOptions engine = {});
    BasicPoseEvaluator(BasicPoseEvaluator const&) = delete;
    BasicPoseEvaluator& operator=(BasicPoseEvaluator const&) = delete;

    /// The rules of the picture. Change them between evaluations. Forward mode always has `precise` arithmetic.
    /// With `Coverage::preserved`, the picture and the residuals are right, and the derivative leaves out that opacities move with the pose.
    splat::Rules& rules() noexcept { return rules_; }
    splat::Tiling const& tiling() const noexcept { return layout_.tiling; }
    /// The slots of a tile's lists, in the machine's memory.
    splat::Sizes const& sizes() const noexcept { return sizes_; }
    /// The mesh. It exists after the first evaluation.
    MeshType& mesh() noexcept { return host_.mesh(); }
    /// The counters of the last evaluation.
    RunCounters const& counters() const noexcept { return counters_; }

    /// Sets the picture for the next evaluations.
    void set_target(TrackTarget target);
    /// The options of `operator()`.
    TrackOptions& options() noexcept { return track_; }

    /// The sums of one pose, against the target that was set.
    NormalEquations evaluate(splat::Camera const& camera, TrackOptions const& options);
    NormalEquations evaluate(splat::Camera const& camera, TrackTarget target, TrackOptions const& options)
    {
        set_target(std::move(target));
        return evaluate(camera, options);
    }
    NormalEquations operator()(splat::Camera const& camera, Level const& level)
    {
        track_.level = level;
        return evaluate(camera, track_);
    }

private:
    /// The highest degree of a map's harmonics.
    static constexpr std::uint32_t degree = [] {
        if constexpr (by_reference)
            return 3u;
        else
            return Policies::Record::sh_degree;
    }();
    void check(splat::Camera const& camera, TrackOptions const& o) const;
    void build();
    void load_target();
    /// In a new view, projects the host's table and the words of its derivatives, and tells the tiles.
    void tell(splat::View const& view);
    splat::pose::Tracking tracking_of(splat::Camera const& camera, TrackOptions const& o) const noexcept;
    /// Throws if a record or a copy found no room.
    void require_all();
    static NormalEquations equations(splat::pose::Tracking const& t, splat::pose::Totals const& totals);

    EvaluatorOptions options_;
    HostType host_;
    Extent2 size_;
    splat::Sizes sizes_{};
    render::RecordTable records_;
    render::ScreenCache cache_;
    render::RecordKeeper<Policies> keeper_;
    std::vector<splat::pose::Terms> terms_;          ///< by rows, of this view
    splat::Rules rules_;
    splat::PolicyWords policies_{};
    render::FrameLayout layout_{};
    std::optional<splat::View> last_;
    RunCounters counters_{};
    TrackTarget target_{};
    TrackOptions track_{};
};

template <class S, template <class, class> class Engine>
BasicPoseEvaluator<S, Engine>::BasicPoseEvaluator(scene::Map map, Extent2 frame, EvaluatorOptions options, EngineOptions engine)
    : options_(options), host_(std::move(engine)), size_(frame), records_(std::move(map), degree),
      cache_(by_reference ? records_.rows() : 0), keeper_(records_, &cache_), terms_(by_reference ? records_.rows() : 0),
      rules_(splat::lossless.rules)
{
    constexpr auto machine = size_of_machine<typename S::Machine>();
    bool const follows = options.tile.width == 0 && options.tile.height == 0;
    layout_ = render::layout_frame({{}, follows ? tracking_tile(frame, machine) : options.tile}, frame.width, frame.height, machine,
                                   machine.sram_bytes / sizeof(splat::pose::TargetPixel), "tracking");
    sizes_ = splat::pose::sizes_on<typename splat::ValueOf<S>::type>(machine, std::uint32_t{layout_.tiling.tile_width} * layout_.tiling.tile_height,
                                                                     by_reference ? records_.map().sh_degree : degree);
    if (sizes_.storage == 0)
        throw Error("tiles of " + std::to_string(layout_.tiling.tile_width) + " x " + std::to_string(layout_.tiling.tile_height) +
                    " pixels (machine " + machine.name +
                    " has no memory for splats beside them); choose smaller tiles, a smaller frame or another machine");
}

template <class S, template <class, class> class Engine>
void BasicPoseEvaluator<S, Engine>::set_target(TrackTarget target)
{
    auto const fits = [&](auto const& p) { return p.width == size_.width && p.height == size_.height; };
    if (!fits(target.colour) || (target.depth.width != 0 && !fits(target.depth)))
        throw Error("a target of " + std::to_string(target.colour.width) + " x " + std::to_string(target.colour.height) + " pixels (frames are " +
                    std::to_string(size_.width) + " x " + std::to_string(size_.height) + ", colour and depth alike); resize it");
    target_ = std::move(target);
    if (host_.has_mesh()) load_target();
}

template <class S, template <class, class> class Engine>
NormalEquations BasicPoseEvaluator<S, Engine>::evaluate(splat::Camera const& camera, TrackOptions const& options)
{
    auto const view = host_.view_of(camera, rules_, [&](splat::View const&) { check(camera, options); });
    if (!host_.has_mesh()) build();
    auto const tracking = tracking_of(camera, options);
    host_.begin_frame(); // if it throws, records may be halfway, and the next evaluation builds the mesh again
    tell(view);
    host_.mesh().template broadcast<splat::pose::Tracking>() = tracking;
    counters_ = host_.run();
    require_all();
    host_.end_frame();
    last_ = view;
    return equations(tracking, std::as_const(host_.mesh()).template state<Reduced<splat::pose::TileTotal, Sum>>(TileId::at(0, 0)).value);
}

template <class S, template <class, class> class Engine>
void BasicPoseEvaluator<S, Engine>::check(splat::Camera const& camera, TrackOptions const& o) const
{
    if (camera.width != size_.width || camera.height != size_.height)
        throw Error("a camera of " + std::to_string(camera.width) + " x " + std::to_string(camera.height) + " pixels (frames are " +
                    std::to_string(size_.width) + " x " + std::to_string(size_.height) + "); scale its intrinsics");
    scene::check_no_panorama(camera, "a pose's derivative");
    if (target_.colour.width == 0) throw Error("an evaluation without a target (residuals need a picture); call set_target first");
    auto const cell = o.level.cell;
    if (cell != 1 && cell != 2 && cell != 4 && cell != 8)
        throw Error("cells of " + std::to_string(cell) + " pixels (a cell is 1, 2, 4 or 8 pixels wide); choose one of these");
    auto const& t = layout_.tiling;
    if (t.tile_width % cell != 0 || t.tile_height % cell != 0)
        throw Error("cells of " + std::to_string(cell) + " pixels on tiles of " + std::to_string(t.tile_width) + " x " +
                    std::to_string(t.tile_height) + " (a cell lies on one tile); choose smaller cells or other tiles");
    constexpr auto most = splat::pose::most_cells_a_side;
    if (o.level.jacobian != Jacobian::forward && (t.tile_width > most * cell || t.tile_height > most * cell))
        throw Error("gradients on tiles of " + std::to_string(t.tile_width) + " x " + std::to_string(t.tile_height) + " pixels (a side has at most " +
                    std::to_string(most) + " cells); choose larger cells or smaller tiles");
    if (o.one_in == 0) throw Error("one in 0 blocks (1 is all of them); choose 1 or more");
    auto const above_0 = [](float v) { return v > 0 && v <= 1e18f; };
    if (!above_0(o.huber_colour) || !above_0(o.huber_depth) || !above_0(o.scene_depth))
        throw Error("a Huber width or scene depth that is not above 0 (residuals and translations are measured in it); give a positive number");
    if (!(std::fabs(o.level.exposure.log_gain) < 40) || !(std::fabs(o.level.exposure.offset) < 1e6))
        throw Error("an exposure beyond e^40 or an offset beyond 1e6 (pictures are in [0, 1]); start from 0");
}

template <class S, template <class, class> class Engine>
void BasicPoseEvaluator<S, Engine>::build()
{
    policies_ = splat::policy_words(splat::setup_of<splat::pose::Tracked<splat::Lossless>>());
    auto const& t = layout_.tiling;
    RendererOptions plain;
    plain.threads = options_.threads;
    host_.build(plain, records_, [&] {
        auto m = engine::plain_sizes<Program>(size_of_machine<typename S::Machine>(), sizes_, typename machine::Needs<Program>::States{},
                                              typename machine::Needs<Program>::Links{});
        m.template link<splat::Road<Policies>>().message_bytes = policies_.road_bytes;
        m.template link<splat::Beam<Policies>>().message_bytes = policies_.beam_bytes;
        return render::MeshPlan<Program>{Program{}, Grid{t.columns, t.rows}, std::move(m)};
    });
    last_.reset();
    try {
        keeper_.begin(host_, t, sizes_.storage);
        render::size_framebuffers<Policies>(host_, t, size_);
        load_target();
    } catch (...) {
        host_.drop_mesh();
        throw;
    }
}

template <class S, template <class, class> class Engine>
void BasicPoseEvaluator<S, Engine>::load_target()
{
    if (target_.colour.width == 0) return;
    splat::Camera frame{};
    frame.width = size_.width, frame.height = size_.height;
    auto& mesh = host_.mesh();
    auto const grid = mesh.grid();
    for (std::uint32_t i = 0; i < grid.size(); ++i) {
        auto const rect = splat::pixels_of(layout_.tiling, frame, grid.tile(i));
        auto pixels = mesh.template state<splat::pose::Target<Policies>>(grid.tile(i));
        pixels.truncate(0);
        for (std::uint32_t y = rect.y0; y < rect.y1; ++y)
            for (std::uint32_t x = rect.x0; x < rect.x1; ++x) {
                float const* const rgb = target_.colour.pixel(x, y);
                pixels.unchecked_push({{rgb[0], rgb[1], rgb[2]}, target_.depth.width != 0 ? target_.depth.at(x, y) : 0.0f});
            }
    }
}

template <class S, template <class, class> class Engine>
void BasicPoseEvaluator<S, Engine>::tell(splat::View const& view)
{
    auto& frame = host_.mesh().template broadcast<Parameters>();
    bool const changed = !last_ || __builtin_memcmp(&*last_, &view, sizeof view) != 0;
    if constexpr (by_reference)
        if (changed)
            host_.on_threads(records_.rows(), [&](std::uint32_t first, std::uint32_t last) {
                cache_.project(records_, first, last, view, layout_.tiling, !last_, frame);
                splat::pose::terms_of_all(records_.gaussians().data() + first, last - first, view, layout_.tiling, terms_.data() + first);
            });
    static_cast<splat::FrameParameters&>(frame) = {view, layout_.tiling, static_cast<std::uint8_t>(changed ? 1 : 0), 0, 0};
    if constexpr (by_reference) {
        frame.policies = policies_;
        cache_.point(frame, false);
        frame.terms = splat::HostPointer<splat::pose::Terms const>(terms_.data());
    }
}

template <class S, template <class, class> class Engine>
splat::pose::Tracking BasicPoseEvaluator<S, Engine>::tracking_of(splat::Camera const& camera, TrackOptions const& o) const noexcept
{
    // The largest sums of a cell: 4 c^2 of J^T J, and c times the Huber widths of J^T r, because a clipped row has at most c.
    double const focal = std::fmax(camera.fx, camera.fy), clip = 4 * focal;
    auto const scale = [](double most) { return static_cast<float>(std::exp2(std::floor(std::log2(0x1p23 / most)))); };
    splat::pose::Tracking t{};
    t.forward = o.level.jacobian == Jacobian::forward ? 1 : 0;
    t.gradients = o.level.jacobian == Jacobian::forward ? 0 : o.level.jacobian == Jacobian::gradient ? 1 : 2;
    t.cell = o.level.cell;
    t.with_depth = o.with_depth && target_.depth.width != 0 ? 1 : 0;
    t.unknowns = o.with_exposure ? 8 : 6;
    t.one_in = o.one_in;
    t.seed = o.seed;
    t.sums = {static_cast<float>(std::exp(o.level.exposure.log_gain)), static_cast<float>(o.level.exposure.offset), o.huber_colour,
              o.huber_depth, o.scene_depth, static_cast<float>(std::exp2(std::round(std::log2(focal)))), static_cast<float>(clip),
              scale(4 * clip * clip), scale(clip * (3 * double{o.huber_colour} + double{o.huber_depth})), scale(4)};
    return t;
}

template <class S, template <class, class> class Engine>
void BasicPoseEvaluator<S, Engine>::require_all()
{
    std::uint64_t lost = 0;
    keeper_.for_each_tile(host_, [&](TileId tile) {
        auto const& counts = std::as_const(host_.mesh()).template state<splat::Counts>(tile);
        lost += counts.storage_full + counts.copies_full + counts.copies_refused;
    });
    if (lost != 0)
        throw NoRoom(std::to_string(lost) + " splats without room on a tile (each tile has " + std::to_string(sizes_.storage) +
                    " slots); choose larger pictures, other tiles or a map with fewer Gaussians");
}

template <class S, template <class, class> class Engine>
NormalEquations BasicPoseEvaluator<S, Engine>::equations(splat::pose::Tracking const& t, splat::pose::Totals const& totals)
{
    auto const number = [](splat::pose::Wide w) { return static_cast<double>(static_cast<std::int64_t>(std::uint64_t{w.high} << 32 | w.low)); };
    auto const unit = [&](std::uint32_t i) { return i < splat::pose::motions ? 1.0 : double{t.sums.exposure_unit}; };
    NormalEquations e;
    e.unknowns = t.unknowns;
    for (std::uint32_t i = 0, at = 0; i < t.unknowns; ++i) {
        e.g[i] = number(totals.g[i]) / (double{t.sums.g_scale} * unit(i));
        for (std::uint32_t j = 0; j <= i; ++j, ++at) e.h[i][j] = e.h[j][i] = number(totals.h[at]) / (double{t.sums.h_scale} * unit(i) * unit(j));
    }
    e.cost = number(totals.cost) / double{t.sums.cost_scale};
    e.pixels = totals.cells;
    return e;
}

/// The default: on host threads, by reference.
using PoseEvaluator = BasicPoseEvaluator<>;
static_assert(Evaluator<PoseEvaluator>);
#if defined(TILEMESH_COMPILED)
extern template class BasicPoseEvaluator<TrackedByReference<splat::Lossless>, Mesh>;
#endif

} // namespace track
}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/track/detail/pose_evaluator_code.hpp>
#endif
