#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <tilemesh/any_renderer.hpp>
#include <tilemesh/engine/digest.hpp>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/engine/port.hpp>
#include <tilemesh/engine/stopwatch.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/either.hpp>
#include <tilemesh/render/engine_options.hpp>
#include <tilemesh/render/homes_choice.hpp>
#include <tilemesh/render/homes_form.hpp>
#include <tilemesh/render/over_ranks.hpp>
#include <tilemesh/render/picture.hpp>
#include <tilemesh/render/record_table.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/row_shares.hpp>
#include <tilemesh/render/setup_facts.hpp>
#include <tilemesh/splat/homes/program.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// Renders a map of any density on a grid of tiles: the program of homes and windows (splat/homes/program.hpp). The picture is complete and
/// bit-identical to that of one depth-ordered list for the whole frame, for any capacities. More splats than a tile holds cost rounds, not
/// records.
///
/// `P`: policies of splat/homes (by reference or by value). `Engine`: Mesh, CheckedMesh or PoplarMesh; by value also MpiMesh. Records never
/// move, so a new view sends every visible splat again; an unchanged view runs nothing.
///
/// On an engine over several processes, each has such a renderer and calls the same functions, as with FrameRenderer: each process has its
/// share of the map, the first gets the picture, and all get the same report. Records and pixels may then have more than the choice asks
/// for, which changes no result: the ledger is that of the choice.
template <class P, template <class, class> class Engine = Mesh, class Machine = AnyMachine>
class HomesRenderer : public AnyRenderer {
public:
    using Program = splat::homes::Frame<P>;
    using MeshType = Engine<Program, Machine>;
    using EngineOptions = typename MeshType::Options;
    static constexpr bool by_reference = std::is_same_v<typename P::Record, splat::Reference>;
    static constexpr bool traced = is_traced<Machine>;

    static_assert(!over_ranks<MeshType> || !by_reference, "references to a table of the host on an engine over several processes (a tile "
                                                          "of another process cannot read that table); choose policies by value");

    /// A map with more records than homes comes in chapters; its records are sent anew for each view. Throws Error if the choice's records or
    /// pixels are not those of the policies.
    HomesRenderer(scene::Map const& map, HomesChoice const& choice, RendererOptions options = {}, EngineOptions engine = {});
    ~HomesRenderer() override;

    RenderedFrame render(splat::Camera const& camera) override;
    /// Renders into an existing frame and reuses its memory. After an exception the frame holds no picture, and the next one begins anew.
    void render_into(splat::Camera const& camera, RenderedFrame& result);

    splat::Rules& rules() override { return choice_.rules; }
    void hold_to(scene::Demand const& demand) override
    {
        demand_.scanned = demand.scanned; // first, because this may throw
        demand_.culled = demand.culled;
    }
    Extent2 grid() override { return {grid_.width, grid_.height}; }
    Extent2 tile() override { return {fold_.x.layers * splat::block_width, fold_.y.layers * splat::block_height}; }
    SetupFacts const& facts() const override { return facts_; }
    bool routes() const override { return true; }
    bool blooms() const override { return true; }
    MeshType& mesh() noexcept { return *mesh_; }
    /// The trace of the last frame, chapter after chapter; only on a Traced machine whose mesh keeps one. A frame whose view did not change has no superstep. On
    /// several processes, it is the trace of this process's tiles.
    template <class M = Machine>
    Trace const& trace() const noexcept
        requires(is_traced<M>)
    {
        return trace_;
    }
    splat::homes::Fold const& fold() const noexcept { return fold_; }
    void observe(Observer observer)
    {
        observer_ = std::move(observer);
        if (mesh_) mesh_->observe(observer_);
    }

private:
    using Parameters = typename P::Parameters;

    bool keeps_trace() const noexcept
    {
        if constexpr (requires { engine_.trace; })
            return traced && engine_.trace;
        else
            return traced;
    }
    /// The form of pixels and blocks that have two.
    bool wide() const noexcept { return choice_.depth || choice_.alpha; }
    static void require_policies(HomesChoice const& c)
    {
        using Pixel = typename P::Pixel;
        bool const rgbx8 = std::is_same_v<splat::ColourOf<Pixel>, splat::Rgbx8Pixel>;
        bool fits = Pixel::has_depth >= c.depth && Pixel::has_alpha >= c.alpha && (c.colour == ColourFormat::rgbx8) >= rgbx8;
        if constexpr (over_ranks<MeshType>)
            fits = fits && c.sh_degree <= P::Record::sh_degree;
        else if constexpr (!by_reference) // what the tiles store is what the ledger counts
            fits = c.sh_degree == P::Record::sh_degree && c.depth == Pixel::has_depth && c.alpha == Pixel::has_alpha &&
                   (c.colour == ColourFormat::rgbx8) == rgbx8;
        if (!fits)
            throw Error("a choice of records or pixels that the renderer's policies do not store (degree, colour format, depth or alpha "
                        "differ); give both the same");
    }
    static RecordTable table_of(scene::Map const& map, std::uint32_t tiles, std::uint32_t degree)
    {
        if constexpr (over_ranks<MeshType>)
            return {map, degree}; // `take_share` deals it
        else
            return {dealt(map, tiles), degree};
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
        mesh_.reset();
        last_.reset();
        auto const rows = options_.rows_of_all_parts != 0 ? options_.rows_of_all_parts : records_.all_rows();
        GroupOf<MeshType> group(engine_);
        std::optional<MeshSizes<Program>> mesh_sizes;
        splat::homes::Sizes sizes;
        together(group, [&] { mesh_sizes = lay_out(width, height, rows, sizes); });
        mesh_.emplace(splat::homes::frame_program<P>(grid_), grid_, *mesh_sizes, engine_); // bands of equal height, see README
        limit_lists(sizes);
        together(*mesh_, [&] {
            if (observer_) mesh_->observe(observer_);
        });
        take_share();
        together(*mesh_, [&] {
            for (TileId const tile : grid_.tiles()) {
                if (!owns(*mesh_, tile)) continue;
                auto table = mesh_->template state<splat::homes::Table>(tile);
                for (auto n = sizes.tiles; n > 0; --n) table.push({splat::homes::infinite_depth, 0, 0});
                auto framebuffer = mesh_->template state<splat::homes::Framebuffer<typename P::Pixel>>(tile);
                if (tile.x() < fold_.x.tiles && tile.y() < fold_.y.tiles) {
                    framebuffer.resize(sizes.tile_pixels);
                    machine::in_form(wide(), framebuffer.begin(), [&]<class Pixel>(Pixel* pixels) {
                        std::fill(pixels, pixels + sizes.tile_pixels, Pixel::make(splat::nothing_blended));
                    });
                }
            }
            if (streams_) return;
            chapter_.resize(records_.rows());
            for (std::uint32_t row = 0; row < records_.rows(); ++row) chapter_[row] = row;
        });
        if (!streams_) load_chapter();
    }
    /// Lays out a frame of this size, and sets what follows from it. `sizes`: what it sets a tile's lists to.
    MeshSizes<Program> lay_out(std::uint32_t width, std::uint32_t height, std::uint32_t rows, splat::homes::Sizes& sizes)
    {
        auto layout = layout_homes(choice_, options_, {width, height}, rows);
        fold_ = layout.fold;
        size_ = {width, height};
        sizes = layout.sizes;
        if (!engine::has_words_for_workers(choice_.machine, StepsOf<Program>{}))
            throw Error("machine " + std::string(choice_.machine.name) + " with " + std::to_string(choice_.machine.workers) +
                        " workers (the program of homes has words for 1 to " + std::to_string(splat::homes::Work::max_workers) +
                        "); choose another machine");
        if (sizes.homes == 0) throw Error("tiles without homes (every record lives in one); give a tile at least one");
        engine::require_least_slots(sizes, typename machine::Needs<Program>::States{});
        engine::require_least_slots(sizes, typename machine::Needs<Program>::Links{});
        facts_ = facts_of(choice_, sizes, layout.ledger);
        std::uint64_t const homes = std::uint64_t{sizes.homes} * grid_.size();
        streams_ = rows > homes;
        residents_ = static_cast<std::uint32_t>(std::min<std::uint64_t>(homes, rows));
        if constexpr (by_reference) table_.resize(residents_);

        set_engine_options<traced>(options_, engine_);
        auto mesh_sizes = engine::plain_sizes<Program>(choice_.machine, sizes, typename machine::Needs<Program>::States{},
                                                       typename machine::Needs<Program>::Links{});
        mesh_sizes.sram_bytes = facts_.sram_bytes;
        if constexpr (machine::has_form_word<Parameters>) mesh_sizes.wide = wide();
        return mesh_sizes;
    }
    void limit_lists(splat::homes::Sizes const& sizes)
    {
        // A limit above the slots that there are limits nothing: the anchored program may have more.
        if (options_.channel_slots != 0) mesh_->template limit<splat::homes::Parcels<P>>(std::min(options_.channel_slots, sizes.parcels));
        if (options_.waiting_slots != 0) {
            mesh_->template limit<splat::homes::Waiting<P, 0>>(std::min(options_.waiting_slots, sizes.waiting));
            mesh_->template limit<splat::homes::Waiting<P, 1>>(std::min(options_.waiting_slots, sizes.waiting));
        }
        if (auto const held = options_.held_slots != 0 ? options_.held_slots : options_.storage_slots; held != 0) {
            mesh_->template limit<splat::homes::Held<P>>(std::min(held, sizes.held));
            mesh_->template limit<splat::homes::Keys>(std::min(held, sizes.held));
            mesh_->template limit<splat::homes::Order>(std::min(held, sizes.held));
        }
    }
    /// The first record of tile t's share, if n records are shared out among all tiles in even shares.
    std::uint64_t first_of(std::uint64_t n, std::uint32_t tile) const noexcept
    {
        return n / grid_.size() * tile + std::min<std::uint64_t>(tile, n % grid_.size());
    }
    /// Over several processes: takes this process's share of the records, in the order of their homes. Once.
    void take_share()
    {
        if constexpr (over_ranks<MeshType>) {
            if (in_order_) return;
            if (!shared_) records_.share(*mesh_, options_.rows_of_all_parts);
            shared_ = true; // if the next step throws, this one has been done
            records_.template reorder<typename P::Record>(*mesh_, [&](std::uint32_t row) { // as `dealt`
                return first_of(records_.all_rows(), row % grid_.size()) + row / grid_.size();
            });
            in_order_ = true;
        }
    }
    /// The view of a camera, as in FrameRenderer: what one of several processes refuses, or what differs, is an Error in all.
    splat::View agreed_view(splat::Camera const& camera)
    {
        splat::View view{};
        auto const agree = [&]([[maybe_unused]] auto& all) {
            together(all, [&] {
                check_camera(camera);
                check_rules(choice_.rules);
                view = splat::make_view(camera, choice_.rules);
                if (!demand_.holds_for(view))
                    throw Error("a view that the demand was not made for (" + std::to_string(demand_.culled) +
                                " records that its path does not show are not loaded); make the demand of all views, with the model");
            });
            if constexpr (over_ranks<MeshType>) require_same_frames(all, digest_of_view(renderer_digest_, view));
        };
        if (mesh_) {
            agree(*mesh_);
        } else {
            GroupOf<MeshType> group(engine_);
            agree(group);
        }
        return view;
    }
    /// Puts the rows of `chapter_` onto their homes, in even shares.
    void load_chapter()
    {
        if constexpr (over_ranks<MeshType>) {
            load_chapter_of_all(*mesh_);
        } else {
            std::uint32_t at = 0;
            for (TileId const tile : grid_.tiles())
                fill(tile, chapter_.size(), [&] {
                    auto const row = at++;
                    if constexpr (by_reference)
                        return splat::Reference{records_.id(chapter_[row]), row};
                    else
                        return records_.template record<typename P::Record>(chapter_[row]);
                });
        }
    }
    /// Over several processes: sends the records of the chapter to the processes of their homes.
    template <class M> // so that an explicit instantiation for one process does not compile it
    void load_chapter_of_all(M& mesh)
    {
        auto const shares = RowShares::of_parts(mesh, chapter_.size());
        std::vector<typename P::Record> records;
        std::vector<std::uint64_t> counts;
        together(mesh, [&] {
            auto const& bands = mesh.bands();
            auto const own = this_process(mesh);
            for (std::uint32_t p = 0; p < processes(mesh); ++p) {
                auto const first = std::max(shares.first(own), first_of(shares.rows(), bands.first(p) * grid_.width));
                auto const last = std::min(shares.last(own), first_of(shares.rows(), bands.last(p) * grid_.width));
                counts.push_back(last > first ? last - first : 0);
            }
            records.reserve(chapter_.size());
            for (auto const row : chapter_) records.push_back(records_.template record<typename P::Record>(row));
        });
        records = deal(mesh, std::move(records), counts);
        together(mesh, [&] {
            std::size_t at = 0;
            for (TileId const tile : grid_.tiles())
                if (owns(mesh, tile)) fill(tile, shares.rows(), [&] { return records[at++]; });
        });
    }
    /// Gives a tile its share of n records, which `next` returns one after another.
    template <class F>
    void fill(TileId tile, std::uint64_t n, F const& next)
    {
        auto home = mesh_->template state<splat::homes::Home<P>>(tile);
        auto seen = mesh_->template state<splat::homes::Seen<P>>(tile);
        auto offers = mesh_->template state<splat::homes::Offers>(tile);
        home.truncate(0), seen.truncate(0), offers.truncate(0);
        auto const index = grid_.index_of(tile);
        for (auto i = first_of(n, index + 1) - first_of(n, index); i > 0; --i) {
            home.push(next());
            seen.push({});
            offers.push({});
        }
    }
    /// Runs the program on the records that are on their homes.
    void run(splat::View const& view, std::uint32_t chapter_depth, report::FrameReport& report)
    {
        engine::Stopwatch const preparing;
        tell(view, chapter_depth);
        if (options_.rounds != 0) splat::homes::bound_rounds(mesh_->program(), static_cast<std::uint32_t>(options_.rounds - report.homes.rounds));
        report.host_ms.project += preparing.milliseconds();
        account(mesh_->run(), report);
        if constexpr (traced)
            if (keeps_trace()) together(*mesh_, [&] { add_to_trace(mesh_->trace()); });
    }
    void add_to_trace([[maybe_unused]] Trace const& ran)
    {
        if constexpr (traced) {
            if (trace_.supersteps.empty()) {
                trace_ = ran;
                return;
            }
            trace_.supersteps.insert(trace_.supersteps.end(), ran.supersteps.begin(), ran.supersteps.end());
            for (std::size_t i = 0; i < trace_.loops.size(); ++i) trace_.loops[i].rounds += ran.loops[i].rounds;
        }
    }
    /// A map with more records than homes: the records in front of the camera come in chapters, the nearest first. A chapter has the next
    /// keys (depth, id) in order, as many as there are homes, so no later chapter has a record in front of one of an earlier chapter.
    /// It ends early if every pixel has stopped, or at the bound on rounds, which all chapters of a frame share.
    void run_chapters(splat::View const& view, report::FrameReport& report)
    {
        engine::Stopwatch const preparing;
        auto const n = records_.rows();
        together(*mesh_, [&] { depths_.resize(n); });
        mesh_->on_threads([&](std::uint32_t thread, std::uint32_t threads) {
            auto const first = static_cast<std::uint32_t>(std::uint64_t{n} * thread / threads);
            auto const last = static_cast<std::uint32_t>(std::uint64_t{n} * (thread + 1) / threads);
            for (auto row = first; row < last; ++row) depths_[row] = records_.depth_bits(row, view);
        });
        auto const key = [&](std::uint32_t row) { return std::uint64_t{depths_[row]} << 32 | static_cast<std::uint32_t>(records_.id(row)); };
        std::vector<std::uint64_t> keys; // of this process
        together(*mesh_, [&] {
            keys.reserve(n);
            for (std::uint32_t row = 0; row < n; ++row)
                if (depths_[row] != 0) keys.push_back(key(row));
            if constexpr (over_ranks<MeshType>) std::sort(keys.begin(), keys.end());
        });
        std::uint64_t all = keys.size();
        sum(*mesh_, &all, 1);
        report.host_ms.project += preparing.milliseconds();
        std::uint64_t done = 0, from = 0, to = 0;
        std::uint32_t behind = 0; // bits of the nearest depth of the next chapter
        do {
            engine::Stopwatch const loading;
            auto const size = std::min<std::uint64_t>(residents_, all - done);
            if constexpr (over_ranks<MeshType>) {
                from = nth_of_all(keys, done);
                to = nth_of_all(keys, done + size);
            } else {
                auto const first = keys.begin() + static_cast<std::ptrdiff_t>(done), last = first + static_cast<std::ptrdiff_t>(size);
                if (last != keys.end()) std::nth_element(first, last, keys.end());
                from = size == 0 ? 0 : *std::min_element(first, last), to = last != keys.end() ? *last : no_key;
            }
            together(*mesh_, [&] {
                chapter_.clear();
                for (std::uint32_t row = 0; row < n; ++row) // in the order of rows, so that homes do not depend on the standard library
                    if (depths_[row] != 0 && key(row) >= from && key(row) < to) chapter_.push_back(row);
            });
            load_chapter();
            report.homes.streamed_bytes += size * facts_.record_bytes;
            ++report.homes.chapters;
            report.host_ms.project += loading.milliseconds();
            report.unfinished.clear();
            run(view, done == 0 ? 0 : static_cast<std::uint32_t>(from >> 32), report);
            done += size;
            if (done == all || !goes_on()) return;
            behind = static_cast<std::uint32_t>(to >> 32);
        } while (report.homes.unfinished_tiles == 0 && (options_.rounds == 0 || report.homes.rounds < options_.rounds));
        // At the bound, a tile that is done with its chapter lacks the later ones.
        report.unfinished.clear();
        together(*mesh_, [&] {
            for_each_window([&](TileId tile, splat::homes::Window const& window) {
                if (window.finished != 0xffffffffu)
                    report.unfinished.push_back({grid_.index_of(tile), __builtin_bit_cast(float, window.done() ? behind : window.lo_depth)});
            });
        });
        give_all(report.unfinished);
        report.homes.unfinished_tiles = report.unfinished.size();
    }
    /// Every process gets the items of all, in the order of their tiles.
    template <class T>
    void give_all(std::vector<T>& items)
    {
        join(*mesh_, items);
        share(*mesh_, items);
    }
    /// The n-th of the keys of all processes, counted from 0; `no_key` if there are fewer. A key's depth is finite and not negative, so a key
    /// is below 2^63. `keys`: those of this process, sorted. Cost: 64 agreements of one word.
    std::uint64_t nth_of_all(std::vector<std::uint64_t> const& keys, std::uint64_t n)
    {
        std::uint64_t least_key = 0, most_key = no_key; // at most n keys are below least_key, and more than n are up to most_key
        while (least_key < most_key) {
            auto const middle = least_key + (most_key - least_key) / 2;
            auto upto = static_cast<std::uint64_t>(std::upper_bound(keys.begin(), keys.end(), middle) - keys.begin());
            sum(*mesh_, &upto, 1);
            if (upto > n) most_key = middle;
            else least_key = middle + 1;
        }
        return least_key;
    }
    /// Calls f(tile, window) for each tile of this process with blocks.
    template <class F>
    void for_each_window(F const& f) const
    {
        for (TileId const tile : grid_.tiles())
            if (tile.x() < fold_.x.tiles && tile.y() < fold_.y.tiles && owns(*mesh_, tile)) f(tile, std::as_const(*mesh_).template state<splat::homes::Window>(tile));
    }
    /// Has a tile a block that has not stopped?
    bool goes_on()
    {
        bool some = false;
        for_each_window([&](TileId, splat::homes::Window const& window) { some = some || window.finished != 0xffffffffu; });
        return in_any(*mesh_, some);
    }
    /// Writes the parameters of a frame. By reference, projects the host's table on all threads.
    void tell(splat::View const& view, std::uint32_t chapter_depth)
    {
        auto& frame = mesh_->template broadcast<Parameters>();
        auto const tiling = splat::make_tiling(size_.width, size_.height, splat::block_width, splat::block_height);
        static_cast<splat::homes::Parameters&>(frame) = {view, tiling, fold_, chapter_depth};
        if constexpr (machine::has_form_word<Parameters>) frame.wide = wide() ? 1 : 0;
        if constexpr (by_reference) {
            frame.splats = splat::HostPointer<splat::Splat const>(table_.data());
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
    /// Replaces each of these words by its sum over the processes.
    void add_up(std::initializer_list<std::uint64_t*> words)
    {
        std::uint64_t sums[16];
        std::size_t n = 0;
        for (auto const* word : words) sums[n++] = *word;
        sum(*mesh_, sums, n);
        n = 0;
        for (auto* word : words) *word = sums[n++];
    }
    /// Adds a run to the report of its frame.
    void account(RunCounters const& run, report::FrameReport& r)
    {
        std::uint64_t visible = 0, hops = 0, asked = 0, arrived = 0, sent = 0, refused = 0, full = 0, no_credit = 0, strips = 0, contributing = 0;
        std::vector<report::UnfinishedTile> unfinished;
        together(*mesh_, [&] {
            for (TileId const tile : grid_.tiles()) {
                if (!owns(*mesh_, tile)) continue;
                auto const& mesh = std::as_const(*mesh_);
                auto const& c = mesh.template state<splat::homes::Counts>(tile);
                auto const& w = mesh.template state<splat::homes::Work>(tile);
                auto const& window = mesh.template state<splat::homes::Window>(tile);
                visible += c.visible;
                hops += c.hops;
                asked += c.asked;
                arrived += c.arrived;
                sent += c.sent;
                refused += c.refused;
                if (!window.done()) unfinished.push_back({grid_.index_of(tile), __builtin_bit_cast(float, window.lo_depth)});
                full += c.channel_full;
                no_credit += c.no_credit;
                for (std::uint32_t i = 0; i < splat::homes::Work::max_workers; ++i) {
                    strips += w.strips[i];
                    contributing += w.contributing[i];
                }
            }
        });
        add_up({&visible, &hops, &asked, &arrived, &sent, &refused, &full, &no_credit, &strips, &contributing});
        give_all(unfinished);
        r.gaussians.visible += visible;
        r.hops += hops;
        r.homes.parcels += sent;
        r.homes.refused += refused;
        r.refused.channel_full += full;
        r.refused.no_credit += no_credit;
        r.pairs_contributing += contributing;
        together(*mesh_, [&] {
            r.unfinished.insert(r.unfinished.end(), unfinished.begin(), unfinished.end());
            r.digests.insert(r.digests.end(), run.digests.begin(), run.digests.end());
        });
        if (asked != arrived)
            throw Error("a frame in which homes sent " + std::to_string(asked) + " splats and tiles received " + std::to_string(arrived) +
                        " (the protocol of homes is broken); report this");
        r.homes.entries += arrived;
        r.homes.unfinished_tiles = r.unfinished.size();
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
    }
    report::FrameReport unchanged() const
    {
        report::FrameReport r;
        r.program = report::Program::homes;
        r.gaussians.visible = visible_;
        r.gaussians.parked = records_.all_rows() - visible_;
        r.unfinished = unfinished_;
        r.homes.unfinished_tiles = unfinished_.size();
        return r;
    }
    /// Copies the tiles' blocks into one picture, with the planes that the choice has. Of several processes, the first gets it.
    void collect(splat::Camera const& camera, RenderedFrame& to)
    {
        gather<splat::homes::Framebuffer<typename P::Pixel>>(*mesh_);
        together(*mesh_, [&] {
            if (is_first(*mesh_)) return copy_picture(camera, to);
            to.image = {};
            to.depth = to.alpha = {};
        });
    }
    void copy_picture(splat::Camera const& camera, RenderedFrame& to)
    {
        size_planes(camera, choice_.depth, choice_.alpha, to);
        bool const round = choice_.colour == ColourFormat::rgbx8 && std::is_same_v<splat::ColourOf<typename P::Pixel>, splat::FloatPixel>;
        auto const& mesh = std::as_const(*mesh_);
        mesh_->on_threads([&](std::uint32_t thread, std::uint32_t threads) {
            std::uint64_t const tiles = grid_.size();
            for (auto t = tiles * thread / threads; t < tiles * (thread + 1) / threads; ++t) {
                auto const tile = grid_.tile(static_cast<std::uint32_t>(t));
                auto const framebuffer = mesh.template state<splat::homes::Framebuffer<typename P::Pixel>>(tile);
                machine::in_form(wide(), framebuffer.begin(), [&](auto const* pixel) {
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
                });
            }
        });
    }

    RendererOptions options_;
    EngineOptions engine_;
    HomesChoice choice_;
    Grid grid_;
    RecordTable records_;             ///< in the order of their homes; of several processes, each has a share
    std::vector<std::uint32_t> chapter_; ///< the rows that are on their homes, tile by tile
    std::vector<splat::Splat> table_;    ///< by reference: their splats in this view
    std::vector<std::uint32_t> depths_;  ///< of this process's records, if there are chapters
    static constexpr std::uint64_t no_key = ~std::uint64_t{0} >> 1; ///< behind all keys
    std::uint64_t renderer_digest_ = 0;  ///< over several processes: of what all of them have in common
    bool shared_ = false, in_order_ = false; ///< over several processes: this one has its share of the records; in the order of their homes
    std::uint32_t residents_ = 0;        ///< records that have homes at the same time
    bool streams_ = false;
    SetupFacts facts_{};
    splat::homes::Fold fold_{};
    Extent2 size_{};
    std::optional<MeshType> mesh_; ///< no memory of its own, which one of several processes may lack
    Observer observer_;
    std::optional<splat::View> last_;
    bool halfway_ = false;
    std::uint64_t visible_ = 0;
    std::vector<report::UnfinishedTile> unfinished_;
    scene::Demand demand_; ///< only the facts about views
    [[no_unique_address]] std::conditional_t<traced, Trace, engine::NoTrace> trace_; ///< of all chapters
};

// As in FrameRenderer, the members that users call are defined outside the class.

template <class P, template <class, class> class Engine, class Machine>
HomesRenderer<P, Engine, Machine>::HomesRenderer(scene::Map const& map, HomesChoice const& choice, RendererOptions options, EngineOptions engine)
    : options_(options), engine_(std::move(engine)), choice_(choice), grid_(homes_grid(options)),
      records_(table_of(map, grid_.size(), choice.sh_degree))
{
    if (options.rows_of_all_parts != 0 && !over_ranks<MeshType>) refuse_part();
    if (over_ranks<MeshType> && options.rows_of_all_parts == 0) renderer_digest_ = records_.digest();
    for (auto const word : {map.sh_degree, options.rounds, options.rows_of_all_parts, options.channel_slots, options.waiting_slots,
                            options.held_slots, options.storage_slots, options.fold ? 1u : 0u})
        renderer_digest_ = engine::mix(renderer_digest_, word);
    require_policies(choice);
    choice_.rules = with_options(choice_.rules, options);
    facts_ = facts_of(choice_, choice_.sizes, HomesLedger(choice_, choice_.sizes)); // until the first frame
}
template <class P, template <class, class> class Engine, class Machine>
HomesRenderer<P, Engine, Machine>::~HomesRenderer() = default;

template <class P, template <class, class> class Engine, class Machine>
RenderedFrame HomesRenderer<P, Engine, Machine>::render(splat::Camera const& camera)
{
    RenderedFrame frame;
    render_into(camera, frame);
    return frame;
}

template <class P, template <class, class> class Engine, class Machine>
void HomesRenderer<P, Engine, Machine>::render_into(splat::Camera const& camera, RenderedFrame& result)
{
    engine::Stopwatch const all;
    if (halfway_) mesh_.reset();
    auto const view = agreed_view(camera);
    halfway_ = true;
    prepare(camera.width, camera.height);
    bool const changed = !last_ || __builtin_memcmp(&*last_, &view, sizeof view) != 0;
    report::FrameReport report;
    report.program = report::Program::homes;
    if constexpr (traced) {
        trace_.supersteps.clear();
        for (auto& loop : trace_.loops) loop.rounds = 0;
    }
    if (changed) {
        if (streams_)
            run_chapters(view, report);
        else
            run(view, 0, report);
        visible_ = report.gaussians.visible;
        together(*mesh_, [&] { unfinished_ = report.unfinished; });
        report.gaussians.parked = records_.all_rows() - visible_;
    } else {
        together(*mesh_, [&] { report = unchanged(); });
    }
    engine::Stopwatch const collecting;
    collect(camera, result);
    result.report = std::move(report);
    result.report.width = camera.width;
    result.report.height = camera.height;
    result.report.gaussians.parked += demand_.culled;
    last_ = view;
    halfway_ = false;
    result.report.host_ms.picture = collecting.milliseconds();
    result.report.host_ms.total = all.milliseconds();
}

/// The renderer of homes that the compiled library has: by reference, for any choice and any engine of one process.
using HostHomesRenderer = HomesRenderer<splat::homes::AnyHostPolicies, PortMesh, Traced<AnyMachine>>;

#if !defined(TILEMESH_COMPILED)
template <class Pixel>
std::unique_ptr<AnyRenderer> make_homes_renderer(scene::Map const& map, HomesChoice const& choice, RendererOptions const& options)
{
    return std::make_unique<HomesRenderer<splat::homes::HostPolicies<Pixel>>>(map, choice, options);
}
#else
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
