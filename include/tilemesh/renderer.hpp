#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/model/no_progress.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/losses.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/scene/records.hpp>
#include <tilemesh/screen_cache.hpp>
#include <tilemesh/splat/quality.hpp>
#include <tilemesh/splat/with_pixel.hpp>
#include <type_traits>
#include <unordered_set>
#include <utility>
#include <vector>

namespace tilemesh {

/// Width and height of a grid in tiles, or of a tile in pixels.
struct Extent2 {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
};

/// What a Renderer may be told. Zeros mean "as the setup says".
struct RendererOptions {
    std::uint32_t threads = 1;
    Extent2 grid{};                          ///< tiles; 0: follows from frame and tile, or 40 x 36
    Extent2 tile{};                          ///< pixels; 0: the frame spread evenly over the grid
    std::uint32_t hops = 0;                  ///< supersteps of routing, and of bloom, a frame; 0: until quiet
    std::uint32_t channel_slots = 0;         ///< a limit, at most the setup's; for dynamic channels their size
    std::uint32_t waiting_slots = 0;         ///< of each of routing's FIFOs; a limit, at most the setup's
    std::uint32_t storage_slots = 0;         ///< a limit, at most the setup's
    std::optional<splat::Footprint> footprint{};
    std::optional<splat::Arithmetic> arithmetic{};
    std::optional<splat::Quality> quality{};  ///< its two cut-offs instead of the setup's, for `model()` to begin with
    bool digest = false;
    /// Of routing, and of bloom, in a run; a frame that needs more throws Error (MeshOptions::most_passes). 0: what the engine's own
    /// options say. Engines without such a bound (PoplarMesh) leave it out.
    std::uint32_t most_passes = 0;
};

/// How a frame is cut: `tile` where it is given, or else evenly over `grid`, or over 40 x 36 tiles.
inline splat::Tiling tiling_for(RendererOptions const& options, std::uint32_t width, std::uint32_t height) noexcept
{
    auto const parts = [](std::uint32_t size, std::uint32_t tile) { return (size + tile - 1) / tile; };
    auto tile = options.tile;
    if (tile.width == 0 || tile.height == 0) {
        Extent2 const grid = options.grid.width == 0 || options.grid.height == 0 ? Extent2{40, 36} : options.grid;
        tile = {parts(width, grid.width), parts(height, grid.height)};
    }
    return splat::make_tiling(width, height, tile.width, tile.height);
}

/// Does a setup leave the size of a channel to the run?
template <class S>
constexpr bool has_dynamic_channel() noexcept
{
    return (S::routes && splat::Road<S>::static_capacity == dynamic_capacity) ||
           (S::blooms && splat::Beam<S>::static_capacity == dynamic_capacity);
}

/// A picture and what it took.
struct RenderedFrame {
    report::Image image;
    report::Plane depth; ///< view z in world units, 0 where nothing is; empty unless the setup's pixels have it (WithDepth)
    report::Plane alpha; ///< share of the pixel that is covered; empty unless the setup's pixels have it (WithAlpha)
    report::FrameReport report;
};

/// Renders a map on a mesh of tiles, frame after frame: loads the map's records onto the tiles once, then runs the frame
/// program for each camera. Records and copies stay on their tiles in between, so a small step moves little and a static view
/// nothing.
///
/// `S` is a setup (splat/setup.hpp): machine, policies, bytes of every region. `Engine` is Mesh or CheckedMesh, or PoplarMesh
/// (poplar/poplar_mesh.hpp), which runs the program on an IPU. With
/// `splat::Referenced<S>` the host moves references instead of records and projects each record once a view: the pictures and
/// reports of S, in a fraction of the time. Its digests are of the references, and no other form's.
///
/// Errors: throws Error when the frame, the grid or the map does not fit the machine, or a limit is out of range. What finds no
/// room while a frame runs is no error: it is listed in the frame's report by id and cause. With `Hold`, a record whose anchor
/// tile is full is handed back to the host, which puts it onto the mesh again for the next view; with `Drop` it is gone, as on
/// the paper's machine. Copies of an unplaced record that are left on other tiles are recalled by the host, and the frame is
/// composited again, so that the picture shows a record whole or not at all.
template <class S = splat::Lossless, template <class, class> class Engine = Mesh>
class BasicRenderer {
public:
    using Setup = S;
    using Program = splat::Frame<S>;
    using Steps = splat::FrameSteps<S>;
    using Value = typename splat::ValueOf<S>::type;
    static constexpr bool by_reference = splat::ValueOf<S>::referenced;
    static_assert(!by_reference || !has_dynamic_channel<Value>(),
                  "a setup with dynamic channels by reference (their bytes are checked against the SRAM that the values leave); "
                  "render S itself");
    using Record = typename Value::Record;
    using Parameters = typename S::Parameters;
    using Machine = typename S::Machine;
    using MeshType = Engine<Program, Machine>;
    using EngineOptions = typename MeshType::Options;
    using Layout = Tile<Machine, splat::Frame<Value>>; ///< of the machine that S simulates

    /// `engine`: what the engine wants to know besides; threads and digest follow from `options`.
    explicit BasicRenderer(scene::Map const& map, RendererOptions options = {}, EngineOptions engine = {})
        : options_(options), engine_(std::move(engine)), gaussians_(scene::records<Record>(map)),
          cache_(by_reference ? static_cast<std::uint32_t>(gaussians_.size()) : 0)
    {
        if (options.quality) model_ = splat::with_quality(model_, *options.quality);
        if (S::one_channel_memory && options.hops != 0)
            throw Error(std::string("setup ") + S::name + " with bounded hops (its routing and bloom take turns in one set of " +
                        "channels, which a bound would leave full); choose a setup with channels of their own");
        std::unordered_set<splat::GaussianId> ids;
        for (auto const& g : gaussians_)
            if (!ids.insert(g.id).second || g.id == splat::GaussianId::none)
                throw Error("two Gaussians with id " + std::to_string(static_cast<std::uint32_t>(g.id)) +
                            ", or an id of 0 (a record is known by its id); number them from 1");
    }

    /// The rules of the picture; change them before a frame.
    splat::Model& model() noexcept { return model_; }
    splat::Model const& model() const noexcept { return model_; }

    /// The mesh; exists once the first frame has been rendered or `prepare` was called.
    MeshType& mesh() noexcept { return *mesh_; }
    splat::Tiling const& tiling() const noexcept { return tiling_; }

    /// What the last frame did, superstep by superstep; on a Traced machine only. Where copies were recalled the program ran twice,
    /// and both runs are in it, one after the other (the mesh's own trace has the second alone); what the host did between is not.
    Trace const& trace() const noexcept
        requires(tilemesh::detail::is_traced<Machine>)
    {
        return ran_twice_ ? trace_ : mesh_->trace();
    }

    /// Builds the mesh for frames of this size and loads the map, unless it stands already.
    void prepare(std::uint32_t width, std::uint32_t height)
    {
        auto const [grid, tiling] = layout(width, height);
        if (mesh_ && width == frame_.width && height == frame_.height) return;
        if (std::uint64_t{tiling.tile_width} * tiling.tile_height > S::tile_pixels)
            throw Error("tiles of " + std::to_string(tiling.tile_width) + " x " + std::to_string(tiling.tile_height) +
                        " pixels (setup " + S::name + " has a framebuffer of " + std::to_string(S::tile_pixels) +
                        " pixels a tile); choose smaller tiles, a smaller frame or another machine");
        frame_ = {width, height};
        tiling_ = tiling;
        if (mesh_ && grid.width == mesh_->grid().width && grid.height == mesh_->grid().height) {
            size_framebuffers();
            occupy(tiling_.columns, tiling_.rows);
            return;
        }
        try {
            build(grid);
        } catch (...) {
            mesh_.reset();
            throw;
        }
    }

    /// Called after every superstep; see SuperstepEvent.
    void observe(Observer observer)
    {
        observer_ = std::move(observer);
        if (mesh_) mesh_->observe(observer_);
    }

    /// Renders one frame, starting from where the last one left the records.
    RenderedFrame render(splat::Camera const& camera)
    {
        RenderedFrame result;
        render_into(camera, result);
        return result;
    }

    /// The same into a frame that exists already, whose memory is used again: for many frames of one size.
    void render_into(splat::Camera const& camera, RenderedFrame& result)
    {
        auto const begin = Clock::now();
        if (!(camera.near_depth > 0) || !(camera.fx > 0) || !(camera.fy > 0))
            throw Error("a camera whose near plane or focal length is not above 0 (nothing in front of it can be projected); "
                        "correct the camera");
        if (!(model_.alpha_min >= 0) || !(model_.alpha_max >= 0) || !(model_.transmittance_min >= 0) || !(model_.dilation >= 0))
            throw Error("a model whose alpha_min, alpha_max, transmittance_min or dilation is negative or not a number (it would "
                        "blend what is not light); correct the model");
        prepare(camera.width, camera.height);
        auto& frame = mesh_->template broadcast<Parameters>();
        splat::Model model = model_;
        if (options_.footprint) model.footprint = *options_.footprint;
        if (options_.arithmetic) model.arithmetic = *options_.arithmetic;
        auto const view = splat::make_view(camera, model);
        bool const changed = !last_ || __builtin_memcmp(&*last_, &view, sizeof view) != 0 ||
                             __builtin_memcmp(&frame.tiling, &tiling_, sizeof tiling_) != 0;
        auto const start = Clock::now();
        if constexpr (by_reference) {
            if (changed) project_all(view);
        }
        if constexpr (!S::routes) {
            if (changed) place(view);
        } else {
            if (changed && S::Saturation::holds && !gone_.empty()) load();
        }
        splat::FrameParameters const told{view, tiling_, changed ? 1u : 0u, changed && full_ ? 1u : 0u, cut_ ? 1u : 0u};
        if constexpr (by_reference)
            frame = cache_.parameters(told);
        else
            frame = told;
        auto const prepared_ms = since(start);

        ran_twice_ = false;
        auto report = account(mesh_->run(), camera);
        report.host_ms.project += prepared_ms;
        ran_twice_ = recall_orphans();
        if (ran_twice_) {
            // The frame again without them: nothing moves, but it is sorted and composited anew.
            if constexpr (traced) trace_ = mesh_->trace();
            frame.view_changed = frame.anew = 0;
            auto const again = account(mesh_->run(), camera);
            if constexpr (traced) {
                auto const& second = mesh_->trace().supersteps;
                trace_.supersteps.insert(trace_.supersteps.end(), second.begin(), second.end());
            }
            report.copies = again.copies;
            report.pairs = again.pairs;
            report.pairs_contributing = again.pairs_contributing;
            report.lost = again.lost;
            report.lost_copies = again.lost_copies;
            report.host_ms.composite += again.host_ms.composite;
            report.digests.insert(report.digests.end(), again.digests.begin(), again.digests.end());
        }
        auto const tiles_done = Clock::now();
        picture(camera, result);
        result.report = std::move(report);
        last_ = view;
        cut_ = options_.hops != 0;
        result.report.host_ms.picture = since(tiles_done);
        result.report.host_ms.total = since(begin);
    }

private:
    static constexpr bool traced = tilemesh::detail::is_traced<Machine>;
    using Clock = std::chrono::steady_clock;
    static double since(Clock::time_point begin)
    {
        return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
    }
    void build(Grid grid)
    {
        engine_.digest = options_.digest;
        if constexpr (requires { engine_.threads; }) engine_.threads = options_.threads;
        if constexpr (requires { engine_.most_passes; })
            if (options_.most_passes != 0) engine_.most_passes = options_.most_passes;
        if constexpr (traced && requires { engine_.explain; })
            if (engine_.explain == nullptr) engine_.explain = explain_no_progress;
        mesh_ = std::make_unique<MeshType>(grid, engine_, splat::frame_program<S>(options_.hops));
        if (options_.channel_slots != 0) {
            if constexpr (S::routes) mesh_->template limit<splat::Road<S>>(options_.channel_slots);
            if constexpr (S::blooms) mesh_->template limit<splat::Beam<S>>(options_.channel_slots);
        }
        if constexpr (S::routes && S::Saturation::holds)
            if (options_.waiting_slots != 0) {
                mesh_->template limit<splat::Waiting<S, 0>>(options_.waiting_slots);
                mesh_->template limit<splat::Waiting<S, 1>>(options_.waiting_slots);
            }
        if (options_.storage_slots != 0) mesh_->template limit<splat::Storage<S>>(options_.storage_slots);
        if (observer_) mesh_->observe(observer_);
        size_framebuffers();
        occupied_ = {};
        occupy(tiling_.columns, tiling_.rows);
        last_.reset();
        gone_.clear();
        full_ = refused_ = cut_ = ran_twice_ = false;
        if constexpr (S::routes) load_all(grid); // otherwise each view places the records
    }
    void load_all(Grid grid)
    {
        for (std::uint32_t i = 0; i < gaussians_.size(); ++i) gone_.push_back(i);
        load();
        if (!gone_.empty())
            throw Error("a map of " + std::to_string(gaussians_.size()) + " Gaussians (" + std::to_string(grid.size()) +
                        " tiles of " + std::to_string(capacity()) + " slots hold " +
                        std::to_string(std::uint64_t{grid.size()} * capacity()) + "); choose more slots or a larger machine");
    }
    std::pair<Grid, splat::Tiling> layout(std::uint32_t width, std::uint32_t height) const
    {
        if (width == 0 || height == 0 || width > 65535 || height > 65535)
            throw Error("a frame of " + std::to_string(width) + " x " + std::to_string(height) +
                        " pixels (each side is 1 to 65,535); choose another size");
        auto const parts = [](std::uint32_t size, std::uint32_t tile) { return (size + tile - 1) / tile; };
        auto const tiling = tiling_for(options_, width, height);
        Extent2 grid = options_.grid;
        Extent2 const tile = {tiling.tile_width, tiling.tile_height};
        if ((grid.width == 0) != (grid.height == 0) || (options_.tile.width == 0) != (options_.tile.height == 0))
            throw Error("a grid or tile with one side of 0 (0 means that both sides follow from the frame); give both sides");
        if (grid.width == 0 && options_.tile.width == 0) grid = {40, 36};
        if (grid.width == 0) grid = {parts(width, tile.width), parts(height, tile.height)};
        if (std::uint64_t{grid.width} * tile.width < width || std::uint64_t{grid.height} * tile.height < height)
            throw Error("a grid of " + std::to_string(grid.width) + " x " + std::to_string(grid.height) + " tiles of " +
                        std::to_string(tile.width) + " x " + std::to_string(tile.height) + " pixels (the frame is " +
                        std::to_string(width) + " x " + std::to_string(height) + "); choose more or larger tiles");
        if (std::uint64_t{grid.width} * grid.height > Machine::tiles)
            throw Error("a grid of " + std::to_string(grid.width) + " x " + std::to_string(grid.height) + " = " +
                        std::to_string(std::uint64_t{grid.width} * grid.height) + " tiles (" + Machine::name + " has " +
                        std::to_string(Machine::tiles) + "); choose larger tiles, a smaller grid or another machine");
        return {Grid{grid.width, grid.height}, tiling};
    }
    /// Gives every tile the pixels it owns, black.
    void size_framebuffers()
    {
        splat::Camera frame{};
        frame.width = frame_.width;
        frame.height = frame_.height;
        auto const grid = mesh_->grid();
        for (std::uint32_t t = 0; t < grid.size(); ++t) {
            auto const rect = splat::pixels_of(tiling_, frame, grid.tile(t));
            auto framebuffer = mesh_->template state<splat::Framebuffer<S>>(grid.tile(t));
            framebuffer.truncate(0);
            for (std::uint32_t n = rect.empty() ? 0 : (rect.x1 - rect.x0) * (rect.y1 - rect.y0); n > 0; --n)
                framebuffer.unchecked_push(S::Pixel::make(splat::nothing_blended));
        }
    }
    std::uint32_t capacity() const noexcept { return options_.storage_slots != 0 ? options_.storage_slots : S::storage_slots; }

    /// The machine runs the tiles of the picture, and those that hold records besides: the others are idle.
    void occupy(std::uint32_t columns, std::uint32_t rows)
    {
        if (columns <= occupied_.width && rows <= occupied_.height) return;
        occupied_ = {std::max(columns, occupied_.width), std::max(rows, occupied_.height)};
        mesh_->run_within(0, 0, occupied_.width, occupied_.height);
    }
    /// f(tile) for every tile that may hold anything.
    template <class F>
    void for_each_tile(F const& f) const
    {
        for (std::uint32_t y = 0; y < occupied_.height; ++y)
            for (std::uint32_t x = 0; x < occupied_.width; ++x) f(TileId::at(x, y));
    }

    /// Projects all records, on all threads.
    void project_all(splat::View const& view)
    {
        std::span<Record const> const records(gaussians_);
        mesh_->on_threads([&](std::uint32_t thread, std::uint32_t threads) {
            std::uint64_t const n = records.size();
            cache_.project(records, static_cast<std::uint32_t>(n * thread / threads),
                           static_cast<std::uint32_t>(n * (thread + 1) / threads), view, tiling_, !last_,
                           mesh_->template broadcast<Parameters>());
        });
    }
    /// What tiles hold for a row, and for its splat.
    decltype(auto) record_of(std::uint32_t row) const noexcept
    {
        if constexpr (by_reference)
            return typename S::Record{gaussians_[row].id, row};
        else
            return (gaussians_[row]);
    }
    typename S::Projected entry_of([[maybe_unused]] std::uint32_t row, [[maybe_unused]] splat::Splat const& s) const noexcept
    {
        if constexpr (by_reference)
            return {row};
        else
            return s;
    }

    /// Puts the records that are not on the mesh onto it: in order, an even share a tile of the picture; a tile that is full
    /// passes its share on, to the tiles beyond the picture where need be. Those that find no room stay in `gone_`.
    void load()
    {
        auto const grid = mesh_->grid();
        auto const in_picture = tiling_.columns * tiling_.rows;
        auto const share = (gone_.size() + in_picture - 1) / in_picture;
        std::size_t next = 0;
        auto const fill = [&](TileId tile, std::size_t most) {
            auto storage = mesh_->template state<splat::Storage<S>>(tile);
            auto marks = mesh_->template state<splat::Marks<S>>(tile);
            auto splats = mesh_->template state<splat::Splats<S>>(tile);
            for (std::size_t n = 0; n < most && next < gone_.size(); ++n, ++next) {
                auto const row = gone_[next];
                auto const& g = record_of(row);
                if constexpr (by_reference) cache_.put(row);
                ++mesh_->template state<splat::Counts>(tile).changes;
                auto const copy = last_ ? splat::find(marks, g.id) : splat::no_slot;
                if (copy != splat::no_slot) { // left behind when its record found no room
                    storage[copy] = g;
                    marks[copy].bits &= ~splat::Mark::copy;
                    continue;
                }
                if (!storage.try_push(g)) return;
                occupy(tile.x() + 1, tile.y() + 1);
                marks.unchecked_push({g.id, 0});
                splats.unchecked_push(entry_of(row, {}));
            }
        };
        for (std::uint32_t i = 0; i < in_picture && next < gone_.size(); ++i)
            fill(TileId::at(i % tiling_.columns, i / tiling_.columns), share);
        for (std::uint32_t t = 0; t < grid.size() && next < gone_.size(); ++t) fill(grid.tile(t), gone_.size());
        gone_.erase(gone_.begin(), gone_.begin() + static_cast<std::ptrdiff_t>(next));
    }

    /// Without routing: puts the records that have something on screen onto their anchor tiles, in order; what finds its tile
    /// full goes to `gone_`, and what has nothing on screen stays with the host.
    void place(splat::View const& view)
    {
        for_each_tile([&](TileId tile) {
            mesh_->template state<splat::Storage<S>>(tile).truncate(0);
            mesh_->template state<splat::Marks<S>>(tile).truncate(0);
            mesh_->template state<splat::Splats<S>>(tile).truncate(0);
            mesh_->template state<splat::Counts>(tile).changes = 1;
        });
        gone_.clear();
        parked_ = 0;
        for (std::uint32_t row = 0; row < gaussians_.size(); ++row) {
            auto const& g = record_of(row);
            auto const s = by_reference ? cache_[row] : splat::project(gaussians_[row], view, tiling_);
            if (!s.visible()) {
                ++parked_;
                continue;
            }
            if (!mesh_->template state<splat::Storage<S>>(s.anchor).try_push(g)) {
                gone_.push_back(row);
                continue;
            }
            splat::MarkOf<S> mark{};
            mark.id = g.id;
            mesh_->template state<splat::Marks<S>>(s.anchor).unchecked_push(mark);
            mesh_->template state<splat::Splats<S>>(s.anchor).unchecked_push(entry_of(row, s));
        }
    }

    /// The tiles' framebuffers as one picture, on all threads.
    void picture(splat::Camera const& camera, RenderedFrame& to)
    {
        auto const size = [&](auto& plane) {
            if (plane.width == camera.width && plane.height == camera.height) return;
            plane = std::remove_reference_t<decltype(plane)>(camera.width, camera.height);
        };
        size(to.image);
        if constexpr (S::Pixel::has_depth) size(to.depth);
        else to.depth = {};
        if constexpr (S::Pixel::has_alpha) size(to.alpha);
        else to.alpha = {};
        mesh_->on_threads([&](std::uint32_t thread, std::uint32_t threads) {
            auto const tiles = std::uint64_t{tiling_.rows} * tiling_.columns;
            for (auto t = tiles * thread / threads; t < tiles * (thread + 1) / threads; ++t) {
                auto const tile = TileId::at(static_cast<std::uint32_t>(t % tiling_.columns), static_cast<std::uint32_t>(t / tiling_.columns));
                auto const rect = splat::pixels_of(tiling_, camera, tile);
                auto const framebuffer = std::as_const(*mesh_).template state<splat::Framebuffer<S>>(tile);
                auto const* row = framebuffer.begin();
                for (auto y = rect.y0; y < rect.y1; ++y, row += rect.x1 - rect.x0) {
                    if constexpr (std::is_same_v<typename S::Pixel, splat::FloatPixel>)
                        __builtin_memcpy(to.image.pixel(rect.x0, y), row, (rect.x1 - rect.x0) * sizeof(splat::FloatPixel));
                    else
                        for (auto x = rect.x0; x < rect.x1; ++x) show(row[x - rect.x0], x, y, to);
                }
            }
        });
    }
    static void show(splat::FloatPixel const& p, std::uint32_t x, std::uint32_t y, RenderedFrame& to) noexcept
    {
        for (std::uint32_t c = 0; c < 3; ++c) to.image.pixel(x, y)[c] = p.rgb[c];
    }
    static void show(splat::Rgbx8Pixel const& p, std::uint32_t x, std::uint32_t y, RenderedFrame& to) noexcept
    {
        for (std::uint32_t c = 0; c < 3; ++c)
            to.image.pixel(x, y)[c] = static_cast<float>(p.word >> (8 * c) & 255u) / 255.0f;
    }
    template <class Colour>
    static void show(splat::WithDepth<Colour> const& p, std::uint32_t x, std::uint32_t y, RenderedFrame& to) noexcept
    {
        show(p.colour, x, y, to);
        to.depth.at(x, y) = p.depth;
    }
    template <class Colour>
    static void show(splat::WithAlpha<Colour> const& p, std::uint32_t x, std::uint32_t y, RenderedFrame& to) noexcept
    {
        show(p.colour, x, y, to);
        to.alpha.at(x, y) = p.alpha;
    }

    report::FrameReport account(RunCounters const& run, splat::Camera const& camera)
    {
        report::FrameReport r;
        for_each_tile([&](TileId tile) {
            auto const& c = std::as_const(*mesh_).template state<splat::Counts>(tile);
            r.gaussians.visible += c.visible;
            r.gaussians.parked += c.parked;
            r.gaussians.moved += c.moved;
            r.hops += c.hops;
            r.refused.channel_full += c.channel_full;
            r.refused.no_credit += c.no_credit;
            r.refused.storage_full += c.storage_full;
            r.refused.copies_full += c.copies_full;
            r.refused.copies_refused += c.copies_refused;
            r.copies += c.copies;
            auto const& w = std::as_const(*mesh_).template state<splat::Work>(tile);
            for (std::uint32_t i = 0; i < splat::Work::max_workers; ++i) {
                r.pairs += std::uint64_t{w.blocks[i]} * splat::detail::block_width * splat::detail::block_height;
                r.pairs_contributing += w.contributing[i];
            }
        });
        r.width = camera.width;
        r.height = camera.height;
        // A step that the setup does without took nothing.
        auto const supersteps = [&](std::uint32_t step) { return step == Steps::none ? 0u : run.steps[step].supersteps; };
        auto const milliseconds = [&](std::uint32_t step) { return step == Steps::none ? 0.0 : run.steps[step].milliseconds; };
        r.supersteps = {supersteps(Steps::project), supersteps(Steps::route),
                        supersteps(Steps::bloom_first) + supersteps(Steps::bloom), supersteps(Steps::composite)};
        r.messages = run.messages();
        for (auto const& s : run.steps) {
            r.exchanged_live_bytes += s.live_bytes;
            r.exchanged_capacity_bytes += s.capacity_bytes;
        }
        r.gaussians.held = S::Saturation::holds ? r.refused.channel_full + r.refused.no_credit : 0;
        for (auto const& p : run.peaks) {
            if (p.region == splat::Storage<S>::name) r.peak_storage = p.items;
            if (p.region == splat::Road<S>::name || p.region == splat::Beam<S>::name)
                r.peak_channel = std::max(r.peak_channel, p.items);
        }
        r.host_ms = {milliseconds(Steps::project), milliseconds(Steps::route),
                     milliseconds(Steps::bloom_first) + milliseconds(Steps::bloom),
                     milliseconds(Steps::depth_sort) + milliseconds(Steps::composite), 0, 0};
        r.digests = run.digests;

        // Losses last until the records are sent again: a frame that refused nothing may still lack what the last one lost.
        auto const& frame = mesh_->template broadcast<Parameters>();
        full_ = r.refused.copies_full != 0 || (full_ && frame.anew == 0);
        refused_ = r.refused.copies_refused != 0 || (refused_ && frame.view_changed == 0);
        bool spans = false;
        if constexpr (!S::blooms) spans = any_spans();
        if constexpr (!S::routes) {
            r.gaussians.visible += gone_.size();
            r.gaussians.parked += parked_;
        }
        if (r.refused.storage_full != 0 || !gone_.empty() || full_ || refused_ || options_.hops != 0 || spans)
            gone_ = report::LossFinder<S, MeshType>(*mesh_, gaussians_, options_.hops != 0).list(r);
        return r;
    }
    /// Without bloom: does a footprint leave its anchor tile?
    bool any_spans()
    {
        auto const& frame = mesh_->template broadcast<Parameters>();
        bool any = false;
        for_each_tile([&](TileId tile) {
            for (auto const& entry : std::as_const(*mesh_).template state<splat::Splats<S>>(tile)) {
                auto const& s = look(frame, entry);
                any = any || (s.visible() && splat::tiles_of(s, tiling_).count() > 1);
            }
        });
        return any;
    }
    /// Takes the copies of unplaced records off the tiles; true when there were any.
    bool recall_orphans()
    {
        if (!S::Saturation::holds || gone_.empty() || options_.hops != 0) return false;
        std::vector<splat::GaussianId> ids;
        for (auto row : gone_) ids.push_back(gaussians_[row].id);
        std::sort(ids.begin(), ids.end());
        bool any = false;
        auto const is_orphan = [&](auto const& mark) {
            return mark.is(splat::Mark::copy) && std::binary_search(ids.begin(), ids.end(), mark.id);
        };
        for_each_tile([&](TileId tile) {
            auto const seen = std::as_const(*mesh_).template state<splat::Marks<S>>(tile);
            if (std::none_of(seen.begin(), seen.end(), is_orphan)) return;
            auto storage = mesh_->template state<splat::Storage<S>>(tile);
            auto marks = mesh_->template state<splat::Marks<S>>(tile);
            auto splats = mesh_->template state<splat::Splats<S>>(tile);
            for (std::uint32_t i = storage.size(); i-- > 0;)
                if (is_orphan(marks[i])) {
                    splat::remove_slot(storage, marks, splats, i);
                    ++mesh_->template state<splat::Counts>(tile).changes;
                    any = true;
                }
        });
        return any;
    }

    RendererOptions options_;
    EngineOptions engine_;
    std::vector<Record> gaussians_;
    ScreenCache<Record> cache_;                      ///< by reference: what tiles read
    splat::Model model_ = [] {
        splat::Model m;
        m.footprint = S::footprint;
        m.alpha_max = S::alpha_max;
        m.transmittance_min = S::transmittance_min;
        m.arithmetic = S::arithmetic;
        return m;
    }();
    Extent2 frame_{};
    splat::Tiling tiling_{};
    std::unique_ptr<MeshType> mesh_;
    Extent2 occupied_{};                             ///< tiles from (0, 0) that hold pixels, or may hold records
    Observer observer_;
    std::uint64_t parked_ = 0;                       ///< rows with nothing on screen that stay here: without routing
    std::vector<std::uint32_t> gone_;                ///< rows that are nowhere on the mesh, in order
    std::optional<splat::View> last_;
    bool full_ = false;                              ///< copies are missing that found no storage: nobody sends them again by itself
    bool refused_ = false;                           ///< copies are missing that met a full channel: owed again in a new view
    bool cut_ = false;                               ///< a bound may have left records under way
    bool ran_twice_ = false;                         ///< the last frame: copies were recalled
    [[no_unique_address]] std::conditional_t<traced, Trace, engine::detail::NoTrace> trace_; ///< of both runs, where it did
};

/// The default: `lossless` on Mk2, on host threads, by reference.
using Renderer = BasicRenderer<splat::Referenced<splat::Lossless>>;

} // namespace tilemesh
