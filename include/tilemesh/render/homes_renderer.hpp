#pragma once
#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/engine/port.hpp>
#include <tilemesh/engine/stopwatch.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/either.hpp>
#include <tilemesh/render/core.hpp>
#include <tilemesh/render/homes_results.hpp>
#include <tilemesh/render/homes_layout.hpp>
#include <tilemesh/render/homes_form.hpp>
#include <tilemesh/render/homes_records.hpp>
#include <tilemesh/render/host.hpp>
#include <tilemesh/render/picture.hpp>
#include <tilemesh/render/project_records.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/splat/homes/program.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// Throws Error if a setup's records or pixels are not those of the policies. `Wider`: tiles may store more than the ledger counts.
template <class P, bool Wider>
void check_homes(Setup const& s)
{
    using Pixel = typename P::Pixel;
    bool const rgbx8 = splat::colour_format<Pixel> == ColourFormat::rgbx8;
    bool fits = Pixel::has_depth >= s.depth && Pixel::has_alpha >= s.alpha && (s.colour == ColourFormat::rgbx8) >= rgbx8;
    if constexpr (Wider)
        fits = fits && s.sh_degree <= P::Record::sh_degree;
    else if constexpr (!std::is_same_v<typename P::Record, splat::Reference>)
        fits = s.sh_degree == P::Record::sh_degree && s.depth == Pixel::has_depth && s.alpha == Pixel::has_alpha &&
               (s.colour == ColourFormat::rgbx8) == rgbx8;
    if (!fits)
        throw Error("a setup with records or pixels that the renderer's policies do not store (degree, colour format, depth or alpha "
                    "differ); give both the same");
}

/// Renders a map of any density on a grid of tiles: the program of homes and windows (splat/homes/program.hpp). The picture is complete and
/// bit-identical to that of one depth-ordered list for the whole frame, for any capacities. More splats than a tile holds cost rounds, not
/// records.
///
/// `P`: policies of splat/homes (by reference or by value). `Engine`: Mesh, CheckedMesh or PoplarMesh; by value also MpiMesh. Records never
/// move, so a new view sends every visible splat again; an unchanged view runs nothing.
///
/// CONTRIBUTING.md names the files on the way of a Gaussian. On an engine over several processes (render/ranks/host.hpp), records and
/// pixels may have more than the choice asks for, which changes no result: the ledger is that of the choice.
template <class P, template <class, class> class Engine = Mesh, class Machine = AnyMachine>
class HomesRenderer : public Core {
public:
    using Program = splat::homes::Frame<P>;
    using MeshType = Engine<Program, Machine>;
    using EngineOptions = typename MeshType::Options;
    using HostType = Host<MeshType, Machine>;
    static constexpr bool by_reference = std::is_same_v<typename P::Record, splat::Reference>;

    static_assert(HostType::has_one_memory || !by_reference, "references to a table of the host on an engine over several processes (a tile "
                                                             "of another process cannot read that table); choose policies by value");

    /// Throws Error if the choice's records or pixels are not those of the policies.
    HomesRenderer(scene::Map map, Setup const& setup, RendererOptions options = {}, EngineOptions engine = {});
    ~HomesRenderer() override;

    void render_into(splat::Camera const& camera, RenderedFrame& result) override;

    splat::Rules& rules() override { return choice_.rules; }
    scene::Map const& map() const override { return records_.table().map(); }
    Extent2 grid() override { return {grid_.width, grid_.height}; }
    Extent2 tile() override { return {fold_.x.layers * splat::block_width, fold_.y.layers * splat::block_height}; }
    Setup const& setup() const override { return setup_; }
    MeshType& mesh() noexcept { return host_.mesh(); }
    /// The trace of the last frame, chapter after chapter; only on a Traced machine whose mesh keeps one. A frame whose view did not change has
    /// no superstep. On several processes, it is the trace of this process's tiles.
    Trace const& trace() const override
    {
        if constexpr (is_traced<Machine>)
            return host_.trace();
        else
            return Core::trace();
    }
    splat::homes::Fold const& fold() const noexcept { return fold_; }
    void observe(Observer observer) override { host_.observe(std::move(observer)); }
    void require_idle() const override { host_.require_idle(); }

private:
    using Parameters = typename P::Parameters;

    /// The form of pixels and blocks that have two.
    bool wide() const noexcept { return choice_.depth || choice_.alpha; }
    void build_for(std::uint32_t width, std::uint32_t height)
    {
        if (host_.has_mesh() && width == size_.width && height == size_.height) return;
        host_.drop_mesh();
        last_.reset();
        auto const rows = options_.rows_of_all_parts != 0 ? options_.rows_of_all_parts : records_.table().all_rows();
        host_.build(options_, records_.table(), [&] {
            auto mesh_sizes = lay_out(width, height, rows);
            return MeshPlan<Program>{splat::homes::frame_program<P>(grid_), grid_, std::move(mesh_sizes)};
        });
        auto& mesh = host_.mesh();
        auto const& sizes = setup_.sizes;
        limit_lists(sizes);
        host_.each_tile([&](TileId tile) {
            auto table = mesh.template state<splat::homes::Table>(tile);
            for (auto n = sizes.tiles; n > 0; --n) table.push({splat::homes::infinite_depth, 0, 0});
            auto framebuffer = mesh.template state<splat::homes::Framebuffer<typename P::Pixel>>(tile);
            if (!has_blocks(tile)) return;
            framebuffer.resize(sizes.tile_pixels);
            machine::in_form(wide(), framebuffer.begin(), [&]<class Pixel>(Pixel* pixels) {
                std::fill(pixels, pixels + sizes.tile_pixels, Pixel::make(splat::nothing_blended));
            });
        });
        records_.begin(host_, grid_, streams_);
    }
    bool has_blocks(TileId tile) const noexcept { return tile.x() < fold_.x.tiles && tile.y() < fold_.y.tiles; }
    /// Lays out a frame of this size, and sets what follows from it.
    MeshSizes<Program> lay_out(std::uint32_t width, std::uint32_t height, std::uint32_t rows)
    {
        auto layout = layout_homes(choice_, options_, {width, height}, rows);
        fold_ = layout.fold;
        size_ = {width, height};
        setup_ = layout.setup;
        auto const& sizes = setup_.sizes;
        check_workers(choice_.machine, splat::homes::Work::max_workers);
        if (sizes.homes == 0) throw Error("tiles without homes (every record lives in one); give a tile at least one");
        engine::require_least_slots(sizes, typename machine::Needs<Program>::States{});
        engine::require_least_slots(sizes, typename machine::Needs<Program>::Links{});
        std::uint64_t const homes = std::uint64_t{sizes.homes} * grid_.size();
        streams_ = rows > homes;
        residents_ = static_cast<std::uint32_t>(std::min<std::uint64_t>(homes, rows));
        if constexpr (by_reference) table_.resize(residents_), keys_.resize(residents_);

        auto mesh_sizes = engine::plain_sizes<Program>(choice_.machine, setup_, typename machine::Needs<Program>::States{},
                                                       typename machine::Needs<Program>::Links{});
        mesh_sizes.sram_bytes = sram_bytes_of(setup_);
        if constexpr (machine::has_form_word<Parameters>) mesh_sizes.wide = wide();
        return mesh_sizes;
    }
    void limit_lists(splat::Sizes const& sizes)
    {
        auto& mesh = host_.mesh();
        // A map of many records may leave fewer slots than the choice has.
        if (options_.channel_slots != 0) mesh.template limit<splat::homes::Parcels<P>>(std::min(options_.channel_slots, sizes.road));
        if (options_.waiting_slots != 0) {
            mesh.template limit<splat::homes::Waiting<P, 0>>(std::min(options_.waiting_slots, sizes.waiting));
            mesh.template limit<splat::homes::Waiting<P, 1>>(std::min(options_.waiting_slots, sizes.waiting));
        }
        if (auto const held = options_.held_slots != 0 ? options_.held_slots : options_.storage_slots; held != 0) {
            mesh.template limit<splat::homes::Held<P>>(std::min(held, sizes.storage));
            mesh.template limit<splat::homes::Keys>(std::min(held, sizes.storage));
            mesh.template limit<splat::homes::Order>(std::min(held, sizes.storage));
        }
    }
    /// Runs the program on the records that are on their homes.
    void run(splat::View const& view, std::uint32_t chapter_depth, report::FrameReport& report)
    {
        engine::Stopwatch const preparing;
        tell(view, chapter_depth);
        if (options_.rounds != 0)
            splat::homes::bound_rounds(host_.mesh().program(), static_cast<std::uint32_t>(options_.rounds - report.homes.rounds));
        report.host_ms.project += preparing.milliseconds();
        auto const counters = host_.run();
        auto const& mesh = std::as_const(host_.mesh());
        auto const sums = host_.template total<HomesSums>([&](HomesSums& all) {
            for (TileId const tile : grid_.tiles())
                if (host_.has(tile)) all.add(mesh.template state<splat::homes::Counts>(tile), mesh.template state<splat::homes::Work>(tile));
        });
        auto const unfinished = unfinished_tiles([](TileId, splat::homes::Window const& window) {
            return window.done() ? std::nullopt : std::optional(window.lo_depth);
        });
        host_.step([&] {
            account<P>(counters, sums, report);
            report.unfinished.insert(report.unfinished.end(), unfinished.begin(), unfinished.end());
        });
        report.homes.unfinished_tiles = report.unfinished.size();
    }
    /// Runs the program on one chapter after another. It ends early if every pixel has stopped, or at the bound on rounds, which all chapters
    /// of a frame share.
    void run_chapters(splat::View const& view, report::FrameReport& report)
    {
        engine::Stopwatch const preparing;
        auto chapters = records_.chapters_of(host_, view);
        report.host_ms.project += preparing.milliseconds();
        std::uint64_t done = 0;
        std::uint32_t behind = 0; // key of the nearest depth of the next chapter
        do {
            engine::Stopwatch const loading;
            auto const size = std::min<std::uint64_t>(residents_, chapters.all - done);
            auto const keys = records_.load_chapter(host_, chapters, done, size);
            report.homes.streamed_bytes += size * record_bytes(setup_);
            ++report.homes.chapters;
            report.host_ms.project += loading.milliseconds();
            report.unfinished.clear();
            run(view, done == 0 ? 0 : static_cast<std::uint32_t>(keys.from >> 32), report);
            done += size;
            if (done == chapters.all || !goes_on()) return;
            behind = static_cast<std::uint32_t>(keys.to >> 32);
        } while (report.homes.unfinished_tiles == 0 && (options_.rounds == 0 || report.homes.rounds < options_.rounds));
        // At the bound, a tile that is done with its chapter lacks the later ones.
        report.unfinished = unfinished_tiles([&](TileId tile, splat::homes::Window const& window) {
            bool const goes = has_blocks(tile) && window.finished != 0xffffffffu;
            return goes ? std::optional(window.done() ? behind : window.lo_depth) : std::nullopt;
        });
        report.homes.unfinished_tiles = report.unfinished.size();
    }
    /// The tiles for which `lacks(tile, window)` gives the key of a depth: from there on they lack splats.
    template <class Lacks>
    std::vector<report::UnfinishedTile> unfinished_tiles(Lacks const& lacks)
    {
        using report::UnfinishedTile;
        return host_.template list<UnfinishedTile>([&](std::vector<UnfinishedTile>& tiles) {
            for (TileId const tile : grid_.tiles()) {
                if (!host_.has(tile)) continue;
                if (auto const depth = lacks(tile, window_of(tile))) tiles.push_back({grid_.index_of(tile), splat::depth_of_key(*depth)});
            }
        });
    }
    splat::homes::Window const& window_of(TileId tile) const noexcept { return host_.mesh().template state<splat::homes::Window>(tile); }
    /// Has a tile a block that has not stopped?
    bool goes_on()
    {
        bool some = false;
        for (TileId const tile : grid_.tiles())
            some = some || (has_blocks(tile) && host_.has(tile) && window_of(tile).finished != 0xffffffffu);
        return host_.any(some);
    }
    /// Writes the parameters of a frame. By reference, projects the host's table on all threads.
    void tell(splat::View const& view, std::uint32_t chapter_depth)
    {
        auto& frame = host_.mesh().template broadcast<Parameters>();
        auto const tiling = splat::make_tiling(size_.width, size_.height, splat::block_width, splat::block_height);
        static_cast<splat::homes::Parameters&>(frame) = {view, tiling, fold_, chapter_depth};
        if constexpr (machine::has_form_word<Parameters>) frame.wide = wide() ? 1 : 0;
        if constexpr (by_reference) {
            frame.district_shift = splat::homes::district_shift(setup_.district);
            frame.splats = splat::HostPointer<splat::Splat const>(table_.data());
            frame.keys = splat::HostPointer<splat::homes::Key>(keys_.data());
            frame.windows = splat::HostPointer<splat::homes::WindowNotice const>(
                std::as_const(host_.mesh()).template state<splat::homes::Table>(grid_.tile(0)).begin());
            auto const& rows = records_.on_homes();
            host_.on_threads(rows.size(), [&](std::uint32_t first, std::uint32_t last) {
                if (streams_) project_listed(records_.table(), rows.data() + first, last - first, view, tiling, table_.data() + first);
                else
                    project_rows(records_.table(), first, last - first, view, tiling, table_.data() + first);
            });
        }
    }
    report::FrameReport unchanged() const
    {
        report::FrameReport r;
        r.program = report::Program::homes;
        r.gaussians.visible = visible_;
        r.gaussians.parked = records_.table().all_rows() - visible_;
        r.unfinished = unfinished_;
        r.homes.unfinished_tiles = unfinished_.size();
        return r;
    }
    RendererOptions options_;
    Setup choice_;
    Grid grid_;
    HostType host_;
    HomesRecords<P, HostType> records_;
    std::vector<splat::Splat> table_;    ///< by reference: the splats of the records on homes, in this view
    std::vector<splat::homes::Key> keys_; ///< by reference: their keys
    std::uint32_t residents_ = 0;        ///< records that have homes at the same time
    bool streams_ = false;               ///< the map comes in chapters
    Setup setup_{};            ///< with the sizes of the last frame
    splat::homes::Fold fold_{};
    Extent2 size_{};
    std::optional<splat::View> last_;
    std::uint64_t visible_ = 0;
    std::vector<report::UnfinishedTile> unfinished_;
};

// As in FrameRenderer, the members that users call are defined outside the class.

template <class P, template <class, class> class Engine, class Machine>
HomesRenderer<P, Engine, Machine>::HomesRenderer(scene::Map map, Setup const& setup, RendererOptions options, EngineOptions engine)
    : options_(options), choice_(setup), grid_(homes_grid(options)), host_(std::move(engine)), records_(std::move(map), setup.sh_degree)
{
    host_.identify(records_.table(), options, {records_.table().map().sh_degree, options.rounds, options.rows_of_all_parts, options.channel_slots,
                                               options.waiting_slots, options.held_slots, options.storage_slots, options.fold ? 1u : 0u});
    check_homes<P, !HostType::has_one_memory>(setup);
    check_limits(setup, options);
    if constexpr (!by_reference) take_districts(choice_, 1u << Parameters::district_shift);
    choice_.rules = with_options(choice_.rules, options);
    setup_ = choice_; // until the first frame
}
template <class P, template <class, class> class Engine, class Machine>
HomesRenderer<P, Engine, Machine>::~HomesRenderer() = default;

template <class P, template <class, class> class Engine, class Machine>
void HomesRenderer<P, Engine, Machine>::render_into(splat::Camera const& camera, RenderedFrame& result)
{
    engine::Stopwatch const all;
    auto const view = host_.view_of(camera, choice_.rules, [&](splat::View const& v) {
        check_lens(v.camera, Parameters::bends, false);
        views_.require(v);
    });
    host_.begin_frame();
    build_for(camera.width, camera.height);
    bool const changed = !last_ || __builtin_memcmp(&*last_, &view, sizeof view) != 0;
    report::FrameReport report;
    report.program = report::Program::homes;
    if (changed) {
        if (streams_) run_chapters(view, report);
        else run(view, 0, report);
        visible_ = report.gaussians.visible;
        host_.step([&] { unfinished_ = report.unfinished; });
        report.gaussians.parked = records_.table().all_rows() - visible_;
    } else {
        host_.step([&] { report = unchanged(); });
    }
    engine::Stopwatch const collecting;
    host_.template picture_of<splat::homes::Framebuffer<typename P::Pixel>>(result, [&] { copy_blocks<P>(host_, fold_, setup_, camera, result); });
    result.report = std::move(report);
    result.report.width = camera.width;
    result.report.height = camera.height;
    result.report.gaussians.parked += views_.culled();
    last_ = view;
    host_.end_frame();
    result.report.host_ms.picture = collecting.milliseconds();
    result.report.host_ms.total = all.milliseconds();
}

/// The pixels of a renderer by value that serves setups with planes.
using HomesPlanes = splat::WithAlpha<splat::WithDepth<splat::FloatPixel>>;
/// The homes that a Renderer runs: by reference, for any setup and any engine of one process.
using HostHomesRenderer = HomesRenderer<splat::homes::AnyHostPolicies, PortMesh, Traced<AnyMachine>>;

#if defined(TILEMESH_COMPILED)
extern template class HomesRenderer<splat::homes::AnyHostPolicies, PortMesh, Traced<AnyMachine>>;
#endif

}}} // namespace tilemesh::render

#if defined(TILEMESH_COMPILED)
namespace tilemesh { inline namespace v0_2 {
extern template std::unique_ptr<engine::Port<render::HostHomesRenderer::Program>>
make_threads_port(render::HostHomesRenderer::Program const&, Grid, MeshSizes<render::HostHomesRenderer::Program> const&, MeshOptions const&);
extern template std::unique_ptr<engine::Port<render::HostHomesRenderer::Program>>
make_checked_port(render::HostHomesRenderer::Program const&, Grid, MeshSizes<render::HostHomesRenderer::Program> const&, MeshOptions const&);
}} // namespace tilemesh
#endif
