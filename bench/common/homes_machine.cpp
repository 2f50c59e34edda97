#include "homes_machine.hpp"
#include <algorithm>
#include <cstdint>
#include <tilemesh/render/frame_renderer.hpp>
#include <tilemesh/render/homes_renderer.hpp>
#include <utility>
#include <vector>

namespace bench {

namespace {

namespace homes = tilemesh::splat::homes;
using tilemesh::render::Setup;
using Policies = homes::HostPolicies<>;
using Renderer = tilemesh::render::HomesRenderer<Policies, tilemesh::Mesh, tilemesh::Traced<tilemesh::AnyMachine>>;

/// Slices of depth with one cut for all tiles, on the program of homes: between two rounds it gives every tile the same window. The window
/// ends at the first splat for which a tile that wants it has no room. The host finds the cut by counting, with the blocks that are
/// finished by then. A machine would need a reduction over the grid for each cut, which is not in the counts.
class OneCut {
public:
    void operator()(Renderer& renderer, tilemesh::SuperstepEvent const& event)
    {
        auto& mesh = renderer.mesh();
        if (event.kernel == homes::Begin<Policies>::name) list(mesh);
        else if (event.kernel != homes::Advance<Policies>::name) return;
        cut(mesh, renderer.fold());
    }

private:
    using MeshType = Renderer::MeshType;
    using Parameters = Policies::Parameters;
    struct Entry {
        homes::Key key;
        std::uint32_t row;
    };
    static bool nearer(Entry const& a, Entry const& b) { return a.key < b.key; }

    /// The splats of this view, the nearest first.
    void list(MeshType& mesh)
    {
        entries_.clear();
        auto const* const splats = mesh.broadcast<Parameters>().splats.get();
        for (auto const tile : mesh.grid().tiles())
            for (auto const& record : std::as_const(mesh).state<homes::Home<Policies>>(tile)) {
                auto const& s = splats[record.row];
                if (s.visible()) entries_.push_back({{s.depth_key, static_cast<std::uint32_t>(record.id)}, record.row});
            }
        std::sort(entries_.begin(), entries_.end(), nearer);
    }
    void cut(MeshType& mesh, homes::Fold const& fold)
    {
        auto const& frame = mesh.broadcast<Parameters>();
        auto const columns = fold.x.tiles, tiles = columns * fold.y.tiles;
        std::vector<std::uint32_t> words(homes::Table::words(tiles));
        homes::Table table{tilemesh::machine::Place{words.data(), words.data() + homes::Table::head_words, tiles}};
        std::vector<homes::Key> from(tiles);
        std::vector<std::uint32_t> room(tiles);
        homes::Key first{homes::infinite_depth, 0};
        std::uint32_t last_depth = 0; // at which a window begins
        for (std::uint32_t t = 0; t < tiles; ++t) {
            auto const tile = tilemesh::TileId::at(t % columns, t / columns);
            auto const& w = std::as_const(mesh).state<homes::Window>(tile);
            table.push({w.lo_depth, homes::infinite_depth, w.finished});
            from[t] = {w.lo_depth, w.lo_id};
            room[t] = std::as_const(mesh).state<homes::Held<Policies>>(tile).capacity();
            if (w.done()) continue;
            first = std::min(first, from[t]);
            last_depth = std::max(last_depth, w.lo_depth);
        }
        if (first.depth == homes::infinite_depth) return;
        std::uint32_t hi = homes::infinite_depth;
        homes::WindowNotice const* const windows = table.begin();
        for (auto e = std::lower_bound(entries_.begin(), entries_.end(), Entry{first, 0}, nearer); e != entries_.end() && hi == homes::infinite_depth; ++e) {
            homes::detail::Wanted const wanted(frame.splats.get()[e->row], fold, frame.view.camera, windows);
            for (std::uint32_t part = 0; part < wanted.parts(); ++part) {
                auto const to = wanted.tiles(part, 0, columns);
                for (std::uint32_t bit = 0; bit < 32; ++bit) {
                    if ((to >> bit & 1u) == 0) continue;
                    auto const t = (wanted.first(part).y() + bit % 8) * columns + wanted.first(part).x() + bit / 8;
                    if (e->key < from[t]) continue;
                    if (room[t] == 0) hi = e->key.depth;
                    else --room[t];
                }
            }
        }
        // More splats than a tile holds at one depth: they take several rounds.
        if (hi <= last_depth) hi = last_depth + 1;
        for (std::uint32_t t = 0; t < tiles; ++t) {
            auto& w = mesh.state<homes::Window>(tilemesh::TileId::at(t % columns, t / columns));
            if (!w.done()) w.hi_depth = w.frontier_depth = hi;
        }
    }

    std::vector<Entry> entries_;
};

Setup choice_of(HomesSetting const& setting)
{
    auto choice = tilemesh::splat::homes_setup;
    choice.machine.sram_bytes = 1u << 30; // rows say what fits
    choice.rules = setting.rules;
    if (setting.homes != 0) choice.sizes.homes = setting.homes;
    if (setting.held != 0) choice.sizes.storage = setting.held;
    if (setting.slots != 0) choice.sizes.road = choice.sizes.waiting = setting.slots;
    return choice;
}

class OverRenderer final : public HomesMachine {
public:
    OverRenderer(tilemesh::scene::Map const& map, HomesSetting const& setting, Setup const& choice)
        : setting_(setting), renderer_(map, choice, options_of(setting))
    {
        setting_.homes = choice.sizes.homes;
        setting_.held = choice.sizes.storage;
        setting_.slots = choice.sizes.road;
        if (setting.one_cut) renderer_.observe([this](tilemesh::SuperstepEvent const& event) { one_cut_(renderer_, event); });
    }
    void render(tilemesh::splat::Camera const& camera) override { renderer_.render_into(camera, frame_); }
    tilemesh::report::Image const& image() const override { return frame_.image; }
    tilemesh::report::FrameReport const& report() const override { return frame_.report; }
    tilemesh::Trace const& trace() const override { return renderer_.trace(); }
    HomesSetting const& setting() const override { return setting_; }
    std::uint64_t sram_bytes() const override { return tilemesh::render::sram_bytes_of(renderer_.setup()); }

private:
    static tilemesh::RendererOptions options_of(HomesSetting const& setting)
    {
        tilemesh::RendererOptions options;
        options.threads = setting.threads;
        options.grid = {setting.grid.width, setting.grid.height};
        options.fold = setting.folded;
        return options;
    }

    HomesSetting setting_;
    Renderer renderer_;
    OneCut one_cut_;
    tilemesh::RenderedFrame frame_;
};

} // namespace

std::unique_ptr<HomesMachine> make_homes_machine(tilemesh::scene::Map const& map, HomesSetting const& setting)
{
    return std::make_unique<OverRenderer>(map, setting, choice_of(setting));
}

std::uint32_t most_held(std::uint64_t records, std::uint32_t slots, tilemesh::Grid grid, std::uint32_t width, std::uint32_t height)
{
    auto choice = tilemesh::splat::homes_setup;
    choice.fit = true; // as many homes as there are records
    choice.sizes.storage = 1;
    choice.sizes.road = choice.sizes.waiting = slots;
    choice.machine.sram_bytes = 1u << 30;
    tilemesh::RendererOptions options;
    options.grid = {grid.width, grid.height};
    auto const layout = tilemesh::render::layout_homes(choice, options, {width, height}, records);
    auto two = layout.setup;
    two.sizes.storage = 2;
    auto const one = tilemesh::render::sram_bytes_of(layout.setup), each = tilemesh::render::sram_bytes_of(two) - one;
    auto const most = std::uint64_t{tilemesh::Mk2::sram_bytes} + each; // a tile of K splats has one + (K - 1) * each bytes
    return most < one + each ? 0 : static_cast<std::uint32_t>((most - one) / each);
}

} // namespace bench
