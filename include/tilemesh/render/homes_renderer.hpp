#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tilemesh/any_renderer.hpp>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/model/no_progress.hpp>
#include <tilemesh/render/record_table.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/setup_facts.hpp>
#include <tilemesh/render/homes_form.hpp>
#include <tilemesh/splat/homes/program.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// A machine and its rules for the program of homes.
struct HomesChoice {
    char const* name = "homes";
    MachineSize machine = size_of_machine<Mk2>();
    /// Slots of a tile. `columns`, `tiles`, `tile_blocks` and `tile_pixels` follow from the grid and the frame. With 120 slots a channel end
    /// and 2,800 splats a window, four modelled views take the least time or nearly so (bench/any_map).
    splat::homes::Sizes sizes{950, 2800, 120, 120};
    std::uint32_t sh_degree = 0;
    ColourFormat colour = ColourFormat::float32;
    bool depth = false, alpha = false;
    splat::Model model{};
};

/// The ledger of a tile: the lines of `SramLedger<splat::homes::Frame<P>>` for the policies by value, and their sum.
struct HomesLedger {
    std::vector<machine::Region> lines;
    std::uint64_t bytes = 0;

    HomesLedger(HomesChoice const& c, splat::homes::Sizes const& sizes)
    {
        using namespace splat;
        using P = homes::ValuePolicies<>;
        auto const list = [](std::uint64_t slots, std::uint64_t slot_bytes) { return 8 + slots * slot_bytes; };
        std::uint64_t const record = sizeof(Gaussian) + 12 * std::uint64_t{harmonics_per_channel(c.sh_degree)};
        std::uint64_t const pixel = (c.colour == ColourFormat::rgbx8 ? 4u : 12u) + (c.depth ? 4u : 0u) + (c.alpha ? 4u : 0u);
        std::uint64_t const parcel = sizeof(homes::Parcel<Splat>);
        add(homes::Tidings::name, "channel, 8 ends", 8 * list(sizes.columns, sizeof(homes::Told)));
        add(homes::Parcels<P>::name, "channel, 8 ends", 8 * list(sizes.parcels, parcel));
        add(homes::Home<P>::name, "state", list(sizes.homes, record));
        add(homes::Seen<P>::name, "state", list(sizes.homes, sizeof(Splat)));
        add(homes::Window::name, "state", sizeof(homes::Window));
        add(homes::Held<P>::name, "state", list(sizes.held, sizeof(Splat)));
        add(homes::Keys::name, "state", list(sizes.held, sizeof(SortKey)));
        add(homes::Order::name, "state", list(sizes.held, 4));
        add(homes::Cuts::name, "state", list(homes::most_cuts, 4));
        add(homes::NextCuts::name, "state", list(homes::most_cuts, 4));
        add(homes::Sample::name, "state", list(homes::most_samples, 4));
        add(homes::Blocks<false>::name, "state", list(sizes.tile_blocks, c.depth ? sizeof(homes::KeptDepthBlock) : sizeof(homes::KeptBlock)));
        add(homes::Counts::name, "state", sizeof(homes::Counts));
        add(homes::Work::name, "state", sizeof(homes::Work));
        add(homes::Table::name, "state", list(sizes.tiles, sizeof(homes::Told)));
        add(homes::Sending::name, "state", sizeof(homes::Sending));
        add(homes::Offers::name, "state", list(sizes.homes, sizeof(homes::Offered)));
        add(homes::Waiting<P, 0>::name, "state", list(sizes.waiting, parcel));
        add(homes::Waiting<P, 1>::name, "state", list(sizes.waiting, parcel));
        add(homes::Framebuffer<FloatPixel>::name, "state", list(sizes.tile_pixels, pixel));
        add(homes::Parameters::name, "broadcast", sizeof(homes::Parameters));
        add("code and stacks", "reserve", c.machine.code_bytes);
    }

private:
    void add(char const* name, char const* what, std::uint64_t region_bytes)
    {
        lines.push_back({as_name(name), what, static_cast<std::uint32_t>(std::min<std::uint64_t>(region_bytes, 0xffffffffu)), true});
        bytes += region_bytes;
    }
};

/// Renders a map of any density on a grid of tiles: the program of homes and windows (splat/homes/program.hpp). The picture is complete and
/// bit-identical to that of one depth-ordered list for the whole frame, for any capacities. More splats than a tile holds cost rounds, not
/// records.
///
/// `P`: policies of splat/homes (by reference or by value). `Engine`: Mesh, CheckedMesh or PoplarMesh. Records never move, so a new view
/// sends every visible splat again; an unchanged view runs nothing.
template <class P, template <class, class> class Engine = Mesh, class Machine = AnyMachine>
class HomesRenderer : public AnyRenderer {
public:
    using Program = splat::homes::Frame<P>;
    using MeshType = Engine<Program, Machine>;
    using EngineOptions = typename MeshType::Options;
    static constexpr bool by_reference = std::is_same_v<typename P::Record, splat::Reference>;
    static constexpr bool traced = is_traced<Machine>;

    /// A map with more records than homes comes in chapters; its records are sent anew for each view. Throws Error if the choice's records or
    /// pixels are not those of the policies.
    HomesRenderer(scene::Map const& map, HomesChoice const& choice, RendererOptions options = {}, EngineOptions engine = {})
        : options_(options), engine_(std::move(engine)), choice_(choice), grid_(grid_of(options)),
          records_(dealt(map, grid_.size()), choice.sh_degree)
    {
        require_policies(choice);
        choice_.model.footprint = options.footprint.value_or(choice_.model.footprint);
        choice_.model.arithmetic = options.arithmetic.value_or(choice_.model.arithmetic);
        if (options.quality) choice_.model = splat::with_quality(choice_.model, *options.quality);
    }

    RenderedFrame render(splat::Camera const& camera) override
    {
        RenderedFrame frame;
        render_into(camera, frame);
        return frame;
    }
    /// Renders into an existing frame and reuses its memory. After an exception the frame holds no picture, and the next one begins anew.
    void render_into(splat::Camera const& camera, RenderedFrame& result)
    {
        auto const begin = Clock::now();
        check_camera(camera);
        check_model(choice_.model);
        if (halfway_) mesh_.reset();
        halfway_ = true;
        prepare(camera.width, camera.height);
        auto const view = splat::make_view(camera, choice_.model);
        bool const changed = !last_ || __builtin_memcmp(&*last_, &view, sizeof view) != 0;
        report::FrameReport report;
        if (changed) {
            if (streams_)
                run_chapters(view, report);
            else
                run(view, 0, report);
            visible_ = report.gaussians.visible;
            unfinished_ = report.homes.unfinished_tiles;
            report.gaussians.parked = records_.rows() - visible_;
        } else {
            report = unchanged();
        }
        auto const done = Clock::now();
        collect(camera, result);
        result.report = std::move(report);
        result.report.width = camera.width;
        result.report.height = camera.height;
        last_ = view;
        halfway_ = false;
        result.report.host_ms.picture = since(done);
        result.report.host_ms.total = since(begin);
    }

    splat::Model& model() override { return choice_.model; }
    void hold_to(scene::Demand const&) override {}
    Extent2 grid() override { return {grid_.width, grid_.height}; }
    Extent2 tile() override { return {fold_.x.layers * splat::block_width, fold_.y.layers * splat::block_height}; }
    SetupFacts const& facts() const override { return facts_; }
    bool routes() const override { return true; }
    bool blooms() const override { return true; }
    MeshType& mesh() noexcept { return *mesh_; }
    splat::homes::Fold const& fold() const noexcept { return fold_; }
    /// The trace of the last frame, superstep by superstep; only on a Traced machine. If the map came in chapters, it holds the runs of all
    /// chapters in order, and the mesh's own trace holds that of the last one.
    Trace const& trace() const noexcept
        requires(is_traced<Machine>)
    {
        return streams_ ? trace_ : mesh_->trace();
    }
    void observe(Observer observer)
    {
        observer_ = std::move(observer);
        if (mesh_) mesh_->observe(observer_);
    }

private:
    using Clock = std::chrono::steady_clock;
    static double since(Clock::time_point begin) { return std::chrono::duration<double, std::milli>(Clock::now() - begin).count(); }
    using Parameters = typename P::Parameters;

    static void require_policies(HomesChoice const& c)
    {
        using Pixel = typename P::Pixel;
        bool const rgbx8 = std::is_same_v<splat::ColourOf<Pixel>, splat::Rgbx8Pixel>;
        bool fits = Pixel::has_depth >= c.depth && Pixel::has_alpha >= c.alpha && (c.colour == ColourFormat::rgbx8) >= rgbx8;
        if constexpr (!by_reference) // what the tiles store is what the ledger counts
            fits = c.sh_degree == P::Record::sh_degree && c.depth == Pixel::has_depth && c.alpha == Pixel::has_alpha &&
                   (c.colour == ColourFormat::rgbx8) == rgbx8;
        if (!fits)
            throw Error("a choice of records or pixels that the renderer's policies do not store (degree, colour format, depth or alpha "
                        "differ); give both the same");
    }
    static Grid grid_of(RendererOptions const& options)
    {
        return options.grid.width != 0 && options.grid.height != 0 ? Grid{options.grid.width, options.grid.height} : Grid{40, 36};
    }
    /// The map with its rows dealt to n tiles, one by one, in the order of the tiles. Neighbours in a map are often neighbours in the scene;
    /// dealt, they load no tile more than others.
    static scene::Map dealt(scene::Map const& map, std::uint32_t n)
    {
        scene::Map out;
        out.name = map.name;
        out.sh_degree = map.sh_degree;
        out.gaussians.reserve(map.gaussians.size());
        out.harmonics.reserve(map.harmonics.size());
        std::size_t const floats = map.gaussians.empty() ? 0 : map.harmonics.size() / map.gaussians.size();
        for (std::size_t t = 0; t < n; ++t)
            for (auto row = t; row < map.gaussians.size(); row += n) {
                out.gaussians.push_back(map.gaussians[row]);
                auto const* const harmonics = map.harmonics.data() + row * floats;
                out.harmonics.insert(out.harmonics.end(), harmonics, harmonics + floats);
            }
        return out;
    }
    void prepare(std::uint32_t width, std::uint32_t height)
    {
        if (mesh_ && width == size_.width && height == size_.height) return;
        if (width == 0 || height == 0 || width > 65535 || height > 65535)
            throw Error("a frame of " + std::to_string(width) + " x " + std::to_string(height) +
                        " pixels (each side is 1 to 65,535); choose another size");
        mesh_.reset();
        last_.reset();
        if (std::uint64_t{grid_.width} * grid_.height > choice_.machine.tiles)
            throw Error("a grid of " + std::to_string(grid_.width) + " x " + std::to_string(grid_.height) + " tiles (" + choice_.machine.name +
                        " has " + std::to_string(choice_.machine.tiles) + "); choose a smaller grid or another machine");
        fold_ = splat::homes::make_fold(width, height, grid_, options_.fold);
        size_ = {width, height};
        auto sizes = choice_.sizes;
        sizes.columns = fold_.x.tiles;
        sizes.tiles = fold_.x.tiles * fold_.y.tiles;
        sizes.tile_blocks = fold_.tile_blocks();
        sizes.tile_pixels = sizes.tile_blocks * splat::block_width * splat::block_height;
        if (!engine::has_words_for_workers(choice_.machine, StepsOf<Program>{}))
            throw Error("machine " + std::string(choice_.machine.name) + " with " + std::to_string(choice_.machine.workers) +
                        " workers (the program of homes has words for 1 to " + std::to_string(splat::homes::Work::max_workers) +
                        "); choose another machine");
        engine::require_least_slots(sizes, typename machine::Needs<Program>::States{});
        engine::require_least_slots(sizes, typename machine::Needs<Program>::Links{});
        HomesLedger ledger(choice_, sizes);
        if (ledger.bytes > choice_.machine.sram_bytes) throw does_not_fit(choice_.machine, ledger.lines, ledger.bytes);
        std::uint64_t const homes = std::uint64_t{sizes.homes} * grid_.size();
        if (homes == 0) throw Error("tiles without homes (every record lives in one); give a tile at least one");
        streams_ = records_.rows() > homes;
        residents_ = static_cast<std::uint32_t>(std::min<std::uint64_t>(homes, records_.rows()));
        if constexpr (by_reference) table_.resize(residents_);
        facts_ = {choice_.name, choice_.machine, {}, {}, choice_.sh_degree, 60 + 12 * splat::harmonics_per_channel(choice_.sh_degree),
                  choice_.colour, choice_.depth, choice_.alpha, choice_.model, ledger.bytes, std::move(ledger.lines)};
        facts_.sizes.storage = sizes.held;
        facts_.sizes.road = facts_.sizes.beam = sizes.parcels;
        facts_.sizes.waiting = sizes.waiting;
        facts_.sizes.tile_pixels = sizes.tile_pixels;

        engine_.digest = options_.digest;
        if constexpr (requires { engine_.threads; }) engine_.threads = options_.threads;
        if constexpr (requires { engine_.most_passes; })
            if (options_.most_passes != 0) engine_.most_passes = options_.most_passes;
        auto mesh_sizes = engine::plain_sizes<Program>(choice_.machine, sizes, typename machine::Needs<Program>::States{},
                                                       typename machine::Needs<Program>::Links{});
        mesh_sizes.sram_bytes = facts_.sram_bytes;
        mesh_ = std::make_unique<MeshType>(splat::homes::frame_program<P>(grid_, options_.rounds != 0 ? options_.rounds : 0xffffffffu), grid_,
                                           mesh_sizes, engine_);
        if (options_.channel_slots != 0) mesh_->template limit<splat::homes::Parcels<P>>(options_.channel_slots);
        if (options_.waiting_slots != 0) {
            mesh_->template limit<splat::homes::Waiting<P, 0>>(options_.waiting_slots);
            mesh_->template limit<splat::homes::Waiting<P, 1>>(options_.waiting_slots);
        }
        if (options_.storage_slots != 0) {
            mesh_->template limit<splat::homes::Held<P>>(options_.storage_slots);
            mesh_->template limit<splat::homes::Keys>(options_.storage_slots);
            mesh_->template limit<splat::homes::Order>(options_.storage_slots);
        }
        if (observer_) mesh_->observe(observer_);
        for (TileId const tile : grid_.tiles()) {
            auto table = mesh_->template state<splat::homes::Table>(tile);
            for (auto n = sizes.tiles; n > 0; --n) table.push({splat::homes::infinite_depth, 0, 0});
            auto framebuffer = mesh_->template state<splat::homes::Framebuffer<typename P::Pixel>>(tile);
            if (tile.x() < fold_.x.tiles && tile.y() < fold_.y.tiles)
                for (auto n = sizes.tile_pixels; n > 0; --n) framebuffer.push(P::Pixel::make(splat::nothing_blended));
        }
        if (!streams_) {
            chapter_.resize(records_.rows());
            for (std::uint32_t row = 0; row < records_.rows(); ++row) chapter_[row] = row;
            load_chapter();
        }
    }
    /// Puts the rows of `chapter_` onto their homes, in even shares.
    void load_chapter()
    {
        std::uint32_t at = 0;
        auto const rows = static_cast<std::uint32_t>(chapter_.size()), tiles = grid_.size();
        for (TileId const tile : grid_.tiles()) {
            auto home = mesh_->template state<splat::homes::Home<P>>(tile);
            auto seen = mesh_->template state<splat::homes::Seen<P>>(tile);
            auto offers = mesh_->template state<splat::homes::Offers>(tile);
            home.truncate(0), seen.truncate(0), offers.truncate(0);
            for (auto n = rows / tiles + (grid_.index_of(tile) < rows % tiles ? 1 : 0); n > 0; --n, ++at) {
                if constexpr (by_reference)
                    home.push({records_.id(chapter_[at]), at});
                else
                    home.push(records_.template record<typename P::Record>(chapter_[at]));
                seen.push({});
                offers.push({});
            }
        }
    }
    /// Runs the program on the records that are on their homes.
    void run(splat::View const& view, std::uint32_t chapter_depth, report::FrameReport& report)
    {
        auto const start = Clock::now();
        tell(view, chapter_depth);
        report.host_ms.project += since(start);
        account(mesh_->run(), report);
        if constexpr (traced) {
            if (!streams_) return;
            auto const& of_chapter = mesh_->trace();
            if (report.homes.chapters == 1) {
                trace_ = of_chapter;
                return;
            }
            trace_.supersteps.insert(trace_.supersteps.end(), of_chapter.supersteps.begin(), of_chapter.supersteps.end());
            for (std::size_t i = 0; i < trace_.loops.size(); ++i) trace_.loops[i].rounds += of_chapter.loops[i].rounds;
        }
    }
    /// A map with more records than homes: the records in front of the camera come in chapters, the nearest first. A chapter has the next
    /// keys (depth, id) in order, as many as there are homes, so no later chapter has a record in front of one of an earlier chapter.
    /// It ends early if every pixel has stopped, or at the bound on rounds.
    void run_chapters(splat::View const& view, report::FrameReport& report)
    {
        auto const start = Clock::now();
        auto const n = records_.rows();
        depths_.resize(n);
        mesh_->on_threads([&](std::uint32_t thread, std::uint32_t threads) {
            auto const first = static_cast<std::uint32_t>(std::uint64_t{n} * thread / threads);
            auto const last = static_cast<std::uint32_t>(std::uint64_t{n} * (thread + 1) / threads);
            for (auto row = first; row < last; ++row) depths_[row] = records_.depth_bits(row, view);
        });
        auto const key = [&](std::uint32_t row) { return std::uint64_t{depths_[row]} << 32 | static_cast<std::uint32_t>(records_.id(row)); };
        std::vector<std::uint64_t> keys;
        keys.reserve(n);
        for (std::uint32_t row = 0; row < n; ++row)
            if (depths_[row] != 0) keys.push_back(key(row));
        report.host_ms.project += since(start);
        std::size_t done = 0;
        do {
            auto const begin = Clock::now();
            auto const size = std::min<std::size_t>(residents_, keys.size() - done);
            auto const first = keys.begin() + static_cast<std::ptrdiff_t>(done), last = first + static_cast<std::ptrdiff_t>(size);
            if (last != keys.end()) std::nth_element(first, last, keys.end());
            std::uint64_t const from = size == 0 ? 0 : *std::min_element(first, last), to = last != keys.end() ? *last : ~std::uint64_t{0};
            chapter_.clear();
            for (std::uint32_t row = 0; row < n; ++row) // in the order of rows, so that homes do not depend on the standard library
                if (depths_[row] != 0 && key(row) >= from && key(row) < to) chapter_.push_back(row);
            load_chapter();
            report.homes.streamed_bytes += std::uint64_t{chapter_.size()} * facts_.record_bytes;
            ++report.homes.chapters;
            report.host_ms.project += since(begin);
            report.homes.unfinished_tiles = 0;
            run(view, done == 0 ? 0 : static_cast<std::uint32_t>(from >> 32), report);
            done += size;
        } while (done < keys.size() && report.homes.unfinished_tiles == 0 && tiles_that_go_on() != 0);
        // At a bound, a tile that is done with its chapter lacks the later ones.
        if (done < keys.size() && report.homes.unfinished_tiles != 0) report.homes.unfinished_tiles = tiles_that_go_on();
    }
    /// The tiles with a block that has not stopped.
    std::uint64_t tiles_that_go_on() const
    {
        std::uint64_t n = 0;
        for (TileId const tile : grid_.tiles())
            if (tile.x() < fold_.x.tiles && tile.y() < fold_.y.tiles)
                n += std::as_const(*mesh_).template state<splat::homes::Window>(tile).finished != 0xffffffffu ? 1 : 0;
        return n;
    }
    /// Writes the parameters of a frame. By reference, projects the host's table on all threads.
    void tell(splat::View const& view, std::uint32_t chapter_depth)
    {
        auto& frame = mesh_->template broadcast<Parameters>();
        auto const tiling = splat::make_tiling(size_.width, size_.height, splat::block_width, splat::block_height);
        static_cast<splat::homes::Parameters&>(frame) = {view, tiling, fold_, chapter_depth};
        if constexpr (by_reference) {
            frame.splats = splat::HostPointer<splat::Splat>(table_.data());
            mesh_->on_threads([&](std::uint32_t thread, std::uint32_t threads) {
                std::uint64_t const n = chapter_.size();
                auto const first = static_cast<std::uint32_t>(n * thread / threads), last = static_cast<std::uint32_t>(n * (thread + 1) / threads);
                if (streams_)
                    records_.project_rows(chapter_.data() + first, last - first, view, tiling, table_.data() + first);
                else
                    records_.project(first, last - first, view, tiling, table_.data() + first);
            });
        }
    }
    /// Adds a run to the report of its frame.
    void account(RunCounters const& run, report::FrameReport& r)
    {
        std::uint64_t asked = 0, arrived = 0, strips = 0;
        for (TileId const tile : grid_.tiles()) {
            auto const& mesh = std::as_const(*mesh_);
            auto const& c = mesh.template state<splat::homes::Counts>(tile);
            auto const& w = mesh.template state<splat::homes::Work>(tile);
            auto const& window = mesh.template state<splat::homes::Window>(tile);
            r.gaussians.visible += c.visible;
            r.hops += c.hops;
            asked += c.asked;
            arrived += c.arrived;
            r.homes.parcels += c.sent;
            r.homes.refused += c.refused;
            r.homes.unfinished_tiles += window.done() ? 0 : 1;
            r.refused.channel_full += c.channel_full;
            r.refused.no_credit += c.no_credit;
            for (std::uint32_t i = 0; i < splat::homes::Work::max_workers; ++i) {
                strips += w.strips[i];
                r.pairs_contributing += w.contributing[i];
            }
        }
        if (asked != arrived)
            throw Error("a frame in which homes sent " + std::to_string(asked) + " splats and tiles received " + std::to_string(arrived) +
                        " (the protocol of homes is broken); report this");
        r.homes.entries += arrived;
        r.homes.rounds += run.loops[0].rounds;
        r.pairs += strips * splat::homes::strip_pairs;
        using namespace splat;
        constexpr auto tell = step_of<Program, homes::Tell<P>>(), sort = step_of<Program, homes::SortRuns<P>>();
        for (std::uint32_t i = 0; i < run.steps.size(); ++i) { // in program order: project, begin; tell to deliver; sort to finish
            using Stages = report::FrameReport::ByStage;
            auto const stage = i < tell ? &Stages::project : i < sort ? &Stages::route : &Stages::composite;
            r.passes.*stage += run.steps[i].passes;
            r.exchanges.*stage += run.steps[i].exchanges;
            (i < tell ? r.host_ms.project : i < sort ? r.host_ms.route : r.host_ms.composite) += run.steps[i].milliseconds;
        }
        r.messages += run.messages();
        for (auto const& s : run.steps) {
            r.exchanged_live_bytes += s.live_bytes;
            r.exchanged_capacity_bytes += s.capacity_bytes;
        }
        for (auto const& p : run.peaks) {
            if (p.region == homes::Held<P>::name) r.peak_storage = std::max(r.peak_storage, p.items);
            if (p.region == homes::Parcels<P>::name) r.peak_channel = std::max(r.peak_channel, p.items);
        }
        r.digests.insert(r.digests.end(), run.digests.begin(), run.digests.end());
    }
    report::FrameReport unchanged() const
    {
        report::FrameReport r;
        r.gaussians.visible = visible_;
        r.gaussians.parked = records_.rows() - visible_;
        r.homes.unfinished_tiles = unfinished_;
        return r;
    }
    /// Copies the tiles' blocks into one picture, with the planes that the choice has.
    void collect(splat::Camera const& camera, RenderedFrame& to)
    {
        auto const size = [&](auto& plane, bool wanted) {
            if (!wanted)
                plane = {};
            else if (plane.width != camera.width || plane.height != camera.height)
                plane = std::remove_reference_t<decltype(plane)>(camera.width, camera.height);
        };
        size(to.image, true);
        size(to.depth, choice_.depth);
        size(to.alpha, choice_.alpha);
        bool const round = choice_.colour == ColourFormat::rgbx8 && std::is_same_v<splat::ColourOf<typename P::Pixel>, splat::FloatPixel>;
        auto const& mesh = std::as_const(*mesh_);
        mesh_->on_threads([&](std::uint32_t thread, std::uint32_t threads) {
            std::uint64_t const tiles = grid_.size();
            for (auto t = tiles * thread / threads; t < tiles * (thread + 1) / threads; ++t) {
                auto const tile = grid_.tile(static_cast<std::uint32_t>(t));
                auto const framebuffer = mesh.template state<splat::homes::Framebuffer<typename P::Pixel>>(tile);
                auto const* pixel = framebuffer.begin();
                for (std::uint32_t b = 0; b < framebuffer.size() / (splat::block_width * splat::block_height); ++b) {
                    auto const place = splat::homes::block_at(fold_, tile, b);
                    for (std::uint32_t j = 0; j < splat::block_height; ++j, pixel += splat::block_width) {
                        auto const y = place.y + j;
                        if (!place.exists || y >= camera.height) continue;
                        auto const width = std::min(splat::block_width, camera.width - place.x);
                        for (std::uint32_t i = 0; i < width; ++i) detail::show(pixel[i], place.x + i, y, to);
                        if (round) detail::round_to_levels(to.image.pixel(place.x, y), 3 * width);
                    }
                }
            }
        });
    }

    RendererOptions options_;
    EngineOptions engine_;
    HomesChoice choice_;
    Grid grid_;
    RecordTable records_;             ///< in the order of their homes
    std::vector<std::uint32_t> chapter_; ///< the rows that are on their homes, tile by tile
    std::vector<splat::Splat> table_;    ///< by reference: their splats in this view
    std::vector<std::uint32_t> depths_;  ///< of all records, if there are chapters
    std::uint32_t residents_ = 0;        ///< records that have homes at the same time
    bool streams_ = false;
    SetupFacts facts_{};
    splat::homes::Fold fold_{};
    Extent2 size_{};
    std::unique_ptr<MeshType> mesh_;
    Observer observer_;
    [[no_unique_address]] std::conditional_t<traced, Trace, engine::NoTrace> trace_; ///< of all chapters
    std::optional<splat::View> last_;
    bool halfway_ = false;
    std::uint64_t visible_ = 0, unfinished_ = 0;
};

}}} // namespace tilemesh::render
